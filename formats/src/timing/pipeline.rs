//! Stages in order.

/// The stages that something passes, one a cycle unless it is held up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pipeline<S> {
    stages: Vec<S>,
}

impl<S: Copy + PartialEq> Pipeline<S> {
    /// These stages, in this order.
    #[must_use]
    pub fn new(stages: impl IntoIterator<Item = S>) -> Self {
        Self {
            stages: stages.into_iter().collect(),
        }
    }

    /// Those of these stages that are built, in this order.
    #[must_use]
    pub fn built<const N: usize>(stages: [(S, bool); N]) -> Self {
        let built = stages.into_iter().filter(|(_, built)| *built);
        Self::new(built.map(|(stage, _)| stage))
    }

    /// The stages, first to last.
    pub fn stages(&self) -> impl DoubleEndedIterator<Item = S> + ExactSizeIterator + '_ {
        self.stages.iter().copied()
    }

    /// Cycles from what enters the first stage to what the last one holds.
    #[must_use]
    pub fn cycles(&self) -> u32 {
        self.stages.len() as u32
    }

    /// Whether a stage is built.
    #[must_use]
    pub fn has(&self, stage: S) -> bool {
        self.stages.contains(&stage)
    }

    /// The cycle in which a stage holds what entered in cycle 0; `None` where it is not built.
    #[must_use]
    pub fn cycle(&self, stage: S) -> Option<u32> {
        let at = self.stages.iter().position(|s| *s == stage)?;
        Some(at as u32 + 1)
    }

    /// The stage before another one; `None` of the first, and of one that is not built.
    #[must_use]
    pub fn before(&self, stage: S) -> Option<S> {
        let at = self.stages.iter().position(|s| *s == stage)?;
        self.stages.get(at.checked_sub(1)?).copied()
    }

    /// The first stage of these that is built.
    #[must_use]
    pub fn first_of<const N: usize>(&self, stages: [S; N]) -> Option<S> {
        stages.into_iter().find(|stage| self.has(*stage))
    }
}
