//! Runs Verilator and the C++ compiler.

use crate::{
    Error, Toolchain,
    commands::{
        PRELUDE, PRELUDE_FILE, all, broken, common_flags, compiler, read, run, tools_key, write,
        write_prelude,
    },
    headers,
    ports::{Member, Port, parse_header},
    store::{self, Entry, Key, Product, SCRATCH},
};
use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

const SHIM: &str = include_str!("cpp/shim.cpp");
/// Optimisation of the shim, compiled separately: it is small and on the path of every evaluation.
const SHIM_OPTIMISE: &str = "-O2";
const SHIM_OBJECT: &str = "shim.o";

/// Names of the files in a product that this crate reads.
pub(crate) const LIBRARY: &str = "model.so";
pub(crate) const MODEL_OBJECT: &str = "model.o";
pub(crate) const OBJ: &str = "obj";

/// All inputs of a compilation, except the tools.
#[derive(Debug, Clone)]
pub(crate) struct Spec {
    pub(crate) top: String,
    pub(crate) sources: Vec<(String, String)>,
    pub(crate) vcd: bool,
    pub(crate) optimise: &'static str,
    pub(crate) deny_warnings: bool,
    pub(crate) keep_objects: bool,
}

/// Verilator 5.006 rewrites some trees of bit operations wrongly (its issues 4059 and 4842), and with
/// `-O0` it drops bits of wide constants.
const NO_BIT_TREES: &str = "-fno-const-bit-op-tree";

fn verilator_flags(spec: &Spec) -> Vec<&'static str> {
    let mut flags = vec![
        "--cc",
        "--assert",
        NO_BIT_TREES,
        "--x-initial",
        "unique",
        "--x-assign",
        "unique",
        "--prefix",
        "Vm",
        "--Mdir",
        OBJ,
    ];
    flags.push(if spec.deny_warnings {
        "-Wall"
    } else {
        "-Wno-fatal"
    });
    if spec.vcd {
        flags.push("--trace");
    }
    flags
}

impl Spec {
    pub(crate) fn key(&self, tools: &Toolchain) -> Key {
        let mut key = tools_key("model", tools, &common_flags(self.vcd))
            .with(SHIM)
            .with(&verilator_flags(self).join(" "))
            .with(self.optimise)
            .with(if self.keep_objects { "objects" } else { "" })
            .with(&self.top);
        for (name, text) in &self.sources {
            key = key.with(name).with(text);
        }
        key
    }
}

/// Verilator's own objects, compiled once for each set of tools and flags.
pub(crate) fn runtime(cache: &Path, tools: &Toolchain, vcd: bool) -> Result<Vec<PathBuf>, Error> {
    let mut units = vec!["verilated", "verilated_threads"];
    if vcd {
        units.push("verilated_vcd_c");
    }
    let flags = [common_flags(vcd), vec!["-O2"]].concat();
    let key = tools_key("runtime", tools, &flags);
    let entry = store::fetch(cache, "runtime", &key, &|folder| {
        let scratch = folder.join(SCRATCH);
        write(&scratch.join(PRELUDE_FILE), PRELUDE)?;
        let jobs = units.iter().map(|unit| {
            let mut command = compiler(tools, &scratch, vcd);
            command.args(["-O2", "-c", "-o"]);
            command.arg(folder.join(format!("{unit}.o")));
            command.arg(tools.verilator_root().join(format!("include/{unit}.cpp")));
            command
        });
        all(jobs.collect(), "compiling Verilator's run-time code")?;
        Ok(Product {
            files: units.iter().map(|u| format!("{u}.o")).collect(),
            notes: Vec::new(),
        })
    })?;
    Ok(units
        .iter()
        .map(|u| entry.folder.join(format!("{u}.o")))
        .collect())
}

/// Builds the model of `spec`, or takes it from the cache.
pub(crate) fn model(cache: &Path, tools: &Toolchain, spec: &Spec) -> Result<Entry, Error> {
    let key = spec.key(tools);
    store::fetch(cache, &spec.top, &key, &|folder| {
        make(cache, tools, spec, folder)
    })
}

fn make(cache: &Path, tools: &Toolchain, spec: &Spec, folder: &Path) -> Result<Product, Error> {
    let scratch = folder.join(SCRATCH);
    for (name, text) in &spec.sources {
        write(&scratch.join(name), text)?;
    }
    let mut verilator = tools.verilator();
    verilator.current_dir(&scratch).args(verilator_flags(spec));
    verilator.args(["--top-module", &spec.top]);
    let is_header = |name: &str| name.ends_with(".vh") || name.ends_with(".svh");
    verilator.args(spec.sources.iter().map(|s| &s.0).filter(|n| !is_header(n)));
    let doing = format!("reading the Verilog of {}", spec.top);
    read(&verilator, &doing)?;

    let obj = scratch.join(OBJ);
    let lacking = |problem: String| broken(&verilator, &doing, problem);
    let header = fs::read_to_string(obj.join("Vm.h")).map_err(|e| {
        lacking(format!(
            "it ended well, but left no readable {OBJ}/Vm.h: {e}"
        ))
    })?;
    let members = parse_header(&header)
        .map_err(|line| lacking(format!("{OBJ}/Vm.h declares no port so: `{line}`")))?;
    write_prelude(&scratch)?;
    if !spec.vcd && !spec.keep_objects {
        headers::provide(cache, tools, spec.optimise, &scratch)?;
    }
    write(&scratch.join("shim.cpp"), &shim(&members))?;
    let mut unit = unit(&obj)?;
    if unit.is_empty() {
        return Err(lacking(format!("it ended well, but left no C++ in {OBJ}")));
    }
    let object = |name: &str| folder.join(SCRATCH).join(name);
    let mut jobs = vec![("unit.cpp", MODEL_OBJECT, spec.optimise)];
    let mut objects = vec![object(MODEL_OBJECT)];
    if spec.keep_objects {
        jobs.push(("shim.cpp", SHIM_OBJECT, SHIM_OPTIMISE));
        objects.push(object(SHIM_OBJECT));
    } else {
        // Verilator's headers are most of what is read: once.
        unit.push_str("#include \"shim.cpp\"\n");
    }
    write(&scratch.join("unit.cpp"), &unit)?;
    let jobs = jobs.into_iter().map(|(from, to, optimise)| {
        let mut command = compiler(tools, &scratch, spec.vcd);
        command.args([optimise, "-Iobj", "-c", from, "-o"]);
        command.arg(object(to));
        command
    });
    all(
        jobs.collect(),
        &format!("compiling the model of {}", spec.top),
    )?;

    let mut link = compiler(tools, &scratch, spec.vcd);
    if let Some(lacks) = objects.iter().find(|object| !object.is_file()) {
        let problem = format!("it ended well, but left no {}", lacks.display());
        return Err(broken(&link, "compiling", problem));
    }
    link.args(["-shared", "-Wl,-Bsymbolic", "-Wl,-z,defs", "-Wl,-z,now"]);
    link.args(objects);
    link.args(runtime(cache, tools, spec.vcd)?);
    link.arg("-o").arg(folder.join(LIBRARY));
    run(link, &format!("linking the model of {}", spec.top))?;

    let mut files = vec![LIBRARY.to_string()];
    if spec.keep_objects {
        files.extend(keep(folder)?);
    }
    Ok(Product {
        files,
        notes: members.iter().map(|m| note(&m.port)).collect(),
    })
}

/// Moves the object file and the headers out of the scratch folder.
fn keep(folder: &Path) -> Result<Vec<String>, Error> {
    let to = folder.join(OBJ);
    fs::create_dir(&to).map_err(|e| Error::io("create the folder", &to, &e))?;
    let mut kept = vec![MODEL_OBJECT.to_string()];
    let move_to = |from: PathBuf, to: PathBuf| {
        fs::rename(&from, &to).map_err(|e| Error::io("move", &from, &e))
    };
    let scratch = folder.join(SCRATCH);
    move_to(scratch.join(MODEL_OBJECT), folder.join(MODEL_OBJECT))?;
    for name in names(&scratch.join(OBJ), ".h")? {
        move_to(scratch.join(OBJ).join(&name), to.join(&name))?;
        kept.push(format!("{OBJ}/{name}"));
    }
    Ok(kept)
}

/// One translation unit with all of Verilator's output.
fn unit(obj: &Path) -> Result<String, Error> {
    Ok(names(obj, ".cpp")?
        .iter()
        .fold(String::new(), |s, n| s + &format!("#include \"{n}\"\n")))
}

fn names(folder: &Path, ending: &str) -> Result<Vec<String>, Error> {
    let fail = |e: std::io::Error| Error::io("list", folder, &e);
    let mut names = Vec::new();
    for entry in fs::read_dir(folder).map_err(fail)? {
        let name = entry.map_err(fail)?.file_name();
        if let Some(name) = name.to_str().filter(|n| n.ends_with(ending)) {
            names.push(name.to_string());
        }
    }
    names.sort();
    Ok(names)
}

fn shim(members: &[Member]) -> String {
    let mut cases = String::new();
    for (i, m) in members.iter().enumerate() {
        let (cpp, bytes) = (&m.cpp, m.port.bytes());
        let _ = writeln!(
            cases,
            "    case {i}: static_assert(sizeof(t.{cpp}) == {bytes}, \"storage of {cpp}\"); \
             return (void*)&t.{cpp};"
        );
    }
    let (load, store) = packed(members);
    SHIM.replace("@PORTS@", &cases)
        .replace("@LOAD@", &load)
        .replace("@STORE@", &store)
}

/// C++ that unpacks words into all inputs, and packs all outputs into words.
fn packed(members: &[Member]) -> (String, String) {
    let (mut load, mut store) = (String::new(), String::new());
    let (mut from, mut to) = (0, 0);
    for m in members {
        let (cpp, bits, words) = (&m.cpp, m.port.bits, m.port.words());
        let over = bits % 32;
        let mask = if over == 0 { u32::MAX } else { (1 << over) - 1 };
        if m.port.dir == crate::Direction::Input {
            let last = from + words - 1;
            let _ = match bits {
                0..=32 => writeln!(load, "        t.{cpp} = in[{from}] & {mask:#x}u;"),
                33..=64 => writeln!(
                    load,
                    "        t.{cpp} = in[{from}] | uint64_t{{in[{last}] & {mask:#x}u}} << 32;"
                ),
                _ => writeln!(
                    load,
                    "        std::memcpy(&t.{cpp}[0], in + {from}, sizeof t.{cpp}); \
                     t.{cpp}[{}] &= {mask:#x}u;",
                    words - 1
                ),
            };
            from += words;
        } else {
            let _ = match bits {
                0..=32 => writeln!(store, "        out[{to}] = t.{cpp};"),
                33..=64 => writeln!(
                    store,
                    "        out[{to}] = uint32_t(t.{cpp}); out[{}] = uint32_t(t.{cpp} >> 32);",
                    to + 1
                ),
                _ => writeln!(
                    store,
                    "        std::memcpy(out + {to}, &t.{cpp}[0], sizeof t.{cpp});"
                ),
            };
            to += words;
        }
    }
    (load, store)
}

fn note(port: &Port) -> String {
    format!("{} {} {}", port.dir, port.bits, port.name)
}

/// Parses a port from [`note`]'s format.
pub(crate) fn parse_note(note: &str) -> Option<Port> {
    let mut words = note.splitn(3, ' ');
    Some(Port {
        dir: crate::Direction::parse(words.next()?)?,
        bits: words.next()?.parse().ok()?,
        name: words.next()?.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each part changed alone gives another model: a part missing from the key would load a model
    /// of other Verilog or other tools.
    #[test]
    fn every_part_of_a_model_is_in_its_key() {
        let sources = |name: &str, text: &str| vec![(name.to_owned(), text.to_owned())];
        let spec = Spec {
            top: "m".to_owned(),
            sources: sources("m.v", "module m; endmodule"),
            vcd: false,
            optimise: "-O1",
            deny_warnings: false,
            keep_objects: false,
        };
        let with = |change: &dyn Fn(&mut Spec)| {
            let mut changed = spec.clone();
            change(&mut changed);
            changed
        };
        let specs = [
            spec.clone(),
            with(&|s| s.top = "n".to_owned()),
            with(&|s| s.sources = sources("n.v", "module m; endmodule")),
            with(&|s| s.sources = sources("m.v", "module m;  endmodule")),
            with(&|s| s.sources.clear()),
            with(&|s| s.vcd = true),
            with(&|s| s.optimise = "-O2"),
            with(&|s| s.deny_warnings = true),
            with(&|s| s.keep_objects = true),
        ];
        let tools = ["Verilator 5.006", "/v", "g++", "g++ 12"];
        let mut keys = specs
            .map(|s| s.key(&Toolchain::pretended(tools)).hex())
            .to_vec();
        for (part, other) in ["Verilator 5.008", "/w", "ccache g++", "g++ 13"]
            .iter()
            .enumerate()
        {
            let mut changed = tools;
            changed[part] = other;
            keys.push(spec.key(&Toolchain::pretended(changed)).hex());
        }
        let count = keys.len();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), count);
    }
}
