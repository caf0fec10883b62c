//! `potamoi sweep`: every point of a plan.

mod dask;
mod front;
mod table;

use std::collections::HashSet;
use std::io::Write as _;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::thread;
use std::time::Instant;

use clap::{Args, ValueEnum};
use potamoi_base::outputs as files;
use potamoi_machines::Workload;
use potamoi_machines::cells::COLUMNS;
use potamoi_machines::sweep::{
    Plan, Rows, SweepError, SweepRow, Swept, better, changes, program, setting,
};
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Serialize;
use serde_json::{Map, Value};

use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::reasons::reasons;
use crate::report_files::ReportFiles;
use crate::scene::{left_open_of_files, note, say_not_checked};
use crate::stdout::{self, prose, say};
use crate::suggest;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "sweep",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};
/// Name of the rows in the folder of a sweep.
const ROWS: &str = "rows.csv";

#[derive(Debug, Args)]
pub(crate) struct SweepArgs {
    /// Plan as TOML: machines, scenes, and the fields that vary
    #[arg(value_name = "PLAN")]
    plan: PathBuf,
    /// Folder for the rows of all points; the same command goes on where it was interrupted [default:
    /// required, but for --points]
    #[arg(long, value_name = "DIR", required_unless_present = "points")]
    work_dir: Option<PathBuf>,
    /// Engine that does the work: a simulator of the hardware, or what the points of a sweep are
    /// spread over
    #[arg(long, value_enum, default_value_t = Engine::Threads)]
    engine: Engine,
    /// Scheduler of --engine dask: tls://HOST:PORT, or tcp://HOST:PORT on this machine alone
    /// [default: none]
    #[arg(long, value_name = "ADDRESS", required_if_eq("engine", "dask"))]
    scheduler: Option<String>,
    /// Print the points that the folder lacks as JSON, one a line: number, key, and the files of
    /// counted work that it uses; nothing is evaluated
    #[arg(long, conflicts_with_all = ["points", "front", "beside", "json", "csv_dir", "scheduler"])]
    missing: bool,
    /// Points to evaluate by number, whose lines of the journal are printed; no folder is read or
    /// written [default: all that the folder lacks]
    #[arg(long, value_name = "N,...", value_delimiter = ',',
          conflicts_with_all = ["work_dir", "front", "beside", "json", "csv_dir", "scheduler"])]
    points: Vec<usize>,
    /// Columns of a front, such as fps,mm2,psnr_db: rows that no other row is better than in one of them
    /// and at least as good as in the others [default: no front]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    front: Vec<String>,
    /// Folder of another sweep, whose figures are compared at the same points [default: none]
    #[arg(long, value_name = "DIR")]
    beside: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Engine {
    /// Threads of this process
    Threads,
    /// Workers of Dask distributed, through the Python package
    Dask,
}

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    program: String,
    workload: &'a Workload,
    /// A row each point: its key, the varied fields, the figures, which may be null, the reason of a
    /// refusal, and with `--front` whether it is on it.
    #[schemars(schema_with = "rows_schema")]
    rows: Vec<Map<String, Value>>,
    /// Items that scenes' files leave open.
    not_checked: Vec<String>,
}

pub(crate) fn run(args: &SweepArgs) -> Result<(), Failure> {
    if let Some(folder) = args.work_dir.as_ref().filter(|own| own.is_file()) {
        return Err(Failure::Usage(format!(
            "--work-dir {}: it is a file: name a folder for the rows; the plan stands before it, as in potamoi \
             sweep PLAN --work-dir DIR",
            folder.display()
        )));
    }
    match &args.work_dir {
        None => evaluate(&Plan::read(&args.plan)?, &args.points),
        Some(folder) if args.missing => missing(&Plan::read(&args.plan)?, folder),
        Some(folder) => sweep(args, folder),
    }
}

fn sweep(args: &SweepArgs, folder: &Path) -> Result<(), Failure> {
    args.files.prepare([])?;
    for name in &args.front {
        better(name).map_err(|error| misspelt(error, name))?;
    }
    let before = args
        .beside
        .as_ref()
        .map(|folder| Rows::read(&folder.join(ROWS)));
    let before = before.transpose()?;
    let plan = Plan::read(&args.plan)?;
    let path = folder.join(ROWS);
    let earlier = earlier(&path)?;
    plan.scenes.iter().for_each(note);
    say_counted_anew(&plan);
    let begun = Instant::now();
    let bar = progress::bar(0, "sweeping");
    let swept = match (args.engine, &args.scheduler) {
        (Engine::Dask, Some(own)) => dask::run(&plan, &args.plan, folder, own, &Shown(&bar))?,
        (Engine::Dask, None) => return Err(Failure::Usage(SCHEDULER.to_owned())),
        (Engine::Threads, Some(_)) => return Err(Failure::Usage(ENGINE.to_owned())),
        (Engine::Threads, None) => plan.run(folder, &Shown(&bar))?,
    };
    bar.finish_and_clear();
    let rows = &swept.rows;
    if let Some(earlier) = &earlier {
        remark_replaced(&path, earlier, rows);
    }
    let text = rows.csv();
    let text = text.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
    files::write(&path, &text)?;
    summary(&swept, begun.elapsed().as_secs_f64());
    say!("rows: {}", path.display());
    let on = front::on_front(rows, &args.front)?;
    if let Some(on) = &on {
        table::front(rows, on, &args.front);
        front::say_out_of_reach(rows);
        front::say_unknown(rows, &args.front, &plan.workload);
    }
    if let Some(before) = &before {
        table::changes(&changes(rows, before));
    }
    let not_checked = left_open_of_files();
    say_not_checked(&not_checked);
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "sweep",
            program: program(),
            workload: &plan.workload,
            rows: as_json(rows, on.as_deref()),
            not_checked,
        };
        args.files.write(&report)?;
    }
    match rows.rows.iter().all(|row| row.refused.is_some()) {
        true => Err(Failure::Usage(format!(
            "{}: no point has figures: change the plan as the reasons above say",
            args.plan.display()
        ))),
        false => Ok(()),
    }
}

/// Says for which fields the frames of a scene are counted more than once.
fn say_counted_anew(plan: &Plan) {
    let fields = plan.counted_anew();
    if !fields.is_empty() {
        prose!(
            0,
            "counted again for each value of {}: the work of a frame or its rates in memory depend on it",
            fields.join(", ")
        );
    }
}

/// The refusal of a column, with the nearest one.
fn misspelt(error: SweepError, name: &str) -> Failure {
    match suggest::nearest(name, COLUMNS.iter().map(|own| own.name)) {
        Some(near) if better(near).is_ok() => {
            Failure::Usage(format!("{error}; did you mean `{near}`?"))
        }
        _ => error.into(),
    }
}

/// What --engine and --scheduler need of one another.
const SCHEDULER: &str =
    "--engine dask: expected --scheduler tls://HOST:PORT or tcp://127.0.0.1:PORT";
const ENGINE: &str = "--scheduler: expected --engine dask beside it; threads need no scheduler";

/// The rows that a folder has from before.
///
/// # Errors
/// The file is no table of a sweep, which would be lost.
fn earlier(path: &Path) -> Result<Option<Rows>, Failure> {
    if path.symlink_metadata().is_err() {
        return Ok(None);
    }
    let path = path.to_owned();
    Ok(Some(
        Rows::read(&path).map_err(|_| SweepError::Taken { path })?,
    ))
}

/// Says that the rows of another plan go, and where they still are.
fn remark_replaced(path: &Path, earlier: &Rows, rows: &Rows) {
    let own: HashSet<&str> = rows.rows.iter().map(|row| &*row.key).collect();
    let gone = earlier.rows.iter().filter(|row| !own.contains(&*row.key));
    let gone = gone.count();
    if gone > 0 {
        stdout::remark(format_args!(
            "{} had {gone} row{} of another plan, and now has this one's; the journal beside it keeps both: \
             the same command with the other plan writes its rows again",
            path.display(),
            if gone == 1 { "" } else { "s" }
        ));
    }
}

/// Prints what a folder lacks.
fn missing(plan: &Plan, folder: &Path) -> Result<(), Failure> {
    let missing = plan.session(folder)?.missing();
    if missing.is_empty() {
        stdout::remark(format_args!(
            "{} lacks no point of {}: nothing is to be evaluated",
            folder.display(),
            plan.name
        ));
    }
    for point in missing {
        let text = serde_json::to_string(&point);
        say!(
            "{}",
            text.map_err(|error| Failure::Output(error.to_string()))?
        );
    }
    Ok(())
}

/// Prints the lines of points. Where nobody reads them any more, the rest is not evaluated.
fn evaluate(plan: &Plan, points: &[usize]) -> Result<(), Failure> {
    let all = thread::available_parallelism().map_or(1, NonZero::get);
    let asked = std::env::var("RAYON_NUM_THREADS").ok();
    let asked = asked
        .and_then(|own| own.parse().ok())
        .filter(|own| *own > 0);
    let print = |line: &str| writeln!(std::io::stdout().lock(), "{line}").is_ok();
    Ok(plan.evaluate(points, all.min(asked.unwrap_or(all)), &print)?)
}

fn summary(swept: &Swept, seconds: f64) {
    let rows = &swept.rows.rows;
    let refused = rows.iter().filter(|row| row.refused.is_some()).count();
    let each = match swept.evaluated {
        0 => String::new(),
        count => format!(", {:.2} ms each", 1e3 * seconds / count as f64),
    };
    prose!(
        0,
        "{} point{}: {} evaluated now in {seconds:.1} s{each}, {} read from the journal, {refused} without \
         figures",
        rows.len(),
        if rows.len() == 1 { "" } else { "s" },
        swept.evaluated,
        swept.resumed
    );
    let reasons = reasons(rows.iter().filter_map(|row| row.refused.as_deref()));
    for own in reasons.iter().take(SHOWN) {
        prose!(2, "{} without figures: {}", own.points, own.words());
    }
    if let Some(more) = reasons.len().checked_sub(SHOWN).filter(|more| *more > 0) {
        say!("  and {more} more reasons, in the column `refused`");
    }
}

/// Reasons of refusals that are printed.
const SHOWN: usize = 3;

/// The schema of [`as_json`], whose keys depend on the plan.
fn rows_schema(_: &mut SchemaGenerator) -> Schema {
    json_schema!({
        "type": "array",
        "items": {
            "type": "object",
            "additionalProperties": { "type": ["string", "number", "boolean", "null"] },
            "required": ["key", "machine", "refused"],
        },
    })
}

/// Rows as objects; an unknown figure is null.
fn as_json(rows: &Rows, on: Option<&[bool]>) -> Vec<Map<String, Value>> {
    let of = |(at, row): (usize, &SweepRow)| {
        let mut own = Map::new();
        own.insert("key".to_owned(), row.key.clone().into());
        for (field, value) in rows.fields.iter().zip(&row.setting) {
            own.insert(setting(field), value.clone().into());
        }
        for (column, cell) in COLUMNS.iter().zip(&row.cells) {
            let value = serde_json::to_value(cell).unwrap_or_default();
            own.insert(column.name.to_owned(), value);
        }
        own.insert("refused".to_owned(), row.refused.clone().into());
        if let Some(on) = on {
            own.insert("on_front".to_owned(), on.get(at).copied().into());
        }
        own
    };
    rows.rows.iter().enumerate().map(of).collect()
}
