//! The sparse renderer: a target that would be rendered in full is refused, and
//! left to the full renderer.

use std::sync::atomic::{AtomicBool, Ordering};

use glam::DVec3;
use potamoi_golden::camera::Camera;
use potamoi_golden::mask::Mask;
use potamoi_golden::warp::{Renderer, Shaded, Target, WarpError, Warper};

/// A renderer that renders no full frames.
pub(super) struct Sparse<'a> {
    inner: &'a dyn Renderer,
    refused: AtomicBool,
}

impl<'a> Sparse<'a> {
    pub(super) fn new(inner: &'a dyn Renderer) -> Self {
        Self {
            inner,
            refused: AtomicBool::new(false),
        }
    }

    /// A target as [`Warper::target`] gives it; none where that would be
    /// rendered in full, as an angle is too large.
    pub(super) fn target(
        &self,
        warper: &Warper<'_>,
        reference: &Shaded,
        from: &Camera,
        to: &Camera,
    ) -> Result<Option<Target>, WarpError> {
        let sparse = Warper {
            renderer: self,
            ..*warper
        };
        match sparse.target(reference, from, to) {
            Err(_) if self.refused.load(Ordering::Relaxed) => Ok(None),
            result => result.map(Some),
        }
    }
}

impl Renderer for Sparse<'_> {
    fn background(&self) -> [f32; 3] {
        self.inner.background()
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        self.inner.bounds()
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        if only.is_none() {
            self.refused.store(true, Ordering::Relaxed);
            return Err(WarpError::Option {
                field: "only",
                value: "no mask".to_owned(),
                expected: "a mask: the sparse renderer renders no full frames".to_owned(),
            });
        }
        self.inner.shade(camera, only)
    }
}
