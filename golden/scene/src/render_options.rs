//! Render options of a scene.

use std::str::FromStr as _;
use std::sync::Arc;

use super::description::RenderDescription;
use super::{Kind, Model, Scene, SceneError};
use crate::model_facts::Cache;
use potamoi_base::precision::{Precision, PrecisionError};
use potamoi_formats::document::Value;
use potamoi_march::tiling::Halo;
use potamoi_splats::{Order, Profile};

impl Scene {
    /// Applies a `[render]` section over the scene's own rules; keys that it lacks change nothing.
    ///
    /// # Errors
    /// A key that `[render]` of a scene description does not have, or that is not for the scene's model;
    /// a value out of its range. The error names the key and what was expected.
    pub fn apply_render(&mut self, section: &Value) -> Result<(), SceneError> {
        let render = RenderDescription::of(section);
        let render = render.map_err(|message| SceneError::RenderSection { message })?;
        self.rules(&render)
    }

    pub(super) fn rules(&mut self, render: &RenderDescription) -> Result<(), SceneError> {
        if let Some(name) = &render.profile {
            let known = Profile::from_str(name);
            self.profile = known.map_err(|_| {
                let names = Profile::ALL.map(Profile::name).join(", ");
                self.value("render.profile", name.clone(), &names)
            })?;
        }
        if let Some(background) = render.background {
            self.set_background("render.background", background)?;
        }
        if let Some(name) = &render.order {
            self.order = match name.as_str() {
                "exact" => Order::Exact,
                "approximate" => Order::Approximate,
                _ => {
                    let expected = "exact or approximate";
                    return Err(self.value("render.order", name.clone(), expected));
                }
            };
        }
        if let Some(name) = &render.halo {
            self.halo = match name.as_str() {
                "shared" => Halo::Shared,
                "split" => Halo::Split,
                _ => return Err(self.value("render.halo", name.clone(), "shared or split")),
            };
        }
        let sides = render.group_tiles.into_iter().flatten();
        if sides.chain(render.group_side).any(|side| side == 0) {
            let (field, value) = match render.group_tiles {
                Some(tiles) => ("render.group_tiles", format!("{tiles:?}")),
                None => ("render.group_side", "0".to_owned()),
            };
            return Err(self.value(field, value, "whole numbers above 0"));
        }
        if let Some(antialiased) = render.antialiased {
            self.set_antialiased(antialiased);
        }
        self.group_tiles = render.group_tiles.or(self.group_tiles);
        self.group_side = render.group_side.or(self.group_side);
        if let Some(step) = render.step {
            self.set_step(step)?;
        }
        self.set_precision(self.precision.and(render.precision))?;
        let splats = matches!(self.model.kind(), Kind::Splats(_));
        let interpolated = match self.model.kind() {
            Kind::Splats(_) => false,
            Kind::Field(field) => field.tables().iter().any(|table| table.vertices() > 1),
        };
        let stepped = self.model.has_step();
        for (field, given, ours, kind) in [
            ("render.profile", render.profile.is_some(), splats, "splats"),
            ("render.order", render.order.is_some(), splats, "splats"),
            (
                "render.group_tiles",
                render.group_tiles.is_some(),
                splats,
                "splats",
            ),
            (
                "render.group_side",
                render.group_side.is_some(),
                !splats,
                "voxels and fields",
            ),
            (
                "render.halo",
                render.halo.is_some(),
                interpolated,
                "voxels and fields that are interpolated",
            ),
            ("render.step", render.step.is_some(), stepped, "voxels"),
            (
                "render.antialiased",
                render.antialiased.is_some(),
                splats,
                "splats",
            ),
        ] {
            if given && !ours {
                let expected = format!("it left out: it is for {kind}");
                return Err(self.value(field, "given".to_owned(), &expected));
            }
        }
        Ok(())
    }

    /// Whether splats are drawn as trained with antialiasing: their opacity compensates for the
    /// area that the pixel filter adds.
    #[must_use]
    pub fn is_antialiased(&self) -> bool {
        matches!(self.model.kind(), Kind::Splats(cloud) if cloud.is_antialiased())
    }

    /// Sets the antialiasing flag of splats, whatever their file states; other models do not
    /// change.
    pub fn set_antialiased(&mut self, antialiased: bool) {
        if antialiased == self.is_antialiased() {
            return;
        }
        match Arc::make_mut(&mut self.model) {
            Model::Splats(cloud) => cloud.set_antialiased(antialiased),
            Model::Compact(model) => model.set_antialiased(antialiased),
            _ => return,
        }
        self.found = Cache::default();
    }

    /// Sets the step in voxel edges, for fields that have one.
    ///
    /// # Errors
    /// The step is outside 1/64 to 8.
    pub fn set_step(&mut self, step: f64) -> Result<(), SceneError> {
        if !(1.0 / 64.0..=8.0).contains(&step) {
            let expected = "1/64 to 8 voxel edges";
            return Err(self.value("render.step", step.to_string(), expected));
        }
        self.step = step;
        // How many samples a ray has follows from it.
        self.found = Cache::default();
        if let Model::Field(field) = &*self.model
            && let Some(own) = field.stepped()
        {
            self.model = Arc::new(Model::Field(own.with_step(step)));
        }
        Ok(())
    }

    /// Thresholds and widths that override the rules'.
    #[must_use]
    pub const fn precision(&self) -> Precision {
        self.precision
    }

    /// Sets thresholds, widths and levels that override the rules'.
    ///
    /// # Errors
    /// A number is out of range, or does not apply to the model. All numbers except levels apply
    /// to splats. Stored voxels have the early-termination threshold and the width of
    /// transmittances, fields have the threshold, and models with hashed tables have levels, at
    /// most as many as tables.
    pub fn set_precision(&mut self, precision: Precision) -> Result<(), SceneError> {
        let refuse = |e: PrecisionError| self.value(e.field, e.value, &e.expected);
        precision.check().map_err(refuse)?;
        self.has_what_is_asked_for(&precision)?;
        precision.check_for(self.model.numbers()).map_err(refuse)?;
        self.precision = precision;
        self.found = Cache::default();
        Ok(())
    }
}
