//! Grids of vertices with density and colour features.

use glam::DVec3;

use crate::Table;
use potamoi_march::MarchError;

/// Maximum number of vertices along an axis.
pub const MAX_POINTS: usize = 2048;
/// Maximum number of feature values in a grid.
pub const MAX_VALUES: usize = 1 << 30;

/// Layout of the channels of a vertex.
///
/// Channel 0 is the density, an optical depth per voxel edge before its ReLU.
/// Then, for red, green and blue in turn, the coefficients of the colour seen
/// along the unit direction (x, y, z) from the camera into the scene:
///
/// - `Constant`, 4 channels in all: `c0`
/// - `Linear`, 13 channels in all: `c0 + c1 x + c2 y + c3 z`, which are the
///   spherical harmonics of degree 0 and 1 with their constant factors folded
///   into the coefficients
///
/// Colours pass a ReLU and have no upper limit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Layout {
    /// The same colour from every direction.
    Constant,
    /// A colour that is linear in the viewing direction.
    Linear,
}

impl Layout {
    /// Number of coefficients of one colour channel.
    #[must_use]
    pub const fn coefficients(self) -> usize {
        match self {
            Self::Constant => 1,
            Self::Linear => 4,
        }
    }

    /// Number of channels `C` of a vertex.
    #[must_use]
    pub const fn channels(self) -> usize {
        1 + 3 * self.coefficients()
    }
}

/// A regular grid of vertices with features, in floating point.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Grid {
    table: Table,
    corner: DVec3,
    voxel: f64,
    layout: Layout,
}

impl Grid {
    /// A grid of `points` vertices along x, y, z. Vertex (0, 0, 0) lies at `corner`; cubic voxels
    /// have edges of `voxel`. `features` holds all channels of a vertex side by side, vertices
    /// with x fastest, z slowest.
    ///
    /// # Errors
    /// There are fewer than 2 or more than [`MAX_POINTS`] vertices along an axis or more than
    /// [`MAX_VALUES`] values, the number of values is wrong, the voxel edge is not positive, or a
    /// value is not finite.
    pub fn new(
        points: [usize; 3],
        corner: DVec3,
        voxel: f64,
        layout: Layout,
        features: Vec<f32>,
    ) -> Result<Self, MarchError> {
        let refuse = |field, value: String, expected: String| {
            Err(MarchError::Grid {
                field,
                value,
                expected,
            })
        };
        if points.iter().any(|p| !(2..=MAX_POINTS).contains(p)) {
            let expected = format!("2 to {MAX_POINTS} vertices along each axis");
            return refuse("points", format!("{points:?}"), expected);
        }
        // Each factor is at most 2048: no overflow.
        let values = points.iter().product::<usize>() * layout.channels();
        if values > MAX_VALUES {
            let expected = format!("at most {MAX_VALUES} feature values, here {values}");
            return refuse("points", format!("{points:?}"), expected);
        }
        if features.len() != values {
            let expected = format!("{values}: one a vertex and channel");
            return refuse("features.len()", features.len().to_string(), expected);
        }
        if !(voxel.is_finite() && voxel > 0.0) {
            return refuse("voxel", voxel.to_string(), "a positive length".to_owned());
        }
        if !corner.is_finite() {
            return refuse("corner", corner.to_string(), "finite numbers".to_owned());
        }
        if let Some((i, v)) = features.iter().enumerate().find(|(_, v)| !v.is_finite()) {
            let (vertex, channel) = (i / layout.channels(), i % layout.channels());
            let value = format!("{v} at vertex {vertex}, channel {channel}");
            return refuse("features", value, "finite numbers".to_owned());
        }
        let table = Table::new(points, layout.channels(), features);
        let table = table.map_err(|e| MarchError::Grid {
            field: "features",
            value: e.to_string(),
            expected: "a table".to_owned(),
        })?;
        Ok(Self {
            table,
            corner,
            voxel,
            layout,
        })
    }

    /// Samples a grid from a function. `field` writes the channels of the vertex at a world
    /// position.
    ///
    /// # Errors
    /// Those of [`Grid::new`].
    pub fn bake(
        points: [usize; 3],
        corner: DVec3,
        voxel: f64,
        layout: Layout,
        mut field: impl FnMut(DVec3, &mut [f32]),
    ) -> Result<Self, MarchError> {
        let channels = layout.channels();
        let empty = |value: &usize| !(2..=MAX_POINTS).contains(value);
        let values = if points.iter().any(empty) {
            0
        } else {
            points.iter().product::<usize>() * channels
        };
        let mut features = vec![0f32; if values > MAX_VALUES { 0 } else { values }];
        for (i, vertex) in features.chunks_exact_mut(channels).enumerate() {
            let (x, y, z) = (
                i % points[0],
                i / points[0] % points[1],
                i / (points[0] * points[1]),
            );
            let at = corner + voxel * DVec3::new(x as f64, y as f64, z as f64);
            field(at, vertex);
        }
        Self::new(points, corner, voxel, layout, features)
    }

    /// Number of vertices along x, y, z.
    #[must_use]
    pub fn points(&self) -> [usize; 3] {
        self.table.points()
    }

    /// World position of vertex (0, 0, 0).
    #[must_use]
    pub fn corner(&self) -> DVec3 {
        self.corner
    }

    /// Edge of a voxel in world units.
    #[must_use]
    pub fn voxel(&self) -> f64 {
        self.voxel
    }

    /// The layout of the channels.
    #[must_use]
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// All values, channels fastest, then x, y, z.
    #[must_use]
    pub fn features(&self) -> &[f32] {
        self.table.values()
    }

    /// The features as a table with a row for each vertex.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.table
    }

    /// Corners of the box whose faces contain the outer vertices, in world coordinates.
    #[must_use]
    pub fn bounds(&self) -> [DVec3; 2] {
        let last = DVec3::from(self.points().map(|p| (p - 1) as f64));
        [self.corner, self.corner + last * self.voxel]
    }

    /// Converts a world position to vertex units, where vertex (x, y, z) lies at (x, y, z).
    #[must_use]
    pub fn to_grid(&self, world: DVec3) -> DVec3 {
        (world - self.corner) / self.voxel
    }

    /// Interpolates all channels in 64-bit floating point at a position in vertex units, clamped
    /// to the volume.
    pub fn sample(&self, at: DVec3, out: &mut [f64]) {
        self.table.gather(at, out);
    }
}
