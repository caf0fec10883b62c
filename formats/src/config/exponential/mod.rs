//! The exponential engine: its knobs, and a file a form.
//!
//! `docs/adding/exponential.md` adds a form step by step.

mod engine;
mod form;
mod knobs;
mod literal;
mod piecewise;
mod radix4;
mod recurrence;
mod restoring;

use serde::{Deserialize, Serialize};

use super::breaches::RuleBreaches;
use crate::fixed::Format;
use crate::timing::{AGREEMENT, Passes, Pipeline, PowerStage};
use crate::units::OpCode;

pub use engine::Engine;
pub use form::Offers;
pub use knobs::{ExpBase, ExpConfig, ExpOutput};
pub use piecewise::PieceWidths;

use form::Form;

/// The forms: name in the code, name in a file, and where its own is.
macro_rules! registry {
    ($($form:ident, $name:literal, $own:expr;)*) => {
        /// How exponentials are found. The module of each form says how.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
        pub enum ExpForm {
            $(
                #[doc = concat!("`vu.exp.form = \"", $name, "\"`.")]
                #[serde(rename = $name)]
                $form,
            )*
        }

        impl ExpForm {
            /// All forms.
            pub const ALL: &[Self] = &[$(Self::$form),*];

            /// The name in a configuration.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$form => $name,)*
                }
            }

            fn own(self) -> &'static dyn Form {
                match self {
                    $(Self::$form => &$own,)*
                }
            }
        }
    };
}

registry! {
    Restoring, "restoring", restoring::Restoring;
    Literal, "literal", literal::Literal;
    Piecewise, "piecewise", piecewise::Piecewise;
    Radix4, "radix-4", radix4::Radix4;
}

impl ExpForm {
    /// What the form offers beyond `exp` of the alpha output.
    #[must_use]
    pub fn offers(self) -> Offers {
        self.own().offers()
    }

    /// The knobs of a plain engine of this form.
    #[must_use]
    pub fn plain(self) -> ExpConfig {
        let mut exp = ExpConfig {
            form: self,
            ..ExpConfig::default()
        };
        self.own().plain(&mut exp);
        exp
    }

    /// Least and most iterations, and why.
    pub(super) fn iterations(self) -> (u32, u32, &'static str) {
        self.own().iterations()
    }

    /// Whether an operand's format is right, and which are.
    pub(super) fn input(self, input: Format, output: ExpOutput) -> (bool, &'static str) {
        self.own().input(input, output)
    }
}

impl ExpConfig {
    /// Bits of the power that the iterations resolve: n, or two for every digit of radix 4.
    #[must_use]
    pub fn resolved_bits(&self) -> u32 {
        self.form.own().resolved_bits(self)
    }

    /// The engine that these knobs describe.
    #[must_use]
    pub fn engine(&self) -> Engine {
        self.form.own().engine(self)
    }

    /// What is done to a power, clock by clock: its clocks are the initiation interval of the
    /// iterative form, and its stages those of the pipelined one.
    #[must_use]
    pub fn power_pipeline(&self) -> Pipeline<PowerStage> {
        self.form.own().stages(self)
    }

    /// The same knobs, with the widths that they have in effect, and nothing said of what the form
    /// does not look at.
    #[must_use]
    pub fn in_effect(&self) -> Self {
        let engine = self.engine();
        let mut own = Self {
            accumulator_bits: Some(engine.accumulator_bits),
            constant_bits: Some(engine.constant_bits),
            offset: Some(engine.offset),
            ..self.clone()
        };
        self.form.own().forget(&mut own, &Self::default());
        own
    }

    /// The fewest fraction bits of the constants, and why.
    pub(super) fn least_constant_bits(&self) -> (u32, &'static str) {
        self.form.own().least_constant_bits(self)
    }

    /// The rules that the form has of its own.
    pub(super) fn rules_of_form(&self, out: &mut RuleBreaches) {
        self.form.own().rules(self, out);
    }

    /// Clocks from the acceptance of an exponential to the next one's: the initiation interval
    /// of the iterative form, and the stages of the pipelined one.
    #[must_use]
    pub fn interval(&self) -> u32 {
        self.power_pipeline().cycles()
    }

    /// The passes of an operation through the iterative engine.
    #[must_use]
    pub fn passes(&self, op: OpCode) -> Passes {
        Passes::of(op, &self.power_pipeline())
    }

    /// Clocks from the acceptance of an exponential whose result is
    /// `mantissa 2^-k` to the next one's: the interval, or fewer with an early
    /// out.
    #[must_use]
    pub fn clocks_of(&self, k: u32) -> u32 {
        let interval = self.interval();
        if !self.early_out {
            return interval;
        }
        let wanted = (self.output_bits + 2).saturating_sub(k);
        let steps = self.engine().digits + wanted.min(self.iterations);
        let clocks = steps.div_ceil(self.iterations_per_clock.max(1));
        clocks.max(self.earliest_out()).min(interval)
    }

    /// Clocks after which the exponent's digits are complete.
    #[must_use]
    pub fn digit_clocks(&self) -> u32 {
        let digits = self.engine().digits;
        digits.div_ceil(self.iterations_per_clock.max(1))
    }

    /// The fewest clocks that an early out can take.
    #[must_use]
    pub fn earliest_out(&self) -> u32 {
        self.digit_clocks() + AGREEMENT
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::{Config, rules};

    #[test]
    fn plain_engines_keep_the_rules_and_every_form_has_a_name() {
        for form in ExpForm::ALL {
            let mut config = Config::default();
            config.vu.ops = vec![OpCode::Exp];
            config.vu.exp = form.plain();
            let breaches = rules::check(&config);
            assert!(breaches.is_empty(), "{form:?}: {breaches}");
            let text = toml::to_string(&config).unwrap();
            assert!(
                text.contains(&format!("form = \"{}\"", form.name())),
                "{text}"
            );
            assert_eq!(toml::from_str::<Config>(&text).unwrap(), config);
        }
    }
}
