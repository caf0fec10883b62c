//! The subset of Python's pickle protocol that PyTorch writes, read as data:
//! nothing is called, classes other than a few are refused by name.
//!
//! Objects lie in an arena and refer to each other by number, so that neither
//! depth nor shared references of a hostile file cost more than its bytes.
//! Opcodes: Python's `pickletools`, protocols 2 to 5.

use std::collections::HashMap;

use super::legacy;
use super::value::{Arena, Array, Class, Kind, Place, Storage, TensorView, Value, class};

/// Reads the one object of a pickle.
///
/// # Errors
/// What is wrong, at which byte.
pub(super) fn read(bytes: &[u8]) -> Result<(Arena, Value), String> {
    let (machine, value) = run(bytes, true)?;
    Ok((machine.arena, value))
}

/// Reads the object of a pickle that a storage within another pickle is
/// described by, and the bytes that it takes.
///
/// # Errors
/// As [`read`]; or it holds such a storage itself, which PyTorch never writes.
pub(super) fn read_inner(bytes: &[u8]) -> Result<(Arena, Value, usize), String> {
    let (machine, value) = run(bytes, false)?;
    Ok((machine.arena, value, machine.at))
}

fn run(bytes: &[u8], loads: bool) -> Result<(Machine<'_>, Value), String> {
    let mut machine = Machine {
        bytes,
        at: 0,
        stack: vec![],
        marks: vec![],
        memo: HashMap::new(),
        copied: 0,
        loads,
        loaded: 0,
        arena: Arena::default(),
    };
    loop {
        let at = machine.at;
        match machine.step() {
            Ok(Some(value)) => return Ok((machine, value)),
            Ok(None) => {}
            Err(problem) => return Err(format!("pickle, byte {at}: {problem}")),
        }
    }
}

struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    stack: Vec<Value>,
    marks: Vec<usize>,
    memo: HashMap<u32, Value>,
    /// Bytes of arrays made from texts so far.
    copied: usize,
    /// Whether storages within it are read.
    loads: bool,
    /// Bytes of such storages so far.
    loaded: usize,
    arena: Arena,
}

/// The most axes of a tensor.
const MAX_AXES: usize = 8;
/// What is looked at of a call's arguments; more are none of PyTorch's.
const MAX_ARGUMENTS: usize = 12;

type Step<T> = Result<T, String>;

fn place<T>(list: &mut Vec<T>, item: T) -> usize {
    list.push(item);
    list.len() - 1
}

impl Machine<'_> {
    fn take(&mut self, count: usize) -> Step<&[u8]> {
        let end = self.at.checked_add(count);
        let taken = end.and_then(|end| self.bytes.get(self.at..end));
        self.at = end.unwrap_or(usize::MAX);
        taken.ok_or_else(|| "the file ends within a value".to_owned())
    }

    fn number<const N: usize>(&mut self) -> Step<[u8; N]> {
        let taken = self.take(N)?;
        taken
            .try_into()
            .map_err(|_| "the file ends within a value".to_owned())
    }

    fn line(&mut self) -> Step<String> {
        let rest = self.bytes.get(self.at..).unwrap_or_default();
        let end = rest.iter().position(|b| *b == b'\n');
        let end = end.ok_or("a name without its end")?;
        let text = self.take(end)?.to_vec();
        self.at += 1;
        String::from_utf8(text).map_err(|_| "a name that is no text".to_owned())
    }

    fn text(&mut self, length: usize) -> Step<()> {
        let text = self.take(length)?.to_vec();
        let text = String::from_utf8(text).map_err(|_| "a text that is no UTF-8")?;
        let text = place(&mut self.arena.texts, text);
        self.push(Value::Text(text))
    }

    fn blob(&mut self, length: usize) -> Step<()> {
        let bytes = self.take(length)?.to_vec();
        let bytes = place(&mut self.arena.bytes, bytes);
        self.push(Value::Bytes(bytes))
    }

    fn push(&mut self, value: Value) -> Step<()> {
        self.stack.push(value);
        Ok(())
    }

    fn pop(&mut self) -> Step<Value> {
        let floor = self.marks.last().copied().unwrap_or(0);
        if self.stack.len() <= floor {
            return Err("a value is missing".to_owned());
        }
        self.stack
            .pop()
            .ok_or_else(|| "a value is missing".to_owned())
    }

    fn since_mark(&mut self) -> Step<Vec<Value>> {
        let mark = self.marks.pop().ok_or("a mark is missing")?;
        Ok(self.stack.split_off(mark))
    }

    fn top(&self) -> Step<Value> {
        let top = self.stack.last().copied();
        top.ok_or_else(|| "a value is missing".to_owned())
    }

    fn tuple(&mut self, items: Vec<Value>) -> Step<()> {
        let tuple = place(&mut self.arena.lists, items);
        self.push(Value::Tuple(tuple))
    }

    fn last(&mut self, count: usize) -> Step<Vec<Value>> {
        let mut items = Vec::with_capacity(count);
        for _ in 0..count {
            items.push(self.pop()?);
        }
        items.reverse();
        Ok(items)
    }

    fn append(&mut self, items: Vec<Value>) -> Step<()> {
        match self.top()? {
            Value::List(list) => {
                self.arena.lists[list].extend(items);
                Ok(())
            }
            other => Err(format!("{} takes no items", other.kind())),
        }
    }

    fn set(&mut self, items: &[Value]) -> Step<()> {
        let Value::Dict(dict) = self.top()? else {
            return Err(format!("{} takes no keys", self.top()?.kind()));
        };
        if items.len() % 2 == 1 {
            return Err("a key without a value".to_owned());
        }
        let pairs = items.as_chunks::<2>().0.iter().map(|[k, v]| (*k, *v));
        self.arena.dicts[dict].extend(pairs);
        Ok(())
    }

    fn memo(&mut self, index: u32) -> Step<()> {
        let top = self.top()?;
        self.memo.insert(index, top);
        Ok(())
    }

    fn recall(&mut self, index: u32) -> Step<()> {
        let value = self.memo.get(&index).copied();
        let value = value.ok_or_else(|| format!("nothing was kept as {index}"))?;
        self.push(value)
    }

    /// Carries out one opcode; gives the object at the end.
    fn step(&mut self) -> Step<Option<Value>> {
        let [code] = self.number()?;
        match code {
            0x80 => {
                let [version] = self.number()?;
                if !(2..=5).contains(&version) {
                    return Err(format!("protocol {version}: expected 2 to 5"));
                }
            }
            // A frame's length says nothing that is needed.
            0x95 => drop(self.number::<8>()?),
            b'.' => return self.pop().map(Some),
            b'(' => self.marks.push(self.stack.len()),
            b'N' => self.push(Value::None)?,
            0x88 => self.push(Value::Bool(true))?,
            0x89 => self.push(Value::Bool(false))?,
            b'K' => {
                let [value] = self.number()?;
                self.push(Value::Int(value.into()))?;
            }
            b'M' => {
                let value = u16::from_le_bytes(self.number()?);
                self.push(Value::Int(value.into()))?;
            }
            b'J' => {
                let value = i32::from_le_bytes(self.number()?);
                self.push(Value::Int(value.into()))?;
            }
            0x8a => {
                let [length] = self.number()?;
                let bytes = self.take(length.into())?;
                if bytes.len() > 8 {
                    return Err("an integer of more than 64 bits".to_owned());
                }
                let fill = if bytes.last().is_some_and(|b| b >> 7 == 1) {
                    0xff
                } else {
                    0
                };
                let mut wide = [fill; 8];
                wide[..bytes.len()].copy_from_slice(bytes);
                self.push(Value::Int(i64::from_le_bytes(wide)))?;
            }
            b'G' => {
                let value = f64::from_be_bytes(self.number()?);
                self.push(Value::Float(value))?;
            }
            b'X' => {
                let length = u32::from_le_bytes(self.number()?);
                self.text(length as usize)?;
            }
            0x8c => {
                let [length] = self.number()?;
                self.text(length.into())?;
            }
            b'B' => {
                let length = u32::from_le_bytes(self.number()?);
                self.blob(length as usize)?;
            }
            b'C' => {
                let [length] = self.number()?;
                self.blob(length.into())?;
            }
            b')' => self.tuple(vec![])?,
            b't' => {
                let items = self.since_mark()?;
                self.tuple(items)?;
            }
            0x85..=0x87 => {
                let items = self.last(usize::from(code - 0x84))?;
                self.tuple(items)?;
            }
            b']' => {
                let list = place(&mut self.arena.lists, vec![]);
                self.push(Value::List(list))?;
            }
            b'a' => {
                let item = self.last(1)?;
                self.append(item)?;
            }
            b'e' => {
                let items = self.since_mark()?;
                self.append(items)?;
            }
            b'}' => {
                let dict = place(&mut self.arena.dicts, vec![]);
                self.push(Value::Dict(dict))?;
            }
            b's' => {
                let pair = self.last(2)?;
                self.set(&pair)?;
            }
            b'u' => {
                let items = self.since_mark()?;
                self.set(&items)?;
            }
            b'q' => {
                let [index] = self.number()?;
                self.memo(index.into())?;
            }
            b'r' => {
                let index = u32::from_le_bytes(self.number()?);
                self.memo(index)?;
            }
            0x94 => {
                let index = self.memo.len() as u32;
                self.memo(index)?;
            }
            b'h' => {
                let [index] = self.number()?;
                self.recall(index.into())?;
            }
            b'j' => {
                let index = u32::from_le_bytes(self.number()?);
                self.recall(index)?;
            }
            b'c' => {
                let (module, name) = (self.line()?, self.line()?);
                let class = class(&module, &name)?;
                self.push(Value::Class(class))?;
            }
            0x93 => {
                let names = self.last(2)?;
                let class = class(self.word(names[0])?, self.word(names[1])?)?;
                self.push(Value::Class(class))?;
            }
            b'Q' => {
                let id = self.pop()?;
                let storage = self.storage(id)?;
                self.push(storage)?;
            }
            b'R' => {
                let args = self.pop()?;
                let callee = self.pop()?;
                let value = self.call(callee, args)?;
                self.push(value)?;
            }
            b'b' => {
                let state = self.pop()?;
                self.build(state)?;
            }
            other => {
                return Err(format!(
                    "opcode {other:#04x} is not one that PyTorch writes"
                ));
            }
        }
        Ok(None)
    }

    fn word(&self, value: Value) -> Step<&str> {
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

    /// `("storage", class, key, location, count)`, and before PyTorch 1.6 what
    /// it is a view of: nothing.
    fn storage(&mut self, id: Value) -> Step<Value> {
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
            place: Place::Member(key),
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
            place: Place::Within(blob, from),
            count,
        };
        Ok(Value::Storage(place(&mut self.arena.storages, storage)))
    }

    fn call(&mut self, callee: Value, args: Value) -> Step<Value> {
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

    /// State of a numpy array or of a type; that of anything else is ignored,
    /// as it is that of a dictionary's own attributes.
    fn build(&mut self, state: Value) -> Step<()> {
        let Value::Array(at) = self.top()? else {
            return Ok(());
        };
        if self.arena.arrays[at].is_dtype {
            let order = self.items(state)?.get(1).copied();
            let order = order.ok_or("a type without its byte order")?;
            return match self.word(order)? {
                "<" | "|" | "=" => Ok(()),
                other => Err(format!(
                    "numbers in byte order `{other}`: expected little-endian"
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
