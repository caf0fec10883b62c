//! Rules of the reducers' output and of the bank organisations, beyond the common ones.

use super::{RuleBreaches, listed};
use crate::config::{Config, EntryKind, ExtraPorts, Modes, Organisation, Sums, WeightTrust};
use crate::rit::Vertices;

pub(super) fn organisation(config: &Config, out: &mut RuleBreaches) {
    let gu = &config.gu;
    out.require(
        gu.channels.is_none_or(|c| (1..=4096).contains(&c)),
        "gu-channels",
        "gu.channels",
        gu.channels.unwrap_or_default(),
        "1 to 4096: channels of a feature; or none, where the unit is for any",
    );
    let two = gu.records_a_row == 2;
    out.require(
        gu.records_a_row == 1
            || two
                && gu.modes != Modes::Structured
                && gu.banks.is_multiple_of(2)
                && config.mvoxel.rows <= 32_768,
        "gu-records",
        "gu.records_a_row",
        gu.records_a_row,
        "1; or 2 with single ids (gu.modes), an even number of banks, and at most 32768 rows",
    );
    let exact = gu.sums == Sums::Exact;
    out.require(
        !exact
            || gu.modes != Modes::Unstructured
                && gu.weights == WeightTrust::Trusted
                && config.rit.entry == EntryKind::Paper
                && !config.is_parity(),
        "gu-sums",
        "gu.sums",
        "exact",
        "\"rounded\"; or structured entries of the paper's kind with trusted weights, channel-major: \
         parts of a cell are weighted vertices, and their sum fits 32 bits",
    );
    if gu.extra_ports == ExtraPorts::Split {
        split(config, out);
    }
    match config.organisation().0 {
        Organisation::Auto | Organisation::ChannelMajor => {}
        Organisation::Parity => parity(config, out),
        Organisation::FeatureMajor => feature_major(config, out),
    }
}

/// Rules of split banks.
fn split(config: &Config, out: &mut RuleBreaches) {
    let ports = config.gu.ports;
    out.require(
        [4, 8].contains(&ports) && config.organisation().0 == Organisation::ChannelMajor,
        "split-ports",
        "gu.extra_ports",
        "split",
        "\"copies\"; or gu.ports 4 or 8, channel-major: a part for every two ports, named by the row's low bits",
    );
    let (rows, parts) = (config.mvoxel.rows, config.table_parts());
    out.require(
        rows.is_multiple_of(parts) && rows / parts >= 2,
        "split-rows",
        "mvoxel.rows",
        rows,
        format_args!("a multiple of gu.ports / 2 = {parts}, twice it or more: rows fill all parts of a bank alike"),
    );
}

fn parity(config: &Config, out: &mut RuleBreaches) {
    let gu = &config.gu;
    out.require(
        gu.banks.is_multiple_of(8),
        "parity-banks",
        "gu.banks",
        gu.banks,
        "a multiple of 8: one group of banks for each parity of x, y and z",
    );
    out.require(
        gu.modes == Modes::Structured,
        "parity-modes",
        "gu.modes",
        match gu.modes {
            Modes::Structured => "structured",
            Modes::Unstructured => "unstructured",
            Modes::Both => "both",
        },
        "\"structured\": the parity organisation reads the vertices of cells",
    );
    out.require(
        gu.vertices == [Vertices::Eight],
        "parity-vertices",
        "gu.vertices",
        listed(&gu.vertices),
        "[8]: a cell has a vertex in each of the eight groups of banks",
    );
    out.require(
        [8, 64, 512, 4096, 32_768].contains(&config.mvoxel.rows),
        "parity-rows",
        "mvoxel.rows",
        config.mvoxel.rows,
        "8, 64, 512, 4096 or 32768: a cube whose edge is a power of two, so that parities are bits of the row",
    );
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
        format_args!(
            "a multiple of gu.ports = {}, the number of lanes that are loaded together",
            gu.ports
        ),
    );
    let (rows, banks) = (config.mvoxel.rows, gu.banks.max(1));
    out.require(
        rows.is_multiple_of(banks) && rows / banks >= 2,
        "feature-major-rows",
        "mvoxel.rows",
        rows,
        format_args!(
            "a multiple of gu.banks = {banks}, twice it or more: rows fill all banks alike"
        ),
    );
    out.require(
        config.rit.entry == EntryKind::Paper
            && gu.sums == Sums::Rounded
            && gu.records_a_row == 1
            && !gu.pipelined,
        "feature-major-plain",
        "gu.organisation",
        "feature-major",
        "another; or rit.entry = \"paper\", gu.sums = \"rounded\", gu.records_a_row = 1 and gu.pipelined = false",
    );
}
