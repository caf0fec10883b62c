//! DirectVoxGO and TensoRF from the grid that is sampled of a scene. Both take
//! the coefficients of colours as features, and turn them into colour by a
//! perceptron that knows how.

use super::shade::perceptron;
use potamoi_fields::algorithms::dvgo::{self, Dvgo};
use potamoi_fields::algorithms::tensorf::{Activation, Known, Rules, Tensorf};
use potamoi_fields::voxels::Grid;
use potamoi_fields::{FieldError, Table};

/// Voxel edges from sample to sample.
const STEP: f64 = 0.5;
/// Coefficients of colour that perceptrons take: four of red, green and blue.
const COEFFICIENTS: usize = 12;
/// Optical depth of a voxel edge where softplus gives 1: so little that it turns
/// sharply about 0.
const SOFTPLUS: f64 = 1.0 / 16.0;
/// What stands for a density of 0. Softplus gives 0.25 there, and nothing far
/// outside, at -65.
const ZERO: f64 = -1.25;
/// Features of TensoRF's appearance.
const FEATURES: usize = 27;
/// Optical depth a voxel edge from which on solids are hollow. The shell about
/// them, a cell more than what is thinner, lets less than 1/1000 through.
const DEEP: f32 = 5.0;
/// Terms of a mode, of density and of appearance.
const RANKS: [usize; 2] = [16, 48];

/// The densities of a grid, scaled for softplus, and its colours.
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

/// Vertices that have one of positive density next to them, or are one: a sample
/// whose nearest vertex is none of these is in a cell without any.
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

/// What softplus makes a density of, an optical depth a voxel edge.
fn before_softplus(density: f64) -> f64 {
    let scaled = density / SOFTPLUS;
    if density > 0.0 {
        // ln(e^x - 1), for large x without overflow.
        (scaled + (-(-scaled).exp_m1()).ln()).max(ZERO)
    } else {
        ZERO + scaled
    }
}

/// Factors through the vertices of all cells in which something is seen. Solids
/// are hollow: no light gets through their shell.
pub(crate) fn tensorf(grid: &Grid) -> Result<Tensorf, FieldError> {
    let points = grid.points();
    let channels = grid.layout().channels();
    let density = |vertex: usize| grid.features()[vertex * channels];
    let vertices: usize = points.iter().product();
    let deep = |vertex: usize| density(vertex) >= DEEP;
    let filled: Vec<bool> = (0..vertices)
        .map(|v| density(v) > 0.0 && !deep(v))
        .collect();
    let mut known = Known {
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

/// The largest value of each vertex and its 26 neighbours: along one axis after
/// another.
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
