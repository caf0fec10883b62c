//! Named rules of a configuration.

use super::breaches::RuleBreaches;
use super::{Config, EntryKind, Modes};
use crate::rit::Vertices;

mod organisation;
mod splats;
mod unused;
mod vector;

/// All rules that `config` breaks.
#[must_use]
pub fn check(config: &Config) -> RuleBreaches {
    let mut out = RuleBreaches::default();
    let ghz = config.clock_ghz().unwrap_or_default();
    // A clock in MHz, as in the version before.
    let hint = match ghz > 10.0 && ghz <= 10_000.0 {
        true => format!(" ({ghz} MHz are {})", ghz / 1e3),
        false => String::new(),
    };
    out.require(
        config
            .clock_mhz
            .is_none_or(|mhz| (1..=10_000).contains(&mhz)),
        "clock",
        "clock_ghz",
        ghz,
        format!("0.001 to 10 GHz{hint}: it converts cycles to time"),
    );
    gathering(config, &mut out);
    organisation::organisation(config, &mut out);
    index_table(config, &mut out);
    vector::vector(config, &mut out);
    vector::exponential(config, &mut out);
    splats::splats(config, &mut out);
    unused::unused(config, &mut out);
    out
}

pub(super) fn listed(vertices: &[Vertices]) -> String {
    let counts: Vec<_> = vertices.iter().map(|v| v.count().to_string()).collect();
    format!("[{}]", counts.join(", "))
}

fn gathering(config: &Config, out: &mut RuleBreaches) {
    let gu = &config.gu;
    out.range(
        "mvoxel-rows",
        "mvoxel.rows",
        config.mvoxel.rows,
        2,
        65_536,
        "a row is named by 16 bits of an id",
    );
    out.range(
        "gu-banks",
        "gu.banks",
        gu.banks,
        1,
        64,
        "channels read in one cycle",
    );
    out.range(
        "gu-ports",
        "gu.ports",
        gu.ports,
        1,
        8,
        "entries processed side by side",
    );
    out.range(
        "gu-feature-bits",
        "gu.feature_bits",
        gu.feature_bits,
        8,
        16,
        "a feature sits in a 16-bit lane",
    );
    out.range(
        "gu-weight-bits",
        "gu.weight_bits",
        gu.weight_bits,
        4,
        15,
        "a weight sits in 16 bits as U1.W",
    );
    out.range(
        "gu-segments",
        "gu.segments",
        gu.segments,
        1,
        64,
        "passes over an MVoxel's entries",
    );
    out.range(
        "gu-fifo-depth",
        "gu.fifo_depth",
        config.feature_fifo_depth(),
        config.least_feature_fifo_depth(),
        1024,
        "fewer beats than the latency and one stall entries of one cycle even with a ready sink",
    );
    out.range(
        "gu-counter-bits",
        "gu.counter_bits",
        gu.counter_bits,
        16,
        64,
        "width of the cycle and stall counters",
    );
    if gu.modes != Modes::Unstructured {
        let mut unique = gu.vertices.clone();
        unique.sort();
        unique.dedup();
        out.require(
            !gu.vertices.is_empty() && unique.len() == gu.vertices.len() && !gu.vertices.contains(&Vertices::One),
            "gu-vertices",
            "gu.vertices",
            listed(&gu.vertices),
            "at least one of 8, 4 and 2, each once; single ids are gu.modes = \"unstructured\" or \"both\"",
        );
    }
}

fn index_table(config: &Config, out: &mut RuleBreaches) {
    let (rit, ports) = (&config.rit, config.gu.ports.max(1));
    out.require(
        rit.entries.is_multiple_of(ports) && (ports..=65_536).contains(&rit.entries),
        "rit-entries",
        "rit.entries",
        rit.entries,
        format_args!(
            "a multiple of gu.ports = {ports}, from {ports} to 65536, such as {}: {ports} entries are read together",
            (rit.entries.min(65_536) / ports * ports).max(ports)
        ),
    );
    let (stream, row) = (config.rit_stream_bits(), config.rit_row_bits());
    // Without a port there is no row to divide.
    out.require(
        config.gu.ports == 0 || stream >= 32 && stream.is_multiple_of(32) && row.is_multiple_of(stream),
        "rit-stream-bits",
        "rit.stream_bits",
        stream,
        format_args!("a multiple of 32 that divides the {row} bits of one RIT row ({ports} entries of 48 bytes)"),
    );
    out.require(
        rit.slot_bits == 16 || rit.slot_bits == 32,
        "rit-slot-bits",
        "rit.slot_bits",
        rit.slot_bits,
        "16 or 32: the tag of word 0, or those of words 0 and 1",
    );
    let compact = rit.entry == EntryKind::Compact;
    out.require(
        !compact || config.gu.modes != Modes::Unstructured,
        "compact-modes",
        "rit.entry",
        "compact",
        "\"paper\", since single ids have no compact form; or gu.modes = \"structured\" or \"both\"",
    );
    out.require(
        !compact || rit.slot_bits == 16,
        "compact-slot",
        "rit.slot_bits",
        rit.slot_bits,
        "16, the width of the slot in a compact entry",
    );
    out.require(
        !compact || [8, 64, 512].contains(&config.mvoxel.rows),
        "compact-rows",
        "mvoxel.rows",
        config.mvoxel.rows,
        "8, 64 or 512: cubes of edges that are powers of two, addressed by the 9 bits of a \
         compact entry",
    );
    out.require(
        rit.slot_bits != 32 || config.gu.modes == Modes::Structured,
        "rit-slot-words",
        "rit.slot_bits",
        rit.slot_bits,
        "16, since single-id entries carry one tag; or gu.modes = \"structured\"",
    );
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// One configuration for every rule; the snapshot shows the messages to a user.
    #[test]
    fn every_rule_refuses_with_its_name() {
        let cases = [
            "clock_mhz = 0",
            "[mvoxel]\nrows = 1",
            "[gu]\nbanks = 65",
            "[gu]\nports = 0",
            "[gu]\nfeature_bits = 7",
            "[gu]\nweight_bits = 16",
            "[gu]\nsegments = 0",
            "[gu]\nfifo_depth = 3",
            "[gu]\ncounter_bits = 8",
            "[gu]\nvertices = [1, 8]",
            "[gu]\nvertices = []",
            "[gu]\norganisation = \"feature-major\"\nbanks = 24",
            "[gu]\norganisation = \"feature-major\"\nlanes = 65",
            "[gu]\norganisation = \"feature-major\"\nlanes = 15",
            "[gu]\norganisation = \"feature-major\"\nfifo_depth = 4",
            "[gu]\norganisation = \"feature-major\"\n[mvoxel]\nrows = 500",
            "[rit]\nentries = 127",
            "[rit]\nstream_bits = 80",
            "[rit]\nslot_bits = 24",
            "[rit]\nslot_bits = 32",
            "[gu]\nchannels = 0",
            "[gu]\nrecords_a_row = 3",
            "[gu]\nsums = \"exact\"\nweights = \"any\"",
            "[gu]\nports = 3\nextra_ports = \"split\"",
            "[gu]\norganisation = \"feature-major\"\nbanks = 16\nports = 4\nextra_ports = \"split\"",
            "[gu]\nports = 8\nextra_ports = \"split\"\n[mvoxel]\nrows = 510",
            "[gu]\norganisation = \"parity\"",
            "[gu]\norganisation = \"parity\"\nbanks = 12\nmodes = \"structured\"\nvertices = [8]",
            "[gu]\norganisation = \"parity\"\nmodes = \"structured\"\nvertices = [8]\n[mvoxel]\nrows = 216",
            "[rit]\nentry = \"compact\"\n[gu]\nmodes = \"unstructured\"",
            "[rit]\nentry = \"compact\"\nslot_bits = 32\n[gu]\nmodes = \"structured\"",
            "[rit]\nentry = \"compact\"\n[mvoxel]\nrows = 1024",
            "[vu]\nlanes = 0",
            "[vu]\nfifo_depth = 1",
            "[vu]\nops = [\"exp\", \"exp\"]",
            "[vu.operands]\nmultiply = [22, 33]",
            "[vu.operands]\nmultiply = [1, 18]",
            "[vu.operands]\nsquare_sum = 1",
            "[vu]\nops = [\"exp\"]\n[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 19",
            "[vu]\nregistered = true\n[vu.exp]\nearly_out = true",
            "[vu.exp]\niterations = 32",
            "[vu.exp]\noutput_bits = 25",
            "[vu.exp]\none_minus_frac_bits = 30",
            "[vu.exp]\ninput = \"S3.12\"",
            "[vu.exp]\noutput = \"general\"",
            "[vu.exp]\nform = \"literal\"",
            "[vu.exp]\niterations_per_clock = 21",
            "[vu.exp]\naccumulator_bits = 15",
            "[vu.exp]\nconstant_bits = 12",
            "[vu.exp]\noffset = 17",
            "[vu]\nops = [\"exp\"]\n[vu.exp]\nform = \"literal\"\ninput = \"S0.15\"\ntail = true",
            "[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "[vu]\nops = [\"exp\", \"sigmoid\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "[vu]\nops = [\"sigmoid\", \"softplus\"]\n[vu.exp]\npipelined = true",
            "[vu]\nops = [\"softplus\"]\n[vu.exp]\noutput_bits = 21",
            "[vu.exp]\nform = \"radix-4\"",
            "[vu]\nops = [\"exp\"]\n[vu.exp]\nform = \"radix-4\"\niterations = 4\noutput = \"general\"\ninput = \"S3.12\"",
            "[vu.exp]\nbase = \"two\"",
            "[vu.exp]\nform = \"piecewise\"\npieces = 48\npipelined = true",
            "[vu.exp]\nform = \"piecewise\"",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\noutput_bits = 17",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\ntail = true\noffset = 1\nearly_out = true",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\niterations_per_clock = 2",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\ninput = \"U3.8\"\nconstant_bits = 9",
            "[vu]\nops = [\"exp\", \"sigmoid\"]\n[vu.exp]\nform = \"piecewise\"\npipelined = true",
            "[vu.exp]\nearly_out = true\ntail = true",
            "[vu.exp]\nearly_out = true\niterations_per_clock = 10",
            "[vu]\nops = [\"sigmoid\"]\n[vu.exp]\nearly_out = true",
            "[vu]\nops = [\"exp\"]\n[vu.exp]\nform = \"radix-4\"\niterations = 4\nearly_out = true",
            "[gu]\nlanes = 0",
            "[gu]\nmodes = \"unstructured\"\nvertices = [8]",
            "[vu.exp]\npieces = 3",
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\niterations = 5",
            "[su]\nlanes = 0",
            "[su]\ntiles = 12",
            "[su]\nunits = 65",
            "[su]\npipelined = true\n[vu.exp]\npipelined = true",
            "[su]\npipelined = true\n[vu.exp]\nearly_out = true",
            "[su]\n[vu.exp]\nform = \"piecewise\"\npipelined = true\nbase = \"two\"",
            "[su]\n[vu]\nops = [\"exp\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "[su]\n[vu.exp]\noutput_bits = 18",
            "[su]\n[vu.exp]\ninput = \"U4.12\"",
            "[su]\nopacity = \"in-power\"\n[vu.exp]\ninput = \"U3.12\"",
        ];
        let mut seen = String::new();
        for text in cases {
            let config: Config = toml::from_str(text).unwrap();
            let breaches = check(&config);
            assert!(!breaches.is_empty(), "accepted:\n{text}");
            seen += &format!(
                "{}\n  {}\n",
                text.replace('\n', " "),
                breaches.to_string().replace('\n', "\n  ")
            );
        }
        insta::assert_snapshot!(seen);
    }

    #[test]
    fn the_whole_stated_range_is_accepted() {
        for banks in [1, 2, 31, 32, 64] {
            for ports in 1..=8 {
                for entries in [ports, 3 * ports, 128 / ports * ports] {
                    let text = format!(
                        "[gu]\nbanks = {banks}\nports = {ports}\n[rit]\nentries = {entries}"
                    );
                    let config: Config = toml::from_str(&text).unwrap();
                    assert!(check(&config).is_empty(), "{text}: {}", check(&config));
                }
            }
        }
        for n in 2..=31 {
            for tail in [false, true] {
                for r in [1, 3, 4 + n] {
                    let text = format!(
                        "[vu.exp]\niterations = {n}\ntail = {tail}\niterations_per_clock = {r}"
                    );
                    let config: Config = toml::from_str(&text).unwrap();
                    assert!(check(&config).is_empty(), "{text}: {}", check(&config));
                }
            }
        }
    }
}
