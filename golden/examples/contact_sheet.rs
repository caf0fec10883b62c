//! The ground truth of all analytic scenes in one picture, and how far their
//! models are from it: `contact_sheet FILE.png [SIDE]`.

use std::path::Path;
use std::time::Instant;

use potamoi_golden::analytic::Analytic;
use potamoi_golden::picture::Picture;
use potamoi_golden::scene::Scene;

/// Pictures a row.
const COLUMNS: u32 = 4;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut args = std::env::args().skip(1);
    let path = args.next().ok_or("expected a PNG file to write")?;
    let side: u32 = args.next().map_or(Ok(240), |text| text.parse())?;
    if !(8..=2048).contains(&side) {
        return Err(format!("side {side}: expected 8 to 2048 pixels").into());
    }
    let rows = (Analytic::ALL.len() as u32).div_ceil(COLUMNS);
    let mut sheet = Picture::filled(COLUMNS * side, rows * side, [1.0; 3]);
    for (i, analytic) in (0..).zip(Analytic::ALL) {
        let start = Instant::now();
        let mut scene = Scene::open(analytic.name())?;
        let opened = start.elapsed().as_secs_f64();
        scene.set_size(Some(side), Some(side))?;
        let start = Instant::now();
        let truth = scene.render_truth()?;
        let took = start.elapsed().as_secs_f64();
        let float = scene.render_float()?;
        let psnr = float.picture.psnr(&truth.picture, |_| true);
        println!(
            "{}: {}; opened in {opened:.2} s, truth in {took:.2} s, model {:.1} dB",
            analytic.name(),
            analytic.asks(),
            psnr.ok_or("pictures of different sizes")?
        );
        let corner = (i / COLUMNS * side * COLUMNS + i % COLUMNS) * side;
        for (y, row) in truth.picture.rgb.chunks_exact(side as usize).enumerate() {
            let from = corner as usize + y * (COLUMNS * side) as usize;
            sheet.rgb[from..from + row.len()].copy_from_slice(row);
        }
    }
    sheet.write_png(Path::new(&path))?;
    Ok(())
}
