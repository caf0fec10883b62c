//! Effects that are forced or left out, whatever a scene needs.

use thiserror::Error;

use super::Effect;

/// Effects that are forced although nothing needs them, and effects that are left out although
/// something does. By default neither.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize)]
pub struct Choices {
    forced: u32,
    left_out: u32,
}

/// A text that does not name an effect.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("effect `{0}`: expected all, or some of {known}", known = known())]
pub struct UnknownEffect(String);

fn known() -> String {
    Effect::ALL.map(|effect| effect.to_string()).join(", ")
}

impl Choices {
    /// Forces every effect.
    #[must_use]
    pub fn all() -> Self {
        Effect::ALL.into_iter().fold(Self::default(), Self::force)
    }

    /// The effects of a name: `all`, a single effect, or spherical harmonics of every degree.
    ///
    /// # Errors
    /// The name is unknown.
    pub fn named(name: &str) -> Result<Vec<Effect>, UnknownEffect> {
        let is_meant =
            |effect: &Effect| name == "all" || name == effect.name() || name == effect.to_string();
        let found: Vec<Effect> = Effect::ALL.into_iter().filter(is_meant).collect();
        match found.is_empty() {
            true => Err(UnknownEffect(name.to_owned())),
            false => Ok(found),
        }
    }

    /// Forces an effect.
    #[must_use]
    pub fn force(self, effect: Effect) -> Self {
        Self {
            forced: self.forced | effect.bit(),
            ..self
        }
    }

    /// Leaves out an effect.
    #[must_use]
    pub fn leave_out(self, effect: Effect) -> Self {
        Self {
            left_out: self.left_out | effect.bit(),
            ..self
        }
    }

    /// Whether an effect is forced.
    #[must_use]
    pub fn forces(self, effect: Effect) -> bool {
        self.forced & effect.bit() != 0 && !self.leaves_out(effect)
    }

    /// Whether an effect is left out.
    #[must_use]
    pub fn leaves_out(self, effect: Effect) -> bool {
        self.left_out & effect.bit() != 0
    }

    /// All effects that are left out.
    #[must_use]
    pub fn left_out(self) -> Vec<Effect> {
        let own = Effect::ALL.into_iter();
        own.filter(|effect| self.leaves_out(*effect)).collect()
    }

    /// Whether an effect is carried out, given whether it is needed.
    #[must_use]
    pub fn carries_out(self, effect: Effect, is_called_for: bool) -> bool {
        !self.leaves_out(effect) && (is_called_for || self.forces(effect))
    }

    /// The highest degree of spherical harmonics that is evaluated, if `stored` degrees are stored
    /// and those up to `highest` are needed. Leaving out a degree also leaves out the higher ones.
    #[must_use]
    pub fn harmonics(self, stored: usize, highest: usize) -> usize {
        let is_carried = |degree: &usize| {
            let effect = Effect::SphericalHarmonics(*degree as u8);
            self.carries_out(effect, *degree <= highest)
        };
        (1..=stored).take_while(is_carried).last().unwrap_or(0)
    }
}
