//! Pictures made of samples as frames of the system: rendered as scenes, counted, and modelled on every
//! variant, at home and afar.

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_scene::{Model as Shown, Scene};
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthReport, Synthesised};
use potamoi_system::system_model::work::{FrameWork, PathOptions, PathParts, PathWork};
use potamoi_system::system_model::{
    Costs, Gathering, Memory, Model, OnChipSizes, Parameters, Program, Scenario, System, Variant,
};
use potamoi_warp::Profile;

use super::system::sound;
use super::{fields, fog, voxels};

/// A picture, and what shows it.
#[derive(Clone)]
pub(crate) struct Case {
    pub(crate) name: &'static str,
    pub(crate) model: Shown,
    pub(crate) camera: Camera,
    pub(crate) config: Config,
    /// In voxel edges, where it is not the model's own.
    pub(crate) step: Option<f64>,
    /// As the twins render it without a scene.
    pub(crate) picture: Picture,
}

const CACHE: u32 = 512 << 10;

/// The same work takes time, energy and bytes on every variant, and no number is below zero or none.
#[test]
fn pictures_of_samples_are_modelled() {
    let (memory, system) = (Memory::with_channels(4), System::default());
    let reports = Synthesised::checked_in().unwrap();
    let records = SynthReport::of_records().unwrap();
    for case in [fog::cases(), fields::cases(), voxels::cases()].concat() {
        let name = case.name;
        let mut scene = Scene::of(name, case.model, case.camera, DVec3::Y, [0.0; 3]);
        case.step
            .into_iter()
            .for_each(|step| scene.set_step(step).unwrap());
        let config = &case.config;
        let mut twins = ReferenceUnits::new(config);
        let counted =
            FrameWork::rendered(&scene, config, MacArray::PAPER, CACHE, None, &mut twins).unwrap();
        assert_eq!(counted.rendered.picture, case.picture, "{name}");
        let options = PathOptions {
            frames: 3,
            fps: 1000.0,
            window: 2,
            phi: Some(4.0),
            profile: Profile::Potamoi,
            array: [24, 24],
            is_double_buffered: false,
            cache: CACHE,
            parts: PathParts::All,
        };
        let path = PathWork::count(&scene, config, &options, &|| ()).unwrap();
        assert_eq!(path.references[0], counted.work, "{name}");
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
        let costs = Costs::new(config, Program::Fields, fit, &parameters);
        let model = Model {
            system: &system,
            memory: &memory,
            costs: &costs.unwrap(),
            clock_ghz: 1.0,
            weight_bytes: 40_000,
            replay: None,
        };
        let gatherings = [Gathering::PixelOrder, Gathering::Streamed, Gathering::Unit];
        for gathering in gatherings {
            let run = model.frame(&counted.work, gathering).unwrap().sum;
            assert!(
                run.span_ns > 0.0 && run.span_ns < 1e9,
                "{name}: {}",
                run.span_ns
            );
            assert_eq!(run.spent.done, counted.work.total());
        }
        for variant in Variant::ALL {
            for scenario in [Scenario::Local, Scenario::Remote] {
                let run = model.run(&path, variant, scenario).unwrap().0.run.sum;
                let at = format!("{name} {} {scenario:?}", variant.name);
                assert!(
                    run.span_ns > 0.0 && run.span_ns < 1e9,
                    "{at}: {}",
                    run.span_ns
                );
                for part in [
                    serde_json::to_value(run.energy),
                    serde_json::to_value(&run.stages),
                    serde_json::to_value(&run.utilisation),
                    serde_json::to_value(run.spent),
                ] {
                    assert!(sound(&part.unwrap(), &at) > 0, "{at}");
                }
            }
        }
    }
}
