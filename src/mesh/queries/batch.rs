//! Many rays at once.

use bevy::tasks::{ComputeTaskPool, TaskPool};

use crate::{
    geometry::ray::{Ray, triangle::Backfaces},
    mesh::{MeshBvh, TriangleHit},
};

/// The fewest rays that are worth a task of their own: some hundred microseconds, against the few that a task costs.
const RAYS_PER_TASK: usize = 256;

/// So many tasks for each thread even out rays that take longer than others.
const TASKS_PER_THREAD: usize = 4;

impl MeshBvh {
    /// The [`closest_hit`](Self::closest_hit) of every ray, written over `hits` in the order of the rays.
    ///
    /// Rays that follow each other and run much the same way are taken through the hierarchy together, which takes half
    /// the time: those of a picture in rows or in tiles, those to one light, those of a scanner. Many rays are shared out
    /// among the threads of `pool`, or, if none is given, of the [`ComputeTaskPool`], if there is one. The answers are the
    /// same.
    pub fn closest_hits(
        &self,
        rays: &[Ray],
        backfaces: Backfaces,
        pool: Option<&TaskPool>,
        hits: &mut Vec<Option<TriangleHit>>,
    ) {
        let answer = |rays: &[Ray], hits: &mut [_]| self.closest_hits_of(rays, backfaces, hits);
        answer_all(rays, pool, hits, None, answer);
    }

    /// Of every ray whether there is [`any_hit`](Self::any_hit), written over `hits` in the order of the rays.
    ///
    /// Together and on the threads as [`closest_hits`](Self::closest_hits) does.
    pub fn any_hits(&self, rays: &[Ray], backfaces: Backfaces, pool: Option<&TaskPool>, hits: &mut Vec<bool>) {
        let answer = |rays: &[Ray], hits: &mut [_]| self.any_hits_of(rays, backfaces, hits);
        answer_all(rays, pool, hits, false, answer);
    }
}

/// Writes the answer for every ray over `answers`, which `answer` does for some; `blank` holds the place of those that are
/// not known yet.
fn answer_all<T: Clone + Send>(
    rays: &[Ray],
    pool: Option<&TaskPool>,
    answers: &mut Vec<T>,
    blank: T,
    answer: impl Fn(&[Ray], &mut [T]) + Sync,
) {
    answers.clear();
    answers.resize(rays.len(), blank);
    let shared = pool.or_else(|| ComputeTaskPool::try_get().map(|pool| &**pool));
    let shared = shared.filter(|pool| rays.len() >= 2 * RAYS_PER_TASK && pool.thread_num() > 1);
    let Some(pool) = shared else {
        answer(rays, answers);
        return;
    };
    let share = rays
        .len()
        .div_ceil(pool.thread_num() * TASKS_PER_THREAD)
        .max(RAYS_PER_TASK);
    let answer = &answer;
    pool.scope(|scope| {
        for (rays, answers) in rays.chunks(share).zip(answers.chunks_mut(share)) {
            scope.spawn(async move { answer(rays, answers) });
        }
    });
}
