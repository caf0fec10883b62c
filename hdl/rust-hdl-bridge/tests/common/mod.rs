//! Runs Verilog under Icarus.

use std::fmt::Write as _;
use std::process::Command;

/// Runs a tool in a folder and gives back what it printed.
fn run(command: &mut Command, dir: &std::path::Path) -> String {
    let name = command.get_program().to_string_lossy().into_owned();
    let output = command.current_dir(dir).output().unwrap_or_else(|e| {
        panic!("`{name}` does not start ({e}): run tools/setup, or apt-get install iverilog")
    });
    assert!(
        output.status.success(),
        "{name}: {}",
        String::from_utf8_lossy(&output.stderr)
    );
    String::from_utf8(output.stdout).unwrap()
}

/// The decimal values of `outputs` after each step, which is a list of
/// assignments to `inputs`. A clock is an input like any other.
pub(crate) fn icarus(
    verilog: &str,
    inputs: &[(&str, u32)],
    outputs: &[(&str, u32)],
    steps: &[Vec<(&str, u64)>],
) -> Vec<Vec<String>> {
    let mut bench = String::from("`timescale 1ns/1ns\nmodule bench;\n");
    let mut ports = vec![];
    for (kind, list) in [("reg", inputs), ("wire", outputs)] {
        for (name, bits) in list {
            let _ = writeln!(bench, "  {kind} [{}:0] {name};", bits - 1);
            ports.push(format!(".{name}({name})"));
        }
    }
    let _ = writeln!(bench, "  top dut ({});\n  initial begin", ports.join(", "));
    for step in steps {
        for (name, value) in step {
            let _ = writeln!(bench, "    {name} = {value};");
        }
        let names: Vec<_> = outputs.iter().map(|o| o.0).collect();
        let format = vec!["%0d"; names.len()].join(" ");
        let _ = writeln!(
            bench,
            "    #1 $display(\"{format}\", {});",
            names.join(", ")
        );
    }
    bench.push_str("  end\nendmodule\n");
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join("design.v"), verilog).unwrap();
    std::fs::write(dir.path().join("bench.v"), bench).unwrap();
    let args = [
        "-g2005", "-s", "bench", "-o", "run.vvp", "bench.v", "design.v",
    ];
    run(Command::new("iverilog").args(args), dir.path());
    let said = run(Command::new("vvp").args(["-n", "run.vvp"]), dir.path());
    let lines = said
        .lines()
        .map(|l| l.split(' ').map(str::to_owned).collect());
    lines.collect()
}

/// rust-hdl's `yosys_validate`, which panics where Yosys is missing.
pub(crate) fn validate(name: &str, verilog: &str) -> Result<(), rust_hdl_core::yosys::SynthError> {
    let found = Command::new("yosys").arg("-V").output();
    found.expect("`yosys` does not start: run tools/setup, or apt-get install yosys");
    // Its folder under the temporary one is shared by all processes.
    let folder = format!("potamoi_rust_hdl_{name}_{}", std::process::id());
    let result = rust_hdl_core::yosys::yosys_validate(&folder, verilog);
    let _ = std::fs::remove_dir_all(std::env::temp_dir().join(folder));
    result
}
