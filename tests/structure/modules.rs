//! No two modules beside each other import each other, at any folder level.
//!
//! A module imports another if code of it, tests excluded, names something below it: in a `use`,
//! or by a path. What a parent re-exports counts as what it re-exports.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;
use std::path::Path;

use syn::visit::Visit;
use syn::{Attribute, Item, ItemUse, UseTree, Visibility};

type Module = Vec<String>;
type Edges = BTreeMap<(Module, String), BTreeMap<String, String>>;

/// The modules of a crate, their paths, and what names in them stand for.
#[derive(Default)]
struct Crate {
    modules: BTreeSet<Module>,
    /// By module: a name, and the path that it was imported from.
    names: BTreeMap<Module, BTreeMap<String, Vec<String>>>,
    /// By module: items that it declares, and what it imports whole (`use a::*`).
    declared: BTreeMap<Module, BTreeSet<String>>,
    globs: BTreeMap<Module, Vec<Vec<String>>>,
    /// Paths that code of a module names, as written.
    used: Vec<(Module, Vec<String>)>,
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|a| {
        a.path().is_ident("cfg")
            && a.parse_args::<syn::Ident>()
                .is_ok_and(|what| what == "test")
    })
}

impl Crate {
    fn read(root: &Path) -> Self {
        let mut own = Self::default();
        own.module(vec![], root, root.parent().unwrap());
        own
    }

    /// Reads a file, and the modules that it declares in `folder`.
    fn module(&mut self, module: Module, file: &Path, folder: &Path) {
        let text = std::fs::read_to_string(file).unwrap();
        let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
        self.items(&module, &parsed.items, folder);
    }

    fn items(&mut self, module: &Module, items: &[Item], folder: &Path) {
        self.modules.insert(module.clone());
        for item in items {
            match item {
                Item::Mod(inner) if is_test(&inner.attrs) => {}
                Item::Mod(inner) => {
                    let name = inner.ident.to_string();
                    let mut below = module.clone();
                    below.push(name.clone());
                    let own = folder.join(&name);
                    if let Some((_, items)) = &inner.content {
                        self.items(&below, items, &own);
                        continue;
                    }
                    let file = folder.join(format!("{name}.rs"));
                    let file = if file.exists() {
                        file
                    } else {
                        own.join("mod.rs")
                    };
                    self.module(below, &file, &own);
                }
                Item::Use(import) if is_test(&import.attrs) => {}
                Item::Use(import) => self.import(module, import),
                Item::Fn(one) if is_test(&one.attrs) => {}
                Item::Impl(one) if is_test(&one.attrs) => {}
                other => {
                    let declared = self.declared.entry(module.clone()).or_default();
                    declared.extend(declared_by(other));
                    let mut paths = Paths(vec![]);
                    paths.visit_item(other);
                    self.used
                        .extend(paths.0.into_iter().map(|path| (module.clone(), path)));
                }
            }
        }
    }

    fn import(&mut self, module: &Module, import: &ItemUse) {
        let mut leaves = vec![];
        flatten(&import.tree, &mut vec![], &mut leaves);
        let re_exported = !matches!(import.vis, Visibility::Inherited);
        for (path, name) in leaves {
            // A parent that re-exports what is below it imports nothing.
            let below = self
                .absolute(module, &path)
                .is_some_and(|to| to.starts_with(module));
            if !(re_exported && below) {
                self.used.push((module.clone(), path.clone()));
            }
            if name.is_empty() {
                self.globs.entry(module.clone()).or_default().push(path);
                continue;
            }
            self.names
                .entry(module.clone())
                .or_default()
                .insert(name, path);
        }
    }

    /// A path from the crate's root, if it stays in the crate.
    fn absolute(&self, module: &Module, path: &[String]) -> Option<Vec<String>> {
        let mut at = module.clone();
        let mut rest = path.iter().peekable();
        match rest.peek()?.as_str() {
            "crate" => {
                at.clear();
                rest.next();
            }
            "self" | "super" => {
                if rest.peek().is_some_and(|s| *s == "self") {
                    rest.next();
                }
                while rest.peek().is_some_and(|s| *s == "super") {
                    at.pop()?;
                    rest.next();
                }
            }
            first => {
                let mut child = module.clone();
                child.push((*first).to_owned());
                if !self.modules.contains(&child) {
                    return None;
                }
            }
        }
        at.extend(rest.cloned());
        Some(at)
    }

    /// Where a module has a name from, that it does not declare itself.
    fn source(&self, module: &Module, name: &String) -> Option<Vec<String>> {
        let named = self.names.get(module).and_then(|names| names.get(name));
        if let Some(path) = named {
            return self.absolute(module, path);
        }
        let globs = self.globs.get(module)?.iter();
        let mut all = globs.filter_map(|path| self.absolute(module, path));
        let mut from = all.find(|from| {
            let declares = self
                .declared
                .get(from)
                .is_some_and(|own| own.contains(name));
            let imports = self
                .names
                .get(from)
                .is_some_and(|own| own.contains_key(name));
            declares || imports
        })?;
        from.push(name.clone());
        Some(from)
    }

    /// The module that a path leads to, through what parents re-export.
    fn target(&self, module: &Module, path: &[String]) -> Option<Module> {
        let mut path = self.absolute(module, path)?;
        for _ in 0..8 {
            let depth = (0..=path.len())
                .rev()
                .find(|n| self.modules.contains(&path[..*n]))?;
            let (within, rest) = path.split_at(depth);
            let within = within.to_vec();
            let from = rest.first().and_then(|name| self.source(&within, name));
            let Some(from) = from else {
                return Some(within);
            };
            path = from
                .into_iter()
                .chain(rest.iter().skip(1).cloned())
                .collect();
        }
        None
    }

    /// By folder and module, the modules beside it that it imports, each with an example.
    fn edges(&self) -> Edges {
        let mut edges = Edges::new();
        for (module, path) in &self.used {
            let Some(to) = self.target(module, path) else {
                continue;
            };
            let common = module.iter().zip(&to).take_while(|(a, b)| a == b).count();
            if let (Some(from), Some(other)) = (module.get(common), to.get(common)) {
                let folder = module[..common].to_vec();
                let example = format!("{} names {}", module.join("::"), path.join("::"));
                let own = edges.entry((folder, from.clone())).or_default();
                own.entry(other.clone()).or_insert(example);
            }
        }
        edges
    }
}

/// The name of what an item declares.
fn declared_by(item: &Item) -> Option<String> {
    let ident = match item {
        Item::Const(own) => &own.ident,
        Item::Enum(own) => &own.ident,
        Item::Fn(own) => &own.sig.ident,
        Item::Macro(own) => own.ident.as_ref()?,
        Item::Static(own) => &own.ident,
        Item::Struct(own) => &own.ident,
        Item::Trait(own) => &own.ident,
        Item::Type(own) => &own.ident,
        Item::Union(own) => &own.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

fn flatten(tree: &UseTree, path: &mut Vec<String>, leaves: &mut Vec<(Vec<String>, String)>) {
    match tree {
        UseTree::Path(part) => {
            path.push(part.ident.to_string());
            flatten(&part.tree, path, leaves);
            path.pop();
        }
        UseTree::Name(last) if last.ident == "self" => {
            leaves.push((path.clone(), path.last().cloned().unwrap_or_default()));
        }
        UseTree::Name(last) => {
            let name = last.ident.to_string();
            leaves.push((
                [path.as_slice(), std::slice::from_ref(&name)].concat(),
                name,
            ));
        }
        UseTree::Rename(last) => {
            let whole = [path.as_slice(), &[last.ident.to_string()]].concat();
            leaves.push((whole, last.rename.to_string()));
        }
        UseTree::Glob(_) => leaves.push((path.clone(), String::new())),
        UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, path, leaves);
            }
        }
    }
}

/// Paths of more than one part.
struct Paths(Vec<Vec<String>>);

impl Visit<'_> for Paths {
    fn visit_path(&mut self, path: &syn::Path) {
        let parts: Vec<_> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if parts.len() > 1 {
            self.0.push(parts);
        }
        syn::visit::visit_path(self, path);
    }

    /// An import within a function.
    fn visit_item_use(&mut self, import: &ItemUse) {
        let mut leaves = vec![];
        flatten(&import.tree, &mut vec![], &mut leaves);
        let paths = leaves.into_iter().map(|(path, _)| path);
        self.0.extend(paths.filter(|path| path.len() > 1));
    }

    /// Paths among the words of a macro, which are not parsed.
    fn visit_macro(&mut self, invocation: &syn::Macro) {
        let text = invocation.tokens.to_string();
        let text = text.replace(" ::", "::").replace(":: ", "::");
        let words = text.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == ':'));
        for word in words.filter(|word| word.contains("::")) {
            let parts: Vec<_> = word.split("::").map(str::to_owned).collect();
            if parts
                .iter()
                .all(|part| !part.is_empty() && !part.contains(':'))
            {
                self.0.push(parts);
            }
        }
        syn::visit::visit_macro(self, invocation);
    }

    fn visit_item_mod(&mut self, _: &syn::ItemMod) {}
}

/// Circles: in each folder, the modules from which imports lead back.
fn circles(edges: &Edges) -> Vec<String> {
    let mut found = vec![];
    let folders: BTreeSet<_> = edges.keys().map(|(folder, _)| folder).collect();
    for folder in folders {
        let next = |name: &str| {
            let own = edges.get(&(folder.clone(), name.to_owned()));
            own.into_iter()
                .flatten()
                .map(|(to, example)| (to.as_str(), example))
        };
        let reached = |from: &str| {
            let (mut seen, mut open) = (BTreeSet::new(), vec![from.to_owned()]);
            while let Some(name) = open.pop() {
                for (to, _) in next(&name) {
                    if seen.insert(to.to_owned()) {
                        open.push(to.to_owned());
                    }
                }
            }
            seen
        };
        let names: BTreeSet<_> = edges
            .keys()
            .filter(|(f, _)| f == folder)
            .map(|(_, n)| n)
            .collect();
        let within: Vec<_> = names
            .into_iter()
            .filter(|n| reached(n).contains(*n))
            .collect();
        if within.is_empty() {
            continue;
        }
        let mut text = format!("crate::{}:", folder.join("::"));
        for from in &within {
            for (to, example) in next(from).filter(|(to, _)| within.iter().any(|n| n == to)) {
                let _ = write!(text, "\n  {from} -> {to}: {example}");
            }
        }
        found.push(text);
    }
    found
}

#[test]
fn no_modules_beside_each_other_import_each_other() {
    let mut found = vec![];
    let mut manifests = vec![];
    super::files(super::root(), "Cargo.toml", &mut manifests);
    for manifest in manifests {
        let folder = manifest.parent().unwrap();
        for root in ["src/lib.rs", "src/main.rs"].map(|r| folder.join(r)) {
            if root.exists() {
                let circles = circles(&Crate::read(&root).edges());
                found.extend(circles.iter().map(|c| format!("{}: {c}", root.display())));
            }
        }
    }
    assert!(
        found.is_empty(),
        "{} circles\n{}",
        found.len(),
        found.join("\n")
    );
}

/// The test finds circles of files and of folders, through re-exports by name and whole, and no
/// other.
#[test]
fn circles_are_found() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    let count = || circles(&Crate::read(&folder.path().join("lib.rs")).edges()).len();
    write("lib.rs", "mod a;\nmod b;\npub use a::One;\n");
    write(
        "a.rs",
        "pub struct One;\n#[cfg(test)]\nmod tests { use crate::b::Two; }\n",
    );
    write("b.rs", "use crate::One;\npub struct Two(One);\n");
    assert_eq!(count(), 0);
    for import in [
        "fn f(_: crate::b::Two) {}",
        "fn f() { use crate::b::Two; let _: Two; }",
        "fn f() { vec![crate::b::Two::new()]; }",
    ] {
        write("a.rs", &format!("pub struct One;\n{import}\n"));
        assert_eq!(count(), 1, "{import}");
    }
    write("a.rs", "pub struct One;\n");
    write("b.rs", "mod c;\nmod d;\nuse c::C;\n");
    write("b/c.rs", "pub struct C;\nuse super::d::D;\n");
    write("b/d.rs", "pub struct D;\nuse super::c::C;\n");
    assert_eq!(count(), 1);
    write("lib.rs", "mod a;\nmod b;\npub use a::*;\n");
    write("a.rs", "use crate::b::Two;\npub struct One(Two);\n");
    write("b.rs", "use crate::One;\npub struct Two(One);\n");
    assert_eq!(count(), 1);
}
