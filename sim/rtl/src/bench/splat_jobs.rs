//! Records of the bench of the splat unit: random ones, and such as reach its edges.

use potamoi_formats::config::{SplatOpacity, SuConfig};
use potamoi_formats::record::{LOG_OPACITY, OPACITY, SplatRecord};
use potamoi_reference::splat_unit::{SplatEntry, SplatSettings, TILE_PIXELS, Thresholds};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A pixel, S19.12.
const PIXEL: i32 = 1 << 12;
/// Side of a tile.
const SIDE: i32 = 16;
/// A factor of 1, S1.30.
const ONE: i32 = 1 << 30;

/// The rules of the published code: cap 0.99, threshold 1/255, transmittance 1e-4.
const PUBLISHED: SplatSettings = SplatSettings {
    thresholds: Thresholds {
        alpha_cap: 64_881,
        alpha_min: 258,
        stop: 6_871_948,
        spare: 0,
    },
    is_centred: true,
    opacity: SplatOpacity::Multiplied,
};

/// A job.
#[derive(Debug, Clone)]
pub(super) struct Records {
    pub(super) title: String,
    pub(super) entries: Vec<SplatEntry>,
    pub(super) settings: SplatSettings,
    pub(super) last_slot: u16,
    /// Cycles, the first ones, in which the sink takes nothing.
    pub(super) closed: u32,
    /// A beat without bytes ends the job.
    pub(super) ends_null: bool,
}

impl Records {
    fn new(title: &str, entries: Vec<SplatEntry>) -> Self {
        Self {
            title: format!("{title}, {} records", entries.len()),
            last_slot: entries.iter().map(|own| own.slot).max().unwrap_or(0),
            entries,
            settings: PUBLISHED,
            closed: 0,
            ends_null: false,
        }
    }

    /// Pixels that it gives.
    pub(super) fn pixels(&self) -> usize {
        (usize::from(self.last_slot) + 1) * TILE_PIXELS
    }
}

/// A record in the first tile, unless said otherwise.
fn entry(record: SplatRecord) -> SplatEntry {
    SplatEntry {
        slot: 0,
        tile: [0, 0],
        last: [15, 15],
        record,
    }
}

/// A record whose centre is this pixel's.
fn at(x: i32, y: i32, factor: [i32; 3], opacity: u16) -> SplatRecord {
    SplatRecord {
        mean: [x, y].map(|v| v * PIXEL + PIXEL / 2),
        factor,
        opacity,
        colour: [4096, 65_535, 1],
        rank: 7,
    }
}

/// Any record near a tile, from less than a pixel wide to more than the tile.
fn random(draw: &mut Pcg64Mcg, tile: [u16; 2]) -> SplatRecord {
    let mut mean = || draw.random_range(-SIDE * PIXEL..2 * SIDE * PIXEL);
    let mean = tile.map(|own| i32::from(own) * SIDE * PIXEL + mean());
    let size = draw.random_range(0..9u32);
    let mut factor = || draw.random_range(1 << 25..i32::MAX) >> size;
    let [l11, l21, l22] = [factor(), factor() / 2, factor()];
    SplatRecord {
        mean,
        factor: [l11, if l11 & 1 == 0 { l21 } else { -l21 }, l22],
        opacity: match draw.random_range(0..6) {
            0 => u16::MAX,
            1 => draw.random_range(0..600),
            _ => draw.random(),
        },
        colour: [0; 3].map(|_: u16| draw.random()),
        rank: draw.random(),
    }
}

/// Records whose forms lie in the middle between two codes at each pixel: their centres are on corners of
/// pixels, and their factors are odd multiples of the forms' ulp, 2^-16.
fn ties(seed: u64, count: usize) -> Vec<SplatEntry> {
    let mut draw = Pcg64Mcg::seed_from_u64(seed + 1);
    let of = |_| {
        let mut factor = || (draw.random_range(1 << 14..1 << 16) | 1) << 14;
        let factor = [factor(), 0, factor()];
        let mut corner = || draw.random_range(2..SIDE - 2) * PIXEL;
        entry(SplatRecord {
            mean: [corner(), corner()],
            ..at(0, 0, factor, 6_000)
        })
    };
    (0..count).map(of).collect()
}

/// A record a row, whose pixels take as long as those of two records take to come.
fn long_rows(count: i32) -> Vec<SplatEntry> {
    let of = |i: i32| {
        let mut record = at(8, i % SIDE, [ONE >> 8, 0, i32::MAX], 1_000 + 37 * i as u16);
        record.colour = [i, 2 * i, 3 * i].map(|own| own as u16);
        entry(record)
    };
    (0..count).map(of).collect()
}

fn any(draw: &mut Pcg64Mcg, slots: u16, count: usize) -> Vec<SplatEntry> {
    let of = |_| {
        let slot = draw.random_range(0..slots);
        // The second tile lies far away, and is cut off at 10 columns and 13 rows.
        let [tile, last] = match slot {
            1 => [[4095, 4000], [9, 12]],
            _ => [[slot, 2 * slot], [15, 15]],
        };
        SplatEntry {
            slot,
            tile,
            last: last.map(|v| v as u8),
            record: random(draw, tile),
        }
    };
    (0..count).map(of).collect()
}

/// Two records on a pixel, and the threshold at which the first one's exact product lies, or `above` it: the
/// pixel ends where the product is below.
fn ends_at(above: u64) -> Records {
    let thresholds = PUBLISHED.thresholds;
    let product = (1 << 20) * u64::from((1 << 16) - thresholds.alpha_cap);
    let title = match above {
        0 => "a product at the threshold, which ends no pixel",
        _ => "a product just below the threshold",
    };
    let bright = entry(at(5, 9, [i32::MAX, 0, i32::MAX], u16::MAX));
    let faint = entry(at(5, 9, [i32::MAX, 0, i32::MAX], 30_000));
    Records {
        settings: SplatSettings {
            thresholds: Thresholds {
                stop: product + above,
                ..thresholds
            },
            ..PUBLISHED
        },
        ..Records::new(title, vec![bright, faint])
    }
}

/// The jobs.
pub(super) fn jobs(su: &SuConfig, seed: u64) -> Vec<Records> {
    let mut draw = Pcg64Mcg::seed_from_u64(seed);
    let opaque = |x, y| entry(at(x, y, [ONE / 8, 0, ONE / 8], u16::MAX));
    let point = |opacity| entry(at(5, 9, [i32::MAX, 0, i32::MAX], opacity));
    let mut all = vec![
        Records::new("two tiles", any(&mut draw, 2, 60)),
        Records {
            last_slot: 0,
            ..Records::new("one tile, and records in the next", any(&mut draw, 2, 16))
        },
        Records::new("two tiles, the second without them", any(&mut draw, 2, 8)),
        Records::new("no record", vec![]),
        // Their rows wait behind a large one, so that their pairs follow one another.
        Records::new(
            "all on one pixel",
            (0..24)
                .map(|i| match i % 6 {
                    0 => entry(at(8, 8, [ONE / 64, 0, ONE / 64], 900)),
                    _ => point(1_500),
                })
                .collect(),
        ),
        Records::new(
            "opaque ones, of which later ones find pixels that have ended",
            (0..12).map(|i| opaque(3 + i % 2, 6)).collect(),
        ),
        Records::new(
            "larger than the picture",
            vec![entry(at(400, -300, [1 << 14, 99, 1 << 14], 40_000)); 4],
        ),
        Records::new(
            "needles along a row and a column",
            vec![
                entry(at(2, 7, [1 << 20, 0, i32::MAX], 65_000)),
                entry(at(11, 3, [i32::MAX, 0, 1 << 20], 65_000)),
                entry(at(8, 8, [ONE, -ONE, ONE / 16], 65_000)),
            ],
        ),
        Records::new(
            "nothing that counts, or too far away",
            vec![
                entry(at(8, 8, [ONE, 0, ONE], 0)),
                entry(at(8, 8, [ONE, 0, ONE], 257)),
                // Their start values end in as many zeros as the format has bits before the point.
                entry(at(8 + 256, 8, [ONE, 0, ONE], 65_535)),
                entry(at(8, 8 - 256, [ONE, 0, ONE], 65_535)),
                entry(at(8 - 25_600, 8, [ONE, 0, ONE], 65_535)),
                entry(at(8, 8 + 64_000, [ONE, 0, ONE], 65_535)),
            ],
        ),
        Records::new("forms in the middle between two codes", ties(seed, 40)),
        Records::new(
            "rows of a tile's width, behind which records wait",
            long_rows(32),
        ),
        ends_at(0),
        ends_at(1),
        Records {
            closed: 700,
            ..Records::new("a sink that takes nothing at first", any(&mut draw, 1, 12))
        },
        Records {
            settings: SplatSettings {
                thresholds: Thresholds {
                    alpha_cap: 1 << 16,
                    alpha_min: 1,
                    stop: 1,
                    spare: 0,
                },
                is_centred: false,
                ..PUBLISHED
            },
            ends_null: true,
            ..Records::new("without threshold and cap", any(&mut draw, 1, 30))
        },
    ];
    // The last tile alone, if its pixels are few enough.
    if su.tiles <= 16 {
        let slot = su.tiles as u16 - 1;
        let mut entries = any(&mut draw, 1, 6);
        entries.iter_mut().for_each(|own| own.slot = slot);
        all.push(Records::new("the last tile", entries));
    }
    if su.opacity == SplatOpacity::InPower {
        for own in &mut all {
            own.settings.opacity = su.opacity;
            let records = own.entries.iter_mut().map(|entry| &mut entry.record);
            records.for_each(|record| record.opacity = logarithm(record.opacity));
        }
    }
    all
}

/// The code of an opacity's negated logarithm.
fn logarithm(opacity: u16) -> u16 {
    let units = -OPACITY.value(opacity.into()).ln() / LOG_OPACITY.ulp();
    // The conversion saturates.
    units.round_ties_even() as u16
}
