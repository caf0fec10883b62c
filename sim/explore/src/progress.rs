//! Progress of a study.

/// Receives the progress of a study. `()` ignores it.
pub trait Progress: Sync {
    /// Announces further steps.
    fn expect(&self, steps: u64);

    /// Reports completed steps.
    fn advance(&self, steps: u64);

    /// Reports steps that needed no work, such as those that an earlier run did: they say nothing of the time
    /// that others take.
    fn pass_over(&self, steps: u64) {
        self.advance(steps);
    }

    /// Names the current activity in a few words.
    fn now(&self, what: &str);
}

impl Progress for () {
    fn expect(&self, _: u64) {}

    fn advance(&self, _: u64) {}

    fn now(&self, _: &str) {}
}
