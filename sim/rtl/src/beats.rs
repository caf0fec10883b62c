//! Beats of a gathering unit's streams as port words, with the expected feature beats, for other
//! drivers.

use potamoi_cycles::{BeatWords, GatherWork, Group, StreamError};
use potamoi_formats::config::Config;
use potamoi_reference::GatherTask;
use potamoi_reference::streams::frames;

use super::gather_check::Expected;

/// An input beat.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct InputBeat {
    /// `tdata`, low word first.
    pub data: Vec<u32>,
    /// `tkeep`, low word first; empty where the stream has none.
    pub keep: Vec<u32>,
    /// `tlast`.
    pub last: bool,
    /// `tuser`; RIT stream only.
    pub user: bool,
}

/// An output beat.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FeatureBeat {
    /// `tdata`, low word first; 0 for ports without an entry.
    pub data: Vec<u32>,
    /// Bits that the port has in the words of `data`.
    pub mask: Vec<u32>,
    /// `tkeep`, low word first.
    pub keep: Vec<u32>,
    /// Slot of each valid entry.
    pub slots: Vec<u32>,
    /// `tlast`.
    pub last: bool,
}

/// Beats of a run of tasks.
#[derive(Debug, Clone)]
pub struct GatherBeats {
    /// Values of the settings' ports.
    pub settings: Vec<(&'static str, u64)>,
    /// Beats of the RIT stream, by packet.
    pub rit: Vec<Vec<InputBeat>>,
    /// Beats of the MFT stream, by MVoxel and segment.
    pub mft: Vec<Vec<InputBeat>>,
    /// Width of a slot in bits.
    pub slot_bits: u32,
}

impl GatherBeats {
    /// The beats of tasks that can follow one another.
    ///
    /// # Errors
    /// As [`GatherWork::new`].
    pub fn of(config: &Config, tasks: &[GatherTask]) -> Result<Self, StreamError> {
        let work = GatherWork::new(config, tasks)?;
        let mut layout = BeatWords::new(&work);
        let (mut rit, mut mft) = (vec![vec![]], vec![vec![]]);
        let add = |packets: &mut Vec<Vec<InputBeat>>, beat: InputBeat| {
            let last = beat.last;
            packets
                .last_mut()
                .into_iter()
                .for_each(|p| p.push(beat.clone()));
            if last {
                packets.push(vec![]);
            }
        };
        for piece in work.run().rit_beats(config) {
            layout.rit(&piece)?;
            let beat = InputBeat {
                data: layout.data.clone(),
                keep: layout.keep.clone(),
                last: piece.beat.last,
                user: piece.beat.again,
            };
            add(&mut rit, beat);
        }
        let lanes = work.lane_run().is_some();
        for piece in work.mft_pieces(config) {
            layout.mft(&piece);
            let beat = InputBeat {
                data: layout.row.clone(),
                keep: if lanes {
                    layout.row_keep.clone()
                } else {
                    vec![]
                },
                last: piece.last,
                user: false,
            };
            add(&mut mft, beat);
        }
        rit.pop();
        mft.pop();
        let mut settings = vec![
            ("cfg_vertices", u64::from(work.vertices().log2())),
            ("cfg_segments", work.segments() as u64),
        ];
        if config.gu.records_a_row == 2 {
            settings.push(("cfg_two_records", u64::from(work.shares_rows())));
        }
        if lanes {
            settings.push(("cfg_channels", work.last_channels() as u64));
        }
        Ok(Self {
            settings,
            rit,
            mft,
            slot_bits: work.slot_bits(),
        })
    }
}

/// Feature beats of tasks. `features` are in task and entry order. `ends_null` tells for each task
/// and segment whether its request packet ends with a beat without bytes.
///
/// # Errors
/// As [`GatherWork::new`].
pub fn feature_beats<T: Copy + Into<i32>>(
    config: &Config,
    tasks: &[GatherTask],
    features: &[T],
    ends_null: impl Fn(usize, usize) -> bool,
) -> Result<Vec<FeatureBeat>, StreamError> {
    let work = GatherWork::new(config, tasks)?;
    let mut beats = vec![];
    let mut before = 0;
    for (task, t) in work.tasks().iter().enumerate() {
        for segment in 0..work.segments() {
            let channels = work.channels_of(segment);
            for frame in frames(t.entries.len(), work.side(), ends_null(task, segment)) {
                for low in channels.clone().step_by(work.width()) {
                    let group = Group {
                        task,
                        segment,
                        entry: frame.first,
                        kept: frame.kept,
                        ordinal: before + frame.first,
                        low,
                        begins: low == channels.start,
                        last: frame.last && low + work.width() >= channels.end,
                    };
                    let wanted = Expected::new(&work, features, group);
                    let entries = &t.entries[frame.first..frame.first + frame.kept];
                    let low_bits = if work.slot_bits() == 32 { !0 } else { 0xffff };
                    beats.push(FeatureBeat {
                        data: wanted.data,
                        mask: wanted.mask,
                        keep: wanted.keep,
                        slots: entries.iter().map(|e| e.slot & low_bits).collect(),
                        last: group.last,
                    });
                }
            }
        }
        before += t.entries.len();
    }
    Ok(beats)
}
