//! DirectVoxGO and TensoRF models from the sampled grid of a scene. Both have the colours'
//! coefficients as features, and a perceptron that computes colour from them.

use super::shade::perceptron;
use potamoi_fields::algorithms::dvgo::{self, Dvgo};
use potamoi_fields::algorithms::tensorf::{Activation, KnownValues, Rules, Tensorf};
use potamoi_fields::voxels::Grid;
use potamoi_fields::{FieldError, Table};

/// Step in voxel edges.
const STEP: f64 = 0.5;
/// Number of colour coefficients, the inputs of perceptrons: four each of red, green and blue.
const COEFFICIENTS: usize = 12;
/// Optical depth of a voxel edge where softplus returns 1: small, so that softplus bends sharply
/// at 0.
const SOFTPLUS: f64 = 1.0 / 16.0;
/// The density that represents 0. Softplus returns 0.25 there, and 0 far outside, at -65.
const ZERO: f64 = -1.25;
/// Number of TensoRF's appearance features.
const FEATURES: usize = 27;
/// Optical depth a voxel edge from which on solids are hollow. The shell around them, one cell
/// more than the thinner part, transmits less than 1/1000.
const DEEP: f32 = 5.0;
/// Number of terms in a mode, of density and of appearance.
const RANKS: [usize; 2] = [16, 48];

/// A DirectVoxGO model from a grid: densities scaled for softplus, and colours.
pub(crate) fn dvgo(grid: &Grid) -> Result<Dvgo, FieldError> {
    let terms = grid.layout().coefficients();
    let vertices = grid.features().chunks_exact(grid.layout().channels());
    let mut values = Vec::with_capacity(vertices.len() * (1 + COEFFICIENTS));
    for vertex in vertices {
        values.push(before_softplus(vertex[0].into()) as f32);
        for colour in vertex[1..].chunks_exact(terms) {
            let mut own = [0.0; COEFFICIENTS / 3];
            own[..terms].copy_from_slice(colour);
            values.extend(own);
        }
    }
    Dvgo::new(dvgo::Parts {
        table: Table::new(grid.points(), 1 + COEFFICIENTS, values)?,
        filled: near_something(grid),
        bounds: grid.bounds(),
        shift: 0.0,
        scale: SOFTPLUS,
        step: STEP,
        range: [0.0, f64::INFINITY],
        frequencies: 4,
        mlp: perceptron("dvgo")?,
    })
}

/// Vertices that have a positive density or a neighbour with one. A sample whose nearest vertex is
/// not among them is in a cell without density.
fn near_something(grid: &Grid) -> Vec<bool> {
    let points = grid.points();
    let vertices = grid.features().chunks_exact(grid.layout().channels());
    let mut near: Vec<bool> = vertices.map(|v| v[0] > 0.0).collect();
    let mut stride = 1;
    for points in points {
        let own = near.clone();
        for (i, to) in near.iter_mut().enumerate() {
            let at = i / stride % points;
            *to |= at > 0 && own[i - stride] || at + 1 < points && own[i + stride];
        }
        stride *= points;
    }
    near
}

/// The input of softplus for a density, an optical depth a voxel edge.
fn before_softplus(density: f64) -> f64 {
    let scaled = density / SOFTPLUS;
    if density > 0.0 {
        // ln(e^x - 1), for large x without overflow.
        (scaled + (-(-scaled).exp_m1()).ln()).max(ZERO)
    } else {
        ZERO + scaled
    }
}

/// A TensoRF model fitted to the vertices of all visible cells. Solids are hollow, since no light
/// passes their shell.
pub(crate) fn tensorf(grid: &Grid) -> Result<Tensorf, FieldError> {
    let points = grid.points();
    let channels = grid.layout().channels();
    let density = |vertex: usize| grid.features()[vertex * channels];
    let vertices: usize = points.iter().product();
    let deep = |vertex: usize| density(vertex) >= DEEP;
    let filled: Vec<bool> = (0..vertices)
        .map(|v| density(v) > 0.0 && !deep(v))
        .collect();
    let mut known = KnownValues {
        points,
        places: vec![],
        density: vec![],
        seen: vec![],
        appearance: vec![vec![]; channels - 1],
        filled,
    };
    let thickest = (0..vertices).map(|v| if known.filled[v] { density(v) } else { 0.0 });
    let around = largest(points, thickest.collect());
    for vertex in 0..vertices {
        if around[vertex] <= 0.0 {
            continue;
        }
        let at = [
            vertex % points[0],
            vertex / points[0] % points[1],
            vertex / (points[0] * points[1]),
        ];
        // What is outside matters only beside what is inside: a surface is not
        // moved by a limit of four times the density around.
        let limit = -4.0 * around[vertex];
        known.places.push(at);
        known.density.push(density(vertex).max(limit));
        if !deep(vertex) {
            known.seen.push(at);
            let colours = &grid.features()[vertex * channels + 1..][..channels - 1];
            for (to, value) in known.appearance.iter_mut().zip(colours) {
                to.push(*value);
            }
        }
    }
    let terms = grid.layout().coefficients();
    let slots: Vec<usize> = (0..3)
        .flat_map(|colour| (0..terms).map(move |term| colour * COEFFICIENTS / 3 + term))
        .collect();
    let rules = Rules {
        activation: Activation::Relu,
        distance_scale: 1.0 / grid.voxel(),
        step_ratio: STEP,
        ..Rules::new(grid.bounds())
    };
    Tensorf::through(
        &known,
        RANKS,
        (FEATURES, &slots),
        perceptron("tensorf")?,
        rules,
    )
}

/// The largest value of each vertex and its 26 neighbours, computed one axis after another.
fn largest(points: [usize; 3], mut all: Vec<f32>) -> Vec<f32> {
    let mut stride = 1;
    for side in points {
        let before = all.clone();
        for (vertex, to) in all.iter_mut().enumerate() {
            let place = vertex / stride % side;
            if place > 0 {
                *to = to.max(before[vertex - stride]);
            }
            if place + 1 < side {
                *to = to.max(before[vertex + stride]);
            }
        }
        stride *= side;
    }
    all
}
