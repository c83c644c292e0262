//! Links from page to page, to headings and to files of the repository.

use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

use super::ROOT;
use super::page::Page;

/// Returns the links of a page that lead nowhere. Those to other sites are not followed.
pub(super) fn broken(page: &Page) -> Vec<String> {
    let mut findings = Vec::new();
    for link in &page.links {
        if link.target.contains("://") || link.target.starts_with("mailto:") {
            continue;
        }
        let (file, heading) = link.target.split_once('#').unwrap_or((&link.target, ""));
        let path = if file.is_empty() { page.path.clone() } else { page.directory().join(file) };
        let book = Path::new(ROOT).join("docs/book/src");
        let leaves = page.path.starts_with(&book) && !plain(&path).starts_with(&book);
        let is_found =
            path.exists() && (heading.is_empty() || Page::read(path).anchors.contains(heading));
        if !is_found || leaves {
            let fault = if is_found { "leads out of the book" } else { "is not there" };
            findings.push(format!("{}: {} {fault}", page.place(link.line), link.target));
        }
    }
    findings
}

/// Returns the pages of the book that SUMMARY.md does not name once, and what else it names.
pub(super) fn unlisted(pages: &[Page]) -> Vec<String> {
    let book = Path::new(ROOT).join("docs/book/src");
    let summary = pages.iter().find(|page| page.path.ends_with("SUMMARY.md")).unwrap();
    let mut times: BTreeMap<PathBuf, usize> = pages
        .iter()
        .filter(|page| page.path.starts_with(&book) && !page.path.ends_with("SUMMARY.md"))
        .map(|page| (page.path.clone(), 0))
        .collect();
    let mut findings = Vec::new();
    for link in &summary.links {
        match times.get_mut(&book.join(&link.target)) {
            Some(count) => *count += 1,
            None => findings.push(format!("{} is no page", link.target)),
        }
    }
    let wrong = times.into_iter().filter(|(_, count)| *count != 1);
    findings.extend(
        wrong.map(|(path, count)| format!("{} stands there {count} times", path.display())),
    );
    findings
}

/// Returns a path without `..`.
fn plain(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            part => plain.push(part),
        }
    }
    plain
}
