//! Rules of the splat unit.

use crate::config::{Config, ExpBase, ExpOutput, RuleBreaches, SplatOpacity};
use crate::record::LOG_OPACITY;

/// Fraction bits of an alpha.
const ALPHA_BITS: u32 = 16;
/// Integer bits of a power: from 8 on nothing counts.
const POWER_INTEGER_BITS: u32 = 3;
/// Fraction bits that the search for spans needs.
const SEARCH_BITS: u32 = 12;
/// Fraction bits of a power at most: a word of limits has 24 bits.
const MOST_BITS: u32 = 20;

pub(super) fn splats(config: &Config, out: &mut RuleBreaches) {
    let Some(su) = &config.su else {
        return;
    };
    out.range(
        "su-lanes",
        "su.lanes",
        su.lanes,
        1,
        64,
        "lanes side by side",
    );
    out.require(
        su.tiles.is_power_of_two() && (2..=1024).contains(&su.tiles),
        "su-tiles",
        "su.tiles",
        su.tiles,
        "a power of two from 2 to 1024: tiles whose pixels the unit holds",
    );
    out.range(
        "su-units",
        "su.units",
        su.units,
        1,
        64,
        "units side by side",
    );
    if su.pipelined {
        let exp = &config.vu.exp;
        out.require(
            !exp.early_out,
            "su-pipelined",
            "su.pipelined",
            true,
            "false, or vu.exp.early_out false: the stages of a pipeline come at fixed clocks",
        );
        out.require(
            !exp.pipelined,
            "unused-su-pipelined",
            "su.pipelined",
            true,
            "left out: vu.exp.pipelined is true, and holds for the splat unit too",
        );
    }
    let exp = &config.vu.exp;
    let fraction = exp.input.frac_bits();
    out.require(
        exp.base == ExpBase::E,
        "su-exp-base",
        "vu.exp.base",
        "two",
        "\"e\", or [su] left out: the splat unit computes exp(-u)",
    );
    out.require(
        exp.output == ExpOutput::Alpha,
        "su-exp-output",
        "vu.exp.output",
        "general",
        "\"alpha\", or [su] left out: the splat unit needs fractions in the formats of alphas",
    );
    out.require(
        exp.output_bits <= ALPHA_BITS,
        "su-exp-output-bits",
        "vu.exp.output_bits",
        exp.output_bits,
        "16 at most, or [su] left out: the opacity times it is an alpha of 16 bits",
    );
    out.require(
        !exp.input.is_signed()
            && exp.input.width() == fraction + POWER_INTEGER_BITS
            && (SEARCH_BITS..=MOST_BITS).contains(&fraction),
        "su-input",
        "vu.exp.input",
        exp.input,
        "U3.12 to U3.20, or [su] left out: the splat unit has powers up to 8, compared with 12 bits or more",
    );
    out.require(
        su.opacity == SplatOpacity::Multiplied || exp.input == LOG_OPACITY,
        "su-opacity",
        "vu.exp.input",
        exp.input,
        "U3.13 with su.opacity = \"in-power\": records hold the logarithm of the opacity in that format",
    );
}
