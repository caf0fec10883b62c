//! Conversion of PLY vertices to a cloud.

use glam::DVec3;
use rayon::prelude::*;

use super::centres::{Centres, Rounded};
use super::columns::Columns;
use crate::cloud::{Cloud, CloudError};
use crate::sigmoid;
use potamoi_base::sh;
use potamoi_containers::ply::rows::FixedRow;

/// Log scale of a size of 0: that of the smallest normal float.
const NO_SIZE: f32 = -87.336_55;
/// Vertices that one thread reads at a time.
const BLOCK: usize = 1 << 12;

/// The vertices read so far.
pub(super) struct Vertices {
    means: Vec<[f32; 3]>,
    /// Centres, if they are wider than 32-bit floats.
    wide: Vec<[f64; 3]>,
    log_scales: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    opacities: Vec<f32>,
    sh: Vec<[f32; 3]>,
    /// Number of vertices that were read.
    read: usize,
}

/// The places of some vertices that lie one after another.
struct Places<'a> {
    means: &'a mut [[f32; 3]],
    /// Empty unless centres are wide.
    wide: &'a mut [[f64; 3]],
    log_scales: &'a mut [[f32; 3]],
    rotations: &'a mut [[f32; 4]],
    opacities: &'a mut [f32],
    sh: &'a mut [[f32; 3]],
}

impl Vertices {
    /// Room for `count` vertices. This is safe: the file holds bytes for each.
    pub(super) fn new(columns: &Columns, count: usize) -> Self {
        // Memory that is never written is never taken.
        Self {
            means: vec![[0.0; 3]; count],
            wide: vec![[0.0; 3]; if columns.wide { count } else { 0 }],
            log_scales: vec![[0.0; 3]; count],
            rotations: vec![[0.0; 4]; count],
            opacities: vec![0.0; count],
            sh: vec![[0.0; 3]; count.saturating_mul(sh::coefficients(columns.degree))],
            read: 0,
        }
    }

    /// Adds a vertex. The error is the column of an invalid value.
    pub(super) fn push(&mut self, columns: &Columns, values: &[f64]) -> Result<(), usize> {
        let value = |column: usize| values.get(column).copied().unwrap_or(f64::NAN);
        let mut blocks = self.next(columns, 1);
        let done = blocks
            .iter_mut()
            .try_for_each(|own| own.fill(columns, 0, value));
        self.read += 1;
        done
    }

    /// Adds vertices, as many as `rows` holds, in parallel. The error is the index of the first vertex
    /// with an invalid value, among those that were added, and the column of the value.
    pub(super) fn extend(
        &mut self,
        columns: &Columns,
        row: &FixedRow,
        rows: &[u8],
    ) -> Result<(), (usize, usize)> {
        let count = rows.len() / row.stride;
        let blocks = self.next(columns, count);
        let wrong = blocks
            .into_par_iter()
            .zip(rows.par_chunks(BLOCK * row.stride))
            .enumerate()
            .filter_map(|(block, (mut own, rows))| {
                let mut rows = rows.chunks_exact(row.stride).enumerate();
                rows.find_map(|(at, bytes)| {
                    let done = own.fill(columns, at, |column| row.value(bytes, column));
                    done.err().map(|column| (block * BLOCK + at, column))
                })
            })
            .min();
        self.read += count;
        wrong.map_or(Ok(()), Err)
    }

    /// The places of the next `count` vertices, in blocks.
    fn next(&mut self, columns: &Columns, count: usize) -> Vec<Places<'_>> {
        let own = self.read..self.read + count;
        let each = sh::coefficients(columns.degree);
        let wide = if columns.wide { own.clone() } else { 0..0 };
        let mut wide = self.wide[wide].chunks_mut(BLOCK);
        let mut log_scales = self.log_scales[own.clone()].chunks_mut(BLOCK);
        let mut rotations = self.rotations[own.clone()].chunks_mut(BLOCK);
        let mut opacities = self.opacities[own.clone()].chunks_mut(BLOCK);
        let mut sh = self.sh[own.start * each..own.end * each].chunks_mut(BLOCK * each);
        let means = self.means[own].chunks_mut(BLOCK);
        means
            .map(|means| Places {
                means,
                wide: wide.next().unwrap_or_default(),
                log_scales: log_scales.next().unwrap_or_default(),
                rotations: rotations.next().unwrap_or_default(),
                opacities: opacities.next().unwrap_or_default(),
                sh: sh.next().unwrap_or_default(),
            })
            .collect()
    }
    /// The cloud, the position of its origin in the file's world, and the centres that are still
    /// rounded.
    pub(super) fn finish(
        mut self,
        columns: &Columns,
    ) -> Result<(Cloud, DVec3, Option<Rounded>), CloudError> {
        let centres = Centres {
            wide: &self.wide,
            log_scales: &self.log_scales,
        };
        let origin = centres.origin();
        let rounded = centres.rounded(origin);
        for (mean, wide) in self.means.iter_mut().zip(&self.wide) {
            for axis in 0..3 {
                if origin[axis] != 0.0 {
                    mean[axis] = (wide[axis] - origin[axis]) as f32;
                }
            }
        }
        let cloud = Cloud::new(
            columns.degree,
            self.means,
            self.log_scales,
            self.rotations,
            self.opacities,
            self.sh,
        )?;
        Ok((cloud, origin, rounded))
    }
}

impl Places<'_> {
    /// Writes the vertex at place `at` from the values of its columns. The error is the column of an
    /// invalid value.
    #[inline]
    fn fill(
        &mut self,
        columns: &Columns,
        at: usize,
        value: impl Fn(usize) -> f64,
    ) -> Result<(), usize> {
        let get = |column: usize| -> Result<f32, usize> {
            let value = value(column) as f32;
            if value.is_finite() {
                Ok(value)
            } else {
                Err(column)
            }
        };
        let three =
            |c: [usize; 3]| -> Result<[f32; 3], usize> { Ok([get(c[0])?, get(c[1])?, get(c[2])?]) };
        self.means[at] = three(columns.mean)?;
        if let Some(wide) = self.wide.get_mut(at) {
            *wide = columns.mean.map(&value);
        }
        let mut scales = [NO_SIZE; 3];
        for (scale, column) in scales.iter_mut().zip(columns.scale) {
            let Some(column) = column else { continue };
            // The logarithm of 0 is a size as others are.
            if value(column) != f64::NEG_INFINITY {
                *scale = get(column)?;
            }
        }
        let r = columns.rotation;
        self.rotations[at] = [get(r[0])?, get(r[1])?, get(r[2])?, get(r[3])?];
        let opacity = value(columns.opacity);
        if opacity.is_nan() {
            return Err(columns.opacity);
        }
        let mut opacity = opacity as f32;
        if let Some(column) = columns.filter {
            let width = f64::from(get(column)?);
            if width < 0.0 {
                return Err(column);
            }
            (scales, opacity) = filtered(scales, opacity, width);
        }
        self.log_scales[at] = scales;
        self.opacities[at] = opacity;
        let each = sh::coefficients(columns.degree);
        let colours = &mut self.sh[at * each..(at + 1) * each];
        colours[0] = three(columns.constant)?;
        for (c, to) in colours[1..].iter_mut().enumerate() {
            *to = three([0, 1, 2].map(|channel| columns.rest[channel * (each - 1) + c]))?;
        }
        Ok(())
    }
}

/// Applies Mip-Splatting's 3D filter of a given width to a Gaussian (Yu, Chen, Huang, Sattler,
/// Geiger: Mip-Splatting, CVPR 2024, section 3.1): variances grow by its square, and the opacity
/// falls by the ratio of the volumes.
fn filtered(scales: [f32; 3], logit: f32, width: f64) -> ([f32; 3], f32) {
    let mut kept = 1.0;
    let scales = scales.map(|log| {
        let own = (2.0 * f64::from(log)).exp();
        let wider = own + width * width;
        if wider == 0.0 {
            return log;
        }
        kept *= (own / wider).sqrt();
        (0.5 * wider.ln()) as f32
    });
    let logit = f64::from(logit);
    // The part that is clear, without a difference of numbers near 1.
    let [opacity, clear] = [sigmoid(logit), sigmoid(-logit)];
    let clear = clear + opacity * (1.0 - kept);
    (scales, (opacity * kept / clear).ln() as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_filter_of_no_width_changes_nothing_and_a_wide_one_fades() {
        for logit in [-8.0f32, 0.0, 3.0] {
            let (scales, found) = filtered([-1.0, -2.0, -87.0], logit, 0.0);
            assert!((found - logit).abs() < 1e-5);
            assert!((scales[1] + 2.0).abs() < 1e-6);
        }
        assert_eq!(filtered([-1.0; 3], f32::INFINITY, 0.0).1, f32::INFINITY);
        let (scales, logit) = filtered([0.0; 3], 2.0, 3f64.sqrt());
        let kept = sigmoid(f64::from(logit)) / sigmoid(2.0);
        assert!((kept - 0.125).abs() < 1e-6 && (scales[0] - 2f32.ln()).abs() < 1e-6);
        assert_eq!(filtered([NO_SIZE; 3], 2.0, 1.0).0, [0.0; 3]);
    }

    #[test]
    fn no_size_is_that_of_the_smallest_normal_float() {
        assert_eq!(NO_SIZE, f32::MIN_POSITIVE.ln());
    }
}
