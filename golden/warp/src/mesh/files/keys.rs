//! Keys of mesh files.

use potamoi_base::file_keys::Fate::{Honoured, Listed, Refused};
use potamoi_base::file_keys::{Format, key};

const CURVES: &str = "points, lines and curves are no surface";
const LOOKS: &str = "no part of depth";
const LETTERS: &str = "words are of small letters: write `v` and `f`";

/// Keys of OBJ: the first words of lines.
pub static OBJ: Format = Format {
    name: "Wavefront OBJ",
    files: "`.obj`, the mesh of `warp --mesh`: lines by their first words. Lines end in a line feed, a \
            carriage return, or both; a byte-order mark does no harm.",
    keys: &[
        key("v", Honoured, "the place of a vertex, three finite numbers"),
        key("f", Honoured, "a face of 3 corners or more"),
        key("weight of v", Listed, "of curves; 1 is accepted"),
        key("colour of v", Listed, LOOKS),
        key("texture of f", Listed, LOOKS),
        key("normal of f", Listed, LOOKS),
        key("vt", Listed, LOOKS),
        key("vn", Listed, LOOKS),
        key("g", Listed, LOOKS),
        key("o", Listed, LOOKS),
        key("s", Listed, LOOKS),
        key("mtllib", Listed, LOOKS),
        key("usemtl", Listed, LOOKS),
        key("p", Listed, CURVES),
        key("l", Listed, CURVES),
        key("vp", Listed, CURVES),
        key("curv*", Listed, CURVES),
        key(
            "surf",
            Refused,
            "no depth is taken of free-form surfaces: write polygons",
        ),
        key("fo", Refused, "the word for faces is `f`: write it so"),
        key(
            "call",
            Refused,
            "other files are not read: write all into one",
        ),
        key("V", Refused, LETTERS),
        key("F", Refused, LETTERS),
        key("#*", Listed, "comments"),
    ],
    others: Listed,
};

/// Keys of PLY: properties after the names of their elements, other elements, and comments.
pub static PLY: Format = Format {
    name: "PLY of meshes",
    files: "`.ply`, the mesh of `warp --mesh`: properties of vertices and faces, other elements, and \
            comments",
    keys: &[
        key(
            "vertex/x",
            Honoured,
            "float or double: integers are codes, not places",
        ),
        key("vertex/y", Honoured, "the same"),
        key("vertex/z", Honoured, "the same"),
        key("vertex/*", Listed, LOOKS),
        key(
            "face/vertex_indices",
            Honoured,
            "a list of 3 corners or more",
        ),
        key("face/vertex_index", Honoured, "the same by its other name"),
        key("face/*", Listed, LOOKS),
        key(
            "element tristrips",
            Refused,
            "no depth is taken of strips: write faces",
        ),
        key("element *", Listed, "no part of the surface"),
        key("comment *", Listed, "for the reader"),
        key("obj_info *", Listed, "for the reader"),
        key("bytes after *", Listed, "what follows the last element"),
    ],
    others: Listed,
};
