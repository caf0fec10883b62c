//! Sequences of frames along a path.

use super::{Class, Plan, Shaded, Target, WarpError, Warper};
use potamoi_base::camera::Camera;

/// A frame of a sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Its number on the path.
    pub number: usize,
    /// The reference from which it was warped; `None` if it is a reference, equals one because it
    /// has the same camera, or was rendered in full.
    pub reference: Option<usize>,
    /// The frame.
    pub target: Target,
}

impl Frame {
    /// Whether it was rendered in full because it could not be warped.
    #[must_use]
    pub fn fell_back(&self) -> bool {
        self.reference.is_some() && self.target.classes.first() == Some(&Class::Full)
    }
}

/// The frames of a plan, one after another. Those on the path that are references are shown
/// unchanged, all others are warped. The targets of a lost reference are rendered in full.
pub struct Sequence<'a> {
    warper: Warper<'a>,
    path: &'a [Camera],
    plan: &'a Plan,
    lost: &'a [usize],
    reference: Option<(usize, Shaded)>,
    next: usize,
}

impl<'a> Sequence<'a> {
    /// The frames of `path` by its `plan`, without the references that are `lost`.
    #[must_use]
    pub const fn new(
        warper: Warper<'a>,
        path: &'a [Camera],
        plan: &'a Plan,
        lost: &'a [usize],
    ) -> Self {
        Self {
            warper,
            path,
            plan,
            lost,
            reference: None,
            next: 0,
        }
    }

    fn frame(&mut self, number: usize) -> Result<Frame, WarpError> {
        let wanted = self.plan.targets[number].reference;
        let task = &self.plan.references[wanted];
        if self.lost.contains(&wanted) {
            return Ok(Frame {
                number,
                reference: Some(wanted),
                target: self.warper.full(&self.path[number])?,
            });
        }
        let shaded = match self.reference.take() {
            Some((held, shaded)) if held == wanted => shaded,
            _ => self.warper.reference(&task.camera)?,
        };
        let frame = if task.target == Some(number) {
            let classes = vec![Class::Full; shaded.depth.len()];
            Frame {
                number,
                reference: None,
                target: Target {
                    shaded: shaded.clone(),
                    classes,
                },
            }
        } else {
            let target = self
                .warper
                .target(&shaded, &task.camera, &self.path[number])?;
            let is_still = task.camera == self.path[number];
            Frame {
                number,
                reference: Some(wanted).filter(|_| !is_still),
                target,
            }
        };
        self.reference = Some((wanted, shaded));
        Ok(frame)
    }
}

impl Iterator for Sequence<'_> {
    type Item = Result<Frame, WarpError>;

    fn next(&mut self) -> Option<Self::Item> {
        let number = self.next;
        if number >= self.path.len().min(self.plan.targets.len()) {
            return None;
        }
        self.next += 1;
        Some(self.frame(number))
    }
}

/// Frames that are each warped from the one before, where the first of each window is rendered in
/// full (Temp-N). Errors accumulate along a window.
pub struct Chain<'a> {
    warper: Warper<'a>,
    path: &'a [Camera],
    window: usize,
    last: Option<Shaded>,
    next: usize,
}

impl<'a> Chain<'a> {
    /// The frames of `path`, with a full one every `window` frames, at least 1.
    #[must_use]
    pub fn new(warper: Warper<'a>, path: &'a [Camera], window: u32) -> Self {
        Self {
            warper,
            path,
            window: window.max(1) as usize,
            last: None,
            next: 0,
        }
    }

    fn frame(&mut self, number: usize) -> Result<Frame, WarpError> {
        let camera = &self.path[number];
        let (reference, target) = match self.last.take() {
            Some(last) if !number.is_multiple_of(self.window) => {
                let target = self.warper.target(&last, &self.path[number - 1], camera)?;
                let is_still = self.path[number - 1] == *camera;
                (Some(number / self.window).filter(|_| !is_still), target)
            }
            _ => (None, self.warper.full(camera)?),
        };
        self.last = Some(target.shaded.clone());
        Ok(Frame {
            number,
            reference,
            target,
        })
    }
}

impl Iterator for Chain<'_> {
    type Item = Result<Frame, WarpError>;

    fn next(&mut self) -> Option<Self::Item> {
        let number = self.next;
        if number >= self.path.len() {
            return None;
        }
        self.next += 1;
        Some(self.frame(number))
    }
}
