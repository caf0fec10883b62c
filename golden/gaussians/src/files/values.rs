//! Conversions from quantised file values to those of a cloud.

use rayon::prelude::*;

use potamoi_base::sh;

/// Logits of the opacities `0/255, 1/255, ... 255/255`; infinite at both ends, since those codes
/// mean opacity 0 and 1 exactly.
pub(super) fn logits() -> [f32; 256] {
    std::array::from_fn(|code| {
        let opacity = code as f64 / 255.0;
        (opacity / (1.0 - opacity)).ln() as f32
    })
}

/// The coefficient of the constant basis function for a colour.
pub(super) fn constant(colour: f64) -> f32 {
    ((colour - 0.5) / sh::CONSTANT) as f32
}

/// A unit quaternion from three components in order and the index of the omitted one, which is the
/// largest and not negative.
pub(super) fn with_largest(largest: usize, others: [f64; 3]) -> [f32; 4] {
    let rest = 1.0 - others.iter().map(|v| v * v).sum::<f64>();
    let mut left = others.into_iter();
    std::array::from_fn(|i| {
        let value = if i == largest { None } else { left.next() };
        value.unwrap_or_else(|| rest.max(0.0).sqrt()) as f32
    })
}

/// Computes one value for each Gaussian, in parallel.
pub(super) fn each<T: Send>(count: usize, value: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count)
        .into_par_iter()
        .with_min_len(1 << 12)
        .map(value)
        .collect()
}

/// Computes the RGB coefficients of each Gaussian, in parallel. `fill` gets the index of a
/// Gaussian and its `(degree + 1)^2` coefficients.
pub(super) fn coefficients(
    count: usize,
    degree: usize,
    fill: impl Fn(usize, &mut [[f32; 3]]) + Sync + Send,
) -> Vec<[f32; 3]> {
    let each = sh::coefficients(degree);
    let mut all = vec![[0.0; 3]; count * each];
    all.par_chunks_mut(each)
        .with_min_len(1 << 12)
        .enumerate()
        .for_each(|(i, out)| fill(i, out));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logits_are_infinite_at_the_ends_and_odd_about_the_middle() {
        let l = logits();
        assert_eq!((l[0], l[255]), (f32::NEG_INFINITY, f32::INFINITY));
        for code in 1..255 {
            let opacity = 1.0 / (1.0 + (-f64::from(l[code])).exp());
            assert!((opacity * 255.0 - code as f64).abs() < 1e-4);
        }
    }

    #[test]
    fn the_largest_component_completes_the_quaternion() {
        for largest in 0..4 {
            let q = with_largest(largest, [0.5, -0.5, 0.5]);
            assert_eq!(q[largest], 0.5);
            let others: Vec<f32> = (0..4).filter(|i| *i != largest).map(|i| q[i]).collect();
            assert_eq!(others, [0.5, -0.5, 0.5]);
        }
        // Rounding may leave nothing for it, and it stays a number.
        assert_eq!(with_largest(0, [0.8, 0.8, 0.8])[0], 0.0);
    }
}
