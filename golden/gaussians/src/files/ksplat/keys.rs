//! Keys of `.ksplat` files.

use potamoi_base::file_keys::{Fate, Format, key};

/// The point around which a viewer loads.
pub(super) const CENTRE: &str = "scene centre";

/// Keys of the format: fields of the header and of sections, and parts of a row.
pub static FORMAT: Format = Format {
    name: "KSplat of GaussianSplats3D",
    files: "`.ksplat`: fields of the header, fields of each section, and parts of a row",
    keys: &[
        key("version", Fate::Honoured, "0.1"),
        key(
            "sections",
            Fate::Honoured,
            "those that are written (0: all), and those that there is room for; 1 or more",
        ),
        key(
            "number of Gaussians",
            Fate::Honoured,
            "of the file and of each section, in agreement; 1 or more",
        ),
        key(
            "compression level",
            Fate::Honoured,
            "0: floats of 32 bits; 1: centres of 16 bits about the middle of a bucket, other floats of 16 \
             bits; 2: as 1, with coefficients of 8 bits",
        ),
        key(
            "range of coefficients",
            Fate::Honoured,
            "smallest and largest at level 2; 0 is -1.5 or 1.5",
        ),
        key(
            "section *: buckets",
            Fate::Honoured,
            "their number, those that are full, Gaussians in a full one and in each of the others, their \
             middles, and their edge",
        ),
        key(
            "section *: range of centres",
            Fate::Honoured,
            "codes a half edge of a bucket, 1 to 65535; 0 is 32767",
        ),
        key(
            "section *: bytes",
            Fate::Honoured,
            "as many as its Gaussians and buckets need, or 0",
        ),
        key("section *: degree", Fate::Honoured, "0 to 2"),
        key(
            "row",
            Fate::Honoured,
            "centre, sizes (not logarithms; 0 is the smallest normal float), quaternion w, x, y, z, colour and \
             opacity as bytes of 1/255, coefficients band by band and channel by channel",
        ),
        key(
            CENTRE,
            Fate::Listed,
            "where a viewer begins to load; no part of the picture",
        ),
        key(
            "reserved *",
            Fate::Listed,
            "bytes of headers that are not 0 and mean nothing",
        ),
        key(
            "section *: room for *",
            Fate::Listed,
            "rows that no Gaussian was written to",
        ),
        key("bytes after *", Fate::Listed, "what follows the sections"),
    ],
    others: Fate::Refused,
};
