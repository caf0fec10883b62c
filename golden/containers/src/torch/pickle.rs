//! The subset of Python's pickle protocol that PyTorch writes, read as data: nothing is called,
//! and all classes except a few are refused by name.
//!
//! Objects lie in an arena and refer to each other by number, so that neither depth nor shared
//! references of a hostile file cost more than its bytes. Opcodes: Python's `pickletools`,
//! protocols 2 to 5.

use std::collections::HashMap;

use super::value::{Arena, Value, class};

/// Reads the only object of a pickle.
///
/// # Errors
/// The problem, with its byte offset.
pub(super) fn read(bytes: &[u8]) -> Result<(Arena, Value), String> {
    let (machine, value) = run(bytes, true)?;
    Ok((machine.arena, value))
}

/// Reads the pickle that describes a storage within another pickle, and returns its length as
/// well.
///
/// # Errors
/// Those of [`read`], or it holds such a storage itself, which PyTorch never writes.
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

pub(super) struct Machine<'a> {
    pub(super) bytes: &'a [u8],
    at: usize,
    stack: Vec<Value>,
    marks: Vec<usize>,
    memo: HashMap<u32, Value>,
    /// Bytes of arrays made from texts so far.
    pub(super) copied: usize,
    /// Whether storages within the pickle are read.
    pub(super) loads: bool,
    /// Bytes of storages within the pickle so far.
    pub(super) loaded: usize,
    pub(super) arena: Arena,
}

pub(super) type Step<T> = Result<T, String>;

pub(super) fn place<T>(list: &mut Vec<T>, item: T) -> usize {
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

    pub(super) fn top(&self) -> Step<Value> {
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

    /// Executes one opcode; returns the object at the end.
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
            _ => {
                let is_known = self.constant(code)?
                    || self.collection(code)?
                    || self.memory(code)?
                    || self.object(code)?;
                if !is_known {
                    return Err(format!("opcode {code:#04x} is not one that PyTorch writes"));
                }
            }
        }
        Ok(None)
    }

    /// Opcodes of values in the stream; returns whether `code` is one.
    fn constant(&mut self, code: u8) -> Step<bool> {
        match code {
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
                let value = integer(self.take(length.into())?)?;
                self.push(Value::Int(value))?;
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
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Opcodes of tuples, lists and dictionaries; returns whether `code` is one.
    fn collection(&mut self, code: u8) -> Step<bool> {
        match code {
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
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Opcodes that store and recall values; returns whether `code` is one.
    fn memory(&mut self, code: u8) -> Step<bool> {
        match code {
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
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Opcodes of classes, storages and objects made from them; returns whether `code` is one.
    fn object(&mut self, code: u8) -> Step<bool> {
        match code {
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
            _ => return Ok(false),
        }
        Ok(true)
    }
}

/// A signed little-endian integer of at most 64 bits.
fn integer(bytes: &[u8]) -> Step<i64> {
    if bytes.len() > 8 {
        return Err("an integer of more than 64 bits".to_owned());
    }
    let is_negative = bytes.last().is_some_and(|b| b >> 7 == 1);
    let mut wide = [if is_negative { 0xff } else { 0 }; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    Ok(i64::from_le_bytes(wide))
}
