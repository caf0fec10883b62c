//! The exponential engine: its knobs, and one file for each form.
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

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::breaches::RuleBreaches;
use crate::fixed::Format;
use crate::timing::{AGREEMENT, Pipeline, PowerStage};

pub use engine::Engine;
pub use form::Offers;
pub use knobs::{ExpBase, ExpConfig, ExpOutput};
pub use piecewise::PieceWidths;

use form::Form;

/// The forms: name in the code, name in a file, and module.
macro_rules! registry {
    ($($form:ident, $name:literal, $own:expr;)*) => {
        /// Algorithm of exponentials, documented in the module of each form.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
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
    /// Optional features, beyond `exp` with the alpha output.
    #[must_use]
    pub fn offers(self) -> Offers {
        self.own().offers()
    }

    /// Knobs of this form's plain engine.
    #[must_use]
    pub fn plain(self) -> ExpConfig {
        let mut exp = ExpConfig {
            form: self,
            ..ExpConfig::default()
        };
        self.own().plain(&mut exp);
        exp
    }

    /// Smallest and largest number of iterations, and the reason.
    pub(super) fn iterations(self) -> (u32, u32, &'static str) {
        self.own().iterations()
    }

    /// Whether an operand format is allowed, and the allowed ones.
    pub(super) fn input(self, input: Format, output: ExpOutput) -> (bool, &'static str) {
        self.own().input(input, output)
    }
}

impl ExpConfig {
    /// Bits of the power that the iterations resolve: n, or two for each radix-4 digit.
    #[must_use]
    pub fn resolved_bits(&self) -> u32 {
        self.form.own().resolved_bits(self)
    }

    /// The engine's widths for these knobs.
    #[must_use]
    pub fn engine(&self) -> Engine {
        self.form.own().engine(self)
    }

    /// Pipeline of a power, clock by clock. Its length is the initiation interval of the iterative
    /// engine and the number of stages of the pipelined one.
    #[must_use]
    pub fn power_pipeline(&self) -> Pipeline<PowerStage> {
        self.form.own().stages(self)
    }

    /// The knobs with their effective widths, and defaults where the form does not use them.
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

    /// Smallest number of fraction bits of the constants, and the reason.
    pub(super) fn least_constant_bits(&self) -> (u32, &'static str) {
        self.form.own().least_constant_bits(self)
    }

    /// Checks the form's own rules.
    pub(super) fn rules_of_form(&self, out: &mut RuleBreaches) {
        self.form.own().rules(self, out);
    }

    /// Clocks from accepting an exponential to accepting the next: the initiation interval of the
    /// iterative engine. In the pipelined one, the number of stages.
    #[must_use]
    pub fn interval(&self) -> u32 {
        self.power_pipeline().cycles()
    }

    /// Clocks from accepting an exponential with the result `mantissa 2^-k` to accepting the next:
    /// the interval, or fewer with early termination.
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

    /// Clocks until the exponent's digits are complete.
    #[must_use]
    pub fn digit_clocks(&self) -> u32 {
        let digits = self.engine().digits;
        digits.div_ceil(self.iterations_per_clock.max(1))
    }

    /// Smallest number of clocks with early termination.
    #[must_use]
    pub(crate) fn earliest_out(&self) -> u32 {
        self.digit_clocks() + AGREEMENT
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::config::{Config, rules};
    use crate::units::OpCode;

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
