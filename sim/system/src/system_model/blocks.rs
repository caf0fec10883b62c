//! Cuts a frame into blocks of the feature buffer.

use super::system::System;
use super::work::FrameWork;
use potamoi_cycles::batch::Batch;

/// One step of the pipeline: the features of a block of the feature buffer.
pub(super) struct Block {
    /// Its group of rays, or of a splat frame's batches.
    pub(super) group: usize,
    pub(super) work: Batch,
}

/// Joins batches to groups of at most half of the feature buffer, and cuts each group into equal
/// parts of at most a block.
pub(super) fn blocks(work: &FrameWork, system: &System) -> Vec<Block> {
    let half = system.feature_buffer_bytes / 2;
    let mut groups: Vec<Batch> = vec![];
    for batch in &work.batches {
        match groups.last_mut() {
            Some(last) if last.feature_bytes + batch.feature_bytes <= half => *last += *batch,
            _ => groups.push(*batch),
        }
    }
    let block = u64::from(system.feature_block_bytes);
    let cut = groups.into_iter().enumerate().flat_map(|(group, whole)| {
        let parts = whole.parts(whole.feature_bytes.div_ceil(block).max(1));
        parts.map(move |work| Block { group, work })
    });
    cut.collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::system_model::figures::frame;

    /// Groups hold at most half of the buffer, blocks at most the buffer's block, and cutting loses
    /// nothing.
    #[test]
    fn groups_fill_half_of_the_buffer_at_most() {
        let work = frame(false, 9, 4096);
        let most = work.batches.iter().map(|b| b.feature_bytes).max().unwrap();
        for size in [2 * most, 4 * most, 16 * most] {
            let system = System {
                feature_buffer_bytes: size,
                ..System::default()
            };
            let cut = blocks(&work, &system);
            let groups = cut.iter().map(|b| b.group).max().unwrap() + 1;
            for group in 0..groups {
                let own = cut.iter().filter(|b| b.group == group);
                let bytes: u64 = own.map(|b| b.work.feature_bytes).sum();
                assert!(bytes <= size / 2, "{size}: {bytes}");
            }
            let all: u64 = cut.iter().map(|b| b.work.feature_bytes).sum();
            assert_eq!(all, work.total().feature_bytes);
            let block = u64::from(system.feature_block_bytes);
            assert!(cut.iter().all(|b| b.work.feature_bytes <= block));
        }
    }
}
