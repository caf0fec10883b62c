//! How a scene is rendered, as a description says it.

use crate::effects::Cache;
use std::str::FromStr as _;

use super::description::RenderDescription;
use super::{Kind, Model, Scene, SceneError};
use crate::splats::{Order, Profile};
use crate::voxels::Halo;

impl Scene {
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
        self.group_tiles = render.group_tiles;
        self.group_side = render.group_side;
        if let Some(step) = render.step {
            self.set_step(step)?;
        }
        let splats = matches!(self.model.kind(), Kind::Splats(_));
        let voxels = matches!(self.model, Model::Voxels(_) | Model::Dvgo(_));
        let interpolated = match self.model.kind() {
            Kind::Splats(_) => false,
            Kind::Voxels(_) => true,
            Kind::Field(field) => field.tables().iter().any(|table| table.vertices() > 1),
        };
        let stepped = voxels || matches!(self.model, Model::Tensorf(_));
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
        ] {
            if given && !ours {
                let expected = format!("it left out: it is for {kind}");
                return Err(self.value(field, "given".to_owned(), &expected));
            }
        }
        Ok(())
    }

    /// Voxel edges from sample to sample.
    /// Sets how far apart samples are, in voxel edges; of fields that step so.
    ///
    /// # Errors
    /// A step outside 1/64 to 8.
    pub fn set_step(&mut self, step: f64) -> Result<(), SceneError> {
        if !(1.0 / 64.0..=8.0).contains(&step) {
            let expected = "1/64 to 8 voxel edges";
            return Err(self.value("render.step", step.to_string(), expected));
        }
        self.step = step;
        // How many samples a ray has follows from it.
        self.found = Cache::default();
        match &mut self.model {
            Model::Dvgo(field) => field.set_step(step),
            Model::Tensorf(field) => field.set_step(step),
            Model::Splats(_) | Model::Compact(_) | Model::Voxels(_) | Model::Field(_) => {}
        }
        Ok(())
    }
}
