//! Bytes that are not rows of a `.splat` file.

use super::refuse::refused;
use super::*;

#[test]
fn what_is_no_rows_is_refused() {
    refused(
        splat_cloud,
        &[0; 33],
        "length in bytes is 33: expected a multiple of 32",
    );
    refused(splat_cloud, &[], "no Gaussian");
    refused(splat_cloud, &[0; 64], "content is zeros alone: expected");
    let text = "0.5 0.25 1.0 of a table of words\n".repeat(32);
    refused(splat_cloud, text.as_bytes(), "content is a text file");
    let png = [&b"\x89PNG\r\n\x1a\n"[..], &[0; 24]].concat();
    refused(splat_cloud, &png, "content is a PNG file");
    let row = |at: usize, value: f32| {
        let mut row = [0; 64];
        row[at..at + 4].copy_from_slice(&value.to_le_bytes());
        row
    };
    refused(
        splat_cloud,
        &row(32, f32::NAN),
        "Gaussian 1: mean[0] is NaN",
    );
    refused(
        splat_cloud,
        &row(48, -1.0),
        "Gaussian 1: scale[1] is -1: expected",
    );
    refused(
        splat_cloud,
        &row(20, f32::INFINITY),
        "Gaussian 0: scale[2] is inf",
    );
}
