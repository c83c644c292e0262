//! One name, one meaning: a type's name is defined once in the whole workspace, nouns are nouns,
//! and what has three parts has names for them.

use std::collections::BTreeMap;

use proc_macro2::Ident;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Type, Visibility};

use super::source::{Module, Package, findings, is_test};
use super::{SOURCE_FINDINGS, assert_none};

/// Words that stand for a noun without being one.
const PRONOUNS: [&str; 5] = ["which", "own", "at", "asked", "way"];

#[test]
fn a_type_name_has_one_meaning() {
    let findings = &SOURCE_FINDINGS.repeated_types;
    assert_none("a type name is defined once in the workspace", findings);
}

#[test]
fn variables_and_fields_are_nouns() {
    assert_none("a variable or a field is called by a noun", &SOURCE_FINDINGS.pronouns);
}

#[test]
fn what_has_three_parts_is_a_struct() {
    let findings = &SOURCE_FINDINGS.tuples;
    assert_none("a signature has no tuple of three or more, and no (bool, String)", findings);
}

pub(super) fn repeated_types(packages: &[Package]) -> Vec<String> {
    let mut places: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for module in packages.iter().flat_map(|package| package.modules.values()) {
        TypeNames { module, places: &mut places }.visit_file(&module.syntax);
    }
    let repeated = places.into_iter().filter(|(_, places)| places.len() > 1);
    repeated.map(|(name, places)| format!("`{name}`: {}", places.join(", "))).collect()
}

pub(super) fn pronouns(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| {
        Pronouns { module, findings }.visit_file(&module.syntax);
    })
}

pub(super) fn tuples(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| Tuples { module, findings }.visit_file(&module.syntax))
}

struct TypeNames<'m> {
    module: &'m Module,
    places: &'m mut BTreeMap<String, Vec<String>>,
}

impl TypeNames<'_> {
    fn add(&mut self, name: &Ident) {
        let place = format!("{}:{}", self.module.file, name.span().start().line);
        self.places.entry(name.to_string()).or_default().push(place);
    }
}

impl<'ast> Visit<'ast> for TypeNames<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_item_struct(&mut self, item: &'ast syn::ItemStruct) {
        self.add(&item.ident);
    }
    fn visit_item_enum(&mut self, item: &'ast syn::ItemEnum) {
        self.add(&item.ident);
    }
    fn visit_item_trait(&mut self, item: &'ast syn::ItemTrait) {
        self.add(&item.ident);
    }
    fn visit_item_type(&mut self, item: &'ast syn::ItemType) {
        // An alias inside a function abbreviates; it defines no concept.
        if !matches!(item.vis, Visibility::Inherited) {
            self.add(&item.ident);
        }
    }
}

struct Pronouns<'m> {
    module: &'m Module,
    findings: &'m mut Vec<String>,
}

impl Pronouns<'_> {
    fn check(&mut self, name: &Ident) {
        if PRONOUNS.iter().any(|pronoun| name == pronoun) {
            let line = name.span().start().line;
            self.findings.push(format!("{}:{line}: `{name}`", self.module.file));
        }
    }
}

impl<'ast> Visit<'ast> for Pronouns<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_pat_ident(&mut self, pattern: &'ast syn::PatIdent) {
        self.check(&pattern.ident);
        visit::visit_pat_ident(self, pattern);
    }
    fn visit_field(&mut self, field: &'ast syn::Field) {
        field.ident.iter().for_each(|name| self.check(name));
        visit::visit_field(self, field);
    }
}

struct Tuples<'m> {
    module: &'m Module,
    findings: &'m mut Vec<String>,
}

impl<'ast> Visit<'ast> for Tuples<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_signature(&mut self, signature: &'ast syn::Signature) {
        let mut found = FoundTuples(Vec::new());
        found.visit_signature(signature);
        for line in found.0 {
            self.findings.push(format!("{}:{line}: `{}`", self.module.file, signature.ident));
        }
    }
    fn visit_field(&mut self, field: &'ast syn::Field) {
        let mut found = FoundTuples(Vec::new());
        found.visit_field(field);
        for line in found.0 {
            let name = field.ident.as_ref().map(Ident::to_string).unwrap_or_default();
            self.findings.push(format!("{}:{line}: the field `{name}`", self.module.file));
        }
    }
}

/// The lines of tuple types that should be structs.
struct FoundTuples(Vec<usize>);

impl<'ast> Visit<'ast> for FoundTuples {
    fn visit_type_tuple(&mut self, tuple: &'ast syn::TypeTuple) {
        let is_named = |position: usize, name: &str| match tuple.elems.iter().nth(position) {
            Some(Type::Path(path)) => path.path.is_ident(name),
            _ => false,
        };
        let is_verdict = tuple.elems.len() == 2 && is_named(0, "bool") && is_named(1, "String");
        if tuple.elems.len() > 2 || is_verdict {
            self.0.push(tuple.span().start().line);
        }
        visit::visit_type_tuple(self, tuple);
    }
}
