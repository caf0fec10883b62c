//! Contact sheet of pictures, with labels.

use std::convert::Infallible;

use embedded_graphics::mono_font::MonoTextStyle;
use embedded_graphics::mono_font::iso_8859_1::{FONT_6X13, FONT_9X18_BOLD};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, Drawable as _, OriginDimensions, Pixel, Point, Size};
use embedded_graphics::text::{Baseline, Text};
use potamoi_analysis::hard_cases::SceneCases;
use potamoi_analysis::hard_cases::pictures::{Shown, psnr};
use potamoi_base::picture::Picture;

/// Width of a picture on the sheet in pixels: smaller pictures are enlarged by a whole number.
const WIDE: u32 = 330;
/// Space between pictures, and of the labels: pixels.
const GAP: u32 = 8;
const TITLE: u32 = 30;
const LABEL: u32 = 34;
/// Characters that fit the width of a picture.
const FITS: usize = 55;
/// Colour of NaN and infinite channels.
const NO_NUMBER: [f32; 3] = [1.0, 0.0, 1.0];

/// A row of the sheet: its name, and its pictures with their labels.
pub(super) struct Row {
    name: String,
    /// Columns that stay empty before the first picture.
    skipped: u32,
    pictures: Vec<(String, Picture)>,
}

/// A level in words, of a picture beside another.
fn level(a: &Picture, b: &Picture) -> String {
    match psnr(a, b) {
        None => "no number".to_owned(),
        Some(db) if db.is_infinite() => "equal".to_owned(),
        Some(db) => format!("{db:.0} dB"),
    }
}

/// The difference of two pictures, enlarged so that its largest is white, and the factor.
fn difference(a: &Picture, b: &Picture) -> (String, Picture) {
    let mut off = a.clone();
    for (pixel, other) in off.rgb.iter_mut().zip(&b.rgb) {
        *pixel = [0, 1, 2].map(|c| (pixel[c] - other[c]).abs());
    }
    let most = off.rgb.iter().flatten().fold(0f32, |most, v| most.max(*v));
    if most > 0.0 {
        off.rgb.iter_mut().flatten().for_each(|v| *v /= most);
    }
    (format!("ours less floats, white is {most:.1e}"), off)
}

impl Row {
    /// The pictures of a hard scene.
    pub(super) fn of_case(own: &Shown) -> Self {
        let naive = level(&own.naive, &own.float);
        let ours = level(&own.fixed, &own.float);
        Self {
            name: format!("{}: {}", own.scene, own.case),
            skipped: 0,
            pictures: vec![
                (format!("{naive}: {}", own.form), own.naive.clone()),
                (format!("{ours}: ours"), own.fixed.clone()),
                ("64-bit floats".to_owned(), own.float.clone()),
                difference(&own.fixed, &own.float),
            ],
        }
    }

    /// The pictures of a user's scene.
    pub(super) fn of_scene(name: &str, own: &SceneCases) -> Self {
        let ours = level(&own.fixed, &own.float);
        Self {
            name: format!("scene {name}"),
            // It has no picture by the obvious form.
            skipped: 1,
            pictures: vec![
                (format!("{ours}: ours"), own.fixed.clone()),
                ("64-bit floats".to_owned(), own.float.clone()),
                difference(&own.fixed, &own.float),
            ],
        }
    }

    fn height(&self) -> u32 {
        let highest = self.pictures.iter().map(|(_, own)| drawn(own)[1]).max();
        LABEL + highest.unwrap_or(0) + GAP
    }
}

/// Width and height of a picture on the sheet.
fn drawn(picture: &Picture) -> [u32; 2] {
    let scale = (WIDE / picture.width.max(1)).max(1);
    [picture.width * scale, picture.height * scale]
}

/// The sheet: a column for each picture of a row.
pub(super) fn sheet(title: &str, rows: &[Row]) -> Picture {
    let columns = rows.iter().map(|row| {
        let wide = row
            .pictures
            .iter()
            .map(|(_, own)| drawn(own)[0].max(WIDE) + GAP);
        row.skipped * (WIDE + GAP) + wide.sum::<u32>()
    });
    let width = GAP + columns.max().unwrap_or(WIDE);
    let height = TITLE + GAP + rows.iter().map(Row::height).sum::<u32>();
    let mut canvas = Canvas(Picture::filled(width, height, [1.0; 3]));
    canvas.text(title, [GAP, GAP], FITS * columns_of(rows), true);
    let mut top = TITLE;
    for row in rows {
        canvas.text(
            &row.name,
            [GAP, top],
            FITS * (row.pictures.len() + row.skipped as usize),
            false,
        );
        let mut left = GAP + row.skipped * (WIDE + GAP);
        for (label, picture) in &row.pictures {
            canvas.text(label, [left, top + 15], FITS, false);
            canvas.paste(picture, [left, top + LABEL - 2]);
            left += drawn(picture)[0].max(WIDE) + GAP;
        }
        top += row.height();
    }
    canvas.0
}

fn columns_of(rows: &[Row]) -> usize {
    let counts = rows.iter().map(|row| row.pictures.len());
    counts.max().unwrap_or(1)
}

/// A picture that text is drawn on.
struct Canvas(Picture);

impl Canvas {
    /// Writes a line, cut off where it does not fit.
    fn text(&mut self, text: &str, [left, top]: [u32; 2], fits: usize, is_title: bool) {
        let font = if is_title {
            &FONT_9X18_BOLD
        } else {
            &FONT_6X13
        };
        let style = MonoTextStyle::new(font, BinaryColor::On);
        let own: String = text.chars().take(fits).collect();
        let at = Point::new(left as i32, top as i32);
        match Text::with_baseline(&own, at, style, Baseline::Top).draw(self) {
            Ok(_) => {}
            Err(never) => match never {},
        }
    }

    fn paste(&mut self, picture: &Picture, [left, top]: [u32; 2]) {
        let [wide, high] = drawn(picture);
        let scale = wide / picture.width.max(1);
        for y in 0..high {
            for x in 0..wide {
                let own = picture.rgb[(y / scale * picture.width + x / scale) as usize];
                let is_number = own.iter().all(|v| v.is_finite());
                let to = (top + y) * self.0.width + left + x;
                self.0.rgb[to as usize] = if is_number { own } else { NO_NUMBER };
            }
        }
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.0.width, self.0.height)
    }
}

impl DrawTarget for Canvas {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        let [width, height] = [self.0.width, self.0.height].map(i64::from);
        for Pixel(at, colour) in pixels {
            let [x, y] = [at.x, at.y].map(i64::from);
            if colour.is_on() && (0..width).contains(&x) && (0..height).contains(&y) {
                self.0.rgb[(y * width + x) as usize] = [0.1; 3];
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows: a picture of two pixels is enlarged, what is no number is magenta, and text leaves ink.
    #[test]
    fn labels_are_written_above_their_pictures() {
        let mut odd = Picture::filled(2, 1, [0.5; 3]);
        odd.rgb[1] = [f32::NAN; 3];
        let row = Row {
            name: "a name".to_owned(),
            skipped: 0,
            pictures: vec![("a label".to_owned(), odd)],
        };
        let made = sheet("a title", &[row]);
        let ink = |rows: std::ops::Range<u32>| {
            let all = rows.flat_map(|y| (0..made.width).map(move |x| (x, y)));
            let is_ink = |(x, y): (u32, u32)| made.rgb[(y * made.width + x) as usize] == [0.1; 3];
            all.filter(|at| is_ink(*at)).count()
        };
        assert!(
            ink(0..TITLE) > 50 && ink(TITLE..TITLE + 15) > 20,
            "{}",
            ink(0..TITLE)
        );
        assert!(ink(TITLE + 15..TITLE + LABEL - 2) > 20);
        let at = |x: u32| made.rgb[((TITLE + LABEL + 5) * made.width + x) as usize];
        assert_eq!([at(GAP), at(GAP + WIDE - 1)], [[0.5; 3], NO_NUMBER]);
    }
}
