//! The order of a volume: MVoxel by MVoxel.

use potamoi_base::camera::Camera;
use potamoi_march::tiling::Halo;
use potamoi_march::{GatherOrder, MarchError, RayGroup};

use super::CodedVolume;
use super::schedule::Schedule;
use super::shared_halo::SharedGroup;
use super::split_halo::SplitGroup;

/// Gathers a ray group MVoxel by MVoxel, the nearest first. One volume allows this order: a ray
/// meets its MVoxels front to back, each once and no two at one distance, so it stops exactly.
pub(crate) struct MVoxelOrder<'a> {
    schedule: Schedule<'a>,
    /// Number of entries after which no more MVoxels join a batch.
    most: usize,
}

impl<'a> MVoxelOrder<'a> {
    /// The order of a camera's rays. With `void_test`, samples are skipped where the field is
    /// known to be empty.
    ///
    /// # Errors
    /// The camera or the step is out of range, or the MVoxels are of another volume.
    pub(crate) fn new(
        volume: &'a CodedVolume,
        camera: &Camera,
        void_test: bool,
        most: usize,
    ) -> Result<Self, MarchError> {
        let schedule = Schedule::new(volume, camera, void_test)?;
        Ok(Self { schedule, most })
    }
}

impl GatherOrder for MVoxelOrder<'_> {
    fn start(&self, pixels: &[[u32; 2]]) -> Box<dyn RayGroup + '_> {
        match self.schedule.mvoxels.halo() {
            Halo::Shared => Box::new(SharedGroup::new(&self.schedule, pixels, self.most)),
            Halo::Split => Box::new(SplitGroup::new(&self.schedule, pixels, self.most)),
        }
    }
}
