//! Error bounds of DirectVoxGO in fixed point.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::Dvgo;
use super::fixed::{DvgoHead, FixedDvgo};
use crate::FieldError;
use crate::bound::{Bounds, ErrorInterval, Pair, UnitErrors};
use crate::volume::{MVoxels, Ray, Rays};
use potamoi_base::camera::Camera;
use potamoi_march::Head as _;
use potamoi_reference::bounds::VectorBounds;

pub(super) struct DvgoBounds<'a> {
    field: &'a Dvgo,
    head: DvgoHead,
    mvoxels: MVoxels,
    rays: Rays,
    frac_bits: [Vec<u32>; 1],
    pair: Pair,
    errors: UnitErrors,
}

pub(super) fn bounds<'a>(
    field: &'a Dvgo,
    config: &Config,
    vector: &VectorBounds,
    camera: &Camera,
) -> Result<DvgoBounds<'a>, FieldError> {
    let FixedDvgo { volume, head } = field.fixed(config)?;
    let mut frac_bits = vec![head.input_bits; head.channels];
    frac_bits[0] = head.density_bits;
    Ok(DvgoBounds {
        field,
        rays: Rays::placed(&volume.placement, camera, volume.step)?,
        mvoxels: volume.mvoxels,
        frac_bits: [frac_bits],
        pair: Pair::new(&field.mlp, &head.mlp),
        errors: UnitErrors::of(config, vector),
        head,
    })
}

impl Bounds for DvgoBounds<'_> {
    fn frac_bits(&self) -> &[Vec<u32>] {
        &self.frac_bits
    }

    fn alpha(&self, features: &[f64], off: &[ErrorInterval]) -> f64 {
        let bits = self.head.density_bits as i32;
        self.head
            .opacity
            .off(&self.errors, features[0], off[0], bits)
    }

    fn colour(&self, features: &[f64], off: &[ErrorInterval], direction: DVec3) -> f64 {
        let mut inputs = vec![];
        self.field.inputs(features, direction, &mut inputs);
        let mut codes = vec![];
        self.head.encode(direction, &mut codes);
        let scale = 2f64.powi(self.head.input_bits as i32);
        let directions = codes.iter().zip(&inputs[features.len() - 1..]);
        let directions =
            directions.map(|(c, exact)| ErrorInterval::exactly(f64::from(*c) / scale - exact));
        let off: Vec<ErrorInterval> = off[1..].iter().copied().chain(directions).collect();
        let logits = self.pair.outputs(&inputs, &off);
        self.errors.colours(&logits, self.head.mlp.output_frac())
    }

    fn ray(&self, [x, y]: [u32; 2]) -> Option<Ray> {
        Some(self.rays.ray(x, y))
    }

    fn holds(&self, at: DVec3) -> bool {
        self.mvoxels.holds(at)
    }
}
