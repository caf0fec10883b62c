#![allow(clippy::unwrap_used)]
use potamoi_netlist::ModuleBuilder;

use super::*;

const ANSI: &str = "module leaf (input wire clk, input wire [3:0] a, b,
  output reg [7:0] y // input comment
); function f; input q; f = q; endfunction helper h (.a(a)); endmodule
module helper (a); input [3:0] a; endmodule";

fn unit() -> std::sync::Arc<Module> {
    let mut m = ModuleBuilder::new("unit");
    let a = m.input("a", potamoi_netlist::Ty::u(4), "operand");
    m.output("y", a, "result");
    m.finish().unwrap()
}

fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    folder
}

fn error(files: &[(&str, &str)], prefix: Option<&str>) -> String {
    let folder = folder(files);
    let read = ForeignRtl::read(folder.path(), prefix);
    let error = read
        .and_then(|rtl| rtl.files(&unit()))
        .unwrap_err()
        .to_string();
    error.replace(&folder.path().display().to_string(), "DIR")
}

#[test]
fn ports_are_read_in_both_styles() {
    let found: BTreeMap<_, _> = modules(Path::new("x.v"), ANSI).into_iter().collect();
    let leaf = &found["leaf"].ports;
    let widths: Vec<_> = leaf
        .iter()
        .map(|(n, p)| (&**n, p.width.unwrap(), p.output))
        .collect();
    let expected = [
        ("a", 4, false),
        ("b", 4, false),
        ("clk", 1, false),
        ("y", 8, true),
    ];
    assert_eq!(widths, expected);
    assert!(found["leaf"].words.contains("helper"));
    assert_eq!(found["helper"].ports["a"].width, Some(4));
}

#[test]
fn a_unit_is_found_by_name_prefix_or_ports_with_the_files_that_it_needs() {
    let body = "(input [3:0] a, output [3:0] y); low l (a, y); endmodule";
    for (name, prefix) in [("unit", None), ("npu_unit", Some("npu_")), ("other", None)] {
        let top = format!("module {name} {body}");
        let low = "module low (input [3:0] p, output [3:0] q); endmodule";
        let files = [
            ("u/top.v", &*top),
            ("u/low.v", low),
            ("v/low.v", low),
            ("u/x_tb.v", low),
        ];
        let folder = folder(&files);
        let rtl = ForeignRtl::read(folder.path(), prefix).unwrap();
        let files = rtl.files(&unit()).unwrap();
        let names: Vec<_> = files.keys().map(String::as_str).collect();
        let wrapper = format!("unit_of_{name}.v");
        let mut expected = vec!["u_low.v", "u_top.v"];
        if name != "unit" {
            expected.push(&wrapper);
        }
        assert_eq!(names, expected);
    }
}

#[test]
fn errors_name_module_port_and_width() {
    let of = |text: &str| error(&[("t.v", text)], None);
    assert_eq!(
        of("module x (input b); endmodule"),
        "DIR: no module unit, and none has all of its ports; modules found: x"
    );
    assert_eq!(
        of("module unit (input [3:0] a); endmodule"),
        "DIR/t.v: module unit: no port y: expected an output of 4 bits"
    );
    assert_eq!(
        of("module unit (input [7:0] a, output [3:0] y); endmodule"),
        "DIR/t.v: module unit: port a has 8 bits: expected 4; name the configuration that the \
         Verilog was made of"
    );
    assert_eq!(
        of("module unit (output [3:0] a, output [3:0] y); endmodule"),
        "DIR/t.v: module unit: port a is an output: expected an input"
    );
    assert_eq!(
        of("module unit (input [3:0] a, input en, output [3:0] y); endmodule"),
        "DIR/t.v: module unit: an input en that the unit does not have"
    );
    let one = "module p_unit (input [3:0] a, output [3:0] y); endmodule";
    assert!(error(&[("a.v", one), ("b.v", one)], None).contains("DIR/a.v and DIR/b.v"));
    let other = one.replace("p_", "q_");
    let said = error(&[("a.v", one), ("b.v", &other)], None);
    assert!(
        said.contains("p_unit and q_unit both have its ports"),
        "{said}"
    );
    assert!(error(&[("a.v", one)], Some("q_")).contains("no module q_unit"));
    assert!(error(&[("a.txt", one)], None).contains("DIR: no Verilog"));
}
