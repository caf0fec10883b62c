//! The buffers of a glTF file: the chunk of a `.glb`, base64 data, and files of the folder.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use super::super::error::{FileError, Origin};
use super::super::reader::{LARGEST, limited};
use super::document::{Accessor, Document};
use potamoi_base::file_keys::told;

/// The longest path of a buffer in bytes that file systems accept.
const LONGEST: usize = 4095;

/// Buffers that were asked for.
pub(super) struct Buffers<'a> {
    document: &'a Document,
    binary: Option<&'a [u8]>,
    folder: &'a Path,
    name: Origin<'a>,
    read: BTreeMap<usize, Cow<'a, [u8]>>,
    /// Keys that no reader took, of the buffers, views and accessors that were read.
    pub(super) rest: Vec<String>,
}

/// The elements of an accessor, all within their buffer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Elements {
    buffer: usize,
    start: usize,
    stride: usize,
    size: usize,
}

impl<'a> Buffers<'a> {
    pub(super) fn new(
        document: &'a Document,
        binary: Option<&'a [u8]>,
        folder: &'a Path,
        name: Origin<'a>,
    ) -> Self {
        Self {
            document,
            binary,
            folder,
            name,
            read: BTreeMap::new(),
            rest: vec![],
        }
    }

    /// Bytes of all buffers outside of the file that were read.
    pub(super) fn bytes_beside(&self) -> u64 {
        let files = self.read.iter().filter(|(index, _)| {
            let uri = self
                .document
                .buffers
                .get(**index)
                .and_then(|own| own.uri.as_deref());
            uri.is_some_and(|uri| !uri.starts_with("data:"))
        });
        files.map(|(_, bytes)| bytes.len() as u64).sum()
    }

    /// The whole buffer view.
    pub(super) fn view(&mut self, index: usize, place: &str) -> Result<&[u8], FileError> {
        let (buffer, start, length) = self.bounds(index, place)?;
        Ok(&self.read[&buffer][start..start + length])
    }

    /// The buffer of a view, and its start and length in it; the buffer is read.
    fn bounds(&mut self, index: usize, place: &str) -> Result<(usize, usize, usize), FileError> {
        let views = &self.document.views;
        let Some(view) = views.get(index) else {
            let expected = format!("below {}, the number of buffer views", views.len());
            return Err(self
                .name
                .field(format!("{place}.bufferView"), index, expected));
        };
        self.rest.extend(view.rest.iter().cloned());
        let length = self.buffer(view.buffer, index)?;
        let end = view.offset.checked_add(view.length);
        if end.is_none_or(|end| end > length) {
            let value = format!("{} from {} on", view.length, view.offset);
            let expected = format!("within the {length} bytes of buffers[{}]", view.buffer);
            let field = format!("bufferViews[{index}].byteLength");
            return Err(self.name.field(field, value, expected));
        }
        Ok((view.buffer, view.offset, view.length))
    }

    /// Reads a buffer, if that is not done, and returns its length.
    fn buffer(&mut self, index: usize, view: usize) -> Result<usize, FileError> {
        let Some(own) = self.document.buffers.get(index) else {
            let all = self.document.buffers.len();
            let field = format!("bufferViews[{view}].buffer");
            let expected = format!("below {all}, the number of buffers");
            return Err(self.name.field(field, index, expected));
        };
        if !self.read.contains_key(&index) {
            self.rest.extend(own.rest.iter().cloned());
            let bytes = match &own.uri {
                Some(uri) => Cow::Owned(self.fetched(uri, index)?),
                None => match self.binary.filter(|_| index == 0) {
                    Some(binary) => Cow::Borrowed(binary),
                    None => {
                        let expected =
                            "a file or base64 data: only the first of a .glb is in the file";
                        let field = format!("buffers[{index}].uri");
                        return Err(self.name.field(field, "missing", expected));
                    }
                },
            };
            if bytes.len() < own.length {
                let field = format!("bytes of buffers[{index}]");
                let expected = format!("at least its byteLength, {}", own.length);
                return Err(self.name.field(field, bytes.len(), expected));
            }
            self.read.insert(index, bytes);
        }
        Ok(own.length)
    }

    fn fetched(&self, uri: &str, index: usize) -> Result<Vec<u8>, FileError> {
        let field = format!("buffers[{index}].uri");
        if let Some(data) = uri.strip_prefix("data:") {
            let encoded = data.split_once(";base64,").map(|(_, text)| text);
            let bytes = encoded.and_then(|text| STANDARD.decode(text).ok());
            let expected = "base64 data, as in data:application/octet-stream;base64,AAAA";
            return bytes
                .ok_or_else(|| self.name.field(field, format!("`{}`", told(uri)), expected));
        }
        let path = beside(uri).ok_or_else(|| {
            let expected = "the path of a file in the folder or below it, or base64 data";
            self.name.field(field, format!("`{}`", told(uri)), expected)
        })?;
        limited(&self.folder.join(path), LARGEST)
    }

    /// The elements of an accessor of `components` components each, of `width` bytes.
    pub(super) fn elements(
        &mut self,
        accessor: &Accessor,
        index: usize,
        size: usize,
    ) -> Result<Elements, FileError> {
        let place = format!("accessors[{index}]");
        self.rest.extend(accessor.rest.iter().cloned());
        let Some(view) = accessor.view else {
            let expected = "the buffer view of its values";
            return Err(self
                .name
                .field(format!("{place}.bufferView"), "missing", expected));
        };
        let (buffer, start, length) = self.bounds(view, &place)?;
        let stride = self.document.views[view].stride.unwrap_or(size);
        if stride < size {
            let field = format!("bufferViews[{view}].byteStride");
            let expected = format!("at least {size}, the bytes of an element");
            return Err(self.name.field(field, stride, expected));
        }
        let last = accessor.count.saturating_sub(1).checked_mul(stride);
        let end = last.and_then(|last| last.checked_add(accessor.offset)?.checked_add(size));
        if accessor.count == 0 || end.is_none_or(|end| end > length) {
            let value = format!("{} elements of {size} bytes", accessor.count);
            let expected = format!("1 or more within the {length} bytes of bufferViews[{view}]");
            return Err(self.name.field(format!("{place}.count"), value, expected));
        }
        Ok(Elements {
            buffer,
            start: start + accessor.offset,
            stride,
            size,
        })
    }

    /// The bytes of an element.
    pub(super) fn element(&self, own: &Elements, index: usize) -> &[u8] {
        &self.read[&own.buffer][own.start + index * own.stride..][..own.size]
    }
}

/// The path that a URI names in or below the folder.
fn beside(uri: &str) -> Option<PathBuf> {
    let text = decoded(uri)?;
    let path = Path::new(&text);
    let is_inside = path
        .components()
        .all(|own| matches!(own, Component::Normal(_) | Component::CurDir));
    let is_scheme = text.split('/').next()?.contains(':');
    let is_good = is_inside && !is_scheme && !text.contains(['\\', '\0']);
    (is_good && !text.is_empty() && text.len() <= LONGEST).then(|| path.to_owned())
}

/// A URI with its `%20` and the like decoded.
fn decoded(uri: &str) -> Option<String> {
    let mut bytes = vec![];
    let mut rest = uri.bytes();
    while let Some(byte) = rest.next() {
        match byte {
            b'%' => {
                let mut digit = || char::from(rest.next()?).to_digit(16);
                let code = digit()? * 16 + digit()?;
                bytes.push(u8::try_from(code).ok()?);
            }
            other => bytes.push(other),
        }
    }
    String::from_utf8(bytes).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_in_the_folder() {
        for good in ["a.bin", "data/a%20b.bin", "a..b"] {
            assert!(beside(good).is_some(), "{good}");
        }
        assert_eq!(beside("a%20b.bin"), Some(PathBuf::from("a b.bin")));
        for bad in [
            "",
            "..",
            "../a",
            "a/../../b",
            "/etc/passwd",
            "%2e%2e/a",
            "https://a/b",
            "file:a",
            "a%2",
            "a%zz",
            "c\\d",
            "%00",
        ] {
            assert_eq!(beside(bad), None, "{bad}");
        }
    }
}
