//! The gathering unit under random traffic.

use potamoi_cycles::work::RitBeat as BeatSize;
use potamoi_cycles::{FeatureMajorModel, GatherInputs, GatherModel, GatherOutputs, GatherWork};
use potamoi_formats::config::{Config, EntryKind, Organisation};
use potamoi_formats::rit::Vertices;
use potamoi_reference::gathering_unit::FLAG_TABLE;
use potamoi_reference::streams::{BlockStream, Packet, RitBeat, RitStream, frames};
use potamoi_rtl::InputBeat;
use potamoi_units::gathering_unit::gathering_unit;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::pins::Pins;
use super::traffic::{Traffic, WRONGS, Wrong, spoil};

/// Clocks without a handshake, everyone willing, after which a unit stands still: more
/// than the cycles of R entries that all wait for one bank.
const STILL: u32 = 1500;

/// Right traffic with beats that have no bytes: every bit and cycle.
pub(crate) fn right(config: &Config, seed: u64) -> Result<(), String> {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut pins = Pins::new(&gathering_unit(config).map_err(|e| e.to_string())?, seed);
    for takes_back in [false, true] {
        let traffic = Traffic::with_bare_beats(&mut random, config);
        into_reset(&mut pins, &traffic, &mut random)?;
        strict(&mut pins, config, &traffic, &mut random, takes_back, None)?;
    }
    Ok(())
}

/// Right traffic that a reset cuts off, and right traffic whose first beats wait
/// through the reset.
pub(crate) fn reset(config: &Config, seed: u64) -> Result<(), String> {
    let mut random = Pcg64Mcg::seed_from_u64(1000 + seed);
    let mut pins = Pins::new(&gathering_unit(config).map_err(|e| e.to_string())?, seed);
    for _ in 0..3 {
        let cut = Traffic::with_bare_beats(&mut random, config);
        into_reset(&mut pins, &cut, &mut random)?;
        let clocks = match random.random_range(0..3) {
            0 => random.random_range(0..20),
            _ => random.random_range(0..600),
        };
        strict(&mut pins, config, &cut, &mut random, false, Some(clocks))?;
    }
    let traffic = Traffic::with_bare_beats(&mut random, config);
    into_reset(&mut pins, &traffic, &mut random)?;
    strict(&mut pins, config, &traffic, &mut random, false, None)
}

/// One wrong thing: a flag, or frames that are right; and then a reset.
pub(crate) fn wrong(config: &Config, seed: u64) -> Result<(), String> {
    let mut random = Pcg64Mcg::seed_from_u64(2000 + seed);
    let mut pins = Pins::new(&gathering_unit(config).map_err(|e| e.to_string())?, seed);
    for _ in 0..2 {
        let mut traffic = Traffic::with_bare_beats(&mut random, config);
        let wrong = WRONGS[random.random_range(0..WRONGS.len())];
        let of_mft = wrong == Wrong::Rows || random.random_range(0..3) == 0;
        if of_mft {
            spoil(&mut random, &mut traffic.mft, wrong, 2 * config.gu.banks);
        } else {
            let bytes = config.rit_stream_bits() / 8;
            spoil(&mut random, &mut traffic.rit, wrong, bytes);
        }
        into_reset(&mut pins, &traffic, &mut random)?;
        let stream = if of_mft { "MFT" } else { "RIT" };
        judged(&mut pins, config, &traffic, &mut random)
            .map_err(|why| format!("{wrong:?} on the {stream} stream: {why}"))?;
    }
    let traffic = Traffic::plain(&mut random, config);
    into_reset(&mut pins, &traffic, &mut random)?;
    strict(&mut pins, config, &traffic, &mut random, false, None)
        .map_err(|why| format!("after a reset: {why}"))
}

/// Takes the unit into reset for some clocks while the traffic's first beats are
/// offered; no stream is ready, not even before the first edge. Leaves it as it comes
/// out.
fn into_reset(pins: &mut Pins, traffic: &Traffic, random: &mut Pcg64Mcg) -> Result<(), String> {
    pins.set("rst_n", 0);
    pins.set("m_axis_feat_tready", 0);
    offer(pins, "rit", traffic.rit.first());
    offer(pins, "mft", traffic.mft.first());
    for _ in 0..random.random_range(1..4) {
        pins.settle();
        for stream in ["rit", "mft"] {
            if pins.is(&format!("s_axis_{stream}_tready")) {
                return Err(format!("s_axis_{stream}_tready is high in reset"));
            }
        }
        pins.edge();
    }
    for (port, value) in &traffic.settings {
        pins.set(port, *value);
    }
    pins.set("rst_n", 1);
    Ok(())
}

fn offer(pins: &mut Pins, stream: &str, beat: Option<&InputBeat>) {
    let port = |what: &str| format!("s_axis_{stream}_{what}");
    pins.set(&port("tvalid"), u64::from(beat.is_some()));
    let Some(beat) = beat else { return };
    pins.set_words(&port("tdata"), &beat.data);
    pins.set(&port("tlast"), u64::from(beat.last));
    if !beat.keep.is_empty() {
        pins.set_words(&port("tkeep"), &beat.keep);
    }
    if stream == "rit" {
        pins.set(&port("tuser"), u64::from(beat.user));
    }
}

/// A stream's source.
struct Source<'a> {
    beats: &'a [InputBeat],
    next: usize,
    valid: bool,
    /// Of ten clocks, so many without a new offer.
    gaps: u32,
    takes_back: bool,
}

impl<'a> Source<'a> {
    fn new(beats: &'a [InputBeat], random: &mut Pcg64Mcg, takes_back: bool) -> Self {
        Self {
            beats,
            next: 0,
            valid: false,
            gaps: [0, 0, 3, 8][random.random_range(0..4)],
            takes_back,
        }
    }

    fn beat(&mut self, random: &mut Pcg64Mcg, eager: bool) -> Option<&'a InputBeat> {
        let willing = eager || random.random_range(0..10) >= self.gaps;
        self.valid = willing || self.valid && !self.takes_back;
        self.beats.get(self.next).filter(|_| self.valid)
    }

    fn accepted(&mut self) {
        self.next += 1;
        self.valid = false;
    }

    fn is_done(&self) -> bool {
        self.next == self.beats.len()
    }
}

/// What happens in a clock.
struct Clock<'a> {
    rit: Option<&'a InputBeat>,
    mft: Option<&'a InputBeat>,
    feat: bool,
    ready: bool,
}

/// Both sources and the sink.
struct Drive<'a> {
    rit: Source<'a>,
    mft: Source<'a>,
    sink_gaps: u32,
    still: u32,
}

impl<'a> Drive<'a> {
    fn new(traffic: &'a Traffic, random: &mut Pcg64Mcg, takes_back: bool) -> Self {
        Self {
            rit: Source::new(&traffic.rit, random, takes_back),
            mft: Source::new(&traffic.mft, random, takes_back),
            sink_gaps: [0, 0, 3, 8][random.random_range(0..4)],
            still: 0,
        }
    }

    /// Drives the ports and settles; `next` ends the clock.
    fn drive(&mut self, pins: &mut Pins, random: &mut Pcg64Mcg) -> Clock<'a> {
        let eager = self.still > 100;
        let clock = Clock {
            rit: self.rit.beat(random, eager),
            mft: self.mft.beat(random, eager),
            feat: false,
            ready: eager || random.random_range(0..10) >= self.sink_gaps,
        };
        offer(pins, "rit", clock.rit);
        offer(pins, "mft", clock.mft);
        pins.set("m_axis_feat_tready", u64::from(clock.ready));
        pins.settle();
        let feat = pins.is("m_axis_feat_tvalid");
        Clock { feat, ..clock }
    }

    /// Takes the edge; says which of the input beats were accepted.
    fn next(&mut self, pins: &mut Pins, clock: &Clock<'a>) -> [Option<&'a InputBeat>; 2] {
        let rit = clock.rit.filter(|_| pins.is("s_axis_rit_tready"));
        let mft = clock.mft.filter(|_| pins.is("s_axis_mft_tready"));
        rit.iter().for_each(|_| self.rit.accepted());
        mft.iter().for_each(|_| self.mft.accepted());
        let moves = rit.is_some() || mft.is_some() || clock.feat && clock.ready;
        self.still = if moves { 0 } else { self.still + 1 };
        pins.edge();
        [rit, mft]
    }
}

/// The stepwise model of a unit.
enum Model {
    ChannelMajor(GatherModel),
    FeatureMajor(FeatureMajorModel),
}

impl Model {
    fn new(config: &Config, traffic: &Traffic) -> Self {
        let work = GatherWork::new(config, &traffic.tasks).unwrap();
        match (work.lane_run(), work.split_run()) {
            (Some(lanes), _) => Self::FeatureMajor(FeatureMajorModel::new(config, &lanes).unwrap()),
            (_, Some(split)) => Self::ChannelMajor(GatherModel::of_turns(config, &split).unwrap()),
            _ => Self::ChannelMajor(
                GatherModel::new(config, traffic.vertices, traffic.segments).unwrap(),
            ),
        }
    }

    fn is_idle(&self) -> bool {
        match self {
            Self::ChannelMajor(model) => model.is_idle(),
            Self::FeatureMajor(model) => model.is_idle(),
        }
    }

    fn step(&mut self, inputs: &GatherInputs) -> GatherOutputs {
        match self {
            Self::ChannelMajor(model) => model.step(inputs),
            Self::FeatureMajor(model) => model.step(inputs),
        }
    }
}

fn size(beat: &InputBeat) -> BeatSize {
    BeatSize {
        halfwords: beat.keep.iter().map(|w| w.count_ones()).sum::<u32>() / 2,
        last: beat.last,
        again: beat.user,
    }
}

/// Whether a beat of the MFT stream has rows, or ends its MVoxel.
fn counts(beat: &&InputBeat) -> bool {
    beat.last || beat.keep.is_empty() || beat.keep.iter().any(|w| *w != 0)
}

/// Every bit and cycle, until all is taken or for so many clocks.
fn strict(
    pins: &mut Pins,
    config: &Config,
    traffic: &Traffic,
    random: &mut Pcg64Mcg,
    takes_back: bool,
    clocks: Option<u64>,
) -> Result<(), String> {
    let mut drive = Drive::new(traffic, random, takes_back);
    let mut model = Model::new(config, traffic);
    let mut wanted = traffic.wanted.iter();
    let mut next = wanted.next();
    let mut quiet = 0;
    for cycle in 0.. {
        if clocks == Some(cycle) {
            return Ok(());
        }
        quiet = match next {
            None if drive.rit.is_done() && drive.mft.is_done() => quiet + 1,
            _ => 0,
        };
        if quiet == 40 {
            break;
        }
        let at = |what: &str| format!("clock {cycle}: {what}");
        let clock = drive.drive(pins, random);
        let idle = model.is_idle();
        let said = model.step(&GatherInputs {
            rit: clock.rit.map(size),
            // A beat without rows is none, unless it ends the MVoxel.
            mft: clock.mft.filter(counts).map(|beat| beat.last),
            feat_ready: clock.ready,
        });
        for (port, found, expected) in [
            (
                "s_axis_rit_tready",
                pins.is("s_axis_rit_tready"),
                said.rit_ready,
            ),
            (
                "s_axis_mft_tready",
                pins.is("s_axis_mft_tready"),
                said.mft_ready,
            ),
            ("m_axis_feat_tvalid", clock.feat, said.feat.is_some()),
            ("idle", pins.is("idle"), idle),
        ] {
            if found != expected {
                return Err(at(&format!(
                    "{port} is {found}, by the cycle model {expected}"
                )));
            }
        }
        for (port, expected) in [
            ("stat_busy", said.counters.busy),
            ("stat_stall_fifo", said.counters.stall_fifo),
            ("stat_stall_mft", said.counters.stall_mft),
            ("stat_stall_rit", said.counters.stall_rit),
            ("stat_entries", said.counters.entries),
            ("stat_errors", 0),
        ] {
            let found = pins.get(port);
            if found != expected {
                return Err(at(&format!("{port} is {found}, expected {expected}")));
            }
        }
        if clock.feat {
            let beat = next.ok_or_else(|| at("a beat of features too many"))?;
            same_beat(pins, beat, traffic.slot_bits).map_err(|why| at(&why))?;
            if clock.ready {
                next = wanted.next();
            }
        }
        drive.next(pins, &clock);
        if drive.still > STILL && quiet == 0 {
            let left = wanted.len() + usize::from(next.is_some());
            return Err(at(&format!(
                "stands still, {left} beats of features to come"
            )));
        }
    }
    Ok(())
}

/// The beat on the ports against the one that must come.
fn same_beat(pins: &Pins, beat: &potamoi_rtl::FeatureBeat, slot_bits: u32) -> Result<(), String> {
    let last = pins.is("m_axis_feat_tlast");
    if last != beat.last {
        return Err(format!(
            "m_axis_feat_tlast is {last}, expected {}",
            beat.last
        ));
    }
    let keep = pins.words("m_axis_feat_tkeep");
    if keep != beat.keep {
        return Err(format!(
            "m_axis_feat_tkeep is {keep:x?}, expected {:x?}",
            beat.keep
        ));
    }
    let data = pins.words("m_axis_feat_tdata");
    let bits = data.iter().zip(&beat.data).zip(&beat.mask);
    if bits
        .into_iter()
        .any(|((found, wanted), mask)| (found ^ wanted) & mask != 0)
    {
        return Err(format!(
            "m_axis_feat_tdata is {data:x?}, expected {:x?}",
            beat.data
        ));
    }
    let slots = slots(pins, beat.slots.len(), slot_bits);
    match slots == beat.slots {
        true => Ok(()),
        false => Err(format!("slots {slots:?}, expected {:?}", beat.slots)),
    }
}

/// The first slots of `tuser`.
fn slots(pins: &Pins, count: usize, slot_bits: u32) -> Vec<u32> {
    let user = pins.words("m_axis_feat_tuser");
    let slot = |i: usize| match slot_bits {
        32 => user[i],
        _ => user[i / 2] >> (16 * (i % 2)) & 0xffff,
    };
    (0..count).map(slot).collect()
}

/// A beat of features as far as its frame says.
#[derive(Debug, PartialEq, Eq)]
struct Frame {
    slots: Vec<u32>,
    last: bool,
}

/// What the streams say of themselves, as they were accepted.
struct Judge<'a> {
    config: &'a Config,
    vertices: Vertices,
    segments: u32,
    channels_of_last: usize,
    rit: RitStream,
    blocks: BlockStream,
    rows: u32,
    /// Passes that packets ask for, and packets of the MFT stream.
    passes: Vec<Packet>,
    begun: bool,
    loads: usize,
    flags: u8,
}

impl<'a> Judge<'a> {
    fn new(config: &'a Config, traffic: &Traffic) -> Self {
        let channels = traffic
            .settings
            .iter()
            .find(|(port, _)| *port == "cfg_channels");
        Self {
            config,
            vertices: traffic.vertices,
            segments: traffic.segments,
            channels_of_last: channels.map_or(0, |(_, n)| *n as usize),
            rit: RitStream::new(config, traffic.vertices, traffic.segments),
            blocks: BlockStream::default(),
            rows: 0,
            passes: vec![],
            begun: false,
            loads: 0,
            flags: 0,
        }
    }

    /// Channels of a beat of features' pass.
    fn channels(&self, pass: usize) -> usize {
        let is_last = (pass + 1).is_multiple_of(self.segments as usize);
        match (self.config.organisation().0, is_last) {
            (Organisation::FeatureMajor, true) => self.channels_of_last,
            (Organisation::FeatureMajor, false) => self.config.gu.banks as usize,
            _ => 1,
        }
    }

    fn take_rit(&mut self, beat: &InputBeat) {
        let bytes: Vec<u8> = beat.data.iter().flat_map(|w| w.to_le_bytes()).collect();
        let bit = |i: usize| beat.keep[i / 32] >> (i % 32) & 1 == 1;
        let keep: Vec<bool> = (0..bytes.len()).map(bit).collect();
        let (flags, packet) = self.rit.take(&RitBeat {
            bytes: &bytes,
            keep: &keep,
            last: beat.last,
            user: beat.user,
        });
        self.flags |= flags;
        self.begun = packet.is_none() && (self.begun || keep.contains(&true));
        if let Some(packet) = packet {
            let times = if packet.streamed {
                1
            } else {
                self.segments as usize
            };
            self.passes.extend(vec![packet; times]);
        }
    }

    fn take_mft(&mut self, beat: &InputBeat) {
        let wrong = match self.config.organisation().0 {
            Organisation::FeatureMajor => {
                let banks = self.config.gu.banks as usize;
                let bit = |i: usize| beat.keep[i / 32] >> (i % 32) & 1 == 1;
                let keep: Vec<bool> = (0..2 * banks).map(bit).collect();
                let most = self.config.mvoxel.rows / self.config.gu.banks;
                let channels = self.channels(self.loads);
                self.blocks.take(&keep, beat.last, channels, most)
            }
            _ => {
                self.rows += 1;
                self.rows > self.config.mft_rows()
            }
        };
        if wrong {
            self.flags |= FLAG_TABLE;
        }
        if beat.last {
            self.rows = 0;
            self.loads += 1;
        }
    }

    /// The frames of complete passes.
    fn frames(&self) -> Vec<Frame> {
        let side = match self.config.organisation().0 {
            Organisation::FeatureMajor => self.config.gu.lanes,
            _ => self.config.gu.ports,
        };
        let size = self.config.entry_bytes(self.vertices);
        let at = match (self.vertices, self.config.rit.entry) {
            (Vertices::One, _) | (_, EntryKind::Paper) => 2,
            (_, EntryKind::Compact) => 6,
        };
        let mut found = vec![];
        for (pass, packet) in self.passes.iter().take(self.loads).enumerate() {
            let slot = |entry: usize| {
                let from = entry * size + at;
                u32::from(u16::from_le_bytes([
                    packet.bytes[from],
                    packet.bytes[from + 1],
                ]))
            };
            let channels = self.channels(pass);
            for frame in frames(packet.bytes.len() / size, side as usize, packet.ends_null) {
                for channel in 0..channels {
                    found.push(Frame {
                        slots: (frame.first..frame.first + frame.kept).map(slot).collect(),
                        last: frame.last && channel + 1 == channels,
                    });
                }
            }
        }
        found
    }
}

/// The flag that the streams ask for, in the clock behind the beat; or, as long as no
/// flag is up, the frames that they ask for, and no standstill that they do not.
fn judged(
    pins: &mut Pins,
    config: &Config,
    traffic: &Traffic,
    random: &mut Pcg64Mcg,
) -> Result<(), String> {
    let mut drive = Drive::new(traffic, random, false);
    let mut judge = Judge::new(config, traffic);
    let mut seen: Vec<Frame> = vec![];
    let bytes = pins.words("m_axis_feat_tkeep").len();
    let entry = config.feature_lane_bits() as usize / 8;
    let entry = entry
        * if config.organisation().0 == Organisation::FeatureMajor {
            1
        } else {
            config.lanes_a_port() as usize
        };
    for cycle in 0.. {
        let clock = drive.drive(pins, random);
        let flags = pins.get("stat_errors") as u16;
        // A spoilt beat may ask for several: one is enough.
        if judge.flags != 0 && u16::from(judge.flags) & flags == 0 {
            let asked = judge.flags;
            return Err(format!(
                "clock {cycle}: flags {flags:#x}, the beats ask for {asked:#x}"
            ));
        }
        let of_entries = 0b1000_0111;
        if judge.flags == 0 && flags & !of_entries != 0 {
            return Err(format!(
                "clock {cycle}: flags {flags:#x} that no beat asks for"
            ));
        }
        if flags != 0 {
            // What comes is not defined. It must not be for ever in the way of a reset.
            return Ok(());
        }
        if clock.feat && clock.ready {
            let keep = pins.words("m_axis_feat_tkeep");
            let kept = (0..32 * bytes)
                .filter(|i| keep[i / 32] >> (i % 32) & 1 == 1)
                .count();
            seen.push(Frame {
                slots: slots(pins, kept / entry, traffic.slot_bits),
                last: pins.is("m_axis_feat_tlast"),
            });
        }
        let [rit, mft] = drive.next(pins, &clock);
        rit.into_iter().for_each(|beat| judge.take_rit(beat));
        mft.into_iter().for_each(|beat| judge.take_mft(beat));
        if drive.still > STILL {
            break;
        }
    }
    let wanted = judge.frames();
    if let Some(at) = wanted.iter().zip(&seen).position(|(w, s)| w != s) {
        return Err(format!(
            "beat {at} is {:?}, expected {:?}",
            seen[at], wanted[at]
        ));
    }
    if seen.len() < wanted.len() {
        return Err(format!(
            "stands still behind {} of {} beats",
            seen.len(),
            wanted.len()
        ));
    }
    if seen.len() > wanted.len() && !judge.begun {
        return Err(format!("{} beats, expected {}", seen.len(), wanted.len()));
    }
    // A table that is not loaded holds up entries; entries that do not come, a table.
    let (asked, loads) = (judge.passes.len() + usize::from(judge.begun), judge.loads);
    if !drive.rit.is_done() && asked <= loads {
        return Err("takes no further entries, and nothing is missing".to_owned());
    }
    if !drive.mft.is_done() && loads < judge.passes.len() + 2 {
        return Err("takes no further rows, and nothing is missing".to_owned());
    }
    Ok(())
}
