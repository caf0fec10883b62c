#![allow(clippy::unwrap_used)]
use potamoi_formats::config::Config;
use potamoi_golden::scene::lantern;
use potamoi_golden::units::Twins;
use potamoi_golden::voxels::*;
use std::time::Instant;
fn main() {
    let a: Vec<String> = std::env::args().collect();
    let w: u32 = a[1].parse().unwrap();
    let h: u32 = a[2].parse().unwrap();
    let t = Instant::now();
    let grid = lantern::lantern().unwrap();
    eprintln!("bake {:?}", t.elapsed());
    let camera = lantern::camera(w, h);
    let t = Instant::now();
    let f = render_float(
        &grid,
        &camera,
        &FloatOptions {
            background: lantern::BACKGROUND,
            ..Default::default()
        },
    )
    .unwrap();
    eprintln!("float {:?} samples {}", t.elapsed(), f.samples);
    f.picture
        .write_png(std::path::Path::new("/tmp/vox_float.png"))
        .unwrap();
    let config = Config::paper();
    let t = Instant::now();
    let mv = MVoxels::new(&grid, &config).unwrap();
    eprintln!(
        "mvoxels {:?} {:?} dup {} {:?}",
        t.elapsed(),
        mv.counts(),
        mv.duplication(),
        mv.formats()
    );
    let t = Instant::now();
    let mut units = Twins::new(&config);
    let x = render_fixed(
        &grid,
        &mv,
        &camera,
        &FixedOptions {
            background: lantern::BACKGROUND,
            ..Default::default()
        },
        &mut units,
    )
    .unwrap();
    eprintln!("fixed {:?} {:#?}", t.elapsed(), x.stats);
    x.picture
        .write_png(std::path::Path::new("/tmp/vox_fixed.png"))
        .unwrap();
    eprintln!(
        "psnr {:?} flags {}",
        x.picture.psnr(&f.picture, |_| true),
        units.gather_flags()
    );
    eprintln!(
        "psnr covered {:?}",
        x.picture.psnr(&f.picture, |i| f.transmittance[i] < 0.999)
    );
    let occupied = (0..mv.counts().iter().product())
        .filter(|m| mv.is_occupied(*m))
        .count();
    eprintln!("occupied {occupied}");
}
