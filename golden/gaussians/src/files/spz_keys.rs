//! Keys of SPZ files.

use potamoi_base::file_keys::{Fate, Format, key};

/// The flag of antialiased training.
pub(super) const ANTIALIASED: &str = "flag 0x01";
/// The flag of extensions.
pub(super) const EXTENDED: &str = "flag 0x02";
/// The extension that names the axes.
pub(super) const AXES: &str = "extension 0xadbe0003";

/// Keys of the format: parts of the header, and extensions, which are known by number.
pub static FORMAT: Format = Format {
    name: "SPZ of Niantic",
    files: "`.spz`, versions 1 to 4: fields and flags of the header, and extensions",
    keys: &[
        key(
            "version",
            Fate::Honoured,
            "1 to 4; up to 3 in a gzip stream or bare, 4 with ZSTD streams",
        ),
        key("number of Gaussians", Fate::Honoured, "1 or more"),
        key("degree of spherical harmonics", Fate::Honoured, "0 to 3"),
        key(
            "fractional bits",
            Fate::Honoured,
            "of centres, 0 to 24; not used by version 1, whose centres are floats of 16 bits",
        ),
        key(ANTIALIASED, Fate::Honoured, "trained with antialiasing"),
        key(
            EXTENDED,
            Fate::Honoured,
            "extensions follow; without it, what stands there is listed as bytes after the arrays",
        ),
        key("flag *", Fate::Listed, "no other flag is known"),
        key(
            AXES,
            Fate::Honoured,
            "the axes, 1 to 8: LDB, RDB, LUB, RUB, LDF, RDF, LUF, RUF; 0 or without it RUB",
        ),
        key(
            "extension 0xadbe0002",
            Fate::Listed,
            "limits of a viewer's orbit",
        ),
        key("extension *", Fate::Listed, "no other extension is known"),
        key(
            "reserved *",
            Fate::Listed,
            "bytes of the header that are not 0",
        ),
        key(
            "bytes after *",
            Fate::Listed,
            "what follows the arrays, the extensions or the stream",
        ),
    ],
    others: Fate::Refused,
};
