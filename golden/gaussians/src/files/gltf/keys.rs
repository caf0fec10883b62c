//! Keys of glTF files.

use potamoi_base::file_keys::{Fate, Format, key};

/// Keys of the format. Of accessors, buffer views, buffers and nodes those that Gaussians use.
pub static FORMAT: Format = Format {
    name: "glTF with KHR_gaussian_splatting",
    files: "`.glb` and `.gltf`: fields of the JSON, of which `primitive` is `meshes.primitives`",
    keys: &[
        key("asset.version", Fate::Honoured, "2.0"),
        key("asset.minVersion", Fate::Honoured, "2.0"),
        key(
            "asset.generator",
            Fate::Honoured,
            "the writer; `inspect` names it",
        ),
        key("asset.*", Fate::Listed, "who wrote it"),
        key(
            "extensionsUsed",
            Fate::Honoured,
            "each is treated where it stands",
        ),
        key(
            "extensionsRequired",
            Fate::Honoured,
            "KHR_gaussian_splatting, its SPZ extension, KHR_mesh_quantization and KHR_materials_unlit; any \
             other is refused",
        ),
        key(
            "scene",
            Fate::Honoured,
            "which scene; the first unless given",
        ),
        key(
            "scenes.nodes",
            Fate::Honoured,
            "its nodes; without scenes all that are no one's children",
        ),
        key("nodes.mesh", Fate::Honoured, "every node shows its mesh"),
        key("nodes.children", Fate::Honoured, "a tree"),
        key(
            "nodes.matrix",
            Fate::Honoured,
            "of all nodes above Gaussians together a rotation, one scale above 0 and a translation; others are \
             refused",
        ),
        key("nodes.translation", Fate::Honoured, "the same"),
        key("nodes.rotation", Fate::Honoured, "the same"),
        key("nodes.scale", Fate::Honoured, "the same"),
        key(
            "nodes.skin",
            Fate::Refused,
            "Gaussians are not bent: apply the skin before export",
        ),
        key(
            "nodes.extensions.EXT_mesh_gpu_instancing",
            Fate::Refused,
            "a node shows its Gaussians once: write a node for each",
        ),
        key("primitive.mode", Fate::Honoured, "0, points"),
        key(
            "primitive.indices",
            Fate::Refused,
            "each Gaussian is drawn once: write them without indices",
        ),
        key(
            "primitive.targets",
            Fate::Refused,
            "Gaussians do not change their form: write them without",
        ),
        key(
            "primitive.material",
            Fate::Listed,
            "Gaussians have colours of their own",
        ),
        key(
            "primitive.extensions.KHR_spz_gaussian_splats_compression",
            Fate::Refused,
            "a draft that others follow otherwise: write KHR_gaussian_splatting_compression_spz_2",
        ),
        key(
            "attributes.POSITION",
            Fate::Honoured,
            "centres, of any type of component",
        ),
        key(
            "attributes.KHR_gaussian_splatting:ROTATION",
            Fate::Honoured,
            "quaternions x, y, z, w: floats, or normalised signed bytes or shorts; of length 0 it is no \
             rotation",
        ),
        key(
            "attributes.KHR_gaussian_splatting:SCALE",
            Fate::Honoured,
            "sizes, not logarithms: floats, or unsigned bytes or shorts, normalised or not; 0 is the smallest \
             normal float",
        ),
        key(
            "attributes.KHR_gaussian_splatting:OPACITY",
            Fate::Honoured,
            "0 to 1: floats, or normalised unsigned bytes or shorts",
        ),
        key(
            "attributes.KHR_gaussian_splatting:SH_DEGREE_*_COEF_*",
            Fate::Whole,
            "coefficients of degree 0 to 3, floats: all of a degree and of those below",
        ),
        key(
            "attributes.KHR_gaussian_splatting:*",
            Fate::Refused,
            "the extension has no such attribute",
        ),
        key(
            "attributes.COLOR_0",
            Fate::Listed,
            "colours for programs that draw points",
        ),
        key("attributes.*", Fate::Listed, "any other"),
        key(
            "KHR_gaussian_splatting.kernel",
            Fate::Honoured,
            "ellipse; assumed where it is missing",
        ),
        key(
            "KHR_gaussian_splatting.colorSpace",
            Fate::Honoured,
            "srgb_rec709_display; assumed where it is missing",
        ),
        key(
            "KHR_gaussian_splatting.projection",
            Fate::Honoured,
            "perspective",
        ),
        key(
            "KHR_gaussian_splatting.sortingMethod",
            Fate::Honoured,
            "zDepth; cameraDistance, the default, is drawn in the profile's order by depth, which is told",
        ),
        key(
            "KHR_gaussian_splatting.extensions.KHR_gaussian_splatting_compression_spz_2.bufferView",
            Fate::Honoured,
            "a whole SPZ file, whose Gaussians stand in the place of attributes; turned from its axes to those \
             of glTF",
        ),
        key(
            "KHR_gaussian_splatting.extensions.KHR_gaussian_splatting_compression_spz.bufferView",
            Fate::Honoured,
            "the same under the extension's earlier name",
        ),
        key("accessors.bufferView", Fate::Honoured, "must be there"),
        key("accessors.byteOffset", Fate::Honoured, "0 unless given"),
        key(
            "accessors.componentType",
            Fate::Honoured,
            "5120 to 5123 or 5126, as the attribute allows",
        ),
        key(
            "accessors.normalized",
            Fate::Honoured,
            "codes over 0 to 1 or -1 to 1",
        ),
        key(
            "accessors.count",
            Fate::Honoured,
            "of all attributes the same",
        ),
        key(
            "accessors.type",
            Fate::Honoured,
            "SCALAR, VEC3 or VEC4, as the attribute needs",
        ),
        key(
            "accessors.sparse",
            Fate::Refused,
            "write the attribute whole",
        ),
        key(
            "accessors.min",
            Fate::Listed,
            "a bound, which follows from the values",
        ),
        key("accessors.max", Fate::Listed, "the same"),
        key("bufferViews.buffer", Fate::Honoured, "which buffer"),
        key("bufferViews.byteOffset", Fate::Honoured, "0 unless given"),
        key(
            "bufferViews.byteLength",
            Fate::Honoured,
            "within its buffer",
        ),
        key(
            "bufferViews.byteStride",
            Fate::Honoured,
            "bytes from one element to the next",
        ),
        key(
            "bufferViews.target",
            Fate::Listed,
            "a hint for graphics memory",
        ),
        key(
            "buffers.uri",
            Fate::Honoured,
            "a file in the folder or below it, or base64 data; none for the chunk of a `.glb`",
        ),
        key(
            "buffers.byteLength",
            Fate::Honoured,
            "as long as that, or shorter",
        ),
        key(
            "chunk *",
            Fate::Listed,
            "of a `.glb`, of a type that means nothing",
        ),
        key("bytes after *", Fate::Listed, "what follows a `.glb`"),
        key(
            "primitives without *",
            Fate::Listed,
            "meshes of points, lines or triangles",
        ),
        key(
            "meshes that *",
            Fate::Listed,
            "Gaussians that the scene does not show",
        ),
        key(
            "animations",
            Fate::Listed,
            "the model stands as its nodes do",
        ),
    ],
    others: Fate::Listed,
};
