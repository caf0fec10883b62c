//! The fields that are read from a snapshot. All others are skipped while parsing.

use std::fmt;

use serde::Deserialize;

use super::integers::{maybe_whole, whole};
use serde::de::{Deserializer, Error, IgnoredAny, SeqAccess, Visitor};

/// The whole document.
#[derive(Debug, Deserialize)]
pub(super) struct Document {
    pub(super) encoding: Encoding,
    pub(super) network: Network,
    pub(super) dir_encoding: Direction,
    pub(super) rgb_network: Network,
    pub(super) snapshot: Snapshot,
}

/// The hash grid.
#[derive(Debug, Deserialize)]
pub(super) struct Encoding {
    pub(super) otype: String,
    #[serde(rename = "type")]
    pub(super) kind: Option<String>,
    pub(super) interpolation: Option<String>,
    pub(super) stochastic_interpolation: Option<bool>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_levels: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_features: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_features_per_level: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) log2_hashmap_size: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) base_resolution: Option<u32>,
    pub(super) per_level_scale: Option<f32>,
    /// How the entry of a vertex is found.
    pub(super) hash: Option<String>,
    /// An extension of this project: what shares an entry of a hashed level.
    pub(super) hash_unit: Option<String>,
}

/// The encoding of directions.
#[derive(Debug, Deserialize)]
pub(super) struct Direction {
    pub(super) otype: String,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) degree: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_dims_to_encode: Option<u32>,
    pub(super) nested: Option<First>,
}

/// The first part of a composite encoding; the others are skipped, however many.
#[derive(Debug)]
pub(super) struct First(pub(super) Box<Direction>);

impl<'de> Deserialize<'de> for First {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Parts;
        impl<'de> Visitor<'de> for Parts {
            type Value = First;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a list of encodings")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut parts: A) -> Result<First, A::Error> {
                let first = parts.next_element()?;
                let first = first.ok_or_else(|| A::Error::custom("an empty list"))?;
                while parts.next_element::<IgnoredAny>()?.is_some() {}
                Ok(First(Box::new(first)))
            }
        }
        deserializer.deserialize_seq(Parts)
    }
}

/// A perceptron.
#[derive(Debug, Deserialize)]
pub(super) struct Network {
    pub(super) otype: String,
    pub(super) activation: Option<String>,
    pub(super) output_activation: Option<String>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_neurons: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_hidden_layers: Option<u32>,
    #[serde(default, deserialize_with = "maybe_whole")]
    pub(super) n_output_dims: Option<u32>,
}

/// The trained parameters.
#[derive(Debug, Deserialize)]
pub(super) struct Snapshot {
    #[serde(deserialize_with = "whole")]
    pub(super) version: u32,
    pub(super) mode: Option<String>,
    pub(super) n_params: Option<u64>,
    pub(super) params_type: Option<String>,
    pub(super) params_binary: Binary,
    #[serde(deserialize_with = "whole")]
    pub(super) density_grid_size: u32,
    pub(super) density_grid_binary: Binary,
    pub(super) nerf: Nerf,
    pub(super) aabb: Option<Bounds>,
    pub(super) render_aabb: Option<Bounds>,
    pub(super) render_aabb_to_local: Option<[[f64; 3]; 3]>,
    pub(super) linear_colors: Option<bool>,
}

/// The description of the scene.
#[derive(Debug, Deserialize)]
pub(super) struct Nerf {
    #[serde(deserialize_with = "whole")]
    pub(super) aabb_scale: u32,
    pub(super) dataset: Option<Dataset>,
    pub(super) linear_colors: Option<bool>,
}

/// The training pictures.
#[derive(Debug, Deserialize)]
pub(super) struct Dataset {
    pub(super) scale: Option<f64>,
    pub(super) offset: Option<[f64; 3]>,
    #[serde(default)]
    pub(super) from_mitsuba: bool,
    #[serde(default)]
    pub(super) is_hdr: bool,
    #[serde(default, deserialize_with = "whole")]
    pub(super) n_extra_learnable_dims: u32,
}

/// A box.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(super) struct Bounds {
    pub(super) min: [f64; 3],
    pub(super) max: [f64; 3],
}

/// Bytes, which MessagePack distinguishes from lists of numbers.
pub(super) struct Binary(pub(super) Vec<u8>);

impl fmt::Debug for Binary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} bytes", self.0.len())
    }
}

impl<'de> Deserialize<'de> for Binary {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Bytes;
        impl Visitor<'_> for Bytes {
            type Value = Binary;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("binary data")
            }

            fn visit_bytes<E: Error>(self, bytes: &[u8]) -> Result<Binary, E> {
                Ok(Binary(bytes.to_owned()))
            }

            fn visit_byte_buf<E: Error>(self, bytes: Vec<u8>) -> Result<Binary, E> {
                Ok(Binary(bytes))
            }
        }
        // Whatever it is, so that another kind of value can be told.
        deserializer.deserialize_any(Bytes)
    }
}
