//! Checkpoints of the authors' layout whose container is whole and whose
//! contents are not.

#![allow(clippy::unwrap_used)]

use proptest::prelude::*;

use super::Tensorf;
use crate::FixedField;
use crate::test_checkpoints::{Content, harms, survives};

/// A small one, with everything that is read.
fn whole() -> Content {
    let points = [4usize, 3, 5];
    let (density, appearance) = ([2usize, 1, 1], [1usize, 2, 1]);
    let mut state = vec![];
    for mode in 0..3 {
        let [a, b] = super::PLANES[mode].map(|axis| points[axis]);
        let along = points[super::LINES[mode]];
        for (of, count) in [("density", density[mode]), ("app", appearance[mode])] {
            state.push((
                format!("{of}_plane.{mode}"),
                Content::tensor(&[1, count, b, a]),
            ));
            state.push((
                format!("{of}_line.{mode}"),
                Content::tensor(&[1, count, along, 1]),
            ));
        }
    }
    // Three features and the direction, with one frequency each.
    for (name, shape) in [
        ("basis_mat.weight", &[3usize, 4][..]),
        ("renderModule.mlp.0.weight", &[4, 18]),
        ("renderModule.mlp.0.bias", &[4]),
        ("renderModule.mlp.2.weight", &[4, 4]),
        ("renderModule.mlp.2.bias", &[4]),
        ("renderModule.mlp.4.weight", &[3, 4]),
        ("renderModule.mlp.4.bias", &[3]),
    ] {
        state.push((name.to_owned(), Content::tensor(shape)));
    }
    let corners = [-1.0, -1.0, -1.0, 1.0, 1.0, 1.0].map(Content::Float);
    let aabb = Content::List(corners.into());
    let kwargs = Content::dict([
        ("aabb", aabb.clone()),
        ("gridSize", Content::whole(&[4, 3, 5])),
        ("density_n_comp", Content::whole(&[2, 1, 1])),
        ("appearance_n_comp", Content::whole(&[1, 2, 1])),
        ("app_dim", Content::Int(3)),
        ("density_shift", Content::Float(-1.0)),
        ("distance_scale", Content::Float(25.0)),
        ("rayMarch_weight_thres", Content::Float(1e-4)),
        ("fea2denseAct", Content::text("softplus")),
        (
            "near_far",
            Content::List([0.1, 6.0].map(Content::Float).into()),
        ),
        ("step_ratio", Content::Float(0.5)),
        ("shadingMode", Content::text("MLP_Fea")),
        ("view_pe", Content::Int(1)),
        ("fea_pe", Content::Int(1)),
        ("featureC", Content::Int(4)),
        ("pos_pe", Content::Int(6)),
    ]);
    Content::dict([
        ("kwargs", kwargs),
        ("state_dict", Content::Dict(state)),
        ("alphaMask.shape", Content::whole(&[1, 1, 2, 2, 4])),
        (
            "alphaMask.mask",
            Content::Tensor(vec![2], vec![255.0, 254.0]),
        ),
        ("alphaMask.aabb", aabb),
    ])
}

#[test]
fn the_whole_one_is_read() {
    let field = Tensorf::load(whole().save().path()).unwrap();
    assert_eq!(field.points(), [4, 3, 5]);
    assert!(field.mask.is_some());
    let ignored = ["kwargs/pos_pe", "the far end of kwargs/near_far"];
    assert_eq!(field.notes.not_used(), ignored);
}

/// The nearest depth alone is used, but what contradicts itself is no range.
#[test]
fn depths_that_are_no_range_are_refused() {
    for range in [[6.0, 2.0], [2.0, f64::NAN], [2.0, 2.0], [-1.0, 2.0]] {
        let Content::Dict(mut root) = whole() else {
            unreachable!()
        };
        let Some((_, Content::Dict(items))) = root.iter_mut().find(|(key, _)| key == "kwargs")
        else {
            unreachable!()
        };
        items.retain(|(key, _)| key != "near_far");
        let value = Content::List(range.map(Content::Float).into());
        items.push(("near_far".to_owned(), value));
        let error = Tensorf::load(Content::Dict(root).save().path());
        let error = error.unwrap_err().to_string();
        let said = format!("`kwargs/near_far` is {range:?}; expected finite depths");
        assert!(error.contains(&said), "{error}");
    }
}

/// Keys of other models by name; the others, known or not, are used or listed.
#[test]
fn every_key_is_honoured_refused_or_listed() {
    use potamoi_base::file_keys::Fate;
    let rows = super::TENSORF.keys.iter().map(|row| (row.name, row.fate));
    let new = [("news", Fate::Listed), ("kwargs/news", Fate::Listed)];
    for (name, fate) in rows.chain(new).filter(|(_, fate)| *fate != Fate::Honoured) {
        let key = name.replace('*', "_new");
        let Content::Dict(mut root) = whole() else {
            unreachable!()
        };
        let made = Content::Tensor(vec![1], vec![0.0]);
        match key.split_once('/') {
            None => root.push((key.clone(), made)),
            Some((part, name)) => {
                let held = root.iter_mut().find(|(known, _)| known == part);
                let Some((_, Content::Dict(items))) = held else {
                    unreachable!()
                };
                items.retain(|(known, _)| known != name);
                items.push((name.to_owned(), made));
            }
        }
        match (fate, Tensorf::load(Content::Dict(root).save().path())) {
            (Fate::Refused, Err(error)) => {
                let error = error.to_string();
                assert!(
                    error.contains(&format!("`{key}` cannot be honoured")),
                    "{error}"
                );
            }
            (Fate::Whole, Err(error)) => {
                let error = error.to_string();
                assert!(
                    error.contains(&format!("`{key}` is out of sequence")),
                    "{error}"
                );
            }
            (Fate::Listed, Ok(field)) => assert!(field.notes.not_used().contains(&key), "{key}"),
            (_, loaded) => unreachable!("{key}: {:?}", loaded.err()),
        }
    }
}

/// The tensors of a made file, by name.
type Tensors = Vec<(String, Content)>;

/// Of planes, lines and layers each is used, or the file is refused by the key that is missing or
/// left.
#[test]
fn a_model_is_whole_or_refused_by_key() {
    let changed = |change: &dyn Fn(&mut Tensors)| {
        let Content::Dict(mut root) = whole() else {
            unreachable!()
        };
        for (key, held) in &mut root {
            if let ("state_dict", Content::Dict(items)) = (&**key, held) {
                change(items);
            }
        }
        let loaded = Tensorf::load(Content::Dict(root).save().path());
        loaded.map(|_| ()).map_err(|error| error.to_string())
    };
    for layer in [0, 2, 4] {
        for part in ["weight", "bias"] {
            let name = format!("renderModule.mlp.{layer}.{part}");
            let error = changed(&|items| items.retain(|(key, _)| *key != name));
            let said = format!("`state_dict/{name}` is missing");
            assert!(error.unwrap_err().contains(&said), "{name}");
        }
    }
    for name in [
        "renderModule.mlp.6.weight",
        "renderModule.mlp.1.bias",
        "basis_mat.bias",
        "density_plane.3",
        "app_line.3",
    ] {
        let error = changed(&|items| items.push((name.to_owned(), Content::tensor(&[3, 3]))));
        let said = format!("`state_dict/{name}` is out of sequence");
        assert!(error.unwrap_err().contains(&said), "{name}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_contents_are_a_field_or_one_clear_error(harms in harms()) {
        let config = potamoi_formats::config::Config::preset("fields").unwrap();
        survives(&whole(), &harms, Tensorf::load, |field| {
            let _ = FixedField::new(field, &config);
        })?;
    }
}
