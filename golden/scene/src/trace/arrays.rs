//! Named arrays in an NPZ file, each with a digest.

use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;

use ndarray::ArrayD;
use ndarray_npy::{ReadNpyExt as _, WriteNpyExt as _};
use potamoi_formats::document;
use serde::{Deserialize, Serialize};
use zip::read::ZipArchive;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::TraceError;
use potamoi_base::file_keys::told;
use potamoi_containers::archive;

/// Name of the JSON header among the arrays.
const HEADER: &str = "header";
/// The largest header, in bytes.
const HEADER_LIMIT: u64 = 1 << 24;
/// Room for an array's own header, in bytes.
const NPY_HEADER: u64 = 4096;
/// Maximum number of elements in an array: 4 GiB of the widest type.
const MAX_ELEMENTS: u64 = 1 << 30;

/// Description of an array in the header.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Info {
    pub(super) name: String,
    /// Type as NumPy names it, little-endian.
    dtype: String,
    shape: Vec<usize>,
    /// BLAKE3 hash of the member, 64 hexadecimal digits.
    digest: String,
}

/// The values of an array.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Values {
    I16(ArrayD<i16>),
    U16(ArrayD<u16>),
    I32(ArrayD<i32>),
    U32(ArrayD<u32>),
}

impl Values {
    const fn dtype(&self) -> &'static str {
        match self {
            Self::I16(_) => "<i2",
            Self::U16(_) => "<u2",
            Self::I32(_) => "<i4",
            Self::U32(_) => "<u4",
        }
    }

    fn shape(&self) -> Vec<usize> {
        match self {
            Self::I16(a) => a.shape().to_vec(),
            Self::U16(a) => a.shape().to_vec(),
            Self::I32(a) => a.shape().to_vec(),
            Self::U32(a) => a.shape().to_vec(),
        }
    }

    fn npy(&self) -> Result<Vec<u8>, String> {
        let mut bytes = vec![];
        match self {
            Self::I16(a) => a.write_npy(&mut bytes),
            Self::U16(a) => a.write_npy(&mut bytes),
            Self::I32(a) => a.write_npy(&mut bytes),
            Self::U32(a) => a.write_npy(&mut bytes),
        }
        .map_err(|e| e.to_string())?;
        Ok(bytes)
    }

    fn from_npy(dtype: &str, bytes: &[u8]) -> Result<Self, String> {
        let text = |e: ndarray_npy::ReadNpyError| e.to_string();
        match dtype {
            "<i2" => ArrayD::read_npy(bytes).map(Self::I16).map_err(text),
            "<u2" => ArrayD::read_npy(bytes).map(Self::U16).map_err(text),
            "<i4" => ArrayD::read_npy(bytes).map(Self::I32).map_err(text),
            "<u4" => ArrayD::read_npy(bytes).map(Self::U32).map_err(text),
            other => Err(format!(
                "values of type {other}: expected <i2, <u2, <i4 or <u4"
            )),
        }
    }
}

/// Rows of equal width.
pub(super) fn rows<T: Copy, const N: usize>(values: &[[T; N]]) -> ArrayD<T> {
    let view = ndarray::aview2(values);
    view.to_owned().into_dyn()
}

/// Elements as one row.
pub(super) fn list<T>(values: Vec<T>) -> ArrayD<T> {
    ndarray::Array1::from(values).into_dyn()
}

/// Message for a file or a header of another kind.
const NO_ARCHIVE: &str = "no whole NPZ archive: expected a file of `potamoi trace`";
const NO_HEADER: &str = "no list of bytes: expected the header that `potamoi trace` writes first";

/// The bytes of an NPZ file: header first, then the arrays in order. Equal content gives equal
/// bytes.
pub(super) fn pack<H: Serialize>(
    header: impl FnOnce(Vec<Info>) -> H,
    arrays: &[(&str, Values)],
) -> Result<Vec<u8>, String> {
    let mut members = vec![];
    let mut infos = vec![];
    for (name, values) in arrays {
        let bytes = values.npy()?;
        infos.push(Info {
            name: (*name).to_owned(),
            dtype: values.dtype().to_owned(),
            shape: values.shape(),
            digest: blake3::hash(&bytes).to_hex().to_string(),
        });
        members.push((*name, bytes));
    }
    let text = serde_json::to_vec(&header(infos)).map_err(|e| e.to_string())?;
    let mut json = vec![];
    list(text).write_npy(&mut json).map_err(|e| e.to_string())?;
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    let options = SimpleFileOptions::default()
        .compression_method(zip::CompressionMethod::Deflated)
        .last_modified_time(zip::DateTime::default())
        .large_file(true);
    for (name, bytes) in std::iter::once((HEADER, json)).chain(members) {
        zip.start_file(format!("{name}.npy"), options)
            .map_err(|e| e.to_string())?;
        zip.write_all(&bytes).map_err(|e| e.to_string())?;
    }
    Ok(zip.finish().map_err(|e| e.to_string())?.into_inner())
}

/// An NPZ file whose header has been read.
pub(super) struct Packed<'a> {
    path: &'a Path,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    infos: Vec<Info>,
    next: usize,
}

impl<'a> Packed<'a> {
    /// Reads the header; `infos` locates the array descriptions in it.
    pub(super) fn open<H: serde::de::DeserializeOwned>(
        path: &'a Path,
        bytes: &'a [u8],
        infos: impl FnOnce(&H) -> &[Info],
    ) -> Result<(H, Self), TraceError> {
        let container = |problem: String| TraceError::Container {
            path: path.to_owned(),
            problem,
        };
        let mut zip =
            ZipArchive::new(Cursor::new(bytes)).map_err(|_| container(NO_ARCHIVE.to_owned()))?;
        let beside = archive::beside(&zip, Cursor::new(bytes));
        let beside = beside.map_err(|e| container(e.to_string()))?;
        if let Some(twice) = beside.twice {
            let problem = "given twice: expected it once".to_owned();
            return Err(array_error(path, &twice, problem));
        }
        if let Some(key) = beside.keys.first() {
            return Err(container(format!("{key}: expected its arrays alone")));
        }
        let member = member(&mut zip, path, HEADER, HEADER_LIMIT)?;
        let wrong = |problem: String| array_error(path, HEADER, problem);
        let text = ndarray::Array1::<u8>::read_npy(&member[..])
            .map_err(|_| wrong(NO_HEADER.to_owned()))?;
        let header = document::json(&text.to_vec()).and_then(|header| header.read());
        let header: H = header.map_err(|e| wrong(e.to_string()))?;
        let infos = infos(&header).to_vec();
        let names: Vec<String> = (0..zip.len())
            .filter_map(|i| Some(zip.by_index_raw(i).ok()?.name().to_owned()))
            .collect();
        let expected = std::iter::once(HEADER).chain(infos.iter().map(|i| i.name.as_str()));
        let mut found = names.iter();
        for (place, name) in expected.enumerate() {
            let file = format!("{name}.npy");
            match found.next() {
                Some(other) if *other == file => {}
                Some(other) => {
                    let other = told(other);
                    let problem = if names.contains(&file) {
                        format!("out of place: `{other}` stands at place {place}")
                    } else {
                        format!("missing; `{other}` stands at place {place}")
                    };
                    return Err(array_error(path, name, problem));
                }
                None => return Err(array_error(path, name, "missing".to_owned())),
            }
        }
        if let Some(extra) = found.next() {
            let problem = "not in the header: expected only what the header lists".to_owned();
            return Err(array_error(path, extra, problem));
        }
        Ok((
            header,
            Self {
                path,
                zip,
                infos,
                next: 0,
            },
        ))
    }

    /// Name of the next array.
    pub(super) fn next_name(&self) -> Option<&str> {
        Some(self.infos.get(self.next)?.name.as_str())
    }

    /// The next array, which must have the name `name`.
    fn take(&mut self, name: &str) -> Result<Values, TraceError> {
        let wrong = |problem: String| array_error(self.path, name, problem);
        let info = self.infos.get(self.next);
        let info = info.filter(|i| i.name == name);
        let Some(info) = info else {
            return Err(wrong("not in its place in the header".to_owned()));
        };
        let width = match info.dtype.as_str() {
            "<i2" | "<u2" => 2,
            "<i4" | "<u4" => 4u64,
            other => {
                let other = told(other);
                return Err(wrong(format!(
                    "values of type {other}: expected <i2, <u2, <i4 or <u4"
                )));
            }
        };
        let elements = info
            .shape
            .iter()
            .try_fold(1u64, |n, side| n.checked_mul(*side as u64))
            .filter(|n| *n <= MAX_ELEMENTS);
        let Some(elements) = elements else {
            let shape = told(&format!("{:?}", info.shape));
            return Err(wrong(format!(
                "shape {shape}: expected at most {MAX_ELEMENTS} elements"
            )));
        };
        let limit = elements * width + NPY_HEADER;
        let bytes = member(&mut self.zip, self.path, name, limit)?;
        if blake3::hash(&bytes).to_hex().to_string() != info.digest {
            return Err(wrong(
                "its values are not those that were written".to_owned(),
            ));
        }
        // The member's own header may claim another shape, and with it memory.
        let shape = match info.shape.as_slice() {
            [n] => format!("({n},)"),
            other => {
                let sides: Vec<_> = other.iter().map(ToString::to_string).collect();
                format!("({})", sides.join(", "))
            }
        };
        // Version 1.0 has a length of two bytes before its header.
        let dtype = &info.dtype;
        let head = format!("{{'descr': '{dtype}', 'fortran_order': False, 'shape': {shape}");
        let own = bytes.strip_prefix(b"\x93NUMPY\x01\x00");
        let own = own.and_then(|b| b.get(2..)?.strip_prefix(head.as_bytes()));
        if !own.is_some_and(|rest| rest.starts_with(b"}") || rest.starts_with(b", }")) {
            return Err(wrong(format!(
                "its own header is not that of a {dtype} array of shape {}, row by row, as \
                 the trace's header says",
                told(&shape)
            )));
        }
        let values = Values::from_npy(&info.dtype, &bytes).map_err(wrong)?;
        self.next += 1;
        Ok(values)
    }
}

/// Defines a method that takes the next array, with values of one type and rows of one width.
macro_rules! taker {
    ($name:ident, $variant:ident, $type:ty) => {
        pub(super) fn $name(
            &mut self,
            name: &str,
            width: Option<usize>,
        ) -> Result<Vec<$type>, TraceError> {
            let path = self.path;
            let wrong = |problem: String| array_error(path, name, problem);
            let values = self.take(name)?;
            let Values::$variant(array) = values else {
                let found = values.dtype();
                return Err(wrong(format!(
                    "values of type {found}: expected {}",
                    stringify!($type)
                )));
            };
            let right = match width {
                None => array.ndim() == 1,
                Some(width) => array.ndim() == 2 && array.shape()[1] == width,
            };
            if !right {
                let shape = array.shape();
                return Err(wrong(format!(
                    "shape {shape:?}: expected rows of {}",
                    width.unwrap_or(1)
                )));
            }
            Ok(array.iter().copied().collect())
        }
    };
}

impl Packed<'_> {
    taker!(i16s, I16, i16);
    taker!(u16s, U16, u16);
    taker!(i32s, I32, i32);
    taker!(u32s, U32, u32);
}

pub(super) fn array_error(path: &Path, array: &str, problem: String) -> TraceError {
    TraceError::Array {
        path: path.to_owned(),
        array: told(array.trim_end_matches(".npy")),
        problem,
    }
}

/// The bytes of a member, at most `limit`.
fn member(
    zip: &mut ZipArchive<Cursor<&[u8]>>,
    path: &Path,
    name: &str,
    limit: u64,
) -> Result<Vec<u8>, TraceError> {
    let wrong = |problem: String| array_error(path, name, problem);
    let file = zip
        .by_name(&format!("{name}.npy"))
        .map_err(|_| wrong("missing: expected a file of `potamoi trace`".to_owned()))?;
    let mut bytes = vec![];
    file.take(limit + 1)
        .read_to_end(&mut bytes)
        .map_err(|_| wrong("its packed bytes are damaged or cut off".to_owned()))?;
    if bytes.len() as u64 > limit {
        return Err(wrong(format!(
            "more than the {limit} bytes that its shape takes"
        )));
    }
    Ok(bytes)
}
