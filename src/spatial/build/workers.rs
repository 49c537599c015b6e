//! Who does the work of a build.

/// A piece of work that needs no other.
pub(crate) type Errand<'a> = Box<dyn FnOnce() + Send + 'a>;

/// Who does pieces of work, perhaps at the same time.
pub(crate) trait Workers: Sync {
    /// How many there are.
    fn count(&self) -> usize;

    /// Does all of the work, and returns when it is done.
    fn run(&self, errands: Vec<Errand<'_>>);
}

/// The calling thread.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Alone;

impl Workers for Alone {
    fn count(&self) -> usize {
        1
    }

    fn run(&self, errands: Vec<Errand<'_>>) {
        errands.into_iter().for_each(|errand| errand());
    }
}
