//! Verification of settings: their Verilog against the golden models.

use potamoi_formats::config::Config;
use potamoi_reference::ReferenceUnits;
use potamoi_rtl::EngineKind;
use potamoi_rtl::verify::{Injection, Settings, Verifier};
use potamoi_scene::Scene;

use super::bench::Bench;
use super::knobs::Setting;
use crate::verification::Extent;
use crate::{ExploreError, Progress};

/// Target size of a proof, in feature vectors, elements and pixels of the splat unit: some seconds.
const AIM: [u64; 3] = [100_000, 1_000_000, 40_000];

/// Amount compared without a mismatch in any bit or cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Proof {
    /// Feature vectors compared, and those of the frame.
    pub vectors: [u64; 2],
    /// Elements of vector operations compared, and those of the frame.
    pub elements: [u64; 2],
    /// Pixels of the splat unit compared, and those of the frame.
    pub pixels: [u64; 2],
}

impl Bench {
    /// Compares the Verilog of settings with the golden models on the scene's frame. An injected
    /// fault shows that mismatches are found.
    ///
    /// # Errors
    /// A mismatch, nothing to compare, or Verilog that cannot be built or run.
    pub fn prove(
        &self,
        settings: &[&Setting],
        inject: Option<Injection>,
        progress: &dyn Progress,
    ) -> Result<Proof, ExploreError> {
        let (config, scene) = self.apply(settings)?;
        Proof::of(&config, &scene, inject, progress)
    }
}

impl Proof {
    /// Compares the Verilog of a configuration with the golden models on a scene's frame. An injected
    /// fault shows that mismatches are found.
    ///
    /// # Errors
    /// As [`Bench::prove`].
    pub fn of(
        config: &Config,
        scene: &Scene,
        inject: Option<Injection>,
        progress: &dyn Progress,
    ) -> Result<Self, ExploreError> {
        let mut twins = ReferenceUnits::new(config);
        let counts = scene.render_fixed(config, &mut twins)?.counts;
        let pixels = twins.counts().splat_pixels;
        let total = [
            counts.feature_vectors,
            counts.elements.values().sum(),
            pixels,
        ];
        let [gather_every, vector_every, splat_every] = Extent::Share(AIM).every(total);
        let own = Settings {
            engine: EngineKind::Verilator,
            seed: 0,
            gather_every,
            vector_every,
            splat_every,
            inject,
            rtl: None,
            excerpt: None,
        };
        progress.expect(total.iter().sum());
        let mut shown = 0;
        let mut show = |p: potamoi_rtl::verify::Progress| {
            progress.advance(p.done.saturating_sub(shown));
            shown = p.done;
        };
        let mut verifier = Verifier::new(config, own, &mut show);
        let done = scene.render_fixed(config, &mut verifier);
        let finished = verifier.finish();
        if verifier.failure().is_some() {
            return Err(ExploreError::Check(
                "the Verilog of the configuration found differs from the golden models".to_owned(),
            ));
        }
        done?;
        finished?;
        let proof = Self {
            vectors: [verifier.gather_report().samples, total[0]],
            elements: [verifier.vector_report().elements, total[1]],
            pixels: [verifier.splat_report().pixels, total[2]],
        };
        if proof.vectors[0] + proof.elements[0] + proof.pixels[0] == 0 {
            return Err(ExploreError::Inconclusive(
                "nothing was compared".to_owned(),
            ));
        }
        Ok(proof)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::knobs;
    use super::*;
    use crate::{ConfigChoice, Setup};
    use potamoi_system::system_model::System;

    /// Faults in both units, in the configuration of a setting, are found.
    #[test]
    fn a_fault_of_what_was_found_is_not_proved() {
        faults_are_not_proved(&[Injection::Bit]);
    }

    #[test]
    #[ignore = "slow; run with make test-full"]
    fn further_faults_are_not_proved() {
        faults_are_not_proved(&[Injection::Bubble, Injection::Exp]);
    }

    fn faults_are_not_proved(faults: &[Injection]) {
        let mut scene = Scene::open("lantern").unwrap();
        scene.set_size(Some(8), None).unwrap();
        let setup = Setup::new(
            ConfigChoice::for_scene(&scene).unwrap(),
            &System::default(),
            scene,
            None,
        )
        .unwrap();
        let bench = Bench::new(setup, 2).unwrap();
        let knobs = knobs::of(&bench.setup.scene);
        let iterations = knobs.iter().find(|knob| knob.name == "iterations").unwrap();
        let own = [&iterations.settings[0]];
        let proof = bench.prove(&own, None, &()).unwrap();
        assert!(proof.vectors[0] > 0 && proof.elements[0] > 0, "{proof:?}");
        for &fault in faults {
            let proved = bench.prove(&own, Some(fault), &());
            assert!(
                matches!(proved, Err(ExploreError::Check(_))),
                "{fault:?}: {proved:?}"
            );
        }
    }
}
