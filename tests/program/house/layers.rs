//! Arrows run down: a file imports from the layers below its own and never in a circle.
//!
//! The table of layers is the one that ARCHITECTURE.md shows: a row for each crate, with the crates
//! that it may use and its own modules from the lowest layer up.

use std::collections::{BTreeMap, BTreeSet};

use proc_macro2::{TokenStream, TokenTree};
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Item, ItemMod, UseTree};

use super::source::{Module, Package, root};
use super::{SOURCE_FINDINGS, assert_none};

/// An import of one file from another file or crate.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
struct Arrow {
    /// The path of the module that imports.
    from: Vec<String>,
    /// What it imports from.
    target: Target,
    /// The file and line of the import.
    place: String,
}

#[derive(Clone, PartialEq, Eq, PartialOrd, Ord)]
enum Target {
    /// A module of the same crate.
    Module(Vec<String>),
    /// Another crate of the workspace.
    Package(String),
}

/// A row of the table of layers.
struct Row {
    may_use: BTreeSet<String>,
    /// The height of each top-level module above the lowest layer.
    heights: BTreeMap<String, usize>,
}

#[test]
fn arrows_run_down_the_layers() {
    assert_none("a file imports from the layers below its own", &SOURCE_FINDINGS.upward_imports);
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let findings = &SOURCE_FINDINGS.circles;
    assert_none("no import leads back to the file that it stands in", findings);
}

pub(super) fn upward_imports(packages: &[Package]) -> Vec<String> {
    let table = match table() {
        Ok(table) => table,
        Err(fault) => return vec![fault],
    };
    let names: BTreeSet<String> = packages.iter().map(|package| package.name.clone()).collect();
    let mut findings = Vec::new();
    for package in packages {
        let Some(row) = table.get(&package.name) else {
            findings.push(format!("the crate `{}` has no row in the table", package.name));
            continue;
        };
        for module in package.modules.keys().filter_map(|path| path.first()) {
            if !row.heights.contains_key(module) {
                findings.push(format!("`{}::{module}` has no layer in the table", package.name));
            }
        }
        for arrow in arrows(package, &names) {
            match &arrow.target {
                Target::Package(name) if !row.may_use.contains(name) => findings
                    .push(format!("{}: `{}` may not use `{name}`", arrow.place, package.name)),
                Target::Package(_) => {}
                Target::Module(path) => {
                    // The face of the crate stands above everything.
                    let height = |path: &[String]| match path.first() {
                        Some(module) => row.heights.get(module).copied().unwrap_or(0),
                        None => usize::MAX,
                    };
                    let (upper, lower) = (height(&arrow.from), height(path));
                    if arrow.from.first() != path.first() && upper <= lower {
                        findings.push(format!(
                            "{}: `{}` is not above `{}`",
                            arrow.place,
                            spelled(&arrow.from),
                            spelled(path)
                        ));
                    }
                }
            }
        }
    }
    findings.dedup();
    findings
}

pub(super) fn circles(packages: &[Package]) -> Vec<String> {
    let names: BTreeSet<String> = packages.iter().map(|package| package.name.clone()).collect();
    let mut findings = Vec::new();
    for package in packages {
        let arrows = arrows(package, &names);
        let mut below: BTreeMap<&[String], BTreeMap<&[String], &str>> = BTreeMap::new();
        for arrow in &arrows {
            if let Target::Module(path) = &arrow.target {
                below.entry(&arrow.from).or_default().entry(path).or_insert(&arrow.place);
            }
        }
        let reached: BTreeMap<&[String], BTreeSet<&[String]>> =
            below.keys().map(|path| (*path, reachable(path, &below))).collect();
        let is_in_circle = |path: &[String], other: &[String]| {
            reached.get(path).is_some_and(|set| set.contains(other))
                && reached.get(other).is_some_and(|set| set.contains(path))
        };
        for (path, targets) in &below {
            for (target, place) in targets {
                if is_in_circle(path, target) {
                    findings.push(format!(
                        "{place}: `{}` imports `{}`, which leads back to it",
                        spelled(path),
                        spelled(target)
                    ));
                }
            }
        }
    }
    findings
}

fn reachable<'p>(
    path: &'p [String],
    below: &BTreeMap<&'p [String], BTreeMap<&'p [String], &str>>,
) -> BTreeSet<&'p [String]> {
    let mut reached = BTreeSet::new();
    let mut waiting = vec![path];
    while let Some(path) = waiting.pop() {
        for target in below.get(path).into_iter().flat_map(BTreeMap::keys) {
            if reached.insert(*target) {
                waiting.push(target);
            }
        }
    }
    reached
}

fn spelled(path: &[String]) -> String {
    if path.is_empty() { "the crate's face".to_owned() } else { path.join("::") }
}

/// Reads the table of layers: rows of | `crate` | the crates it may use | `a` `b` < `c` < … |.
fn table() -> Result<BTreeMap<String, Row>, String> {
    let page = std::fs::read_to_string(root().join("ARCHITECTURE.md"))
        .map_err(|error| format!("ARCHITECTURE.md cannot be read: {error}"))?;
    let quoted = |text: &str| -> Vec<String> {
        text.split('`').skip(1).step_by(2).map(str::to_owned).collect()
    };
    let rows = page
        .lines()
        .skip_while(|line| !line.starts_with("| crate | may use |"))
        .skip(2)
        .take_while(|line| line.starts_with('|'));
    let mut table = BTreeMap::new();
    for line in rows {
        let cells: Vec<&str> = line.split('|').collect();
        let [_, name, may_use, layers, ..] = cells[..] else {
            return Err(format!("a row of the table of layers has three cells: {line}"));
        };
        let heights = layers.split('<').enumerate().flat_map(|(height, layer)| {
            quoted(layer).into_iter().map(move |module| (module, height))
        });
        let row =
            Row { may_use: quoted(may_use).into_iter().collect(), heights: heights.collect() };
        table.insert(quoted(name).concat(), row);
    }
    match table.is_empty() {
        true => Err("ARCHITECTURE.md has no table `| crate | may use | … |`".to_owned()),
        false => Ok(table),
    }
}

/// Returns every import of a crate's files from each other and from other crates of the workspace.
fn arrows(package: &Package, packages: &BTreeSet<String>) -> BTreeSet<Arrow> {
    let mut arrows = BTreeSet::new();
    for (path, module) in &package.modules {
        let mut imports = Imports {
            package,
            packages,
            module,
            path,
            inner: Vec::new(),
            aliases: BTreeMap::new(),
            arrows: &mut arrows,
        };
        // Names must be known before the paths that begin with them.
        for item in &module.syntax.items {
            if let Item::Use(item) = item {
                imports.flatten(&item.tree, Vec::new(), item.span().start().line);
            }
        }
        imports.visit_file(&module.syntax);
    }
    arrows
}

/// Collects the arrows that start in one file.
struct Imports<'p> {
    package: &'p Package,
    packages: &'p BTreeSet<String>,
    module: &'p Module,
    /// The path of the file's module.
    path: &'p [String],
    /// The modules inside the file that are being visited.
    inner: Vec<String>,
    /// What the names that `use` brought into the file stand for.
    aliases: BTreeMap<String, Vec<String>>,
    arrows: &'p mut BTreeSet<Arrow>,
}

impl Imports<'_> {
    /// Takes in a tree of `use`, branch by branch.
    fn flatten(&mut self, tree: &UseTree, mut before: Vec<String>, line: usize) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.flatten(&path.tree, before, line);
            }
            UseTree::Group(group) => {
                for branch in &group.items {
                    self.flatten(branch, before.clone(), line);
                }
            }
            UseTree::Glob(_) => self.add(&before, line),
            UseTree::Name(name) => {
                let ident = name.ident.to_string();
                if ident != "self" {
                    before.push(ident);
                }
                self.import(before.last().cloned(), &before, line);
            }
            UseTree::Rename(rename) => {
                if rename.ident != "self" {
                    before.push(rename.ident.to_string());
                }
                self.import(Some(rename.rename.to_string()), &before, line);
            }
        }
    }

    fn import(&mut self, name: Option<String>, path: &[String], line: usize) {
        self.add(path, line);
        if let (Some(name), Some(absolute)) = (name, self.absolute(path)) {
            self.aliases.insert(name, absolute);
        }
    }

    /// Returns a path from the root of the crate; `None` if it leads elsewhere.
    fn absolute(&self, path: &[String]) -> Option<Vec<String>> {
        let here = || self.path.iter().chain(&self.inner).cloned().collect::<Vec<String>>();
        let (first, rest) = path.split_first()?;
        let mut absolute = match first.as_str() {
            "crate" => Vec::new(),
            "self" => here(),
            "super" => {
                let mut above = here();
                above.pop();
                above
            }
            name => {
                let mut child = here();
                child.push(name.to_owned());
                if self.package.modules.contains_key(&child) {
                    child
                } else {
                    self.aliases.get(name)?.clone()
                }
            }
        };
        for segment in rest {
            if segment == "super" {
                absolute.pop();
            } else {
                absolute.push(segment.clone());
            }
        }
        Some(absolute)
    }

    fn add(&mut self, path: &[String], line: usize) {
        let place = format!("{}:{line}", self.module.file);
        let target = match self.absolute(path) {
            Some(absolute) => {
                let is_module =
                    |length: &usize| self.package.modules.contains_key(&absolute[..*length]);
                let length = (0..=absolute.len()).rev().find(is_module).unwrap_or(0);
                if absolute[..length] == *self.path {
                    return;
                }
                Target::Module(absolute[..length].to_vec())
            }
            None => match path.first() {
                Some(name) if self.packages.contains(name) && *name != self.package.name => {
                    Target::Package(name.clone())
                }
                _ => return,
            },
        };
        self.arrows.insert(Arrow { from: self.path.to_vec(), target, place });
    }

    /// Takes in the paths that stand in the tokens of a macro.
    fn tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = Vec::new();
        let mut line = 0;
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        self.add_from_macro(&path, line);
                        path.clear();
                    }
                    line = ident.span().start().line;
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    self.add_from_macro(&path, line);
                    path.clear();
                    colons = 0;
                    self.tokens(group.stream());
                }
                _ => {
                    self.add_from_macro(&path, line);
                    path.clear();
                    colons = 0;
                }
            }
        }
        self.add_from_macro(&path, line);
    }

    fn add_from_macro(&mut self, path: &[String], line: usize) {
        if path.len() > 1 {
            self.add(path, line);
        }
    }
}

impl<'ast> Visit<'ast> for Imports<'_> {
    fn visit_item_mod(&mut self, module: &'ast ItemMod) {
        if module.content.is_some() && !super::source::is_test(&module.attrs) {
            self.inner.push(module.ident.to_string());
            visit::visit_item_mod(self, module);
            self.inner.pop();
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.flatten(&item.tree, Vec::new(), item.span().start().line);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> =
            path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if segments.len() > 1 {
            self.add(&segments, path.span().start().line);
        }
        visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        self.tokens(mac.tokens.clone());
        visit::visit_macro(self, mac);
    }
}
