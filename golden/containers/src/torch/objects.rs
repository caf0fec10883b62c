//! The objects that a pickle may build: PyTorch's storages and tensors, NumPy's arrays, and the
//! few other callables that are allowed.

use super::legacy;
use super::pickle::{Machine, Step, place};
use super::value::{Array, Class, Kind, Storage, StorageLocation, TensorView, Value};
use potamoi_base::file_keys::told;

/// Maximum number of axes of a tensor.
const MAX_AXES: usize = 8;
/// Maximum number of a call's arguments that are examined; PyTorch's calls have no more.
const MAX_ARGUMENTS: usize = 12;

impl Machine<'_> {
    pub(super) fn word(&self, value: Value) -> Step<&str> {
        match value {
            Value::Text(at) => Ok(&self.arena.texts[at]),
            other => Err(format!("{} where a name is expected", other.kind())),
        }
    }

    fn items(&self, value: Value) -> Step<&[Value]> {
        match value {
            Value::Tuple(at) | Value::List(at) => Ok(&self.arena.lists[at]),
            other => Err(format!(
                "{} where several values are expected",
                other.kind()
            )),
        }
    }

    fn sizes(&self, value: Value) -> Step<Vec<usize>> {
        let whole = |v: &Value| match v {
            Value::Int(n) => usize::try_from(*n).map_err(|_| format!("a size of {n}")),
            other => Err(format!("{} where a size is expected", other.kind())),
        };
        let items = self.items(value)?;
        if items.len() > MAX_AXES {
            return Err(format!("{} axes: expected at most {MAX_AXES}", items.len()));
        }
        items.iter().map(whole).collect()
    }

    /// `("storage", class, key, location, count)`, and before PyTorch 1.6 a view key, which must
    /// be none.
    pub(super) fn storage(&mut self, id: Value) -> Step<Value> {
        let ([tag, class, key, _, count] | [tag, class, key, _, count, Value::None]) =
            *self.items(id)?
        else {
            return Err("a storage that is not described as PyTorch does".to_owned());
        };
        let (Value::Class(Class::Storage(kind)), Value::Text(key), Value::Int(count)) =
            (class, key, count)
        else {
            return Err("a storage that is not described as PyTorch does".to_owned());
        };
        if self.word(tag)? != "storage" {
            return Err("something other than a storage beside the pickle".to_owned());
        }
        let count = usize::try_from(count).map_err(|_| format!("a storage of {count} numbers"))?;
        let storage = Storage {
            kind,
            place: StorageLocation::Member(key),
            count,
        };
        Ok(Value::Storage(place(&mut self.arena.storages, storage)))
    }

    /// A storage that was saved on its own, as bytes within this pickle.
    fn load(&mut self, blob: usize) -> Step<Value> {
        let bytes = &self.arena.bytes[blob];
        // One array of bytes may be named again and again.
        self.loaded += bytes.len();
        if self.loaded > self.bytes.len() {
            return Err("storages of more bytes than the pickle has".to_owned());
        }
        if !self.loads {
            return Err("storages within storages".to_owned());
        }
        let (kind, count, from) = legacy::storage(bytes)?;
        let storage = Storage {
            kind,
            place: StorageLocation::Within(blob, from),
            count,
        };
        Ok(Value::Storage(place(&mut self.arena.storages, storage)))
    }

    pub(super) fn call(&mut self, callee: Value, args: Value) -> Step<Value> {
        let Value::Class(class) = callee else {
            return Err(format!("{} is called", callee.kind()));
        };
        let args = self.items(args)?;
        let args = args[..args.len().min(MAX_ARGUMENTS)].to_vec();
        match (class, &args[..]) {
            (Class::OrderedDict, []) => Ok(Value::Dict(place(&mut self.arena.dicts, vec![]))),
            (
                Class::RebuildTensor,
                [
                    Value::Storage(storage),
                    Value::Int(offset),
                    shape,
                    strides,
                    ..,
                ],
            ) => {
                let view = TensorView {
                    storage: *storage,
                    offset: usize::try_from(*offset).map_err(|_| format!("offset {offset}"))?,
                    shape: self.sizes(*shape)?,
                    strides: self.sizes(*strides)?,
                };
                if view.shape.len() != view.strides.len() {
                    return Err("a tensor's shape and strides do not fit".to_owned());
                }
                Ok(Value::Tensor(place(&mut self.arena.tensors, view)))
            }
            (Class::RebuildParameter, [tensor @ Value::Tensor(_), ..]) => Ok(*tensor),
            (Class::Reconstruct, _) => Ok(Value::Array(place(
                &mut self.arena.arrays,
                Array::default(),
            ))),
            (Class::Dtype, [name, ..]) => {
                let kind = Kind::of_numpy(self.word(*name)?);
                let array = Array {
                    kind,
                    is_dtype: true,
                    ..Array::default()
                };
                Ok(Value::Array(place(&mut self.arena.arrays, array)))
            }
            (Class::Scalar, [Value::Array(dtype), Value::Bytes(bytes)]) => {
                let array = Array {
                    kind: self.arena.arrays[*dtype].kind,
                    bytes: Some(*bytes),
                    ..Array::default()
                };
                Ok(Value::Array(place(&mut self.arena.arrays, array)))
            }
            // Text whose characters are the bytes.
            (Class::Encode, [text, _]) => {
                let text = self.word(*text)?;
                let byte = |c: char| u8::try_from(u32::from(c));
                let bytes: Result<Vec<u8>, _> = text.chars().map(byte).collect();
                let bytes = bytes.map_err(|_| "a byte above 255")?;
                // One text may be named again and again.
                self.copied += bytes.len();
                if self.copied > self.bytes.len() {
                    return Err("arrays of more bytes than the pickle has".to_owned());
                }
                Ok(Value::Bytes(place(&mut self.arena.bytes, bytes)))
            }
            (Class::LoadStorage, [Value::Bytes(blob)]) => self.load(*blob),
            (Class::Size, [sizes]) => Ok(*sizes),
            (Class::Device, _) => Ok(Value::None),
            _ => Err(format!(
                "{class:?} with arguments that PyTorch does not give"
            )),
        }
    }

    /// Sets the state of a NumPy array or type; the state of anything else, such as a dictionary's
    /// attributes, is ignored.
    pub(super) fn build(&mut self, state: Value) -> Step<()> {
        let Value::Array(at) = self.top()? else {
            return Ok(());
        };
        if self.arena.arrays[at].is_dtype {
            let order = self.items(state)?.get(1).copied();
            let order = order.ok_or("a type without its byte order")?;
            return match self.word(order)? {
                "<" | "|" | "=" => Ok(()),
                other => Err(format!(
                    "numbers in byte order `{}`: expected little-endian",
                    told(other)
                )),
            };
        }
        let [_, shape, Value::Array(dtype), Value::Bool(fortran), content] = *self.items(state)?
        else {
            return Err("an array that is not described as NumPy does".to_owned());
        };
        let Value::Bytes(bytes) = content else {
            // An array of objects has a list here.
            self.arena.arrays[at].object = match *self.items(content)? {
                [object] => Some(object),
                _ => None,
            };
            return Ok(());
        };
        if fortran {
            return Err("an array in column-major order".to_owned());
        }
        let (shape, kind) = (self.sizes(shape)?, self.arena.arrays[dtype].kind);
        let array = &mut self.arena.arrays[at];
        (array.shape, array.kind, array.bytes) = (shape, kind, Some(bytes));
        Ok(())
    }
}
