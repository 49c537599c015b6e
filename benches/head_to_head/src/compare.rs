//! Two sides, one after the other, over and over.

use std::time::{Duration, Instant};

/// Times `ours` and `peer` in turn on each of `0..rounds`, after a warm-up of a tenth of them, and prints the ratio of
/// the medians. Which side begins alternates, so that neither always finds the caches warm.
///
/// Says on how many rounds the two sides do not agree, by `agree`, if there are any: rays that graze an edge are
/// decided by rounding.
///
/// # Panics
///
/// If they do not agree on more than one round in a hundred.
pub(crate) fn compare<S, A, B>(
    case: &str,
    peer_name: &str,
    rounds: usize,
    state: &mut S,
    mut ours: impl FnMut(&mut S, usize) -> (Duration, A),
    mut peer: impl FnMut(&mut S, usize) -> (Duration, B),
    agree: impl Fn(&A, &B) -> bool,
) where
    A: std::fmt::Debug,
    B: std::fmt::Debug,
{
    let warm_up = rounds.div_ceil(10);
    let mut disagreements = 0;
    let (mut our_times, mut peer_times) = (Vec::with_capacity(rounds), Vec::with_capacity(rounds));
    for round in 0..warm_up + rounds {
        let index = round % rounds;
        let ((our_time, our_answer), (peer_time, peer_answer)) = if round % 2 == 0 {
            let ours = ours(state, index);
            (ours, peer(state, index))
        } else {
            let peer = peer(state, index);
            (ours(state, index), peer)
        };
        if !agree(&our_answer, &peer_answer) {
            disagreements += 1;
            assert!(
                disagreements * 100 <= rounds,
                "{case}, round {index}: ours is {our_answer:?}, and that of {peer_name} is {peer_answer:?}"
            );
        }
        if round >= warm_up {
            our_times.push(our_time);
            peer_times.push(peer_time);
        }
    }
    if disagreements > 0 {
        println!(
            "# {case}: the answers differ in {disagreements} of {} rounds",
            warm_up + rounds
        );
    }
    let (ours, peer) = (median_ns(our_times), median_ns(peer_times));
    println!(
        "RATIO\t{case}\t{ours}\t{peer}\t{:.2}\t{peer_name}",
        peer as f64 / ours as f64
    );
}

/// The time that `work` takes, and what it gives.
pub(crate) fn time<R>(work: impl FnOnce() -> R) -> (Duration, R) {
    let start = Instant::now();
    let result = work();
    (start.elapsed(), result)
}

fn median_ns(mut times: Vec<Duration>) -> u128 {
    times.sort_unstable();
    times[times.len() / 2].as_nanos()
}
