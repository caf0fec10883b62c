//! Effect of the batch size on the traffic of a field in several tables: `batch_sizes [SCENE]
//! [WIDTH] [SIDE]...` counts the renderer's traffic for several numbers of samples a ray in a
//! batch, for ray groups of SIDE pixels; the rule ([`BatchSize::of`]) comes last.

use std::path::Path;

use potamoi_fields::{BatchSize, Field, FixedField, FixedOptions};
use potamoi_formats::config::Config;
use potamoi_march::tiling::Halo;
use potamoi_reference::ReferenceUnits;
use potamoi_scene::characterise::sized_traffic;
use potamoi_scene::{Model, Scene};

const SAMPLES: [u32; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 32, 64];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let name = args.next().unwrap_or_else(|| "cairn:tensorf".to_owned());
    let width: u32 = args.next().map_or(Ok(200), |text| text.parse())?;
    let mut sides: Vec<u32> = args.map(|text| text.parse()).collect::<Result<_, _>>()?;
    if sides.is_empty() {
        sides = vec![16, 64, width];
    }
    if !(8..=2048).contains(&width) || sides.contains(&0) {
        return Err("expected a width of 8 to 2048 pixels, and groups of 1 or more".into());
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    let config = Config::read(&folder.join("../../configs/fields.toml"))?;
    let mut scene = Scene::open(&name)?;
    scene.set_size(Some(width), None)?;
    let field: &dyn Field = match scene.model() {
        Model::Field(field) => &**field,
        _ => return Err("expected a field in several tables".into()),
    };
    let camera = scene.camera();
    let made = FixedField::new(field, &config)?;
    let stops = made.stops(
        camera,
        &FixedOptions::default(),
        &mut ReferenceUnits::new(&config),
    )?;
    let count = |side: u32, size| {
        let found = sized_traffic(field, camera, &stops, &config, &[side], size);
        found.map(|rows| rows.into_iter().find(|t| t.halo != Some(Halo::Split)))
    };
    let of = |samples| BatchSize {
        samples,
        entries: usize::MAX,
    };
    println!("the rule: {:?}", BatchSize::of(made.tables()));
    println!("{name}, {width} wide");
    println!("group  samples  MVoxels  entries over  MVoxels in, MB  total, MB");
    for side in sides {
        // One sample a ray goes past no stop.
        let least = count(side, Some(of(1)))?.map_or(0, |t| t.entries);
        for samples in SAMPLES.map(Some).into_iter().chain([None]) {
            let Some(t) = count(side, samples.map(of))? else {
                continue;
            };
            println!(
                "{side:5}  {:>7}  {:7}  {:10.1} %  {:14.2}  {:9.2}",
                samples.map_or("rule".to_owned(), |s| s.to_string()),
                t.mvoxels,
                100.0 * (t.entries as f64 / least as f64 - 1.0),
                t.streams.mvoxels_read as f64 / 1e6,
                t.streams.total() as f64 / 1e6,
            );
        }
    }
    Ok(())
}
