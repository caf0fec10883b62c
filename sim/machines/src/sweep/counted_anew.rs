//! Fields of a plan for whose values frames are counted anew.

use super::plan::Plan;
use crate::space::Space;
use crate::workbench::Workbench;

/// Most values of an axis that are looked at.
const VALUES: usize = 32;

impl Plan {
    /// Fields whose values change what is counted of a frame, such as its schedule on the units or its
    /// rates in memory: each value alone, beside the first of every other axis.
    #[must_use]
    pub fn counted_anew(&self) -> Vec<String> {
        let bench = Workbench::default();
        let mut found: Vec<String> = vec![];
        for space in &self.spaces {
            for (at, axis) in space.axes.iter().enumerate() {
                let mut new = axis.fields.clone();
                new.retain(|field| !found.contains(field));
                if !new.is_empty() && self.counts_anew(&bench, space, at) {
                    found.extend(new);
                }
            }
        }
        found
    }

    fn counts_anew(&self, bench: &Workbench, space: &Space, axis: usize) -> bool {
        let values = space.axes[axis].values.len().min(VALUES);
        self.scenes.iter().any(|scene| {
            let mut files = (0..values).filter_map(|value| {
                let mut places = vec![0; space.axes.len()];
                places[axis] = value;
                // What cannot be is told with its point.
                let machine = space.machine(&places).ok()?;
                bench.counted_files(&machine, scene, &self.workload).ok()
            });
            match files.next() {
                Some(first) => files.any(|own| own != first),
                None => false,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::sweep::Plan;
    use std::path::Path;

    #[test]
    fn some_fields_change_the_work_or_its_rates_in_memory() {
        let text = "machines = [\"paper\"]\nscenes = [\"garden\"]\nwidth = 16\n\
                    [vary]\n\"gu.banks\" = [16, 32]\n\"vu.lanes\" = [12, 24]\nclock_ghz = [0.5, 1.0]\n\
                    \"system.memory_channels\" = [2, 4]\n\"vu.exp.iterations\" = [16]\n";
        let plan = Plan::of(text.as_bytes(), "plan.toml", Path::new(".")).unwrap();
        let found = plan.counted_anew();
        assert_eq!(found, ["gu.banks", "system.memory_channels"]);
    }
}
