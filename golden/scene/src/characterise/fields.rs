//! Accesses of fields that are sampled along rays, and of colours from such fields.

use std::borrow::Cow;

use glam::DVec3;

use super::accesses::{Lanes, Vectors, count, firsts, rows_of};
use super::full_size::with_entries;
use super::{Accesses, FullSize};
use potamoi_fields::{FieldError, HashedColour, RayLengths, Table, TableShape};

/// The rows that samples read, numbered table after table.
struct Rows<'a> {
    tables: Vec<Cow<'a, TableShape>>,
    firsts: Vec<u32>,
}

impl<'a> Rows<'a> {
    fn new(tables: Vec<Cow<'a, TableShape>>) -> Result<(Self, Vec<Vectors>), FieldError> {
        let vectors: Vec<Vectors> = tables
            .iter()
            .map(|table| rows_of(table))
            .collect::<Result<_, _>>()?;
        let firsts = firsts(&vectors)?;
        Ok((Self { tables, firsts }, vectors))
    }

    /// Maximum number of rows a sample.
    fn a_sample(&self) -> usize {
        self.tables.iter().map(|table| table.vertices()).sum()
    }

    fn list(&self, place: impl Fn(usize) -> DVec3, out: &mut Vec<u32>) {
        for (number, (table, first)) in self.tables.iter().zip(&self.firsts).enumerate() {
            table.corners(place(number), |row, _| out.push(first + row as u32));
        }
    }
}

/// Lanes with one ray each.
struct Rays<'a> {
    stops: &'a RayLengths<'a>,
    rows: Rows<'a>,
    full: Option<&'a FullSize>,
    /// Number of samples that replace one.
    parts: u32,
}

impl Rays<'_> {
    fn pixel(&self, lane: usize) -> [u32; 2] {
        let width = self.stops.camera().width;
        [lane as u32 % width, lane as u32 / width]
    }
}

impl Lanes for Rays<'_> {
    fn count(&self) -> usize {
        let camera = self.stops.camera();
        camera.width as usize * camera.height as usize
    }

    fn reads(&self, lane: usize) -> usize {
        let samples = self.stops.gathered(self.pixel(lane)) as usize;
        samples * self.parts as usize * self.rows.a_sample()
    }

    fn list(&self, lane: usize, out: &mut Vec<u32>) {
        let mut places = vec![DVec3::ZERO; self.stops.field().tables().len()];
        let pixel = self.pixel(lane);
        self.stops
            .samples(pixel, self.parts, &mut places, |places| {
                let place = |number: usize| {
                    let own = places[number];
                    self.full.map_or(own, |full| full.place(number, own))
                };
                self.rows.list(place, out);
            });
    }
}

/// Reads of a frame: every row of every gathered sample, one lane a ray, rays of a picture row
/// side by side, through a buffer of `capacity` bytes. Vectors are the rows of the tables, with
/// two bytes a channel.
///
/// With `full`, rows are those of larger tables that replace the field's.
///
/// # Errors
/// The tables have 2^32 rows or more.
pub fn field_accesses(
    stops: &RayLengths<'_>,
    full: Option<&FullSize>,
    capacity: u32,
) -> Result<Accesses, FieldError> {
    let tables = match full {
        None => stops.field().tables().iter().map(Table::shape).collect(),
        Some(full) => full.tables().iter().collect::<Vec<_>>(),
    };
    let (rows, vectors) = Rows::new(tables.into_iter().map(Cow::Borrowed).collect())?;
    let rays = Rays {
        stops,
        rows,
        full,
        parts: full.map_or(1, FullSize::parts),
    };
    count(vectors, &[&rays], capacity)
}

/// Lanes with the colour of one Gaussian each.
pub(super) struct Colours<'a> {
    field: &'a HashedColour,
    centres: &'a [[f32; 3]],
    rows: Rows<'a>,
}

impl<'a> Colours<'a> {
    /// Colours of Gaussians at `centres`, and the vectors of the field. Its tables have `entries`
    /// entries if given, otherwise their own number.
    pub(super) fn new(
        field: &'a HashedColour,
        centres: &'a [[f32; 3]],
        entries: Option<usize>,
    ) -> Result<(Self, Vec<Vectors>), FieldError> {
        let tables = field.tables().iter().map(|table| match entries {
            None => Ok(Cow::Borrowed(table.shape())),
            Some(entries) => with_entries(table, entries).map(Cow::Owned),
        });
        let (rows, vectors) = Rows::new(tables.collect::<Result<_, _>>()?)?;
        let made = Self {
            field,
            centres,
            rows,
        };
        Ok((made, vectors))
    }
}

impl Lanes for Colours<'_> {
    fn count(&self) -> usize {
        self.centres.len()
    }

    fn reads(&self, _: usize) -> usize {
        self.rows.a_sample()
    }

    fn list(&self, lane: usize, out: &mut Vec<u32>) {
        let mut places = vec![DVec3::ZERO; self.rows.tables.len()];
        let at = DVec3::from(self.centres[lane].map(f64::from));
        self.field.index(at, &mut places);
        self.rows.list(|number| places[number], out);
    }
}
