//! Rays along an axis and samples on faces of voxels, MVoxels and the volume.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::{Case, Measuring, Worst, cases};
use potamoi_base::camera::crossing;
use potamoi_march::tiling::{Halo, Tiling};

cases! {
    "samples";
    samples_on_faces, "samples on faces of voxels, MVoxels and the volume: owners", "";
    places_on_faces, "samples on faces: places", "";
    rays_along_an_axis, "rays parallel to an axis, in a face too", "";
}

const POINTS: [usize; 3] = [19, 16, 23];

/// On, and just about, faces of cells, of MVoxels and of the volume.
fn along(axis: usize) -> Vec<f64> {
    let last = (POINTS[axis] - 1) as f64;
    let mut all = vec![0.0, last, last.next_down(), last - 2f64.powi(-12)];
    for face in [1.0f64, 6.0, 7.0, 8.0, 14.0] {
        all.extend([face.next_down(), face, face.next_up()]);
        all.extend([-1.0, 0.45, 1.0].map(|codes| face + codes * 2f64.powi(-12)));
    }
    all
}

fn places() -> impl Iterator<Item = [f64; 3]> {
    along(0).into_iter().flat_map(|x| {
        along(1)
            .into_iter()
            .flat_map(move |y| along(2).into_iter().map(move |z| [x, y, z]))
    })
}

/// Each sample is in the cell that its owner holds whole.
fn samples_on_faces(_: &Config) -> Measuring {
    let tiling = Tiling::new(POINTS, [8; 3], Halo::Shared);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for at in places() {
        let place = tiling.locate(at);
        let extent = tiling.extent(place.mvoxel);
        let holds = place.mvoxel < tiling.count()
            && (0..3).all(|a| place.local[a] + 1 < extent[a])
            && (0..3).all(|a| place.fraction[a] < 4096 || at[a] > (POINTS[a] - 1) as f64 - 1e-3);
        ours.count(!holds);
        // All boxes that a sample is in, faces included.
        let owners = (0..tiling.count()).filter(|m| {
            let (first, extent) = (tiling.first(*m), tiling.extent(*m));
            (0..3).all(|a| {
                let low = first[a] as f64;
                (low..=low + (extent[a] - 1) as f64).contains(&at[a])
            })
        });
        fails.count(owners.count() != 1);
    }
    Ok(Case {
        naive: "every MVoxel whose box holds it, faces included".into(),
        unit: "samples of 39,304 without exactly one owner".into(),
        fails,
        bound: 0.0,
        from: "the cell is found from the code, in integers".into(),
        ours,
    })
}

/// Both sides of a face agree on where a sample is.
fn places_on_faces(_: &Config) -> Measuring {
    let tiling = Tiling::new(POINTS, [8; 3], Halo::Shared);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for at in places() {
        let place = tiling.locate(at);
        let first = tiling.first(place.mvoxel);
        for axis in 0..3 {
            let vertex = (first[axis] + place.local[axis]) as f64;
            ours.see(vertex + f64::from(place.fraction[axis]) / 4096.0 - at[axis]);
            // The cell from the number, the fraction rounded by itself into 12 bits.
            let cell = at[axis].floor();
            let code = (((at[axis] - cell) * 4096.0).round() as i64) & 0xfff;
            fails.see(cell + code as f64 / 4096.0 - at[axis]);
        }
    }
    Ok(Case {
        naive: "floor, and the fraction in U0.12".into(),
        unit: "voxels".into(),
        fails,
        bound: 2f64.powi(-13),
        from: "half a unit of the position's 12 fraction bits".into(),
        ours,
    })
}

/// Slabs by division, compared as they come.
fn divided([low, high]: [DVec3; 2], origin: DVec3, direction: DVec3) -> [f64; 2] {
    let (mut near, mut far) = (0.0, f64::INFINITY);
    for axis in 0..3 {
        let a = (low[axis] - origin[axis]) / direction[axis];
        let b = (high[axis] - origin[axis]) / direction[axis];
        let (a, b) = if a < b { (a, b) } else { (b, a) };
        near = if a > near { a } else { near };
        far = if b < far { b } else { far };
    }
    [near, far]
}

fn rays_along_an_axis(_: &Config) -> Measuring {
    let bounds = [DVec3::ZERO, DVec3::splat(4.0)];
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    let across = [-1.0, -0.0, 0.0, 2.0, 4.0, 4.0f64.next_up()];
    for axis in 0..3 {
        for (u, v) in across.into_iter().flat_map(|u| across.map(|v| (u, v))) {
            for zeros in [[0.0, 0.0], [-0.0, 0.0], [-0.0, -0.0]] {
                for forward in [true, false] {
                    let mut origin = [0.0; 3];
                    let mut direction = [0.0; 3];
                    let [b, c] = [(axis + 1) % 3, (axis + 2) % 3];
                    [origin[b], origin[c]] = [u, v];
                    [direction[b], direction[c]] = zeros;
                    (origin[axis], direction[axis]) =
                        if forward { (-2.0, 1.0) } else { (6.0, -1.0) };
                    // Faces are part of the volume.
                    let inside = [u, v].iter().all(|p| (0.0..=4.0).contains(p));
                    let wrong = |[near, far]: [f64; 2]| {
                        if inside {
                            [near, far] != [2.0, 6.0]
                        } else {
                            far >= near
                        }
                    };
                    let (o, d) = (DVec3::from(origin), DVec3::from(direction));
                    ours.count(wrong(crossing(bounds, o, d, [0.0, f64::INFINITY])));
                    fails.count(wrong(divided(bounds, o, d)));
                }
            }
        }
    }
    Ok(Case {
        naive: "slabs by division, 0 / 0 among them".into(),
        unit: "rays of 648 that enter or miss wrongly".into(),
        fails,
        bound: 0.0,
        from: "a parallel ray is inside all along or never".into(),
        ours,
    })
}

#[test]
fn there_are_as_many_places_as_are_told() {
    assert_eq!(places().count(), 39_304);
}
