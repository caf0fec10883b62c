//! The surface of a scene's model as a mesh.

use glam::{DMat3, DVec3};

use super::{Kind, Scene, SceneError};
use potamoi_fields::{self as fields, Field};
use potamoi_gaussians::{Cloud, rotation, sigmoid};
use potamoi_warp::Renderer;
use potamoi_warp::mesh::{Density, Lattice, Mesh, half_light};

/// The level of a surface: fraction of rays that reach half transmittance at a density below it.
/// One half would give the most accurate depth, but would cut off the rim of surfaces seen from
/// the side, where a missing surface costs more than one that lies a fraction of a voxel in front
/// (`--example mesh_depth`).
const SHARE: f64 = 0.1;
/// The level for splats: blurred, they extend to both sides, and the surface lies in their middle.
const SHARE_OF_SPLATS: f64 = 0.5;
/// Radius of Gaussians in standard deviations: beyond it, alpha is below 1/255.
const REACH: f64 = 3.34;
/// Upper limit of opacities, as in rendering.
const OPAQUE: f64 = 0.99;
/// Standard deviation of the blur of Gaussians, relative to a cell's edge, so that thin ones do
/// not fall between the sampled points.
const BLUR: f64 = 0.5;

/// The surface of a scene's model at its [`level_of`], with `cells` cells along the longest side
/// of its box. The mesh is closed.
///
/// # Errors
/// Those of [`level_of`] and [`of_scene_at`].
pub fn of_scene(scene: &Scene, cells: u32) -> Result<Mesh, SceneError> {
    of_scene_at(scene, cells, level_of(scene, cells)?)
}

/// The surface at a given level, an optical depth per unit of length. The density of splats is the
/// sum of the Gaussians, each blurred by half a cell, with the correct optical depth along its
/// thinnest axis.
///
/// # Errors
/// `cells` is 0 or above 1024, the model has no finite box, the level is not finite, or the
/// surface has no triangles or too many.
pub fn of_scene_at(scene: &Scene, cells: u32, level: f64) -> Result<Mesh, SceneError> {
    with_density(scene, cells, |density, lattice| {
        let mesh = Mesh::of_surface(density, lattice, level)?;
        if mesh.triangles().is_empty() {
            let value = format!("{level}, which no place is above and beside one below");
            return Err(refuse(
                scene,
                "level of the surface",
                &value,
                "a level within the density's range",
            ));
        }
        Ok(mesh)
    })
}

/// The density at the surface of a model: where rays reach half transmittance, as [`half_light`]
/// computes it.
///
/// # Errors
/// Those of [`of_scene_at`], or the model absorbs no light.
pub fn level_of(scene: &Scene, cells: u32) -> Result<f64, SceneError> {
    let share = match scene.model.kind() {
        Kind::Splats(_) => SHARE_OF_SPLATS,
        Kind::Field(_) => SHARE,
    };
    with_density(scene, cells, |density, lattice| {
        let level = half_light(density, lattice, share).filter(|level| *level > 0.0);
        level.ok_or_else(|| {
            let expected = "a model that stops half of the light somewhere";
            refuse(scene, "density", "too low for a surface", expected)
        })
    })
}

fn refuse(scene: &Scene, field: &'static str, value: &str, expected: &str) -> SceneError {
    SceneError::Value {
        scene: scene.name.clone(),
        field,
        value: value.to_owned(),
        expected: expected.to_owned(),
    }
}

fn with_density<T>(
    scene: &Scene,
    cells: u32,
    make: impl FnOnce(&dyn Density, &Lattice) -> Result<T, SceneError>,
) -> Result<T, SceneError> {
    let bounds = scene
        .bounds()
        .ok_or_else(|| refuse(scene, "model", "without bounds", "one in a finite box"))?;
    let lattice = Lattice::new(bounds, cells)?;
    match scene.model.kind() {
        Kind::Splats(cloud) => make(&Gaussians::new(cloud, lattice.cell()), &lattice),
        Kind::Field(field) => make(&OfField(field), &lattice),
    }
}

/// The density of a field.
struct OfField<'a>(&'a dyn Field);

impl Density for OfField<'_> {
    fn plane(&self, lattice: &Lattice, z: usize, out: &mut [f32]) {
        let mut sample = fields::Density::new(self.0);
        let [width, ..] = lattice.points();
        for (i, value) in out.iter_mut().enumerate() {
            let at = lattice.point([i % width, i / width, z]);
            *value = self.0.density(at, &mut sample) as f32;
        }
    }

    fn at(&self, p: DVec3) -> Option<f64> {
        Some(self.0.density(p, &mut fields::Density::new(self.0)))
    }
}

/// A Gaussian as a density.
struct Gaussian {
    mean: DVec3,
    /// Half the size of its bounding box.
    reach: DVec3,
    /// Inverse of its covariance.
    inverse: DMat3,
    /// Density at its centre.
    peak: f64,
}

/// The sum of the densities of blurred Gaussians, in their order.
struct Gaussians(Vec<Gaussian>);

impl Gaussians {
    fn new(cloud: &Cloud, cell: f64) -> Self {
        let blur = (BLUR * cell).powi(2);
        let all = (0..cloud.len()).filter_map(|i| {
            let opacity = sigmoid(f64::from(cloud.opacity_logits()[i])).min(OPAQUE);
            let scales = cloud.log_scales()[i].map(|s| f64::from(s).exp());
            let variances = DVec3::from(scales.map(|s| s * s + blur));
            let turn = rotation(cloud.rotations()[i]);
            let covariance = turn * DMat3::from_diagonal(variances) * turn.transpose();
            let diagonal = |m: DMat3| DVec3::new(m.x_axis.x, m.y_axis.y, m.z_axis.z);
            // Through the middle along the thinnest axis; blurring spreads it.
            let depth = -(-opacity).ln_1p();
            let [a, b, c] = scales;
            let broad = (a * b).max(b * c).max(c * a);
            let spread = variances.to_array().iter().product::<f64>().sqrt();
            let peak = depth * broad / (spread * std::f64::consts::TAU.sqrt());
            let gaussian = Gaussian {
                mean: DVec3::from(cloud.means()[i].map(f64::from)),
                reach: REACH * diagonal(covariance).map(f64::sqrt),
                inverse: turn * DMat3::from_diagonal(variances.recip()) * turn.transpose(),
                peak,
            };
            (peak > 0.0 && peak.is_finite()).then_some(gaussian)
        });
        Self(all.collect())
    }
}

impl Density for Gaussians {
    fn plane(&self, lattice: &Lattice, z: usize, out: &mut [f32]) {
        out.fill(0.0);
        let [width, height, _] = lattice.points();
        let first = lattice.point([0, 0, z]);
        for gaussian in &self.0 {
            let off = first - gaussian.mean;
            if off.z.abs() > gaussian.reach.z {
                continue;
            }
            // Points of an axis within reach; casts hold to the range.
            let span = |axis: usize, count: usize| {
                let from = (-off[axis] - gaussian.reach[axis]) / lattice.cell();
                let to = (-off[axis] + gaussian.reach[axis]) / lattice.cell();
                from.ceil().max(0.0) as usize..((to.floor() + 1.0).max(0.0) as usize).min(count)
            };
            for y in span(1, height) {
                for x in span(0, width) {
                    let at = off + lattice.cell() * DVec3::new(x as f64, y as f64, 0.0);
                    let square = at.dot(gaussian.inverse * at);
                    if square <= REACH * REACH {
                        out[y * width + x] += (gaussian.peak * (-0.5 * square).exp()) as f32;
                    }
                }
            }
        }
    }

    /// Not available: a sum over all Gaussians would be expensive.
    fn at(&self, _: DVec3) -> Option<f64> {
        None
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{ExactDepth, Model};
    use potamoi_fields::voxels::{Grid, Layout};
    use potamoi_warp::{Geometry as _, is_surface};

    /// Median depth error against the exact depth, in voxel edges, and the share of foreground
    /// pixels in which only one of the two has a surface.
    fn off(name: &str, cells: u32) -> (f64, f64) {
        let scene = crate::tests::opened(name);
        let analytic = scene.analytic().unwrap();
        let camera = analytic.camera(1.0, 80, 80);
        let exact = ExactDepth(analytic).depth(&camera).unwrap();
        let found = of_scene(&scene, cells).unwrap().depth(&camera);
        let (mut off, mut differ) = (vec![], 0.0);
        for (found, exact) in found.iter().zip(&exact) {
            match [*found, *exact].map(is_surface) {
                [true, true] => off.push(f64::from((found - exact).abs()) / analytic.voxel()),
                [false, false] => {}
                _ => differ += 1.0,
            }
        }
        off.sort_by(f64::total_cmp);
        let foreground = exact.iter().filter(|d| is_surface(**d)).count() as f64;
        (off[off.len() / 2], differ / foreground)
    }

    #[test]
    fn surfaces_lie_where_the_truth_has_them() {
        surfaces_lie(&[("cairn", 96, 0.75, 0.015), ("cairn:splats", 96, 1.8, 0.04)]);
    }

    #[test]
    #[ignore = "exhaustive; run with make test-full"]
    fn surfaces_of_every_kind_of_model_lie_where_the_truth_has_them() {
        surfaces_lie(&[
            ("cairn:tensorf", 96, 0.75, 0.015),
            ("cairn:efficientnerf", 96, 1.0, 0.025),
            // From within, cells finer than its own.
            ("gallery", 200, 0.75, 0.015),
        ]);
    }

    /// Scenes, cells along an axis, and what is off at most.
    fn surfaces_lie(cases: &[(&str, u32, f64, f64)]) {
        for &(name, cells, most, most_differ) in cases {
            let (off, differ) = off(name, cells);
            assert!(off < most && differ < most_differ, "{name}: {off} {differ}");
        }
    }

    #[test]
    fn models_without_a_surface_are_refused() {
        let empty = vec![0.0; 8 * Layout::Constant.channels()];
        let grid = Grid::new([2; 3], DVec3::ZERO, 1.0, Layout::Constant, empty).unwrap();
        let cairn = crate::tests::opened("cairn");
        let error = of_scene_at(&cairn, 8, 1e30).unwrap_err().to_string();
        assert!(error.contains("level of the surface"), "{error}");
        let scene = Scene {
            model: Model::Field(grid.into()).into(),
            ..cairn
        };
        let error = of_scene(&scene, 8).unwrap_err().to_string();
        assert!(error.contains("density is too low"), "{error}");
        let error = of_scene(&scene, 0).unwrap_err().to_string();
        assert!(error.contains("cells is 0"), "{error}");
    }
}
