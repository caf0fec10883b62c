//! Scenes and models, read and rendered. Mutants of files have a binary of their own, `mutants`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod field_contents;
mod fields_bound;
mod fields_common;
mod fields_dvgo;
mod fields_fixed;
mod fields_ngp;
mod interpolation;
mod splats_cases;
mod splats_common;
mod splats_files;
mod splats_fixed;
mod splats_float;
mod splats_gsplat_vectors;
