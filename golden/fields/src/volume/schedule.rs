//! The memory-centric order: which samples need which MVoxel, and when.
//!
//! A frame is cut into square ray groups. Within a group, MVoxels are visited in the order of
//! their distance from the camera's ([`MVoxels::distances`]), each once. Every ray meets them
//! front to back and never two at the same distance. So all MVoxels at one distance can be
//! gathered together, and rays still stop at exactly the same sample as on their own.

use glam::DVec3;
use rayon::prelude::*;

use potamoi_formats::rit::{RitEntry, Vertices};

use super::CodedVolume;
use super::mvoxels::MVoxels;
use super::ray::{Ray, Rays};
use potamoi_base::camera::Camera;
use potamoi_march::tiling::{Holder, SampleLocation};
use potamoi_march::{MarchError, Span};
use potamoi_reference::{GatherTask, weights};

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
    /// Number of crossings of all rays, the units of [`Schedule::batch`].
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

    /// Builds the next tasks of a group with a shared halo, from crossing `next` on, for the rays
    /// that are `alive`: all MVoxels of at least one distance, and of further ones until there are
    /// `most` entries. Returns the crossing to continue with.
    pub(crate) fn batch(
        &self,
        group: &Group,
        next: usize,
        most: usize,
        alive: impl Fn(u32) -> bool,
        tasks: &mut Vec<GatherTask>,
        spans: &mut Vec<Span>,
    ) -> usize {
        tasks.clear();
        spans.clear();
        let rest = &group.crossings[next..];
        let Some(first) = rest.first() else {
            return next;
        };
        let mut entries = 0;
        let mut done = 0;
        for same in rest.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
            if same[0].distance != first.distance || entries >= most {
                break;
            }
            done += same.len();
            let mut task = Vec::new();
            for crossing in same.iter().filter(|c| alive(c.ray)) {
                let start = entries + task.len();
                self.entries(group, crossing, &mut task);
                spans.push(Span {
                    ray: crossing.ray,
                    start: start as u32,
                    len: (entries + task.len() - start) as u32,
                });
            }
            if !task.is_empty() {
                entries += task.len();
                tasks.push(self.task(same[0].mvoxel as usize, task));
            }
        }
        next + done
    }

    /// Appends the entries of one ray in one MVoxel.
    fn entries(&self, group: &Group, crossing: &Crossing, out: &mut Vec<RitEntry>) {
        let ray = &group.rays[crossing.ray as usize];
        for k in crossing.first..crossing.end {
            let Some(place) = self.place(ray, k) else {
                continue;
            };
            out.push(RitEntry {
                slot: crossing.ray,
                rows: self.mvoxels.tiling().corner_rows(&place),
                weights: weights::trilinear(place.fraction, self.mvoxels.weight_bits()),
            });
        }
    }

    /// A task that loads the rows up to the last that its entries use.
    fn task(&self, mvoxel: usize, entries: Vec<RitEntry>) -> GatherTask {
        let last = entries.iter().map(|e| e.rows[7]).max().unwrap_or_default();
        self.loading(mvoxel, usize::from(last) + 1, entries)
    }

    /// A task that loads `rows` rows.
    pub(super) fn loading(&self, mvoxel: usize, rows: usize, entries: Vec<RitEntry>) -> GatherTask {
        let channels = self.mvoxels.channels();
        GatherTask {
            vertices: Vertices::Eight,
            channels,
            rows: self.mvoxels.rows(mvoxel)[..rows * channels].to_vec(),
            entries,
        }
    }
}
