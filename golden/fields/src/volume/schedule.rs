//! The memory-centric order: which samples need which MVoxel, and when.
//!
//! A frame is cut into square ray groups. Within a group, MVoxels are visited in the order of
//! their distance from the camera's ([`MVoxels::distances`]), each once. Every ray meets them
//! front to back and never two at the same distance. So all MVoxels at one distance can be
//! gathered together, and rays still stop at exactly the same sample as on their own.

use glam::DVec3;
use rayon::prelude::*;

use super::CodedVolume;
use super::mvoxels::MVoxels;
use super::ray::{Ray, Rays};
use crate::gather_plan::{Load, Part};
use potamoi_base::camera::Camera;
use potamoi_march::MarchError;
use potamoi_march::streams::Visit;
use potamoi_march::tiling::{Holder, SampleLocation};
use potamoi_reference::GatherTask;

/// The samples of a ray that need one MVoxel, front to back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Crossing {
    pub(super) distance: u32,
    pub(super) mvoxel: u32,
    pub(super) ray: u32,
    pub(super) first: u32,
    pub(super) end: u32,
}

/// The visits of a frame's rays to the MVoxels of a volume.
#[derive(Debug)]
pub(crate) struct Schedule<'a> {
    pub(super) mvoxels: &'a MVoxels,
    rays: Rays,
    pub(super) distances: Vec<u32>,
    void_test: bool,
}

/// A ray group with its crossings.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) rays: Vec<Ray>,
    pub(super) crossings: Vec<Crossing>,
}

impl Group {
    /// Number of crossings of all rays.
    pub(crate) fn crossings(&self) -> usize {
        self.crossings.len()
    }

    /// Unit directions of the rays in world coordinates.
    pub(crate) fn directions(&self) -> Vec<DVec3> {
        self.rays.iter().map(|ray| ray.towards).collect()
    }

    /// Samples along the rays, including skipped ones.
    pub(crate) fn samples(&self) -> u64 {
        self.rays.iter().map(|r| u64::from(r.samples)).sum()
    }
}

impl<'a> Schedule<'a> {
    /// Schedules the rays of a camera. With `void_test`, samples are skipped where the field is
    /// known to be empty.
    ///
    /// # Errors
    /// The camera or the step is out of range, or the MVoxels are of another volume.
    pub(super) fn new(
        volume: &'a CodedVolume,
        camera: &Camera,
        void_test: bool,
    ) -> Result<Self, MarchError> {
        let CodedVolume {
            mvoxels,
            placement,
            step,
        } = volume;
        if mvoxels.points() != placement.points {
            return Err(MarchError::Option {
                field: "mvoxels",
                value: format!("{:?}", mvoxels.points()),
                expected: "the MVoxels of the volume that is rendered",
            });
        }
        let rays = Rays::placed(placement, camera, *step)?;
        Ok(Self {
            mvoxels,
            rays,
            distances: mvoxels.distances(rays.origin.to_array()),
            void_test,
        })
    }

    /// Computes the rays of some pixels and all their crossings, in visiting order.
    pub(crate) fn group(&self, pixels: &[[u32; 2]]) -> Group {
        let rays: Vec<Ray> = pixels
            .par_iter()
            .map(|[x, y]| self.rays.ray(*x, *y))
            .collect();
        let mut crossings: Vec<Crossing> = rays
            .par_iter()
            .enumerate()
            .flat_map_iter(|(slot, ray)| self.cross(slot as u32, ray))
            .collect();
        crossings.par_sort_unstable_by_key(|c| (c.distance, c.mvoxel, c.ray));
        Group { rays, crossings }
    }

    /// Location of a sample, unless it is skipped.
    pub(super) fn place(&self, ray: &Ray, k: u32) -> Option<SampleLocation> {
        let at = ray.at(k);
        let place = self.mvoxels.tiling().locate(at.to_array());
        let is_empty =
            self.void_test && !(self.mvoxels.holds(at) && self.mvoxels.is_cell_occupied(&place));
        (!is_empty).then_some(place)
    }

    /// The MVoxels that a ray's samples need, without skipped samples.
    fn cross(&self, slot: u32, ray: &Ray) -> Vec<Crossing> {
        let mut crossings: Vec<Crossing> = Vec::new();
        for k in 0..ray.samples {
            let Some(place) = self.place(ray, k) else {
                continue;
            };
            for Holder { mvoxel: number, .. } in self.mvoxels.tiling().holders(&place) {
                let mvoxel = number as u32;
                // Mostly among the last; a ray needs no MVoxel twice.
                match crossings.iter_mut().rev().find(|c| c.mvoxel == mvoxel) {
                    Some(open) => open.end = k + 1,
                    None => crossings.push(Crossing {
                        distance: self.distances[number],
                        mvoxel,
                        ray: slot,
                        first: k,
                        end: k + 1,
                    }),
                }
            }
        }
        crossings
    }

    /// Visits an MVoxel for the samples of some crossings, and returns its traffic and the unit's
    /// task, if there are any. `each` is called with the ray, number and part of each sample, and
    /// whether the unit gathers it.
    pub(super) fn visit<'c>(
        &self,
        group: &Group,
        mvoxel: usize,
        crossings: impl Iterator<Item = &'c Crossing>,
        mut each: impl FnMut(u32, u32, &Part, bool),
    ) -> Option<(Visit, Option<GatherTask>)> {
        let (tiling, shape) = (self.mvoxels.tiling(), self.mvoxels.shape());
        let mut load = Load::default();
        for crossing in crossings {
            self.samples(group, crossing, |k, place, holder| {
                let part = Part::of(tiling, place, holder, crossing.ray, shape);
                let is_gathered = load.add(&part, shape);
                each(crossing.ray, k, &part, is_gathered);
            });
        }
        load.done(self.mvoxels.rows(mvoxel), shape)
    }

    /// Calls `each` with the number and location of every sample of a crossing, and its MVoxel as
    /// a holder.
    pub(super) fn samples(
        &self,
        group: &Group,
        crossing: &Crossing,
        mut each: impl FnMut(u32, &SampleLocation, Holder),
    ) {
        let (tiling, mvoxel) = (self.mvoxels.tiling(), crossing.mvoxel as usize);
        let ray = &group.rays[crossing.ray as usize];
        for k in crossing.first..crossing.end {
            let Some(place) = self.place(ray, k) else {
                continue;
            };
            if let Some(holder) = tiling.holders(&place).find(|h| h.mvoxel == mvoxel) {
                each(k, &place, holder);
            }
        }
    }
}
