//! Knobs of the exponential.

use super::{Knob, Setting, config, exp};

/// A setting that keeps the default's widths.
fn plain(label: impl Into<String>, toml: impl Into<String>) -> Setting {
    config(label, format!("[vu.exp]\n{}", toml.into()))
}

pub(super) fn exponential() -> Vec<Knob> {
    let iterations = [8, 10, 12, 14, 20, 24];
    let tails = [4, 6, 8, 9, 12];
    let pieces = [8, 16, 32, 64, 128];
    vec![
        Knob {
            name: "iterations",
            what: "iterations of the exponential",
            settings: iterations
                .map(|n| exp(format!("{n}"), format!("iterations = {n}")))
                .to_vec(),
        },
        Knob {
            name: "tail",
            what: "a multiply by 1 + residual instead of the last iterations",
            settings: tails
                .map(|n| exp(format!("n = {n}"), format!("iterations = {n}\ntail = true")))
                .to_vec(),
        },
        Knob {
            name: "radix-4",
            what: "two bits of the exponential a step",
            settings: [3, 4, 5]
                .map(|n| {
                    let toml = format!("form = \"radix-4\"\niterations = {n}\ntail = true");
                    exp(format!("J = {n}"), toml)
                })
                .to_vec(),
        },
        Knob {
            name: "pieces",
            what: "straight pieces instead of a recurrence, an exponential a clock",
            settings: pieces
                .map(|n| {
                    let toml = format!("form = \"piecewise\"\npieces = {n}\npipelined = true");
                    exp(format!("{n}"), toml)
                })
                .to_vec(),
        },
        Knob {
            name: "output-bits",
            what: "fraction bits of the exponential's result",
            settings: [10, 12, 14]
                .map(|n| exp(n.to_string(), format!("output_bits = {n}")))
                .to_vec(),
        },
        Knob {
            name: "input-bits",
            what: "fraction bits of the power",
            settings: [8, 10, 11, 12]
                .map(|n| plain(n.to_string(), format!("input = \"U3.{n}\"")))
                .to_vec(),
        },
        Knob {
            name: "accumulator-bits",
            what: "fraction bits of the exponential's accumulator",
            settings: [16, 17, 18, 19]
                .map(|n| plain(n.to_string(), format!("accumulator_bits = {n}")))
                .to_vec(),
        },
        Knob {
            name: "constant-bits",
            what: "fraction bits of the exponential's remainder and constants",
            settings: [14, 16, 17, 18]
                .map(|n| plain(n.to_string(), format!("constant_bits = {n}")))
                .to_vec(),
        },
        Knob {
            name: "early-out",
            what: "the exponential stops when its bits are complete",
            settings: vec![plain("on", "early_out = true")],
        },
        Knob {
            name: "iterations-a-clock",
            what: "iterations of the exponential a clock",
            settings: [2, 4]
                .map(|n| plain(format!("{n}"), format!("iterations_per_clock = {n}")))
                .to_vec(),
        },
        Knob {
            name: "pipelined",
            what: "an exponential a clock",
            settings: vec![plain("on", "pipelined = true")],
        },
    ]
}
