//! A grid in the hardware's formats.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::field::StoredField;
use super::formats::{Formats, code};
use super::grid::Grid;
use super::head::Stored;
use crate::volume::{CodedVolume, MVoxels, Placement};
use potamoi_march::{MarchError, Transparent};

impl Grid {
    pub(super) fn placement(&self) -> Placement {
        Placement {
            points: self.points(),
            corner: self.corner(),
            spacing: DVec3::splat(self.voxel()),
            edge: self.voxel(),
            range: [0.0, f64::INFINITY],
        }
    }
}

impl StoredField {
    /// Quantises the grid for a configuration.
    ///
    /// # Errors
    /// Those of [`Formats::new`], or there are rows for less than 2 x 2 x 2 vertices.
    pub(super) fn fixed(&self, config: &Config) -> Result<(CodedVolume, Stored), MarchError> {
        let grid = &*self.grid;
        let formats = Formats::new(grid, config)?;
        let channels = grid.layout().channels();
        let codes = grid.features().iter().enumerate();
        let codes = codes.map(|(i, v)| match i % channels {
            0 => code(formats.density, *v),
            _ => code(formats.colour, *v),
        });
        let codes: Vec<i16> = codes.collect();
        let volume = CodedVolume {
            mvoxels: MVoxels::of_codes(grid.points(), channels, &codes, config, |v| v[0] > 0)?,
            placement: grid.placement(),
            step: self.step,
        };
        let head = Stored {
            layout: grid.layout(),
            formats,
            step: Formats::step_code(self.step),
            transparent: Transparent::of(config, 0),
        };
        Ok((volume, head))
    }
}
