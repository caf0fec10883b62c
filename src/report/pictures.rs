//! Pictures of the page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use potamoi_base::picture::Picture;
use potamoi_page::{Images, SCALE};

use super::document::Image;
use crate::failure::Failure;

/// Keeps a picture as PNG.
pub(super) fn keep(images: &mut Images, id: String, picture: &Picture) -> Result<Image, Failure> {
    let folder = tempfile::tempdir();
    let lost = |error: std::io::Error| Failure::Usage(format!("a temporary picture: {error}"));
    let file = folder
        .as_ref()
        .map_err(|e| lost(e.kind().into()))?
        .path()
        .join("picture.png");
    picture.write_png(&file)?;
    let png = std::fs::read(&file).map_err(lost)?;
    let hash = potamoi_base::content_hash::hash_of(&png[..])
        .to_hex()
        .to_string();
    images.insert(
        id.clone(),
        format!("data:image/png;base64,{}", STANDARD.encode(&png)),
    );
    Ok(Image { id, hash })
}

/// Difference of two pictures in colours of a scale.
pub(super) struct Difference {
    pub(super) picture: Picture,
    /// Difference at which the scale ends: a power of two that 99.5 % of the pixels keep to.
    pub(super) scale: f64,
    /// The largest.
    pub(super) largest: f64,
}

impl Difference {
    /// The largest difference of a channel in each pixel. Pictures are of one size.
    pub(super) fn of(one: &Picture, other: &Picture) -> Self {
        let of = |(a, b): (&[f32; 3], &[f32; 3])| {
            let off = a.iter().zip(b).map(|(x, y)| (x - y).abs());
            f64::from(off.fold(0f32, f32::max))
        };
        let off: Vec<f64> = one.rgb.iter().zip(&other.rgb).map(of).collect();
        let mut sorted = off.clone();
        sorted.sort_by(f64::total_cmp);
        let most = sorted
            .get(sorted.len() * 995 / 1000)
            .copied()
            .unwrap_or(0.0);
        let scale = match most > 0.0 {
            true => most.log2().ceil().exp2().min(1.0),
            false => 1.0 / 256.0,
        };
        let rgb = off.iter().map(|own| colour(own / scale)).collect();
        Self {
            picture: Picture {
                width: one.width,
                height: one.height,
                rgb,
            },
            scale,
            largest: sorted.last().copied().unwrap_or(0.0),
        }
    }
}

/// The colour of a share of the scale.
fn colour(share: f64) -> [f32; 3] {
    let last = SCALE.len() - 1;
    let at = share.clamp(0.0, 1.0) * last as f64;
    let low = (at as usize).min(last - 1);
    let part = at - low as f64;
    let of = |channel: usize| {
        let [a, b] = [SCALE[low], SCALE[low + 1]].map(|own| f64::from(own[channel]));
        ((a + part * (b - a)) / 255.0) as f32
    };
    [of(0), of(1), of(2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scale_ends_above_the_errors_and_colours_follow() {
        let black = Picture::filled(20, 20, [0.0; 3]);
        let mut other = black.clone();
        for pixel in &mut other.rgb[..100] {
            *pixel = [0.0, 0.1, 0.02];
        }
        let own = Difference::of(&black, &other);
        assert_eq!(own.scale, 0.125);
        assert!((own.largest - 0.1).abs() < 1e-6);
        assert_eq!(own.picture.rgb[399], SCALE[0].map(|v| f32::from(v) / 255.0));
        let brightness = |own: [f32; 3]| own.iter().sum::<f32>();
        assert!(brightness(own.picture.rgb[0]) > brightness(own.picture.rgb[399]));
        assert_eq!(Difference::of(&black, &black).largest, 0.0);
    }
}
