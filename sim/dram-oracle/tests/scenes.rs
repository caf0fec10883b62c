//! The same of what scenes read: MVoxels in memory-centric order, and what misses a GPU's cache
//! in pixel-centric order.
#![allow(clippy::unwrap_used, missing_docs)]

mod common;

use std::collections::{HashMap, VecDeque};

use common::agree;
use potamoi_formats::config::Config;
use potamoi_formats::units::VectorOp;
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::{GatherTask, Product, ReferenceUnits, UnitError, Units};
use potamoi_scene::Scene;
use potamoi_system::system_model::dram::Access;

const BURST: u64 = 32;
/// What the model may be off: a read that waits for longer than many others is merged with the
/// next of its burst in DRAMsim3.
const WITHIN: f64 = 0.01;
/// Bursts of a sequence at most.
const MOST: usize = 200_000;
/// More reads than all queues of four channels hold: 32, and 8 for each of 16 banks.
const WAITING: usize = 1024;

/// ReferenceUnits, and the rows that were loaded: MVoxels with the same rows are the same, and lie one
/// behind the other as they come up.
struct Loads {
    twins: ReferenceUnits,
    places: HashMap<Vec<i16>, u64>,
    end: u64,
    accesses: Vec<Access>,
}

impl Loads {
    fn load(&mut self, tasks: &[GatherTask]) {
        for task in tasks {
            let bursts = (2 * task.rows.len() as u64).div_ceil(BURST);
            let end = &mut self.end;
            let first = *self.places.entry(task.rows.clone()).or_insert_with(|| {
                let own = *end;
                *end += bursts;
                own
            });
            self.accesses.extend((0..bursts).map(|i| Access {
                address: (first + i) * BURST,
                is_write: false,
            }));
        }
    }
}

impl Units for Loads {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.load(tasks);
        self.twins.gather(tasks, features)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.load(tasks);
        self.twins.sums(tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.twins.vector(op, a, b, out)
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.twins.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.twins.multiplied(product);
    }
}

#[test]
fn accesses_of_scenes() {
    for name in ["garden", "lantern", "cairn:splats", "cairn:voxels"] {
        let config = Config::paper();
        let mut scene = Scene::open(name).unwrap();
        scene.set_size(Some(128), Some(128)).unwrap();
        let mut units = Loads {
            twins: ReferenceUnits::new(&config),
            places: HashMap::new(),
            end: 0,
            accesses: vec![],
        };
        scene.render_fixed(&config, &mut units).unwrap();
        units.accesses.truncate(MOST);
        agree(&format!("{name}, MVoxels"), &units.accesses, WITHIN);

        let misses = scene.accesses(&config, 1 << 16, None).unwrap().first_misses;
        let bursts = misses.iter().flat_map(|(address, bytes)| {
            let last = address + u64::from(*bytes) - 1;
            (address / BURST..=last / BURST).map(|burst| Access {
                address: burst * BURST,
                is_write: false,
            })
        });
        // A burst that is on its way is not asked for again: DRAMsim3 merges such reads, and a
        // cache's list of misses does.
        let mut on_its_way = VecDeque::from([u64::MAX; WAITING]);
        let bursts: Vec<Access> = bursts
            .filter(|own| {
                let is_new = !on_its_way.contains(&own.address);
                if is_new {
                    on_its_way.pop_front();
                    on_its_way.push_back(own.address);
                }
                is_new
            })
            .take(MOST)
            .collect();
        assert!(bursts.len() > 1000, "{name}: {}", bursts.len());
        agree(&format!("{name}, misses"), &bursts, WITHIN);
    }
}
