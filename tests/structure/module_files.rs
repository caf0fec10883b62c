//! One style of module files: what has modules of its own is `name/mod.rs`.

use std::collections::BTreeSet;

#[test]
fn a_module_with_modules_below_it_is_its_folders_mod_rs() {
    let mut sources = vec![];
    super::files(super::root(), ".rs", &mut sources);
    let folders: BTreeSet<_> = sources.iter().filter_map(|path| path.parent()).collect();
    let beside: Vec<_> = (sources.iter())
        .filter(|path| folders.contains(path.with_extension("").as_path()))
        .collect();
    assert!(beside.is_empty(), "to be moved to mod.rs: {beside:#?}");
}
