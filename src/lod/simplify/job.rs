//! What is made in the background.

use std::sync::Arc;

use bevy::tasks::{AsyncComputeTaskPool, Task, TaskPool, futures::check_ready};

use crate::spatial::BuildProgress;

/// Something that is being made on the pool; called off when it is dropped.
#[derive(Debug)]
pub(super) struct Job<T> {
    task: Task<Option<T>>,
    progress: Arc<BuildProgress>,
}

impl<T: Send + 'static> Job<T> {
    /// Begins with `make`, which returns nothing only if it is called off.
    pub fn start(make: impl FnOnce(&BuildProgress) -> Option<T> + Send + 'static) -> Self {
        let progress = Arc::new(BuildProgress::default());
        let task = AsyncComputeTaskPool::get_or_init(TaskPool::default).spawn({
            let progress = Arc::clone(&progress);
            async move { make(&progress) }
        });
        Self { task, progress }
    }

    /// What was made, once it is there.
    pub fn take_made(&mut self) -> Option<T> {
        check_ready(&mut self.task).map(|made| made.expect("only what is dropped is called off"))
    }
}

impl<T> Job<T> {
    /// How much is done, from 0 to 1.
    pub fn fraction(&self) -> f32 {
        self.progress.fraction()
    }
}

/// Dropping the task ends one that has not begun; one that runs has to be told.
impl<T> Drop for Job<T> {
    fn drop(&mut self) {
        self.progress.cancel();
    }
}

/// How many jobs run at a time: what they work on is copied when they begin.
pub(super) fn most_jobs() -> usize {
    AsyncComputeTaskPool::get_or_init(TaskPool::default).thread_num() + 1
}
