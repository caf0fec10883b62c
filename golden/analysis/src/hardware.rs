//! The hardware that a scene calls for.

use std::collections::BTreeSet;

use potamoi_formats::config::{Config, EntryKind, Modes, Organisation, rules};
use potamoi_formats::record::RECORD_CHANNELS;
use potamoi_formats::rit::Vertices;
use potamoi_formats::units::OpCode;
use serde::Serialize;
use thiserror::Error;

use potamoi_scene::{Scene, SceneError};

/// A configuration without what no camera of a scene can use. What is left works as before: the
/// same bits in the same cycles.
#[derive(Debug, Clone, PartialEq)]
pub struct Hardware {
    /// The configuration.
    pub config: Config,
    /// Whether anything is gathered.
    pub gathers: bool,
    /// Whether anything is computed element by element.
    pub computes: bool,
    /// What was left out of the configuration that was asked for, or kept although nothing uses
    /// it.
    pub left_out: Vec<LeftOut>,
}

/// A part of the hardware that nothing uses.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// The field of the configuration, or the unit.
    pub field: &'static str,
    /// What was asked for.
    pub asked: String,
    /// What is left of it; what was asked for where it has to stay.
    pub left: String,
    /// Why.
    pub reason: String,
}

/// Hardware of a scene that cannot be found.
#[derive(Debug, Error)]
pub enum HardwareError {
    /// The scene cannot be rendered in the configuration.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The gathering unit cannot gather what the scene has.
    #[error(
        "{scene} has entries of {vertices} vertices, but the gathering unit is built for {built}; \
         change gu.modes or gu.vertices"
    )]
    Vertices {
        /// The scene.
        scene: String,
        /// Vertices of its entries that the unit lacks.
        vertices: usize,
        /// Those that it has.
        built: String,
    },
    /// What is left breaks a rule.
    #[error("without what {scene} does not use: {breaches}; leave --for-scene out")]
    Rules {
        /// The scene.
        scene: String,
        /// Which.
        breaches: String,
    },
}

/// What the units are asked for.
struct Uses {
    vertices: BTreeSet<Vertices>,
    /// The most of a feature vector.
    channels: usize,
    operations: BTreeSet<OpCode>,
}

impl Hardware {
    /// The whole of a configuration.
    #[must_use]
    pub fn whole(config: &Config) -> Self {
        Self {
            config: config.clone(),
            gathers: true,
            computes: true,
            left_out: vec![],
        }
    }

    /// What a scene uses of a configuration, whatever the camera.
    ///
    /// # Errors
    /// A configuration in which the scene cannot be rendered.
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
        for (unit, is_used) in [
            ("gathering_unit", own.gathers),
            ("vector_unit", own.computes),
        ] {
            if !is_used {
                own.note(unit, "all of it", "nothing", "nothing of it can be seen");
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

    /// Reducers where all entries are single ids, single ids where none is, and sizes of entries.
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
