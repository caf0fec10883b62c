//! Tests of the fixed-point renderer's error bound.

use super::*;
use potamoi_reference::bounds::VectorBounds;

/// Largest ratios of the errors of colour and transmittance to their bounds, for a configuration
/// and a number of transmittance bits each.
fn used(grid: &Grid, bounded: (&Config, u32), shown: (&Config, u32)) -> [f64; 2] {
    let camera = camera(40, 36);
    let formats = Formats::new(grid, bounded.0).unwrap();
    let to_the_end = FloatOptions {
        terminate: false,
        ..FloatOptions::default()
    };
    let float = float(grid, &camera, &to_the_end);
    let options = |transmittance_bits| FixedOptions {
        terminate: false,
        transmittance_bits,
        ..FixedOptions::default()
    };
    let bounds = error_bounds(
        &field(grid),
        &formats,
        &VectorBounds::by_formula(&bounded.0.vu.exp),
        &camera,
        &options(bounded.1),
        STOP_BELOW,
    );
    let fixed = fixed(grid, shown.0, &camera, &options(shown.1));
    let least = float.transmittance.iter().copied().fold(1.0, f64::min);
    assert!((0.005..0.5).contains(&least), "{least}");
    let mut used = [0f64; 2];
    for (i, [colour, left]) in bounds.into_iter().enumerate() {
        let t = f64::from(fixed.transmittance[i]) / f64::from(1 << 20);
        used[1] = used[1].max((t - float.transmittance[i]).abs() / left.max(f64::MIN_POSITIVE));
        for c in 0..3 {
            let (a, b) = (fixed.picture.rgb[i][c], float.picture.rgb[i][c]);
            used[0] = used[0].max((f64::from(a) - f64::from(b)).abs() / colour);
        }
    }
    used
}

#[test]
fn fixed_stays_within_a_derived_bound_of_float() {
    for layout in [Layout::Constant, Layout::Linear] {
        let dense = blob([19, 16, 23], layout);
        let channels = layout.channels();
        // Thin, so that light is left behind all of it.
        let thin = dense.features().iter().enumerate();
        let thin = thin.map(|(i, v)| if i % channels == 0 { v * 0.15 } else { *v });
        let grid = Grid::new(
            dense.points(),
            dense.corner(),
            dense.voxel(),
            layout,
            thin.collect(),
        )
        .unwrap();
        for text in [
            "",
            "[gu]\nweight_bits = 8",
            "[gu]\nfeature_bits = 10\nweight_bits = 10",
            "[gu]\nweight_bits = 4",
        ] {
            let config = config(text);
            let used = used(&grid, (&config, 20), (&config, 20));
            println!("{layout:?} {text:?}: {used:.3?} of the bound");
            assert!(used.iter().all(|u| *u <= 1.0 && *u > 0.01), "{used:?}");
        }
        // The bound of the paper's formats tells coarser ones.
        let [colour, left] = used(
            &grid,
            (&config(""), 20),
            (&config("[gu]\nweight_bits = 4"), 20),
        );
        assert!(colour > 1.0 && left > 1.0, "{colour} {left}");
        let paper = config("");
        let own = used(&grid, (&paper, 9), (&paper, 9));
        assert!(own.iter().all(|u| *u <= 1.0 && *u > 0.01), "{own:?}");
        let [colour, left] = used(&grid, (&paper, 20), (&paper, 9));
        assert!(colour > 1.0 && left > 1.0, "{colour} {left}");
    }
}

/// A ray that stops early leaves out at most its threshold, which exceeds the bound of rays that
/// do not stop.
#[test]
fn what_a_stop_leaves_out_counts() {
    let grid = blob([19, 16, 23], Layout::Constant);
    let (config, camera) = (config(""), camera(40, 36));
    let formats = Formats::new(&grid, &config).unwrap();
    let options = |terminate| FixedOptions {
        terminate,
        ..FixedOptions::default()
    };
    let to_the_end = FloatOptions {
        terminate: false,
        ..FloatOptions::default()
    };
    let float = float(&grid, &camera, &to_the_end);
    let stored = field(&grid);
    let early = WithEarlyTermination::new(&stored, Some(0.05));
    let made = FixedField::new(&early, &config).unwrap();
    let stopped = made.render(&camera, &options(true), &mut ReferenceUnits::new(&config));
    let stopped = stopped.unwrap();
    let used = |terminate| {
        let exp = &config.vu.exp;
        let bounds = error_bounds(
            &stored,
            &formats,
            &VectorBounds::by_formula(exp),
            &camera,
            &options(terminate),
            0.05,
        );
        let pixels = stopped.picture.rgb.iter().zip(&float.picture.rgb);
        let parts = pixels.zip(bounds).map(|((a, b), [colour, _])| {
            let off = a.iter().zip(b).map(|(a, b)| f64::from((a - b).abs()));
            off.fold(0.0, f64::max) / colour
        });
        parts.fold(0.0, f64::max)
    };
    let [own, to_the_end] = [true, false].map(used);
    assert!(own <= 1.0 && to_the_end > 1.0, "{own} {to_the_end}");
}
