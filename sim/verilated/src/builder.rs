//! Description and build of a model.

use crate::{
    Direction, Error, Library, Port, Toolchain, cache,
    compile::{self, Spec},
};
use std::{collections::BTreeMap, path::PathBuf};

/// Whether a model can write waveforms.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Trace {
    /// No waveforms; the fastest.
    #[default]
    Off,
    /// Value change dumps (IEEE 1364-2005, section 18).
    Vcd,
}

/// Optimisation level of the C++ compiler.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Opt {
    /// `-O0`: builds fastest, runs about eight times slower.
    O0,
    /// `-O1`: builds soonest of those that run fast. The vector unit of 24 lanes takes a third more time a
    /// clock than with `-O3`.
    #[default]
    O1,
    /// `-O2`.
    O2,
    /// `-O3`.
    O3,
}

impl Opt {
    fn flag(self) -> &'static str {
        match self {
            Opt::O0 => "-O0",
            Opt::O1 => "-O1",
            Opt::O2 => "-O2",
            Opt::O3 => "-O3",
        }
    }
}

/// Handling of Verilator's warnings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Warnings {
    /// All warnings are on (`-Wall`), and each fails the build.
    #[default]
    Deny,
    /// Warnings do not fail the build; for third-party Verilog.
    Allow,
}

/// Description of a model: top module, Verilog sources, and expected ports.
#[derive(Debug, Clone)]
pub struct ModelBuilder {
    top: String,
    sources: Vec<(String, String)>,
    ports: Vec<Port>,
    trace: Trace,
    optimise: Opt,
    warnings: Warnings,
    cache: Option<PathBuf>,
    keep_objects: bool,
}

impl ModelBuilder {
    /// A model of the module `top`.
    pub fn new(top: impl Into<String>) -> Self {
        ModelBuilder {
            top: top.into(),
            sources: Vec::new(),
            ports: Vec::new(),
            trace: Trace::default(),
            optimise: Opt::default(),
            warnings: Warnings::default(),
            cache: None,
            keep_objects: false,
        }
    }

    /// Adds a source file. Names ending in `.vh` or `.svh` are for `` `include `` only.
    ///
    /// A missing newline at the end is added. The Verilog is trusted as the Rust program is: Verilator's `$c` and `` `systemc_ ``
    /// texts are C++ that becomes part of the process.
    #[must_use]
    pub fn source(mut self, file_name: impl Into<String>, text: impl Into<String>) -> Self {
        let mut text = text.into();
        if !text.ends_with('\n') {
            text.push('\n');
        }
        self.sources.push((file_name.into(), text));
        self
    }

    /// Declares a port of the top module, with its width in bits and its direction; the build
    /// checks it.
    ///
    /// Ports that are not declared can be used as well.
    #[must_use]
    pub fn port(mut self, name: impl Into<String>, bits: u32, dir: Direction) -> Self {
        self.ports.push(Port {
            name: name.into(),
            bits,
            dir,
        });
        self
    }

    /// Sets whether the model can write waveforms; default [`Trace::Off`].
    #[must_use]
    pub fn trace(mut self, trace: Trace) -> Self {
        self.trace = trace;
        self
    }

    /// Sets the optimisation level; default [`Opt::O1`].
    #[must_use]
    pub fn optimise(mut self, optimise: Opt) -> Self {
        self.optimise = optimise;
        self
    }

    /// Sets the handling of warnings; default [`Warnings::Deny`].
    #[must_use]
    pub fn warnings(mut self, warnings: Warnings) -> Self {
        self.warnings = warnings;
        self
    }

    /// Sets the cache folder of built models; default `models` in [`crate::cache::root`].
    ///
    /// The folder is created if missing. Models are loaded from it as code: a folder that belongs
    /// to or is writable by other users is refused.
    #[must_use]
    pub fn cache_dir(mut self, path: impl Into<PathBuf>) -> Self {
        self.cache = Some(path.into());
        self
    }

    pub(crate) fn keep_objects(mut self) -> Self {
        self.keep_objects = true;
        self
    }

    pub(crate) fn is_traced(&self) -> bool {
        self.trace == Trace::Vcd
    }

    pub(crate) fn cache_folder(&self) -> Result<PathBuf, Error> {
        match &self.cache {
            Some(path) => cache::claim(path),
            None => cache::folder(cache::MODELS),
        }
    }

    pub(crate) fn optimise_flag(&self) -> &'static str {
        self.optimise.flag()
    }

    /// Builds and loads the model, or loads it from the cache if its content is unchanged.
    ///
    /// Many threads and processes may build the same model at once. A cached model with damaged
    /// files is rebuilt.
    ///
    /// # Errors
    /// [`Error::Tool`] with Verilator's message for Verilog that it refuses, [`Error::NoSuchPort`]
    /// and [`Error::PortMismatch`] for ports that differ from their declaration, [`Error::BadName`]
    /// and [`Error::NoSource`] for a description that cannot be built, [`Error::Broken`] for broken
    /// tools, [`Error::Untrusted`] for a cache that others can write, and [`Error::Io`].
    pub fn build(&self, tools: &Toolchain) -> Result<Library, Error> {
        let (entry, ports) = self.entry(tools)?;
        let id = self.spec()?.key(tools).hex();
        Library::load(&entry, id, &self.top, ports, self.is_traced())
    }

    pub(crate) fn entry(
        &self,
        tools: &Toolchain,
    ) -> Result<(crate::store::Entry, Vec<Port>), Error> {
        let entry = compile::model(&self.cache_folder()?, tools, &self.spec()?)?;
        let ports: Vec<Port> = entry
            .notes
            .iter()
            .filter_map(|n| compile::parse_note(n))
            .collect();
        self.check_ports(&ports)?;
        Ok((entry, ports))
    }

    fn spec(&self) -> Result<Spec, Error> {
        check_identifier("module", &self.top)?;
        if self.sources.is_empty() {
            return Err(Error::NoSource {
                top: self.top.clone(),
            });
        }
        let mut seen = BTreeMap::new();
        for (name, _) in &self.sources {
            check_file(name)?;
            if seen.insert(name, ()).is_some() {
                return Err(Error::BadName {
                    what: "source file",
                    name: name.clone(),
                    expected: "each source file needs a name of its own",
                });
            }
        }
        Ok(Spec {
            top: self.top.clone(),
            sources: self.sources.clone(),
            vcd: self.is_traced(),
            optimise: self.optimise.flag(),
            deny_warnings: self.warnings == Warnings::Deny,
            keep_objects: self.keep_objects,
        })
    }

    fn check_ports(&self, found: &[Port]) -> Result<(), Error> {
        for stated in &self.ports {
            let Some(port) = found.iter().find(|p| p.name == stated.name) else {
                return Err(crate::library::no_such_port(&self.top, &stated.name, found));
            };
            if port != stated {
                return Err(Error::PortMismatch {
                    top: self.top.clone(),
                    port: stated.name.clone(),
                    declared: stated.to_string(),
                    found: port.to_string(),
                });
            }
        }
        Ok(())
    }
}

fn check_identifier(what: &'static str, name: &str) -> Result<(), Error> {
    let mut chars = name.chars();
    let first = chars.next();
    let good = first.is_some_and(|c| c.is_ascii_alphabetic() || c == '_')
        && chars.all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= 200;
    if good {
        return Ok(());
    }
    Err(Error::BadName {
        what,
        name: name.to_string(),
        expected: "it must be a Verilog identifier of letters, digits and _, of at most 200 \
                   characters",
    })
}

fn check_file(name: &str) -> Result<(), Error> {
    let good = name.rsplit_once('.').is_some_and(|(stem, ending)| {
        ["v", "sv", "vh", "svh"].contains(&ending)
            && stem.starts_with(|c: char| c.is_ascii_alphanumeric() || c == '_')
            && stem
                .chars()
                .all(|c| c.is_ascii_alphanumeric() || "_-.".contains(c))
    });
    if good && name.len() <= 200 {
        return Ok(());
    }
    Err(Error::BadName {
        what: "source file",
        name: name.to_string(),
        expected: "it must be a plain name without folders that ends in .v, .sv, .vh or .svh",
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_that_could_leave_the_folder_are_refused() {
        for good in ["a.v", "gu_top.sv", "x-1.2.vh"] {
            assert!(check_file(good).is_ok(), "{good}");
        }
        for bad in [
            "../a.v", "a/b.v", "", ".v", "-o.v", "a.cpp", "a", "a b.v", "obj",
        ] {
            assert!(check_file(bad).is_err(), "{bad:?}");
        }
        for bad in ["", "1a", "a-b", "a b", "--x", "a\"", "é"] {
            assert!(check_identifier("module", bad).is_err(), "{bad:?}");
        }
    }
}
