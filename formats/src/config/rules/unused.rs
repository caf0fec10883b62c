//! Rules against knobs without effect. A knob that a configuration does not use must have its
//! default, as a user who sets it expects an effect.

use super::listed;
use crate::config::{Config, ExpConfig, ExpForm, GuConfig, Modes, Organisation, RuleBreaches};

pub(super) fn unused(config: &Config, out: &mut RuleBreaches) {
    let (gu, exp) = (&config.gu, &config.vu.exp);
    let plain = GuConfig::default();
    out.require(
        config.organisation().0 == Organisation::FeatureMajor || gu.lanes == plain.lanes,
        "unused-lanes",
        "gu.lanes",
        gu.lanes,
        "left out: lanes are of gu.organisation = \"feature-major\"",
    );
    out.require(
        gu.modes != Modes::Unstructured || gu.vertices == plain.vertices,
        "unused-vertices",
        "gu.vertices",
        listed(&gu.vertices),
        "left out: gu.modes = \"unstructured\" has no entries of several vertices",
    );
    let plain = ExpConfig::default();
    let is_piecewise = exp.form == ExpForm::Piecewise;
    out.require(
        is_piecewise || exp.pieces == plain.pieces,
        "unused-pieces",
        "vu.exp.pieces",
        exp.pieces,
        "left out: pieces are of vu.exp.form = \"piecewise\"",
    );
    out.require(
        !is_piecewise || exp.iterations == plain.iterations,
        "unused-iterations",
        "vu.exp.iterations",
        exp.iterations,
        "left out: vu.exp.form = \"piecewise\" takes no iterations",
    );
}
