//! The fixed-point renderer: every gather and every vector operation of a frame goes through the
//! units.

use potamoi_formats::fixed::Rounding;
use potamoi_formats::record::{COLOUR, RECORD_CHANNELS, SplatRecord};
use potamoi_formats::units::OpCode;

use super::compositing::Compositing;
use super::decisions::Decisions;
use super::error::RenderError;
use super::fixed_options::{CompositingUnit, FixedOptions};
use super::fixed_stats::FixedStats;
use super::float::mask_fits;
use super::profile::Profile;
use super::schedule::{Group, Schedule};
use super::transmittance::TRANSMITTANCE;
use super::view::{TILE, View};
use crate::reorder_buffer::{Hold, Order};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_gaussians::Cloud;
use potamoi_march::streams::{UnitStreams, Visit};
use potamoi_reference::{GatherTask, Units};

/// Number of gathered or waiting entries that starts compositing.
const BATCH_ENTRIES: usize = 1 << 18;

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedFrame {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel, U1.20 codes.
    pub transmittance: Vec<u32>,
    /// Work and traffic.
    pub stats: FixedStats,
    /// Each skip and stop, if requested.
    pub decisions: Option<Decisions>,
}

/// Renders in the hardware's formats. Projection, colour and sorting are computed in floating
/// point, as on the GPU; everything from gathering on goes through `units`. The picture depends on
/// neither ray groups nor the order of Gaussians in the cloud, and in exact order not on the
/// MVoxels.
///
/// # Errors
/// Those of [`View::new`] and [`Schedule::new`]; a unit fails or returns a wrong number of
/// features.
pub fn render_fixed(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FixedOptions,
    units: &mut dyn Units,
) -> Result<FixedFrame, RenderError> {
    render_fixed_masked(cloud, camera, profile, options, None, units)
}

/// As [`render_fixed`], but renders only the pixels of a mask, bit for bit as in the whole frame;
/// the others are background. All Gaussians are projected; only tiles with such pixels have
/// entries.
///
/// # Errors
/// Those of [`render_fixed`], or the mask does not have the camera's size.
pub fn render_fixed_masked(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FixedOptions,
    only: Option<&Mask>,
    units: &mut dyn Units,
) -> Result<FixedFrame, RenderError> {
    let view = View::by(cloud, camera, profile, &options.work)?;
    if let Some(mask) = only {
        mask_fits(view.size(), mask)?;
    }
    let schedule = Schedule::masked(cloud, &view, &options.schedule, only)?;
    let logs = options.log_decisions
        && options.order == Order::Exact
        && options.unit == CompositingUnit::VectorUnit;
    let mut frame = Frame::new(&view, options);
    frame.stats.visible = view.splats().len() as u64;
    frame.stats.saturations = schedule.saturations();
    frame.stats.pair_test = schedule.test();
    if logs {
        frame.decisions = Some(Decisions::new(view.by_tile().0));
    }
    for index in 0..schedule.groups() {
        if let Some(group) = schedule.group(index) {
            let done = render_group(&view, &group, options, only, units, &mut frame.stats)?;
            let places = (frame.decisions.as_ref()).and_then(|_| schedule.profile_places(index));
            frame.place(&view, &group, (&done, only), places.as_deref());
        }
    }
    let stats = &mut frame.stats;
    stats.streams.records(stats.visible);
    let hold = &stats.hold;
    stats.streams.spills(hold.spilled, hold.spilled_entries);
    Ok(frame.finish())
}

fn render_group(
    view: &View,
    group: &Group,
    options: &FixedOptions,
    only: Option<&Mask>,
    units: &mut dyn Units,
    stats: &mut FixedStats,
) -> Result<Compositing, RenderError> {
    let mut compositor = Compositing::new(view, group, options, only)?;
    let mut hold = Hold::new(options.hold_records);
    let mut highest = vec![0u32; group.tiles.len()];
    let mut features = Vec::new();
    let mut start = 0;
    while start < group.tasks.len() {
        let end = batch_end(&group.tasks, start);
        let batch = &group.tasks[start..end];
        gather(units, batch, &mut features, options.unit_streams, stats)?;
        let mut rows = features.as_chunks::<RECORD_CHANNELS>().0.iter();
        for (t, task) in (start..).zip(batch) {
            compositor.tell_of_forms(task, units);
            for (entry, row) in task.entries.iter().zip(&mut rows) {
                let record = SplatRecord::from_channels(row);
                match options.order {
                    Order::Exact => hold.arrive((entry.slot as u16, record)),
                    Order::Approximate => {
                        let top = &mut highest[entry.slot as usize];
                        stats.inversions += u64::from(record.rank < *top);
                        *top = record.rank.max(*top);
                        compositor.push(entry.slot as usize, record);
                    }
                }
            }
            if options.order == Order::Exact {
                let next = group.mvoxels.get(t + 1).map(|m| m.min_rank);
                hold.retire(next, |(slot, r)| compositor.push(slot.into(), r));
            }
            if compositor.queued() >= BATCH_ENTRIES {
                compositor.run(units)?;
            }
        }
        start = end;
    }
    compositor.finish(units, stats)?;
    stats.scattered_bytes += group.scattered_bytes();
    stats.hold = stats.hold.and(hold.stats());
    Ok(compositor)
}

/// One past the last task of the batch that starts at `start`, which has at least one task.
fn batch_end(tasks: &[GatherTask], start: usize) -> usize {
    let mut entries = 0;
    let more = tasks[start..].iter().take_while(|t| {
        let before = entries;
        entries += t.entries.len();
        before < BATCH_ENTRIES
    });
    start + more.count()
}

fn gather(
    units: &mut dyn Units,
    tasks: &[GatherTask],
    features: &mut Vec<i16>,
    reads: UnitStreams,
    stats: &mut FixedStats,
) -> Result<(), RenderError> {
    features.clear();
    units.gather(tasks, features).map_err(RenderError::Unit)?;
    let entries: usize = tasks.iter().map(|t| t.entries.len()).sum();
    let expected = entries * RECORD_CHANNELS;
    if features.len() != expected {
        return Err(RenderError::Features {
            found: features.len(),
            expected,
        });
    }
    stats.tasks += tasks.len() as u64;
    stats.gathers += entries as u64;
    for task in tasks {
        stats.streams.visit(&Visit::of(task), reads);
    }
    Ok(())
}

/// A frame under construction.
struct Frame {
    picture: Picture,
    transmittance: Vec<u32>,
    background: [u64; 3],
    stats: FixedStats,
    decisions: Option<Decisions>,
}

impl Frame {
    fn new(view: &View, options: &FixedOptions) -> Self {
        let [width, height] = view.size();
        let code = |v: f32| {
            let code = COLOUR.quantise(f64::from(v), Rounding::HalfEven);
            code.unwrap_or_default() as u64
        };
        Self {
            picture: Picture::filled(width, height, [0.0; 3]),
            transmittance: vec![0; width as usize * height as usize],
            background: options.background.map(code),
            stats: FixedStats::default(),
            decisions: None,
        }
    }

    fn place(
        &mut self,
        view: &View,
        group: &Group,
        (done, only): (&Compositing, Option<&Mask>),
        profile_places: Option<&[Vec<u32>]>,
    ) {
        for (slot, number) in group.tiles.iter().enumerate() {
            let [[x0, y0], [columns, rows]] = view.tile_pixels(*number as usize);
            for y in 0..rows {
                for x in 0..columns {
                    let to = ((y0 + y) * self.picture.width + x0 + x) as usize;
                    let wanted = only.is_none_or(|mask| mask.has(to));
                    let (left, colour) = match wanted {
                        true => done.pixel(slot, (y * TILE + x) as usize),
                        false => (1 << TRANSMITTANCE.frac_bits(), [0; 3]),
                    };
                    self.transmittance[to] = left;
                    for c in 0..3 {
                        let sum = colour[c] + u64::from(left) * self.background[c];
                        let bits = TRANSMITTANCE.frac_bits() + COLOUR.frac_bits();
                        self.picture.rgb[to][c] = (sum as f64 / (1u64 << bits) as f64) as f32;
                    }
                }
            }
            if let (Some(d), Compositing::VectorUnit(done)) = (&mut self.decisions, done) {
                let tile = &done.tiles[slot];
                let places = profile_places.map(|all| all[slot].as_slice());
                d.set(*number as usize, &tile.stop, &tile.drawn, places);
            }
        }
    }

    fn finish(mut self) -> FixedFrame {
        let elements = |code| self.stats.vector_elements.get(&code).copied().unwrap_or(0);
        [self.stats.evaluated, self.stats.exponentials] =
            [OpCode::SquareSum, OpCode::Exp].map(elements);
        self.stats.affine_forms = 2 * self.stats.exponentials;
        self.stats.evaluated += self.stats.splat_unit.square_sums;
        self.stats.exponentials += self.stats.splat_unit.exponentials;
        FixedFrame {
            picture: self.picture,
            transmittance: self.transmittance,
            stats: self.stats,
            decisions: self.decisions,
        }
    }
}
