//! The splat unit: what the cut, the spans and the chain of transmittances may leave out.
//!
//! The exact decision on a pair of pixel and Gaussian takes every pixel of the tile: both forms exactly,
//! their power, the exponential, and the product with the opacity beside the threshold.

use potamoi_formats::config::{Config, ExpConfig, SplatOpacity};
use potamoi_formats::fixed::Format;
use potamoi_formats::record::{FACTOR, MEAN, SplatRecord};
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::splat_unit::{
    Forms, Outcome, PowerLimits, ReferenceSplatUnit, SplatEntry, SplatJob, SplatSettings,
    StoredLimits, TILE, TileState,
};
use potamoi_splats::{Limits, Profile, unit_settings};

use super::{Case, Draws, Measuring, Stop, Worst, base_e, cases, codes_of_powers, ensure, unless};

/// The paper's exponential in a splat unit.
const UNIT: &str = "[vu.exp]\npipelined = true\n[su]";

cases! {
    "splat unit";
    opacities_at_the_cut, "opacities at the cut, each with the powers about its limit", UNIT;
    opacities_that_never_count, "opacities for which nothing counts", UNIT;
    powers_at_the_edge_of_a_code, "powers at the edge of a code", UNIT;
    needles_along_a_row, "needles along a row", UNIT;
    all_records_on_one_pixel, "all records on one pixel", UNIT;
    pairs_behind_a_stop, "a pixel that stops while its later pairs are in flight", UNIT;
    larger_than_the_frame, "a Gaussian larger than the frame", UNIT;
    all_pixels_live, "all pixels of a tile live", UNIT;
    no_pixel_live, "no pixel of a tile live", UNIT;
}

/// Stages from the reading of a transmittance to its writing.
const STAGES: usize = 4;

fn settings() -> SplatSettings {
    unit_settings(&Profile::Gsplat.rules(), SplatOpacity::Multiplied)
}

fn threshold() -> i64 {
    Limits::new(&Profile::Gsplat.rules()).alpha_min.into()
}

/// The power at which the alpha of an opacity is the least that is rounded up to the threshold.
fn by_formula(opacity: u16) -> f64 {
    (f64::from(opacity) / (threshold() as f64 - 0.5)).ln()
}

/// The product of an opacity and an exponential, U0.16.
fn alpha(opacity: u16, e: i32) -> i64 {
    (i64::from(opacity) * i64::from(e) + (1 << 15)) >> 16
}

fn codes(value: f64, fraction: u32) -> i32 {
    (value * f64::from(1u32 << fraction)) as i32
}

/// A record whose mean is so many pixels from the centre of the tile's first pixel.
fn entry(off: [f64; 2], factor: [f64; 3], opacity: u16) -> SplatEntry {
    SplatEntry {
        slot: 0,
        tile: [0, 0],
        last: [15, 15],
        record: SplatRecord {
            mean: off.map(|at| codes(at + 0.5, MEAN.frac_bits())),
            factor: factor.map(|v| codes(v, FACTOR.frac_bits())),
            opacity,
            colour: [4096; 3],
            rank: 0,
        },
    }
}

/// Forms of a record at each pixel of its tile.
fn forms(own: &SplatEntry) -> Forms {
    Forms::new(&own.record, [1 << (MEAN.frac_bits() - 1); 2])
}

/// Half the sum of squares of both forms, S15.16, as a code of 13 fraction bits, with a rounding.
fn power([p, q]: [i32; 2], half: i128) -> i32 {
    let [p, q] = [p, q].map(i128::from);
    ((p * p + q * q + half) >> 20).min(65_535) as i32
}

const HALF_UP: i128 = 1 << 19;

/// Pixels of a tile by column and row, the first pixel lowest in each row.
fn mask(is_in: impl Fn(u32, u32) -> bool) -> [u16; 16] {
    std::array::from_fn(|y| {
        let row = (0..TILE).filter(|x| is_in(*x, y as u32));
        row.fold(0, |row, x| row | 1 << x)
    })
}

/// Pairs of a tile that count, the first pixel lowest in each row.
fn counted(own: &SplatEntry, twin: &ReferenceExponential) -> [u16; 16] {
    let forms = forms(own);
    mask(|x, y| {
        let u = power(forms.at(x, y), HALF_UP);
        alpha(own.record.opacity, twin.exp(u)) >= threshold()
    })
}

/// Pairs that the unit draws on a clear tile.
fn of_unit(own: &SplatEntry, unit: &mut ReferenceSplatUnit) -> [u16; 16] {
    let settings = settings();
    let job = SplatJob {
        settings,
        tiles: 1,
        entries: &[*own],
    };
    let pixels = unit.run(&job).pixels;
    mask(|x, y| pixels[(TILE * y + x) as usize].transmittance != 1 << 20)
}

/// Pairs decided otherwise.
fn wrong(found: [u16; 16], counted: [u16; 16]) -> f64 {
    let rows = found.into_iter().zip(counted);
    rows.map(|(a, b)| f64::from((a ^ b).count_ones())).sum()
}

/// The exponential of a splat unit in the formats that the cases are written in.
fn of_splats(config: &Config) -> Result<&ExpConfig, Stop> {
    let none = || "the configuration has no splat unit (no table [su])".to_owned();
    let su = config.su.as_ref();
    unless(su.is_some(), none)?;
    let exp = codes_of_powers(config)?;
    base_e(exp)?;
    let is_factor = su.is_some_and(|su| su.opacity == SplatOpacity::Multiplied);
    let own = (exp.input, exp.output_bits) == (Format::unsigned(3, 13), 16);
    unless(is_factor && own, || {
        "the decisions of these cases are written for su.opacity = \"multiplied\", vu.exp.input = \
         \"U3.13\" and 16 bits of result"
            .to_owned()
    })?;
    Ok(exp)
}

fn parts(config: &Config) -> Result<(ReferenceExponential, ReferenceSplatUnit), Stop> {
    let exp = of_splats(config)?;
    let unit = ReferenceSplatUnit::new(exp, 1, settings());
    Ok((ReferenceExponential::new(exp), unit))
}

/// Every opacity, at the powers around its limit.
fn opacities_at_the_cut(under: &Config) -> Measuring {
    let (twin, _) = parts(under)?;
    let exp = &under.vu.exp;
    let stored = StoredLimits::new(exp, SplatOpacity::Multiplied, threshold() as i32);
    let exact = PowerLimits::new(exp, SplatOpacity::Multiplied, threshold() as i32);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for opacity in 0..=u16::MAX {
        let Some(limit) = exact.of(opacity) else {
            continue;
        };
        let by_formula = (by_formula(opacity).max(0.0) * 8192.0).round() as i32;
        for power in (limit as i32 - 2).max(0)..=limit as i32 + 2 {
            let counts = alpha(opacity, twin.exp(power)) >= threshold();
            fails.count(counts && power > by_formula);
            let kept = stored.of(opacity).is_some_and(|most| power as u32 <= most);
            ours.count(counts && !kept);
        }
    }
    Ok(Case {
        naive: "the power at which the product is the threshold, by ln, rounded".into(),
        unit: "pairs lost of 327,000".into(),
        fails,
        bound: 0.0,
        from: "the limit is found by a scan of the exponential's codes, and rounded up".into(),
        ours,
    })
}

/// On the mean, where the exponential is largest.
fn opacities_that_never_count(under: &Config) -> Measuring {
    let (twin, mut unit) = parts(under)?;
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for opacity in 0..600 {
        let own = entry([3.0, 5.0], [1.5, 0.0, 1.5], opacity);
        let counted = counted(&own, &twin);
        // What is within the limit counts, and a limit below 0 is 0.
        let limit = by_formula(opacity).max(0.0) * 8192.0;
        let forms = forms(&own);
        let within = mask(|x, y| f64::from(power(forms.at(x, y), HALF_UP)) <= limit);
        fails.0 += wrong(within, counted);
        ours.0 += wrong(of_unit(&own, &mut unit), counted);
    }
    Ok(Case {
        naive: "all within the limit counts, a limit below 0 is 0".into(),
        unit: "pairs decided wrongly".into(),
        fails,
        bound: 0.0,
        from: "they have no limit, and the product is compared after the cut".into(),
        ours,
    })
}

/// Gaussians whose power at a pixel is half a code above the limit.
fn powers_at_the_edge_of_a_code(under: &Config) -> Measuring {
    let (twin, mut unit) = parts(under)?;
    let mut draws = Draws(11);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for _ in 0..4000 {
        let size = draws.between(0.1, 1.7);
        let off = [draws.between(-2.0, 17.0), draws.between(-2.0, 17.0)];
        let opacity = draws.between(300.0, 65_535.0) as u16;
        let own = entry(off, [size, draws.between(-0.2, 0.2), size], opacity);
        let counted = counted(&own, &twin);
        let forms = forms(&own);
        let cut_off = mask(|x, y| {
            let u = power(forms.at(x, y), 0);
            alpha(opacity, twin.exp(u)) >= threshold()
        });
        fails.0 += wrong(cut_off, counted);
        ours.0 += wrong(of_unit(&own, &mut unit), counted);
    }
    Ok(Case {
        naive: "half the sum of squares, cut off".into(),
        unit: "pairs decided wrongly of 1,024,000".into(),
        fails,
        bound: 0.0,
        from: "one rounding, half up, in the unit as in the reference".into(),
        ours,
    })
}

/// Thin across a row, long along it: the ends of spans are met often.
fn needles_along_a_row(under: &Config) -> Measuring {
    let (twin, mut unit) = parts(under)?;
    let mut draws = Draws(12);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for _ in 0..4000 {
        let factor = [
            draws.between(0.2, 0.6),
            draws.between(-1.0, 1.0),
            draws.between(0.8, 1.8),
        ];
        let off = [draws.between(0.0, 15.0), draws.between(0.0, 15.0)];
        let own = entry(off, factor, draws.between(300.0, 65_535.0) as u16);
        let counted = counted(&own, &twin);
        fails.0 += lost(counted, by_the_quadratic(&own, factor, off));
        ours.0 += lost(counted, of_unit(&own, &mut unit));
    }
    Ok(Case {
        naive: "ends of each row's span by the quadratic, where the product is the threshold"
            .into(),
        unit: "pairs lost".into(),
        fails,
        bound: 0.0,
        from: "start values, steps and the root err outwards".into(),
        ours,
    })
}

/// Pairs that count and are left out.
fn lost(counted: [u16; 16], kept: [u16; 16]) -> f64 {
    let rows = counted.into_iter().zip(kept);
    rows.map(|(a, b)| f64::from((a & !b).count_ones())).sum()
}

/// Spans between the places at which the product is the threshold.
fn by_the_quadratic(own: &SplatEntry, factor: [f64; 3], off: [f64; 2]) -> [u16; 16] {
    let [a, b, c] = factor.map(|v| v as f32);
    let [x0, y0] = off.map(|v| v as f32);
    let square = 2.0 * by_formula(own.record.opacity) as f32;
    mask(|x, y| {
        let dy = y as f32 - y0;
        let rest = square - (c * dy) * (c * dy);
        let (middle, reach) = (x0 - b * dy / a, rest.max(0.0).sqrt() / a);
        rest >= 0.0 && (x as f32 - middle).abs() <= reach
    })
}

/// 200 records of one pixel: each needs the transmittance that the one before leaves.
fn all_records_on_one_pixel(under: &Config) -> Measuring {
    of_splats(under)?;
    let alphas: Vec<i64> = (0..200).map(|i| 700 + 37 * (i % 11)).collect();
    let step = |t: i64, alpha: i64| (t * (65_536 - alpha) + (1 << 15)) >> 16;
    let exact = alphas.iter().fold(1 << 20, |t, alpha| step(t, *alpha));
    // Without waiting, the transmittance of some stages before is read.
    let mut chain = vec![1i64 << 20; STAGES];
    for alpha in &alphas {
        chain.push(step(chain[chain.len() - STAGES], *alpha));
    }
    let mut tile = TileState::CLEAR;
    for alpha in &alphas {
        tile.composite(17, *alpha as u32, [0; 3], &settings().thresholds);
    }
    let error = |t: i64| Worst::of([(t - exact) as f64]);
    Ok(Case {
        naive: "each reads the transmittance without waiting for the pairs in the stages before it"
            .into(),
        unit: "ulp of U1.20".into(),
        fails: error(chain[chain.len() - 1]),
        bound: 0.0,
        from: "a pair waits while one of its pixel is in a stage that has not written".into(),
        ours: error(tile.transmittance[17].into()),
    })
}

/// A pixel ends while pairs of it are in flight: they may change nothing.
fn pairs_behind_a_stop(under: &Config) -> Measuring {
    of_splats(under)?;
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    let thresholds = settings().thresholds;
    let draw = |tile: &mut TileState, alpha: u32| tile.composite(3, alpha, [4096; 3], &thresholds);
    for behind in 1..=STAGES {
        let mut tile = TileState::CLEAR;
        for expected in [Outcome::Drawn, Outcome::Stopped] {
            let found = draw(&mut tile, thresholds.alpha_cap);
            ensure(found == expected, || {
                format!("{found:?} instead of {expected:?}")
            })?;
        }
        // As it was looked up when the pairs entered.
        let mut looked_up = tile.clone();
        looked_up.live = TileState::CLEAR.live;
        for _ in 0..behind {
            ours.count(draw(&mut tile, 300) != Outcome::Skipped);
            fails.count(draw(&mut looked_up, 300) != Outcome::Skipped);
        }
    }
    Ok(Case {
        naive: "live pixels are looked up once, before the pairs".into(),
        unit: "pairs drawn behind the stop".into(),
        fails,
        bound: 0.0,
        from: "the transmittance of a pixel that has stopped holds a bit that says so".into(),
        ours,
    })
}

/// Gaussians whose means are far outside the picture and whose forms change little from pixel to pixel: the
/// limit runs through the tile.
fn larger_than_the_frame(under: &Config) -> Measuring {
    let (twin, mut unit) = parts(under)?;
    let mut draws = Draws(13);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for _ in 0..4000 {
        let opacity = draws.between(400.0, 65_535.0) as u16;
        let size = draws.between(0.002, 0.02);
        let reach = (2.0 * by_formula(opacity)).sqrt() / size;
        let off = [7.5 - reach, draws.between(0.0, 15.0)];
        let own = entry(off, [size, draws.between(-size, size) / 4.0, size], opacity);
        let drawn = |forms: &dyn Fn(u32, u32) -> [i32; 2]| {
            mask(|x, y| alpha(opacity, twin.exp(power(forms(x, y), HALF_UP))) >= threshold())
        };
        let counted = drawn(&|x, y| rounded_once(&own.record, x, y));
        fails.0 += wrong(drawn(&|x, y| rounded_steps(&own.record, x, y)), counted);
        ours.0 += wrong(of_unit(&own, &mut unit), counted);
    }
    Ok(Case {
        naive: "start values and steps of the forms are rounded to 16 fraction bits, and added"
            .into(),
        unit: "pairs decided wrongly of 1,024,000".into(),
        fails,
        bound: 0.0,
        from: "start values and steps are exact, and each form is rounded once".into(),
        ours,
    })
}

/// Exact forms of a record at a pixel of the first tile, 42 fraction bits.
fn exact_forms(record: &SplatRecord, x: u32, y: u32) -> [i128; 2] {
    let bits = MEAN.frac_bits();
    let offset =
        |at: u32, mean: i32| (i128::from(at) << bits) + (1 << (bits - 1)) - i128::from(mean);
    let [dx, dy] = [offset(x, record.mean[0]), offset(y, record.mean[1])];
    let [l11, l21, l22] = record.factor.map(i128::from);
    [l11 * dx + l21 * dy, l22 * dy]
}

/// Half to even, away with so many bits.
fn half_even(value: i128, dropped: u32) -> i32 {
    let (floor, half) = (value >> dropped, 1 << (dropped - 1));
    let rest = value - (floor << dropped);
    (floor + i128::from(rest > half || rest == half && floor & 1 == 1)) as i32
}

/// Forms, S15.16, each rounded once.
fn rounded_once(record: &SplatRecord, x: u32, y: u32) -> [i32; 2] {
    let dropped = FACTOR.frac_bits() + MEAN.frac_bits() - 16;
    exact_forms(record, x, y).map(|own| half_even(own, dropped))
}

/// Forms, S15.16, from a start value and steps of that format.
fn rounded_steps(record: &SplatRecord, x: u32, y: u32) -> [i32; 2] {
    let [p, q] = rounded_once(record, 0, 0);
    let step = |factor: i32| half_even(factor.into(), FACTOR.frac_bits() - 16);
    let [l11, l21, l22] = record.factor.map(step);
    let [x, y] = [x as i32, y as i32];
    [p + l11 * x + l21 * y, q + l22 * y]
}

/// Faint Gaussians over the whole tile: as many pairs a record as a tile has pixels.
fn all_pixels_live(under: &Config) -> Measuring {
    const RECORDS: u64 = 20;
    let (_, mut unit) = parts(under)?;
    let wide = entry([7.5, 7.5], [0.01, 0.0, 0.01], 2_000);
    let job = SplatJob {
        settings: settings(),
        tiles: 1,
        entries: &[wide; RECORDS as usize],
    };
    let pairs = u64::from(TILE * TILE);
    let counts = unit.run(&job).counts;
    // A count in the bits of a pixel's number.
    let in_a_byte = u64::from(pairs as u8);
    let off = |a_record: u64| Worst::of([(RECORDS * pairs).abs_diff(a_record) as f64]);
    Ok(Case {
        naive: "an eight-bit counter of the pairs of a record".into(),
        unit: "pairs missed of 5,120".into(),
        fails: off(RECORDS * in_a_byte),
        bound: 0.0,
        from:
            "the remaining pixels of a row are a mask of 16 bits; the unit has no counter of pairs"
                .into(),
        ours: off(counts.drawn + counts.stopped),
    })
}

/// Opaque Gaussians end all pixels of a tile; what comes after them finds none.
fn no_pixel_live(under: &Config) -> Measuring {
    let (_, mut unit) = parts(under)?;
    let opaque = entry([7.5, 7.5], [0.001, 0.0, 0.001], u16::MAX);
    let later = entry([4.0, 9.0], [0.3, 0.1, 0.2], 30_000);
    let mut square_sums = |entries: &[SplatEntry]| {
        let job = SplatJob {
            settings: settings(),
            tiles: 1,
            entries,
        };
        unit.run(&job).counts.square_sums
    };
    // By the third at the latest every pixel has ended.
    let first = square_sums(&[opaque; 3]);
    let all = square_sums(&[[opaque; 3].as_slice(), &[later; 20]].concat());
    let alone = square_sums(&[later]);
    Ok(Case {
        naive: "every pixel of a record's spans is evaluated, live or not".into(),
        unit: "square sums after the end".into(),
        fails: Worst::of([20.0 * alone as f64]),
        bound: 0.0,
        from: "the mask of a row excludes pixels that have ended".into(),
        ours: Worst::of([(all - first) as f64]),
    })
}
