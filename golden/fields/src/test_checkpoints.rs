//! Checkpoints for tests: valid containers with arbitrary contents.

#![allow(clippy::unwrap_used)]

use std::io::Write as _;

use proptest::prelude::*;
use proptest::sample::Index;
use tempfile::NamedTempFile;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

/// The content of a checkpoint.
#[derive(Debug, Clone)]
pub(crate) enum Content {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(String),
    List(Vec<Content>),
    Dict(Vec<(String, Content)>),
    /// Shape and stored numbers, in order.
    Tensor(Vec<usize>, Vec<f32>),
    /// Shape and bytes of a tensor of `torch.uint8`.
    Bytes(Vec<usize>, Vec<u8>),
}

impl Content {
    /// A tensor of small, distinct numbers.
    pub(crate) fn tensor(shape: &[usize]) -> Self {
        let count = shape.iter().product::<usize>();
        let values = (0..count).map(|i| ((i * 37 + 11) % 64) as f32 / 64.0 - 0.4);
        Self::Tensor(shape.to_vec(), values.collect())
    }

    pub(crate) fn text(text: &str) -> Self {
        Self::Text(text.to_owned())
    }

    pub(crate) fn whole(values: &[i64]) -> Self {
        Self::List(values.iter().map(|v| Self::Int(*v)).collect())
    }

    pub(crate) fn dict<const N: usize>(items: [(&str, Self); N]) -> Self {
        Self::Dict(items.map(|(k, v)| (k.to_owned(), v)).into())
    }

    /// Writes the file that `torch.save` could have written.
    pub(crate) fn save(&self) -> NamedTempFile {
        let (mut pickle, mut storages) = (vec![0x80, 2], vec![]);
        self.pickle(&mut pickle, &mut storages);
        pickle.push(b'.');
        let file = NamedTempFile::new().unwrap();
        let mut zip = ZipWriter::new(file.reopen().unwrap());
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        zip.start_file("m/data.pkl", options).unwrap();
        zip.write_all(&pickle).unwrap();
        for (i, bytes) in storages.iter().enumerate() {
            zip.start_file(format!("m/data/{i}"), options).unwrap();
            zip.write_all(bytes).unwrap();
        }
        zip.finish().unwrap();
        file
    }

    fn pickle(&self, p: &mut Vec<u8>, storages: &mut Vec<Vec<u8>>) {
        match self {
            Self::None => p.push(b'N'),
            Self::Bool(value) => p.push(if *value { 0x88 } else { 0x89 }),
            Self::Int(value) => int(p, *value),
            Self::Float(value) => {
                p.push(b'G');
                p.extend(value.to_be_bytes());
            }
            Self::Text(value) => text(p, value),
            Self::List(items) => {
                p.extend(b"](");
                items.iter().for_each(|item| item.pickle(p, storages));
                p.push(b'e');
            }
            Self::Dict(items) => {
                p.extend(b"}(");
                for (key, item) in items {
                    text(p, key);
                    item.pickle(p, storages);
                }
                p.push(b'u');
            }
            Self::Tensor(shape, values) => {
                let bytes = values.iter().flat_map(|v| v.to_le_bytes()).collect();
                stored(p, storages, shape, ("FloatStorage", values.len(), bytes));
            }
            Self::Bytes(shape, bytes) => {
                stored(
                    p,
                    storages,
                    shape,
                    ("ByteStorage", bytes.len(), bytes.clone()),
                );
            }
        }
    }

    /// Number of dictionary items at any depth.
    fn count(&self) -> usize {
        match self {
            Self::Dict(items) => items.iter().map(|(_, item)| 1 + item.count()).sum(),
            _ => 0,
        }
    }

    /// Applies a harm to item `at`.
    fn harm(&mut self, at: &mut usize, harm: &Harm) {
        let Self::Dict(items) = self else { return };
        for i in 0..items.len() {
            if *at == 0 {
                *at = usize::MAX;
                if let Harm::Remove = harm {
                    items.remove(i);
                } else {
                    items[i].1.harmed(harm);
                }
                return;
            }
            *at -= 1;
            items[i].1.harm(at, harm);
            if *at == usize::MAX {
                return;
            }
        }
    }

    /// Gives every tensor of more than three axes the same size along one of the last three.
    fn together(&mut self, axis: Index, side: usize) {
        match self {
            Self::Dict(items) => {
                items
                    .iter_mut()
                    .for_each(|item| item.1.together(axis, side));
            }
            Self::Tensor(shape, values) if shape.len() > 3 => {
                let at = shape.len() - 3 + axis.index(3);
                shape[at] = side;
                fill(shape, values, true);
            }
            _ => {}
        }
    }

    fn harmed(&mut self, harm: &Harm) {
        match (harm, &mut *self) {
            (Harm::Replace(other), _) => *self = other.clone(),
            (Harm::Number(_, value), Self::Int(_) | Self::Float(_)) => *self = Self::Float(*value),
            (Harm::Number(at, value), Self::List(items)) if !items.is_empty() => {
                let at = at.index(items.len());
                items[at] = Self::Float(*value);
            }
            (Harm::Number(at, value), Self::Tensor(_, values)) if !values.is_empty() => {
                let at = at.index(values.len());
                values[at] = *value as f32;
            }
            (Harm::Side(at, side, filled), Self::Tensor(shape, values)) if !shape.is_empty() => {
                let at = at.index(shape.len());
                shape[at] = *side;
                fill(shape, values, *filled);
            }
            (Harm::Side(_, side, _), Self::Int(value)) => *value = *side as i64,
            (Harm::Side(at, side, _), Self::List(items)) if !items.is_empty() => {
                let at = at.index(items.len());
                items[at] = Self::Int(*side as i64);
            }
            (Harm::Axes(axes), Self::Tensor(shape, values)) => {
                shape.resize(*axes, 1);
                fill(shape, values, true);
            }
            (Harm::Axes(axes), Self::List(items)) => items.truncate(*axes),
            _ => {}
        }
    }
}

/// Fills up the numbers of a shape, if they are few.
fn fill(shape: &[usize], values: &mut Vec<f32>, filled: bool) {
    let count = shape.iter().try_fold(1usize, |n, s| n.checked_mul(*s));
    if let Some(count) = count.filter(|n| filled && *n < 1 << 14) {
        values.resize(count, 0.25);
    }
}

fn int(p: &mut Vec<u8>, value: i64) {
    p.extend([0x8a, 8]);
    p.extend(value.to_le_bytes());
}

fn text(p: &mut Vec<u8>, text: &str) {
    p.push(b'X');
    p.extend((text.len() as u32).to_le_bytes());
    p.extend(text.as_bytes());
}

/// A change to one item of a checkpoint.
#[derive(Debug, Clone)]
pub(crate) enum Harm {
    Remove,
    Replace(Content),
    /// Changes a number of it, or the number that it is.
    Number(Index, f64),
    /// Changes a side of its shape, with or without numbers to fill it.
    Side(Index, usize, bool),
    /// Changes its number of axes.
    Axes(usize),
    /// Changes a side of all grids alike, so that they still fit one another.
    Together(Index, usize),
}

fn number() -> impl Strategy<Value = f64> {
    let known = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        0.5,
        3.0,
        17.0,
        1e-300,
        1e-9,
        1e9,
        1e19,
        3e38,
        1e300,
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
    ];
    prop::sample::select(known.to_vec())
}

fn side() -> impl Strategy<Value = usize> {
    let large = [1 << 14, 1 << 20, 1 << 31, 1 << 40, i64::MAX as usize];
    let known: Vec<usize> = (0..10).chain(large).collect();
    prop::sample::select(known)
}

fn other() -> impl Strategy<Value = Content> {
    let shape = prop::collection::vec(0usize..4, 0..6);
    prop_oneof![
        number().prop_map(Content::Float),
        any::<i64>().prop_map(Content::Int),
        Just(Content::text("softplus")),
        Just(Content::List(vec![])),
        Just(Content::Dict(vec![])),
        prop::collection::vec(number().prop_map(Content::Float), 0..8).prop_map(Content::List),
        shape.prop_map(|shape| Content::tensor(&shape)),
    ]
}

/// One to three harms with their positions.
pub(crate) fn harms() -> impl Strategy<Value = Vec<(Index, Harm)>> {
    let harm = prop_oneof![
        Just(Harm::Remove),
        other().prop_map(Harm::Replace),
        (any::<Index>(), number()).prop_map(|(at, value)| Harm::Number(at, value)),
        (any::<Index>(), number()).prop_map(|(at, value)| Harm::Number(at, value)),
        (any::<Index>(), side(), any::<bool>()).prop_map(|(at, n, fill)| Harm::Side(at, n, fill)),
        (any::<Index>(), side(), any::<bool>()).prop_map(|(at, n, fill)| Harm::Side(at, n, fill)),
        (0usize..7).prop_map(Harm::Axes),
        (any::<Index>(), side()).prop_map(|(at, side)| Harm::Together(at, side)),
    ];
    prop::collection::vec((any::<Index>(), harm), 1..4)
}

/// A checkpoint after the harms.
pub(crate) fn harmed(whole: &Content, harms: &[(Index, Harm)]) -> Content {
    let mut made = whole.clone();
    for (at, harm) in harms {
        let count = made.count();
        if let Harm::Together(axis, side) = harm {
            made.together(*axis, *side);
        } else if count > 0 {
            made.harm(&mut at.index(count), harm);
        }
    }
    made
}

/// Checks what every loader must do: load the unchanged checkpoint, and for a harmed one either
/// return a field that can be rendered or name the file in one line. Few harmed values are huge,
/// so a run takes neither long nor much memory.
pub(crate) fn survives<F: crate::Field>(
    whole: &Content,
    harms: &[(Index, Harm)],
    load: impl Fn(&std::path::Path) -> Result<F, crate::FieldError>,
    also: impl Fn(&F),
) -> Result<(), TestCaseError> {
    use glam::DVec3;
    use potamoi_base::camera::Camera;

    let file = harmed(whole, harms).save();
    let start = std::time::Instant::now();
    let loaded = load(file.path());
    prop_assert!(start.elapsed().as_secs_f64() < 30.0, "it took long");
    match loaded {
        Ok(field) => {
            let eye = DVec3::new(2.0, 1.5, 1.0);
            let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Z, 0.5, 2, 1);
            let _ = crate::render_float(&field, &camera, [0.0; 3]);
            also(&field);
        }
        Err(error) => {
            let error = error.to_string();
            let named = error.contains(&file.path().display().to_string());
            prop_assert!(
                named && !error.contains('\n') && error.len() < 1000,
                "{}",
                error
            );
        }
    }
    Ok(())
}

/// A tensor of this shape with a storage of its own: its class, its number of elements, and their
/// bytes.
fn stored(
    p: &mut Vec<u8>,
    storages: &mut Vec<Vec<u8>>,
    shape: &[usize],
    (class, count, bytes): (&str, usize, Vec<u8>),
) {
    p.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
    text(p, "storage");
    p.extend(format!("ctorch\n{class}\n").bytes());
    text(p, &storages.len().to_string());
    text(p, "cpu");
    int(p, count as i64);
    p.extend(b"tQK\0");
    let mut strides = vec![1usize; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis].saturating_mul(shape[axis]);
    }
    for sizes in [shape, &strides] {
        p.push(b'(');
        sizes.iter().for_each(|n| int(p, *n as i64));
        p.push(b't');
    }
    p.extend(b"\x89ccollections\nOrderedDict\n)RtR");
    storages.push(bytes);
}
