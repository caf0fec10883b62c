//! Instant-NGP (Müller, Evans, Schied, Keller, SIGGRAPH 2022): levels of a hash grid, one small
//! perceptron for density and one for colour, and an occupancy grid.
//!
//! A world point, in the frame of `transforms.json`, is scaled by 0.33, shifted by 0.5, and its
//! axes are cycled, (x, y, z) to (y, z, x), so that points at most 1.5 from the origin lie in the
//! unit cube. A snapshot's own scale and offset have precedence. The model fills a box of side
//! `aabb_scale` around the middle of the cube, and the grid spans the box.
//!
//! Two things differ from the authors' renderer. Steps are sqrt(3)/1024 of the unit cube
//! everywhere, whereas that renderer widens them with the distance if `aabb_scale` is above 1. A
//! ray that stops at a transmittance of 1 % keeps it, whereas that renderer scales the colour up.
//! Colours are those of the training pictures, and composited as such.

mod bound;
mod document;
mod fixed;
mod full_size;
pub mod grid;
mod integers;
mod keys;
mod occupancy;
mod parameters;
mod snapshot;
mod wrong;

use std::path::Path;

use glam::{DVec3, dvec3};
use potamoi_formats::config::Config;

use crate::calibrate::Magnitudes;
use crate::{
    Algorithm, Along, AnyField, Bounds, Directions, Field, FieldError, FieldFile, FileOptions,
    HashUnit, LoadedField, Mlp, QuantisedField, Sampling, Size, Table, sigmoid, unverified_work,
};
use grid::GridShape;
use occupancy::Occupancy;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_base::sh;
use potamoi_reference::bounds::VectorBounds;

pub use keys::NGP;
pub(crate) use parameters::table as level_table;

/// Step in the unit cube: its diagonal divided by 1024.
const STEP: f64 = 1.732_050_807_568_877_2 / 1024.0;
/// Early-termination threshold (transmittance).
const STOP: f64 = 0.01;
/// Range of samples: in front of the camera, at any distance.
const RANGE: [f64; 2] = [0.0, 1e9];

/// The transform from the world to the frame of the unit cube.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
struct Placement {
    scale: f64,
    /// Offset before axes are cycled.
    offset: DVec3,
}

/// Cycles the axes of the world to those of the cube.
fn cycled(v: DVec3) -> DVec3 {
    dvec3(v.y, v.z, v.x)
}

impl Placement {
    fn to_cube(self, at: DVec3) -> DVec3 {
        cycled(at * self.scale + self.offset)
    }

    fn to_world(self, at: DVec3) -> DVec3 {
        (dvec3(at.z, at.x, at.y) - self.offset) / self.scale
    }
}

/// An Instant-NGP model.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Ngp {
    shape: GridShape,
    /// What shares an entry of a hashed level.
    unit: HashUnit,
    /// The tables, one a level.
    tables: Vec<Table>,
    /// The scale of each level.
    scales: Vec<f64>,
    /// Perceptron from features to latents, the first of which is the logarithm of the density.
    density: Mlp,
    /// Perceptron from latents and spherical harmonics of the direction to colour logits.
    colour: Mlp,
    occupancy: Option<Occupancy>,
    placement: Placement,
    /// The first corner of the box that the grid spans, and its side, in the frame of the unit
    /// cube.
    corner: f64,
    side: f64,
    /// The visible part of the field, in world coordinates.
    bounds: [DVec3; 2],
    /// Unused parts of the snapshot.
    #[serde(skip)]
    notes: Notes,
    /// Of the outputs of its perceptrons.
    #[serde(skip)]
    magnitudes: Magnitudes,
}

impl Ngp {
    /// Unused parts of the file.
    #[must_use]
    pub const fn notes(&self) -> &Notes {
        &self.notes
    }

    /// Loads a snapshot, `.ingp` or `.msgpack`.
    ///
    /// # Errors
    /// The file is not a snapshot, a part is missing or inconsistent, or the variant is not
    /// supported.
    pub fn load(path: &Path) -> Result<Self, FieldError> {
        snapshot::load(path)
    }

    /// Loads a snapshot from its bytes; `name` is the file name in errors.
    ///
    /// # Errors
    /// Those of [`Ngp::load`].
    pub fn from_bytes(name: &str, bytes: &[u8]) -> Result<Self, FieldError> {
        snapshot::from_reader(Path::new(name), bytes, bytes.len() as u64)
    }

    /// Sizes of the hash grid.
    #[must_use]
    pub fn shape(&self) -> &GridShape {
        &self.shape
    }

    /// What shares an entry of a hashed level; a vertex in snapshots that Instant-NGP writes.
    #[must_use]
    pub const fn hash_unit(&self) -> HashUnit {
        self.unit
    }

    /// Latents of the gathered features of any number of samples; the first of each sample is the
    /// logarithm of its density.
    fn latents(&self, features: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(features);
        self.density.run(out);
    }

    /// The density at gathered features, per unit of length of the unit cube.
    #[must_use]
    pub fn density(&self, features: &[f64]) -> f64 {
        let mut latents = vec![];
        self.latents(features, &mut latents);
        latents[0].exp()
    }
}

/// A requested hash unit must be that of the snapshot: it decides which vertices share an entry.
fn load(path: &Path, options: &FileOptions) -> Result<LoadedField, FieldError> {
    let snapshot = Ngp::load(path)?;
    let fitted = snapshot.unit;
    if let Some(unit) = options.hash_unit.filter(|unit| *unit != fitted) {
        return Err(FieldError::Asked {
            path: path.to_owned(),
            problem: format!(
                "model.hash_unit is {}: expected {} or left out: it changes which vertices share \
                 an entry, and this snapshot was fitted with {1}; tools/fit ngp-mvoxel fits the \
                 other",
                unit.name(),
                fitted.name()
            ),
        });
    }
    Ok(LoadedField {
        notes: snapshot.notes.clone(),
        field: AnyField::new(snapshot),
    })
}

/// Description of the algorithm for reports; the size is that of a level in its base
/// configuration.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "Instant-NGP",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::HASHES,
        unverified_work::OCCUPANCY,
        unverified_work::RIT,
        unverified_work::HARMONICS,
        unverified_work::PERCEPTRONS,
        unverified_work::COMPOSITING,
    ],
    full_size: Some(Size::Entries(1 << 19)),
    preset: "fields",
    file: Some(FieldFile {
        kind: "ngp",
        endings: &["ingp", "msgpack"],
        format: &NGP,
        keys: &["path", "hash_unit"],
        background: [0.0; 3],
        load,
    }),
};

/// The variant with one entry an MVoxel; such MVoxels share no vertices.
pub static BY_MVOXEL: Algorithm = Algorithm {
    name: "Instant-NGP, hashed by MVoxel",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::HASHES,
        unverified_work::OCCUPANCY,
        unverified_work::RIT,
        unverified_work::HARMONICS,
        unverified_work::PERCEPTRONS,
        unverified_work::COMPOSITING,
        unverified_work::PARTS,
    ],
    full_size: Some(Size::Entries(1 << 19)),
    preset: "fields",
    file: None,
};

impl Field for Ngp {
    fn algorithm(&self) -> &'static Algorithm {
        match self.unit {
            HashUnit::Vertex => &ALGORITHM,
            HashUnit::MVoxel => &BY_MVOXEL,
        }
    }

    fn tables(&self) -> &[Table] {
        &self.tables
    }

    fn holds(&self, at: DVec3) -> bool {
        let grid = self.occupancy.as_ref();
        grid.is_none_or(|grid| grid.holds(self.placement.to_cube(at)))
    }

    fn empty_for(&self, at: DVec3, direction: DVec3) -> Option<f64> {
        let grid = self.occupancy.as_ref()?;
        let empty = grid.empty_for(self.placement.to_cube(at), cycled(direction))?;
        Some(empty / self.placement.scale)
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        let at = self.placement.to_cube(at);
        // Rounding at the faces would lead out of the tables.
        let within = ((at - self.corner) / self.side).clamp(DVec3::ZERO, DVec3::ONE);
        for (place, scale) in places.iter_mut().zip(&self.scales) {
            *place = within * *scale + 0.5;
        }
    }

    fn depth(&self, features: &[f64]) -> f64 {
        STEP * self.density(features)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.latents(features, scratch);
        scratch.extend(sh::basis(cycled(direction)));
        self.colour.run(scratch);
        DVec3::from([0, 1, 2].map(|channel| sigmoid(scratch[channel])))
    }

    fn kept(&self) -> usize {
        self.density.outputs()
    }

    fn depths(&self, features: &[f64], depths: &mut Vec<f64>, kept: &mut Vec<f64>) {
        self.latents(features, kept);
        depths.clear();
        let logarithms = kept.iter().step_by(self.kept());
        depths.extend(logarithms.map(|logarithm| STEP * logarithm.exp()));
    }

    fn encoded(&self) -> usize {
        self.colour.inputs() - self.density.outputs()
    }

    fn encode(&self, direction: DVec3, out: &mut Vec<f64>) {
        out.extend(sh::basis(cycled(direction)));
    }

    fn colours(&self, kept: &[f64], directions: &[f64], out: &mut Vec<DVec3>) {
        let samples = kept.chunks_exact(self.kept());
        let mut values = Vec::with_capacity(kept.len() + directions.len());
        for (latents, direction) in samples.zip(directions.chunks_exact(self.encoded())) {
            values.extend_from_slice(latents);
            values.extend_from_slice(direction);
        }
        self.colour.run(&mut values);
        out.clear();
        let logits = values.chunks_exact(self.colour.outputs());
        out.extend(logits.map(|own| DVec3::from([0, 1, 2].map(|i| sigmoid(own[i])))));
    }

    fn perceptrons(&self) -> Vec<&Mlp> {
        vec![&self.density, &self.colour]
    }

    fn directions(&self) -> Directions<'_> {
        Directions::Perceptron {
            mlp: &self.colour,
            inputs: (self.density.outputs()..self.colour.inputs()).collect(),
            are_harmonics: true,
        }
    }

    fn void(&self) -> Option<[u64; 2]> {
        self.occupancy.as_ref().map(Occupancy::void)
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            bounds: self.bounds,
            step: STEP / self.placement.scale,
            range: RANGE,
            along: Along::Ray,
            least_opacity: 0.0,
            least_weight: 0.0,
            stop: STOP,
        }
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        fixed::coded(self, config)
    }

    fn bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(Some(Box::new(bound::bounds(self, config, vector)?)))
    }
}
