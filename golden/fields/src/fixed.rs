//! The fixed-point renderer of fields: every gather and every vector operation goes through the
//! units.
//!
//! A frame is cut into square ray groups. In a field of one volume, a group is gathered MVoxel by
//! MVoxel ([`crate::volume`]). In a field of several tables, its samples are processed in batches:
//! the same number from every ray that has not stopped, front to back. A batch is gathered table
//! after table, each in the memory-centric order ([`crate::gather_plan`]). The features of each
//! sample are then joined, and its rays are composited. The picture depends on neither ray groups,
//! nor batches, nor the order.

use glam::DVec3;
use potamoi_formats::config::Config;
use rayon::prelude::*;

use super::batches::{BatchSize, SampleBatch, SampleBatches};
use super::float::{check, check_mask};
use super::quantised_field::{QuantisedField, Storage};
use super::work::{FieldWork, FixedOptions};
use super::{Field, FieldError, Sampling};
use crate::gather_plan::{CodedTable, Gathers, Located};
use crate::volume::{CodedVolume, MVoxelOrder};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_march::tiling::Halo;
use potamoi_march::{
    self as march, Batch, Compositor, FixedFrame, FixedStats, GatherOrder, Head, MarchError, Next,
    OpacityAlone, Orders, RayGroup, Setup, TruncatedDirections, check_background,
    default_group_side,
};
use potamoi_reference::Units;

/// A quantised field, ready for rendering.
pub struct FixedField<'a> {
    field: &'a dyn Field,
    /// The tables; empty for a volume.
    tables: Vec<CodedTable>,
    volume: Option<CodedVolume>,
    head: Box<dyn Head + 'a>,
}

impl<'a> FixedField<'a> {
    /// Quantises a field for a configuration.
    ///
    /// # Errors
    /// The field is rendered only in floating point, the configuration's units lack an operation
    /// or format, or a value fits no format.
    pub fn new(field: &'a dyn Field, config: &Config) -> Result<Self, FieldError> {
        Self::with_halo(field, config, Halo::Shared)
    }

    /// As [`FixedField::new`], with a choice of halo.
    ///
    /// # Errors
    /// Those of [`FixedField::new`].
    pub fn with_halo(
        field: &'a dyn Field,
        config: &Config,
        halo: Halo,
    ) -> Result<Self, FieldError> {
        let QuantisedField { storage, head } = field.coded(config)?;
        let (tables, volume) = match storage {
            Storage::Tables(frac_bits) => {
                let tables = field.tables().iter().zip(&frac_bits);
                let coded =
                    |(table, bits): (_, &Vec<_>)| CodedTable::with_halo(table, bits, config, halo);
                (tables.map(coded).collect::<Result<_, _>>()?, None)
            }
            Storage::Volume(volume) => {
                let volume = match halo {
                    Halo::Shared => *volume,
                    Halo::Split => volume.with_halo(halo),
                };
                (vec![], Some(volume))
            }
        };
        Ok(Self {
            field,
            tables,
            volume,
            head,
        })
    }

    /// Its tables; empty for a volume.
    #[must_use]
    pub fn tables(&self) -> &[CodedTable] {
        &self.tables
    }

    /// Its volume; `None` for tables.
    #[must_use]
    pub fn volume(&self) -> Option<&CodedVolume> {
        self.volume.as_ref()
    }

    /// Its feature computation.
    #[must_use]
    pub fn head(&self) -> &dyn Head {
        &*self.head
    }

    /// The gathering tasks of each table for a batch of samples, seen from `eye`. `samples` are
    /// world positions where the field is not known to be empty, each ray's front to back; `slots`
    /// are their rays.
    #[must_use]
    pub fn gathers(&self, eye: DVec3, slots: &[u32], samples: &[DVec3]) -> Vec<Gathers> {
        let count = self.tables.len();
        let mut eyes = vec![DVec3::ZERO; count];
        self.field.place(eye, &mut eyes);
        let mut places = vec![DVec3::ZERO; count * samples.len()];
        places
            .par_chunks_exact_mut(count)
            .zip(samples)
            .for_each(|(places, at)| self.field.place(*at, places));
        let tables = self.tables.par_iter().enumerate();
        tables
            .map(|(number, table)| {
                let own = places.iter().skip(number).step_by(count);
                let located = slots.iter().zip(own);
                let located: Vec<Located> = located
                    .map(|(slot, place)| Located {
                        slot: *slot,
                        place: *place,
                    })
                    .collect();
                table.gathers(eyes[number], &located)
            })
            .collect()
    }

    /// Renders the field through `units`. Sample positions are computed in floating point, as on the
    /// GPU, and rounded to 12 fraction bits. Everything else goes through `units`, except sums of
    /// products (MAC array) and additions to a pixel.
    ///
    /// # Errors
    /// The camera has no pixels, an option or the sampling is out of range, or a unit fails.
    pub fn render(
        &self,
        camera: &Camera,
        options: &FixedOptions,
        units: &mut dyn Units,
    ) -> Result<FixedFrame, FieldError> {
        self.render_masked(camera, options, None, units)
    }

    /// As [`FixedField::render`], but renders only the pixels of a mask, bit for bit as in the
    /// whole frame; the others are background.
    ///
    /// # Errors
    /// Those of [`FixedField::render`], or the mask does not have the camera's size.
    pub fn render_masked(
        &self,
        camera: &Camera,
        options: &FixedOptions,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<FixedFrame, FieldError> {
        let facing = TruncatedDirections {
            head: &*self.head,
            kept: options.work.direction_codes,
        };
        self.render_with(&facing, camera, options, only, units)
    }

    /// Gathered samples per pixel up to where its ray stops, row after row; `u32::MAX` for rays
    /// that do not stop. No colour is computed.
    ///
    /// # Errors
    /// Those of [`FixedField::render`].
    pub fn stops(
        &self,
        camera: &Camera,
        options: &FixedOptions,
        units: &mut dyn Units,
    ) -> Result<Vec<u32>, FieldError> {
        let frame = self.render_with(&OpacityAlone(&*self.head), camera, options, None, units)?;
        Ok(frame.stops)
    }

    fn render_with(
        &self,
        head: &dyn Head,
        camera: &Camera,
        options: &FixedOptions,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<FixedFrame, FieldError> {
        let order = self.order(camera, options)?;
        check_mask(camera, only)?;
        check_background(options.background)?;
        let side = options.group_side.unwrap_or_else(default_group_side);
        if side == 0
            || options
                .batch
                .is_some_and(|b| b.samples == 0 || b.entries == 0)
        {
            return Err(FieldError::Part {
                part: "group_side and batch",
                found: format!("{side} and {:?}", options.batch),
                expected: "1 or more".to_owned(),
            });
        }
        let setup = Setup {
            size: [camera.width, camera.height],
            side: options.group_side,
            only,
            stop: options.terminate.then_some(self.field.sampling().stop),
            transmittance_bits: options.transmittance_bits,
            background: options.background,
        };
        let mut frame = march::render(&setup, head, &*order, units)?;
        frame
            .stats
            .orders
            .resize(self.tables.len(), Orders::default());
        Ok(frame)
    }

    /// The order of gathering, with the camera checked.
    fn order(
        &self,
        camera: &Camera,
        options: &FixedOptions,
    ) -> Result<Box<dyn GatherOrder + '_>, FieldError> {
        let void_test = options.work.void_test;
        if let Some(volume) = &self.volume {
            let most = options.batch.unwrap_or(BatchSize::VOLUME).entries;
            let order = MVoxelOrder::new(volume, camera, void_test, most)?;
            return Ok(Box::new(order));
        }
        let sampling = self.field.sampling();
        check(camera, &sampling)?;
        Ok(Box::new(SampleOrder {
            field: self,
            sampling,
            camera: *camera,
            void_test,
            batch_size: options.batch.unwrap_or_else(|| BatchSize::of(&self.tables)),
            work: options.work,
        }))
    }

    /// Gathers a batch and joins the channels of each sample.
    fn features(
        &self,
        eye: DVec3,
        batch: &SampleBatch,
        work: FieldWork,
        units: &mut dyn Units,
        stats: &mut FixedStats,
    ) -> Result<Vec<i16>, MarchError> {
        let all = self.head.channels();
        stats.orders.resize(self.tables.len(), Orders::default());
        let mut features = vec![0; batch.at.len() * all];
        let (mut first, mut hashed) = (0, 0);
        let gathers = self.gathers(eye, &batch.slots, &batch.at);
        for (number, (table, own)) in self.tables.iter().zip(gathers).enumerate() {
            if self.field.tables()[number].is_hashed() {
                hashed += 1;
                if hashed > work.hashed {
                    first += table.channels();
                    continue;
                }
            }
            table.carry_out(&own, units, stats, |sample, codes| {
                let to = sample as usize * all + first;
                features[to..to + codes.len()].copy_from_slice(codes);
            })?;
            let samples = &mut stats.orders[number];
            if own.row_by_row {
                samples.row_by_row += own.samples.len() as u64;
            } else {
                samples.streamed += (own.samples.len() + own.parted.samples.len()) as u64;
            }
            first += table.channels();
        }
        Ok(features)
    }
}

/// Gathers a ray group in batches: the same number of samples from every ray that has not stopped,
/// table after table. Several tables need this order: their MVoxels differ, and a sample is
/// composited only after the last table, so no order of MVoxels is front to back in all of them.
struct SampleOrder<'a> {
    field: &'a FixedField<'a>,
    sampling: Sampling,
    camera: Camera,
    void_test: bool,
    batch_size: BatchSize,
    work: FieldWork,
}

impl GatherOrder for SampleOrder<'_> {
    fn start(&self, pixels: &[[u32; 2]]) -> Box<dyn RayGroup + '_> {
        let field = self.field.field;
        Box::new(TableGroup {
            order: self,
            batches: SampleBatches::new(
                field,
                self.void_test,
                &self.sampling,
                &self.camera,
                pixels,
            ),
        })
    }
}

/// The rays of a group in a field of tables.
struct TableGroup<'a> {
    order: &'a SampleOrder<'a>,
    batches: SampleBatches<'a>,
}

impl RayGroup for TableGroup<'_> {
    fn directions(&self) -> Vec<DVec3> {
        self.batches.directions().collect()
    }

    fn samples(&self) -> u64 {
        self.batches.samples()
    }

    fn next(
        &mut self,
        done: &Compositor<'_>,
        units: &mut dyn Units,
        stats: &mut FixedStats,
        batch: &mut Batch,
    ) -> Result<Next, MarchError> {
        let order = self.order;
        let alive = |slot| done.is_alive(slot);
        let samples = self.batches.next(alive, order.batch_size);
        if samples.at.is_empty() {
            return Ok(Next::End);
        }
        let eye = order.camera.position();
        batch.features = order
            .field
            .features(eye, &samples, order.work, units, stats)?;
        batch.spans = samples.spans;
        Ok(Next::Batch)
    }
}
