//! Memory behaviour of any scene.

use potamoi_formats::config::{Config, PRESETS};
use rayon::join;

use super::{Kind, Model, Scene, SceneError};
use crate::characterise::{
    Accesses, FullSize, SplatPairs, Stages, Traffic, colour_traffic, field_accesses, field_stages,
    splat_accesses, splat_pairs, splat_stages, splat_traffic, table_traffic, traffic,
};
use potamoi_base::mask::Mask;
use potamoi_fields::Size;
use potamoi_fields::{Field, FieldError, FixedField, FixedOptions, RayLengths};
use potamoi_gaussians::Cloud;
use potamoi_reference::ReferenceUnits;
use potamoi_splats::View;

/// Memory behaviour of a frame in both orders, and time of its stages.
#[derive(Debug, Clone, PartialEq)]
pub struct Characterised {
    /// Reads of feature vectors in pixel-centric order.
    pub accesses: Accesses,
    /// Traffic of the memory-centric order, by side of ray groups, and by halo if MVoxels share
    /// vertices.
    pub traffic: Vec<Traffic>,
    /// Time of the paper's three stages in the float renderer, measured.
    pub stages: Stages,
    /// Pairs of pixel and Gaussian; `None` for fields, and for exponentials of which no pairs can be
    /// left out.
    pub pairs: Option<SplatPairs>,
}

impl Scene {
    /// Characterises a frame: its reads through a buffer of `capacity` bytes, and its traffic for
    /// each side of ray groups. With `full`, reads are those of tables of the size that the
    /// algorithm's authors use, if [`Model::full_size`] has it.
    ///
    /// # Errors
    /// Those of [`Scene::render_float`], or the configuration's rows cannot hold a cell of a
    /// table.
    pub fn characterise(
        &self,
        config: &Config,
        capacity: u32,
        sides: &[u32],
        full: bool,
    ) -> Result<Characterised, SceneError> {
        let full = self.model.full_size().filter(|_| full);
        match self.model.kind() {
            Kind::Splats(cloud) => self.of_splats(cloud, config, capacity, sides, full),
            Kind::Field(field) => {
                let traffic = || self.of_coded(field, config, sides);
                self.of_field(field, capacity, full, traffic)
            }
        }
    }

    /// Reads of feature vectors of a frame, or of a mask's pixels, in pixel-centric order through
    /// a buffer of `capacity` bytes with oracle replacement. Of splats, the configuration decides which
    /// (tile, Gaussian) pairs are listed.
    ///
    /// # Errors
    /// Those of [`Scene::render_float`], or the mask does not have the camera's size.
    pub fn accesses(
        &self,
        config: &Config,
        capacity: u32,
        only: Option<&Mask>,
    ) -> Result<Accesses, SceneError> {
        let field = |field: &dyn Field| -> Result<Accesses, SceneError> {
            let field = self.stopping(field);
            let stops = RayLengths::masked(&field, &self.camera, only)?;
            Ok(field_accesses(&stops, None, capacity)?)
        };
        match self.model.kind() {
            Kind::Splats(cloud) => {
                let view = self.listed(View::new(cloud, &self.camera, self.profile)?, config);
                let colour = match self.model() {
                    Model::Compact(model) => Some(&**model),
                    _ => None,
                };
                Ok(splat_accesses(cloud, colour, None, &view, only, capacity)?)
            }
            Kind::Field(own) => field(own),
        }
    }

    /// The view with the pairs that the configuration lists.
    fn listed(&self, view: View, config: &Config) -> View {
        match self.tile_limits(config) {
            Some(limits) => view.that_may_count(&limits),
            None => view,
        }
    }

    fn of_field(
        &self,
        field: &dyn Field,
        capacity: u32,
        full: Option<Size>,
        traffic: impl FnOnce() -> Result<Vec<Traffic>, FieldError> + Send,
    ) -> Result<Characterised, SceneError> {
        let full = full.map(|size| FullSize::new(field, size)).transpose()?;
        let stopping = self.stopping(field);
        let stops = RayLengths::find(&stopping, &self.camera)?;
        let (accesses, traffic) = join(|| field_accesses(&stops, full.as_ref(), capacity), traffic);
        Ok(Characterised {
            accesses: accesses?,
            traffic: traffic?,
            // Alone, since it is timed.
            stages: field_stages(&stops),
            pairs: None,
        })
    }

    fn of_coded(
        &self,
        field: &dyn Field,
        config: &Config,
        sides: &[u32],
    ) -> Result<Vec<Traffic>, FieldError> {
        let stopping = self.stopping(field);
        let preset = field.algorithm().preset;
        let (able, made) = able(config, preset, |config| FixedField::new(&stopping, config))?;
        let options = FixedOptions {
            transmittance_bits: self.transmittance_bits(),
            ..FixedOptions::default()
        };
        let stops = made.stops(&self.camera, &options, &mut ReferenceUnits::new(&able))?;
        match made.volume() {
            Some(volume) => traffic(volume, &self.camera, &stops, sides),
            None => table_traffic(field, &self.camera, &stops, config, sides),
        }
    }

    fn of_splats(
        &self,
        cloud: &Cloud,
        config: &Config,
        capacity: u32,
        sides: &[u32],
        full: Option<Size>,
    ) -> Result<Characterised, SceneError> {
        let view = View::new(cloud, &self.camera, self.profile)?;
        let colour = match self.model() {
            Model::Compact(model) => Some(&**model),
            _ => None,
        };
        let options = self.splat_options(config);
        let listed = self.listed(view.clone(), config);
        let (accesses, traffic) = join(
            || splat_accesses(cloud, colour, full, &listed, None, capacity),
            || splat_traffic(cloud, &view, &options, sides),
        );
        let mut traffic = traffic?;
        if let Some(model) = colour {
            let colours = colour_traffic(model.colour(), &model.asked_at(), config)?;
            for own in &mut traffic {
                *own = own.and(colours);
            }
        }
        Ok(Characterised {
            accesses: accesses?,
            traffic,
            stages: splat_stages(cloud, &self.camera, self.profile)?,
            pairs: splat_pairs(cloud, &view, &options, &config.vu.exp)?,
        })
    }
}

/// Calls a function with a configuration, or with the vector unit of a preset if the
/// configuration's own lacks an operation. This affects where rays stop, but not the
/// traffic of an MVoxel.
fn able<T>(
    config: &Config,
    preset: &str,
    make: impl Fn(&Config) -> Result<T, FieldError>,
) -> Result<(Config, T), FieldError> {
    let made = make(config);
    let preset = PRESETS.iter().find(|(name, _)| *name == preset);
    let preset = preset.and_then(|(name, text)| Config::from_toml(text, name).ok());
    match (made, preset) {
        (Err(_), Some(preset)) => {
            let config = Config {
                vu: preset.vu,
                ..config.clone()
            };
            let made = make(&config)?;
            Ok((config, made))
        }
        (made, _) => Ok((config.clone(), made?)),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_reference::ReferenceUnits;

    /// Reads and bytes of the colours of Compact-3DGS are counted as the renderer
    /// counts them: every stream, MVoxels and entries.
    #[test]
    fn colours_of_gaussians_are_counted_as_they_are_rendered() {
        let path =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml");
        let text = std::fs::read_to_string(path).unwrap();
        let config = Config::from_toml(&text, "fields").unwrap();
        let mut scene = crate::tests::opened("cairn:compact");
        scene.set_size(Some(64), Some(48)).unwrap();
        let found = scene.characterise(&config, 1 << 21, &[64], false).unwrap();
        let mut units = ReferenceUnits::new(&config);
        let rendered = scene.render_fixed(&config, &mut units).unwrap().counts;
        let [traffic] = found.traffic[..] else {
            unreachable!("one side")
        };
        assert_eq!(traffic.streams, rendered.streams);
        assert_eq!(traffic.mvoxels, rendered.mvoxels);
        assert_eq!(traffic.entries, rendered.feature_vectors);
        assert_eq!(traffic.scattered, rendered.scattered_bytes);
        assert!(traffic.scattered > 0);

        // Every Gaussian reads eight rows of every level, besides what the same
        // Gaussians read that have colours of their own.
        let Model::Compact(model) = scene.model() else {
            unreachable!("a Compact-3DGS model")
        };
        let view = View::new(model.gaussians(), scene.camera(), scene.profile()).unwrap();
        let tiles: usize = (0..view.splats().len())
            .map(|r| view.tiles_of(r).len())
            .sum();
        let colours = 8 * model.colour().tables().len() * model.gaussians().len();
        assert_eq!(found.accesses.memory.reads, (tiles + colours) as u64);
        assert_eq!(rendered.feature_vectors, (tiles + colours / 8) as u64);
        let bytes: Vec<u32> = found.accesses.tables.iter().map(|t| t.bytes).collect();
        assert_eq!(bytes, [vec![4; 16], vec![56]].concat());
    }
}
