//! The C text, compiled.

use std::fs::File;
use std::path::Path;
use std::process::Command;

use potamoi_formats::config::{ExpConfig, ExpForm};
use potamoi_reference::exponential::c_header;

use crate::engines::{ENGINES, assert_equal, folder, grid, operands, read};

/// Warnings are errors.
const FLAGS: [&str; 5] = ["-Wall", "-Wextra", "-Wconversion", "-Werror", "-pedantic"];

/// Undefined behaviour stops the program; no library is needed for it.
const SANITISED: [&str; 3] = [
    "-O1",
    "-fsanitize=undefined",
    "-fsanitize-undefined-trap-on-error",
];

/// A program that computes the results of the operands that standard input has, both of 4 bytes in
/// the machine's order. Its argument numbers the engine: the function that a header of the same name
/// has.
fn program(engines: &[String]) -> String {
    let includes = engines
        .iter()
        .map(|name| format!("#include \"{name}.h\"\n"));
    let functions = engines.iter().map(|name| format!("    {name},\n"));
    format!(
        r"{includes}#include <stdio.h>
#include <stdlib.h>

static uint32_t (*const ENGINES[])(uint32_t) = {{
{functions}}};

int main(int count, char **words)
{{
    uint32_t s;
    if (count != 2) {{
        return 2;
    }}
    while (fread(&s, sizeof s, 1, stdin) == 1) {{
        s = ENGINES[atoi(words[1])](s);
        if (fwrite(&s, sizeof s, 1, stdout) != 1) {{
            return 1;
        }}
    }}
    return 0;
}}
",
        includes = includes.collect::<String>(),
        functions = functions.collect::<String>(),
    )
}

fn compiler(variable: &str, otherwise: &str) -> Command {
    Command::new(std::env::var(variable).unwrap_or_else(|_| otherwise.to_owned()))
}

/// Runs a compiler in a folder.
fn compile(command: &mut Command, folder: &Path) {
    let output = command.current_dir(folder).output();
    let output = output.expect("no C compiler: tools/setup test");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
}

/// Compiles `main.c` of a folder.
fn compile_main(folder: &Path, flags: &[&str]) {
    let mut command = compiler("CC", "cc");
    command.arg("-std=c99").args(FLAGS).args(flags);
    compile(command.args(["main.c", "-o", "main"]), folder);
}

/// What the program of a folder computes of all operands.
fn run(folder: &Path, config: &ExpConfig, engine: usize) -> Vec<u8> {
    let bytes = operands(config).into_iter().flat_map(i32::to_ne_bytes);
    std::fs::write(folder.join("operands"), bytes.collect::<Vec<_>>()).unwrap();
    let output = Command::new(folder.join("main"))
        .arg(engine.to_string())
        .stdin(File::open(folder.join("operands")).unwrap())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && said.is_empty(), "{said}");
    let words = output.stdout.chunks(4);
    words
        .flat_map(|word| u32::from_ne_bytes(word.try_into().unwrap()).to_le_bytes())
        .collect()
}

/// What a header computes, compiled with flags.
fn results(config: &ExpConfig, header: &str, name: &str, flags: &[&str]) -> Vec<u8> {
    let folder = folder(&format!("c-{name}"));
    std::fs::write(folder.join("potamoi_exp.h"), header).unwrap();
    std::fs::write(folder.join("main.c"), program(&["potamoi_exp".to_owned()])).unwrap();
    compile_main(&folder, flags);
    run(&folder, config, 0)
}

/// Headers in one program: each function has a name of its own.
fn compare(bodies: &[String], name: &str, flags: &[&str]) {
    let folder = folder(&format!("c-{name}"));
    let mut engines = vec![];
    for (i, body) in bodies.iter().enumerate() {
        let prefix = format!("engine{i}_");
        let text = c_header(&read(body).unwrap(), &prefix);
        std::fs::write(folder.join(format!("{prefix}potamoi_exp.h")), text).unwrap();
        engines.push(format!("{prefix}potamoi_exp"));
    }
    std::fs::write(folder.join("main.c"), program(&engines)).unwrap();
    compile_main(&folder, flags);
    for (i, body) in bodies.iter().enumerate() {
        let config = read(body).unwrap();
        assert_equal(&config, &run(&folder, &config, i), "C");
    }
}

#[test]
fn c_results_are_those_of_the_reference_unit() {
    compare(&ENGINES.map(str::to_owned), "engines", &["-O1"]);
}

#[test]
#[ignore = "hundreds of engines; run with make test-full"]
fn c_results_of_a_grid_are_those_of_the_reference_unit() {
    compare(&grid(), "grid", &SANITISED);
}

/// Of every form's plain engine, with the header as it is.
#[test]
fn the_c_text_of_all_forms_is_defined_and_also_cpp() {
    for form in ExpForm::ALL {
        let (config, name) = (form.plain(), form.name());
        let found = results(&config, &c_header(&config, ""), name, &SANITISED);
        assert_equal(&config, &found, "C with a sanitiser");
        let folder = folder(&format!("c-{name}"));
        let cpp = ["-std=c++11", "-fsyntax-only", "-x", "c++", "main.c"];
        compile(compiler("CXX", "c++").args(FLAGS).args(cpp), &folder);
    }
}

/// A last bit of a constant is seen.
#[test]
fn a_wrong_constant_is_found() {
    let config = ExpForm::Restoring.plain();
    let text = c_header(&config, "");
    // ln 2 in units of 2^-19.
    let (right, wrong) = ("INT64_C(363409)", "INT64_C(363410)");
    assert_eq!(text.matches(right).count(), 1, "{text}");
    let found = results(&config, &text.replace(right, wrong), "wrong", &["-O1"]);
    let compared = std::panic::catch_unwind(|| assert_equal(&config, &found, "C"));
    assert!(compared.is_err());
}
