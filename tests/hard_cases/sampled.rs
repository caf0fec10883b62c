//! Pictures that are not of splats: what they have in common.

use std::sync::LazyLock;

use potamoi_base::picture::Picture;

use super::{fields, fog, warped};

/// What the obvious form, the hardware's formats and 64-bit floats show of a scene.
#[derive(Clone)]
pub(crate) struct Shown {
    pub(crate) scene: &'static str,
    pub(crate) case: &'static str,
    /// How the obvious form goes about it.
    pub(crate) form: &'static str,
    pub(crate) naive: Picture,
    pub(crate) ours: Picture,
    pub(crate) float: Picture,
    /// The largest difference of the latter two, each pixel's within its bound.
    pub(crate) farthest: f64,
    /// The largest bound of a pixel.
    pub(crate) bound: f64,
}

/// The largest difference of two pictures, whose pixels must keep to their bounds.
pub(crate) fn farthest(a: &Picture, b: &Picture, bounds: impl Iterator<Item = f64>) -> f64 {
    let pixels = a.rgb.iter().zip(&b.rgb).zip(bounds);
    let mut most = 0.0;
    for (i, ((a, b), bound)) in pixels.enumerate() {
        for (a, b) in a.iter().zip(b) {
            let off = (f64::from(*a) - f64::from(*b)).abs();
            assert!(off <= bound, "pixel {i}: {a} and {b}, {off:e} > {bound:e}");
            most = f64::max(most, off);
        }
    }
    most
}

/// All of them, rendered once for every test.
pub(crate) fn all() -> &'static [Shown] {
    static ALL: LazyLock<Vec<Shown>> =
        LazyLock::new(|| [fog::shown(), fields::shown(), warped::shown()].concat());
    &ALL
}

impl Shown {
    /// dB of the obvious form and of ours beside floats; none where one is no number.
    pub(crate) fn levels(&self) -> [Option<f64>; 2] {
        [&self.naive, &self.ours].map(|picture| super::pictures::psnr(picture, &self.float))
    }
}

/// Ours keeps each pixel's bound; the obvious form is farther off by 10 dB or more, and leaves it.
#[test]
fn samples_keep_their_bounds_and_the_obvious_form_does_not() {
    for shown in all() {
        let [naive, ours] = shown.levels();
        let (name, ours) = (shown.scene, ours.expect("finite pictures"));
        println!(
            "{name}: {ours:.1} dB, naive {naive:?}, {:e} of {:e}",
            shown.farthest, shown.bound
        );
        assert!(shown.farthest <= shown.bound);
        assert!(
            naive.is_none_or(|naive| naive < ours - 10.0),
            "{name}: {naive:?} beside {ours} dB: the case does not bite"
        );
    }
}
