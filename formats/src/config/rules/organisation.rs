//! What the organisations of the banks ask for beyond the common rules.

use super::RuleBreaches;
use crate::config::{Config, Organisation};

pub(super) fn organisation(config: &Config, out: &mut RuleBreaches) {
    match config.gu.organisation {
        Organisation::ChannelMajor => {}
        Organisation::FeatureMajor => feature_major(config, out),
    }
}

fn feature_major(config: &Config, out: &mut RuleBreaches) {
    let gu = &config.gu;
    out.require(
        (2..=64).contains(&gu.banks) && gu.banks.is_power_of_two(),
        "feature-major-banks",
        "gu.banks",
        gu.banks,
        "2, 4, 8, 16, 32 or 64: a row's low bits name its bank",
    );
    out.range(
        "feature-major-lanes",
        "gu.lanes",
        gu.lanes,
        1,
        64,
        "ray samples processed side by side",
    );
    out.require(
        gu.lanes.is_multiple_of(gu.ports.max(1)),
        "feature-major-lane-groups",
        "gu.lanes",
        gu.lanes,
        format!(
            "a multiple of gu.ports = {}: so many lanes are loaded together",
            gu.ports
        ),
    );
    out.require(
        gu.fifo_depth > 4,
        "feature-major-fifo-depth",
        "gu.fifo_depth",
        gu.fifo_depth,
        "5 or more: fewer beats stall single-id entries even with a ready sink",
    );
    let (rows, banks) = (config.mvoxel.rows, gu.banks.max(1));
    out.require(
        rows.is_multiple_of(banks) && rows / banks >= 2,
        "feature-major-rows",
        "mvoxel.rows",
        rows,
        format!("a multiple of gu.banks = {banks}, twice it or more: rows fill all banks alike"),
    );
}
