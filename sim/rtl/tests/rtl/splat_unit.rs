//! The splat unit against its twin, bit by bit.

use potamoi_cycles::splat_unit::SplatPixel;
use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::record::SplatRecord;
use potamoi_reference::splat_unit::{
    ReferenceSplatUnit, SplatEntry, SplatSettings, SplatUnitCounts, Thresholds,
};
use potamoi_rtl::{EngineKind, SplatRun, SplatUnit};
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
};

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

fn expected(
    config: &Config,
    jobs: &[Vec<SplatEntry>],
    tiles: u16,
) -> (Vec<Vec<SplatPixel>>, SplatUnitCounts) {
    let mut counts = SplatUnitCounts::default();
    let of = |job: &Vec<SplatEntry>| {
        let mut twin = ReferenceSplatUnit::new(&config.vu.exp, usize::from(tiles), SETTINGS);
        job.iter().for_each(|entry| twin.composite(entry));
        let own = twin.counts();
        counts.square_sums += own.square_sums;
        counts.exponentials += own.exponentials;
        counts.drawn += own.drawn;
        counts.stopped += own.stopped;
        let pixels = twin.tiles().iter().flat_map(|tile| {
            let both = tile.transmittance.iter().zip(tile.colour);
            both.map(|(transmittance, colour)| SplatPixel {
                transmittance: *transmittance,
                colour,
            })
        });
        pixels.collect()
    };
    (jobs.iter().map(of).collect(), counts)
}

fn check(config: &Config, su: &SuConfig, jobs: &[Vec<SplatEntry>], stalls: Stalls) -> SplatRun {
    let unit = SplatUnit::on(EngineKind::Verilator, config, su).unwrap();
    let own: Vec<&[SplatEntry]> = jobs.iter().map(Vec::as_slice).collect();
    let last = su.tiles as u16 - 1;
    let found = unit.check(&own, last, &SETTINGS, &stalls, 1).unwrap();
    let (wanted, counts) = expected(config, jobs, su.tiles as u16);
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

#[test]
fn random_records_are_composited_bit_by_bit() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for (preset, lanes, tiles) in [("pipelined", 1, 4), ("small", 12, 4)] {
        let su = SuConfig { lanes, tiles };
        let jobs: Vec<_> = [400, 0, 1, 60]
            .map(|count| entries(&mut random, tiles as u16, count))
            .to_vec();
        check(&config(preset), &su, &jobs, Stalls::NONE);
        let some = StreamStalls {
            per_mille: 400,
            burst: 3,
        };
        let stalls = Stalls {
            rit: some,
            sink: some,
            ..Stalls::NONE
        };
        check(&config(preset), &su, &jobs, stalls);
    }
}
