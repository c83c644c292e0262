//! Reads the sources of the workspace: which files there are, which modules they are, what they
//! hold beside tests.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use syn::{Attribute, File, Item};

/// A crate of the workspace.
pub(crate) struct Package {
    /// The name under which other crates import it; the program is `tribosweep`.
    pub(crate) name: String,
    /// Its files by the path of their module; the root has the empty path.
    pub(crate) modules: BTreeMap<Vec<String>, Module>,
}

/// A file that is a module of its own.
pub(crate) struct Module {
    /// Its path below the root of the workspace.
    pub(crate) file: String,
    pub(crate) text: String,
    /// What it holds beside tests.
    pub(crate) syntax: File,
}

/// The root of the workspace.
pub(crate) fn root() -> PathBuf {
    std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from).expect("cargo says where it stands")
}

/// Reads every crate of the workspace, the program last.
pub(crate) fn packages() -> Vec<Package> {
    let crates = std::fs::read_dir(root().join("crates")).expect("the crates can be listed");
    let mut places: Vec<PathBuf> =
        crates.map(|entry| entry.expect("an entry can be read").path()).collect();
    places.sort();
    let mut packages: Vec<Package> = places
        .iter()
        .map(|place| {
            let name = place.file_name().expect("a crate has a folder").to_string_lossy();
            package(&name, &place.join("src"))
        })
        .collect();
    packages.push(package("python", &root().join("python/src")));
    packages.push(package("tribosweep", &root().join("src")));
    packages
}

fn package(name: &str, src: &Path) -> Package {
    let mut modules = BTreeMap::new();
    let face = ["lib.rs", "main.rs"].map(|file| src.join(file)).into_iter().find(|p| p.is_file());
    read(&face.expect("a crate has a lib.rs or a main.rs"), Vec::new(), src, &mut modules);
    Package { name: name.to_owned(), modules }
}

/// Reads the file of a module and the files of the modules that it declares.
fn read(file: &Path, path: Vec<String>, src: &Path, modules: &mut BTreeMap<Vec<String>, Module>) {
    let text = std::fs::read_to_string(file)
        .unwrap_or_else(|error| panic!("{} cannot be read: {error}", file.display()));
    let mut syntax = syn::parse_file(&text)
        .unwrap_or_else(|error| panic!("{} cannot be parsed: {error}", file.display()));
    syntax.items.retain(|item| !is_test(attributes(item)));
    let declared = syntax.items.iter().filter_map(|item| match item {
        Item::Mod(module) if module.content.is_none() => Some(module.ident.to_string()),
        _ => None,
    });
    for child in declared.collect::<Vec<_>>() {
        let folder = path.iter().fold(src.to_owned(), |folder, name| folder.join(name));
        let own_file = folder.join(format!("{child}.rs"));
        let face = folder.join(&child).join("mod.rs");
        let mut below = path.clone();
        below.push(child);
        read(if own_file.is_file() { &own_file } else { &face }, below, src, modules);
    }
    let file = file.strip_prefix(root()).unwrap_or(file).display().to_string();
    modules.insert(path, Module { file, text, syntax });
}

/// Returns what breaks a rule in any module, which `find` notes.
pub(crate) fn findings(
    packages: &[Package],
    mut find: impl FnMut(&Module, &mut Vec<String>),
) -> Vec<String> {
    let mut findings = Vec::new();
    for module in packages.iter().flat_map(|package| package.modules.values()) {
        find(module, &mut findings);
    }
    findings
}

/// Tells whether an item is compiled for tests alone.
pub(crate) fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let is_cfg = attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|word| word == "test");
        is_cfg || attribute.path().is_ident("test")
    })
}

/// The attributes of an item.
pub(crate) fn attributes(item: &Item) -> &[Attribute] {
    match item {
        Item::Const(item) => &item.attrs,
        Item::Enum(item) => &item.attrs,
        Item::ExternCrate(item) => &item.attrs,
        Item::Fn(item) => &item.attrs,
        Item::ForeignMod(item) => &item.attrs,
        Item::Impl(item) => &item.attrs,
        Item::Macro(item) => &item.attrs,
        Item::Mod(item) => &item.attrs,
        Item::Static(item) => &item.attrs,
        Item::Struct(item) => &item.attrs,
        Item::Trait(item) => &item.attrs,
        Item::TraitAlias(item) => &item.attrs,
        Item::Type(item) => &item.attrs,
        Item::Union(item) => &item.attrs,
        Item::Use(item) => &item.attrs,
        _ => &[],
    }
}
