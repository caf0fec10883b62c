//! The rows of a PLY file's elements.

use std::io::{BufRead, Read as _};

use ply_rs_bw::ply::{ElementDef, Encoding, PropertyType, ScalarType};

use super::header::{Header, scalar_bytes};

/// Reads the rows of elements one after another.
pub struct Rows<R> {
    reader: R,
    encoding: Encoding,
    line_end: u8,
    buffer: Vec<u8>,
    /// The list kept from the last row.
    items: Vec<f64>,
}

/// Storage layout of an element's row.
pub struct Layout {
    properties: Vec<PropertyType>,
    /// Bytes of a binary row, if it has only scalars.
    stride: Option<usize>,
    /// Whether all values are 32-bit floats, the most common case.
    floats: bool,
    /// The property whose list is kept.
    kept: Option<usize>,
}

impl Layout {
    /// The layout of an element of a header.
    pub fn of(element: &ElementDef) -> Self {
        let of = element.properties.values();
        let properties: Vec<_> = of.map(|own| own.data_type.clone()).collect();
        let widths = properties.iter().map(|own| match own {
            PropertyType::Scalar(kind) => Some(scalar_bytes(kind) as usize),
            PropertyType::List(..) => None,
        });
        let float = |own: &PropertyType| *own == PropertyType::Scalar(ScalarType::Float);
        Self {
            stride: widths.sum(),
            floats: properties.iter().all(float),
            properties,
            kept: None,
        }
    }

    /// Keeps the list of property `column` for [`Rows::items`].
    #[must_use]
    pub fn keeping(self, column: usize) -> Self {
        let kept = Some(column);
        Self { kept, ..self }
    }
}

/// Where the numbers of a binary row lie, if it has no list.
#[derive(Debug, Clone)]
pub struct FixedRow {
    /// Bytes of a row.
    pub stride: usize,
    /// First byte and type of each property.
    places: Vec<(usize, ScalarType)>,
    swap: bool,
}

impl FixedRow {
    /// The number in a column, in the order of the header; NaN if there is none.
    #[must_use]
    #[inline]
    pub fn value(&self, row: &[u8], column: usize) -> f64 {
        let Some((at, kind)) = self.places.get(column) else {
            return f64::NAN;
        };
        let own = &row[*at..];
        match (kind, own.first_chunk()) {
            (ScalarType::Float, Some(word)) if !self.swap => f64::from(f32::from_le_bytes(*word)),
            _ => number(kind, &own[..scalar_bytes(kind) as usize], self.swap),
        }
    }
}

impl<R: BufRead> Rows<R> {
    /// Where the numbers of an element's rows lie; `None` in text, and with lists.
    #[must_use]
    pub fn fixed(&self, layout: &Layout) -> Option<FixedRow> {
        let swap = match self.encoding {
            Encoding::Ascii => return None,
            Encoding::BinaryLittleEndian => false,
            Encoding::BinaryBigEndian => true,
        };
        let mut stride = 0;
        let places = layout.properties.iter().map(|property| match property {
            PropertyType::Scalar(kind) => {
                let at = stride;
                stride += scalar_bytes(kind) as usize;
                Some((at, kind.clone()))
            }
            PropertyType::List(..) => None,
        });
        let places = places.collect::<Option<Vec<_>>>()?;
        Some(FixedRow {
            stride,
            places,
            swap,
        })
    }

    /// Reads rows of `stride` bytes into `bytes`, `count` of them or as many as the file has. The error
    /// says what is wrong.
    pub fn read_many(
        &mut self,
        stride: usize,
        count: usize,
        bytes: &mut Vec<u8>,
    ) -> Result<(), String> {
        bytes.resize(stride * count, 0);
        let mut found = 0;
        while found < bytes.len() {
            match self.reader.read(&mut bytes[found..]) {
                Ok(0) => break,
                Ok(read) => found += read,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => return Err(ended(error)),
            }
        }
        bytes.truncate(found / stride * stride);
        Ok(())
    }

    /// A reader of rows. `reader` must be positioned after the header.
    pub fn new(reader: R, header: &Header) -> Self {
        Self {
            reader,
            encoding: header.ply.encoding,
            line_end: header.line_end,
            buffer: vec![],
            items: vec![],
        }
    }

    /// Numbers of the list that was kept from the last row.
    #[must_use]
    pub fn items(&self) -> &[f64] {
        &self.items
    }

    /// Reads a row's values in the order of the header; lists yield NaN. The error says what is
    /// wrong.
    pub fn read(&mut self, layout: &Layout, values: &mut Vec<f64>) -> Result<(), String> {
        values.clear();
        self.items.clear();
        let swap = match self.encoding {
            Encoding::Ascii => return self.read_text(layout, values),
            Encoding::BinaryLittleEndian => false,
            Encoding::BinaryBigEndian => true,
        };
        if let Some(stride) = layout.stride {
            self.buffer.resize(stride, 0);
            self.reader.read_exact(&mut self.buffer).map_err(ended)?;
            if layout.floats && !swap {
                let (words, _) = self.buffer.as_chunks();
                values.extend(words.iter().map(|own| f64::from(f32::from_le_bytes(*own))));
                return Ok(());
            }
            let mut rest = self.buffer.as_slice();
            for property in &layout.properties {
                if let PropertyType::Scalar(kind) = property {
                    let (own, others) = rest.split_at(scalar_bytes(kind) as usize);
                    values.push(number(kind, own, swap));
                    rest = others;
                }
            }
            return Ok(());
        }
        for (column, property) in layout.properties.iter().enumerate() {
            match property {
                PropertyType::Scalar(kind) => values.push(self.number(kind, swap)?),
                PropertyType::List(length, item) if layout.kept == Some(column) => {
                    let length = self.number(length, swap)?;
                    // Each is pushed once it is there: a wrong length takes no memory.
                    for _ in 0..length.max(0.0) as u64 {
                        let item = self.number(item, swap)?;
                        self.items.push(item);
                    }
                    values.push(f64::NAN);
                }
                PropertyType::List(length, item) => {
                    let length = self.number(length, swap)?;
                    let bytes = length.max(0.0) as u64 * scalar_bytes(item) as u64;
                    self.skip(bytes)?;
                    values.push(f64::NAN);
                }
            }
        }
        Ok(())
    }

    fn number(&mut self, kind: &ScalarType, swap: bool) -> Result<f64, String> {
        let mut word = [0; 8];
        let own = &mut word[..scalar_bytes(kind) as usize];
        self.reader.read_exact(own).map_err(ended)?;
        Ok(number(kind, own, swap))
    }

    fn skip(&mut self, bytes: u64) -> Result<(), String> {
        let skipped = std::io::copy(&mut self.reader.by_ref().take(bytes), &mut std::io::sink());
        match skipped.map_err(ended)? == bytes {
            true => Ok(()),
            false => Err(ENDS_WITHIN.to_owned()),
        }
    }

    fn read_text(&mut self, layout: &Layout, values: &mut Vec<f64>) -> Result<(), String> {
        self.buffer.clear();
        let read = self.reader.read_until(self.line_end, &mut self.buffer);
        if read.map_err(ended)? == 0 {
            return Err("the file ends before it".to_owned());
        }
        let line = String::from_utf8_lossy(&self.buffer);
        let mut words = line.split_whitespace().enumerate();
        let mut next = |is_right: fn(f64) -> bool, expected: &str| match words.next() {
            None => Err(format!("its line ends early: expected {expected}")),
            Some((at, word)) => {
                let value = word.parse::<f64>().ok().filter(|own| is_right(*own));
                let place = at + 1;
                value.ok_or_else(|| {
                    format!(
                        "value {place} of its line is `{}`: expected {expected}",
                        shown(word)
                    )
                })
            }
        };
        for (column, property) in layout.properties.iter().enumerate() {
            match property {
                PropertyType::Scalar(_) => values.push(next(|_| true, "a number")?),
                PropertyType::List(..) => {
                    let is_count = |own: f64| own >= 0.0 && own.fract() == 0.0;
                    let length = next(is_count, "the count of a list, from 0")?;
                    for _ in 0..length as u64 {
                        let item = next(|_| true, "a number of a list")?;
                        if layout.kept == Some(column) {
                            self.items.push(item);
                        }
                    }
                    values.push(f64::NAN);
                }
            }
        }
        match words.next() {
            None => Ok(()),
            Some((at, word)) => Err(format!(
                "value {} of its line is `{}`: expected the line to end before it",
                at + 1,
                shown(word)
            )),
        }
    }

    /// Number of bytes after the last row; in text files only those that are not blank.
    pub fn rest(mut self) -> std::io::Result<u64> {
        let mut left = 0;
        loop {
            let bytes = self.reader.fill_buf()?;
            if bytes.is_empty() {
                return Ok(left);
            }
            left += match self.encoding {
                Encoding::Ascii => bytes.iter().filter(|b| !b.is_ascii_whitespace()).count(),
                _ => bytes.len(),
            } as u64;
            let all = bytes.len();
            self.reader.consume(all);
        }
    }
}

/// A word of a line, shortly.
fn shown(word: &str) -> String {
    potamoi_base::file_keys::told(word)
        .escape_debug()
        .to_string()
}

fn ended(error: std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => ENDS_WITHIN.to_owned(),
        _ => error.to_string(),
    }
}

/// What is said of a row that the file ends within.
pub const ENDS_WITHIN: &str = "the file ends within it";

/// Decodes a number; `swap` selects big-endian.
fn number(kind: &ScalarType, bytes: &[u8], swap: bool) -> f64 {
    let mut word = [0; 8];
    let own = &mut word[..bytes.len()];
    own.copy_from_slice(bytes);
    if swap {
        own.reverse();
    }
    let bits = u64::from_le_bytes(word);
    match kind {
        ScalarType::Char => f64::from(bits as u8 as i8),
        ScalarType::UChar => f64::from(bits as u8),
        ScalarType::Short => f64::from(bits as u16 as i16),
        ScalarType::UShort => f64::from(bits as u16),
        ScalarType::Int => f64::from(bits as u32 as i32),
        ScalarType::UInt => f64::from(bits as u32),
        ScalarType::Float => f64::from(f32::from_bits(bits as u32)),
        ScalarType::Double => f64::from_bits(bits),
    }
}
