//! Gathering of the dense levels in the memory-centric order: their tables as
//! codes in MVoxels, and the tasks of a ray group, level after level.
//!
//! In a level every MVoxel that a sample of the group needs is loaded once, in
//! the order of distance from the camera's, by the sum of their indices'
//! distances, which grows along every ray. Hashed levels are left out: see
//! [`GridShape::streams`](super::grid::GridShape::streams).

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};

use super::Ngp;
use crate::fields::codes::{finest, quantised};
use crate::fields::{Field as _, FieldError, Table};
use crate::units::GatherTask;
use crate::units::weights::trilinear;
use crate::voxels::MVoxels;

/// The dense levels of a model as codes in MVoxels.
#[derive(Debug)]
pub struct Streamed<'a> {
    field: &'a Ngp,
    levels: Vec<StreamedLevel>,
}

/// A dense level.
#[derive(Debug)]
pub struct StreamedLevel {
    level: usize,
    mvoxels: MVoxels,
    frac_bits: u32,
}

/// Whose features an entry gathers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Which of the grid's levels.
    pub level: usize,
    /// Which of the samples.
    pub sample: usize,
}

/// Gathering tasks and where their results belong.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathers {
    /// In the order in which they are carried out.
    pub tasks: Vec<GatherTask>,
    /// Of every entry of every task, in order.
    pub sources: Vec<Source>,
}

impl StreamedLevel {
    fn new(level: usize, table: &Table, config: &Config) -> Result<Self, FieldError> {
        let bits = config.gu.feature_bits;
        let frac_bits = finest(table.values().iter(), bits, "features")?;
        let codes = table.values().iter();
        let codes: Vec<i16> = codes.map(|v| quantised(*v, bits, frac_bits)).collect();
        let mvoxels =
            MVoxels::of_codes(table.points(), table.channels(), &codes, config, |_| true)?;
        Ok(Self {
            level,
            mvoxels,
            frac_bits,
        })
    }

    /// Which of the grid's levels it is.
    #[must_use]
    pub fn level(&self) -> usize {
        self.level
    }

    /// Its MVoxels.
    #[must_use]
    pub fn mvoxels(&self) -> &MVoxels {
        &self.mvoxels
    }

    /// Fraction bits of its codes.
    #[must_use]
    pub fn frac_bits(&self) -> u32 {
        self.frac_bits
    }
}

impl Ngp {
    /// The dense levels as codes in the MVoxels that a configuration's rows
    /// hold.
    ///
    /// # Errors
    /// A configuration whose gathering unit has no entries of eight vertices,
    /// too few segments or too few rows, or values that no format holds.
    pub fn streamed(&self, config: &Config) -> Result<Streamed<'_>, FieldError> {
        let refuse = |part, found: String, expected: String| {
            Err(FieldError::Part {
                part,
                found,
                expected,
            })
        };
        let built = config.supported_vertices();
        if !built.contains(&Vertices::Eight) {
            let counts: Vec<_> = built.iter().map(|v| v.count()).collect();
            let expected = "8 among them, for voxels".to_owned();
            return refuse("gu.vertices", format!("{counts:?}"), expected);
        }
        let channels = self.shape.features as usize;
        let segments = config.segments(channels);
        if segments > config.gu.segments as usize {
            let expected = format!("{segments} or more, for {channels} channels");
            return refuse("gu.segments", config.gu.segments.to_string(), expected);
        }
        let dense = self.tables.iter().enumerate();
        let dense = dense.filter(|(_, table)| !table.is_hashed());
        let levels = dense.map(|(level, table)| StreamedLevel::new(level, table, config));
        Ok(Streamed {
            field: self,
            levels: levels.collect::<Result<_, _>>()?,
        })
    }

    /// Where a place of the world lies in a level's table, in vertices.
    fn place(&self, level: usize, at: DVec3) -> DVec3 {
        let within = (self.placement.to_cube(at) - self.corner) / self.side;
        within * self.scales[level] + 0.5
    }
}

impl Streamed<'_> {
    /// The dense levels, coarse to fine.
    #[must_use]
    pub fn levels(&self) -> &[StreamedLevel] {
        &self.levels
    }

    /// The gathering tasks of a ray group: `samples` in the world, each ray's
    /// front to back, seen from `eye`. Samples where the field is known to be
    /// empty have no entries; the slot of the others is their number.
    #[must_use]
    pub fn gathers(&self, eye: DVec3, samples: &[DVec3]) -> Gathers {
        let mut places = vec![DVec3::ZERO; self.field.tables().len()];
        let filled = samples.iter().enumerate();
        let filled: Vec<usize> = filled
            .filter(|(_, at)| self.field.index(**at, &mut places))
            .map(|(sample, _)| sample)
            .collect();
        let mut gathers = Gathers::default();
        for level in &self.levels {
            self.level(level, eye, samples, &filled, &mut gathers);
        }
        gathers
    }

    fn level(
        &self,
        level: &StreamedLevel,
        eye: DVec3,
        samples: &[DVec3],
        filled: &[usize],
        gathers: &mut Gathers,
    ) {
        let mvoxels = &level.mvoxels;
        let distances = mvoxels.distances(self.field.place(level.level, eye).to_array());
        let located = filled.iter().map(|sample| {
            let at = self.field.place(level.level, samples[*sample]);
            (*sample, mvoxels.locate(at.to_array()))
        });
        let mut located: Vec<_> = located.collect();
        // Stable: within an MVoxel samples stay in their order.
        located.sort_by_key(|(_, place)| (distances[place.mvoxel], place.mvoxel));
        for own in located.chunk_by(|(_, a), (_, b)| a.mvoxel == b.mvoxel) {
            let entries = own.iter().map(|(sample, place)| RitEntry {
                slot: *sample as u32,
                rows: mvoxels.corner_rows(place),
                weights: trilinear(place.fraction, mvoxels.weight_bits()),
            });
            gathers.tasks.push(GatherTask {
                vertices: Vertices::Eight,
                channels: mvoxels.channels(),
                rows: mvoxels.rows(own[0].1.mvoxel).to_vec(),
                entries: entries.collect(),
            });
            gathers.sources.extend(own.iter().map(|(sample, _)| Source {
                level: level.level,
                sample: *sample,
            }));
        }
    }
}
