//! `potamoi emit --unit exp`: what the page about it says works as it stands.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::common::{expect, json, stderr, stdout};

const PAGE: &str = "docs/how-to/exponential-by-itself.md";

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Lines of the page's blocks of a kind.
fn block(page: &str, kind: &str) -> Vec<String> {
    let fence = format!("```{kind}\n");
    let blocks = page.split(&fence).skip(1);
    let lines = blocks.flat_map(|rest| rest.split("```").next().unwrap_or_default().lines());
    lines.map(str::to_owned).collect()
}

/// Runs a program in a folder: one run of each bench, and the Python with NumPy that `tools/setup` has.
fn run(folder: &Path, program: &str, arguments: &[&str]) -> Output {
    let own = root().join(".tools/bin/python3-numpy");
    let python = if own.exists() {
        own
    } else {
        PathBuf::from("python3")
    };
    let program = if program == "python" {
        python.as_os_str()
    } else {
        program.as_ref()
    };
    let mut command = Command::new(program);
    command
        .current_dir(folder)
        .env("RUNS", "0:1")
        .env("PYTHON", &python)
        .env("PYTHONPATH", root().join("python"))
        .env("PYTHONDONTWRITEBYTECODE", "1");
    let done = command.args(arguments).output();
    done.unwrap_or_else(|error| panic!("{command:?}: {error}: tools/setup test"))
}

fn passes(folder: &Path, program: &str, arguments: &[&str]) -> String {
    let done = run(folder, program, arguments);
    let said = stdout(&done) + &stderr(&done);
    assert!(done.status.success(), "{arguments:?}: {said}");
    said
}

/// Verilator runs every form's bench in the tests of `potamoi-rtl`.
#[test]
fn commands_of_the_page_work() {
    let page = std::fs::read_to_string(root().join(PAGE)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let emit = block(&page, "console");
    let emit = emit[0].strip_prefix("$ potamoi ").unwrap();
    let said = expect(folder.path(), 0, &emit.split(' ').collect::<Vec<_>>());
    for part in [
        "make -C rtl_exp/sim c ",
        "potamoi_exp_test.py",
        "64 pieces ",
        "dB: PSNR",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let commands = block(&page, "sh");
    assert_eq!(commands.len(), 4, "{commands:?}");
    for line in commands.iter().filter(|line| !line.contains("verilator")) {
        // The words before the comment, without a choice of program.
        let words = line.split('#').next().unwrap();
        let said = passes(folder.path(), "sh", &["-c", words]);
        assert_eq!(said.matches("PASS: ").count(), 1, "{line}: {said}");
    }
    let python = block(&page, "python");
    std::fs::write(folder.path().join("my.toml"), "[vu.exp]\niterations = 9\n").unwrap();
    let program = python.join("\n") + "\nprint(powers.tolist())\n";
    let said = passes(folder.path(), "python", &["-c", &program]);
    // exp(0), exp(-1) and exp(-7.9999) in units of 2^-16.
    assert_eq!(said.trim(), "[65535, 24109, 22]");
    let main = "#include <stdio.h>\n#include \"rtl_exp/potamoi_exp.h\"\n\
                int main(void) { uint32_t operand = 8192;\n@\nprintf(\"%u\", (unsigned)power); return 0; }\n";
    let c = block(&page, "c");
    let call = c.iter().find(|line| line.contains("power =")).unwrap();
    std::fs::write(folder.path().join("main.c"), main.replace('@', call)).unwrap();
    passes(
        folder.path(),
        "cc",
        &["-std=c99", "-Wall", "-Werror", "main.c", "-o", "main"],
    );
    assert_eq!(passes(folder.path(), "./main", &[]), "24109");
}

/// A prefix begins names, the report has the price, and a C header that was edited is not lost.
#[test]
fn what_is_emitted_is_in_the_report_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(
        at.join("own.toml"),
        "vu.ops = [\"exp\"]\n[vu.exp]\niterations = 7\noutput_bits = 10\n",
    )
    .unwrap();
    let arguments = [
        "--config",
        "own.toml",
        "emit",
        "--unit",
        "exp",
        "--prefix",
        "npu0_",
        "--out-dir",
        "x",
        "--json",
        "x.json",
    ];
    let said = expect(at, 0, &arguments);
    for part in [
        "restoring, n = 7, F = 10",
        " ~",
        "that differs in numbers alone",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    let report = json(&at.join("x.json"));
    for file in [
        "potamoi_exp.h",
        "sim/potamoi_exp_test.c",
        "sim/potamoi_exp_test.py",
    ] {
        assert!(
            report["files"][file].as_u64().unwrap() > 20,
            "{file}: {report}"
        );
    }
    let price = &report["price"];
    assert_eq!(price["error"]["operands"], 65_536);
    assert_eq!(price["interval_clocks"]["most"], 11);
    // Another number of iterations and of bits: a ratio to a synthesised block.
    assert_eq!(price["hardware"]["origin"]["kind"], "ratio", "{price}");
    let header = at.join("x/potamoi_exp.h");
    let text = std::fs::read_to_string(&header).unwrap();
    assert!(
        text.contains("static inline uint32_t npu0_potamoi_exp(uint32_t s)"),
        "{text}"
    );
    assert!(text.contains("#ifndef NPU0_POTAMOI_EXP_H"), "{text}");
    let said = passes(at, "make", &["-C", "x/sim", "c", "python"]);
    assert_eq!(said.matches("PASS: ").count(), 2, "{said}");
    std::fs::write(&header, text + "/* mine */\n").unwrap();
    let said = expect(at, 2, &arguments);
    assert!(
        said.contains("potamoi_exp.h") && said.contains("--overwrite"),
        "{said}"
    );
}

#[test]
fn prices_are_of_the_methods_alone() {
    let folder = tempfile::tempdir().unwrap();
    let said = expect(
        folder.path(),
        2,
        &["cost", "--study", "exp", "--prices", "p.csv"],
    );
    assert!(
        said.contains("--prices: expected with --study methods"),
        "{said}"
    );
}
