//! Forms of the engine, as they are built.

use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm};
use potamoi_formats::units::OpCode;
use potamoi_reference::exact_exponential::ExactExponential;
use potamoi_reference::exponential::ReferenceExponential;
use potamoi_reference::widths::budget;
use potamoi_synth::fit::{Fit, ScaledEstimate, Work};
use potamoi_synth::{SynthError, UnitKind, scaling};
use potamoi_units::vector_unit::error_bound;

use super::Method;
use crate::ExploreError;

/// Node in nanometres for area and energy.
const NODE_NM: u32 = 12;

/// Estimate of the vector unit at full utilisation, at 12 nm.
fn hardware(fit: &Fit, config: &Config) -> Result<Option<ScaledEstimate>, ExploreError> {
    let node = fit.grid().library.node_nm;
    let factors = node.and_then(|nm| scaling::logic(nm, NODE_NM));
    let work = Work {
        busy: 1.0,
        channels: 0,
    };
    match (fit.estimate(config, UnitKind::Vector, work), factors) {
        (Ok(unit), Some(factors)) => Ok(Some(unit.scaled(&factors))),
        (Err(SynthError::NotFitted { .. }), _) | (_, None) => Ok(None),
        (Err(error), _) => Err(error.into()),
    }
}

fn method(
    fit: &Fit,
    family: &'static str,
    name: String,
    exp: ExpConfig,
) -> Result<Method, ExploreError> {
    let fail = |e: &dyn std::fmt::Display| ExploreError::Inconclusive(e.to_string());
    let reference = ExactExponential::in_base(exp.input, exp.base).map_err(|e| fail(&e))?;
    let twin = ReferenceExponential::new(&exp);
    let error = reference.measure(exp.output_bits, |u| twin.exp(u));
    let clocks = match (exp.pipelined, exp.early_out) {
        (true, _) => 1.0,
        (_, true) => {
            let (mut sum, mut count) = (0.0, 0.0);
            for u in reference.codes() {
                sum += f64::from(exp.clocks_of(twin.exponent(OpCode::Exp, u)));
                count += 1.0;
            }
            sum / count
        }
        _ => f64::from(exp.interval()),
    };
    let mut config = Config::paper();
    config.vu.exp = exp.clone();
    let hardware = hardware(fit, &config)?;
    let netlist = error_bound(&config, OpCode::Exp).map_err(|e| fail(&e))?;
    Ok(Method {
        name,
        family,
        clocks,
        max_ulp: error.max_ulp,
        mean_ulp: error.mean,
        bound_ulp: Some(budget(&exp)),
        netlist_ulp: netlist.map(|bound| bound.ulp),
        monotone: error.monotone,
        area_mm2: hardware.as_ref().map(|unit| unit.area_um2 * 1e-6),
        energy_pj: (hardware.as_ref())
            .map(|unit| unit.with_glitches_pj * clocks / f64::from(config.vu.lanes)),
    })
}

/// Forms of the paper's engine and its alternatives, with derived widths.
pub(super) fn forms() -> Result<Vec<Method>, ExploreError> {
    let fit = Fit::checked_in()?;
    let paper = Config::paper().vu.exp;
    let mut all = vec![];
    for n in [8, 10, 12, 14, 16, 20, 24, 27] {
        let exp = ExpConfig {
            iterations: n,
            ..paper.clone()
        };
        let name = format!(
            "restoring, n = {n}{}",
            if n == 16 { " (the paper's)" } else { "" }
        );
        all.push(method(&fit, "restoring", name, exp)?);
    }
    for n in [4, 6, 8, 9, 14] {
        let exp = ExpConfig {
            iterations: n,
            tail: true,
            ..paper.clone()
        };
        all.push(method(
            &fit,
            "with a tail",
            format!("restoring, n = {n}, tail"),
            exp,
        )?);
    }
    let early = ExpConfig {
        early_out: true,
        ..paper.clone()
    };
    all.push(method(
        &fit,
        "early out",
        "restoring, n = 16, early out".to_owned(),
        early,
    )?);
    for n in [3, 4, 5] {
        let exp = ExpConfig {
            form: ExpForm::Radix4,
            iterations: n,
            tail: true,
            ..paper.clone()
        };
        all.push(method(
            &fit,
            "radix 4 with a tail",
            format!("radix 4, J = {n}, tail"),
            exp,
        )?);
    }
    for base in [ExpBase::E, ExpBase::Two] {
        for pieces in [64, 128, 256] {
            let exp = ExpConfig {
                form: ExpForm::Piecewise,
                base,
                pieces,
                pipelined: true,
                ..paper.clone()
            };
            let (family, power) = match base {
                ExpBase::E => ("straight pieces", ""),
                ExpBase::Two => ("straight pieces of 2^-u", " of 2^-u"),
            };
            all.push(method(
                &fit,
                family,
                format!("{pieces} pieces{power}"),
                exp,
            )?);
        }
    }
    Ok(all)
}
