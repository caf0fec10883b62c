#![allow(clippy::unwrap_used)]
use std::collections::HashMap;

use glam::{DAffine3, DMat3, DQuat, DVec2, DVec3, dvec3};
use proptest::prelude::*;

use super::*;

fn corners(mesh: &Mesh) -> impl Iterator<Item = [DVec3; 3]> {
    let at = |v: &u32| DVec3::from(mesh.vertices()[*v as usize].map(f64::from));
    mesh.triangles()
        .iter()
        .map(move |t| [0, 1, 2].map(|k| at(&t[k])))
}

fn area(mesh: &Mesh) -> f64 {
    let of = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
    corners(mesh).map(of).sum()
}

fn volume(mesh: &Mesh) -> f64 {
    corners(mesh).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum()
}

/// Every side of a triangle is one of exactly one other, the other way round.
fn is_closed(mesh: &Mesh) -> bool {
    let mut sides: HashMap<[u32; 2], i32> = HashMap::new();
    for t in mesh.triangles() {
        for k in 0..3 {
            *sides.entry([t[k], t[(k + 1) % 3]]).or_default() += 1;
        }
    }
    let paired = |([a, b], n): (&[u32; 2], &i32)| *n == 1 && sides.get(&[*b, *a]) == Some(&1);
    sides.iter().all(paired)
}

fn used(mesh: &Mesh) -> bool {
    let mut used = vec![false; mesh.vertices().len()];
    for v in mesh.triangles().as_flattened() {
        used[*v as usize] = true;
    }
    used.into_iter().all(|u| u)
}

const BOX: [DVec3; 2] = [DVec3::splat(-1.5), DVec3::splat(1.5)];

#[test]
fn a_spheres_area_and_volume_converge() {
    let pi = std::f64::consts::PI;
    let mut last = f64::INFINITY;
    for cells in [8, 16, 32, 64] {
        // Steep and curved, as densities are: straight lines would miss.
        let ball = |p: DVec3| (9.0 * (1.0 - p.length())).exp();
        let mesh = Mesh::of_density(BOX, cells, 1.0, ball).unwrap();
        assert!(is_closed(&mesh) && used(&mesh));
        let error = (volume(&mesh) / (4.0 * pi / 3.0) - 1.0).abs();
        assert!(error < last / 3.0, "{cells}: {error}");
        last = error;
        let error = (area(&mesh) / (4.0 * pi) - 1.0).abs();
        assert!(error < 10.0 / f64::from(cells).powi(2), "{cells}: {error}");
        for v in mesh.vertices() {
            let off = DVec3::from(v.map(f64::from)).length() - 1.0;
            assert!(off.abs() < 0.01 * 3.0 / f64::from(cells), "{cells}: {off}");
        }
    }
}

#[test]
fn what_the_box_cuts_is_closed_at_the_box() {
    // The far sides are no multiples of a cell away.
    let bounds = [dvec3(-1.0, 0.0, 2.0), dvec3(1.0, 1.27, 2.9)];
    let mesh = Mesh::of_density(bounds, 16, 1.0, |_| 2.0).unwrap();
    assert!(is_closed(&mesh));
    assert!(
        (volume(&mesh) - 2.0 * 1.27 * 0.9).abs() < 0.05,
        "{}",
        volume(&mesh)
    );
    let [low, high] =
        mesh.vertices()
            .iter()
            .fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[low, high], v| {
                let v = DVec3::from(v.map(f64::from));
                [low.min(v), high.max(v)]
            });
    assert!((low - bounds[0]).length() < 1e-6 && (high - bounds[1]).length() < 1e-6);
    // Nothing, and a box thinner than a cell.
    let none = Mesh::of_density(bounds, 16, 1.0, |_| 0.0).unwrap();
    assert!(none.vertices().is_empty() && none.triangles().is_empty());
    let flat = [DVec3::ZERO, dvec3(1.0, 1.0, 0.01)];
    assert!(is_closed(
        &Mesh::of_density(flat, 10, 1.0, |_| 2.0).unwrap()
    ));
}

/// A number from a point's place, of no pattern.
fn noise(p: DVec3, seed: u64) -> f64 {
    let mut bits = seed;
    for v in p.to_array() {
        bits = (bits ^ v.to_bits()).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        bits ^= bits >> 29;
    }
    (bits >> 11) as f64 / 2f64.powi(53)
}

#[test]
fn the_mesh_does_not_depend_on_the_number_of_threads() {
    let make = || Mesh::of_density(BOX, 40, 0.6, |p| noise(p, 3)).unwrap();
    let pool = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(make)
    };
    let one = pool(1);
    assert!(one.triangles().len() > 50_000);
    assert!(one == pool(2) && one == pool(7));
    let camera = Camera::look_at(dvec3(0.3, -4.0, 1.0), DVec3::ZERO, DVec3::Z, 0.8, 90, 70);
    let depth = one.depth(&camera);
    let mut turned = one.clone();
    turned.triangles.reverse();
    assert_eq!(depth, turned.depth(&camera));
}

#[test]
fn what_cannot_be_marched_is_refused_by_name() {
    let make = |bounds, cells, level| {
        let made = Mesh::of_density(bounds, cells, level, |_| 1.0);
        made.unwrap_err().to_string()
    };
    assert!(make(BOX, 0, 1.0).contains("cells is 0"));
    assert!(make(BOX, 1025, 1.0).contains("cells is 1025"));
    assert!(make(BOX, 8, f64::NAN).contains("level is NaN"));
    for bounds in [
        [DVec3::ZERO, DVec3::ZERO],
        [DVec3::ZERO, DVec3::NAN],
        [DVec3::ZERO, DVec3::INFINITY],
        [DVec3::splat(1e9), DVec3::splat(1e9 + 1.0)],
        [DVec3::ONE, DVec3::ZERO],
    ] {
        assert!(make(bounds, 1024, 1.0).contains("bounds"), "{bounds:?}");
    }
    let new = |vertices, triangles| Mesh::new(vertices, triangles).unwrap_err().to_string();
    assert!(new(vec![[0.0; 3], [0.0, f32::NAN, 0.0]], vec![]).contains("vertex 1"));
    assert!(new(vec![[0.0; 3]; 3], vec![[0, 1, 2], [0, 3, 1]]).contains("triangle 1"));
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn more_triangles_than_are_kept_are_refused() {
    let made = Mesh::of_density(BOX, 280, 0.5, |p| noise(p, 1));
    let error = made.unwrap_err().to_string();
    assert!(
        error.contains("triangles") && error.contains("fewer cells"),
        "{error}"
    );
}

/// Depths at which a ray surely meets a triangle, and at which it may
/// (Moller and Trumbore 1997): the two differ at its edges and where it is seen
/// nearly edge-on, by what rounding can make of it.
fn meets(direction: DVec3, [a, b, c]: [DVec3; 3]) -> [Option<f64>; 2] {
    let (ab, ac) = (b - a, c - a);
    let across = direction.cross(ac);
    let det = ab.dot(across);
    let u = -a.dot(across) / det;
    let q = (-a).cross(ab);
    let v = direction.dot(q) / det;
    let t = ac.dot(q) / det;
    let within = u.min(v).min(1.0 - u - v);
    let reach = [a, b, c].map(DVec3::length).into_iter().fold(0.0, f64::max);
    let side = [ab, ac, c - b]
        .map(DVec3::length)
        .into_iter()
        .fold(0.0, f64::max);
    let normal = ab.cross(ac);
    let shares = 1e-9 + 1e-14 * reach * side * direction.length() / det.abs();
    let depth = 1e-13 * reach * normal.length() / a.dot(normal).abs();
    if !(shares < 1e-3 && depth < 1e-6) {
        return [None, Some(0.0)];
    }
    let at = |is: bool| (is && t > 0.0).then_some(t);
    [at(within > shares), at(within > -shares)]
}

/// Depths by rays: the nearest that surely is met, and the nearest that may be.
fn by_rays(mesh: &Mesh, camera: &Camera, pixel: u32) -> [f64; 2] {
    let at = DVec2::new(
        f64::from(pixel % camera.width) + 0.5,
        f64::from(pixel / camera.width) + 0.5,
    );
    let direction = ((at - camera.centre) / camera.focal).extend(1.0);
    let mut nearest = [f64::INFINITY; 2];
    for corners in corners(mesh) {
        let corners = corners.map(|p| camera.world_to_camera.transform_point3(p));
        for (near, found) in nearest.iter_mut().zip(meets(direction, corners)) {
            *near = near.min(found.unwrap_or(f64::INFINITY));
        }
    }
    nearest
}

fn point(reach: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-reach..reach).prop_map(DVec3::from)
}

/// Triangles of every sort: behind, across the camera's plane, huge, tiny,
/// edge-on.
fn triangle() -> impl Strategy<Value = [DVec3; 3]> {
    let near = [point(2.0), point(2.0), point(2.0)];
    let huge = [point(1e5), point(1e3), point(1e5)];
    let tiny = (
        point(2.0),
        [point(1.0), point(1.0), point(1.0)],
        -4.0f64..-1.0,
    )
        .prop_map(|(at, offs, size)| offs.map(|o| at + o * 10f64.powf(size)));
    let edge_on = (point(1.0), -3.0f64..3.0, 0.1f64..3.0).prop_map(|(p, a, b)| {
        // In a plane with the camera of no rotation.
        [p, p * a + DVec3::ONE * 1e-9, p * b + p.yzx() * 1e-12]
    });
    prop_oneof![3 => near, 1 => huge, 1 => tiny, 1 => edge_on]
}

use glam::Vec3Swizzles as _;

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn depths_are_those_of_rays(
        all in prop::collection::vec(triangle(), 1..12),
        turn in prop::array::uniform3(-3.2f64..3.2),
        shift in prop_oneof![Just(DVec3::ZERO), point(1.0), point(4.0)],
        focal in 4.0f64..60.0,
    ) {
        let rotation = DQuat::from_euler(glam::EulerRot::XYZ, turn[0], turn[1], turn[2]);
        let camera = Camera {
            width: 23,
            height: 17,
            focal: DVec2::new(focal, focal * 1.1),
            centre: DVec2::new(11.0, 8.7),
            world_to_camera: DAffine3::from_rotation_translation(rotation, shift),
        };
        let vertices: Vec<[f32; 3]> = all
            .as_flattened()
            .iter()
            .map(|p| p.to_array().map(|v| v as f32))
            .collect();
        let triangles = (0..all.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = Mesh::new(vertices, triangles).unwrap();
        for (pixel, depth) in (0..).zip(mesh.depth(&camera)) {
            let [sure, may] = by_rays(&mesh, &camera, pixel);
            let depth = f64::from(depth);
            prop_assert!(depth <= sure * (1.0 + 1e-5), "{pixel}: {depth} {sure}");
            prop_assert!(depth >= may * (1.0 - 1e-5), "{pixel}: {depth} {may}");
        }
    }

    #[test]
    fn noise_of_any_kind_makes_a_closed_surface(
        seed: u64,
        // Some of it is above.
        level in 0.05f64..0.85,
        size in prop::array::uniform3(0.2f64..1.0),
        odd: bool,
    ) {
        let bounds = [DVec3::ZERO, DVec3::from(size)];
        let mesh = Mesh::of_density(bounds, 12, level, |p| match noise(p, seed) {
            v if odd && v > 0.97 => f64::INFINITY,
            v if odd && v > 0.94 => f64::NAN,
            v if odd && v > 0.9 => level,
            v if odd && v < 0.05 => f64::NEG_INFINITY,
            v => v,
        });
        let mesh = mesh.unwrap();
        prop_assert!(!mesh.triangles().is_empty());
        prop_assert!(is_closed(&mesh) && used(&mesh));
        prop_assert!(volume(&mesh) > 0.0);
    }
}

/// A grid of squares, each two triangles, whose edges and corners lie on the
/// centres of pixels and beside them.
#[test]
fn shared_edges_leave_no_hole() {
    let side = 13u32;
    let n = 24u32;
    for turn in [0.0, 0.1, std::f64::consts::FRAC_PI_4] {
        let pose =
            DAffine3::from_mat3_translation(DMat3::from_rotation_z(turn), dvec3(0.0, 0.0, 2.0));
        let camera = Camera {
            width: side,
            height: side,
            focal: DVec2::splat(16.0),
            centre: DVec2::splat(6.5),
            world_to_camera: pose,
        };
        let place = |i: u32| (f64::from(i) - 12.0) / 8.0;
        let vertices = (0..(n + 1) * (n + 1))
            .map(|i| [place(i % (n + 1)) as f32, place(i / (n + 1)) as f32, 0.0])
            .collect();
        let mut triangles = vec![];
        for i in 0..n * n {
            let a = i % n + (n + 1) * (i / n);
            let (b, c, d) = (a + 1, a + n + 1, a + n + 2);
            triangles.extend(if i % 3 == 0 {
                [[a, b, c], [b, c, d]]
            } else {
                [[a, d, b], [d, a, c]]
            });
        }
        let mesh = Mesh::new(vertices, triangles).unwrap();
        for depth in mesh.depth(&camera) {
            assert!((depth - 2.0).abs() < 1e-6, "{turn}: {depth}");
        }
    }
}

#[test]
fn a_floor_under_the_camera_reaches_to_the_horizon() {
    // One triangle that crosses the camera's plane, and one nearer, behind.
    let vertices = vec![
        [-1e6, 1.0, -1e6],
        [1e6, 1.0, -1e6],
        [0.0, 1.0, 1e6],
        [-1.0, 0.5, -0.5],
        [1.0, 0.5, -0.5],
        [0.0, 0.4, -0.1],
    ];
    let mesh = Mesh::new(vertices, vec![[0, 1, 2], [3, 4, 5]]).unwrap();
    let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.5, 400, 300);
    let depth = mesh.depth(&camera);
    for (i, depth) in depth.iter().enumerate() {
        let down = ((i / 400) as f64 + 0.5 - camera.centre.y) / camera.focal.y;
        if down < 0.0 {
            assert_eq!(*depth, f32::INFINITY);
        } else {
            assert!(
                (f64::from(*depth) * down - 1.0).abs() < 1e-6,
                "{i}: {depth}"
            );
        }
    }
}

#[test]
fn cameras_that_see_nothing_get_nothing() {
    let mesh = Mesh::of_density(BOX, 8, 0.0, |p| 1.0 - p.length()).unwrap();
    let at = |width, height, pose| Camera {
        width,
        height,
        focal: DVec2::splat(9.0),
        centre: DVec2::splat(4.0),
        world_to_camera: pose,
    };
    for pose in [
        DAffine3::from_translation(dvec3(0.0, 0.0, -5.0)),
        DAffine3::from_translation(dvec3(90.0, 0.0, 5.0)),
        DAffine3::from_translation(DVec3::NAN),
        DAffine3::from_translation(DVec3::splat(f64::INFINITY)),
    ] {
        let depth = mesh.depth(&at(8, 8, pose));
        assert!(depth.len() == 64 && depth.iter().all(|d| *d == f32::INFINITY));
    }
    assert!(mesh.depth(&at(0, 8, DAffine3::IDENTITY)).is_empty());
    // From inside, everything.
    let inside = mesh.depth(&at(8, 8, DAffine3::IDENTITY));
    assert!(inside.iter().all(|d| (0.3..1.01).contains(d)), "{inside:?}");
    let large = at(1 << 14, 1 << 14, DAffine3::IDENTITY);
    let error = Geometry::depth(&mesh, &large).unwrap_err().to_string();
    assert!(error.contains("`camera` is 16384 x 16384"), "{error}");
}
