//! Comments are sentences: documentation begins with a capital letter and a word that can begin a
//! sentence, ends with a full stop, and says what errors mean. Lines end before column 100.

use syn::visit::{self, Visit};
use syn::{AttrStyle, Attribute, Expr, Lit, Meta, ReturnType, Type, Visibility};

use super::source::{Module, Package, findings, is_test};
use super::{SOURCE_FINDINGS, assert_none};

/// Words that begin half a sentence.
const HALVES: [&str; 11] =
    ["What", "Of", "Whoever", "Who", "How", "Where", "Whether", "Whose", "From", "By", "As"];

/// These files have the help texts of the command line, which clap prints without a full stop.
const HELP_TEXTS: [&str; 2] = ["src/cli.rs", "src/cli/"];

#[test]
fn documentation_is_written_in_sentences() {
    assert_none("documentation is written in whole sentences", &SOURCE_FINDINGS.half_sentences);
}

#[test]
fn public_functions_say_what_their_errors_mean() {
    let findings = &SOURCE_FINDINGS.silent_errors;
    assert_none("a public function that returns a Result has a section `# Errors`", findings);
}

#[test]
fn functions_are_documented_by_a_verb_in_the_third_person() {
    let findings = &SOURCE_FINDINGS.missing_verbs;
    assert_none("the documentation of a function begins with a verb such as Returns", findings);
}

#[test]
fn comments_end_before_column_100() {
    assert_none("a line of comment has at most 100 columns", &SOURCE_FINDINGS.long_comments);
}

pub(super) fn half_sentences(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| {
        let is_help = HELP_TEXTS.iter().any(|place| module.file.starts_with(place));
        let mut sentences = Sentences { lines: Vec::new() };
        sentences.visit_file(&module.syntax);
        for comment in sentences.comments() {
            let first = &comment[0];
            if let Some(fault) = fault(comment, is_help) {
                let place = format!("{}:{}", module.file, first.number);
                findings.push(format!("{place}: {fault}: {}", first.text.trim()));
            }
        }
    })
}

pub(super) fn silent_errors(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| Errors { module, findings }.visit_file(&module.syntax))
}

pub(super) fn missing_verbs(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| Verbs { module, findings }.visit_file(&module.syntax))
}

pub(super) fn long_comments(packages: &[Package]) -> Vec<String> {
    findings(packages, |module, findings| {
        for (line, content) in module.text.lines().enumerate() {
            let is_comment = content.trim_start().starts_with("//");
            if is_comment && content.chars().count() > 100 {
                findings.push(format!("{}:{}", module.file, line + 1));
            }
        }
    })
}

/// Returns the number and the text of a line of documentation.
fn documentation(attribute: &Attribute) -> Option<(usize, String)> {
    let Meta::NameValue(pair) = &attribute.meta else { return None };
    let Expr::Lit(literal) = &pair.value else { return None };
    let Lit::Str(text) = &literal.lit else { return None };
    attribute.path().is_ident("doc").then(|| (text.span().start().line, text.value()))
}

/// Returns what is wrong with the documentation of one item, if anything is. A help text ends
/// without a full stop.
fn fault(lines: &[DocLine], is_help: bool) -> Option<&'static str> {
    let paragraph: Vec<&str> =
        lines.iter().map(|line| line.text.trim()).take_while(|text| !text.is_empty()).collect();
    let text = paragraph.join(" ");
    let first = text.split([' ', ',', ':', ';']).next()?;
    if first.chars().next().is_some_and(|letter| letter.is_ascii_lowercase()) {
        return Some("begins with a small letter");
    }
    if HALVES.contains(&first) || text.starts_with("The same ") {
        return Some("begins with half a sentence");
    }
    let closed = ['"', '.', ':', '!', '?', ')', '|', '`'];
    (!is_help && !text.ends_with(closed)).then_some("has no full stop")
}

struct Sentences {
    /// Each line of documentation: where it stands, whether it is an inner one, its text.
    lines: Vec<DocLine>,
}

#[derive(PartialEq)]
struct DocLine {
    number: usize,
    is_inner: bool,
    text: String,
}

impl Sentences {
    /// Joins the lines that stand below each other.
    fn comments(&self) -> impl Iterator<Item = &[DocLine]> {
        self.lines.chunk_by(|upper, lower| {
            upper.number + 1 == lower.number && upper.is_inner == lower.is_inner
        })
    }
}

impl<'ast> Visit<'ast> for Sentences {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        if let Some((number, text)) = documentation(attribute) {
            let is_inner = matches!(attribute.style, AttrStyle::Inner(_));
            self.lines.push(DocLine { number, is_inner, text });
        }
    }
}

struct Verbs<'m> {
    module: &'m Module,
    findings: &'m mut Vec<String>,
}

impl Verbs<'_> {
    fn check(&mut self, attributes: &[Attribute], signature: &syn::Signature) {
        let Some((line, text)) = attributes.iter().find_map(documentation) else { return };
        let word = text.split_whitespace().next().unwrap_or_default();
        let is_verb = word.ends_with('s') && word.starts_with(|first: char| first.is_uppercase());
        if !is_verb {
            self.findings.push(format!("{}:{line}: `{}`", self.module.file, signature.ident));
        }
    }
}

impl<'ast> Visit<'ast> for Verbs<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        self.check(&function.attrs, &function.sig);
    }
    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        self.check(&function.attrs, &function.sig);
    }
    fn visit_trait_item_fn(&mut self, function: &'ast syn::TraitItemFn) {
        self.check(&function.attrs, &function.sig);
    }
}

struct Errors<'m> {
    module: &'m Module,
    findings: &'m mut Vec<String>,
}

impl Errors<'_> {
    fn check(&mut self, attributes: &[Attribute], signature: &syn::Signature) {
        let ReturnType::Type(_, returned) = &signature.output else { return };
        let Type::Path(path) = &**returned else { return };
        let is_result = path.path.segments.last().is_some_and(|last| last.ident == "Result");
        let explains =
            attributes.iter().filter_map(documentation).any(|(_, text)| text.trim() == "# Errors");
        if is_result && !explains {
            let line = signature.ident.span().start().line;
            self.findings.push(format!("{}:{line}: `{}`", self.module.file, signature.ident));
        }
    }
}

impl<'ast> Visit<'ast> for Errors<'_> {
    fn visit_item_mod(&mut self, module: &'ast syn::ItemMod) {
        if !is_test(&module.attrs) {
            visit::visit_item_mod(self, module);
        }
    }
    fn visit_item_fn(&mut self, function: &'ast syn::ItemFn) {
        if matches!(function.vis, Visibility::Public(_)) {
            self.check(&function.attrs, &function.sig);
        }
    }
    fn visit_impl_item_fn(&mut self, function: &'ast syn::ImplItemFn) {
        if matches!(function.vis, Visibility::Public(_)) {
            self.check(&function.attrs, &function.sig);
        }
    }
}
