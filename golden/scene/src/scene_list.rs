//! Lists of scenes, with a word for many.

use potamoi_analytic::Analytic;

use crate::{BUILTIN, Representation};

/// The scenes of a list: `all` is every built-in scene in every representation,
/// `cairn:all` every one of a scene, `all:ngp` every scene in one of them.
#[must_use]
pub fn scenes_named(list: &[String]) -> Vec<String> {
    let mut names = vec![];
    for wanted in list {
        let (scene, representation) = wanted.split_once(':').unwrap_or((wanted, "all"));
        if scene != "all" && !wanted.ends_with(":all") {
            names.push(wanted.clone());
            continue;
        }
        let before = names.len();
        for built_in in BUILTIN.iter().filter(|b| scene == "all" || scene == **b) {
            if Analytic::named(built_in).is_none() {
                if wanted == "all" {
                    names.push((*built_in).to_owned());
                }
                continue;
            }
            let all = Representation::ALL.map(Representation::name);
            let chosen = all
                .iter()
                .filter(|r| representation == "all" || representation == **r);
            names.extend(chosen.map(|r| format!("{built_in}:{r}")));
        }
        if names.len() == before {
            // Opening it says what there is.
            names.push(wanted.clone());
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_stand_for_many_scenes() {
        let of = |name: &str| scenes_named(&[name.to_owned()]);
        assert_eq!(of("garden"), ["garden"]);
        assert_eq!(of("cairn:all").len(), Representation::ALL.len());
        assert!(of("all:ngp").iter().all(|name| name.ends_with(":ngp")));
        assert!(of("all").len() > of("all:ngp").len());
        assert_eq!(of("nowhere:all"), ["nowhere:all"]);
    }
}
