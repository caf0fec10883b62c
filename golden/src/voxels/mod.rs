//! Voxel-grid scenes: baking, MVoxels and rendering.
