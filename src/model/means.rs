//! Means of figures over scenes, and the scene that decides one.

use potamoi_system::system_model::AtBounds;

/// A mean that one scene moves by more than this share is decided by it.
const DECIDES: f64 = 0.2;

/// The arithmetic mean, at both bounds.
pub(super) fn mean(all: &[AtBounds<f64>]) -> AtBounds<f64> {
    of(all, |all| all.iter().sum::<f64>() / all.len() as f64)
}

/// The geometric mean, at both bounds.
pub(super) fn geometric(all: &[AtBounds<f64>]) -> AtBounds<f64> {
    of(all, |all| {
        let logs = all.iter().map(|own| own.ln()).sum::<f64>();
        (logs / all.len() as f64).exp()
    })
}

fn of(all: &[AtBounds<f64>], mean: impl Fn(&[f64]) -> f64) -> AtBounds<f64> {
    let at = |own: fn(&AtBounds<f64>) -> f64| mean(&all.iter().map(own).collect::<Vec<_>>());
    AtBounds {
        max: at(|own| own.max),
        sum: at(|own| own.sum),
    }
}

/// The scene without which the arithmetic mean of a column differs most, if by more than a fifth;
/// each column has a figure for each scene.
pub(super) fn deciding(columns: &[Vec<AtBounds<f64>>]) -> Option<usize> {
    let scenes = columns.first()?.len();
    let moved = |scene: usize| {
        let by = columns.iter().map(|own| {
            let (with, without) = (mean(own).mid(), mean(&without(own, scene)).mid());
            (without / with - 1.0).abs()
        });
        by.fold(0.0, f64::max)
    };
    let all = (0..scenes).map(|scene| (scene, moved(scene)));
    let (scene, most) = all.max_by(|a, b| a.1.total_cmp(&b.1))?;
    (scenes > 2 && most > DECIDES).then_some(scene)
}

/// All figures but a scene's.
pub(super) fn without(all: &[AtBounds<f64>], scene: usize) -> Vec<AtBounds<f64>> {
    let others = all.iter().enumerate().filter(|(i, _)| *i != scene);
    others.map(|(_, own)| *own).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_scene_that_decides_a_mean_is_found() {
        let all = |values: [f64; 4]| {
            values
                .map(|v| AtBounds {
                    max: v,
                    sum: 2.0 * v,
                })
                .to_vec()
        };
        let even = all([2.0, 2.1, 1.9, 2.0]);
        let odd = all([2.0, 2.1, 9.0, 2.0]);
        assert_eq!(deciding(std::slice::from_ref(&even)), None);
        assert_eq!(deciding(&[even.clone(), odd.clone()]), Some(2));
        assert_eq!(
            deciding(&[odd[1..3].to_vec()]),
            None,
            "two scenes decide alike"
        );
        assert!((mean(&even).max - 2.0).abs() < 1e-12 && (mean(&even).sum - 4.0).abs() < 1e-12);
        assert!((geometric(&all([1.0, 4.0, 2.0, 2.0])).max - 2.0).abs() < 1e-12);
        assert_eq!(without(&odd, 2).len(), 3);
        assert_eq!(deciding(&[]), None);
    }
}
