//! Jobs of the splat unit as beats.

use std::collections::BTreeMap;

use potamoi_cycles::splat_unit::{SplatBeat, SplatModel};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::{ReferenceSplatUnit, SplatEntry, SplatPixel, TILE_PIXELS};

use super::beat::Beat;
use super::garbage::Garbage;
use super::job::Job;
use super::script::{Clock, Script, keep_of};
use super::splat_jobs::Records;
use crate::RtlError;
use crate::splat_beats::{RECORD_BYTES, WORD_BYTES, data_of, limit_words, user_of};

/// Clocks of the bench from a reset to the first beat; counters are cleared in the one before the last.
const BEFORE: usize = 3;
/// Cycles after which a model counts as hanging.
const PATIENCE: u64 = 1_000_000;

/// Flags of `stat_errors`.
const TORN: u64 = 1;
const MOVED: u64 = 2;
const DROPPED: u64 = 4;

/// Counters that gaps do not change: when a pixel ends decides which later pairs are computed in vain.
pub(super) const STEADY: [&str; 4] = ["stat_records", "stat_drawn", "stat_stopped", "stat_errors"];

/// The jobs of a bench, one after the other, from a reset.
///
/// # Errors
/// A model that hangs.
pub(super) fn jobs(
    config: &Config,
    su: &SuConfig,
    all: &[Records],
    garbage: &mut Garbage,
) -> Result<Vec<Job>, RtlError> {
    let mut made = vec![];
    for (i, own) in all.iter().enumerate() {
        let input = beats(config, own);
        let (cycles, stats) = run(config, su, own, i == 0)?;
        let mut beats = vec![];
        for beat in &input {
            beats.push(input_beat(su, *beat, garbage));
        }
        made.push(Job {
            title: own.title.clone(),
            settings: settings(own),
            inputs: vec![beats],
            output: pixels(config, own)
                .iter()
                .enumerate()
                .map(|(at, pixel)| output_beat(pixel, at + 1 == own.pixels()))
                .collect(),
            closed: own.closed,
            cycles,
            stats,
        });
    }
    Ok(made)
}

/// A beat of the input.
#[derive(Clone, Copy)]
enum Input<'a> {
    Limit(u32),
    Record(&'a SplatEntry),
    Nothing,
}

fn beats<'a>(config: &Config, own: &'a Records) -> Vec<(Input<'a>, bool)> {
    let limits = limit_words(config, &own.settings);
    let mut beats: Vec<_> = limits
        .into_iter()
        .map(|word| (Input::Limit(word), false))
        .collect();
    for (i, entry) in own.entries.iter().enumerate() {
        // Now and then a beat without bytes, which is ignored.
        if i % 7 == 3 {
            beats.push((Input::Nothing, false));
        }
        beats.push((Input::Record(entry), false));
    }
    match own.entries.last() {
        Some(_) if own.ends_null => beats.push((Input::Nothing, true)),
        None => beats.push((Input::Nothing, true)),
        Some(_) => {
            if let Some(last) = beats.last_mut() {
                last.1 = true;
            }
        }
    }
    beats
}

fn input_beat(su: &SuConfig, (input, last): (Input<'_>, bool), garbage: &mut Garbage) -> Beat {
    let (mut data, kept, user) = match input {
        Input::Limit(word) => (vec![word, 0, 0, 0, 0, 0, 0, 0], WORD_BYTES, 0),
        Input::Nothing => (vec![0; 8], 0, 0),
        Input::Record(entry) => (data_of(entry), RECORD_BYTES, user_of(su, entry)),
    };
    let keep = keep_of(RECORD_BYTES, |byte| byte < kept);
    garbage.fill(&mut data, &keep, 8);
    Beat::from([
        ("tdata", data),
        ("tkeep", keep),
        ("tlast", vec![u32::from(last)]),
        ("tuser", vec![user as u32, (user >> 32) as u32]),
    ])
}

/// A pixel as words: 24 bits of transmittance, 40 of each colour sum.
fn output_beat(pixel: &SplatPixel, last: bool) -> Beat {
    let [red, green, blue] = pixel.colour.map(u128::from);
    let all = u128::from(pixel.transmittance) | red << 24 | green << 64 | blue << 104;
    let high = (blue >> 24) as u32;
    let words = [0, 32, 64, 96].map(|low| (all >> low) as u32);
    Beat::from([
        ("tlast", vec![u32::from(last)]),
        ("tdata", [&words[..], &[high]].concat()),
    ])
}

fn settings(own: &Records) -> Vec<(&'static str, u64)> {
    let thresholds = &own.settings.thresholds;
    vec![
        ("cfg_alpha_cap", u64::from(thresholds.alpha_cap)),
        ("cfg_alpha_min", u64::from(thresholds.alpha_min)),
        ("cfg_stop_below", thresholds.stop),
        ("cfg_centred", u64::from(own.settings.is_centred)),
        ("cfg_last_slot", u64::from(own.last_slot)),
    ]
}

/// Pixels, by the reference unit.
fn pixels(config: &Config, own: &Records) -> Vec<SplatPixel> {
    let slots = usize::from(own.last_slot) + 1;
    let mut twin = ReferenceSplatUnit::new(&config.vu.exp, slots, own.settings);
    own.entries.iter().for_each(|entry| twin.composite(entry));
    SplatPixel::of_tiles(twin.tiles()).collect()
}

/// Cycles and counters by the stepwise model.
fn run(
    config: &Config,
    su: &SuConfig,
    own: &Records,
    is_first: bool,
) -> Result<(u64, BTreeMap<&'static str, u64>), RtlError> {
    let last_slot = usize::from(own.last_slot);
    let mut model = SplatModel::new(config, su, own.settings, last_slot)?;
    let mut wait = BEFORE;
    if !is_first {
        // The pixels are clear.
        wait = su.tiles as usize * TILE_PIXELS + BEFORE;
    }
    for _ in 0..wait {
        model.step(None, false);
    }
    let all = beats(config, own);
    let (mut next, mut cycles) = (0, 0);
    loop {
        let beat = all.get(next).map(|(input, last)| match input {
            Input::Record(entry) => SplatBeat::Record(entry, *last),
            Input::Limit(_) | Input::Nothing => SplatBeat::Other(*last),
        });
        let sink = cycles >= u64::from(own.closed);
        let outputs = model.step(beat, sink);
        next += usize::from(beat.is_some() && outputs.ready);
        cycles += 1;
        if sink && outputs.pixel.is_some_and(|(_, is_last)| is_last) {
            break;
        }
        if cycles > PATIENCE {
            return Err(potamoi_cycles::WorkError::Deadlock { cycle: cycles }.into());
        }
    }
    let ended = model.step(None, false);
    let counters = ended.counters;
    let stats = BTreeMap::from([
        ("stat_busy", counters.busy),
        ("stat_records", counters.records),
        ("stat_square_sums", counters.square_sums),
        ("stat_exponentials", counters.exponentials),
        ("stat_drawn", counters.drawn),
        ("stat_stopped", counters.stopped),
        ("stat_errors", if ended.has_dropped { DROPPED } else { 0 }),
    ]);
    Ok((cycles, stats))
}

/// Beats and settings that break promises: bytes that are neither a record nor a word, a setting that
/// moves while a job is open, and a record in a tile after the last one.
pub(super) fn script(su: &SuConfig) -> Script {
    let normal = |cap: u64| {
        vec![
            ("cfg_alpha_cap", cap),
            ("cfg_alpha_min", 1),
            ("cfg_stop_below", 1),
            ("cfg_centred", 0),
            ("cfg_last_slot", 0),
        ]
    };
    let clock = |beat: Option<Vec<u32>>, cap: u64, up: u64| Clock {
        beats: vec![
            beat.map(|keep| Beat::from([("tkeep", keep), ("tlast", vec![0]), ("tuser", vec![0])])),
        ],
        settings: normal(cap),
        up,
        down: !up & (TORN | MOVED | DROPPED),
        ..Clock::default()
    };
    let reset = Clock {
        reset: true,
        ..clock(None, 0, 0)
    };
    let cleared = Clock {
        times: su.tiles * TILE_PIXELS as u32 + 2,
        ..clock(None, 0, 0)
    };
    let mut clocks = vec![];
    for kept in (0..=RECORD_BYTES).filter(|kept| ![0, WORD_BYTES, RECORD_BYTES].contains(kept)) {
        let keep = keep_of(RECORD_BYTES, |byte| byte < kept);
        clocks.extend([reset.clone(), cleared.clone()]);
        clocks.push(clock(Some(keep), 0, TORN));
        clocks.push(clock(None, 0, TORN));
    }
    let hole = keep_of(RECORD_BYTES, |byte| byte != 9);
    clocks.extend([reset.clone(), cleared.clone(), clock(Some(hole), 0, TORN)]);
    // A setting may move before a job, and not within it.
    clocks.extend([reset.clone(), cleared.clone(), clock(None, 5, 0)]);
    clocks.push(clock(Some(keep_of(RECORD_BYTES, |_| false)), 5, 0));
    clocks.push(clock(None, 5, 0));
    clocks.push(clock(None, 6, MOVED));
    clocks.push(clock(None, 6, MOVED));
    clocks.push(Clock {
        clear: true,
        ..clock(None, 6, 0)
    });
    clocks.push(clock(None, 6, 0));
    let record_in = |slot: u32, up: u64| Clock {
        beats: vec![Some(Beat::from([
            ("tkeep", keep_of(RECORD_BYTES, |_| true)),
            ("tlast", vec![0]),
            ("tuser", vec![slot]),
        ]))],
        ..clock(None, 0, up)
    };
    // Tile 0 is given, and tile 1 is not.
    for (slot, up) in [(0, 0), (1, DROPPED)] {
        clocks.extend([reset.clone(), cleared.clone()]);
        clocks.extend([record_in(slot, up), clock(None, 0, up)]);
    }
    Script { clocks }
}
