//! Exact ties of depth: the picture does not depend on the order of the file.

use glam::DVec3;
use potamoi_formats::config::Config;

use super::{Case, Measuring, Stop, Worst, cases, ensure, rendered};
use potamoi_base::camera::Camera;
use potamoi_gaussians::{Cloud, CloudError};
use potamoi_scene::{Model, Scene};
use potamoi_splats::Profile;

cases! {
    "order";
    depth_ties, "exact ties of depth", "";
    near_ties, "depths that differ below 32 bits", "";
}

/// Four Gaussians over one another, each of another colour, at these depths; each a little more to
/// the left than those before it by `aside` of its depth.
fn stack(depths: [f32; 4], aside: f32) -> Result<Cloud, CloudError> {
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
    all
}

/// The sorted colours of a file by 32-bit depth, ties as they stand.
fn in_file_order(cloud: &Cloud) -> Vec<[f32; 3]> {
    let mut order: Vec<usize> = (0..cloud.len()).collect();
    order.sort_by(|a, b| cloud.means()[*a][2].total_cmp(&cloud.means()[*b][2]));
    order.into_iter().map(|i| cloud.sh(i)[0]).collect()
}

fn depth_ties(under: &Config) -> Measuring {
    let cloud = stack([3.0; 4], 0.0)?;
    let scene = |cloud: Cloud| {
        let model = Model::Splats(cloud);
        Scene::of("ties of depth", model, camera(), DVec3::Y, [0.0; 3])
    };
    let both = |cloud: &Cloud| -> Result<_, Stop> {
        let scene = scene(cloud.clone());
        let fixed = rendered(&scene, under)?;
        Ok((scene.render_float()?, fixed))
    };
    let first = both(&cloud)?;
    let drawn = first.1.counts.splats.map_or(0, |own| own.pairs_drawn);
    ensure(drawn > 100, || format!("{drawn} pairs drawn"))?;
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for order in permutations() {
        let other = cloud.select(&order)?;
        ours.count(both(&other)? != first);
        fails.count(in_file_order(&other) != in_file_order(&cloud));
    }
    Ok(Case {
        naive: "a stable sort by depth, ties in file order".into(),
        unit: "of 24 permutations that change a bit".into(),
        fails,
        bound: 0.0,
        from: "ties are ordered by what the Gaussians hold".into(),
        ours,
    })
}

/// Depths that differ in 64 bits and not in 32: the true order, whatever the file's.
fn near_ties(_: &Config) -> Measuring {
    // From a camera far off, depths of means 2^-12 apart are equal in 32 bits.
    let eye = DVec3::new(0.0, 0.0, -30_000.0);
    let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::NEG_Y, 1e-4, 16, 16);
    let step = 2f32.powi(-12);
    // By their contents, as ties are ordered, they would come in reverse.
    let cloud = stack([3.0 * step, step, 0.0, 2.0 * step], 1.0)?;
    let truth = [2, 1, 3, 0].map(|i: usize| cloud.sh(i)[0]);
    let (mut fails, mut ours) = (Worst::default(), Worst::default());
    for order in permutations() {
        let other = cloud.select(&order)?;
        let view = potamoi_splats::View::new(&other, &camera, Profile::Gsplat)?;
        let found: Vec<_> = view.splats().iter().map(|s| other.sh(s.index)[0]).collect();
        ours.count(found != truth);
        let mut naive: Vec<usize> = (0..4).collect();
        naive.sort_by(|a, b| {
            let depth = |i: &usize| (f64::from(other.means()[*i][2]) + 30_000.0) as f32;
            depth(a).total_cmp(&depth(b))
        });
        fails.count(naive.iter().map(|i| other.sh(*i)[0]).ne(truth));
    }
    Ok(Case {
        naive: "a sort by 32-bit depths".into(),
        unit: "of 24 permutations in a wrong order".into(),
        fails,
        bound: 0.0,
        from: "all 64 bits are sorted".into(),
        ours,
    })
}
