//! Drives the gathering unit's ports, cycle by cycle.

use potamoi_cycles::{BeatWords, GatherInputs, GatherWork, Plan, Source};
use potamoi_formats::config::Config;
use potamoi_formats::units::GATHERING_UNIT;

use super::engine::{Engine, Job};
use super::model::RtlError;
use super::post_failure_window::PostFailureWindow;

/// Cycles without a handshake after which a unit counts as hanging: more than any plan's stalls are
/// likely to last.
const PATIENCE: u64 = 20_000;

/// Outputs of the unit in one cycle.
pub(super) struct GatherSeen<'a> {
    pub(super) rit_ready: bool,
    pub(super) mft_ready: bool,
    pub(super) idle: bool,
    /// The beat of features, if valid.
    pub(super) beat: Option<BeatSeen<'a>>,
    /// Busy; stalls for FIFO, MFT, RIT; entries; stalls for banks.
    pub(super) counters: [u64; 6],
}

/// A beat of features on the ports.
#[derive(Clone, Copy)]
pub(super) struct BeatSeen<'a> {
    pub(super) data: &'a [u32],
    /// Unknown bits of `data`, neither 0 nor 1.
    pub(super) unknown: Option<&'a [u32]>,
    pub(super) keep: &'a [u32],
    pub(super) user: &'a [u32],
    pub(super) last: bool,
}

/// Observer, called once per simulated cycle.
pub(super) trait GatherWatch {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &GatherInputs,
        seen: &GatherSeen<'_>,
    ) -> Result<(), RtlError>;
}

/// Cycles and counters of a run.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct GatherTotals {
    /// Cycles until the last beat was accepted.
    pub cycles: u64,
    /// Cycle of the first accepted beat of the RIT stream.
    pub first_beat: u64,
    /// Cycle of the first issue, by the unit's counter.
    pub first_issue: u64,
    /// Cycle in which the first beat of features was offered.
    pub first_feature: u64,
    /// Busy cycles, in which a vertex is issued, by the unit's counter.
    pub busy: u64,
    /// Stall cycles by the unit's counters: FIFO full, no MVoxel, no entry.
    pub stalls: [u64; 3],
    /// Cycles in which lanes waited for a bank or ports for their turn, by the unit's counter; 0
    /// where none can wait.
    pub stall_bank: u64,
    /// Entries issued, counted for each segment, by the unit's counter.
    pub entries: u64,
    /// Its sticky flags.
    pub errors: u64,
}

impl GatherTotals {
    /// Notes the first issue and the first beat of features. A counter shows what happened up to
    /// the cycle before.
    const fn note_first(&mut self, cycle: u64, counters: [u64; 6], valid: bool) {
        let [busy, _, _, _, _, bank] = counters;
        if (busy != 0 || bank != 0) && self.first_issue == 0 {
            // A counter that counts from the first cycle on is wrong, and not refused here.
            self.first_issue = cycle.saturating_sub(1);
        }
        if valid && self.first_feature == 0 {
            self.first_feature = cycle;
        }
    }

    /// Reads the unit's counters and flags at the end of a run.
    fn read<E: Engine>(&mut self, ports: &Ports<E::Port>, engine: &mut E) -> Result<(), RtlError> {
        let [busy, fifo, mft, rit, entries, bank] = ports.counters(engine)?;
        self.busy = busy;
        self.stalls = [fifo, mft, rit];
        self.stall_bank = bank;
        self.entries = entries;
        self.errors = engine.get(ports.errors)?;
        Ok(())
    }

    /// Cycles from the first to the last issue, inclusive.
    #[must_use]
    pub fn issue_span(&self) -> u64 {
        self.busy + self.stalls.iter().sum::<u64>() + self.stall_bank
    }
}

/// Ports of an AXI4-Stream that every organisation has.
#[derive(Clone, Copy)]
struct Stream<P> {
    valid: P,
    ready: P,
    data: P,
    last: P,
}

/// Ports of a stream with bytes that are kept and a sideband.
#[derive(Clone, Copy)]
struct MarkedStream<P> {
    stream: Stream<P>,
    keep: P,
    user: P,
}

struct Ports<P> {
    rit: MarkedStream<P>,
    mft: Stream<P>,
    feat: MarkedStream<P>,
    counters: [P; 5],
    /// Counter of bank stalls, where they are possible.
    bank: Option<P>,
    /// The MFT stream's keep, of the feature-major organisation.
    mft_keep: Option<P>,
    errors: P,
    idle: P,
}

impl<P: Copy> Stream<P> {
    fn find(engine: &impl Engine<Port = P>, name: &str) -> Result<Self, RtlError> {
        let port = |signal: &str| engine.port(&format!("{name}_{signal}"));
        Ok(Self {
            valid: port("tvalid")?,
            ready: port("tready")?,
            data: port("tdata")?,
            last: port("tlast")?,
        })
    }
}

impl<P: Copy> MarkedStream<P> {
    fn find(engine: &impl Engine<Port = P>, name: &str) -> Result<Self, RtlError> {
        Ok(Self {
            stream: Stream::find(engine, name)?,
            keep: engine.port(&format!("{name}_tkeep"))?,
            user: engine.port(&format!("{name}_tuser"))?,
        })
    }
}

impl<P: Copy> Ports<P> {
    fn counters(&self, engine: &mut impl Engine<Port = P>) -> Result<[u64; 6], RtlError> {
        let mut counters = [0; 6];
        for (value, port) in counters
            .iter_mut()
            .zip(self.counters.into_iter().chain(self.bank))
        {
            *value = engine.get(port)?;
        }
        Ok(counters)
    }

    /// Drives a beat of the RIT stream.
    fn show_rit(
        &self,
        engine: &mut impl Engine<Port = P>,
        words: &BeatWords<'_>,
        [last, again]: [bool; 2],
    ) -> Result<(), RtlError> {
        engine.set_words(self.rit.stream.data, &words.data)?;
        engine.set_words(self.rit.keep, &words.keep)?;
        engine.set(self.rit.stream.last, u64::from(last))?;
        engine.set(self.rit.user, u64::from(again))
    }

    /// Drives a row of the MFT stream.
    fn show_mft(
        &self,
        engine: &mut impl Engine<Port = P>,
        words: &BeatWords<'_>,
        last: bool,
    ) -> Result<(), RtlError> {
        engine.set_words(self.mft.data, &words.row)?;
        engine.set(self.mft.last, u64::from(last))?;
        match self.mft_keep {
            Some(keep) => engine.set_words(keep, &words.row_keep),
            None => Ok(()),
        }
    }

    /// The beat of features on the output; `words` receives its data, keep and user.
    fn beat<'a>(
        &self,
        engine: &'a impl Engine<Port = P>,
        words: &'a mut [Vec<u32>; 3],
    ) -> Result<BeatSeen<'a>, RtlError> {
        let [data, keep, user] = words;
        engine.get_words(self.feat.stream.data, data)?;
        engine.get_words(self.feat.keep, keep)?;
        engine.get_words(self.feat.user, user)?;
        Ok(BeatSeen {
            data,
            unknown: engine.unknown(self.feat.stream.data),
            keep,
            user,
            last: engine.get(self.feat.stream.last)? == 1,
        })
    }

    fn find(engine: &impl Engine<Port = P>, work: &GatherWork<'_>) -> Result<Self, RtlError> {
        let lanes = work.lane_run().is_some();
        let waits = lanes || work.split_run().is_some();
        let stat = |name: &str| engine.port(&format!("stat_{name}"));
        Ok(Self {
            rit: MarkedStream::find(engine, "s_axis_rit")?,
            mft: Stream::find(engine, "s_axis_mft")?,
            feat: MarkedStream::find(engine, "m_axis_feat")?,
            counters: [
                stat("busy")?,
                stat("stall_fifo")?,
                stat("stall_mft")?,
                stat("stall_rit")?,
                stat("entries")?,
            ],
            bank: waits.then(|| stat("stall_bank")).transpose()?,
            mft_keep: lanes.then(|| engine.port("s_axis_mft_tkeep")).transpose()?,
            errors: stat("errors")?,
            idle: engine.port("idle")?,
        })
    }
}

/// Holds all streams inactive, and sets the unit up for a kind of work.
fn configure<E: Engine>(
    engine: &mut E,
    p: &Ports<E::Port>,
    work: &GatherWork<'_>,
    config: &Config,
) -> Result<(), RtlError> {
    for port in [p.rit.stream.valid, p.mft.valid, p.feat.stream.ready] {
        engine.set(port, 0)?;
    }
    for (name, value) in [
        ("cfg_clear", 0),
        ("cfg_vertices", u64::from(work.vertices().log2())),
        ("cfg_segments", work.segments() as u64),
    ] {
        let port = engine.port(name)?;
        engine.set(port, value)?;
    }
    if config.gu.records_a_row == 2 {
        let port = engine.port("cfg_two_records")?;
        engine.set(port, u64::from(work.shares_rows()))?;
    }
    if work.lane_run().is_some() {
        let port = engine.port("cfg_channels")?;
        engine.set(port, work.last_channels() as u64)?;
    }
    Ok(())
}

/// One run on any engine.
pub(super) struct Drive<'a, W> {
    pub(super) config: &'a Config,
    pub(super) work: &'a GatherWork<'a>,
    pub(super) plan: Plan,
    /// Cycles observed after the last beat.
    pub(super) drain: u64,
    pub(super) watch: &'a mut W,
}

impl<W: GatherWatch> Job for Drive<'_, W> {
    type Output = GatherTotals;

    fn run<E: Engine>(self, engine: &mut E) -> Result<GatherTotals, RtlError> {
        let Self {
            config,
            work,
            mut plan,
            drain,
            watch,
        } = self;
        let p = Ports::find(engine, work)?;
        configure(engine, &p, work, config)?;
        engine.reset()?;
        let run = work.run();
        let mut rit = Source::new(run.rit_beats(config));
        let mut mft = Source::new(work.mft_pieces(config));
        let mut layout = BeatWords::new(work);
        let mut beat_words =
            [p.feat.stream.data, p.feat.keep, p.feat.user].map(|port| vec![0; engine.words(port)]);
        let beats = work.beats();
        let mut totals = GatherTotals::default();
        let (mut sent, mut taken, mut idle, mut left) = (0u64, 0u64, 0, drain);
        let (mut rit_shown, mut mft_shown) = (false, false);
        for cycle in 0.. {
            if taken == beats {
                if left == 0 {
                    break;
                }
                left -= 1;
            }
            let willing = plan.step();
            let rit_piece = rit.offer(willing.rit).copied();
            let mft_piece = mft.offer(willing.mft).copied();
            engine.set(p.rit.stream.valid, u64::from(rit_piece.is_some()))?;
            engine.set(p.mft.valid, u64::from(mft_piece.is_some()))?;
            engine.set(p.feat.stream.ready, u64::from(willing.sink))?;
            if let Some(piece) = rit_piece.filter(|_| !rit_shown) {
                layout.rit(&piece)?;
                p.show_rit(engine, &layout, [piece.beat.last, piece.beat.again])?;
                rit_shown = true;
            }
            if let Some(piece) = mft_piece.filter(|_| !mft_shown) {
                layout.mft(&piece);
                p.show_mft(engine, &layout, piece.last)?;
                mft_shown = true;
            }
            engine.settle()?;
            let inputs = GatherInputs {
                rit: rit_piece.map(|piece| piece.beat),
                mft: mft_piece.map(|piece| piece.last),
                feat_ready: willing.sink,
            };
            let valid = engine.get(p.feat.stream.valid)? == 1;
            let counters = p.counters(engine)?;
            totals.note_first(cycle, counters, valid);
            let beat = match valid {
                true => Some(p.beat(engine, &mut beat_words)?),
                false => None,
            };
            let seen = GatherSeen {
                rit_ready: engine.get(p.rit.stream.ready)? == 1,
                mft_ready: engine.get(p.mft.ready)? == 1,
                idle: engine.get(p.idle)? == 1,
                beat,
                counters,
            };
            let rit_moves = rit_piece.is_some() && seen.rit_ready;
            let mft_moves = mft_piece.is_some() && seen.mft_ready;
            let feature_moves = valid && willing.sink;
            watch.cycle(cycle, &inputs, &seen)?;
            if rit_moves {
                if sent == 0 {
                    totals.first_beat = cycle;
                }
                rit.accepted();
                rit_shown = false;
                sent += 1;
            }
            if mft_moves {
                mft.accepted();
                mft_shown = false;
            }
            if feature_moves {
                taken += 1;
                totals.cycles = cycle + 1;
            }
            engine.edge()?;
            let moves = rit_moves || mft_moves || feature_moves;
            idle = if moves { 0 } else { idle + 1 };
            if idle > PATIENCE.max(drain) {
                return Err(RtlError::Hang {
                    unit: GATHERING_UNIT,
                    cycles: idle,
                    state: format!("{sent} RIT beats accepted, {taken} of {beats} feature beats"),
                });
            }
        }
        engine.settle()?;
        totals.read(&p, engine)?;
        Ok(totals)
    }
}

impl<W: GatherWatch> GatherWatch for PostFailureWindow<W> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &GatherInputs,
        seen: &GatherSeen<'_>,
    ) -> Result<(), RtlError> {
        self.after(|w| w.cycle(cycle, inputs, seen))
    }
}
