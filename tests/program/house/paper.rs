//! The paper about the program has the parts and the length that the Journal of Open Source Software
//! asks for, and its references exist.

use std::collections::BTreeSet;

use super::source::root;

/// The sections that the journal asks for since 2026, in their order.
const SECTIONS: [&str; 8] = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
    "Acknowledgements",
    "References",
];

fn read(file: &str) -> String {
    std::fs::read_to_string(root().join(file)).unwrap()
}

/// Returns the text of the paper, without its head.
fn text() -> String {
    let paper = read("paper/paper.md");
    let mut parts = paper.splitn(3, "---\n");
    assert_eq!(parts.next(), Some(""), "the paper begins with its head");
    let head = parts.next().unwrap();
    for key in ["title:", "tags:", "authors:", "affiliations:", "date:", "bibliography: paper.bib"]
    {
        assert!(head.lines().any(|line| line.starts_with(key)), "its head has no `{key}`");
    }
    parts.next().unwrap().to_owned()
}

#[test]
fn the_paper_has_the_sections_and_the_length_that_are_asked_for() {
    let text = text();
    let sections: Vec<&str> = text.lines().filter_map(|line| line.strip_prefix("# ")).collect();
    assert_eq!(sections, SECTIONS);
    let words = text.split_whitespace().count();
    assert!((750..=1750).contains(&words), "{words} words");
    for peer in ["CONTACT", "tamaas", "ContactMechanics", "slippy", "Siconos"] {
        assert!(text.contains(peer), "{peer} is not in it");
    }
}

#[test]
fn every_work_that_the_paper_cites_is_in_its_list_and_the_other_way_round() {
    let is_key = |c: char| c.is_ascii_alphanumeric();
    let text = text();
    let cited: BTreeSet<&str> = text
        .split('@')
        .skip(1)
        .map(|rest| rest.split(|c| !is_key(c)).next().unwrap_or_default())
        .collect();
    let list = read("paper/paper.bib");
    let mut listed = BTreeSet::new();
    for entry in list.split("\n@") {
        let key = entry.split_once('{').unwrap().1.split(',').next().unwrap();
        assert!(listed.insert(key), "{key} is there twice");
        let field = |name: &str| {
            entry.lines().find_map(|line| line.trim().strip_prefix(name)?.strip_prefix(" = {"))
        };
        for name in ["author", "title"] {
            assert!(field(name).is_some(), "{key} has no {name}");
        }
        let doi = field("doi").map(|rest| rest.trim_end_matches(['}', ',']));
        if let Some(doi) = doi {
            let (registrant, name) = doi.split_once('/').unwrap_or_default();
            let digits = registrant.strip_prefix("10.").unwrap_or_default();
            assert!((4..=9).contains(&digits.len()) && !name.is_empty(), "{key}: {doi}");
            assert!(digits.bytes().all(|byte| byte.is_ascii_digit()), "{key}: {doi}");
            assert!(!doi.contains(char::is_whitespace), "{key}: {doi}");
        }
        let is_found = doi.is_some() || entry.contains("\\url{https://") || key == "alexandrov";
        assert!(is_found, "{key} cannot be found");
    }
    assert_eq!(cited, listed);
}

/// A work that `cite` prints as well has the same DOI there.
#[test]
fn works_of_the_paper_have_the_dois_that_the_program_prints() {
    let program = read("crates/contact/src/literature.rs");
    let list = read("paper/paper.bib");
    for key in ["kalker1990", "christensen1998"] {
        let (_, entry) = list.split_once(&format!("{{{key},")).unwrap();
        let (_, doi) = entry.split_once("doi = {").unwrap();
        let doi = doi.split('}').next().unwrap();
        assert!(program.contains(&format!("doi: Some(\"{doi}\")")), "{key}: {doi}");
    }
}

#[test]
fn the_description_for_archives_has_its_fields() {
    let said: serde_json::Value = serde_json::from_str(&read("codemeta.json")).unwrap();
    assert_eq!(said["@context"], "https://doi.org/10.5063/schema/codemeta-2.0");
    assert_eq!(said["@type"], "SoftwareSourceCode");
    assert_eq!(said["codeRepository"], env!("CARGO_PKG_REPOSITORY"));
    for field in ["name", "description", "issueTracker", "operatingSystem", "softwareRequirements"]
    {
        assert!(said[field].as_str().is_some_and(|text| !text.is_empty()), "no `{field}`");
    }
    for field in ["license", "programmingLanguage", "keywords", "author"] {
        assert!(said[field].as_array().is_some_and(|list| !list.is_empty()), "no `{field}`");
    }
    let citation = read("CITATION.cff");
    let title = citation.lines().find_map(|line| line.strip_prefix("title: ")).unwrap();
    assert!(title.contains(said["name"].as_str().unwrap()));
    assert!(citation.contains(said["codeRepository"].as_str().unwrap()));
}
