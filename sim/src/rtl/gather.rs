//! Drives the Verilated gathering unit.

use potamoi_formats::config::Config;
use potamoi_golden::units::GatherTask;
use potamoi_hdl::gu::gathering_unit;
use potamoi_verilated::{Clock, Library, Model, PortId};

use super::model::{RtlError, compile};
use super::stall::Stalls;
use super::stream::{FeatureBeat, GatherStreams};

/// Cycles without a handshake after which a unit is taken to hang. A willing
/// moment of a stream that stalls 99 cycles of 100 is certain within it.
const PATIENCE: u64 = 20_000;

/// A Verilated gathering unit.
pub struct GatherUnit {
    config: Config,
    library: Library,
}

/// What a run gave.
#[derive(Debug, Clone, PartialEq)]
pub struct GatherRun {
    /// Features, beat by beat.
    pub beats: Vec<FeatureBeat>,
    /// Cycles until the last beat was accepted.
    pub cycles: u64,
    /// For every cycle: RIT ready 1, MFT ready 2, features valid 4.
    pub handshakes: Vec<u8>,
    /// Issuing cycles, from the unit's counter.
    pub busy: u64,
    /// Stalls for want of FIFO room, MVoxel, entries, from its counters.
    pub stalls: [u64; 3],
    /// Entries issued, from its counter.
    pub entries: u64,
    /// Its sticky flags.
    pub errors: u64,
    /// Issuing cycles that the tasks ask for.
    pub issues: u64,
}

struct Ports {
    clock: Clock,
    reset: PortId,
    rit: [PortId; 6],
    mft: [PortId; 4],
    feat: [PortId; 6],
    config: [PortId; 3],
    stat: [PortId; 6],
}

impl Ports {
    fn find(model: &Model) -> Result<Self, RtlError> {
        let port = |name: &str| model.port(name);
        let stream = |prefix: &str, name: &str| model.port(&format!("{prefix}_{name}"));
        let rit = |name| stream("s_axis_rit", name);
        let mft = |name| stream("s_axis_mft", name);
        let feat = |name| stream("m_axis_feat", name);
        Ok(Self {
            clock: model.clock("clk")?,
            reset: port("rst_n")?,
            rit: [
                rit("tvalid")?,
                rit("tready")?,
                rit("tdata")?,
                rit("tkeep")?,
                rit("tlast")?,
                rit("tuser")?,
            ],
            mft: [mft("tvalid")?, mft("tready")?, mft("tdata")?, mft("tlast")?],
            feat: [
                feat("tvalid")?,
                feat("tready")?,
                feat("tdata")?,
                feat("tkeep")?,
                feat("tlast")?,
                feat("tuser")?,
            ],
            config: [
                port("cfg_vertices")?,
                port("cfg_segments")?,
                port("cfg_clear")?,
            ],
            stat: [
                port("stat_busy")?,
                port("stat_stall_fifo")?,
                port("stat_stall_mft")?,
                port("stat_stall_rit")?,
                port("stat_entries")?,
                port("stat_errors")?,
            ],
        })
    }
}

impl GatherUnit {
    /// Builds the unit of a configuration, or finds it in the cache.
    ///
    /// # Errors
    /// A missing tool, or a failure of one.
    pub fn build(config: &Config) -> Result<Self, RtlError> {
        let module = gathering_unit(config)?;
        Ok(Self {
            config: config.clone(),
            library: compile(&module)?,
        })
    }

    /// Sends tasks through the unit, from reset.
    ///
    /// # Errors
    /// A malformed task, or a unit that hangs or fails.
    pub fn run(&self, tasks: &[GatherTask], stalls: Stalls) -> Result<GatherRun, RtlError> {
        let streams = GatherStreams::new(&self.config, tasks)?;
        let mut model = self.library.model(stalls.seed as u32)?;
        let p = Ports::find(&model)?;
        for port in [p.reset, p.rit[0], p.mft[0], p.feat[1], p.config[2]] {
            model.set_u64(port, 0)?;
        }
        model.set_u64(p.config[0], u64::from(streams.vertices.log2()))?;
        model.set_u64(p.config[1], streams.segments as u64)?;
        for _ in 0..3 {
            model.tick(p.clock)?;
        }
        model.set_u64(p.reset, 1)?;
        let run = self.cycles(&mut model, &p, &streams, stalls)?;
        Ok(run)
    }

    fn cycles(
        &self,
        model: &mut Model,
        p: &Ports,
        streams: &GatherStreams,
        stalls: Stalls,
    ) -> Result<GatherRun, RtlError> {
        let mut willing = stalls.start();
        let (mut rit, mut mft) = (0, 0);
        let (mut rit_on, mut mft_on, mut sink_on) = (false, false, false);
        let (mut loaded_rit, mut loaded_mft) = (usize::MAX, usize::MAX);
        let mut beats = Vec::with_capacity(streams.beats);
        let mut handshakes = vec![];
        let mut idle = 0;
        let mut cycle = 0;
        while beats.len() < streams.beats {
            let [w_rit, w_mft, w_sink] = willing.next();
            // Once offered, a beat stays until it is accepted.
            rit_on = rit < streams.rit.len() && (rit_on || w_rit);
            mft_on = mft < streams.mft.len() && (mft_on || w_mft);
            if sink_on != w_sink || cycle == 0 {
                sink_on = w_sink;
                model.set_u64(p.feat[1], u64::from(sink_on))?;
            }
            model.set_u64(p.rit[0], u64::from(rit_on))?;
            model.set_u64(p.mft[0], u64::from(mft_on))?;
            if rit_on && loaded_rit != rit {
                let beat = &streams.rit[rit];
                model.set_words(p.rit[2], &beat.data)?;
                model.set_words(p.rit[3], &beat.keep)?;
                model.set_u64(p.rit[4], u64::from(beat.last))?;
                model.set_u64(p.rit[5], u64::from(beat.user))?;
                loaded_rit = rit;
            }
            if mft_on && loaded_mft != mft {
                let beat = &streams.mft[mft];
                model.set_words(p.mft[2], &beat.data)?;
                model.set_u64(p.mft[3], u64::from(beat.last))?;
                loaded_mft = mft;
            }
            model.fall(p.clock)?;
            let ready = [model.get_u64(p.rit[1])? == 1, model.get_u64(p.mft[1])? == 1];
            let valid = model.get_u64(p.feat[0])? == 1;
            handshakes.push(u8::from(ready[0]) | u8::from(ready[1]) << 1 | u8::from(valid) << 2);
            let moved = [rit_on && ready[0], mft_on && ready[1], valid && sink_on];
            if moved[2] {
                beats.push(self.beat(model, p, cycle)?);
            }
            if moved[0] {
                rit += 1;
                rit_on = false;
            }
            if moved[1] {
                mft += 1;
                mft_on = false;
            }
            model.rise(p.clock)?;
            cycle += 1;
            idle = if moved.contains(&true) { 0 } else { idle + 1 };
            if idle > PATIENCE {
                return Err(RtlError::Hang {
                    unit: potamoi_formats::units::GATHERING_UNIT,
                    cycles: idle,
                    state: format!(
                        "{rit} of {} RIT beats, {mft} of {} MFT beats, {} of {} feature beats",
                        streams.rit.len(),
                        streams.mft.len(),
                        beats.len(),
                        streams.beats
                    ),
                });
            }
        }
        model.fall(p.clock)?;
        let mut stat = [0; 6];
        for (value, port) in stat.iter_mut().zip(p.stat) {
            *value = model.get_u64(port)?;
        }
        Ok(GatherRun {
            beats,
            cycles: cycle,
            handshakes,
            busy: stat[0],
            stalls: [stat[1], stat[2], stat[3]],
            entries: stat[4],
            errors: stat[5],
            issues: streams.issues,
        })
    }

    fn beat(&self, model: &Model, p: &Ports, cycle: u64) -> Result<FeatureBeat, RtlError> {
        let (banks, slot_bits) = (
            self.config.gu.banks as usize,
            self.config.rit.slot_bits as usize,
        );
        let (data, keep, user) = (
            model.words(p.feat[2])?,
            model.words(p.feat[3])?,
            model.words(p.feat[5])?,
        );
        let half = |words: &[u32], i: usize| (words[i / 2] >> (16 * (i % 2))) as u16;
        let mut entries = vec![];
        for port in 0..self.config.gu.ports as usize {
            let first = 2 * banks * port;
            if keep[first / 32] >> (first % 32) & 1 == 0 {
                continue;
            }
            let slot = if slot_bits == 32 {
                user[port]
            } else {
                u32::from(half(&user, port))
            };
            let features = (0..banks)
                .map(|b| half(&data, port * banks + b) as i16)
                .collect();
            entries.push((slot, features));
        }
        Ok(FeatureBeat {
            entries,
            last: model.get_u64(p.feat[4])? == 1,
            cycle,
        })
    }
}

impl GatherRun {
    /// Features in task and entry order, all `channels` of an entry together.
    ///
    /// # Errors
    /// Beats that do not add up to the tasks.
    pub fn features(&self, config: &Config, tasks: &[GatherTask]) -> Result<Vec<i16>, RtlError> {
        let banks = config.gu.banks as usize;
        let mut out = vec![];
        let mut beats = self.beats.iter();
        for task in tasks {
            let segments = config.segments(task.channels).max(1);
            let start = out.len();
            out.resize(start + task.entries.len() * task.channels, 0);
            for segment in 0..segments {
                let mut entry = 0;
                while entry < task.entries.len() {
                    let short = || {
                        RtlError::Usage(
                            "the unit gave fewer features than the tasks have".to_owned(),
                        )
                    };
                    let beat = beats.next().ok_or_else(short)?;
                    for (_, features) in &beat.entries {
                        let low = segment * banks;
                        let count = banks.min(task.channels - low);
                        let at = start + entry * task.channels + low;
                        let place = out.get_mut(at..at + count).ok_or_else(short)?;
                        place.copy_from_slice(&features[..count]);
                        entry += 1;
                    }
                    if beat.entries.is_empty() {
                        return Err(short());
                    }
                }
            }
        }
        Ok(out)
    }
}
