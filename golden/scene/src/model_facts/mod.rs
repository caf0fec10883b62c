//! Facts about a model's data that do not depend on the camera.

mod cache;
mod thickness;

use crate::{Kind, Model};
pub(crate) use cache::Cache;
use potamoi_base::sh_degrees::{self, Bands};
use potamoi_fields::{
    Directions, Field, HashedColour, Mlp, StoredDensity, Table, WithEarlyTermination,
};
use potamoi_gaussians::{Cloud, sigmoid};
use potamoi_splats::Rules;
pub use thickness::Thickness;

/// A table of features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableFacts {
    /// Number of vertices that a sample reads: 1, 2, 4 or 8.
    pub vertices: usize,
    /// Channels a vertex.
    pub channels: usize,
    /// Number of rows.
    pub rows: usize,
    /// Whether vertices share rows.
    pub is_hashed: bool,
}

/// View dependence of a perceptron.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Perceptron {
    /// Number of inputs of its first layer, and how many of them encode the direction.
    pub inputs: [usize; 2],
    /// Number of weights of these inputs, and how many of them are not 0.
    pub weights: [u64; 2],
}

/// Facts about a model's data.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelFacts {
    /// Name and number of its parts.
    pub parts: (&'static str, u64),
    /// Spherical harmonics, if any.
    pub harmonics: Option<Bands>,
    /// Name of the owners of their coefficients.
    pub holders: &'static str,
    /// The perceptron that computes colours, if any.
    pub perceptron: Option<Perceptron>,
    /// Upper bound of the optical depth along a ray.
    pub thickness: Thickness,
    /// Number of weights and biases of all perceptrons.
    pub weights: usize,
    /// Tables of features, before records of splats.
    pub tables: Vec<TableFacts>,
    /// Number of empty cells and of all cells, if a grid marks empty space.
    pub void: Option<[u64; 2]>,
    /// The largest opacity value: a density as optical depth a voxel edge, or a Gaussian's
    /// opacity. `None` for fields that compute it.
    pub most_opaque: Option<f64>,
}

impl ModelFacts {
    /// Determines the facts of a model. `rules` are those of splats, `stop` overrides the
    /// early-termination threshold (transmittance).
    #[must_use]
    pub fn of(model: &Model, rules: &Rules, stop: Option<f64>) -> Self {
        match (model, model.kind()) {
            (Model::Compact(compact), _) => Self {
                tables: tables(compact.colour().tables()),
                holders: "neurons",
                perceptron: Some(perceptron(compact.colour().head(), &compact_inputs())),
                harmonics: Some(harmonics(compact.colour().head(), &compact_inputs())),
                weights: compact.colour().head().len(),
                ..of_cloud(compact.gaussians(), rules)
            },
            (_, Kind::Splats(cloud)) => of_cloud(cloud, rules),
            (_, Kind::Field(field)) => of_field(&WithEarlyTermination::new(field, stop)),
        }
    }

    /// The highest degree of spherical harmonics that affects the picture.
    #[must_use]
    pub fn highest_harmonic(&self) -> usize {
        self.harmonics.as_ref().map_or(0, Bands::highest)
    }

    /// The highest degree that is stored.
    #[must_use]
    pub fn stored_harmonics(&self) -> usize {
        self.harmonics.map_or(0, |bands| bands.stored)
    }

    /// Whether a perceptron's colours depend on the direction.
    #[must_use]
    pub fn sees_directions(&self) -> bool {
        self.perceptron.is_some_and(|own| own.weights[1] > 0)
    }

    /// Whether any part of the model can be visible.
    #[must_use]
    pub fn can_be_seen(&self) -> bool {
        self.most_opaque.is_none_or(|most| most > 0.0)
    }

    /// Number of tables whose vertices share entries.
    #[must_use]
    pub fn hashed_tables(&self) -> usize {
        self.tables.iter().filter(|table| table.is_hashed).count()
    }
}

fn compact_inputs() -> Vec<usize> {
    HashedColour::direction_inputs()
}

fn tables(all: &[Table]) -> Vec<TableFacts> {
    let facts = |table: &Table| TableFacts {
        vertices: table.vertices(),
        channels: table.channels(),
        rows: table.rows(),
        is_hashed: table.is_hashed(),
    };
    all.iter().map(facts).collect()
}

fn perceptron(mlp: &Mlp, inputs: &[usize]) -> Perceptron {
    Perceptron {
        inputs: [mlp.inputs(), inputs.len()],
        weights: mlp.weights_of(inputs),
    }
}

/// Spherical harmonics that are inputs of a perceptron, by degree: for each the number of neurons
/// of the first layer that use it.
fn harmonics(mlp: &Mlp, inputs: &[usize]) -> Bands {
    let first = &mlp.layers()[..1.min(mlp.layers().len())];
    let rows = first
        .iter()
        .flat_map(|layer| layer.weights().chunks_exact(layer.inputs()));
    let holders = rows.map(|row| {
        let own = inputs.iter().map(|i| row.get(*i..=*i).unwrap_or_default());
        sh_degrees::used(own)
    });
    Bands::of(inputs.len().isqrt().saturating_sub(1), holders)
}

fn of_cloud(cloud: &Cloud, rules: &Rules) -> ModelFacts {
    let coefficients = |index| {
        let own = cloud.sh(index).iter();
        sh_degrees::used(own.map(<[f32; 3]>::as_slice))
    };
    let mut thickness = Thickness {
        depth: 0.0,
        samples: cloud.len() as f64,
        stop: rules.stop_below,
    };
    let mut most = 0f64;
    for logit in cloud.opacity_logits() {
        let opacity = sigmoid(f64::from(*logit)).min(rules.alpha_cap);
        most = most.max(opacity);
        // Fainter ones are skipped; a record's code may be half a unit above.
        if opacity + 1e-5 >= rules.alpha_min {
            thickness.depth -= (-opacity).ln_1p();
        }
    }
    ModelFacts {
        parts: ("Gaussians", cloud.len() as u64),
        harmonics: Some(Bands::of(
            cloud.degree(),
            (0..cloud.len()).map(coefficients),
        )),
        holders: "Gaussians",
        perceptron: None,
        weights: 0,
        thickness,
        tables: vec![],
        void: None,
        most_opaque: Some(most),
    }
}

fn of_field(field: &dyn Field) -> ModelFacts {
    let (harmonics, perceptron, holders) = match field.directions() {
        Directions::None => (None, None, "rows"),
        Directions::Harmonics { bands, holders } => (Some(bands), None, holders),
        Directions::Perceptron {
            mlp,
            inputs,
            are_harmonics,
        } => {
            let bands = are_harmonics.then(|| harmonics(mlp, &inputs));
            (bands, Some(perceptron(mlp, &inputs)), "neurons")
        }
    };
    let tables = tables(field.tables());
    let stop = field.sampling().stop;
    let stored = field.stored();
    let densities = stored.map(StoredDensity::densities);
    let parts = stored.map_or("rows", StoredDensity::owners);
    ModelFacts {
        parts: (parts, tables.iter().map(|table| table.rows as u64).sum()),
        harmonics,
        holders,
        perceptron,
        weights: field.perceptrons().into_iter().map(Mlp::len).sum(),
        thickness: densities.map_or(Thickness::unknown(stop), |own| Thickness {
            depth: own.depth,
            samples: own.samples,
            stop,
        }),
        tables,
        void: field.void(),
        most_opaque: densities.map(|own| own.most),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_splats::Profile;

    /// What is not skipped takes light, however little above the limit it is.
    #[test]
    fn gaussians_that_are_drawn_take_light() {
        let rules = &Profile::Inria.rules();
        let depth = |opacity: f64| {
            let n = 100;
            let logit = (opacity / (1.0 - opacity)).ln() as f32;
            let cloud = Cloud::new(
                0,
                vec![[0.0; 3]; n],
                vec![[0.0; 3]; n],
                vec![[1.0, 0.0, 0.0, 0.0]; n],
                vec![logit; n],
                vec![[0.0; 3]; n],
            );
            of_cloud(&cloud.unwrap(), rules).thickness.depth
        };
        for over in [1.0001f64, 1.005, 1.02, 2.0] {
            let opacity = over * rules.alpha_min;
            let expected = -100.0 * (-opacity).ln_1p();
            let found = depth(opacity);
            assert!((found / expected - 1.0).abs() < 1e-4, "{over}: {found}");
        }
        assert_eq!(depth(0.99 * rules.alpha_min), 0.0);
    }
}
