//! Shifts by amounts of any width mean the same to the interpreter, to Verilator
//! and to plain integers: amounts wider than 64 bits are where Verilator 5.006
//! goes wrong if they are printed as they are.

use num_bigint::BigUint;
use potamoi_netlist::{Header, Interpreter, ModuleBuilder, Ty, verilog};
use potamoi_verilated::{ModelBuilder, Opt, Toolchain};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

const VALUES: [u32; 14] = [1, 2, 31, 32, 33, 63, 64, 65, 96, 127, 129, 511, 513, 1024];
const AMOUNTS: [u32; 11] = [1, 5, 7, 31, 32, 33, 63, 64, 65, 96, 130];

#[test]
fn shifts_by_amounts_of_any_width() {
    let mut m = ModuleBuilder::new("shifts");
    let amounts = AMOUNTS.map(|w| m.input(&format!("n{w}"), Ty::u(w), ""));
    let mut outputs = vec![];
    for w in VALUES {
        let unsigned = m.input(&format!("a{w}"), Ty::u(w), "");
        let signed = m.as_signed(unsigned);
        for (n, width) in amounts.iter().zip(AMOUNTS) {
            let shifted = [
                ("shl", m.shl(unsigned, *n)),
                ("shr", m.shr(unsigned, *n)),
                ("sra", m.shr(signed, *n)),
            ];
            for (kind, s) in shifted {
                let name = format!("{kind}_{w}_{width}");
                let s = m.as_unsigned(s);
                m.output(&name, s, "");
                outputs.push((name, w));
            }
        }
    }
    let module = m.finish().unwrap();
    let tools = Toolchain::detect().expect("Verilator and a C++ compiler");
    let mut builder = ModelBuilder::new("shifts")
        .optimise(Opt::O0)
        .cache_dir(concat!(env!("CARGO_TARGET_TMPDIR"), "/models"));
    for (file, text) in verilog(&module, &Header::default()) {
        builder = builder.source(file, text);
    }
    let mut model = builder.build(&tools).unwrap().model(1).unwrap();
    let mut unit = Interpreter::new(&module, 1);
    let seed = std::env::var("POTAMOI_SEED").map_or(1, |s| s.parse().unwrap());
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut wrong = std::collections::BTreeMap::new();
    for round in 0..400 {
        let mut set = |name: &str, width: u32, small: bool| {
            let mut words: Vec<u32> = (0..width.div_ceil(32)).map(|_| random.random()).collect();
            if small {
                // Amounts about the values' widths, and multiples of 2^32.
                words.fill(0);
                words[0] = random.random_range(0..1100);
                if random.random_range(0..4) == 0 {
                    words[0] &= 0xff;
                    let last = words.len() - 1;
                    words[last] |= 1 << random.random_range(0..32);
                }
            }
            if !width.is_multiple_of(32) {
                *words.last_mut().unwrap() &= (1 << (width % 32)) - 1;
            }
            model.set_words(model.port(name).unwrap(), &words).unwrap();
            let port = unit.port(name).unwrap();
            unit.set_words(port, &words).unwrap();
        };
        for w in AMOUNTS {
            set(&format!("n{w}"), w, round % 8 != 0);
        }
        for w in VALUES {
            set(&format!("a{w}"), w, false);
        }
        model.eval().unwrap();
        unit.eval().unwrap();
        let read = |name: String| BigUint::new(unit.words(unit.port(&name).unwrap()).unwrap());
        for (name, width) in &outputs {
            let found = model.words(model.port(name).unwrap()).unwrap();
            let interpreted = unit.words(unit.port(name).unwrap()).unwrap();
            let amount = read(format!("n{}", name.rsplit('_').next().unwrap()));
            let by = u32::try_from(amount).unwrap_or(u32::MAX).min(*width);
            let value = read(format!("a{width}"));
            let all = (BigUint::from(1u32) << *width) - 1u32;
            let exact = match &name[..3] {
                "shl" => (value << by) & &all,
                "shr" => value >> by,
                _ if value.bit(u64::from(*width) - 1) => (value >> by) | (&all ^ (&all >> by)),
                _ => value >> by,
            };
            if found != interpreted || BigUint::new(found) != exact {
                *wrong.entry(name.clone()).or_insert(0) += 1;
            }
        }
    }
    assert!(
        wrong.is_empty(),
        "{wrong:?}\nrun it again with: POTAMOI_SEED={seed} cargo test -p potamoi-netlist --test netlist shifts::"
    );
}
