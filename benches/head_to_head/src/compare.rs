//! Two sides, one after the other, over and over.

use std::time::{Duration, Instant};

/// Times `ours` and `peer` in turn on each of `0..rounds`, after a warm-up of a tenth of them, and prints the ratio of
/// the medians. Which side begins alternates.
///
/// `differences` tells how many of how many answers differ, and the total is printed if there are any: rays that graze
/// an edge are decided by rounding.
///
/// # Panics
///
/// If more than one answer in a hundred differs.
pub(crate) fn compare<S, A>(
    case: &str,
    peer_name: &str,
    rounds: usize,
    state: &mut S,
    ours: impl Fn(&mut S, usize) -> (Duration, A),
    peer: impl Fn(&mut S, usize) -> (Duration, A),
    differences: impl Fn(&A, &A) -> (usize, usize),
) {
    let warm_up = rounds.div_ceil(10);
    let (mut different, mut all) = (0, 0);
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
        let (differ, of) = differences(&our_answer, &peer_answer);
        different += differ;
        all += of;
        if round >= warm_up {
            our_times.push(our_time);
            peer_times.push(peer_time);
        }
    }
    if different > 0 {
        println!("# {case}: {different} of {all} answers differ from those of {peer_name}");
    }
    assert!(different * 100 <= all, "{case}: too many answers differ");
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

/// The upper median, in nanoseconds.
pub(crate) fn median_ns(mut times: Vec<Duration>) -> u128 {
    times.sort_unstable();
    times[times.len() / 2].as_nanos()
}
