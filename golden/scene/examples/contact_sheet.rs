//! Contact sheets of the analytic scenes.
//!
//! - `contact_sheet scenes FILE.png [SIDE]`: the ground truth of all.
//! - `contact_sheet models FILE.png [SIDE] [SCENE]`: one row a scene, with the ground truth
//!   followed by each ready-made model, rendered at SIDE and shown at half of it, over the PSNR in
//!   decibels of linear RGB over the frame. Also prints the values as rows of a Markdown table,
//!   each followed by the PSNR over the covered pixels.
//!   pixels that something covers.

use std::path::Path;
use std::time::Instant;

use potamoi_analytic::Analytic;
use potamoi_base::picture::Picture;
use potamoi_scene::{Representation, Scene};

type Failure = Box<dyn std::error::Error>;

/// Pictures a row in the sheet of scenes.
const COLUMNS: u32 = 4;
/// Pixels above and below pictures, for glyphs of 3 x 5 dots of 2 x 2 pixels.
const MARGIN: u32 = 16;
/// The dots of digits and letters, three bits a row; other characters are blank.
const GLYPHS: [(char, [u8; 5]); 33] = [
    ('0', [7, 5, 5, 5, 7]),
    ('1', [2, 6, 2, 2, 7]),
    ('2', [7, 1, 7, 4, 7]),
    ('3', [7, 1, 7, 1, 7]),
    ('4', [5, 5, 7, 1, 1]),
    ('5', [7, 4, 7, 1, 7]),
    ('6', [7, 4, 7, 5, 7]),
    ('7', [7, 1, 2, 2, 2]),
    ('8', [7, 5, 7, 5, 7]),
    ('9', [7, 5, 7, 1, 7]),
    ('.', [0, 0, 0, 0, 2]),
    ('A', [2, 5, 7, 5, 5]),
    ('B', [6, 5, 6, 5, 6]),
    ('C', [3, 4, 4, 4, 3]),
    ('D', [6, 5, 5, 5, 6]),
    ('E', [7, 4, 6, 4, 7]),
    ('F', [7, 4, 6, 4, 4]),
    ('G', [3, 4, 5, 5, 3]),
    ('H', [5, 5, 7, 5, 5]),
    ('I', [7, 2, 2, 2, 7]),
    ('K', [5, 5, 6, 5, 5]),
    ('L', [4, 4, 4, 4, 7]),
    ('M', [5, 7, 7, 5, 5]),
    ('N', [6, 5, 5, 5, 5]),
    ('O', [2, 5, 5, 5, 2]),
    ('P', [6, 5, 6, 4, 4]),
    ('R', [6, 5, 6, 5, 5]),
    ('S', [3, 4, 2, 1, 6]),
    ('T', [7, 2, 2, 2, 2]),
    ('U', [5, 5, 5, 5, 7]),
    ('V', [5, 5, 5, 5, 2]),
    ('X', [5, 5, 2, 5, 5]),
    ('Y', [5, 5, 2, 2, 2]),
];

fn main() -> Result<(), Failure> {
    let mut args = std::env::args().skip(1);
    let kind = args.next().unwrap_or_default();
    let path = args
        .next()
        .ok_or("expected `scenes` or `models`, and a PNG file to write")?;
    let side: u32 = args.next().map_or(Ok(240), |text| text.parse())?;
    if !(80..=2048).contains(&side) {
        return Err(format!("side {side}: expected 80 to 2048 pixels").into());
    }
    let sheet = match kind.as_str() {
        "scenes" => scenes(side)?,
        "../models" => models(side, args.next().as_deref())?,
        _ => return Err(format!("`{kind}`: expected `scenes` or `models`").into()),
    };
    sheet.write_png(Path::new(&path))?;
    Ok(())
}

fn open(name: &str, side: u32) -> Result<Scene, Failure> {
    let start = Instant::now();
    let mut scene = Scene::open(name)?;
    scene.set_size(Some(side), Some(side))?;
    eprintln!("{name}: opened in {:.2} s", start.elapsed().as_secs_f64());
    Ok(scene)
}

fn scenes(side: u32) -> Result<Picture, Failure> {
    let rows = (Analytic::ALL.len() as u32).div_ceil(COLUMNS);
    let mut sheet = Picture::filled(COLUMNS * side, rows * side, [1.0; 3]);
    for (i, analytic) in (0..).zip(Analytic::ALL) {
        let truth = open(analytic.name(), side)?.render_truth()?;
        let corner = [i % COLUMNS * side, i / COLUMNS * side];
        paste(&mut sheet, corner, &truth.picture);
    }
    Ok(sheet)
}

fn models(side: u32, only: Option<&str>) -> Result<Picture, Failure> {
    let shown: Vec<_> = Analytic::ALL
        .into_iter()
        .filter(|scene| only.is_none_or(|name| name == scene.name()))
        .collect();
    let columns = 1 + Representation::ALL.len() as u32;
    let half = side / 2;
    let tall = half + MARGIN;
    let high = MARGIN + shown.len() as u32 * tall;
    let mut sheet = Picture::filled(columns * half, high, [1.0; 3]);
    let names = Representation::ALL.map(Representation::name);
    println!("| scene | `{}` |", names.join("` | `"));
    println!("|---|{}", "---|".repeat(names.len()));
    for (column, name) in (0..).zip(std::iter::once("truth").chain(names)) {
        caption(&mut sheet, [column * half, 3], half, name);
    }
    for (row, analytic) in (0..).zip(shown) {
        let top = MARGIN + row * tall;
        caption(&mut sheet, [0, top + half + 3], half, analytic.name());
        let mut truth = None;
        let mut cells = vec![];
        for (column, kind) in (1..).zip(Representation::ALL) {
            let scene = open(&format!("{}:{}", analytic.name(), kind.name()), side)?;
            let truth = match &mut truth {
                Some(truth) => truth,
                none => none.insert(scene.render_truth()?),
            };
            paste(&mut sheet, [0, top], &halved(&truth.picture));
            let start = Instant::now();
            let float = scene.render_float()?.picture;
            eprintln!("  rendered in {:.2} s", start.elapsed().as_secs_f64());
            let over = |counts: &dyn Fn(usize) -> bool| {
                let psnr = float.psnr(&truth.picture, counts);
                psnr.ok_or("pictures of different sizes, or nothing is seen")
            };
            let (frame, covered) = (over(&|_| true)?, over(&|i| truth.covered[i])?);
            let text = format!("{frame:.1}");
            paste(&mut sheet, [column * half, top], &halved(&float));
            caption(&mut sheet, [column * half, top + half + 3], half, &text);
            cells.push(format!("{text} / {covered:.1}"));
        }
        println!("| `{}` | {} |", analytic.name(), cells.join(" | "));
    }
    Ok(sheet)
}

/// The mean of every 2 x 2 pixels.
fn halved(picture: &Picture) -> Picture {
    let [width, height] = [picture.width / 2, picture.height / 2];
    let mut half = Picture::filled(width, height, [0.0; 3]);
    for (i, to) in (0..).zip(&mut half.rgb) {
        let corner = i / width * 2 * picture.width + i % width * 2;
        for at in [0, 1, picture.width, picture.width + 1] {
            let own = picture.rgb[(corner + at) as usize];
            for (sum, value) in to.iter_mut().zip(own) {
                *sum += value / 4.0;
            }
        }
    }
    half
}

/// Copies a picture to a position.
fn paste(sheet: &mut Picture, [x, y]: [u32; 2], picture: &Picture) {
    let rows = picture.rgb.chunks_exact(picture.width as usize);
    for (row, pixels) in (y..).zip(rows) {
        let from = (row * sheet.width + x) as usize;
        sheet.rgb[from..from + pixels.len()].copy_from_slice(pixels);
    }
}

/// Writes a text, centred in `wide` pixels from a position on.
fn caption(sheet: &mut Picture, [x, y]: [u32; 2], wide: u32, text: &str) {
    let free = wide.saturating_sub(8 * text.len() as u32);
    write(sheet, [x + free / 2, y], text);
}

/// Writes a text with its upper left corner at a position.
fn write(sheet: &mut Picture, [x, y]: [u32; 2], text: &str) {
    let wide = sheet.width;
    for (place, letter) in (0..).zip(text.to_uppercase().chars()) {
        let Some((_, dots)) = GLYPHS.iter().find(|(known, _)| *known == letter) else {
            continue;
        };
        for (dy, dx) in (0..10).flat_map(|dy| (0..6).map(move |dx| (dy, dx))) {
            let place = x + 8 * place + dx;
            if dots[dy as usize / 2] >> (2 - dx / 2) & 1 == 1 && place < wide {
                sheet.rgb[((y + dy) * wide + place) as usize] = [0.0; 3];
            }
        }
    }
}
