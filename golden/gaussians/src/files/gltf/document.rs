//! The JSON of a glTF file as plain data.

use glam::{DMat4, DQuat, DVec3};

use super::super::error::{FileError, Origin};
use super::super::json::Object;

/// The extension of Gaussians.
pub(super) const SPLATTING: &str = "KHR_gaussian_splatting";
/// The extensions of SPZ streams under it: the one of the specification's draft, and its earlier name.
pub(super) const SPZ: [&str; 2] = [
    "KHR_gaussian_splatting_compression_spz_2",
    "KHR_gaussian_splatting_compression_spz",
];
/// Extensions that a file may require.
const KNOWN: [&str; 5] = [
    SPLATTING,
    SPZ[0],
    SPZ[1],
    "KHR_mesh_quantization",
    "KHR_materials_unlit",
];

/// A whole file. Each part has the keys of its fields that nobody uses.
#[derive(Debug)]
pub(super) struct Document {
    /// The program that wrote it.
    pub(super) generator: Option<String>,
    /// The version that it states.
    pub(super) version: String,
    pub(super) buffers: Vec<Buffer>,
    pub(super) views: Vec<View>,
    pub(super) accessors: Vec<Accessor>,
    /// Primitives of each mesh.
    pub(super) meshes: Vec<Vec<Primitive>>,
    pub(super) nodes: Vec<Node>,
    /// Nodes of the scene.
    pub(super) roots: Vec<usize>,
    /// Keys outside of the parts.
    pub(super) rest: Vec<String>,
    /// What the file leaves open.
    pub(super) assumed: Vec<String>,
}

/// An item of `buffers`.
#[derive(Debug)]
pub(super) struct Buffer {
    pub(super) uri: Option<String>,
    pub(super) length: usize,
    pub(super) rest: Vec<String>,
}

/// An item of `bufferViews`.
#[derive(Debug)]
pub(super) struct View {
    pub(super) buffer: usize,
    pub(super) offset: usize,
    pub(super) length: usize,
    pub(super) stride: Option<usize>,
    pub(super) rest: Vec<String>,
}

/// An item of `accessors`.
#[derive(Debug)]
pub(super) struct Accessor {
    pub(super) view: Option<usize>,
    pub(super) offset: usize,
    pub(super) component: usize,
    pub(super) is_normalised: bool,
    pub(super) count: usize,
    pub(super) kind: String,
    pub(super) rest: Vec<String>,
}

/// A primitive with Gaussians.
#[derive(Debug)]
pub(super) struct Primitive {
    /// Its place, for errors.
    pub(super) place: String,
    /// Semantics and accessors.
    pub(super) attributes: Vec<(String, usize)>,
    /// The buffer view with an SPZ file.
    pub(super) spz: Option<usize>,
    pub(super) rest: Vec<String>,
    /// What it leaves open.
    pub(super) assumed: Vec<String>,
}

/// An item of `nodes`.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) mesh: Option<usize>,
    pub(super) children: Vec<usize>,
    /// From its own space to that of its parent.
    pub(super) transform: DMat4,
    /// Keys that matter where it shows Gaussians.
    pub(super) rest: Vec<String>,
}

impl Document {
    /// Reads the JSON.
    pub(super) fn read(json: &[u8], name: Origin<'_>) -> Result<Self, FileError> {
        let mut whole = Object::read(json, "JSON", name)?;
        let mut rest = vec![];
        let mut assumed = vec![];
        let (version, generator) = asset(&mut whole, &mut rest)?;
        whole.texts("extensionsUsed")?;
        let required = whole.texts("extensionsRequired")?;
        if let Some(unknown) = required.iter().find(|own| !KNOWN.contains(&&***own)) {
            let unknown = potamoi_base::file_keys::told(unknown);
            let expected = format!("{}; write the file without it", KNOWN.join(", "));
            return Err(whole.wrong("extensionsRequired", format!("`{unknown}`"), &expected));
        }
        let buffers = parts(&mut whole, "buffers", buffer)?;
        let views = parts(&mut whole, "bufferViews", view)?;
        let accessors = parts(&mut whole, "accessors", accessor)?;
        let mut plain = 0;
        let mut meshes = vec![];
        for mut own in whole.objects("meshes")? {
            let mut all = vec![];
            for own in own.objects("primitives")? {
                match primitive(own.named("primitive"))? {
                    Some(splats) => all.push(splats),
                    None => plain += 1,
                }
            }
            own.finish(&mut rest);
            meshes.push(all);
        }
        if plain > 0 {
            rest.push(format!("primitives without Gaussians ({plain})"));
        }
        let nodes = parts(&mut whole, "nodes", node)?;
        let roots = roots(&mut whole, &nodes, &mut rest, &mut assumed)?;
        whole.finish(&mut rest);
        Ok(Self {
            generator,
            version,
            buffers,
            views,
            accessors,
            meshes,
            nodes,
            roots,
            rest,
            assumed,
        })
    }
}

fn parts<T>(
    whole: &mut Object<'_>,
    key: &str,
    of: impl Fn(Object<'_>) -> Result<T, FileError>,
) -> Result<Vec<T>, FileError> {
    whole.objects(key)?.into_iter().map(of).collect()
}

fn asset(
    whole: &mut Object<'_>,
    rest: &mut Vec<String>,
) -> Result<(String, Option<String>), FileError> {
    let Some(mut own) = whole.object("asset")? else {
        return Err(whole.wrong("asset", "missing", "an object with version 2.0"));
    };
    let version = own.text("version")?;
    for (key, text) in [
        ("version", &version),
        ("minVersion", &own.text("minVersion")?),
    ] {
        let is_known = |text: &str| text == "2.0";
        match text {
            Some(text) if !is_known(text) => {
                return Err(own.wrong(key, format!("`{text}`"), "2.0"));
            }
            None if key == "version" => return Err(own.wrong(key, "missing", "2.0")),
            _ => {}
        }
    }
    let generator = own.text("generator")?;
    own.finish(rest);
    Ok((version.unwrap_or_default(), generator))
}

/// The scene's nodes.
fn roots(
    whole: &mut Object<'_>,
    nodes: &[Node],
    rest: &mut Vec<String>,
    assumed: &mut Vec<String>,
) -> Result<Vec<usize>, FileError> {
    let asked = whole.whole("scene")?;
    let mut scenes = whole.objects("scenes")?;
    let count = scenes.len();
    if let Some(index) = asked.filter(|own| *own >= count) {
        let expected = format!("below {count}, the number of scenes");
        return Err(whole.wrong("scene", index, &expected));
    }
    if count == 0 {
        let mut is_child = vec![false; nodes.len()];
        for child in nodes.iter().flat_map(|own| &own.children) {
            if let Some(own) = is_child.get_mut(*child) {
                *own = true;
            }
        }
        assumed.push("all nodes, of a file without scenes".to_owned());
        return Ok((0..nodes.len()).filter(|i| !is_child[*i]).collect());
    }
    if asked.is_none() && count > 1 {
        assumed.push(format!("the first of {count} scenes"));
    }
    let mut own = scenes.swap_remove(asked.unwrap_or(0));
    let found = own.wholes("nodes")?.unwrap_or_default();
    own.finish(rest);
    Ok(found)
}

fn buffer(mut own: Object<'_>) -> Result<Buffer, FileError> {
    Ok(Buffer {
        uri: own.text("uri")?,
        length: own.needed("byteLength")?,
        rest: left(own),
    })
}

fn view(mut own: Object<'_>) -> Result<View, FileError> {
    Ok(View {
        buffer: own.needed("buffer")?,
        offset: own.whole("byteOffset")?.unwrap_or(0),
        length: own.needed("byteLength")?,
        stride: own.whole("byteStride")?,
        rest: left(own),
    })
}

fn accessor(mut own: Object<'_>) -> Result<Accessor, FileError> {
    Ok(Accessor {
        view: own.whole("bufferView")?,
        offset: own.whole("byteOffset")?.unwrap_or(0),
        component: own.needed("componentType")?,
        is_normalised: own.flag("normalized")?.unwrap_or(false),
        count: own.needed("count")?,
        kind: own.text("type")?.unwrap_or_default(),
        rest: left(own),
    })
}

fn node(mut own: Object<'_>) -> Result<Node, FileError> {
    let matrix = own.numbers::<16>("matrix")?;
    let translation = own.numbers::<3>("translation")?;
    let rotation = own.numbers::<4>("rotation")?;
    let scale = own.numbers::<3>("scale")?;
    if matrix.is_some() && (translation.is_some() || rotation.is_some() || scale.is_some()) {
        let expected = "it, or translation, rotation and scale, not both";
        return Err(own.wrong("matrix", "given beside others", expected));
    }
    let rotation = rotation.map_or(DQuat::IDENTITY, DQuat::from_array);
    if (rotation.length() - 1.0).abs() > 1e-3 {
        let value = format!("of length {}", rotation.length());
        return Err(own.wrong("rotation", value, "a quaternion of length 1"));
    }
    // Rounding of a file's digits is no scale.
    let rotation = match rotation.length() == 1.0 {
        true => rotation,
        false => rotation.normalize(),
    };
    let transform = match matrix {
        Some(matrix) => DMat4::from_cols_array(&matrix),
        None => DMat4::from_scale_rotation_translation(
            scale.map_or(DVec3::ONE, DVec3::from),
            rotation,
            translation.map_or(DVec3::ZERO, DVec3::from),
        ),
    };
    let mesh = own.whole("mesh")?;
    let children = own.wholes("children")?.unwrap_or_default();
    let mut rest = vec![];
    if let Some(extensions) = own.object("extensions")? {
        extensions.finish(&mut rest);
    }
    own.finish(&mut rest);
    Ok(Node {
        mesh,
        children,
        transform,
        rest,
    })
}

/// Reads a primitive; `None` if it has no Gaussians.
fn primitive(mut own: Object<'_>) -> Result<Option<Primitive>, FileError> {
    let place = own.place("attributes");
    let mut rest = vec![];
    let mut extensions = own.object("extensions")?;
    let splatting = match &mut extensions {
        Some(all) => all.object(SPLATTING)?,
        None => None,
    };
    if let Some(all) = extensions {
        all.finish(&mut rest);
    }
    let Some(splatting) = splatting else {
        // What an unknown key of Gaussians would say, must be heard.
        let is_refused = |key: &String| key.ends_with("KHR_spz_gaussian_splats_compression");
        rest.retain(is_refused);
        return Ok((!rest.is_empty()).then_some(Primitive {
            place,
            attributes: vec![],
            spz: None,
            rest,
            assumed: vec![],
        }));
    };
    match own.whole("mode")? {
        Some(0) => {}
        other => {
            let value = other.map_or("missing, which is triangles".to_owned(), |own| {
                own.to_string()
            });
            return Err(own.wrong("mode", value, "0, points"));
        }
    }
    let mut assumed = vec![];
    let spz = described(splatting.named(SPLATTING), &mut rest, &mut assumed)?;
    let mut attributes = vec![];
    if let Some(mut all) = own.object("attributes")? {
        for key in all.names() {
            attributes.push((key.clone(), all.needed(&key)?));
        }
    }
    own.finish(&mut rest);
    Ok(Some(Primitive {
        place,
        attributes,
        spz,
        rest,
        assumed,
    }))
}

/// Checks the fields of the extension, and finds the SPZ file.
fn described(
    mut own: Object<'_>,
    rest: &mut Vec<String>,
    assumed: &mut Vec<String>,
) -> Result<Option<usize>, FileError> {
    const FIELDS: [(&str, &str, bool); 3] = [
        ("kernel", "ellipse", true),
        ("colorSpace", "srgb_rec709_display", true),
        ("projection", "perspective", false),
    ];
    for (key, known, is_needed) in FIELDS {
        match own.text(key)? {
            Some(value) if value != known => {
                let expected = format!("{known}, which alone is rendered; train or convert it so");
                let value = potamoi_base::file_keys::told(&value);
                return Err(own.wrong(key, format!("`{value}`"), &expected));
            }
            None if is_needed => assumed.push(format!("{SPLATTING}.{key} {known}")),
            _ => {}
        }
    }
    match own.text("sortingMethod")?.as_deref() {
        Some("zDepth") => {}
        None | Some("cameraDistance") => {
            assumed.push(
                "Gaussians in order of depth, not of their distance to the camera".to_owned(),
            );
        }
        Some(other) => {
            let value = format!("`{}`", potamoi_base::file_keys::told(other));
            return Err(own.wrong("sortingMethod", value, "cameraDistance or zDepth"));
        }
    }
    let mut spz = None;
    if let Some(mut all) = own.object("extensions")? {
        for key in SPZ {
            if let Some(mut stream) = all.object(key)? {
                spz = Some(stream.needed("bufferView")?);
                stream.finish(rest);
            }
        }
        all.finish(rest);
    }
    own.finish(rest);
    Ok(spz)
}

fn left(own: Object<'_>) -> Vec<String> {
    let mut rest = vec![];
    own.finish(&mut rest);
    rest
}
