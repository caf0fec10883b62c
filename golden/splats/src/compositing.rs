//! The two ways of compositing a ray group: through the vector unit, wave by wave, or as one job of the
//! splat unit.

use potamoi_base::mask::Mask;
use potamoi_formats::record::SplatRecord;
use potamoi_reference::splat_unit::{Composited, SplatEntry, SplatJob, SplatSettings};
use potamoi_reference::{GatherTask, Units};

use super::composite::Compositor;
use super::error::RenderError;
use super::fixed_options::{CompositingUnit, FixedOptions};
use super::fixed_stats::FixedStats;
use super::reorder_buffer::Order;
use super::schedule::Group;
use super::unit_entries::{entry_of, unit_settings};
use super::view::{TILE_PIXELS, View};

/// Compositing of a ray group.
pub(crate) enum Compositing {
    VectorUnit(Compositor),
    SplatUnit(SplatTiles),
}

/// The tiles of a ray group in the splat unit.
pub(crate) struct SplatTiles {
    settings: SplatSettings,
    /// First pixel, and columns and rows in the picture, of each tile.
    places: Vec<[[u32; 2]; 2]>,
    entries: Vec<SplatEntry>,
    done: Composited,
}

impl Compositing {
    /// Empty tiles of a group; with a mask, only its pixels are wanted.
    ///
    /// # Errors
    /// The splat unit carries all bits of a transmittance, and the rules do not.
    pub(crate) fn new(
        view: &View,
        group: &Group,
        options: &FixedOptions,
        only: Option<&Mask>,
    ) -> Result<Self, RenderError> {
        let places = group.tiles.iter().map(|t| view.tile_pixels(*t as usize));
        match options.unit {
            CompositingUnit::VectorUnit => {
                let keep = options.log_decisions && options.order == Order::Exact;
                let mut own = Compositor::new(view.rules(), options.widths, places, keep);
                if let Some(mask) = only {
                    own.leave_out(|[x, y]| mask.has((y * view.size()[0] + x) as usize));
                }
                Ok(Self::VectorUnit(own))
            }
            CompositingUnit::SplatUnit => {
                let settings = unit_settings(view.rules(), options.schedule.opacity);
                if settings.thresholds.spare != 0 {
                    return Err(RenderError::Option {
                        field: "transmittance_bits",
                        value: view.rules().transmittance_bits.to_string(),
                        expected: "20, which the splat unit carries; or a configuration without the table [su]",
                    });
                }
                Ok(Self::SplatUnit(SplatTiles {
                    settings,
                    places: places.collect(),
                    entries: vec![],
                    done: Composited {
                        pixels: vec![],
                        counts: Default::default(),
                    },
                }))
            }
        }
    }

    /// Appends a record to those of a tile.
    pub(crate) fn push(&mut self, slot: usize, record: SplatRecord) {
        match self {
            Self::VectorUnit(own) => own.push(slot, record),
            Self::SplatUnit(own) => {
                if let Some(place) = own.places.get(slot) {
                    own.entries.push(entry_of(slot as u16, *place, record));
                }
            }
        }
    }

    /// Reports the affine forms of a task, which the MAC array computes for the vector unit. The splat
    /// unit computes its own.
    pub(crate) fn tell_of_forms(&self, task: &GatherTask, units: &mut dyn Units) {
        match self {
            Self::VectorUnit(own) => own.tell_of_forms(task, units),
            Self::SplatUnit(_) => {}
        }
    }

    /// Number of entries that wait for the vector unit. The splat unit takes those of a group at once.
    pub(crate) fn queued(&self) -> usize {
        match self {
            Self::VectorUnit(own) => own.queued(),
            Self::SplatUnit(_) => 0,
        }
    }

    /// Composites the entries that wait for the vector unit.
    pub(crate) fn run(&mut self, units: &mut dyn Units) -> Result<(), RenderError> {
        match self {
            Self::VectorUnit(own) => own.run(units),
            Self::SplatUnit(_) => Ok(()),
        }
    }

    /// Composites what is left, and adds the work to that of the frame.
    pub(crate) fn finish(
        &mut self,
        units: &mut dyn Units,
        stats: &mut FixedStats,
    ) -> Result<(), RenderError> {
        match self {
            Self::VectorUnit(own) => {
                own.run(units)?;
                stats.drawn += own.drawn;
                for (code, count) in &own.elements {
                    *stats.vector_elements.entry(*code).or_default() += count;
                }
                let stops = own.tiles.iter().flat_map(|tile| &tile.stop);
                stats.stopped += stops.filter(|stop| **stop != u32::MAX).count() as u64;
            }
            Self::SplatUnit(own) => {
                own.finish(units)?;
                stats.splat_unit += own.done.counts;
                stats.drawn += own.done.counts.drawn;
                stats.stopped += own.done.counts.stopped;
            }
        }
        Ok(())
    }

    /// Transmittance (U1.20) and colour sums (32 fraction bits) of a pixel of a tile.
    pub(crate) fn pixel(&self, slot: usize, at: usize) -> (u32, [u64; 3]) {
        match self {
            // Never negative, at most 1.
            Self::VectorUnit(own) => {
                let tile = &own.tiles[slot];
                (tile.transmittance[at] as u32, tile.colour[at])
            }
            Self::SplatUnit(own) => {
                let pixel = own.done.pixels[slot * TILE_PIXELS + at];
                (pixel.transmittance, pixel.colour)
            }
        }
    }
}

impl SplatTiles {
    fn finish(&mut self, units: &mut dyn Units) -> Result<(), RenderError> {
        let job = SplatJob {
            settings: self.settings,
            tiles: self.places.len(),
            entries: &self.entries,
        };
        self.done = units.splats(&job).map_err(RenderError::Unit)?;
        self.entries.clear();
        let (found, expected) = (self.done.pixels.len(), self.places.len() * TILE_PIXELS);
        if found != expected {
            return Err(RenderError::Pixels { found, expected });
        }
        Ok(())
    }
}
