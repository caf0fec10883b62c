//! Random AXI4-Stream traffic, right and wrong, on both units of every preset: beats
//! without bytes in any place, gaps, back-pressure, offers that are taken back, `tkeep`
//! of every shape, ends too early or too late, and reset in any cycle. Either every
//! beat comes back right, in every bit and cycle, or a flag is up; and after a reset
//! the unit does right work again.
mod gather;
mod pins;
mod traffic;
mod vector;

use potamoi_formats::config::{Config, PRESETS};

/// Seeds that a test looks at, of each preset.
const FEW: u64 = 1;
const MANY: u64 = 40;

/// Every preset, and choices that none has.
fn configurations() -> Vec<(String, Config)> {
    let more = [
        (
            "pipelined",
            "[gu]\nbanks = 4\npipelined = true\n[rit]\nentries = 8\n",
        ),
        (
            "three ports",
            "[gu]\nbanks = 2\nports = 3\n[rit]\nentries = 6\n",
        ),
        (
            "turns",
            "[gu]\nbanks = 2\nports = 4\nextra_ports = \"split\"\n[rit]\nentries = 8\n",
        ),
        (
            "wide stream",
            "[gu]\nbanks = 2\nports = 2\n[rit]\nentries = 4\nstream_bits = 768\n",
        ),
        (
            "parity",
            "[gu]\norganisation = \"parity\"\nbanks = 8\nmodes = \"structured\"\nvertices = [8]\n\
             [rit]\nentries = 4\n",
        ),
        (
            "compact, pipelined",
            "[gu]\nbanks = 2\npipelined = true\n[rit]\nentries = 4\nentry = \"compact\"\n\
             [mvoxel]\nrows = 64\n",
        ),
        (
            "early out",
            "[gu]\nbanks = 1\nports = 1\n[rit]\nentries = 2\n[vu]\nlanes = 3\n[vu.exp]\nearly_out = true\n",
        ),
        (
            "narrow lanes",
            "[gu]\nbanks = 1\nports = 1\n[rit]\nentries = 2\n[vu]\nlanes = 3\nregistered = true\n\
             [vu.operands]\nmultiply = [12, 15]\nsquare_sum = 13\n",
        ),
        (
            "feature-major",
            "[gu]\norganisation = \"feature-major\"\nbanks = 4\nlanes = 4\n[rit]\nentries = 4\n\
             [mvoxel]\nrows = 64\n",
        ),
    ];
    let presets = PRESETS.iter().map(|(name, text)| (*name, *text));
    let named = presets.chain(more);
    named
        .map(|(name, text)| (name.to_owned(), Config::from_toml(text, name).unwrap()))
        .collect()
}

/// The seeds to run: those of a sweep, or the one that `STREAMS_SEED` names, of the
/// configuration that `STREAMS_OF` names.
fn cases(count: u64) -> Vec<(String, Config, u64)> {
    let number = |name: &str| std::env::var(name).ok()?.parse().ok();
    let seeds = match number("STREAMS_SEED") {
        Some(seed) => seed..seed + 1,
        None => 0..count,
    };
    let only = std::env::var("STREAMS_OF").ok();
    let configs = configurations().into_iter();
    configs
        .filter(|(name, _)| only.as_ref().is_none_or(|only| only == name))
        .flat_map(|(name, config)| {
            seeds
                .clone()
                .map(move |seed| (name.clone(), config.clone(), seed))
        })
        .collect()
}

/// Runs a case of a test by its name; a failure says how to run it again.
fn each(test: &str, count: u64, run: impl Fn(&Config, u64) -> Result<(), String>) {
    for (name, config, seed) in cases(count) {
        if let Err(why) = run(&config, seed) {
            panic!(
                "{name}, seed {seed}: {why}\nagain: STREAMS_OF='{name}' STREAMS_SEED={seed} \
                 cargo test -p potamoi-rtl --test rtl streams::{test} -- --include-ignored --exact"
            );
        }
    }
}

#[test]
fn right_traffic_comes_back_right_in_every_bit_and_cycle() {
    each(
        "right_traffic_comes_back_right_in_every_bit_and_cycle",
        FEW,
        gather::right,
    );
}

#[test]
fn wrong_traffic_raises_a_flag_and_a_reset_helps() {
    each(
        "wrong_traffic_raises_a_flag_and_a_reset_helps",
        FEW,
        gather::wrong,
    );
}

#[test]
fn a_reset_in_any_cycle_loses_no_beat_and_leaves_nothing() {
    each(
        "a_reset_in_any_cycle_loses_no_beat_and_leaves_nothing",
        FEW,
        gather::reset,
    );
}

#[test]
fn vectors_come_back_right_or_raise_a_flag() {
    each(
        "vectors_come_back_right_or_raise_a_flag",
        FEW,
        vector::traffic,
    );
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn many_more_seeds_of_all() {
    each("many_more_seeds_of_all", MANY, |config, seed| {
        gather::right(config, seed)?;
        gather::wrong(config, seed)?;
        gather::reset(config, seed)?;
        vector::traffic(config, seed)
    });
}
