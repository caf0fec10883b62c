//! Objects of a PyTorch pickle, and the classes that it may name.

use potamoi_base::file_keys::told;

/// A value, or the index of one in the arena.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Value {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(usize),
    Bytes(usize),
    Class(Class),
    Tuple(usize),
    List(usize),
    Dict(usize),
    Storage(usize),
    Tensor(usize),
    Array(usize),
}

/// The classes that may be named. Calling one makes the value that it represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Class {
    OrderedDict,
    RebuildTensor,
    RebuildParameter,
    Storage(Kind),
    /// `numpy._core.multiarray._reconstruct`.
    Reconstruct,
    NdArray,
    Dtype,
    /// `numpy._core.multiarray.scalar`.
    Scalar,
    /// `_codecs.encode`.
    Encode,
    /// `torch.storage._load_from_bytes`.
    LoadStorage,
    Size,
    Device,
}

/// Type of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    F16,
    BF16,
    F32,
    F64,
    I16,
    I32,
    I64,
    U8,
    Bool,
}

impl Kind {
    pub(super) const fn bytes(self) -> usize {
        match self {
            Self::F16 | Self::BF16 | Self::I16 => 2,
            Self::F32 | Self::I32 => 4,
            Self::F64 | Self::I64 => 8,
            Self::U8 | Self::Bool => 1,
        }
    }

    /// Whether its numbers may be fractions, as weights are.
    pub(super) const fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::BF16 | Self::F32 | Self::F64)
    }

    /// Its name.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::F16 => "float16",
            Self::BF16 => "bfloat16",
            Self::F32 => "float32",
            Self::F64 => "float64",
            Self::I16 => "int16",
            Self::I32 => "int32",
            Self::I64 => "int64",
            Self::U8 => "uint8",
            Self::Bool => "bool",
        }
    }

    /// The kind for NumPy's type string without byte order.
    pub(super) fn of_numpy(text: &str) -> Option<Self> {
        Some(match text {
            "f2" => Self::F16,
            "f4" => Self::F32,
            "f8" => Self::F64,
            "i2" => Self::I16,
            "i4" => Self::I32,
            "i8" => Self::I64,
            "u1" => Self::U8,
            "b1" => Self::Bool,
            _ => return None,
        })
    }
}

/// A storage of numbers.
#[derive(Debug, Clone)]
pub(super) struct Storage {
    pub(super) kind: Kind,
    pub(super) place: StorageLocation,
    pub(super) count: usize,
}

/// Location of a storage's numbers.
#[derive(Debug, Clone, Copy)]
pub(super) enum StorageLocation {
    /// In a member: index of the text with its name below `data/`.
    Member(usize),
    /// Within the pickle: an array of bytes, and the first byte.
    Within(usize, usize),
}

/// A view of a storage.
#[derive(Debug, Clone)]
pub(super) struct TensorView {
    pub(super) storage: usize,
    pub(super) offset: usize,
    pub(super) shape: Vec<usize>,
    pub(super) strides: Vec<usize>,
}

/// A NumPy array or scalar, with its bytes within the pickle.
#[derive(Debug, Clone, Default)]
pub(super) struct Array {
    pub(super) shape: Vec<usize>,
    pub(super) kind: Option<Kind>,
    /// An array of bytes; `None` before its state is set.
    pub(super) bytes: Option<usize>,
    /// The object of an array of one object.
    pub(super) object: Option<Value>,
    /// Whether it is only a type object.
    pub(super) is_dtype: bool,
}

/// All objects of a pickle.
#[derive(Debug, Default)]
pub(super) struct Arena {
    pub(super) texts: Vec<String>,
    pub(super) bytes: Vec<Vec<u8>>,
    pub(super) lists: Vec<Vec<Value>>,
    pub(super) dicts: Vec<Vec<(Value, Value)>>,
    pub(super) storages: Vec<Storage>,
    pub(super) tensors: Vec<TensorView>,
    pub(super) arrays: Vec<Array>,
}

impl Value {
    /// Name of its kind, for messages.
    pub(super) const fn kind(self) -> &'static str {
        match self {
            Self::None => "nothing",
            Self::Bool(_) => "a truth value",
            Self::Int(_) => "an integer",
            Self::Float(_) => "a number",
            Self::Text(_) => "a text",
            Self::Bytes(_) => "bytes",
            Self::Class(_) => "a class",
            Self::Tuple(_) => "a tuple",
            Self::List(_) => "a list",
            Self::Dict(_) => "a dictionary",
            Self::Storage(_) => "a storage",
            Self::Tensor(_) => "a tensor",
            Self::Array(_) => "an array",
        }
    }
}

/// The class of a module, if it is a known one.
///
/// # Errors
/// Any other class, by name.
pub(super) fn class(module: &str, name: &str) -> Result<Class, String> {
    let storage = |kind| Ok(Class::Storage(kind));
    match (module, name) {
        ("collections", "OrderedDict") => Ok(Class::OrderedDict),
        ("torch._utils", "_rebuild_tensor_v2") => Ok(Class::RebuildTensor),
        ("torch._utils", "_rebuild_parameter") => Ok(Class::RebuildParameter),
        ("torch.storage", "_load_from_bytes") => Ok(Class::LoadStorage),
        ("torch", "HalfStorage") => storage(Kind::F16),
        ("torch", "BFloat16Storage") => storage(Kind::BF16),
        ("torch", "FloatStorage") => storage(Kind::F32),
        ("torch", "DoubleStorage") => storage(Kind::F64),
        ("torch", "ShortStorage") => storage(Kind::I16),
        ("torch", "IntStorage") => storage(Kind::I32),
        ("torch", "LongStorage") => storage(Kind::I64),
        ("torch", "ByteStorage") => storage(Kind::U8),
        ("torch", "BoolStorage") => storage(Kind::Bool),
        ("torch", "Size") => Ok(Class::Size),
        ("torch", "device") => Ok(Class::Device),
        ("numpy._core.multiarray" | "numpy.core.multiarray", "_reconstruct") => {
            Ok(Class::Reconstruct)
        }
        ("numpy._core.multiarray" | "numpy.core.multiarray", "scalar") => Ok(Class::Scalar),
        ("numpy", "ndarray") => Ok(Class::NdArray),
        ("numpy", "dtype") => Ok(Class::Dtype),
        ("_codecs", "encode") => Ok(Class::Encode),
        _ => Err(format!(
            "it names {}.{}: a model's file holds tensors, numbers and texts; \
             anything else is refused and never run",
            told(module),
            told(name)
        )),
    }
}
