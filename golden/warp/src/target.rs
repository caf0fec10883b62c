//! One target frame: warped from a reference, and rendered where the reference does not show it.

use rayon::prelude::*;

use super::crack::Cracks;
use super::pixel::centre;
use super::reproject::{Transfer, reproject};
use super::sampler::Sampler;
use super::silhouette::Silhouette;
use super::{Class, Geometry, Renderer, Rule, Scope, Shaded, WarpError, is_surface, is_void};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;

/// A target frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Target {
    /// The picture with depth.
    pub shaded: Shaded,
    /// The source of each pixel.
    pub classes: Vec<Class>,
}

/// Warps target frames.
#[derive(Clone, Copy)]
pub struct Warper<'a> {
    /// The renderer.
    pub renderer: &'a dyn Renderer,
    /// The source of a target's depth before rendering. Without it, references are warped by the
    /// depth of their own rendering, and only pixels on which no point landed are rendered, except
    /// those that the reference shows to be void.
    pub geometry: Option<&'a dyn Geometry>,
    /// The rules of classification.
    pub rule: Rule,
}

impl Warper<'_> {
    /// Renders a reference frame.
    ///
    /// # Errors
    /// Those of the renderer and the geometry.
    pub fn reference(&self, camera: &Camera) -> Result<Shaded, WarpError> {
        let mut shaded = self.renderer.shade(camera, None)?;
        if let Some(geometry) = self.geometry {
            shaded.depth = geometry.depth(camera)?;
        }
        check("a frame", camera, &shaded)?;
        Ok(shaded)
    }

    /// Renders a target frame in full.
    ///
    /// # Errors
    /// Those of [`Warper::reference`].
    pub fn full(&self, camera: &Camera) -> Result<Target, WarpError> {
        let shaded = self.reference(camera)?;
        let classes = vec![Class::Full; shaded.depth.len()];
        Ok(Target { shaded, classes })
    }

    /// A target frame, warped from a reference of camera `from`, or rendered in full if the rules
    /// require it.
    ///
    /// # Errors
    /// Those of [`Warper::reference`], or a rule is out of range.
    pub fn target(
        &self,
        reference: &Shaded,
        from: &Camera,
        to: &Camera,
    ) -> Result<Target, WarpError> {
        let sparse = self.sparse_target(reference, from, to)?;
        sparse.map_or_else(|| self.full(to), Ok)
    }

    /// As [`Warper::target`], but returns `None` instead of rendering in full, if an angle of the
    /// frame is too large ([`Scope::Frame`]).
    ///
    /// # Errors
    /// Those of [`Warper::target`].
    pub fn sparse_target(
        &self,
        reference: &Shaded,
        from: &Camera,
        to: &Camera,
    ) -> Result<Option<Target>, WarpError> {
        self.rule.check()?;
        check("a reference", from, reference)?;
        let is_still = from == to;
        if is_still && !self.rule.warps_still {
            return Ok(Some(as_it_is(reference)));
        }
        let known = self.geometry.map(|g| g.depth(to)).transpose()?;
        let silhouette = match (&known, self.renderer.bounds()) {
            (None, Some(bounds)) => Some(Silhouette::new(reference, from, bounds)),
            _ => None,
        };
        let warped = reproject(reference, from, to);
        let there = Transfer::new(from, to);
        let sampler = Sampler::new(reference, from, to, &self.rule);
        let cracks = self.rule.fill_cracks.then_some(Cracks {
            warped: &warped,
            sampler: &sampler,
            to,
            nearer: self.rule.nearer,
        });
        let shift = to.world_to_camera.transform_point3(from.position());
        let count = to.width as usize * to.height as usize;
        // Class, depth and pixel of the reference.
        let pixels: Vec<(Class, f32, u32)> = (0..count)
            .into_par_iter()
            .map(|i| {
                let depth = known.as_ref().and_then(|d| d.get(i).copied());
                let filled = cracks.as_ref().and_then(|c| c.fill(i, depth));
                let Some((source, near)) = filled.or_else(|| warped.at(i)) else {
                    let void = match (depth, &silhouette) {
                        (Some(depth), _) => is_void(depth),
                        (None, Some(silhouette)) => {
                            let pixel = i as u32;
                            let (origin, towards) = to.ray(pixel % to.width, pixel / to.width);
                            silhouette.is_void(origin, towards)
                        }
                        (None, None) => false,
                    };
                    let rim = || {
                        let known = known.as_ref().filter(|_| self.rule.render_edges);
                        known.is_some_and(|depth| is_beside_surface(depth, to, i))
                    };
                    let class = match void {
                        // Neither a surface nor void, as a rim.
                        false if depth.is_some_and(f32::is_nan) => Class::Edge,
                        false => Class::Disoccluded,
                        true if rim() => Class::Edge,
                        true => Class::Void,
                    };
                    return (class, f32::INFINITY, 0);
                };
                match depth {
                    Some(depth) if is_void(depth) && !self.rule.keep_over_void => {
                        return (Class::Void, depth, 0);
                    }
                    Some(depth)
                        if is_surface(depth)
                            && f64::from(depth) < self.rule.nearer * f64::from(near) =>
                    {
                        return (Class::Disoccluded, depth, 0);
                    }
                    _ => {}
                }
                let at = centre(from, source as usize);
                let point = there.point(at, f64::from(reference.depth[source as usize]));
                let class = if self.rule.is_too_far(point - shift, point, point.z) {
                    Class::Angle
                } else if sampler.is_at_edge(centre(to, i), shown(depth, near), source) {
                    Class::Edge
                } else {
                    Class::Warped
                };
                (class, near, source)
            })
            .collect();
        if self.rule.scope == Scope::Frame && pixels.iter().any(|p| p.0 == Class::Angle) {
            return Ok(None);
        }
        let target = self.combine(&sampler, to, &pixels, known)?;
        Ok(Some(match is_still {
            true => as_it_is(reference),
            false => target,
        }))
    }

    /// Step 4: renders the remaining pixels and combines all.
    fn combine(
        &self,
        sampler: &Sampler<'_>,
        to: &Camera,
        pixels: &[(Class, f32, u32)],
        known: Option<Vec<f32>>,
    ) -> Result<Target, WarpError> {
        let mask = Mask::new([to.width, to.height], |i| pixels[i].0.is_rendered());
        let mut shaded = if mask.count() == 0 {
            Shaded {
                picture: potamoi_base::picture::Picture::filled(
                    to.width,
                    to.height,
                    self.renderer.background(),
                ),
                depth: vec![f32::INFINITY; pixels.len()],
            }
        } else {
            self.renderer.shade(to, Some(&mask))?
        };
        check("a sparse frame", to, &shaded)?;
        let background = self.renderer.background();
        for (i, (class, depth, source)) in pixels.iter().enumerate() {
            match class {
                Class::Warped => {
                    let exact = known.as_ref().map(|known| known[i]);
                    let shown = shown(exact, *depth);
                    shaded.picture.rgb[i] = sampler.colour(centre(to, i), shown, *source);
                    shaded.depth[i] = *depth;
                }
                Class::Void => {
                    shaded.picture.rgb[i] = background;
                    shaded.depth[i] = f32::INFINITY;
                }
                Class::Disoccluded | Class::Angle | Class::Edge | Class::Full => {}
            }
        }
        if let Some(known) = known {
            shaded.depth = known;
        }
        Ok(Target {
            shaded,
            classes: pixels.iter().map(|p| p.0).collect(),
        })
    }
}

/// A reference as its own target: every pixel is taken from it.
fn as_it_is(reference: &Shaded) -> Target {
    Target {
        shaded: reference.clone(),
        classes: vec![Class::Warped; reference.depth.len()],
    }
}

/// Whether a neighbour of a pixel shows a surface: a geometry has no soft edge, but the model may.
fn is_beside_surface(depth: &[f32], camera: &Camera, pixel: usize) -> bool {
    let (width, height) = (camera.width as usize, camera.height as usize);
    let (x, y) = (pixel % width, pixel / width);
    let rows = y.saturating_sub(1)..(y + 2).min(height);
    rows.flat_map(|y| (x.saturating_sub(1)..(x + 2).min(width)).map(move |x| y * width + x))
        .any(|i| is_surface(depth[i]))
}

/// The depth of a pixel: the known one, or that of the point warped to it.
fn shown(known: Option<f32>, warped: f32) -> f64 {
    known
        .filter(|depth| is_surface(*depth))
        .unwrap_or(warped)
        .into()
}

fn check(what: &'static str, camera: &Camera, shaded: &Shaded) -> Result<(), WarpError> {
    let expected = [camera.width as usize, camera.height as usize];
    let picture = [shaded.picture.width, shaded.picture.height].map(|v| v as usize);
    let count = expected[0] * expected[1];
    let found = if picture != expected {
        picture
    } else if shaded.picture.rgb.len() != count {
        [shaded.picture.rgb.len(), 1]
    } else if shaded.depth.len() != count {
        [shaded.depth.len(), 1]
    } else {
        return Ok(());
    };
    Err(WarpError::Size {
        what,
        found,
        expected,
    })
}
