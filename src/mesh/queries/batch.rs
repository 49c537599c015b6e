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
    /// Many rays are shared out among the threads of `pool`, or, if none is given, of the [`ComputeTaskPool`], if there is
    /// one. The answers are the same.
    pub fn closest_hits(
        &self,
        rays: &[Ray],
        backfaces: Backfaces,
        pool: Option<&TaskPool>,
        hits: &mut Vec<Option<TriangleHit>>,
    ) {
        answer_all(rays, pool, hits, None, |ray| self.closest_hit(ray, backfaces));
    }

    /// Of every ray whether there is [`any_hit`](Self::any_hit), written over `hits` in the order of the rays.
    ///
    /// On the threads that [`closest_hits`](Self::closest_hits) takes.
    pub fn any_hits(&self, rays: &[Ray], backfaces: Backfaces, pool: Option<&TaskPool>, hits: &mut Vec<bool>) {
        answer_all(rays, pool, hits, false, |ray| self.any_hit(ray, backfaces));
    }
}

/// Writes the answer for every ray over `answers`; `blank` holds the place of those that are not known yet.
fn answer_all<T: Clone + Send>(
    rays: &[Ray],
    pool: Option<&TaskPool>,
    answers: &mut Vec<T>,
    blank: T,
    answer: impl Fn(&Ray) -> T + Sync,
) {
    answers.clear();
    let shared = pool.or_else(|| ComputeTaskPool::try_get().map(|pool| &**pool));
    let shared = shared.filter(|pool| rays.len() >= 2 * RAYS_PER_TASK && pool.thread_num() > 1);
    let Some(pool) = shared else {
        answers.extend(rays.iter().map(answer));
        return;
    };
    answers.resize(rays.len(), blank);
    let share = rays
        .len()
        .div_ceil(pool.thread_num() * TASKS_PER_THREAD)
        .max(RAYS_PER_TASK);
    let answer = &answer;
    pool.scope(|scope| {
        for (rays, answers) in rays.chunks(share).zip(answers.chunks_mut(share)) {
            scope.spawn(async move {
                for (ray, place) in rays.iter().zip(answers) {
                    *place = answer(ray);
                }
            });
        }
    });
}
