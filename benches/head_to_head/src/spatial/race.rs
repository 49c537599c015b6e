//! Ours against all peers that can do the same, in one run.

use std::time::{Duration, Instant};

use crate::compare::median_ns;

/// Answers a turn of queries: all of the slice.
type Answer<'a, Q, A> = Box<dyn FnMut(&[Q], &mut Vec<A>) + 'a>;

/// One that runs: its name, and how it answers.
pub(crate) struct Side<'a, Q, A> {
    name: &'static str,
    answer: Answer<'a, Q, A>,
}

impl<'a, Q, A> Side<'a, Q, A> {
    pub fn new(name: &'static str, mut answer: impl FnMut(&Q) -> A + 'a) -> Self {
        Self::of_turns(name, move |queries, answers| {
            answers.extend(queries.iter().map(&mut answer));
        })
    }

    /// One that answers a turn at once.
    pub fn of_turns(name: &'static str, answer: impl FnMut(&[Q], &mut Vec<A>) + 'a) -> Self {
        Self {
            name,
            answer: Box::new(answer),
        }
    }
}

/// Prints the ratio of our median to that of the best of the others, and below it what all took. See [`measure`].
pub(crate) fn race<Q, A>(
    case: &str,
    turn: usize,
    queries: &[Q],
    sides: &mut [Side<Q, A>],
    same: impl Fn(&A, &A) -> bool,
) {
    report(case, measure(case, turn, queries, sides, same));
}

/// Lets the sides answer the queries, a turn at a time, one after the other, and gives the median of the time that each
/// took for a query, in nanoseconds.
///
/// Each turn another one begins. Before its time starts, each answers the queries of the next turn, so that its caches are
/// not those that the others have left; what takes a turn for itself does without.
///
/// # Panics
///
/// If more than one answer in a hundred is not the `same` as that of the first, which is ours: queries that graze a box
/// are decided by rounding.
pub(crate) fn measure<Q, A>(
    case: &str,
    turn: usize,
    queries: &[Q],
    sides: &mut [Side<Q, A>],
    same: impl Fn(&A, &A) -> bool,
) -> Vec<(&'static str, f64)> {
    let turns: Vec<&[Q]> = queries.chunks_exact(turn).collect();
    let warm_up = turns.len().div_ceil(10);
    let mut times = vec![Vec::with_capacity(turns.len()); sides.len()];
    let mut answers: Vec<Vec<A>> = sides.iter().map(|_| Vec::with_capacity(turn)).collect();
    let mut different = vec![0; sides.len()];
    for round in 0..warm_up + turns.len() {
        let queries = turns[round % turns.len()];
        let before = if turn == 1 {
            &[]
        } else {
            turns[(round + 1) % turns.len()]
        };
        let number = sides.len();
        for side in (0..number).map(|side| (side + round) % number) {
            (sides[side].answer)(before, &mut answers[side]);
            answers[side].clear();
            let start = Instant::now();
            (sides[side].answer)(queries, &mut answers[side]);
            if round >= warm_up {
                times[side].push(start.elapsed());
            }
        }
        let (ours, theirs) = answers.split_first().expect("ours comes first");
        for (different, theirs) in different[1..].iter_mut().zip(theirs) {
            *different += ours.iter().zip(theirs).filter(|(a, b)| !same(a, b)).count();
        }
    }
    let all = (warm_up + turns.len()) * turn;
    for (side, different) in sides.iter().zip(different) {
        if different > 0 {
            println!(
                "# {case}: {different} of {all} answers differ from those of {}",
                side.name
            );
        }
        assert!(different * 100 <= all, "{case}: too many answers differ");
    }
    let per_query = |times: Vec<Duration>| median_ns(times) as f64 / turn as f64;
    let names = sides.iter().map(|side| side.name);
    names.zip(times.into_iter().map(per_query)).collect()
}

/// Prints the ratio to the best of the others, and below it all figures. Ours come first.
pub(crate) fn report(case: &str, figures: Vec<(&'static str, f64)>) {
    let (ours, peers) = (figures[0].1, &figures[1..]);
    let Some((name, best)) = peers.iter().min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return;
    };
    println!("RATIO\t{case}\t{ours:.0}\t{best:.0}\t{:.2}\t{name}", best / ours);
    if peers.len() > 1 {
        let all: Vec<String> = peers
            .iter()
            .map(|(name, figure)| format!("{figure:.0} {name}"))
            .collect();
        println!("#\t{case}\t{}", all.join(", "));
    }
}
