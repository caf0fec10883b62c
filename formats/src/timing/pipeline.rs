//! Pipelines: ordered stages.

/// Pipeline stages, each of one cycle unless stalled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pipeline<S> {
    stages: Vec<S>,
}

impl<S: Copy + PartialEq> Pipeline<S> {
    /// A pipeline of these stages, in order.
    #[must_use]
    pub fn new(stages: impl IntoIterator<Item = S>) -> Self {
        Self {
            stages: stages.into_iter().collect(),
        }
    }

    /// A pipeline of those stages that are built, in order.
    #[must_use]
    pub fn built<const N: usize>(stages: [(S, bool); N]) -> Self {
        let built = stages.into_iter().filter(|(_, built)| *built);
        Self::new(built.map(|(stage, _)| stage))
    }

    /// The stages, first to last.
    pub fn stages(&self) -> impl DoubleEndedIterator<Item = S> + ExactSizeIterator + '_ {
        self.stages.iter().copied()
    }

    /// Cycles from entering the first stage to leaving the last: the number of stages.
    #[must_use]
    pub fn cycles(&self) -> u32 {
        self.stages.len() as u32
    }

    /// Whether a stage is built.
    #[must_use]
    pub fn has(&self, stage: S) -> bool {
        self.stages.contains(&stage)
    }

    /// Cycle in which a stage holds a value that entered in cycle 0; `None` where it is not built.
    #[must_use]
    pub fn cycle(&self, stage: S) -> Option<u32> {
        let at = self.stages.iter().position(|s| *s == stage)?;
        Some(at as u32 + 1)
    }

    /// The stage before another one; `None` for the first, and for one that is not built.
    #[must_use]
    pub fn before(&self, stage: S) -> Option<S> {
        let at = self.stages.iter().position(|s| *s == stage)?;
        self.stages.get(at.checked_sub(1)?).copied()
    }
}
