//! A built model, loaded into the process.

use crate::{Error, Port, PortId, compile, store::Entry};
use std::{
    ffi::{c_char, c_int, c_void},
    sync::Arc,
};

pub(crate) type Sim = *mut c_void;

/// Functions of the shim, valid as long as `_library`.
#[derive(Debug)]
pub(crate) struct Loaded {
    pub(crate) new: unsafe extern "C" fn(c_int) -> Sim,
    pub(crate) delete: unsafe extern "C" fn(Sim),
    pub(crate) port: unsafe extern "C" fn(Sim, u32) -> *mut u8,
    pub(crate) eval: unsafe extern "C" fn(Sim) -> c_int,
    pub(crate) half: unsafe extern "C" fn(Sim, *mut u8, c_int) -> c_int,
    pub(crate) tick: unsafe extern "C" fn(Sim, *mut u8) -> c_int,
    pub(crate) cycle: unsafe extern "C" fn(Sim, *mut u8, *const u32, *mut u32) -> c_int,
    pub(crate) time: unsafe extern "C" fn(Sim) -> u64,
    pub(crate) error: unsafe extern "C" fn(Sim) -> *const c_char,
    pub(crate) output: unsafe extern "C" fn(Sim) -> *const c_char,
    pub(crate) clear_output: unsafe extern "C" fn(Sim),
    pub(crate) vcd_open: unsafe extern "C" fn(Sim, *const c_char) -> c_int,
    pub(crate) vcd_dump: unsafe extern "C" fn(Sim, u64) -> c_int,
    pub(crate) vcd_close: unsafe extern "C" fn(Sim) -> c_int,
    pub(crate) top: String,
    pub(crate) ports: Vec<Port>,
    pub(crate) id: u64,
    pub(crate) traced: bool,
    _library: libloading::Library,
}

/// A built and loaded model, a factory of instances.
#[derive(Debug, Clone)]
pub struct Library {
    pub(crate) loaded: Arc<Loaded>,
    cached: bool,
    key: String,
}

impl Library {
    pub(crate) fn load(
        entry: &Entry,
        key: String,
        top: &str,
        ports: Vec<Port>,
        traced: bool,
    ) -> Result<Self, Error> {
        let path = entry.folder.join(compile::LIBRARY);
        let fail = |e: libloading::Error| Error::Load {
            path: path.clone(),
            reason: e.to_string(),
        };
        // SAFETY: the file was made from this crate's shim and its content was just checked
        // against the hash its manifest keeps. Its initialisers are those of Verilator's
        // run-time code, which need nothing of the process.
        let library = unsafe { libloading::Library::new(&path) }.map_err(fail)?;
        // SAFETY: the shim defines each function with exactly the type of the field that it
        // is stored in, and the pointers are kept beside the library that holds the code.
        let loaded = unsafe {
            Loaded {
                new: *library.get(b"vs_new\0").map_err(fail)?,
                delete: *library.get(b"vs_delete\0").map_err(fail)?,
                port: *library.get(b"vs_port\0").map_err(fail)?,
                eval: *library.get(b"vs_eval\0").map_err(fail)?,
                half: *library.get(b"vs_half\0").map_err(fail)?,
                tick: *library.get(b"vs_tick\0").map_err(fail)?,
                cycle: *library.get(b"vs_cycle\0").map_err(fail)?,
                time: *library.get(b"vs_time\0").map_err(fail)?,
                error: *library.get(b"vs_error\0").map_err(fail)?,
                output: *library.get(b"vs_output\0").map_err(fail)?,
                clear_output: *library.get(b"vs_clear_output\0").map_err(fail)?,
                vcd_open: *library.get(b"vs_vcd_open\0").map_err(fail)?,
                vcd_dump: *library.get(b"vs_vcd_dump\0").map_err(fail)?,
                vcd_close: *library.get(b"vs_vcd_close\0").map_err(fail)?,
                top: top.to_string(),
                ports,
                id: u64::from_str_radix(key.get(..16).unwrap_or_default(), 16).unwrap_or(0),
                traced,
                _library: library,
            }
        };
        Ok(Library {
            loaded: Arc::new(loaded),
            cached: entry.cached,
            key,
        })
    }

    /// The ports of the top module, in the order of Verilator's header.
    pub fn ports(&self) -> &[Port] {
        &self.loaded.ports
    }

    /// The port of this name.
    ///
    /// # Errors
    /// [`Error::NoSuchPort`].
    pub fn port(&self, name: &str) -> Result<PortId, Error> {
        self.loaded.find(name)
    }

    /// Whether the model was cached.
    pub fn was_cached(&self) -> bool {
        self.cached
    }

    /// Hash of all inputs of the build.
    pub fn key(&self) -> &str {
        &self.key
    }
}

impl Loaded {
    pub(crate) fn find(&self, name: &str) -> Result<PortId, Error> {
        let index = self.ports.iter().position(|p| p.name == name);
        match index.and_then(|i| self.ports.get(i).map(|p| (i, p))) {
            Some((index, port)) => Ok(PortId {
                library: self.id,
                index: index as u32,
                bits: port.bits,
                words: port.words() as u32,
                dir: port.dir,
            }),
            None => Err(no_such_port(&self.top, name, &self.ports)),
        }
    }
}

pub(crate) fn no_such_port(top: &str, port: &str, found: &[Port]) -> Error {
    let names: Vec<String> = found.iter().map(Port::to_string).collect();
    Error::NoSuchPort {
        top: top.to_string(),
        port: port.to_string(),
        available: if names.is_empty() {
            "none".to_string()
        } else {
            names.join(", ")
        },
    }
}
