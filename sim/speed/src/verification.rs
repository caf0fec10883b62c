//! A whole verification, beside the C++ testbench for the clocks that it simulates.

use potamoi_formats::config::Config;
use potamoi_rtl::EngineKind;
use potamoi_rtl::verify::{Settings, Verifier};
use potamoi_scene::Scene;

use crate::error::SpeedError;
use crate::frame_name;
use crate::row::{Beside, Figure, Kind, Row, Section};
use crate::sizes::Sizes;
use crate::time::Meter;
use crate::units::Units;

/// Scene whose frame is verified.
const SCENE: &str = "garden";
/// Runs are made side by side.
const THREADS: usize = 2;
/// Number of steps of [`row`].
pub(crate) const STEPS: u64 = 1;

/// Clocks of both runs, without stalls and with them: of the gathering unit, and of the vector unit.
type Simulated = [u64; 2];

/// A frame verified in full, with models that are already built.
///
/// # Errors
/// A scene that cannot be opened.
pub(crate) fn row(
    sizes: &Sizes,
    runs: u32,
    units: &Units,
    meter: &mut Meter,
    begin: &mut dyn FnMut(&str),
) -> Result<Row, SpeedError> {
    begin("verification");
    let config = (sizes.config)();
    let mut scene = Scene::open(SCENE)?;
    scene.set_size(Some(sizes.verify), None)?;
    let found = match &units.gathering {
        // Models are built before any time is taken.
        Ok(_) => verified(&scene, &config)
            .and_then(|_| meter.fastest(runs, THREADS, || verified(&scene, &config))),
        Err(why) => Err(why.clone()),
    };
    let what = format!("verify {}, full", frame_name::of_scene(&scene));
    Ok(of(what, &found, units))
}

fn of(what: String, found: &Result<(f64, Simulated), String>, units: &Units) -> Row {
    let limit = found.as_ref().map_err(Clone::clone);
    let limit = limit.and_then(|(_, clocks)| limit_of(*clocks, units));
    let beside = Beside::new(Kind::Limit, "C++ testbench", &limit);
    let figure = found.as_ref().map(|(ms, _)| *ms).map_err(Clone::clone);
    let origin = "the frame rendered by the reference units, and every gather and vector operation of it \
                  compared in every bit and clock, without stalls and again with them, by models that \
                  are already built; beside: the same number of clocks by the C++ testbench of each \
                  unit, with the stimulus of another scene, and nothing compared";
    let row = Row::new(Section::Verify, what, &figure, beside, origin);
    match found {
        Ok((_, [gathering, vector])) => row.with_counts([
            ("clocks of the gathering unit", *gathering),
            ("clocks of the vector unit", *vector),
        ]),
        Err(_) => row,
    }
}

/// Milliseconds that the testbenches take for the clocks of both units.
fn limit_of(clocks: Simulated, units: &Units) -> Figure {
    let [gathering, vector] = [&units.gathering, &units.vector].map(|unit| match unit {
        Ok(clocks) => Ok(clocks.cpp),
        Err(why) => Err(why.clone()),
    });
    let ns = clocks[0] as f64 * gathering? + clocks[1] as f64 * vector?;
    Ok(1e-6 * ns)
}

/// Verifies the frame, and gives the clocks that were compared.
fn verified(scene: &Scene, config: &Config) -> Result<Simulated, String> {
    let settings = Settings {
        engine: EngineKind::Verilator,
        seed: 1,
        gather_every: 1,
        vector_every: 1,
        splat_every: 1,
        inject: None,
        rtl: None,
        excerpt: None,
    };
    let mut ignore = |_| ();
    let mut verifier = Verifier::new(config, settings, &mut ignore);
    let done = scene.render_fixed(config, &mut verifier);
    let finished = verifier.finish();
    done.map_err(|error| error.to_string())?;
    finished.map_err(|error| error.to_string())?;
    Ok([
        verifier.gather_report().cycles_compared,
        verifier.vector_report().cycles_compared,
    ])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_missing_tool_is_the_reason() {
        let units = Units::without("no verilator");
        let row = of("verify".to_owned(), &Err("no verilator".to_owned()), &units);
        assert_eq!((row.measured, row.ratio), (None, None));
        assert_eq!(row.beside.why.as_deref(), Some("no verilator"));
        // The models of one unit alone do not make a limit.
        let row = of("verify".to_owned(), &Ok((5.0, [3, 4])), &units);
        assert_eq!(
            (row.measured, row.beside.value, row.ratio),
            (Some(5.0), None, None)
        );
        assert_eq!(row.counts[1].count, 4);
    }
}
