//! Progress of a study.

/// Receives the progress of a study. `()` ignores it.
pub trait Progress: Sync {
    /// Announces further steps.
    fn expect(&self, steps: u64);

    /// Reports completed steps.
    fn advance(&self, steps: u64);

    /// Names the current activity in a few words.
    fn now(&self, what: &str);
}

impl Progress for () {
    fn expect(&self, _: u64) {}

    fn advance(&self, _: u64) {}

    fn now(&self, _: &str) {}
}
