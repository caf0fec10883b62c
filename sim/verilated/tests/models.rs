//! Models of small designs, driven through the public interface.

use potamoi_verilated::{
    Direction::{Input, Output},
    Error, Library, Model, ModelBuilder, Stop, Toolchain, Trace, Warnings,
    peer::Peer,
};
use proptest::prelude::*;
use std::{path::PathBuf, sync::OnceLock};

const WIDTHS: [u32; 20] = [
    1, 2, 7, 8, 9, 16, 17, 31, 32, 33, 63, 64, 65, 127, 128, 129, 511, 512, 513, 1024,
];

fn tools() -> Toolchain {
    Toolchain::detect().expect("these tests need Verilator 5 and a C++ compiler")
}

fn cache() -> PathBuf {
    PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("models")
}

fn build(top: &str, verilog: &str) -> Library {
    ModelBuilder::new(top)
        .source(format!("{top}.v"), verilog)
        .cache_dir(cache())
        .build(&tools())
        .unwrap()
}

/// For each width: an input, its complement at once, and its sum with itself after an edge.
fn widths() -> &'static Library {
    static LIBRARY: OnceLock<Library> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let (mut ports, mut body) = (String::new(), String::new());
        let mut builder = ModelBuilder::new("widths").cache_dir(cache());
        for w in WIDTHS {
            let top = w - 1;
            ports += &format!(
                ",\n input wire [{top}:0] a{w}, output wire [{top}:0] n{w}, output reg [{top}:0] q{w}"
            );
            body += &format!("assign n{w} = ~a{w}; always @(posedge clk) q{w} <= q{w} + a{w};\n");
            body += &format!("initial q{w} = 0;\n");
            builder = builder
                .port(format!("a{w}"), w, Input)
                .port(format!("n{w}"), w, Output)
                .port(format!("q{w}"), w, Output);
        }
        let text = format!("module widths(input wire clk{ports});\n{body}endmodule");
        builder.source("widths.v", text).build(&tools()).unwrap()
    })
}

fn masked(mut words: Vec<u32>, bits: u32) -> Vec<u32> {
    words.truncate(bits.div_ceil(32) as usize);
    if !bits.is_multiple_of(32) {
        *words.last_mut().unwrap() &= (1 << (bits % 32)) - 1;
    }
    words
}

fn sum(a: &[u32], b: &[u32], bits: u32) -> Vec<u32> {
    let mut carry = 0;
    let words = a.iter().zip(b).map(|(a, b)| {
        let s = u64::from(*a) + u64::from(*b) + carry;
        carry = s >> 32;
        s as u32
    });
    masked(words.collect(), bits)
}

/// A model runs on the thread that drives it.
#[test]
#[cfg(target_os = "linux")]
fn models_make_no_threads() {
    const MODELS: usize = 64;
    let library = widths();
    let threads = || std::fs::read_dir("/proc/self/task").unwrap().count();
    let before = threads();
    let models: Vec<_> = (0..MODELS)
        .map(|_| {
            let mut model = library.model(1).unwrap();
            model.eval().unwrap();
            model
        })
        .collect();
    // Other tests begin and end threads beside this one.
    let more = threads().saturating_sub(before);
    assert!(
        more < MODELS / 2,
        "{more} threads more for {} models",
        models.len()
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn every_width_goes_in_and_out(seeds in prop::collection::vec(
        prop::collection::vec(any::<u32>(), 32), 2)) {
        let library = widths();
        let mut model = library.model(1).unwrap();
        let clk = model.clock("clk").unwrap();
        let mut want: Vec<Vec<u32>> =
            WIDTHS.iter().map(|w| vec![0; w.div_ceil(32) as usize]).collect();
        for words in &seeds {
            for w in WIDTHS {
                let port = model.port(&format!("a{w}")).unwrap();
                prop_assert_eq!(port.bits(), w);
                if w <= 64 {
                    model.set_u64(port, u64::from(words[0]) | u64::from(words[1]) << 32).unwrap();
                } else {
                    model.set_words(port, &words[..port.words()]).unwrap();
                }
            }
            model.tick(clk).unwrap();
            for (w, want) in WIDTHS.into_iter().zip(&mut want) {
                let a = masked(words.clone(), w);
                *want = sum(want, &a, w);
                let port = |p: &str| model.port(&format!("{p}{w}")).unwrap();
                prop_assert_eq!(&model.words(port("a")).unwrap(), &a, "a{}", w);
                let not = masked(a.iter().map(|x| !x).collect(), w);
                prop_assert_eq!(&model.words(port("n")).unwrap(), &not, "n{}", w);
                prop_assert_eq!(&model.words(port("q")).unwrap(), &*want, "q{}", w);
                if w > 64 {
                    prop_assert_eq!(model.wide(port("q")).unwrap(), &want[..]);
                } else {
                    let high = want.get(1).copied().unwrap_or(0);
                    let whole = u64::from(want[0]) | u64::from(high) << 32;
                    prop_assert_eq!(model.get_u64(port("q")).unwrap(), whole);
                }
            }
        }
    }
}

#[test]
fn narrow_ports_take_words_too() {
    let mut model = widths().model(1).unwrap();
    for (name, words) in [("a33", vec![7, 0xffff_ffff]), ("a7", vec![0xff])] {
        let port = model.port(name).unwrap();
        model.set_words(port, &words).unwrap();
        assert_eq!(model.words(port).unwrap(), masked(words, port.bits()));
    }
}

#[test]
fn misuse_of_ports_is_an_error() {
    let library = widths();
    let mut model = library.model(1).unwrap();
    let port = |n: &str| library.port(n).unwrap();
    let text = |r: Result<(), Error>| r.unwrap_err().to_string();
    assert!(text(model.set_u64(port("q8"), 0)).contains("q8 is an output"));
    assert!(text(model.set_u64(port("a65"), 0)).contains("use set_words"));
    assert!(text(model.set_words(port("a65"), &[0; 2])).contains("3 words for it, not 2"));
    assert!(text(model.get_words(port("q65"), &mut [0; 4])).contains("3 words for it, not 4"));
    assert!(matches!(
        model.get_u64(port("q65")),
        Err(Error::WrongWidth { .. })
    ));
    assert!(matches!(
        model.wide(port("q64")),
        Err(Error::WrongWidth { .. })
    ));
    assert!(text(model.port("x").map(drop)).contains("input clk (1 bit)"));
    assert!(matches!(model.clock("a2"), Err(Error::WrongWidth { .. })));
    assert!(matches!(model.clock("q1"), Err(Error::NotAnInput { .. })));
    assert!(matches!(
        model.open_vcd("x.vcd"),
        Err(Error::NoTrace { .. })
    ));
    let other = build(
        "other",
        "module other(input clk, output o); assign o = clk; endmodule",
    );
    let (foreign, clock) = (
        other.port("o").unwrap(),
        other.model(1).unwrap().clock("clk"),
    );
    assert_eq!(model.get_u64(foreign), Err(Error::ForeignPort));
    assert_eq!(model.tick(clock.unwrap()), Err(Error::ForeignPort));
}

const STOPS: &str = r#"
module stops(input wire clk, input wire [2:0] how, output reg [7:0] n);
    initial n = 0;
    always @(posedge clk) begin
        n <= n + 1;
        if (how == 1) $fatal(1, "fatal at %0d", n);
        if (how == 2) $stop;
        if (how == 3) $finish;
        if (how == 4) $error("error at %0d", n);
        a_small: assert (how != 5) else $error("how is %0d", how);
        if (how == 6) $display("n is %0d", n);
    end
endmodule"#;

#[test]
fn a_model_that_stops_gives_an_error_and_stays_dead() {
    let library = ModelBuilder::new("stops")
        .source("stops.sv", STOPS)
        .cache_dir(cache())
        .build(&tools())
        .unwrap();
    let (how, n) = (library.port("how").unwrap(), library.port("n").unwrap());
    let expected = [
        (1, Stop::Stop, "fatal at 2"),
        (2, Stop::Stop, "stops.sv:7: $stop"),
        (3, Stop::Finish, "stops.sv:8: $finish"),
        (4, Stop::Stop, "error at 2"),
        (5, Stop::Stop, "how is 5"),
    ];
    for (value, cause, says) in expected {
        let mut model = library.model(9).unwrap();
        let clk = model.clock("clk").unwrap();
        model.tick(clk).unwrap();
        model.tick(clk).unwrap();
        assert_eq!(model.get_u64(n), Ok(2));
        model.set_u64(how, value).unwrap();
        let error = model.tick(clk).unwrap_err();
        match &error {
            Error::Stopped {
                top,
                time,
                cause: got,
                text,
            } => {
                assert_eq!((top.as_str(), *time, *got), ("stops", 6, cause));
                assert!(text.contains(says), "{text}");
            }
            other => panic!("{other}"),
        }
        assert_eq!(model.eval(), Err(error.clone()));
        assert_eq!(model.tick(clk), Err(error.clone()));
        assert_eq!(model.set_u64(how, 0), Err(error.clone()));
        assert_eq!(model.get_u64(n), Err(error));
    }
    let mut model = library.model(9).unwrap();
    let clk = model.clock("clk").unwrap();
    model.set_u64(how, 6).unwrap();
    model.tick(clk).unwrap();
    assert_eq!(model.take_output(), "n is 0\n");
    assert_eq!(model.take_output(), "");
}

#[test]
fn a_loop_that_does_not_settle_is_an_error() {
    let text = "module ring(input wire en, output wire o); wire a; \
                assign a = ~(a & en); assign o = a; endmodule";
    let library = ModelBuilder::new("ring")
        .source("ring.v", text)
        .warnings(Warnings::Allow)
        .cache_dir(cache())
        .build(&tools())
        .unwrap();
    let mut model = library.model(1).unwrap();
    model.eval().unwrap();
    model.set_u64(library.port("en").unwrap(), 1).unwrap();
    match model.eval() {
        Err(Error::Stopped {
            cause: Stop::Fatal,
            text,
            ..
        }) => {
            assert!(text.contains("converge"), "{text}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_seed_alone_decides_unreset_registers() {
    let library = build(
        "unreset",
        "module unreset(input wire clk, input wire en, output reg [255:0] q); \
         always @(posedge clk) if (en) q <= ~q; endmodule",
    );
    let start = |seed| {
        let mut model = library.model(seed).unwrap();
        model.eval().unwrap();
        model.words(library.port("q").unwrap()).unwrap()
    };
    let alone: Vec<_> = (0..8).map(start).collect();
    for (i, a) in alone.iter().enumerate() {
        assert!(alone[..i].iter().all(|b| b != a), "seed {i}");
    }
    // Threads that make models at once do not disturb one another's values.
    std::thread::scope(|scope| {
        let jobs: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| (0..8).map(start).collect::<Vec<_>>()))
            .collect();
        for job in jobs {
            assert_eq!(job.join().unwrap(), alone);
        }
    });
}

#[test]
fn models_move_between_threads() {
    let library = widths();
    let (a, q) = (library.port("a513").unwrap(), library.port("q513").unwrap());
    let mut models: Vec<Model> = (0..4).map(|i| library.model(i).unwrap()).collect();
    for turn in 1..=4u32 {
        std::thread::scope(|scope| {
            for (i, model) in models.iter_mut().enumerate() {
                scope.spawn(move || {
                    let clk = model.clock("clk").unwrap();
                    let mut value = [0; 17];
                    value[16] = i as u32 & 1;
                    value[3] = i as u32;
                    model.set_words(a, &value).unwrap();
                    model.tick(clk).unwrap();
                });
            }
        });
        for (i, model) in models.iter().enumerate() {
            let got = model.wide(q).unwrap();
            assert_eq!((got[3], got[16]), (i as u32 * turn, i as u32 & turn & 1));
        }
    }
}

#[test]
fn a_half_period_shows_what_follows_within_the_cycle() {
    let mut model = widths().model(1).unwrap();
    let clk = model.clock("clk").unwrap();
    let port = |n: &str| widths().port(n).unwrap();
    model.set_u64(port("a8"), 3).unwrap();
    model.fall(clk).unwrap();
    assert_eq!(model.get_u64(port("n8")), Ok(0xfc));
    assert_eq!(model.get_u64(port("q8")), Ok(0));
    model.rise(clk).unwrap();
    assert_eq!(model.get_u64(port("q8")), Ok(3));
    assert_eq!(model.time(), 2);
}

#[test]
fn a_value_change_dump_holds_the_values() {
    let library = ModelBuilder::new("count")
        .source(
            "count.v",
            "module count(input wire clk, output reg [3:0] n); initial n = 0; \
             always @(posedge clk) n <= n + 1; endmodule",
        )
        .trace(Trace::Vcd)
        .cache_dir(cache())
        .build(&tools())
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let mut model = library.model(1).unwrap();
    let clk = model.clock("clk").unwrap();
    assert!(matches!(model.close_vcd(), Err(Error::Trace(_))));
    assert!(matches!(model.dump(0), Err(Error::Trace(_))));
    let nowhere = folder.path().join("none/x.vcd");
    assert!(matches!(model.open_vcd(&nowhere), Err(Error::Trace(_))));
    // A second file of the same model is as good as the first.
    for (name, first) in [("a.vcd", 1u64), ("b.vcd", 6)] {
        let path = folder.path().join(name);
        model.open_vcd(&path).unwrap();
        for _ in 0..5 {
            model.tick(clk).unwrap();
        }
        let now = model.time();
        assert!(matches!(model.dump(now), Err(Error::Trace(_))));
        model.dump(now + 1).unwrap();
        model.close_vcd().unwrap();
        let values = last_values(&path, "n");
        let want: Vec<u64> = (first..first + 5).collect();
        assert_eq!(&values[values.len() - 5..], want, "{name}");
    }
}

/// The values that a signal takes, in order of time.
fn last_values(path: &std::path::Path, signal: &str) -> Vec<u64> {
    let file = std::io::BufReader::new(std::fs::File::open(path).unwrap());
    let mut parser = vcd::Parser::new(file);
    let header = parser.parse_header().unwrap();
    let scope = header.items.iter().find_map(|i| match i {
        vcd::ScopeItem::Scope(s) => Some(s),
        _ => None,
    });
    let code = scope
        .unwrap()
        .items
        .iter()
        .find_map(|i| match i {
            vcd::ScopeItem::Var(v) if v.reference == signal => Some(v.code),
            _ => None,
        })
        .unwrap();
    parser
        .filter_map(|c| match c.unwrap() {
            vcd::Command::ChangeVector(id, v) if id == code => Some(
                v.iter()
                    .fold(0, |n, b| 2 * n + u64::from(b == vcd::Value::V1)),
            ),
            _ => None,
        })
        .collect()
}

#[test]
fn the_cpp_twin_reads_the_same() {
    let text = "module twin(input wire clk, input wire [6:0] a__b, input wire [40:0] m, \
                input wire [70:0] w, output reg [70:0] q, output reg [15:0] s); \
                initial begin q = 0; s = 0; end \
                always @(posedge clk) begin q <= q + w + {30'd0, m}; s <= s + {9'd0, a__b}; end \
                endmodule";
    let builder = ModelBuilder::new("twin")
        .source("twin.v", text)
        .cache_dir(cache());
    let peer = Peer::build(builder, &tools(), "clk").unwrap();
    assert_eq!(peer.words_per_cycle(), 6);
    let stimulus: Vec<u32> = (0..6 * 100u32)
        .map(|i| i.wrapping_mul(0x9e37_79b9))
        .collect();
    let report = peer.compare(&stimulus, 3).unwrap();
    assert_eq!(report.cycles, 100);
    assert!(report.ratio > 0.0);
    let mut other = stimulus.clone();
    other[599] ^= 1;
    assert_eq!(peer.drive(&stimulus), Ok(report.checksum));
    assert_ne!(peer.drive(&other), Ok(report.checksum));
    assert!(matches!(
        peer.compare(&stimulus[1..], 3),
        Err(Error::Peer(_))
    ));
    assert!(matches!(peer.compare(&[], 3), Err(Error::Peer(_))));
}

/// All ports at once: the same as setting each, a tick, and reading each.
#[test]
fn a_packed_cycle_equals_single_accesses() {
    let widths = [1u32, 7, 8, 31, 32, 33, 63, 64, 65, 127, 160];
    let mut text = String::from("module packed_ports(input wire clk");
    for w in widths {
        text.push_str(&format!(
            ", input wire [{0}:0] a{w}, output reg [{0}:0] y{w}",
            w - 1
        ));
    }
    text.push_str("); always @(posedge clk) begin\n");
    for w in widths {
        text.push_str(&format!("  y{w} <= ~a{w};\n"));
    }
    text.push_str("end endmodule\n");
    let library = ModelBuilder::new("packed_ports")
        .source("packed_ports.v", text)
        .cache_dir(concat!(env!("CARGO_TARGET_TMPDIR"), "/models"))
        .build(&Toolchain::detect().unwrap())
        .unwrap();
    let (mut single, mut packed) = (library.model(1).unwrap(), library.model(1).unwrap());
    let clock = single.clock("clk").unwrap();
    let total: u32 = widths.iter().map(|w| w.div_ceil(32)).sum();
    let mut outputs = vec![0; total as usize];
    for round in 0..50u32 {
        let word = |i: u32| (i + 1).wrapping_mul(0x9e37_79b1).wrapping_mul(round + 1);
        // The clock's own word is of no account.
        let inputs: Vec<u32> = (0..=total).map(word).collect();
        let (mut at, mut ports) = (0, vec![]);
        for port in library.ports() {
            let id = single.port(&port.name).unwrap();
            if port.dir == Output {
                ports.push(id);
                continue;
            }
            if port.name != "clk" {
                single
                    .set_words(id, &inputs[at..at + port.words()])
                    .unwrap();
            }
            at += port.words();
        }
        single.tick(clock).unwrap();
        packed.cycle(clock, &inputs, &mut outputs).unwrap();
        let expected: Vec<u32> = ports
            .iter()
            .flat_map(|id| single.words(*id).unwrap())
            .collect();
        assert_eq!(outputs, expected, "round {round}");
    }
    let error = packed.cycle(clock, &[0; 3], &mut outputs).unwrap_err();
    assert!(matches!(error, Error::Packed { inputs: 3, .. }), "{error}");
}
