//! Splat scenes: loading, projection and rendering of 3D Gaussians.
