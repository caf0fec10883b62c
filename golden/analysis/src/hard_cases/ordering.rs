//! Exact ties of depth: the picture does not depend on the order of the file.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::{Case, Worst, cases};
use potamoi_base::camera::Camera;
use potamoi_reference::ReferenceUnits;
use potamoi_splats::{Cloud, FixedOptions, FloatOptions, Profile, render_fixed, render_float};

cases!(depth_ties, near_ties);

/// Four Gaussians over one another, each of another colour, at these depths; each a little more to
/// the left than those before it by `aside` of its depth.
fn stack(depths: [f32; 4], aside: f32) -> Cloud {
    let colour = |i: usize| {
        [
            0.5 * i as f32 - 1.0,
            1.0 - 0.7 * i as f32,
            [0.9, -0.9][i % 2],
        ]
    };
    Cloud::new(
        0,
        depths.map(|z| [0.02 - aside * z, -0.01, z]).to_vec(),
        vec![[-2.0; 3]; 4],
        vec![[1.0, 0.0, 0.0, 0.0]; 4],
        vec![0.3; 4],
        (0..4).map(colour).collect(),
    )
    .unwrap()
}

fn camera() -> Camera {
    Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 16, 16)
}

fn permutations() -> Vec<Vec<usize>> {
    let mut all = vec![];
    for code in 0..256usize {
        let order = [0, 1, 2, 3].map(|i| code >> (2 * i) & 3);
        if (0..4).all(|i| order.contains(&i)) {
            all.push(order.to_vec());
        }
    }
    assert_eq!(all.len(), 24);
    all
}

/// The sorted colours of a file by 32-bit depth, ties as they stand.
fn in_file_order(cloud: &Cloud) -> Vec<[f32; 3]> {
    let mut order: Vec<usize> = (0..cloud.len()).collect();
    order.sort_by(|a, b| cloud.means()[*a][2].total_cmp(&cloud.means()[*b][2]));
    order.into_iter().map(|i| cloud.sh(i)[0]).collect()
}

fn depth_ties() -> Case {
    let cloud = stack([3.0; 4], 0.0);
    let config = Config::paper();
    let both = |cloud: &Cloud| {
        let options = FloatOptions::default();
        let float = render_float(cloud, &camera(), Profile::Inria, &options).unwrap();
        let (options, mut units) = (FixedOptions::default(), ReferenceUnits::new(&config));
        let fixed = render_fixed(cloud, &camera(), Profile::Inria, &options, &mut units);
        (float, fixed.unwrap())
    };
    let first = both(&cloud);
    assert!(first.1.stats.drawn > 100);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for order in permutations() {
        let other = cloud.select(&order).unwrap();
        ours.count(both(&other) != first);
        fails.count(in_file_order(&other) != in_file_order(&cloud));
    }
    Case {
        name: "exact ties of depth",
        naive: "a stable sort by depth, ties in file order",
        unit: "of 24 permutations that change a bit",
        fails,
        bound: 0.0,
        from: "ties are ordered by what the Gaussians hold",
        ours,
    }
}

/// Depths that differ in 64 bits and not in 32: the true order, whatever the file's.
fn near_ties() -> Case {
    // From a camera far off, depths of means 2^-12 apart are equal in 32 bits.
    let eye = DVec3::new(0.0, 0.0, -30_000.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::NEG_Y, 1e-4, 16, 16);
    let step = 2f32.powi(-12);
    // By their contents, as ties are ordered, they would come in reverse.
    let cloud = stack([3.0 * step, step, 0.0, 2.0 * step], 1.0);
    let truth = [2, 1, 3, 0].map(|i: usize| cloud.sh(i)[0]);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for order in permutations() {
        let other = cloud.select(&order).unwrap();
        let view = potamoi_splats::View::new(&other, &camera, Profile::Gsplat).unwrap();
        let found: Vec<_> = view.splats().iter().map(|s| other.sh(s.index)[0]).collect();
        ours.count(found != truth);
        let mut naive: Vec<usize> = (0..4).collect();
        naive.sort_by(|a, b| {
            let depth = |i: &usize| (f64::from(other.means()[*i][2]) + 30_000.0) as f32;
            depth(a).total_cmp(&depth(b))
        });
        fails.count(naive.iter().map(|i| other.sh(*i)[0]).ne(truth));
    }
    Case {
        name: "depths that differ below 32 bits",
        naive: "a sort by 32-bit depths",
        unit: "of 24 permutations in a wrong order",
        fails,
        bound: 0.0,
        from: "all 64 bits are sorted",
        ours,
    }
}
