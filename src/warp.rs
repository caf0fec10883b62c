//! `potamoi warp`: sparse radiance warping along a camera path.

mod measure;
mod picture;
mod report;
mod source;
mod timing;

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use potamoi_golden::warp::{
    Angle, Chain, Class, Counts, Frame, Plan, PlanOptions, Profile, ReferenceFrom, Rule, Sampling,
    Scope, Sequence, Target, WarpError, Warper, half_resolution,
};

use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::scene::SceneArgs;

use measure::{Footage, Measured};
use report::{Report, Variant};
use source::{DepthFrom, Source};
use timing::TimingArgs;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

#[derive(Debug, Args)]
pub(crate) struct WarpArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// How frames are made; several are shown side by side
    #[arg(long, value_enum, value_delimiter = ',', default_value = "sparw")]
    method: Vec<Method>,
    /// Targets of a reference; several are shown side by side
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "16")]
    window: Vec<u32>,
    /// Frames of the path; left out: three windows, or all that a file has
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Frames a second of an analytic scene's way
    #[arg(long, value_name = "F", default_value_t = 30.0)]
    fps: f64,
    /// Largest angle between the rays of reference and target at a point, in
    /// degrees; several are shown side by side; left out: none
    #[arg(long, value_name = "DEG", value_delimiter = ',')]
    phi: Vec<f64>,
    /// What a larger angle leads to
    #[arg(long, value_enum, default_value_t = PhiScope::Pixel)]
    phi_scope: PhiScope,
    /// Rules that belong together; the next options change one of them
    #[arg(long, value_enum, default_value_t = RulesOf::Potamoi)]
    profile: RulesOf,
    /// Which angle
    #[arg(long, value_enum)]
    angle: Option<AngleOf>,
    /// How colours are taken from a reference
    #[arg(long, value_enum)]
    sampling: Option<SamplingBy>,
    /// Whether pixels at edges of the reference are rendered
    #[arg(long, value_name = "true|false")]
    render_edges: Option<bool>,
    /// Whether points that are warped to where nothing is stay
    #[arg(long, value_name = "true|false")]
    keep_over_void: Option<bool>,
    /// A pixel is rendered where the depth there is below so much of the warped one; 0.995 unless
    /// given
    #[arg(long, value_name = "SHARE")]
    nearer: Option<f64>,
    /// From where references are taken; left out: predicted, of image sequences centre
    #[arg(long, value_enum)]
    reference: Option<From>,
    /// Frames before its window at which a reference is begun; left out: as many as the window
    /// has; 0: the paper's formula
    #[arg(long, value_name = "N")]
    lead: Option<u32>,
    /// Where depth is from: the model's rendering, what is known exactly, or the surface mesh of
    /// the model; left out: given for image sequences, model otherwise
    #[arg(long, value_enum)]
    depth: Option<DepthFrom>,
    /// Cells along the longest side of the mesh of a model's surface
    #[arg(long, value_name = "N", default_value_t = 256)]
    mesh_cells: u32,
    /// A mesh that depth is taken from (.obj, .ply)
    #[arg(long, value_name = "FILE", conflicts_with = "depth")]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    timing: TimingArgs,
    /// References that never arrive, from 0, as if a remote renderer lost them
    #[arg(long, value_name = "N", value_delimiter = ',')]
    lose: Vec<usize>,
    /// Folder for the frames, and for pictures of where their pixels come from
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Report as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Sparse radiance warping
    Sparw,
    /// Each frame warped from the one before
    Temp,
    /// Half the resolution, scaled up
    Ds2,
}

impl Method {
    const fn name(self) -> &'static str {
        match self {
            Self::Sparw => "SpaRW",
            Self::Temp => "Temp",
            Self::Ds2 => "DS-2",
        }
    }
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum PhiScope {
    /// The pixel is rendered
    Pixel,
    /// The frame is rendered
    Frame,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum RulesOf {
    /// Bilinear samples, and edges rendered
    Potamoi,
    /// Pixels as they land, and only what is hidden is rendered
    Paper,
    /// The same with the first authors' half-angle
    FirstAuthors,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum AngleOf {
    /// Between both rays at the point
    Subtended,
    /// Half of it, as the first authors' program has it
    Half,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum SamplingBy {
    /// Of the point that landed on the pixel, as the paper has it
    Nearest,
    /// Where the pixel's centre is in the reference, between neighbours of the same surface
    Bilinear,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum From {
    /// Predicted for the middle of the window
    Predicted,
    /// The window's first frame
    First,
    /// The frame nearest the window's middle
    Centre,
}

/// One way of making the frames.
#[derive(Debug, Clone, Copy)]
struct Way {
    method: Method,
    window: u32,
    /// In degrees.
    phi: Option<f64>,
}

pub(crate) fn run(args: &WarpArgs) -> Result<(), Failure> {
    files::prepare([args.json.as_ref(), args.timing.trace.as_ref()])?;
    let source = Source::open(&args.scene)?;
    let longest = args.window.iter().copied().max().unwrap_or(1);
    let path = source.path(args.fps, args.frames, 3 * longest)?;
    let ways = ways(args);
    if let Some(folder) = &args.out {
        if ways.len() != 1 {
            return Err(Failure::Usage(
                "--out: frames of one way are written: name one --method, --window and --phi"
                    .to_owned(),
            ));
        }
        files::prepare([Some(&folder.join("frame.0000.png"))])?;
    }
    args.timing.check()?;
    if args.timing.is_asked() && (ways.len() != 1 || ways[0].method != Method::Sparw) {
        return Err(Failure::Usage(
            "--frame-ms, --live: of one way: --method sparw, and one --window and --phi".to_owned(),
        ));
    }
    let depth = match (&args.mesh, args.depth) {
        (Some(_), _) => DepthFrom::Mesh,
        (None, depth) => depth.unwrap_or_else(|| source.usual_depth()),
    };
    let geometry = source.geometry(depth, args.mesh.as_deref(), args.mesh_cells)?;
    let rule = |way: &Way| Rule {
        phi: way.phi.map(f64::to_radians),
        ..args.rule()
    };
    for way in &ways {
        rule(way).check()?;
    }

    let start = Instant::now();
    let bar = progress::bar((path.len() * (ways.len() + 1)) as u64, "warping");
    let footage = Footage::new(&source, geometry.as_deref(), &path, &bar)?;
    let mut variants = vec![];
    for way in &ways {
        let warper = Warper {
            renderer: source.renderer(),
            geometry: geometry.as_deref(),
            rule: rule(way),
        };
        let plan = Plan::new(
            &path,
            &PlanOptions {
                window: way.window,
                reference: reference(args, &source),
                lead: args.lead,
            },
        )?;
        let begun = Instant::now();
        let mut measured = Measured::new(&footage);
        let mut counts = vec![];
        let mut take = |frame: &Frame| -> Result<(), Failure> {
            measured.add(frame);
            counts.push(Counts::of(&frame.target.classes, |_| true));
            if let Some(folder) = &args.out {
                picture::write(folder, frame)?;
            }
            bar.inc(1);
            Ok(())
        };
        let timing = &args.timing;
        let mut schedule = None;
        if timing.is_live() {
            let mut failed = None;
            let measured = timing.measure(warper, &path, &plan, &args.lose, |frame| {
                if failed.is_none() {
                    failed = take(&frame).err();
                }
            })?;
            if let Some(failure) = failed {
                return Err(failure);
            }
            schedule = Some(measured);
        } else {
            for frame in frames(way, warper, &path, &plan, &args.lose) {
                take(&frame?)?;
            }
        }
        if timing.is_scheduled() {
            let fps = source.is_timed().then_some(args.fps);
            schedule = Some(timing.schedule(&plan, &counts, &path[0], fps, &args.lose)?);
        }
        let seconds = begun.elapsed().as_secs_f64();
        let timed = schedule.map(|s| timing.done(&s)).transpose()?;
        variants.push(Variant::new(way, measured, &plan, &path, seconds, timed));
    }
    bar.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "warp",
        scene: source.name(),
        width: footage.size()[0],
        height: footage.size()[1],
        frames: path.len(),
        fps: source.is_timed().then_some(args.fps),
        depth: depth.name(),
        model: footage.quality(),
        variants,
        seconds: start.elapsed().as_secs_f64(),
    };
    report.print(args.timing.trace.as_ref());
    if let Some(folder) = &args.out {
        crate::say::say!("  frames and origins of their pixels: {}", folder.display());
    }
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}

impl WarpArgs {
    /// What decides, but for the angle's threshold.
    fn rule(&self) -> Rule {
        let base = match self.profile {
            RulesOf::Potamoi => Profile::Potamoi,
            RulesOf::Paper => Profile::Paper,
            RulesOf::FirstAuthors => Profile::FirstAuthors,
        }
        .rule();
        Rule {
            nearer: self.nearer.unwrap_or(base.nearer),
            phi: None,
            angle: match self.angle {
                Some(AngleOf::Subtended) => Angle::Subtended,
                Some(AngleOf::Half) => Angle::Half,
                None => base.angle,
            },
            scope: match self.phi_scope {
                PhiScope::Pixel => Scope::Pixel,
                PhiScope::Frame => Scope::Frame,
            },
            keep_over_void: self.keep_over_void.unwrap_or(base.keep_over_void),
            sampling: match self.sampling {
                Some(SamplingBy::Nearest) => Sampling::Nearest,
                Some(SamplingBy::Bilinear) => Sampling::Bilinear,
                None => base.sampling,
            },
            render_edges: self.render_edges.unwrap_or(base.render_edges),
        }
    }
}

/// All that were asked for, less those that do not differ.
fn ways(args: &WarpArgs) -> Vec<Way> {
    let mut ways = vec![];
    for method in &args.method {
        let phis: Vec<Option<f64>> = match method {
            Method::Sparw | Method::Temp if !args.phi.is_empty() => {
                args.phi.iter().copied().map(Some).collect()
            }
            _ => vec![None],
        };
        let windows = match method {
            Method::Ds2 => &args.window[..1],
            _ => &args.window[..],
        };
        for window in windows {
            ways.extend(phis.iter().map(|phi| Way {
                method: *method,
                window: *window,
                phi: *phi,
            }));
        }
    }
    ways
}

fn reference(args: &WarpArgs, source: &Source) -> ReferenceFrom {
    match args.reference {
        Some(From::Predicted) => ReferenceFrom::Predicted,
        Some(From::First) => ReferenceFrom::First,
        Some(From::Centre) => ReferenceFrom::Centre,
        None => source.usual_reference(),
    }
}

/// The frames of one way, one after another.
fn frames<'a>(
    way: &Way,
    warper: Warper<'a>,
    path: &'a [potamoi_golden::camera::Camera],
    plan: &'a Plan,
    lost: &'a [usize],
) -> Box<dyn Iterator<Item = Result<Frame, WarpError>> + 'a> {
    match way.method {
        Method::Sparw => Box::new(Sequence::new(warper, path, plan, lost)),
        Method::Temp => Box::new(Chain::new(warper, path, way.window)),
        Method::Ds2 => Box::new(path.iter().enumerate().map(move |(number, camera)| {
            let picture = half_resolution(warper.renderer, camera)?;
            let count = picture.rgb.len();
            Ok(Frame {
                number,
                reference: None,
                target: Target {
                    shaded: potamoi_golden::warp::Shaded {
                        picture,
                        depth: vec![f32::NAN; count],
                    },
                    classes: vec![Class::Full; count],
                },
            })
        })),
    }
}
