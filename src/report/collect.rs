//! What the commands of the page find, by the same studies.

use potamoi_analysis::Surroundings;
use potamoi_analysis::hard_cases::{measure, of_scene, pictures as hard_scenes};
use potamoi_base::effects::Choices;
use potamoi_explore::accuracy::{Bench, ImageQuality, Proof, References, Sweep, knobs};
use potamoi_explore::effects::EffectsStudy;
use potamoi_explore::rendering::{Numerics, shoot, whole_float};
use potamoi_explore::system::{Modelled, with_free_gpu};
use potamoi_explore::{ExploreError, Progress, Setup};
use potamoi_formats::config::Config;
use potamoi_machines::{Comparison, Machine, Row, WINDOW, Workload};
use potamoi_page::Images;
use potamoi_scene::Scene;
use potamoi_system::system_model::work::{PathOptions, PathParts};
use potamoi_system::system_model::{AtBounds, Outcome, Run, Scenario, Variant};
use serde_json::Value;

use super::asked::Asked;
use super::document::{
    Document, FORMAT_VERSION, Found, HardCases, IfFree, LibraryUsed, MachineFound, More, Pictures,
    Proved, SceneFound, SweepFound, UnitProved, VariantFound,
};
use super::pictures::{Difference, keep};
use super::{paper, plots, provenance};
use crate::failure::Failure;
use crate::scene::left_open_of_files;

/// The document as the page reads it, its pictures, and whether Verilog differs from its model.
pub(super) struct Collected {
    pub(super) document: Value,
    pub(super) images: Images,
    pub(super) differs: Option<String>,
    /// What was not verified, and why.
    pub(super) unverified: Vec<String>,
}

/// Runs all studies.
pub(super) fn collect(asked: &Asked<'_>, progress: &dyn Progress) -> Result<Collected, Failure> {
    let workload = Workload {
        frames: asked.frames,
        ..Workload::default()
    };
    let comparison = Comparison::of(asked.machines, asked.scenes, &workload, progress)?;
    let mut own = Collector {
        asked,
        progress,
        images: Images::new(),
        plots: [("compare".to_owned(), plots::comparison(&comparison))].into(),
        differs: None,
        unverified: vec![],
    };
    let mut scenes = vec![];
    for (at, scene) in asked.scenes.iter().enumerate() {
        scenes.push(own.scene(at, scene, &comparison.scenes[at])?);
    }
    let libraries = potamoi_plots::library::LIBRARIES.map(|own| LibraryUsed {
        name: own.name,
        version: own.version,
        licence: own.licence,
        sha256: own.sha256,
    });
    let document = Document {
        format_version: FORMAT_VERSION,
        command: "report",
        version: env!("CARGO_PKG_VERSION"),
        libraries: libraries.into(),
        provenance: provenance::of(asked, &scenes),
        workload,
        scenes,
        plots: own.plots,
        not_checked: left_open_of_files(),
    };
    let document = serde_json::to_value(&document);
    Ok(Collected {
        document: document.map_err(|error| Failure::Usage(format!("the report: {error}")))?,
        images: own.images,
        differs: own.differs,
        unverified: own.unverified,
    })
}

struct Collector<'a> {
    asked: &'a Asked<'a>,
    progress: &'a dyn Progress,
    images: Images,
    plots: std::collections::BTreeMap<String, Value>,
    differs: Option<String>,
    unverified: Vec<String>,
}

impl Collector<'_> {
    fn scene(&mut self, at: usize, scene: &Scene, rows: &[Row]) -> Result<SceneFound, Failure> {
        let varied = self.knobs(scene)?;
        let settings: usize = varied.iter().map(|own| own.settings.len()).sum();
        // Of accuracy, the default is a step, too.
        let steps = 5 + settings as u64 + 1;
        self.progress
            .expect(2 + steps * self.asked.machines.len() as u64);
        self.now(scene, "references");
        let references = References::of(scene)?;
        let float = whole_float(scene)?.picture;
        self.progress.advance(2);
        let picture = keep(
            &mut self.images,
            format!("s{at}-reference"),
            references.picture(),
        )?;
        let mut machines = vec![];
        for (number, (machine, figures)) in self.asked.machines.iter().zip(rows).enumerate() {
            let more = match figures.figures() {
                None => None,
                Some(_) => {
                    let id = format!("s{at}-m{number}");
                    let beside = (&references, &float);
                    Some(self.machine(&id, machine, scene, beside)?)
                }
            };
            machines.push(MachineFound {
                machine: machine.name.clone(),
                figures: figures.clone(),
                more,
            });
        }
        Ok(SceneFound {
            name: scene.name().to_owned(),
            algorithm: scene.model().algorithm(),
            size: [scene.camera().width, scene.camera().height],
            hash: potamoi_machines::quality::identity_of(scene).to_hex()[..12].to_owned(),
            reference: references.described(),
            reference_picture: picture,
            machines,
        })
    }

    fn now(&self, scene: &Scene, what: &str) {
        self.progress.now(&format!("{}: {what}", scene.name()));
    }

    fn machine(
        &mut self,
        id: &str,
        machine: &Machine,
        plain: &Scene,
        (references, float): (&References, &potamoi_base::picture::Picture),
    ) -> Result<More, Failure> {
        let mut scene = plain.clone();
        machine.prepare(&mut scene)?;
        let chosen = machine.hardware_for(&scene)?;
        self.now(&scene, "picture in the hardware's formats");
        let shown = shoot(&scene, &chosen.config, Numerics::Fixed)?
            .picture
            .picture;
        let pictures = self.pictures(id, &shown, references, float)?;
        self.progress.advance(1);
        self.now(&scene, "verifying the Verilog");
        let proof = self.proof(&scene, &chosen.config)?;
        if let Some(why) = proof.why() {
            let (scene, machine) = (scene.name(), &machine.name);
            self.unverified
                .push(format!("{scene} was not verified on {machine}: {why}"));
        }
        self.progress.advance(1);
        self.now(&scene, "effects");
        let effects = self.effects(machine, plain, &scene)?;
        self.progress.advance(1);
        self.now(&scene, "hard cases");
        let hard_cases = hard_cases(&scene, &chosen.config);
        self.progress.advance(1);
        let mut setup = Setup::new(chosen, &machine.system, scene, None)?;
        let (variants, modelled) = self.variants(machine, &mut setup)?;
        let [times, energies] = plots::variants(&variants);
        self.plots.insert(format!("{id}-time"), times);
        self.plots.insert(format!("{id}-energy"), energies);
        self.progress.advance(1);
        let (config, preset) = (setup.config.hash(), setup.preset);
        self.now(&setup.scene, "accuracy and time");
        let accuracy = self.accuracy(id, setup)?;
        Ok(More {
            preset,
            configuration: config,
            paper: paper::beside(&modelled),
            arxiv: paper::ARXIV,
            clock: modelled.clock,
            area: modelled.area,
            energy_origin: modelled.energy_origin,
            pictures,
            proof,
            variants,
            accuracy,
            effects,
            hard_cases,
        })
    }

    fn pictures(
        &mut self,
        id: &str,
        shown: &potamoi_base::picture::Picture,
        references: &References,
        float: &potamoi_base::picture::Picture,
    ) -> Result<Pictures, Failure> {
        let off = Difference::of(shown, references.picture());
        let images = &mut self.images;
        Ok(Pictures {
            float: keep(images, format!("{id}-float"), float)?,
            hardware: keep(images, format!("{id}-hardware"), shown)?,
            error: keep(images, format!("{id}-error"), &off.picture)?,
            scale: off.scale,
            largest: off.largest,
            beside_reference: ImageQuality::of(shown, references.picture()),
            beside_float: ImageQuality::of(shown, float),
        })
    }

    /// What was compared; a difference fails the command after the page is written.
    fn proof(&mut self, scene: &Scene, config: &Config) -> Result<Found<Proved>, Failure> {
        let proof = match Proof::of(config, scene, None, &()) {
            Ok(proof) => proof,
            Err(error) => {
                if matches!(error, ExploreError::Check(_)) {
                    self.differs.get_or_insert_with(|| error.told());
                }
                return unless_input(error);
            }
        };
        let unit = |unit, of, [compared, all]: [u64; 2]| UnitProved {
            unit,
            of,
            compared,
            all,
            share: (all > 0).then(|| compared as f64 / all as f64),
        };
        let mut units = vec![
            unit("gathering unit", "feature vectors", proof.vectors),
            unit(
                "vector unit",
                "elements of vector operations",
                proof.elements,
            ),
        ];
        if config.su.is_some() {
            units.push(unit("splat unit", "pixels", proof.pixels));
        }
        Ok(Found::Known(Proved {
            units,
            not_checked: scene.not_checked(config),
        }))
    }

    fn effects(
        &self,
        machine: &Machine,
        plain: &Scene,
        scene: &Scene,
    ) -> Result<Found<potamoi_explore::effects::Effects>, Failure> {
        let chosen = machine.hardware_for(scene)?;
        let path = plain.path(Workload::default().fps, self.asked.frames)?;
        let mut scene = scene.clone();
        if let Some(first) = path.first() {
            scene.set_camera(*first);
        }
        let study = EffectsStudy {
            scene: &scene,
            chosen: &chosen,
            path: &path,
            around: Surroundings { is_remote: false },
            choices: Choices::default(),
            // Wall times are no figures of the hardware, and differ from run to run.
            pairs: 0,
            rtl: false,
        };
        match study.run(&()) {
            Ok(found) => Ok(Found::Known(found)),
            Err(error) => unless_input(error),
        }
    }

    fn variants(
        &self,
        machine: &Machine,
        setup: &mut Setup,
    ) -> Result<(Vec<VariantFound>, Modelled), Failure> {
        let (system, path) = (&setup.system, &machine.path);
        let options = PathOptions {
            frames: self.asked.frames,
            fps: Workload::default().fps,
            window: path.window.unwrap_or(WINDOW),
            phi: path.phi,
            profile: path.profile.unwrap_or_default(),
            array: [system.array_rows.into(), system.array_columns.into()],
            is_double_buffered: system.array_double_buffered,
            cache: system.gpu.cache_bytes(),
            parts: PathParts::All,
        };
        let (counted, was_kept) = setup.count(&options, &Announced(self.progress))?;
        let cameras = setup.scene.path(options.fps, options.frames)?;
        let scenarios = [Scenario::Local];
        let all = &Variant::ALL;
        let (found, _) = Modelled::of((&counted, was_kept), setup, all, &scenarios, &cameras)?;
        let free = with_free_gpu(setup, &counted, all, Scenario::Local)?;
        let both = found.outcomes.iter().zip(&free);
        let variants = both.map(|(own, free)| variant(&found, own, free));
        Ok((variants.collect(), found))
    }

    /// The knobs that are varied.
    fn knobs(&self, scene: &Scene) -> Result<Vec<knobs::Knob>, Failure> {
        knobs::named(knobs::of(scene), self.asked.knobs)
            .map_err(|error| Failure::Usage(format!("--knobs {error}")))
    }

    fn accuracy(&mut self, id: &str, setup: Setup) -> Result<Found<SweepFound>, Failure> {
        let all = self.knobs(&setup.scene)?;
        let bench = Bench::new(setup, self.asked.frames)?;
        let sweep = match Sweep::of(&bench, &all, &Announced(self.progress)) {
            Ok(own) => own,
            Err(error) => return unless_input(error),
        };
        let mut names = vec![];
        for (beside, spec) in plots::accuracy(&sweep) {
            let name = format!("{id}-accuracy-{beside}");
            self.plots.insert(name.clone(), spec);
            names.push((beside, name));
        }
        Ok(Found::Known(SweepFound {
            frame_us: sweep.points.iter().map(|own| own.frame_ns * 1e-3).collect(),
            sweep,
            plots: names,
        }))
    }
}

/// The reason instead of a result where a tool is missing or a check has no result; other errors are
/// the command's.
fn unless_input<T>(error: ExploreError) -> Result<Found<T>, Failure> {
    match error.cause() {
        potamoi_explore::Cause::Input => Err(error.into()),
        _ => Ok(Found::unknown(error.told())),
    }
}

fn variant(found: &Modelled, own: &Outcome, free: &Outcome) -> VariantFound {
    let frame_ms = |own: &Outcome| own.run.map(|run| run.span_ns * 1e-6 / run.frames as f64);
    VariantFound {
        name: own.variant.name,
        frames_per_second: own.run.frames_per_second(),
        frame_ms: frame_ms(own),
        mj: own.run.total_mj(),
        full_db: own.float_quality.full_db,
        speed_up: found.speed_up(own),
        saving: found.saving(own),
        work_ms: work_ms(&own.run),
        parts_mj: parts_mj(&own.run),
        if_gpu_were_free: IfFree {
            frames_per_second: free.run.frames_per_second(),
            frame_ms: frame_ms(free),
            mj: free.run.total_mj(),
            work_ms: work_ms(&free.run),
            parts_mj: parts_mj(&free.run),
        },
    }
}

/// Milliseconds of work a frame, by resource and by channel.
fn work_ms(run: &AtBounds<Run>) -> Vec<(&'static str, f64)> {
    let at = |run: &Run| {
        let ms = run.span_ns * 1e-6 / run.frames as f64;
        let resources = run.demand.iter().map(|(of, share)| (of.name(), share * ms));
        let memory = [("memory", run.memory_utilisation * ms)];
        resources.chain(memory).collect::<Vec<_>>()
    };
    let both = at(&run.max).into_iter().zip(at(&run.sum));
    both.map(|((name, max), (_, sum))| (name, AtBounds { max, sum }.mid()))
        .collect()
}

fn parts_mj(run: &AtBounds<Run>) -> Vec<(&'static str, f64)> {
    let [max, sum] = [&run.max, &run.sum].map(|run| run.energy.named());
    let both = max.into_iter().zip(sum);
    both.filter_map(|((name, max), (_, sum))| {
        let both = AtBounds {
            max: max?,
            sum: sum?,
        };
        Some((name, both.mid()))
    })
    .collect()
}

/// Progress whose steps were announced before.
struct Announced<'a>(&'a dyn Progress);

impl Progress for Announced<'_> {
    fn expect(&self, _: u64) {}

    fn advance(&self, steps: u64) {
        self.0.advance(steps);
    }

    fn now(&self, what: &str) {
        self.0.now(what);
    }
}

/// Hard cases with the formats of a configuration, and on a scene.
fn hard_cases(scene: &Scene, config: &Config) -> HardCases {
    let (pictures, no_pictures) = match hard_scenes::shown(config) {
        Ok(shown) => (shown.into_iter().map(|own| own.check).collect(), None),
        Err(reason) => (vec![], Some(reason.to_string())),
    };
    let (checks, no_scene) = match of_scene(scene, config) {
        Ok(found) => (found.checks, None),
        Err(reason) => (vec![], Some(reason.to_string())),
    };
    HardCases {
        cases: measure(config),
        pictures,
        no_pictures,
        scene: checks,
        no_scene,
    }
}
