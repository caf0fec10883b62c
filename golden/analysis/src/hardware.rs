//! The hardware that a scene needs.

use std::collections::BTreeSet;

use potamoi_formats::config::{Config, EntryKind, Modes, Organisation, rules};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;
use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

use potamoi_scene::{Scene, SceneError};

/// A configuration without the parts that no camera of a scene can use. The rest produces the same
/// bits in the same cycles.
#[derive(Debug, Clone, PartialEq)]
pub struct Hardware {
    /// The configuration.
    pub config: Config,
    /// Whether the gathering unit is used.
    pub gathers: bool,
    /// Whether the vector unit is used.
    pub computes: bool,
    /// Parts of the requested configuration that are left out, or kept although nothing uses them.
    pub left_out: Vec<LeftOut>,
}

/// A part of the hardware that the scene does not use.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct LeftOut {
    /// The field of the configuration, or the unit.
    pub field: &'static str,
    /// The requested value.
    pub asked: String,
    /// The remaining value; the requested one if the part has to stay.
    pub left: String,
    /// The reason.
    pub reason: String,
}

/// The hardware of a scene cannot be determined.
#[derive(Debug, Error)]
pub enum HardwareError {
    /// The scene cannot be rendered with the configuration.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The gathering unit does not support the scene's entries.
    #[error(
        "{scene} has entries of {vertices} vertices: expected {built}, for which the gathering \
         unit is built; change gu.modes or gu.vertices"
    )]
    Vertices {
        /// The scene.
        scene: String,
        /// Vertices of the entries that the unit does not support.
        vertices: usize,
        /// Entries that it supports.
        built: String,
    },
    /// The remaining configuration breaks a rule.
    #[error("the configuration reduced to {scene} is invalid: {breaches}; leave --for-scene out")]
    Rules {
        /// The scene.
        scene: String,
        /// The broken rules.
        breaches: String,
    },
}

/// What the scene needs of the units.
struct Uses {
    vertices: BTreeSet<Vertices>,
    /// Largest number of channels in a feature vector.
    channels: usize,
    operations: BTreeSet<OpCode>,
}

impl Hardware {
    /// The complete configuration.
    #[must_use]
    pub fn whole(config: &Config) -> Self {
        Self {
            config: config.clone(),
            gathers: true,
            computes: true,
            left_out: vec![],
        }
    }

    /// The part of a configuration that a scene uses, for any camera.
    ///
    /// # Errors
    /// The scene cannot be rendered with the configuration.
    pub fn of(scene: &Scene, config: &Config) -> Result<Self, HardwareError> {
        let uses = Uses::of(scene, config)?;
        let built = config.supported_vertices();
        if let Some(lacking) = uses.vertices.iter().find(|v| !built.contains(v)) {
            return Err(HardwareError::Vertices {
                scene: scene.name().to_owned(),
                vertices: lacking.count(),
                built: list(&built),
            });
        }
        let mut own = Self::whole(config);
        own.gathers = !uses.vertices.is_empty();
        own.computes = !uses.operations.is_empty();
        let what = scene.model().algorithm();
        own.leave_out_modes(&uses, what);
        own.leave_out_segments(&uses, what);
        own.leave_out_operations(&uses, what);
        own.leave_out_splat_unit(scene, what);
        for (unit, is_used) in [
            ("gathering_unit", own.gathers),
            ("vector_unit", own.computes),
        ] {
            if !is_used {
                own.note(unit, "all of it", "nothing", "the scene gives it no work");
            }
        }
        let breaches = rules::check(&own.config);
        if breaches.is_empty() {
            return Ok(own);
        }
        Err(HardwareError::Rules {
            scene: scene.name().to_owned(),
            breaches: breaches.to_string(),
        })
    }

    fn note(
        &mut self,
        field: &'static str,
        asked: impl Into<String>,
        left: impl Into<String>,
        reason: impl Into<String>,
    ) {
        self.left_out.push(LeftOut {
            field,
            asked: asked.into(),
            left: left.into(),
            reason: reason.into(),
        });
    }

    /// Removes the reducers if all entries are single ids, single ids if no entries are, and
    /// unused entry sizes.
    fn leave_out_modes(&mut self, uses: &Uses, what: &str) {
        let gu = self.config.gu.clone();
        let structured: Vec<Vertices> = (gu.vertices.iter().copied())
            .filter(|v| uses.vertices.contains(v))
            .collect();
        let single = uses.vertices.contains(&Vertices::One);
        let wanted = match (structured.is_empty(), single) {
            (true, true) => Modes::Unstructured,
            (false, false) => Modes::Structured,
            (false, true) => gu.modes,
            (true, false) => return,
        };
        let organisation = self.config.organisation().0;
        if wanted != gu.modes && organisation != Organisation::ChannelMajor {
            let reason = "single ids and entries of vertices share the crossbar";
            self.note("gu.modes", modes(gu.modes), modes(gu.modes), reason);
        } else if wanted == Modes::Unstructured
            && gu.modes != wanted
            && self.config.rit.entry == EntryKind::Compact
        {
            let reason = "without the stages of compact entries single ids would come sooner";
            self.note("gu.modes", modes(gu.modes), modes(gu.modes), reason);
        } else if wanted != gu.modes {
            let reason = match wanted {
                Modes::Unstructured => {
                    format!("{what} gathers records of one vertex: no reducer")
                }
                _ => format!("{what} gathers no single id"),
            };
            self.config.gu.modes = wanted;
            self.note("gu.modes", modes(gu.modes), modes(wanted), reason);
        }
        if !structured.is_empty() && structured != gu.vertices {
            let reason = format!("{what} has entries of no other size");
            self.config.gu.vertices.clone_from(&structured);
            self.note("gu.vertices", list(&gu.vertices), list(&structured), reason);
        }
        if !single && gu.records_a_row != 1 {
            self.config.gu.records_a_row = 1;
            let asked = gu.records_a_row.to_string();
            self.note("gu.records_a_row", asked, "1", "no records are gathered");
        }
        // Fewer sizes of entries must not choose another organisation.
        if self.config.organisation().0 != organisation {
            self.config.gu.organisation = organisation;
        }
    }

    fn leave_out_segments(&mut self, uses: &Uses, what: &str) {
        let asked = self.config.gu.segments;
        let wanted = self.config.segments(uses.channels).max(1) as u32;
        if wanted < asked && self.gathers {
            self.config.gu.segments = wanted;
            let reason = format!("{what} has {} channels at most", uses.channels);
            self.note("gu.segments", asked.to_string(), wanted.to_string(), reason);
        }
    }

    /// Removes the splat unit if there are no Gaussians.
    fn leave_out_splat_unit(&mut self, scene: &Scene, what: &str) {
        if self.config.su.is_some() && !scene.model().is_splats() {
            self.config.su = None;
            let reason = format!("{what} has no Gaussians");
            self.note("su", "a splat unit", "none", reason);
        }
    }

    fn leave_out_operations(&mut self, uses: &Uses, what: &str) {
        if !self.computes {
            return;
        }
        let asked = self.config.vu.ops.clone();
        let wanted: Vec<OpCode> = (asked.iter().copied())
            .filter(|op| uses.operations.contains(op))
            .collect();
        if wanted != asked {
            self.config.vu.ops.clone_from(&wanted);
            let reason = format!("{what} computes nothing else");
            self.note(
                "vu.ops",
                OpCode::list(&asked),
                OpCode::list(&wanted),
                reason,
            );
        }
    }
}

fn list(vertices: &[Vertices]) -> String {
    let counts: Vec<_> = vertices.iter().map(|v| v.count().to_string()).collect();
    format!("[{}]", counts.join(", "))
}

fn modes(modes: Modes) -> &'static str {
    match modes {
        Modes::Structured => "structured",
        Modes::Unstructured => "unstructured",
        Modes::Both => "both",
    }
}

impl Uses {
    fn of(scene: &Scene, config: &Config) -> Result<Self, SceneError> {
        let facts = scene.facts();
        let mut uses = Self {
            vertices: BTreeSet::new(),
            channels: 0,
            operations: BTreeSet::new(),
        };
        let sees = facts.can_be_seen();
        let is_splats = scene.model().is_splats();
        // Colours are gathered of Gaussians that nobody sees, too.
        if sees || is_splats {
            uses.operations.extend(scene.operations(config)?);
            for table in &facts.tables {
                uses.vertices.extend(
                    Vertices::ALL
                        .iter()
                        .copied()
                        .filter(|v| v.count() == table.vertices),
                );
                uses.channels = uses.channels.max(table.channels);
            }
        }
        if is_splats {
            uses.vertices.insert(Vertices::One);
            uses.channels = uses.channels.max(RECORD_CHANNELS);
        }
        Ok(uses)
    }
}
