//! Mutants of every file that this crate reads, as `golden/scene/tests/mutants` tries those of scenes
//! and models.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

#[path = "../../../../golden/scene/tests/mutants/frame/mod.rs"]
mod frame;

use std::io::Write as _;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use flate2::Compression;
use flate2::write::GzEncoder;
use potamoi_formats::config::Config;
use potamoi_result_cache as result_cache;
use potamoi_scene::Scene;
use potamoi_synth::fit::Fit;
use potamoi_synth::grid::Grid;
use potamoi_synth::{Library, SynthReport, Synthesised, UnitKind};
use potamoi_system::system_model::work::FrameWork;
use potamoi_system::system_model::{
    Costs, Gathering, Memory, Model, OnChipSizes, Parameters, Program, System,
};

use frame::{Format, Rng, Verdict, text, tree};

const BINARY: &str = "-p potamoi-system --test mutants";

/// The system of the defaults, and a part of each kind.
const SYSTEM: &str = "memory_channels = 4\narray_rows = 24\narray_columns = 24\ngroups_in_flight = 4\n\
    feature_block_bytes = 4096\nfeature_buffer_bytes = 32768\nfeature_banks = 32\nfeature_block_banks = 32\n\
    interconnect_over_memory = 1.25\nlink_bytes_per_second = 1e7\ninterconnect_pj_per_byte = 0.5\n\
    [gpu]\ndevice = \"orin-nx\"\nidle_watts = 2.0\nshares_memory = true\n[remote]\ndevice = \"2080ti\"\nidle_watts = 15.0\n";

fn costs() -> &'static Costs {
    static COSTS: OnceLock<Costs> = OnceLock::new();
    COSTS.get_or_init(|| {
        let reports = Synthesised::checked_in().unwrap();
        let records = SynthReport::of_records().unwrap();
        let parameters = Parameters {
            given: None,
            system: &reports[0].report,
            reports: &reports,
            estimated: &[],
            records: &records,
            sizes: OnChipSizes::default(),
            wire_margin: 0.0,
        };
        let fit = Fit::checked_in().unwrap();
        Costs::new(&Config::paper(), Program::Fields, fit, &parameters).unwrap()
    })
}

/// A frame of 8 x 8 pixels.
fn work() -> &'static FrameWork {
    static WORK: OnceLock<FrameWork> = OnceLock::new();
    WORK.get_or_init(|| {
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(8), Some(8)).unwrap();
        let array = System::default().array();
        FrameWork::count(&scene, &Config::paper(), array, 1 << 16, None).unwrap()
    })
}

fn memory(channels: u32) -> &'static Memory {
    static ALL: [OnceLock<Memory>; 5] = [const { OnceLock::new() }; 5];
    ALL[channels.ilog2() as usize].get_or_init(|| Memory::with_channels(channels))
}

/// A frame takes some time and some energy.
fn system(path: &Path) -> Verdict {
    let text = match potamoi_base::files::read_text(path, 1 << 20) {
        Ok(text) => text,
        Err(error) => return Verdict::Refused(format!("{}: {error}", path.display())),
    };
    Verdict::of(
        System::from_toml(&text, &path.to_string_lossy()),
        |system| {
            let model = Model {
                system: &system,
                memory: memory(system.memory_channels),
                costs: costs(),
                clock_ghz: 1.0,
                weight_bytes: 1000,
                replay: None,
            };
            let run = model
                .frame(work(), Gathering::Unit)
                .map_err(|e| e.to_string())?;
            let energy = run.total_mj().ok_or("its energy is not known")?;
            let span = run.span_ns();
            let all = [("span", span), ("energy", energy)];
            for (what, value) in all.map(|(what, both)| (what, both.low())) {
                if !(value.is_finite() && value > 0.0) {
                    return Err(format!("its {what} is {value}"));
                }
            }
            Ok(())
        },
    )
}

fn synthesis(path: &Path) -> Verdict {
    Verdict::of(SynthReport::read(path), |report| {
        let areas = [UnitKind::Gathering, UnitKind::Vector].map(|unit| report.unit(unit));
        let sound = areas
            .into_iter()
            .flatten()
            .all(|unit| unit.area_um2 > 0.0 && unit.area_um2.is_finite());
        sound
            .then_some(())
            .ok_or_else(|| "an area is not positive".to_owned())
    })
}

/// What is fitted to a grid gives figures of a unit.
fn grid(path: &Path) -> Verdict {
    Verdict::of(Grid::read(path), |grid| {
        for point in &grid.points {
            let (area, energy) = (point.area_um2(), point.energy());
            if !(area > 0.0 && area.is_finite() && energy.iter().all(|e| e.is_finite() && *e > 0.0))
            {
                return Err(format!(
                    "point {} takes {area} and {energy:?}",
                    point.name()
                ));
            }
        }
        Ok(())
    })
}

fn library(path: &Path) -> Verdict {
    Verdict::of(Library::read(path), |library| {
        let sound = library
            .cells
            .values()
            .all(|cell| cell.area.is_finite() && cell.area >= 0.0);
        sound
            .then_some(())
            .ok_or_else(|| "a cell's area is no area".to_owned())
    })
}

/// What is kept is believed or made again; whatever is believed can be written again.
fn kept_work(path: &Path) -> Verdict {
    match result_cache::read::<FrameWork>(path) {
        None => Verdict::Refused(format!("{}: not believed", path.display())),
        Some(work) => Verdict::of(result_cache::write(path, &work), |()| {
            let again = result_cache::read::<FrameWork>(path);
            (again.as_ref() == Some(&work))
                .then_some(())
                .ok_or_else(|| "it is another when read again".to_owned())
        }),
    }
}

const LIBERTY: &str = include_str!("../../../synth/cells/handful.lib");
const SYNTHESIS: &[u8] = include_bytes!("../../../../synth/paper-asap7.json");
const GRID: &[u8] = include_bytes!("../../../../synth/grid-asap7.json");
const FORMS: &[u8] = include_bytes!("../../../../synth/forms-asap7.json");

fn mutated_liberty(rng: &mut Rng) -> Vec<u8> {
    let bytes = text::mutate(LIBERTY, rng);
    if !rng.one_in(4) {
        return bytes;
    }
    let mut out = GzEncoder::new(vec![], Compression::fast());
    out.write_all(&bytes).unwrap();
    out.finish().unwrap()
}

/// The name of the kept file.
const KEPT: &str = "k.json";

fn whole_kept() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    // Under the name that mutants have: another name's results are not believed.
    let path = folder.path().join(KEPT);
    result_cache::write(&path, work()).unwrap();
    std::fs::read(path).unwrap()
}

/// With a checksum that fits, as a forger would make it.
fn mutated_kept(rng: &mut Rng) -> Vec<u8> {
    static WHOLE: OnceLock<Vec<u8>> = OnceLock::new();
    let whole = WHOLE.get_or_init(whole_kept);
    let end = whole.iter().position(|b| *b == b'\n').unwrap();
    let body = tree::json(&whole[end + 1..], rng);
    let head = String::from_utf8_lossy(&whole[..end]).into_owned();
    let (rest, name) = head.rsplit_once(' ').unwrap();
    let (format, _) = rest.rsplit_once(' ').unwrap();
    let mut out = format!("{format} {} {name}\n", blake3::hash(&body).to_hex()).into_bytes();
    out.extend(body);
    if rng.one_in(12) {
        rng.damage(&mut out);
    }
    out
}

fn formats() -> Vec<Format> {
    type Mutant = fn(&mut Rng) -> Vec<u8>;
    let one = |name, file: &'static str, whole: fn() -> Vec<u8>, mutant: Mutant, judge| Format {
        name,
        binary: BINARY,
        whole: Arc::new(move || vec![(file.to_owned(), whole())]),
        mutant: Arc::new(move |rng| vec![(file.to_owned(), mutant(rng))]),
        judge,
    };
    vec![
        one(
            "system_toml",
            "s.toml",
            || SYSTEM.into(),
            |rng| tree::toml(SYSTEM, rng),
            system,
        ),
        one(
            "synthesis",
            "u.json",
            || SYNTHESIS.to_vec(),
            |rng| tree::json(SYNTHESIS, rng),
            synthesis,
        ),
        one(
            "grid",
            "g.json",
            || GRID.to_vec(),
            |rng| tree::json(GRID, rng),
            grid,
        ),
        one(
            "forms",
            "f.json",
            || FORMS.to_vec(),
            |rng| tree::json(FORMS, rng),
            grid,
        ),
        one(
            "liberty",
            "c.lib",
            || LIBERTY.into(),
            mutated_liberty,
            library,
        ),
        one("kept_work", KEPT, whole_kept, mutated_kept, kept_work),
    ]
}

frame::tests! { system_toml, synthesis, grid, forms, liberty, kept_work }
