//! The splat unit against its twin, bit by bit.

use std::sync::Arc;

use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::{Config, SplatOpacity, SuConfig};
use potamoi_formats::record::SplatRecord;
use potamoi_netlist::{Change, Fault, Module};
use potamoi_reference::splat_unit::{
    ReferenceSplatUnit, SplatEntry, SplatPixel, SplatSettings, SplatUnitCounts, Thresholds,
};
use potamoi_rtl::{EngineKind, SplatRun, SplatUnit};
use potamoi_units::splat_unit::splat_unit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const AGAIN: &str = "cargo test -p potamoi-rtl --test rtl splat_unit";
const SETTINGS: SplatSettings = SplatSettings {
    thresholds: Thresholds {
        alpha_cap: 64_881,
        alpha_min: 258,
        stop: 6_871_948,
        spare: 0,
    },
    is_centred: true,
    opacity: SplatOpacity::Multiplied,
};

/// Records so far away that the low bits of a start value are those of one on the tile's first pixel.
fn far_entries() -> [SplatEntry; 2] {
    [[256, 0], [0, 256]].map(|off| SplatEntry {
        slot: 0,
        tile: [0, 0],
        last: [15, 15],
        record: SplatRecord {
            mean: off.map(|pixels: i32| pixels << 12),
            factor: [1 << 30, 0, 1 << 30],
            opacity: u16::MAX / 2,
            colour: [1 << 12; 3],
            rank: 0,
        },
    })
}

/// A record near a tile, from less than a pixel to more than a tile wide.
fn record(random: &mut Pcg64Mcg, tile: [u16; 2]) -> SplatRecord {
    let mut mean = || random.random_range(-24 * 4096..40 * 4096);
    let mean = tile.map(|at| i32::from(at) * 16 * 4096 + mean());
    let size = random.random_range(0..9u32);
    let mut factor = || random.random_range(1 << 25..i32::MAX) >> size;
    let (l11, l22) = (factor(), factor());
    SplatRecord {
        mean,
        factor: [l11, factor() * [1, -1][(l11 & 1) as usize] / 2, l22],
        opacity: match random.random_range(0..6) {
            0 => u16::MAX,
            1 => random.random_range(0..600),
            _ => random.random(),
        },
        colour: [0; 3].map(|_: u16| random.random()),
        rank: 0,
    }
}

fn entries(random: &mut Pcg64Mcg, tiles: u16, count: usize) -> Vec<SplatEntry> {
    let of = |_| {
        let slot = random.random_range(0..tiles);
        let tile = [slot % 4 + 1000 * (slot / 7), slot / 4];
        SplatEntry {
            slot,
            tile,
            last: [15, if slot == 1 { 9 } else { 15 }],
            record: record(random, tile),
        }
    };
    (0..count).map(of).collect()
}

/// Settings for records that hold opacities as a unit takes them.
const fn settings(su: &SuConfig) -> SplatSettings {
    SplatSettings {
        opacity: su.opacity,
        ..SETTINGS
    }
}

fn expected(
    (config, su): (&Config, &SuConfig),
    jobs: &[Vec<SplatEntry>],
) -> (Vec<Vec<SplatPixel>>, SplatUnitCounts) {
    let mut counts = SplatUnitCounts::default();
    let of = |job: &Vec<SplatEntry>| {
        let mut twin = ReferenceSplatUnit::new(&config.vu.exp, su.tiles as usize, settings(su));
        job.iter().for_each(|entry| twin.composite(entry));
        let own = twin.counts();
        counts.square_sums += own.square_sums;
        counts.exponentials += own.exponentials;
        counts.drawn += own.drawn;
        counts.stopped += own.stopped;
        SplatPixel::of_tiles(twin.tiles()).collect()
    };
    (jobs.iter().map(of).collect(), counts)
}

fn check(
    engine: EngineKind,
    (config, su): (&Config, &SuConfig),
    jobs: &[Vec<SplatEntry>],
    stalls: Stalls,
) -> SplatRun {
    let unit = SplatUnit::on(engine, config, su).unwrap();
    let own: Vec<&[SplatEntry]> = jobs.iter().map(Vec::as_slice).collect();
    let last = su.tiles as u16 - 1;
    let found = unit.check(&own, last, &settings(su), &stalls, 1).unwrap();
    let (wanted, counts) = expected((config, su), jobs);
    for (job, (found, wanted)) in found.jobs.iter().zip(&wanted).enumerate() {
        for (at, (found, wanted)) in found.iter().zip(wanted).enumerate() {
            assert_eq!(found, wanted, "job {job}, pixel {at}; again: {AGAIN}");
        }
    }
    let own = found.counters;
    assert_eq!([own.drawn, own.stopped], [counts.drawn, counts.stopped]);
    assert!(own.square_sums >= counts.square_sums && own.exponentials >= counts.exponentials);
    println!("{own:?} {counts:?} {} cycles", found.cycles);
    found
}

fn config(preset: &str) -> Config {
    Config::preset(preset).unwrap()
}

fn stalls() -> Stalls {
    let some = StreamStalls {
        per_mille: 400,
        burst: 3,
    };
    Stalls {
        rit: some,
        sink: some,
        ..Stalls::NONE
    }
}

#[test]
fn random_records_are_composited_bit_by_bit() {
    composited(3..5);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn random_records_are_composited_by_other_units() {
    composited(0..3);
}

/// By units with these numbers.
fn composited(units: std::ops::Range<usize>) {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let (factor, in_power) = (SplatOpacity::Multiplied, SplatOpacity::InPower);
    let all = [
        ("pipelined", false, 1, 4, factor),
        ("small", true, 1, 4, factor),
        ("small", false, 12, 4, factor),
        ("pipelined", false, 1, 4, in_power),
        ("small", false, 5, 4, in_power),
    ];
    for (preset, pipelined, lanes, tiles, opacity) in all[units].iter().copied() {
        let su = SuConfig {
            lanes,
            tiles,
            units: 1,
            pipelined,
            opacity,
        };
        let mut jobs = [400, 0, 1, 60]
            .map(|count| entries(&mut random, tiles as u16, count))
            .to_vec();
        jobs.push(far_entries().to_vec());
        check(
            EngineKind::Verilator,
            (&config(preset), &su),
            &jobs,
            Stalls::NONE,
        );
        check(
            EngineKind::Verilator,
            (&config(preset), &su),
            &jobs,
            stalls(),
        );
    }
}

/// Limits reach the highest bit of a power, whatever its fraction bits.
#[test]
fn inputs_of_12_to_20_fraction_bits_are_composited() {
    let mut random = Pcg64Mcg::seed_from_u64(6);
    for bits in ["U3.12", "U3.14", "U3.20"] {
        let constants = if bits == "U3.20" {
            "constant_bits = 24\n"
        } else {
            ""
        };
        let text = format!(
            "[vu.exp]\npipelined = true\ninput = \"{bits}\"\n{constants}[su]\nlanes = 1\ntiles = 2\n"
        );
        let config = Config::from_toml(&text, "test").unwrap();
        let su = config.su.clone().unwrap();
        let jobs = [entries(&mut random, 2, 60)];
        check(EngineKind::Interpreter, (&config, &su), &jobs, Stalls::NONE);
    }
}

const SMALL: SuConfig = SuConfig {
    lanes: 3,
    tiles: 2,
    units: 1,
    pipelined: false,
    opacity: SplatOpacity::Multiplied,
};

/// Every engine has the pixels of the reference unit and the cycles of the cycle model.
#[test]
fn the_engines_agree_on_the_splat_unit() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let jobs = [14, 3].map(|count| entries(&mut random, 2, count));
    let runs = [
        EngineKind::Verilator,
        EngineKind::Interpreter,
        EngineKind::Icarus,
    ]
    .map(|engine| check(engine, (&config("small"), &SMALL), &jobs, stalls()));
    assert_eq!(runs[0], runs[1]);
    assert_eq!(runs[0], runs[2]);
}

/// Records in a tile after the last one are dropped, and raise a flag: every cycle is that of the cycle
/// model, and the pixels are those of the reference unit, which drops them too.
#[test]
fn records_in_tiles_after_the_last_one_are_dropped() {
    let mut random = Pcg64Mcg::seed_from_u64(9);
    let jobs = [24, 9].map(|count| entries(&mut random, 2, count));
    let kept = jobs.clone().map(|mut job| {
        job.retain(|entry| entry.slot == 0);
        job
    });
    let config = config("small");
    let unit = SplatUnit::on(EngineKind::Interpreter, &config, &SMALL).unwrap();
    let run = |jobs: &[Vec<SplatEntry>; 2]| {
        let own = jobs.each_ref().map(Vec::as_slice);
        unit.check(&own, 0, &SETTINGS, &stalls(), 1)
    };
    let error = run(&jobs).unwrap_err().to_string();
    assert!(error.contains("raises the flags 0b100"), "{error}");
    let found = run(&kept).unwrap();
    for (job, found) in jobs.iter().zip(found.jobs) {
        let mut twin = ReferenceSplatUnit::new(&config.vu.exp, 1, SETTINGS);
        job.iter().for_each(|entry| twin.composite(entry));
        assert_eq!(
            found,
            SplatPixel::of_tiles(twin.tiles()).collect::<Vec<_>>()
        );
    }
}

/// A fault in a register of each part shows in a pixel, a handshake or a counter.
#[test]
fn faults_in_the_splat_unit_are_found() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let jobs = [16, 6].map(|count| entries(&mut random, 2, count));
    let jobs: Vec<&[SplatEntry]> = jobs.iter().map(Vec::as_slice).collect();
    let config = config("small");
    let unit = splat_unit(&config, &SMALL).unwrap();
    let run = |module: &Arc<Module>| {
        let own = SplatUnit::of_module(EngineKind::Interpreter, &config, &SMALL, module);
        own.unwrap().check(&jobs, 1, &SETTINGS, &stalls(), 4)
    };
    run(&unit).unwrap();
    for (module, register, bit) in [
        ("splat_setup", "phase", 1),
        ("splat_setup", "fresh_1", 0),
        ("splat_setup", "p_sum", 40),
        ("splat_setup", "dy_held", 20),
        ("splat_setup", "q_first", 40),
        ("splat_setup", "p_is_far", 0),
        ("splat_setup", "q_is_far", 0),
        ("splat_setup", "limit", 9),
        ("splat_setup", "settled", 0),
        ("splat_rows", "rows_left", 3),
        ("splat_rows", "entries_used", 0),
        ("splat_rows", "p_3", 44),
        ("splat_rows", "square_6", 11),
        ("splat_rows", "index_11", 0),
        ("splat_rows", "live_in_row", 6),
        ("splat_near", "times_3", 12),
        ("splat_near", "lowest", 7),
        ("splat_root", "root_4", 5),
        ("splat_unit", "rows_held", 0),
        ("splat_row_fifo", "write_pointer", 0),
        ("splat_pixels", "left", 4),
        ("splat_pixels", "q_square", 30),
        ("splat_pixels", "power", 7),
        ("splat_pixels", "info", 5),
        ("splat_powers", "count", 0),
        ("splat_powers", "infos", 2),
        ("splat_powers", "in_flight", 0),
        ("splat_tiles", "lane", 0),
        ("splat_product_32x17", "rows_6_to_11", 30),
        ("splat_product_18x18", "rows_9_to_17", 20),
        ("splat_product_16x16", "rows_0_to_7", 20),
        ("splat_tiles", "alpha_3", 9),
        ("splat_tiles", "product_7", 33),
        ("splat_tiles", "pixel_7", 2),
        ("splat_tiles", "stops_8", 0),
        ("splat_tiles", "added_12", 17),
        ("splat_tiles", "drain_at", 6),
        ("splat_unit", "ending", 0),
        ("splat_unit", "job_open", 0),
    ] {
        let fault = Fault {
            module: module.to_owned(),
            register: register.to_owned(),
            change: Change::Invert(bit),
        };
        let found = run(&fault.inject(&unit).unwrap());
        assert!(found.is_err(), "{module}.{register}[{bit}]; again: {AGAIN}");
    }
}

/// A vector of pairs of one pixel, whose neighbours are below the threshold: each reads the transmittance and the colour that the one before wrote.
#[test]
fn pairs_of_one_pixel_wait_for_each_other() {
    let su = SuConfig {
        lanes: 6,
        tiles: 2,
        units: 1,
        pipelined: false,
        opacity: SplatOpacity::Multiplied,
    };
    let mut random = Pcg64Mcg::seed_from_u64(4);
    let entry = |_| SplatEntry {
        slot: 0,
        tile: [0, 0],
        last: [15, 15],
        record: SplatRecord {
            mean: [5, 9].map(|at| at * 4096 + 2048),
            factor: [i32::MAX, 0, i32::MAX],
            opacity: random.random_range(600..1_800),
            colour: [4096, 65_535, 9],
            rank: 0,
        },
    };
    let jobs = [(0..30).map(entry).collect()];
    check(
        EngineKind::Verilator,
        (&config("small"), &su),
        &jobs,
        Stalls::NONE,
    );
}
