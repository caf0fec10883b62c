//! Gaussians of an analytic scene with their colours, as training data for models: `field_splats
//! SCENE FOLDER [DISCS] [VIEWS]` writes NumPy arrays into the folder.
//!
//! | file | type and shape | content |
//! |---|---|---|
//! | `mean`, `log_scale` | f32, N x 3 | centres in the world, logarithms of standard deviations |
//! | `rotation` | f32, N x 4 | unit quaternions, w first |
//! | `opacity` | f32, N | 0 to 1 |
//! | `eye` | f64, V x 3 | points of the scene's path |
//! | `colour` | f32, V x N x 3 | linear RGB, 0 to 1, of each centre seen from each point |

use std::path::Path;

use glam::DVec3;
use ndarray::{Array1, Array3, aview2};
use ndarray_npy::write_npy;
use potamoi_analytic::Analytic;
use potamoi_scene as scene;
use rayon::prelude::*;

type Failure = Box<dyn std::error::Error>;

/// Duration of the path in seconds.
const PATH: f64 = 10.0;

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let names = Analytic::ALL.map(Analytic::name).join(", ");
    let field = args.next().and_then(|name| Analytic::named(&name));
    let field = field.ok_or_else(|| format!("expected a scene: {names}"))?;
    let folder = args.next().ok_or("expected a folder to write to")?;
    let discs: u32 = args.next().map_or(Ok(72_000), |text| text.parse())?;
    let views: u32 = args.next().map_or(Ok(32), |text| text.parse())?;
    if !(1..=100).contains(&views) {
        return Err(format!("{views} views: expected 1 to 100").into());
    }

    let cloud = scene::laid_splats(field, discs)?;
    let folder = Path::new(&folder);
    std::fs::create_dir_all(folder)?;
    let file = |name: &str| folder.join(format!("{name}.npy"));
    write_npy(file("mean"), &aview2(cloud.means()))?;
    write_npy(file("log_scale"), &aview2(cloud.log_scales()))?;
    write_npy(file("rotation"), &aview2(cloud.rotations()))?;
    let logits = cloud.opacity_logits().iter();
    let opacities: Array1<f32> = logits.map(|l| 1.0 / (1.0 + (-l).exp())).collect();
    write_npy(file("opacity"), &opacities)?;

    let seconds = (0..views).map(|k| PATH * f64::from(k) / f64::from(views));
    let eyes: Vec<DVec3> = seconds.map(|s| field.camera(s, 8, 8).position()).collect();
    let corners: Vec<[f64; 3]> = eyes.iter().map(DVec3::to_array).collect();
    write_npy(file("eye"), &aview2(&corners))?;
    let centres: Vec<DVec3> = cloud
        .means()
        .iter()
        .map(|m| DVec3::from(m.map(f64::from)))
        .collect();
    let colours: Vec<f32> = eyes
        .par_iter()
        .flat_map_iter(|eye| {
            centres.iter().flat_map(move |at| {
                let direction = (*at - *eye).normalize_or(DVec3::X);
                let colour = field.look(*at).along(direction);
                colour.clamp(DVec3::ZERO, DVec3::ONE).as_vec3().to_array()
            })
        })
        .collect();
    let shape = [eyes.len(), centres.len(), 3];
    write_npy(file("colour"), &Array3::from_shape_vec(shape, colours)?)?;
    println!("{}: {} Gaussians", field.name(), centres.len());
    Ok(())
}
