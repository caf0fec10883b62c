//! PSNR of a model of an analytic scene, an Instant-NGP snapshot or (`.npz`) a Compact-3DGS model,
//! against the scene's ground truth: `model_psnr SCENE FILE [SIDE] [PNG]` renders both, prints the
//! PSNR in decibels of linear RGB over the frame, and writes them side by side.

use std::path::Path;

use potamoi_analytic::Analytic;
use potamoi_base::picture::Picture;
use potamoi_fields::algorithms::ngp::Ngp;
use potamoi_fields::render_float;
use potamoi_scene::compact_3dgs::{self, Compact};
use potamoi_splats::{self as splats, Profile};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let names = Analytic::ALL.map(Analytic::name).join(", ");
    let scene = args.next().and_then(|name| Analytic::named(&name));
    let scene = scene.ok_or_else(|| format!("expected a scene: {names}"))?;
    let file = args
        .next()
        .ok_or("expected an .ingp, .msgpack or .npz file")?;
    let side: u32 = args.next().map_or(Ok(200), |text| text.parse())?;
    if !(8..=2048).contains(&side) {
        return Err(format!("side {side}: expected 8 to 2048 pixels").into());
    }
    let file = Path::new(&file);
    let camera = scene.camera(0.0, side, side);
    let truth = scene.truth(&camera, scene.background()).picture;
    let shown = if file.extension().is_some_and(|e| e == compact_3dgs::ENDING) {
        let seen = Compact::load(file, None)?.0.seen_from(camera.position());
        let options = splats::FloatOptions {
            background: scene.background(),
            ..splats::FloatOptions::default()
        };
        splats::render_float(&seen, &camera, Profile::Inria, &options)?.picture
    } else {
        render_float(&Ngp::load(file)?, &camera, scene.background())?.picture
    };
    let psnr = truth.psnr(&shown, |_| true);
    println!("{:.2}", psnr.ok_or("pictures of different sizes")?);
    if let Some(path) = args.next() {
        let mut both = Picture::filled(2 * side, side, [0.0; 3]);
        let rows = |p: &'_ Picture| {
            p.rgb
                .chunks_exact(side as usize)
                .map(<[_]>::to_vec)
                .collect::<Vec<_>>()
        };
        for ((to, a), b) in both
            .rgb
            .chunks_exact_mut(2 * side as usize)
            .zip(rows(&truth))
            .zip(rows(&shown))
        {
            to[..side as usize].copy_from_slice(&a);
            to[side as usize..].copy_from_slice(&b);
        }
        both.write_png(Path::new(&path))?;
    }
    Ok(())
}
