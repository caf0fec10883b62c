//! Cycles of fixed jobs, as they were: a unit that takes one cycle more fails.
//!
//! The jobs are those of the benches beside the Verilog, without pauses. The benches compare the same
//! cycles with those of the Verilog.

use std::fmt::Write as _;
use std::path::Path;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_rtl::bench::job_cycles;

const AGAIN: &str = "POTAMOI_REFRESH=1 cargo test -p potamoi-rtl --test rtl cycle_budget";

#[test]
fn no_job_takes_more_cycles_than_its_budget() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/rtl/cycle_budget.tsv");
    let mut made = "preset\tunit\tjob\tcontent\tcycles\n".to_owned();
    for (preset, _) in PRESETS {
        let jobs = job_cycles(&Config::preset(preset).unwrap()).unwrap();
        for (i, job) in jobs.iter().enumerate() {
            let (unit, title, cycles) = (job.unit, &job.title, job.cycles);
            writeln!(made, "{preset}\t{unit}\t{i}\t{title}\t{cycles}").unwrap();
        }
    }
    if std::env::var_os("POTAMOI_REFRESH").is_some() {
        return std::fs::write(&path, made).unwrap();
    }
    let kept = std::fs::read_to_string(&path).unwrap();
    let split = |line: &str| {
        let (job, cycles) = line.rsplit_once('\t')?;
        Some((job.to_owned(), cycles.parse::<u64>().ok()?))
    };
    let (mut slower, mut others) = (vec![], vec![]);
    for (was, is) in kept.lines().zip(made.lines()).skip(1) {
        match (split(was), split(is)) {
            (Some((a, before)), Some((b, now))) if a == b && now > before => {
                slower.push(format!("{a}: {now} cycles, budget {before}"));
            }
            _ if was != is => others.push(format!("{is}, before {was}")),
            _ => {}
        }
    }
    let (slow, other) = (slower.join("\n"), others.join("\n"));
    assert!(
        slower.is_empty(),
        "jobs that take longer than their budget:\n{slow}"
    );
    assert!(
        kept == made,
        "jobs are others, or faster: write the new budget and review it: {AGAIN}\n{other}"
    );
}
