//! Verilog of others with the ports of the units: edited, synthesised again, or of gates.

mod source;

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::Module;
use potamoi_units::gathering_unit::gathering_unit;
use potamoi_units::vector_unit::vector_unit;

use crate::RtlError;
use source::{Declared, Source, modules};

/// Folders below the named one that are searched.
const DEPTH: usize = 3;
/// Size limit of a file in bytes.
const LARGEST: u64 = 256 << 20;

/// Verilog files of a folder.
#[derive(Debug, Clone)]
pub struct ForeignRtl {
    folder: PathBuf,
    prefix: Option<String>,
    /// Modules by name, each as often as it is declared.
    modules: BTreeMap<String, Vec<Source>>,
}

impl ForeignRtl {
    /// Reads the files `*.v` and `*.sv` of a folder and of those below it, except for testbenches
    /// (`*_tb.v`) and the working folders of SymbiYosys. A unit is the module of its name with `prefix` before it; without a prefix, that
    /// of its name or else the only one with its ports.
    ///
    /// # Errors
    /// A folder or file that cannot be read, or no Verilog file.
    pub fn read(folder: &Path, prefix: Option<&str>) -> Result<Self, RtlError> {
        let mut files = vec![];
        list(folder, DEPTH, &mut files)?;
        files.sort();
        if files.is_empty() {
            let folder = folder.display();
            let text =
                format!("{folder}: no Verilog: expected files *.v or *.sv in it or below it");
            return Err(RtlError::Usage(text));
        }
        let mut all = BTreeMap::<String, Vec<Source>>::new();
        for path in files {
            let text = fs::read_to_string(&path).map_err(|error| unread(&path, &error))?;
            for (name, module) in modules(&path, &Arc::new(text)) {
                all.entry(name).or_default().push(module);
            }
        }
        Ok(Self {
            folder: folder.to_owned(),
            prefix: prefix.map(str::to_owned),
            modules: all,
        })
    }

    /// Checks that the folder has both units of a configuration.
    ///
    /// # Errors
    /// Those of [`ForeignRtl::files`].
    pub fn check_units(&self, config: &Config) -> Result<(), RtlError> {
        for unit in [gathering_unit(config)?, vector_unit(config)?] {
            self.files(&unit)?;
        }
        Ok(())
    }

    /// The files of a unit by name, with the ports of `unit` checked. Where the module has another
    /// name, a further file connects it.
    ///
    /// # Errors
    /// A module that is missing or declared twice, or a port that is missing or has another
    /// direction or width.
    pub fn files(&self, unit: &Module) -> Result<BTreeMap<String, String>, RtlError> {
        let expected = expected_ports(unit);
        let (name, top) = self.top(unit.name(), &expected)?;
        self.check(name, top, &expected)?;
        let mut files = BTreeMap::new();
        for path in self.below(name, top)? {
            let text = fs::read_to_string(&path).map_err(|error| unread(&path, &error))?;
            files.insert(plain_name(&self.folder, &path), text);
        }
        if name != unit.name() {
            files.insert(
                format!("{}_of_{name}.v", unit.name()),
                wrapper(unit.name(), name, &expected),
            );
        }
        Ok(files)
    }

    fn refuse(&self, problem: &str) -> RtlError {
        RtlError::Usage(format!("{}: {problem}", self.folder.display()))
    }

    fn top(&self, unit: &str, expected: &Ports) -> Result<(&str, &Source), RtlError> {
        let wanted = format!("{}{unit}", self.prefix.as_deref().unwrap_or_default());
        if let Some((name, found)) = self.modules.get_key_value(&wanted) {
            return Ok((name, self.only(name, found)?));
        }
        let has_ports = |found: &&Vec<Source>| {
            let ports = &found[0].ports;
            expected.keys().all(|port| ports.contains_key(port))
        };
        let mut alike = self.modules.iter().filter(|(_, found)| has_ports(found));
        match (&self.prefix, alike.next(), alike.next()) {
            (None, Some((name, found)), None) => Ok((name, self.only(name, found)?)),
            (None, Some((one, _)), Some((other, _))) => Err(self.refuse(&format!(
                "no module {wanted}, and {one} and {other} both have its ports: tell which by \
                 --rtl-prefix"
            ))),
            _ => {
                let names: Vec<_> = self.modules.keys().map(String::as_str).take(12).collect();
                Err(self.refuse(&format!(
                    "no module {wanted}, and none has all of its ports; modules found: {}",
                    names.join(", ")
                )))
            }
        }
    }

    fn only<'a>(&self, name: &str, found: &'a [Source]) -> Result<&'a Source, RtlError> {
        match found {
            [one] => Ok(one),
            several => {
                let places: Vec<_> = several
                    .iter()
                    .map(|s| s.path.display().to_string())
                    .collect();
                let places = places.join(" and ");
                Err(self.refuse(&format!(
                    "module {name} is declared in {places}: expected once"
                )))
            }
        }
    }

    fn check(&self, name: &str, top: &Source, expected: &Ports) -> Result<(), RtlError> {
        let place = top.path.display();
        let refuse = |problem: String| {
            Err(RtlError::Usage(format!(
                "{place}: module {name}: {problem}"
            )))
        };
        for (port, wanted) in expected {
            let direction = |output| if output { "an output" } else { "an input" };
            let Some(found) = top.ports.get(port) else {
                let (kind, width) = (direction(wanted.output), wanted.width.unwrap_or(1));
                return refuse(format!("no port {port}: expected {kind} of {width} bits"));
            };
            if found.output != wanted.output {
                let (found, wanted) = (direction(found.output), direction(wanted.output));
                return refuse(format!("port {port} is {found}: expected {wanted}"));
            }
            if let (Some(found), Some(wanted)) = (found.width, wanted.width)
                && found != wanted
            {
                return refuse(format!(
                    "port {port} has {found} bits: expected {wanted}; name the configuration that \
                     the Verilog was made of"
                ));
            }
        }
        let more = top
            .ports
            .iter()
            .find(|(port, own)| !own.output && !expected.contains_key(*port));
        match more {
            Some((port, _)) => refuse(format!("an input {port} that the unit does not have")),
            None => Ok(()),
        }
    }

    /// Files of a module and of those that it names, directly or not.
    fn below(&self, name: &str, top: &Source) -> Result<BTreeSet<PathBuf>, RtlError> {
        let (mut open, mut done) = (vec![top], BTreeSet::from([name.to_owned()]));
        let mut paths = BTreeSet::new();
        while let Some(module) = open.pop() {
            paths.insert(module.path.clone());
            for used in &module.words {
                let Some(found) = self.modules.get(used) else {
                    continue;
                };
                if !done.insert(used.clone()) {
                    continue;
                }
                // Beside its user first: both units may have a module of one name.
                let beside = |s: &&Source| s.path.parent() == module.path.parent();
                let near: Vec<_> = found.iter().filter(beside).cloned().collect();
                let own = if near.len() == 1 { &near } else { found };
                let own = self.only(used, own)?.path.clone();
                open.extend(found.iter().find(|s| s.path == own));
            }
        }
        Ok(paths)
    }
}

type Ports = BTreeMap<String, Declared>;

fn expected_ports(unit: &Module) -> Ports {
    let mut ports = Ports::new();
    let input = Declared {
        output: false,
        width: Some(1),
    };
    for (name, has) in [("clk", unit.is_clocked()), ("rst_n", unit.has_reset())] {
        if has {
            ports.insert(name.to_owned(), input);
        }
    }
    for port in unit.ports() {
        let declared = Declared {
            output: port.output,
            width: Some(port.ty.width),
        };
        ports.insert(port.name, declared);
    }
    ports
}

/// A module of the unit's name around one of another.
fn wrapper(unit: &str, name: &str, ports: &Ports) -> String {
    let port = |(name, port): (&String, &Declared)| {
        let kind = if port.output { "output" } else { "input" };
        format!("  {kind} wire [{}:0] {name}", port.width.unwrap_or(1) - 1)
    };
    let declared: Vec<_> = ports.iter().map(port).collect();
    let links: Vec<_> = ports.keys().map(|p| format!("    .{p}({p})")).collect();
    let mut text = String::new();
    let _ = write!(
        text,
        "module {unit} (\n{}\n);\n  {name} unit (\n{}\n  );\nendmodule\n",
        declared.join(",\n"),
        links.join(",\n")
    );
    text
}

/// A file's name with those of its folders below the named one.
fn plain_name(folder: &Path, path: &Path) -> String {
    let below = path.strip_prefix(folder).unwrap_or(path).to_string_lossy();
    let plain = |c: char| {
        if c.is_ascii_alphanumeric() || c == '.' {
            c
        } else {
            '_'
        }
    };
    below.chars().map(plain).collect()
}

fn list(folder: &Path, depth: usize, files: &mut Vec<PathBuf>) -> Result<(), RtlError> {
    let entries = fs::read_dir(folder).map_err(|error| unread(folder, &error))?;
    for entry in entries {
        let path = entry.map_err(|error| unread(folder, &error))?.path();
        let name = path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned();
        if path.is_dir() {
            // A folder of SymbiYosys holds copies.
            let is_of_proof = path.join("config.sby").is_file();
            if depth > 0 && !name.starts_with('.') && !is_of_proof {
                list(&path, depth - 1, files)?;
            }
            continue;
        }
        let is_bench = ["_tb.v", "_tb.sv"].iter().any(|end| name.ends_with(end));
        let is_verilog = path
            .extension()
            .is_some_and(|end| end == "v" || end == "sv");
        if is_verilog && !is_bench {
            let bytes = fs::metadata(&path)
                .map_err(|error| unread(&path, &error))?
                .len();
            if bytes > LARGEST {
                let text = format!(
                    "{}: {bytes} bytes: expected at most {LARGEST}",
                    path.display()
                );
                return Err(RtlError::Usage(text));
            }
            files.push(path);
        }
    }
    Ok(())
}

fn unread(path: &Path, error: &std::io::Error) -> RtlError {
    RtlError::Usage(format!("cannot read {}: {error}", path.display()))
}

#[cfg(test)]
mod tests;
