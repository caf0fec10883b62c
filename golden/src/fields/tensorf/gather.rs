//! The tables as codes, cut into MVoxels, and the gathering of a camera's
//! samples in the memory-centric order.
//!
//! MVoxels of planes are rectangles of twice as many vertices along the faster
//! axis or as many (16 x 32 with 512 rows), those of lines take all rows. They
//! follow one another at a stride of one vertex less, so that every sample has
//! one owner a table: an entry of four vertices in each plane, of two in each
//! line.
//!
//! A frame is cut into square ray groups. In a group, table after table, an
//! MVoxel is loaded once, for all samples of all rays; MVoxels come in the order
//! of their distance from the camera's, by the sum of their indices' distances,
//! which grows along every ray.

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::{Tensorf, part};
use crate::camera::Camera;
use crate::fields::codes::{finest, quantised};
use crate::fields::march::{Samples, check};
use crate::fields::{Field, FieldError, Table};
use crate::units::GatherTask;
use crate::units::weights::{self, FRACTION_BITS};
use crate::voxels::default_group_side;

/// Entries of a sample: one a table.
const ENTRIES: usize = 6;

/// A model's tables as codes in MVoxels.
#[derive(Debug, Clone)]
pub struct Tiled<'a> {
    field: &'a Tensorf,
    tables: Vec<TiledTable>,
    weight_bits: u32,
}

/// A table as codes in MVoxels. A line has one vertex along its second axis.
#[derive(Debug, Clone, PartialEq)]
pub struct TiledTable {
    points: [usize; 2],
    edge: [usize; 2],
    counts: [usize; 2],
    channels: usize,
    /// Channels of density, which come first.
    density: usize,
    /// Fraction bits of density and of appearance.
    frac_bits: [u32; 2],
    /// Rows of each MVoxel, channels fastest, then the first axis.
    rows: Vec<Vec<i16>>,
}

/// A sample of a camera's ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// Column and row.
    pub pixel: [u32; 2],
    /// In the world.
    pub at: DVec3,
    /// Of its ray in its group.
    slot: u32,
}

/// Whose features an entry gathers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Source {
    /// Which of the tables.
    pub table: usize,
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
    /// Ray after ray, front to back.
    pub samples: Vec<Sample>,
}

/// An entry, its MVoxel, and how far that is from the camera's.
struct Placed {
    distance: u64,
    mvoxel: usize,
    sample: usize,
    entry: RitEntry,
}

/// The halves of a plane's MVoxel with so many rows: powers of two.
fn rectangle(rows: usize) -> [usize; 2] {
    let high = 1 << rows.isqrt().max(1).ilog2();
    let wide = 1 << (rows / high).max(1).ilog2();
    [wide, high]
}

impl TiledTable {
    fn new(table: &Table, density: usize, config: &Config) -> Result<Self, FieldError> {
        let [x, y, _] = table.points();
        // A row number has 16 bits.
        let rows = (config.mvoxel.rows as usize).min(1 << 16);
        let edge = if y > 1 { rectangle(rows) } else { [rows, 1] };
        if edge[0] < 2 || (y > 1 && edge[1] < 2) {
            let expected = "4 rows or more, for 2 x 2 vertices";
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        }
        let channels = table.channels();
        let bits = config.gu.feature_bits;
        let of = |appearance: bool| {
            let values = table.values().iter().enumerate();
            let own = values.filter(move |(i, _)| (i % channels >= density) == appearance);
            own.map(|(_, v)| v)
        };
        let frac_bits = [
            finest(of(false), bits, "density components")?,
            finest(of(true), bits, "appearance components")?,
        ];
        let code = |(i, v): (usize, &f32)| {
            let frac = frac_bits[usize::from(i % channels >= density)];
            quantised(*v, bits, frac)
        };
        let codes: Vec<i16> = table.values().iter().enumerate().map(code).collect();
        let along = |points: usize, edge: usize| match points {
            1 => 1,
            _ => (points - 1).div_ceil(edge - 1),
        };
        let mut tiled = Self {
            points: [x, y],
            edge,
            counts: [along(x, edge[0]), along(y, edge[1])],
            channels,
            density,
            frac_bits,
            rows: vec![],
        };
        tiled.rows = (0..tiled.counts[0] * tiled.counts[1])
            .map(|mvoxel| tiled.cut(mvoxel, &codes))
            .collect();
        Ok(tiled)
    }

    fn cut(&self, mvoxel: usize, codes: &[i16]) -> Vec<i16> {
        let [wide, high] = self.extent(mvoxel);
        let [x, y] = self.first(mvoxel);
        let mut rows = Vec::with_capacity(wide * high * self.channels);
        for line in y..y + high {
            let start = (x + self.points[0] * line) * self.channels;
            rows.extend_from_slice(&codes[start..][..wide * self.channels]);
        }
        rows
    }

    /// Cells along each axis of an MVoxel; 1 where there are none.
    fn stride(&self) -> [usize; 2] {
        self.edge.map(|edge| (edge - 1).max(1))
    }

    fn index(&self, mvoxel: usize) -> [usize; 2] {
        [mvoxel % self.counts[0], mvoxel / self.counts[0]]
    }

    fn first(&self, mvoxel: usize) -> [usize; 2] {
        let (index, stride) = (self.index(mvoxel), self.stride());
        [index[0] * stride[0], index[1] * stride[1]]
    }

    fn extent(&self, mvoxel: usize) -> [usize; 2] {
        let first = self.first(mvoxel);
        [0, 1].map(|axis| self.edge[axis].min(self.points[axis] - first[axis]))
    }

    /// Vertices an entry.
    #[must_use]
    pub fn vertices(&self) -> Vertices {
        if self.points[1] > 1 {
            Vertices::Four
        } else {
            Vertices::Two
        }
    }

    /// MVoxels along each axis.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        self.counts
    }

    /// Fraction bits of a channel's codes.
    #[must_use]
    pub fn frac_bits(&self, channel: usize) -> u32 {
        self.frac_bits[usize::from(channel >= self.density)]
    }

    /// The MVoxel of a place in vertices, and the entry that gathers there.
    fn entry(&self, place: DVec3, slot: u32, weight_bits: u32) -> (usize, RitEntry) {
        let (mut index, mut local, mut fraction) = ([0; 2], [0; 2], [0; 2]);
        let stride = self.stride();
        for axis in 0..2 {
            let cells = self.points[axis] - 1;
            let code = position_code(place[axis]).max(0) as u64;
            let code = code.min((cells as u64) << FRACTION_BITS);
            let cell = ((code >> FRACTION_BITS) as usize).min(cells.saturating_sub(1));
            index[axis] = cell / stride[axis];
            local[axis] = cell % stride[axis];
            fraction[axis] = (code - ((cell as u64) << FRACTION_BITS)) as u16;
        }
        let mvoxel = index[0] + self.counts[0] * index[1];
        let [wide, _] = self.extent(mvoxel);
        let low = local[0] + wide * local[1];
        let mut entry = RitEntry {
            slot,
            rows: [0; MAX_VERTICES],
            weights: [0; MAX_VERTICES],
        };
        let count = self.vertices().count();
        for (corner, row) in entry.rows[..count].iter_mut().enumerate() {
            *row = (low + (corner & 1) + wide * (corner >> 1)) as u16;
        }
        match self.vertices() {
            Vertices::Four => {
                entry.weights[..4].copy_from_slice(&weights::bilinear(fraction, weight_bits));
            }
            _ => entry.weights[..2].copy_from_slice(&weights::linear(fraction[0], weight_bits)),
        }
        (mvoxel, entry)
    }

    /// How far an MVoxel is from the one of the camera, which is at `camera` in
    /// vertices.
    fn distance(&self, mvoxel: usize, camera: DVec3) -> u64 {
        let (index, stride) = (self.index(mvoxel), self.stride());
        let along = |axis: usize| {
            if self.points[axis] == 1 {
                return 0;
            }
            let own = position_code(camera[axis])
                .div_euclid((stride[axis] as i64) << FRACTION_BITS)
                // Far enough, and no sum of two overflows.
                .clamp(-(1 << 50), 1 << 50);
            own.abs_diff(index[axis] as i64)
        };
        along(0) + along(1)
    }

    /// A task that loads the rows up to the last that its entries use.
    fn task(&self, mvoxel: usize, entries: Vec<RitEntry>) -> GatherTask {
        let vertices = self.vertices();
        let top = vertices.count() - 1;
        let last = entries.iter().map(|e| e.rows[top]).max();
        let used = (usize::from(last.unwrap_or_default()) + 1) * self.channels;
        GatherTask {
            vertices,
            channels: self.channels,
            rows: self.rows[mvoxel][..used].to_vec(),
            entries,
        }
    }
}

/// A coordinate with 12 fraction bits, to nearest; monotone, and saturating.
fn position_code(v: f64) -> i64 {
    (v * f64::from(1u32 << FRACTION_BITS)).round() as i64
}

impl Tensorf {
    /// The tables as codes in the MVoxels that a configuration's rows hold.
    ///
    /// # Errors
    /// A configuration whose gathering unit has no entries of four and two
    /// vertices, too few segments or too few rows, or values that no format
    /// holds.
    pub fn tiled(&self, config: &Config) -> Result<Tiled<'_>, FieldError> {
        let built = config.supported_vertices();
        if ![Vertices::Four, Vertices::Two]
            .iter()
            .all(|v| built.contains(v))
        {
            let counts: Vec<_> = built.iter().map(|v| v.count()).collect();
            let expected = "4 and 2 among them, for planes and lines";
            return Err(part("gu.vertices", format!("{counts:?}"), expected));
        }
        let channels = self.tables.iter().map(Table::channels).max().unwrap_or(0);
        let segments = config.segments(channels);
        if segments > config.gu.segments as usize {
            let expected = format!("{segments} or more, for {channels} channels");
            return Err(part(
                "gu.segments",
                config.gu.segments.to_string(),
                expected,
            ));
        }
        let tables = self.tables.iter().enumerate();
        let tables = tables.map(|(i, table)| TiledTable::new(table, self.density[i % 3], config));
        Ok(Tiled {
            field: self,
            tables: tables.collect::<Result<_, _>>()?,
            weight_bits: config.gu.weight_bits,
        })
    }
}

impl Tiled<'_> {
    /// Planes, then lines.
    #[must_use]
    pub fn tables(&self) -> &[TiledTable] {
        &self.tables
    }

    /// The gathering tasks of a camera's samples in the memory-centric order, as
    /// if no ray stopped early, up to `most` entries; the last ray may exceed
    /// it.
    ///
    /// # Errors
    /// A camera without pixels, or a sampling that would not end.
    pub fn tasks(&self, camera: &Camera, most: usize) -> Result<Vec<GatherTask>, FieldError> {
        Ok(self.gathers(camera, most)?.tasks)
    }

    /// The same, with the places in the world that entries belong to.
    ///
    /// # Errors
    /// As [`Tiled::tasks`].
    pub fn gathers(&self, camera: &Camera, most: usize) -> Result<Gathers, FieldError> {
        let sampling = self.field.sampling();
        check(camera, &sampling)?;
        let side = default_group_side();
        let mut places = [DVec3::ZERO; ENTRIES];
        let mut all = Gathers::default();
        let enough = most.div_ceil(ENTRIES);
        for top in (0..camera.height).step_by(side as usize) {
            for left in (0..camera.width).step_by(side as usize) {
                let first = all.samples.len();
                let columns = left..camera.width.min(left + side);
                let lines = top..camera.height.min(top + side);
                let pixels = lines.flat_map(|y| columns.clone().map(move |x| [x, y]));
                for (slot, pixel) in (0..).zip(pixels) {
                    if all.samples.len() >= enough {
                        break;
                    }
                    let ray = Samples::of(&sampling, camera, pixel);
                    let inside = (0..ray.count).map(|k| ray.at(k));
                    let seen = inside.filter(|at| self.field.index(*at, &mut places));
                    all.samples
                        .extend(seen.map(|at| Sample { pixel, at, slot }));
                }
                self.visit(camera, first, &mut all);
            }
        }
        Ok(all)
    }

    /// Appends the tasks of a group, whose samples begin with number `first`.
    fn visit(&self, camera: &Camera, first: usize, all: &mut Gathers) {
        let mut places = [DVec3::ZERO; ENTRIES];
        let mut eye = [DVec3::ZERO; ENTRIES];
        self.field.place(camera.position(), &mut eye);
        for (number, table) in self.tables.iter().enumerate() {
            let samples = all.samples.iter().enumerate().skip(first);
            let mut entries: Vec<Placed> = samples
                .map(|(sample, Sample { at, slot, .. })| {
                    self.field.place(*at, &mut places);
                    let (mvoxel, entry) = table.entry(places[number], *slot, self.weight_bits);
                    Placed {
                        distance: table.distance(mvoxel, eye[number]),
                        mvoxel,
                        sample,
                        entry,
                    }
                })
                .collect();
            entries.sort_unstable_by_key(|e| (e.distance, e.mvoxel, e.sample));
            for same in entries.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
                let own = same.iter().map(|e| e.entry).collect();
                all.tasks.push(table.task(same[0].mvoxel, own));
                all.sources.extend(same.iter().map(|e| Source {
                    table: number,
                    sample: e.sample,
                }));
            }
        }
    }
}

#[cfg(test)]
#[path = "gather_tests.rs"]
mod tests;
