//! Values of a snapshot that do not fit are refused by their name.

use std::path::Path;

use potamoi_fields::algorithms::ngp::Ngp;

use super::{at, expanded, load, patched};

#[test]
fn numbers_that_are_none_and_boxes_that_are_none_are_refused() {
    use rmpv::Value;
    // Halves: not a number, and plus and minus infinity.
    for half in [0x7e00u16, 0x7c00, 0xfc00] {
        // Parameters of this fixture have 32 bits, of which these would be half.
        {
            let field = "snapshot.density_grid_binary";
            let bytes = patched(|d| {
                let Value::Binary(all) = at(d, field) else {
                    unreachable!()
                };
                all[20..22].copy_from_slice(&half.to_le_bytes());
            });
            let error = load(&bytes).unwrap_err();
            let expected = format!("`{field}` is {} at number 10", half::f16::from_bits(half));
            assert!(error.contains(&expected), "{error}");
        }
    }
    let corner = |x: f64, yz: f64| Value::Array(vec![x.into(), yz.into(), yz.into()]);
    let aabb = |min: f64, max: f64| {
        Value::Map(vec![
            ("min".into(), corner(min, 0.2)),
            ("max".into(), corner(max, 0.8)),
        ])
    };
    for (min, max) in [(0.4, f64::NAN), (f64::NAN, 0.6), (0.6, 0.4), (0.5, 0.5)] {
        let error = load(&patched(|d| {
            *at(d, "snapshot.render_aabb") = aabb(min, max)
        }));
        let error = error.unwrap_err();
        let said = "finite corners, `min` below `max`";
        assert!(
            error.contains("snapshot.render_aabb` is [") && error.contains(said),
            "{error}"
        );
    }
    let off = load(&patched(|d| {
        *at(d, "snapshot.render_aabb") = aabb(5.0, 6.0)
    }));
    let off = off.unwrap_err();
    assert!(off.contains("a box that meets `aabb`"), "{off}");
    // One number too many.
    let long = Value::Array(vec![0.5.into(); 4]);
    let error = load(&patched(|d| {
        *at(d, "snapshot.nerf.dataset.offset") = long.clone()
    }));
    let error = error.unwrap_err();
    assert!(
        error.contains("offset") && error.contains("too many values"),
        "{error}"
    );
    for word in ["u32", "struct", "invalid type", "marker"] {
        for (field, value) in [
            ("encoding", Value::from(3)),
            ("snapshot.version", Value::from("one")),
            ("snapshot.params_binary", Value::Array(vec![])),
            ("encoding.n_levels", Value::from(-1)),
            ("encoding.n_levels", Value::from(1.5)),
        ] {
            let error = load(&patched(|d| *at(d, field) = value.clone())).unwrap_err();
            assert!(
                error.contains(field) && !error.contains(word),
                "{word}: {error}"
            );
        }
    }
}

/// What is found in the place of a number or of bytes, however long.
#[test]
fn another_kind_of_value_is_told_shortly() {
    let long = "text".repeat(7000);
    for (field, value, said) in [
        (
            "snapshot.version",
            "1",
            "found \"1\", expected a whole number",
        ),
        ("snapshot.params_binary", &*long, "found \"texttext"),
    ] {
        let error = load(&patched(|d| *at(d, field) = value.into()))
            .err()
            .unwrap();
        assert!(error.contains(field) && error.contains(said), "{error}");
        assert!(error.len() < 300, "{error}");
    }
}

/// A number without a fraction is whole, however it is written.
#[test]
fn whole_numbers_may_have_a_point() {
    use rmpv::Value;
    let fields = [
        "encoding.n_levels",
        "snapshot.version",
        "snapshot.nerf.aabb_scale",
    ];
    let bytes = patched(|d| {
        for field in fields {
            let whole = at(d, field).as_u64().unwrap() as f64;
            *at(d, field) = Value::F64(whole);
        }
        *at(d, "snapshot.linear_colors") = false.into();
        *at(d, "snapshot.nerf.linear_colors") = false.into();
    });
    assert_eq!(load(&bytes).unwrap(), load(&expanded()).unwrap());
}

#[test]
fn what_contradicts_itself_is_refused_by_name() {
    use rmpv::Value;
    let per_level = |d: &mut Value| at(d, "encoding.n_features_per_level").as_u64().unwrap();
    let levels = |d: &mut Value| at(d, "encoding.n_levels").as_u64().unwrap();
    let all = |more_levels: u64, more: u64| {
        load(&patched(|d| {
            let all = per_level(d) * (levels(d) + more_levels) + more;
            *at(d, "encoding.n_features") = all.into();
        }))
    };
    assert!(all(0, 0).is_ok());
    assert!(all(0, 1).unwrap_err().contains("`encoding.n_features` is"));
    assert!(all(1, 0).unwrap_err().contains("`encoding.n_levels` is"));
    let harmonics = || {
        let name = ("otype".into(), "SphericalHarmonics".into());
        let inputs = ("n_dims_to_encode".into(), 3.into());
        Value::Array(vec![Value::Map(vec![name, inputs])])
    };
    for (field, values) in [
        (
            "encoding.per_level_scale",
            vec![("encoding.per_level_scale", f64::NAN.into())],
        ),
        (
            "encoding.per_level_scale",
            vec![("encoding.per_level_scale", (-3.0).into())],
        ),
        (
            "encoding.type",
            vec![
                ("encoding.otype", "HashGrid".into()),
                ("encoding.type", "Dense".into()),
            ],
        ),
        (
            "snapshot.linear_colors",
            vec![("snapshot.linear_colors", true.into())],
        ),
        (
            "dir_encoding.nested",
            vec![
                ("dir_encoding.otype", "SphericalHarmonics".into()),
                ("dir_encoding.nested", harmonics()),
            ],
        ),
        (
            "dir_encoding.degree",
            vec![
                ("dir_encoding.otype", "Composite".into()),
                ("dir_encoding.nested", harmonics()),
                ("dir_encoding.degree", 3.into()),
            ],
        ),
    ] {
        let bytes = patched(|d| {
            for (field, value) in &values {
                *at(d, field) = value.clone();
            }
        });
        let error = load(&bytes).unwrap_err();
        assert!(error.contains(&format!("`{field}` is")), "{error}");
    }
}

/// Each field that does not fit is refused by its name.
#[test]
fn what_does_not_fit_is_refused_by_name() {
    use rmpv::Value;
    let short = |size: usize| Value::Binary(vec![0; size]);
    let cases: Vec<(&str, Value)> = vec![
        ("snapshot.version", 2.into()),
        ("snapshot.mode", "sdf".into()),
        ("snapshot.params_binary", short(7)),
        ("snapshot.params_type", "__bfloat".into()),
        ("snapshot.n_params", 3.into()),
        ("snapshot.density_grid_size", 64.into()),
        ("snapshot.density_grid_binary", short(128 * 128)),
        ("snapshot.nerf.aabb_scale", 3.into()),
        ("snapshot.nerf.aabb_scale", 256.into()),
        ("snapshot.nerf.dataset.from_mitsuba", true.into()),
        ("snapshot.nerf.dataset.is_hdr", true.into()),
        ("snapshot.nerf.dataset.scale", 0.into()),
        ("snapshot.nerf.dataset.n_extra_learnable_dims", 8.into()),
        ("encoding.otype", "DenseGrid".into()),
        ("encoding.interpolation", "Smoothstep".into()),
        ("encoding.hash", "Prime".into()),
        ("encoding.hash", "ReversedPrime".into()),
        ("encoding.hash", "Rng".into()),
        ("encoding.n_levels", 0.into()),
        ("encoding.n_features_per_level", 3.into()),
        ("encoding.log2_hashmap_size", 60.into()),
        ("encoding.base_resolution", 1_000_000.into()),
        ("encoding.hash_unit", "voxel".into()),
        ("encoding.per_level_scale", 0.5.into()),
        ("encoding.per_level_scale", 64.0.into()),
        ("dir_encoding.otype", "Frequency".into()),
        ("network.otype", "CutlassMLP".into()),
        ("network.activation", "Sine".into()),
        ("network.n_neurons", 48.into()),
        ("rgb_network.n_hidden_layers", 0.into()),
        ("rgb_network.output_activation", "Sigmoid".into()),
    ];
    for (field, value) in cases {
        let bytes = patched(|document| *at(document, field) = value.clone());
        let error = load(&bytes).unwrap_err();
        assert!(error.contains(&format!("`{field}` is ")), "{error}");
    }
    // Sizes that disagree with the number of parameters.
    for (field, value) in [("encoding.n_levels", 5), ("network.n_neurons", 64)] {
        let bytes = patched(|document| *at(document, field) = value.into());
        let error = load(&bytes).unwrap_err();
        assert!(error.contains("snapshot.params_binary"), "{error}");
    }
    let error = load(&patched(|d| *at(d, "snapshot.nerf.aabb_scale") = 2.into())).unwrap_err();
    assert!(error.contains("snapshot.aabb"), "{error}");
    // Of another kind, missing, or not a snapshot at all.
    let error = load(&patched(|d| *at(d, "encoding.n_levels") = "x".into())).unwrap_err();
    assert!(error.contains("field `encoding.n_levels`"), "{error}");
    let error = load(&patched(|d| *at(d, "snapshot") = Value::Map(vec![]))).unwrap_err();
    assert!(error.contains("`version` is missing"), "{error}");
    for bytes in [&b""[..], b"\x80", b"\x78\x9c\x00", b"\x1f\x8b", b"ply\n"] {
        assert!(load(bytes).is_err());
    }
    let error = Ngp::load(Path::new("no.ingp")).unwrap_err().to_string();
    assert!(error.contains("cannot read snapshot no.ingp"), "{error}");
}

/// The hash that is computed has a name, in any letters; it is the same model.
#[test]
fn the_usual_hash_may_be_named() {
    for name in ["CoherentPrime", "coherentprime"] {
        let named = load(&patched(|d| *at(d, "encoding.hash") = name.into())).unwrap();
        assert_eq!(named, load(&expanded()).unwrap());
        assert!(!named.notes().not_used().join(" ").contains("hash"));
    }
}

/// The first number that is none is told before anything is made of the others.
#[test]
fn parameters_that_are_no_numbers_are_refused_by_place() {
    for (place, value, name) in [(3, f32::NAN, "NaN"), (3000, f32::INFINITY, "inf")] {
        let changed = patched(|document| {
            assert_eq!(at(document, "snapshot.params_type").as_str(), Some("float"));
            let field = at(document, "snapshot.params_binary");
            let mut all = field.as_slice().unwrap().to_vec();
            all[4 * place..][..4].copy_from_slice(&value.to_le_bytes());
            *field = rmpv::Value::Binary(all);
        });
        let error = load(&changed).err().unwrap();
        let said = format!(
            "`snapshot.params_binary` is {name} at number {place}; expected finite numbers alone"
        );
        assert!(error.contains(&said), "{error}");
    }
}
