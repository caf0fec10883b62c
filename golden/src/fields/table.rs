//! Tables of features at the vertices of a line, a plane or a volume.

use glam::DVec3;

use super::FieldError;

/// The most vertices along an axis.
const MAX_POINTS: usize = 1 << 14;
/// The most values of a table.
const MAX_VALUES: usize = 1 << 30;

/// A dense table. Lines have one axis of more than one vertex, planes two,
/// volumes three.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    points: [usize; 3],
    channels: usize,
    values: Vec<f32>,
}

impl Table {
    /// A table of `points` vertices along each axis, x fastest, `channels`
    /// values a vertex.
    ///
    /// # Errors
    /// Sizes out of range, another number of values, or one that is not finite.
    pub fn new(points: [usize; 3], channels: usize, values: Vec<f32>) -> Result<Self, FieldError> {
        let refuse = |part, found: String, expected: String| {
            Err(FieldError::Part {
                part,
                found,
                expected,
            })
        };
        if points.iter().any(|p| !(1..=MAX_POINTS).contains(p)) {
            let expected = format!("1 to {MAX_POINTS} vertices along each axis");
            return refuse("table.points", format!("{points:?}"), expected);
        }
        // Below 2^42 times the channels.
        let count = points.iter().product::<usize>().checked_mul(channels);
        let Some(count) = count.filter(|n| (1..=MAX_VALUES).contains(n)) else {
            let expected = format!("1 to {MAX_VALUES} values");
            return refuse("table", format!("{points:?} x {channels}"), expected);
        };
        if values.len() != count {
            let expected = format!("{count}, one a vertex and channel");
            return refuse("table.values.len()", values.len().to_string(), expected);
        }
        if let Some(at) = values.iter().position(|v| !v.is_finite()) {
            let found = format!(
                "{} at vertex {}, channel {}",
                values[at],
                at / channels,
                at % channels
            );
            return refuse("table.values", found, "finite numbers".to_owned());
        }
        Ok(Self {
            points,
            channels,
            values,
        })
    }

    /// Vertices along each axis.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Values a vertex.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// All values, channels fastest, then x, y, z.
    #[must_use]
    pub fn values(&self) -> &[f32] {
        &self.values
    }

    /// Vertices that a sample reads: 2, 4 or 8, or the only one.
    #[must_use]
    pub fn vertices(&self) -> usize {
        1 << self.points.iter().filter(|p| **p > 1).count()
    }

    /// Gathering: the multilinear interpolation at a place in vertices, held
    /// within the table, one value a channel.
    pub fn gather(&self, place: DVec3, out: &mut [f64]) {
        out.fill(0.0);
        self.corners(place, |vertex, weight| {
            let row = &self.values[vertex * self.channels..][..self.channels];
            for (sum, value) in out.iter_mut().zip(row) {
                *sum += weight * f64::from(*value);
            }
        });
    }

    /// Tells each vertex that a sample at a place reads, and its weight.
    pub fn corners(&self, place: DVec3, mut read: impl FnMut(usize, f64)) {
        let mut cell = [0usize; 3];
        let mut fraction = [0f64; 3];
        for axis in 0..3 {
            let last = self.points[axis] - 1;
            let held = place[axis].clamp(0.0, last as f64);
            cell[axis] = (held as usize).min(last.saturating_sub(1));
            fraction[axis] = held - cell[axis] as f64;
        }
        let flat = self.points.map(|points| points == 1);
        for corner in 0..8usize {
            let far = [0, 1, 2].map(|axis| corner >> axis & 1 == 1);
            if (0..3).any(|axis| far[axis] && flat[axis]) {
                continue;
            }
            let mut weight = 1.0;
            let mut index = [0; 3];
            for axis in 0..3 {
                index[axis] = cell[axis] + usize::from(far[axis]);
                weight *= match (flat[axis], far[axis]) {
                    (true, _) => 1.0,
                    (false, true) => fraction[axis],
                    (false, false) => 1.0 - fraction[axis],
                };
            }
            read(
                index[0] + self.points[0] * (index[1] + self.points[1] * index[2]),
                weight,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// A multilinear function is its own interpolation, on lines, planes and
    /// volumes.
    #[test]
    fn a_linear_field_comes_back() {
        for points in [[5, 1, 1], [1, 4, 3], [3, 1, 6], [4, 5, 6]] {
            let at = |x: f64, y: f64, z: f64| 1.0 + 2.0 * x - 3.0 * y + 0.5 * z + 0.25 * x * y;
            let mut values = vec![];
            for z in 0..points[2] {
                for y in 0..points[1] {
                    for x in 0..points[0] {
                        let value = at(x as f64, y as f64, z as f64);
                        values.extend([value as f32, -value as f32]);
                    }
                }
            }
            let table = Table::new(points, 2, values).unwrap();
            let axes = points.iter().filter(|p| **p > 1).count();
            assert_eq!(table.vertices(), 1 << axes);
            let mut out = [0.0; 2];
            for i in 0..200 {
                let place = [0, 1, 2].map(|axis| {
                    let last = (points[axis] - 1) as f64;
                    last * f64::from(i * (axis as i32 * 37 + 11) % 100) / 99.0
                });
                let held = [0, 1, 2].map(|a: usize| place[a].clamp(0.0, (points[a] - 1) as f64));
                table.gather(DVec3::from(place), &mut out);
                let exact = at(held[0], held[1], held[2]);
                assert!(
                    (out[0] - exact).abs() < 1e-9 && out[1] == -out[0],
                    "{place:?}"
                );
            }
            // Outside, the nearest place of the table.
            table.gather(DVec3::splat(-3.0), &mut out);
            assert_eq!(out[0], 1.0);
        }
    }

    #[test]
    fn what_is_no_table_is_refused() {
        let error = |points, channels, values: Vec<f32>| {
            Table::new(points, channels, values)
                .unwrap_err()
                .to_string()
        };
        assert!(error([0, 1, 1], 1, vec![]).contains("vertices along each axis"));
        assert!(error([2, 1, 1], 0, vec![]).contains("table"));
        assert!(error([2, 1, 1], 1, vec![1.0]).contains("2, one a vertex"));
        assert!(error([2, 1, 1], 2, vec![0.0, 0.0, 0.0, f32::NAN]).contains("vertex 1, channel 1"));
        assert!(error([1 << 14; 3], 4, vec![]).contains("values"));
    }
}
