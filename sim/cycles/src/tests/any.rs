//! Properties for random configurations, work and stalls.

use potamoi_formats::config::{Config, ExtraPorts, Organisation, rules};
use potamoi_formats::rit::Vertices;
use proptest::prelude::*;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::super::closed_form::{overlapped_cycles, rit_keeps_up};
use super::super::*;
use super::{config, ready};

fn any_config() -> impl Strategy<Value = Config> {
    (1u32..=8, 1u32..=12, 7u32..=12, 0usize..32, 0usize..6).prop_map(|(ports, rows, depth, width, kind)| {
        let row = 384 * ports;
        let widths: Vec<_> = (1..=row / 32)
            .map(|n| 32 * n)
            .filter(|w| row % w == 0)
            .collect();
        let stream = widths[width % widths.len()];
        let entries = ports * rows;
        let cells = "organisation = \"parity\"\nmodes = \"structured\"\nvertices = [8]";
        let (mvoxel, entry, kind) = match kind {
            0 => (64, "paper", ""),
            1 => (64, "paper", "pipelined = true"),
            2 => (64, "compact", ""),
            3 => (64, "compact", "pipelined = true"),
            4 => (512, "paper", cells),
            _ => (512, "compact", cells),
        };
        // The register behind the FIFO of a pipelined unit is one of its places.
        let depth = depth + u32::from(kind.starts_with("pipelined"));
        config(&format!(
            "[mvoxel]\nrows = {mvoxel}\n[rit]\nentry = \"{entry}\"\nentries = {entries}\nstream_bits = {stream}\n\
             [gu]\nports = {ports}\nfifo_depth = {depth}\n{kind}"
        ))
    })
}

fn any_mvoxels() -> impl Strategy<Value = Vec<(u32, u32, u32)>> {
    prop::collection::vec((0u32..6, 0u32..10_000, 1u32..=64), 1..14)
}

/// One of the built entry sizes.
fn one_of(config: &Config, which: usize) -> Vertices {
    let built = config.supported_vertices();
    built[which % built.len()]
}

/// Sizes below and above the capacity of one half and of both.
fn sized(config: &Config, vertices: Vertices, raw: &[(u32, u32, u32)]) -> Vec<Mvoxel> {
    let half = config.rit_entries(vertices);
    raw.iter()
        .map(|&(kind, entries, rows)| Mvoxel {
            entries: match kind {
                0 => 1 + entries % config.gu.ports,
                1 => half,
                2 => 2 * half,
                3 => 1 + entries % (2 * half),
                4 => 1 + entries % (5 * half),
                _ => 1 + entries % 30,
            },
            rows: if kind == 5 { 1 + rows % 4 } else { rows },
        })
        .collect()
}

fn any_stalls() -> impl Strategy<Value = Stalls> {
    let one = || {
        prop_oneof![
            Just(StreamStalls::NONE),
            (0u16..900, 1u16..6).prop_map(|(per_mille, burst)| StreamStalls { per_mille, burst }),
            (0u16..30, 20u16..90).prop_map(|(per_mille, burst)| StreamStalls { per_mille, burst }),
        ]
    };
    (one(), one(), one()).prop_map(|(rit, mft, sink)| Stalls { rit, mft, sink })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1500))]

    #[test]
    fn the_closed_form_of_turns_is_exact(
        mut config in any_config(), eight in any::<bool>(), which in 0usize..4, segments in 1u32..4,
        raw in prop::collection::vec((0u32..6, 0u32..500, 1u32..=64), 1..8), seed in any::<u64>(),
    ) {
        config.gu.ports = if eight { 8 } else { 4 };
        config.gu.extra_ports = ExtraPorts::Split;
        config.gu.organisation = Organisation::ChannelMajor;
        config.rit.entries = config.rit.entries.next_multiple_of(8);
        config.rit.stream_bits = None;
        prop_assume!(rules::check(&config).is_empty());
        let vertices = one_of(&config, which);
        let mvoxels = sized(&config, vertices, &raw);
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let parts = config.table_parts() as u16;
        let turns: Vec<Vec<Rounds>> = mvoxels
            .iter()
            .map(|m| {
                let groups = m.entries.div_ceil(config.gu.ports);
                (0..groups).map(|_| Rounds::default().map(|_| random.random_range(1..=parts))).collect()
            })
            .collect();
        let run = GatherRun { vertices, segments, mvoxels: &mvoxels };
        let work = SplitRun { run, turns: &turns };
        let log = run_split(&config, &work, &Stalls::NONE, 0).unwrap();
        let c = log.counters;
        let stepped = GatherCycles {
            fill: log.first_issue.unwrap(),
            busy: c.busy,
            stall_mft: c.stall_mft,
            stall_rit: c.stall_rit,
            stall_bank: c.stall_bank,
            elapsed: log.cycles,
        };
        prop_assert_eq!(split_cycles(&config, &work).unwrap(), stepped);
        prop_assert_eq!(c.stall_fifo, 0);
        prop_assert_eq!(gather_cycles(&config, &run).unwrap_err(), WorkError::Turns);
    }

    #[test]
    fn the_closed_form_is_exact(config in any_config(), which in 0usize..4, segments in 1u32..5, raw in any_mvoxels()) {
        let vertices = one_of(&config, which);
        let mvoxels = sized(&config, vertices, &raw);
        let run = GatherRun { vertices, segments, mvoxels: &mvoxels };
        let log = ready(&config, &run);
        let c = log.counters;
        let closed = gather_cycles(&config, &run).unwrap();
        let stepped = GatherCycles {
            fill: log.first_issue.unwrap(),
            busy: c.busy,
            stall_mft: c.stall_mft,
            stall_rit: c.stall_rit,
            stall_bank: 0,
            elapsed: log.cycles,
        };
        prop_assert_eq!(closed, stepped);
        prop_assert_eq!(c.stall_fifo, 0);
        prop_assert_eq!(c.busy, run.busy(&config));

        // The plain formula, within its stated error.
        let plain = overlapped_cycles(&config, &run);
        let first = u64::from(mvoxels[0].entries.min(config.gu.ports)) * config.entry_bytes(vertices) as u64;
        let fill = u64::from(config.rit_pipeline().cycles()) + first.div_ceil(u64::from(config.rit_stream_bits() / 8));
        let slack = fill.saturating_sub(u64::from(mvoxels[0].rows));
        prop_assert!(plain <= c.cycles() + slack, "{} {} {}", plain, c.cycles(), slack);
        if rit_keeps_up(&config, &run) {
            prop_assert_eq!(c.stall_rit, 0);
            prop_assert!(plain >= c.cycles());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Under any stalls: no deadlock, every group once and in order, every entry counted, no more
    /// groups in flight than the FIFO holds, and streams that obey AXI4-Stream.
    #[test]
    fn stalls_lose_nothing(config in any_config(), which in 0usize..4, segments in 1u32..4, raw in any_mvoxels(), stalls in any_stalls(), seed in any::<u64>()) {
        let vertices = one_of(&config, which);
        let mvoxels = sized(&config, vertices, &raw);
        let run = GatherRun { vertices, segments, mvoxels: &mvoxels };
        let ports = config.gu.ports;
        let mut expected = Vec::new();
        for m in &mvoxels {
            for _ in 0..segments {
                let groups = m.entries.div_ceil(ports);
                expected.extend((0..groups).map(|g| ((m.entries - g * ports).min(ports), g + 1 == groups)));
            }
        }
        let plan = Plan::new(seed, &stalls).unwrap();
        let mut waiting = None;
        let mut broken = Vec::new();
        let (mut next, mut fresh) = (0, true);
        let mut stall_cycles = 0;
        let mut issues = 0;
        let log = run_gather_watched(&config, &run, plan, |cycle, inputs, out| {
            if waiting.is_some() && waiting != out.feat {
                broken.push((cycle, "features change while they wait"));
            }
            waiting = out.feat.filter(|_| !inputs.feat_ready);
            if let Some(issue) = out.issue {
                issues += 1;
                if issue.vertex != next || issue.first != fresh {
                    broken.push((cycle, "vertices out of order"));
                }
                next = (issue.vertex + 1) % config.issue_cycles(vertices);
                fresh = issue.last;
            } else if next != 0 {
                broken.push((cycle, "a bubble within a group"));
            }
            stall_cycles += u64::from(out.stall.is_some());
        }).unwrap();
        prop_assert!(broken.is_empty(), "{:?}", broken);
        let groups: Vec<_> = log.groups.iter().map(|g| (g.kept, g.last)).collect();
        prop_assert_eq!(&groups, &expected);
        let entries: u64 = mvoxels.iter().map(|m| u64::from(m.entries)).sum();
        let c = log.counters;
        prop_assert_eq!(c.entries, entries * u64::from(segments));
        prop_assert_eq!(c.busy, run.busy(&config));
        prop_assert_eq!(c.busy, issues);
        prop_assert_eq!(c.cycles(), log.last_issue.unwrap() - log.first_issue.unwrap() + 1);
        // Idling after the last issue has a cause but is not counted.
        prop_assert!(c.cycles() - c.busy <= stall_cycles);
        for (i, g) in log.groups.iter().enumerate() {
            prop_assert!(g.accepted >= g.issued + u64::from(config.issue_cycles(vertices) + config.gather_pipeline().cycles()) - 1);
            if let Some(ahead) = log.groups.get(i + config.feature_fifo_depth() as usize) {
                prop_assert!(ahead.issued > g.accepted);
            }
        }
        // Never faster than with data and sink ready.
        prop_assert!(log.cycles >= gather_cycles(&config, &run).unwrap().elapsed);
        // Bounded: every beat, row and group may wait its own stalls, no more.
        let length = |s: &StreamStalls| u64::from(s.burst) * 1000 / u64::from(1000 - s.per_mille) + u64::from(s.burst) * 60;
        let worst = log.rit_beats * length(&stalls.rit) + log.mft_rows * length(&stalls.mft)
            + log.groups.len() as u64 * length(&stalls.sink) + c.busy + 20;
        prop_assert!(log.cycles <= worst);
    }
}

proptest! {
    #[test]
    fn the_vector_units_closed_form_is_exact(
        lanes in 1u32..9, pipelined in any::<bool>(), r in 1u32..21, tail in any::<bool>(),
        depth in 3u32..6, built in 0usize..3, form in 0usize..6, registered in any::<bool>(),
        work in prop::collection::vec((0usize..9, prop::collection::vec(any::<i32>(), 0..60), 0u32..32), 0..12),
    ) {
        use potamoi_formats::units::OpCode;
        let pipelined = pipelined && built != 2;
        let exp = match form {
            0 if built != 2 => "form = \"piecewise\"\npipelined = true".to_owned(),
            1 if built != 2 => "form = \"piecewise\"\npipelined = true\nbase = \"two\"".to_owned(),
            2 if built != 2 => format!(
                "form = \"radix-4\"\niterations = 4\npipelined = {pipelined}\niterations_per_clock = {}\ntail = {tail}",
                r.min(6)
            ),
            3 | 4 if built != 2 => format!("early_out = true\niterations_per_clock = {}", 1 + r % 6),
            _ => format!("pipelined = {pipelined}\niterations_per_clock = {r}\ntail = {tail}"),
        };
        let ops = ["", "ops = [\"pass\", \"relu\"]", "ops = [\"add\", \"exp\", \"sigmoid\", \"softplus\"]"][built];
        let registered = registered && built != 2 && !exp.contains("early_out");
        let config = config(&format!(
            "[vu]\nlanes = {lanes}\nfifo_depth = {depth}\nregistered = {registered}\n{ops}\n[vu.exp]\n{exp}"
        ));
        let exponents = Exponents::of(&config);
        let work: Vec<_> = work
            .into_iter()
            .map(|(op, a, shift)| (OpCode::ALL[op], a.into_iter().map(|a| a >> shift).collect::<Vec<_>>()))
            .collect();
        let vectors = work.iter().flat_map(|(op, a)| {
            let exponents = &exponents;
            a.chunks(lanes as usize).map(move |a| (op.code(), exponents.least(*op, a)))
        });
        let mut source = Source::new(vectors);
        let mut unit = VectorModel::new(&config).unwrap();
        let mut elapsed = 0;
        while !source.is_done() || !unit.is_idle() {
            let vector = source.offer(true).copied();
            let (op, exponent) = (vector.map(|v| v.0), vector.map_or(0, |v| v.1));
            let out = unit.step(&VectorInputs { op, exponent, ready: true });
            if op.is_some() && out.ready { source.accepted(); }
            prop_assert_eq!(out.stall_out, 0);
            elapsed += 1;
        }
        let last = unit.step(&VectorInputs::default());
        let stepped = VectorCycles { vectors: u64::from(last.vectors), busy: u64::from(last.busy), elapsed };
        let work: Vec<_> = work.iter().map(|(op, a)| (*op, a.as_slice())).collect();
        prop_assert_eq!(vector_cycles(&config, &work).unwrap(), stepped);
    }
}
