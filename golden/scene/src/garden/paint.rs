//! Collecting lit Gaussians.

use glam::{DMat3, DQuat, DVec3};

use super::light::Light;
use potamoi_base::sh;
use potamoi_gaussians::Cloud;

/// One stroke: a Gaussian with its appearance.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stroke {
    pub(super) at: DVec3,
    /// The axes of `sigma`, as columns.
    pub(super) axes: DMat3,
    pub(super) sigma: DVec3,
    pub(super) opacity: f64,
    /// The base colour.
    pub(super) colour: DVec3,
    /// Added brightness along this viewing direction, the same for each channel.
    pub(super) glow: DVec3,
}

#[derive(Debug)]
pub(super) struct Painter {
    pub(super) light: Light,
    strokes: Vec<Stroke>,
}

/// Axes whose third is `normal`, with the first rotated by `angle` about it.
pub(super) fn facing(normal: DVec3, angle: f64) -> DMat3 {
    let n = normal.normalize_or(DVec3::Y);
    let (a, b) = n.any_orthonormal_pair();
    let (s, c) = angle.sin_cos();
    DMat3::from_cols(a * c + b * s, b * c - a * s, n)
}

impl Painter {
    pub(super) fn new(light: Light) -> Self {
        Self {
            light,
            strokes: Vec::new(),
        }
    }

    pub(super) fn add(&mut self, stroke: Stroke) {
        self.strokes.push(stroke);
    }

    /// Adds a flat, shaded patch with a normal; `glow` brightens it against the sun.
    pub(super) fn patch(&mut self, at: DVec3, axes: DMat3, sigma: DVec3, albedo: DVec3, glow: f64) {
        let colour = self.light.shade(albedo, axes.z_axis, at);
        let glow = self.light.sun * (glow * self.light.sunlit(at));
        self.add(Stroke {
            at,
            axes,
            sigma,
            opacity: 0.93,
            colour,
            glow,
        });
    }

    /// Adds a thin stroke from one point to another, shaded as if facing `normal`.
    pub(super) fn needle(
        &mut self,
        from: DVec3,
        to: DVec3,
        width: f64,
        albedo: DVec3,
        normal: DVec3,
    ) {
        let along = to - from;
        let at = from.midpoint(to);
        let colour = self.light.shade(albedo, normal, at);
        self.add(Stroke {
            at,
            axes: facing(along, 0.0),
            // Two standard deviations to either end.
            sigma: DVec3::new(width, width, along.length() / 3.6),
            opacity: 0.9,
            colour,
            glow: DVec3::ZERO,
        });
    }

    /// All strokes as a cloud of degree 1.
    pub(super) fn finish(self) -> Cloud {
        let vector = |v: DVec3| v.as_vec3().to_array();
        let means = self.strokes.iter().map(|s| vector(s.at)).collect();
        let scales = self.strokes.iter().map(|s| vector(s.sigma.map(f64::ln)));
        let rotations = self.strokes.iter().map(|s| {
            // A Gaussian looks the same with an axis turned round.
            let hand = s.axes.determinant().signum();
            let axes = DMat3::from_cols(s.axes.x_axis * hand, s.axes.y_axis, s.axes.z_axis);
            let q = DQuat::from_mat3(&axes).as_quat();
            [q.w, q.x, q.y, q.z]
        });
        let logits = self
            .strokes
            .iter()
            .map(|s| (s.opacity / (1.0 - s.opacity)).ln() as f32);
        // Band 1 is (-y, z, -x) times this.
        let band = sh::basis(DVec3::Z)[2];
        let colours = self.strokes.iter().flat_map(|s| {
            let constant = (s.colour - 0.5) / sh::CONSTANT;
            let tint = s.colour / band;
            [
                constant,
                tint * -s.glow.y,
                tint * s.glow.z,
                tint * -s.glow.x,
            ]
            .map(vector)
        });
        let (scales, rotations) = (scales.collect(), rotations.collect());
        let (logits, colours) = (logits.collect(), colours.collect());
        match Cloud::new(1, means, scales, rotations, logits, colours) {
            Ok(cloud) => cloud,
            // Every stroke is finite, and there are some.
            Err(e) => unreachable!("the garden is no cloud: {e}"),
        }
    }
}
