//! The frame's depth order.

use super::cloud::Cloud;
use super::project::Projected;

/// Sorts front to back. Exact depth ties are broken by what the Gaussians
/// hold, not by where they stand in the file, so that any permutation of the
/// input gives the same bits. Depths that differ only below 32-bit precision,
/// which the reference leaves in file order, are ordered truly.
pub(crate) fn sort(cloud: &Cloud, splats: &mut [Projected]) {
    splats.sort_by(|a, b| {
        a.depth
            .total_cmp(&b.depth)
            .then_with(|| cloud.compare_content(a.index, b.index))
    });
}
