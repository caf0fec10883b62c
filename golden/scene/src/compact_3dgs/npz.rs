//! Arrays of an `.npz` file in NumPy's format (`numpy.lib.format`, versions 1 to 3): a ZIP archive
//! with one member an array, each with a text header.

use std::io::{Cursor, Read as _};

use half::f16;
use zip::ZipArchive;

use potamoi_containers::archive;
use potamoi_gaussians::files::{FileError, Origin};

/// Maximum ratio of a member's unpacked size to the size of the file.
const RATIO: u64 = 64;
/// The longest header of an array, in bytes.
const LONGEST_HEADER: usize = 1 << 12;
/// Maximum number of array names in a message.
const LISTED: usize = 16;

/// An open archive.
pub(super) struct Npz<'a> {
    name: Origin<'a>,
    zip: ZipArchive<Cursor<&'a [u8]>>,
    most: u64,
    beside: Vec<String>,
}

/// An array.
pub(super) struct Array<'a> {
    name: Origin<'a>,
    /// Name in messages.
    field: String,
    /// Type as NumPy names it.
    kind: String,
    pub(super) shape: Vec<usize>,
    bytes: Vec<u8>,
}

impl<'a> Npz<'a> {
    pub(super) fn open(bytes: &'a [u8], name: Origin<'a>) -> Result<Self, FileError> {
        let damaged = |_| name.part("ZIP archive", "there is none, or it is cut off");
        let zip = ZipArchive::new(Cursor::new(bytes)).map_err(damaged)?;
        let cut = |_| name.part("ZIP archive", "it is cut off");
        let beside = archive::beside(&zip, Cursor::new(bytes)).map_err(cut)?;
        if let Some(twice) = beside.twice {
            return Err(name.field(format!("member `{twice}`"), "given twice", "it once"));
        }
        Ok(Self {
            name,
            most: bytes.len() as u64 * RATIO,
            beside: beside.keys,
            zip,
        })
    }

    /// Names of the arrays and of other members.
    pub(super) fn keys(&self) -> impl Iterator<Item = String> {
        let names = self.names().map(str::to_owned);
        names.chain(self.beside.iter().cloned())
    }

    /// Names of the arrays, in order.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let names = self.zip.file_names();
        names.map(|n| n.strip_suffix(".npy").unwrap_or(n))
    }

    /// Checks that the file has these arrays.
    pub(super) fn require(&self, arrays: &[&str]) -> Result<(), FileError> {
        let missing = arrays.iter().find(|a| self.names().all(|n| n != **a));
        let Some(missing) = missing else {
            return Ok(());
        };
        let mut held: Vec<_> = self.names().take(LISTED).collect();
        held.sort_unstable();
        let value = format!("missing from {}", held.join(", "));
        let expected = format!("{}, as save_npz of Compact-3DGS writes", arrays.join(", "));
        Err(self.name.field(array(missing), value, expected))
    }

    pub(super) fn array(&mut self, own: &str) -> Result<Array<'a>, FileError> {
        let (name, field) = (self.name, array(own));
        let fail = |message: String| name.part(field.clone(), message);
        let file = self.zip.by_name(&format!("{own}.npy"));
        let file =
            file.map_err(|_| fail("the archive has no such member that can be read".to_owned()))?;
        let mut bytes = vec![];
        file.take(self.most + 1)
            .read_to_end(&mut bytes)
            .map_err(|_| fail("it ends early, or its checksum is wrong".to_owned()))?;
        if bytes.len() as u64 > self.most {
            let most = self.most;
            return Err(fail(format!(
                "more than {most} bytes, {RATIO} times the file"
            )));
        }
        let (header, from) = header(&bytes).map_err(fail)?;
        let (kind, shape) = described(header).map_err(|problem| {
            let shown: String = header.chars().take(80).collect();
            name.part(field.clone(), format!("header `{shown}`: {problem}"))
        })?;
        bytes.drain(..from);
        let array = Array {
            name,
            field,
            kind,
            shape,
            bytes,
        };
        array.check_length()?;
        Ok(array)
    }
}

fn array(name: &str) -> String {
    format!("array `{name}`")
}

/// The text of the header, and the offset of the numbers.
fn header(bytes: &[u8]) -> Result<(&str, usize), String> {
    let rest = bytes.strip_prefix(b"\x93NUMPY");
    let version = rest.and_then(|r| r.first_chunk::<2>());
    let (Some(rest), Some([major, _])) = (rest, version) else {
        return Err("no array of NumPy".to_owned());
    };
    let rest = &rest[2..];
    let length = match major {
        1 => rest
            .first_chunk()
            .map(|b| (2, u16::from_le_bytes(*b) as usize)),
        2 | 3 => rest
            .first_chunk()
            .map(|b| (4, u32::from_le_bytes(*b) as usize)),
        other => return Err(format!("version {other} of the format: expected 1 to 3")),
    };
    let (width, length) = length.ok_or("it ends within its header")?;
    if length > LONGEST_HEADER {
        return Err(format!(
            "a header of {length} bytes: expected at most {LONGEST_HEADER}"
        ));
    }
    let text = rest.get(width..width + length);
    let text = text.ok_or("it ends within its header")?;
    let text = std::str::from_utf8(text).map_err(|_| "a header that is no text")?;
    Ok((text.trim_end(), 8 + width + length))
}

/// Type and shape of `{'descr': '<f2', 'fortran_order': False, 'shape': (5, 3), }`.
fn described(header: &str) -> Result<(String, Vec<usize>), &'static str> {
    let parts = || {
        let rest = header.strip_prefix("{'descr': '")?;
        let (kind, rest) = rest.split_once("', 'fortran_order': ")?;
        let (order, rest) = rest.split_once(", 'shape': (")?;
        let (sides, end) = rest.split_once(')')?;
        matches!(end, "}" | ", }").then_some((kind, order, sides))
    };
    let (kind, order, sides) = parts().ok_or("not what numpy.savez writes")?;
    if order != "False" {
        return Err("columns first: expected rows first");
    }
    let sides = sides.strip_suffix(',').unwrap_or(sides);
    let shape = if sides.is_empty() {
        Ok(vec![])
    } else {
        sides.split(',').map(|s| s.trim().parse()).collect()
    };
    let shape = shape.map_err(|_| "a side that is no number")?;
    Ok((kind.to_owned(), shape))
}

impl Array<'_> {
    fn width(&self) -> Option<usize> {
        Some(match self.kind.as_str() {
            "|u1" => 1,
            "<f2" => 2,
            "<f4" | "<i4" => 4,
            "<i8" => 8,
            _ => return None,
        })
    }

    /// Checks that the length of an array of numbers fits its shape.
    fn check_length(&self) -> Result<(), FileError> {
        let Some(width) = self.width() else {
            return Ok(());
        };
        let sides = self.shape.iter();
        let wanted = sides.fold(width as u128, |n, side| n.saturating_mul(*side as u128));
        if wanted == self.bytes.len() as u128 {
            return Ok(());
        }
        let shape = format!("{:?} with {} bytes", self.shape, self.bytes.len());
        Err(self.wrong("shape", shape, format!("{wanted} bytes of it")))
    }

    pub(super) fn wrong(
        &self,
        what: &str,
        value: impl ToString,
        expected: impl Into<String>,
    ) -> FileError {
        let field = format!("{} of {}", what, self.field);
        self.name.field(field, value, expected)
    }

    /// An error from the reader of its content.
    pub(super) fn refused(&self, error: impl ToString) -> FileError {
        self.name.part(self.field.clone(), error)
    }

    /// Checks the type.
    fn of(&self, kinds: &[&str]) -> Result<(), FileError> {
        if kinds.contains(&self.kind.as_str()) {
            return Ok(());
        }
        Err(self.wrong("type", &self.kind, kinds.join(" or ")))
    }

    /// Returns an error with the `expected` shape unless the shape is right.
    pub(super) fn shaped(&self, right: bool, expected: &str) -> Result<(), FileError> {
        if right {
            return Ok(());
        }
        Err(self.wrong("shape", format!("{:?}", self.shape), expected))
    }

    /// Whether it holds a Python object.
    pub(super) fn is_object(&self) -> bool {
        self.kind == "|O"
    }

    pub(super) fn pickle(&self) -> &[u8] {
        &self.bytes
    }

    pub(super) fn bytes(&self) -> Result<&[u8], FileError> {
        self.of(&["|u1"])?;
        Ok(&self.bytes)
    }

    /// The numbers of a finite 16-bit array.
    pub(super) fn halves(&self) -> Result<Vec<f32>, FileError> {
        self.of(&["<f2"])?;
        let (words, _) = self.bytes.as_chunks();
        self.finite(words.iter().map(|b| f16::from_le_bytes(*b).to_f32()))
    }

    /// The numbers of a finite 32-bit array.
    pub(super) fn floats(&self) -> Result<Vec<f32>, FileError> {
        self.of(&["<f4"])?;
        let (words, _) = self.bytes.as_chunks();
        self.finite(words.iter().map(|b| f32::from_le_bytes(*b)))
    }

    fn finite(&self, values: impl Iterator<Item = f32>) -> Result<Vec<f32>, FileError> {
        let values: Vec<f32> = values.collect();
        match values.iter().position(|v| !v.is_finite()) {
            None => Ok(values),
            Some(at) => {
                let what = format!("element {at}");
                Err(self.wrong(&what, values[at], "a finite number"))
            }
        }
    }

    pub(super) fn integers(&self) -> Result<Vec<i64>, FileError> {
        self.of(&["<i8", "<i4"])?;
        let wide = |b: &[u8; 8]| i64::from_le_bytes(*b);
        let narrow = |b: &[u8; 4]| i64::from(i32::from_le_bytes(*b));
        Ok(match self.kind.as_str() {
            "<i8" => self.bytes.as_chunks().0.iter().map(wide).collect(),
            _ => self.bytes.as_chunks().0.iter().map(narrow).collect(),
        })
    }
}
