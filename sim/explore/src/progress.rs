//! How far a study has come.

/// Takes note of how far work has come, for whoever shows it. `()` takes no note.
pub trait Progress: Sync {
    /// So many further steps are to be done.
    fn expect(&self, steps: u64);

    /// So many steps are done.
    fn advance(&self, steps: u64);

    /// What is being done, in a few words.
    fn now(&self, what: &str);
}

impl Progress for () {
    fn expect(&self, _: u64) {}

    fn advance(&self, _: u64) {}

    fn now(&self, _: &str) {}
}
