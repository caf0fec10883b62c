//! What the ports of the splat unit show in a cycle.

use potamoi_cycles::splat_unit::{SplatCounters, SplatOutputs};
use potamoi_formats::config::SuConfig;
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_reference::splat_unit::SplatPixel;

use super::beats::{Beat, pixel_of};
use crate::engine::Engine;
use crate::mismatch::Mismatch;
use crate::model::RtlError;
use crate::splat_beats::user_of;

/// Counters, as [`SplatCounters`] has them.
const STATS: [&str; 6] = [
    "busy",
    "records",
    "square_sums",
    "exponentials",
    "drawn",
    "stopped",
];

/// The flag of a record in a tile after the last one.
const DROPPED: u64 = 0b100;

/// Handles of the ports.
pub(super) struct Ports<P> {
    valid: P,
    ready: P,
    data: P,
    keep: P,
    last: P,
    user: P,
    given: P,
    sink: P,
    pixel: P,
    end: P,
    idle: P,
    errors: P,
    stats: [P; 6],
    words: Vec<u32>,
}

impl<P: Copy> Ports<P> {
    /// The ports of a unit.
    ///
    /// # Errors
    /// A unit without one of them.
    pub(super) fn of<E: Engine<Port = P>>(engine: &E) -> Result<Self, RtlError> {
        let input = |name: &str| engine.port(&format!("s_axis_spl_{name}"));
        let output = |name: &str| engine.port(&format!("m_axis_pix_{name}"));
        let stat = |name: &str| engine.port(&format!("stat_{name}"));
        let [busy, records, square_sums, exponentials, drawn, stopped] = STATS.map(stat);
        let pixel = output("tdata")?;
        Ok(Self {
            valid: input("tvalid")?,
            ready: input("tready")?,
            data: input("tdata")?,
            keep: input("tkeep")?,
            last: input("tlast")?,
            user: input("tuser")?,
            given: output("tvalid")?,
            sink: output("tready")?,
            pixel,
            end: output("tlast")?,
            idle: engine.port("idle")?,
            errors: stat("errors")?,
            stats: [
                busy?,
                records?,
                square_sums?,
                exponentials?,
                drawn?,
                stopped?,
            ],
            words: vec![0; engine.words(pixel)],
        })
    }

    /// Offers a beat, or none, and a sink that takes a pixel, or not.
    pub(super) fn offer<E: Engine<Port = P>>(
        &self,
        engine: &mut E,
        su: &SuConfig,
        beat: Option<Beat<'_>>,
        sink: bool,
    ) -> Result<(), RtlError> {
        engine.set(self.valid, u64::from(beat.is_some()))?;
        if let Some(beat) = beat {
            let (words, kept, ends) = beat.words();
            engine.set_words(self.data, &words)?;
            engine.set(self.keep, (1u64 << kept) - 1)?;
            engine.set(self.last, u64::from(ends))?;
            let user = beat.entry().map_or(0, |own| user_of(su, own));
            engine.set(self.user, user)?;
        }
        engine.set(self.sink, u64::from(sink))
    }

    /// What they show, after the engine has settled.
    pub(super) fn seen<E: Engine<Port = P>>(&mut self, engine: &E) -> Result<Seen, RtlError> {
        let pixel = match engine.get(self.given)? {
            0 => None,
            _ => {
                engine.get_words(self.pixel, &mut self.words)?;
                Some((pixel_of(&self.words), engine.get(self.end)? == 1))
            }
        };
        Ok(Seen {
            ready: engine.get(self.ready)? == 1,
            idle: engine.get(self.idle)? == 1,
            pixel,
            counters: counters_of(engine, self.stats)?,
            errors: engine.get(self.errors)?,
        })
    }
}

/// What the ports show in a cycle.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Seen {
    pub(super) ready: bool,
    idle: bool,
    pub(super) pixel: Option<(SplatPixel, bool)>,
    pub(super) counters: SplatCounters,
    pub(super) errors: u64,
}

impl From<SplatOutputs> for Seen {
    fn from(own: SplatOutputs) -> Self {
        Self {
            ready: own.ready,
            idle: own.idle,
            pixel: own.pixel,
            counters: own.counters,
            errors: if own.has_dropped { DROPPED } else { 0 },
        }
    }
}

impl Seen {
    /// What differs, the most telling first.
    pub(super) fn differing(&self, wanted: &Self, cycle: u64, place: String) -> Mismatch {
        let all = [
            (
                "m_axis_pix",
                [self, wanted].map(|own| format!("{:?}", own.pixel)),
            ),
            (
                "s_axis_spl_tready",
                [self, wanted].map(|own| own.ready.to_string()),
            ),
            (
                "stat_*",
                [self, wanted].map(|own| format!("{:?}", own.counters)),
            ),
            ("idle", [self, wanted].map(|own| own.idle.to_string())),
            (
                "stat_errors",
                [self, wanted].map(|own| format!("{:#b}", own.errors)),
            ),
        ];
        let differs = |(_, [found, expected]): &(_, [String; 2])| found != expected;
        let (signal, [found, expected]) = all.into_iter().find(differs).unwrap_or_default();
        Mismatch {
            module: SPLAT_UNIT,
            cycle,
            signal: signal.to_owned(),
            expected,
            found,
            place,
        }
    }
}

fn counters_of<E: Engine>(engine: &E, ports: [E::Port; 6]) -> Result<SplatCounters, RtlError> {
    let mut values = [0; 6];
    for (value, port) in values.iter_mut().zip(ports) {
        *value = engine.get(port)?;
    }
    let [busy, records, square_sums, exponentials, drawn, stopped] = values;
    Ok(SplatCounters {
        busy,
        records,
        square_sums,
        exponentials,
        drawn,
        stopped,
    })
}
