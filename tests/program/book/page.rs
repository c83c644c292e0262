//! A page in Markdown: its blocks of code, its headings, its links.

use std::collections::BTreeSet;
use std::ops::Range;
use std::path::{Path, PathBuf};

use pulldown_cmark::{CodeBlockKind, Event, Options, Parser, Tag, TagEnd};

pub(super) struct Page {
    pub(super) path: PathBuf,
    pub(super) text: String,
    pub(super) blocks: Vec<Block>,
    /// What stands between backquotes in the text.
    pub(super) words: Vec<Words>,
    pub(super) links: Vec<Link>,
    /// The names of the headings, by which links find them.
    pub(super) anchors: BTreeSet<String>,
    /// The lines where an emphasis begins within another one, as that of a name with an asterisk does.
    pub(super) nested: Vec<usize>,
}

/// A block of code.
pub(super) struct Block {
    pub(super) line: usize,
    /// What stands behind the fence; empty for an indented block.
    pub(super) language: String,
    pub(super) text: String,
    /// Where the text stands in the page.
    pub(super) range: Range<usize>,
}

pub(super) struct Words {
    pub(super) line: usize,
    pub(super) text: String,
}

pub(super) struct Link {
    pub(super) line: usize,
    pub(super) target: String,
}

impl Page {
    pub(super) fn read(path: PathBuf) -> Self {
        let text = std::fs::read_to_string(&path).unwrap();
        let line = |at: usize| text[..at].lines().count() + 1;
        let mut page = Self {
            path,
            text: String::new(),
            blocks: Vec::new(),
            words: Vec::new(),
            links: Vec::new(),
            anchors: BTreeSet::new(),
            nested: Vec::new(),
        };
        let mut emphases = 0;
        let mut heading: Option<String> = None;
        let mut is_code = false;
        let options = Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES;
        for (event, range) in Parser::new_ext(&text, options).into_offset_iter() {
            match event {
                Event::Start(Tag::CodeBlock(kind)) => {
                    let language = match kind {
                        CodeBlockKind::Fenced(info) => info.to_string(),
                        CodeBlockKind::Indented => String::new(),
                    };
                    is_code = true;
                    page.blocks.push(Block {
                        line: line(range.start),
                        language,
                        text: String::new(),
                        range: range.end..range.end,
                    });
                }
                Event::End(TagEnd::CodeBlock) => is_code = false,
                Event::Text(words) if is_code => {
                    let block = page.blocks.last_mut().unwrap();
                    if block.text.is_empty() {
                        block.range.start = range.start;
                    }
                    block.range.end = range.end;
                    block.text.push_str(&words);
                }
                Event::Start(Tag::Emphasis) => {
                    if emphases > 0 {
                        page.nested.push(line(range.start));
                    }
                    emphases += 1;
                }
                Event::End(TagEnd::Emphasis) => emphases -= 1,
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => {
                    page.anchors.insert(anchor(&heading.take().unwrap()));
                }
                Event::Text(words) | Event::Code(words) if heading.is_some() => {
                    heading.as_mut().unwrap().push_str(&words);
                }
                Event::Code(words) => {
                    page.words.push(Words { line: line(range.start), text: words.into_string() });
                }
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links
                        .push(Link { line: line(range.start), target: dest_url.into_string() });
                }
                _ => (),
            }
        }
        page.text = text;
        page
    }

    /// Returns where something stands, below the directory of the repository.
    pub(super) fn place(&self, line: usize) -> String {
        format!("{}:{line}", self.name())
    }

    pub(super) fn name(&self) -> String {
        self.path.strip_prefix(super::ROOT).unwrap_or(&self.path).display().to_string()
    }

    /// Returns the directory against which the page's links count.
    pub(super) fn directory(&self) -> &Path {
        self.path.parent().unwrap()
    }
}

impl Block {
    pub(super) fn first_line(&self) -> &str {
        self.text.lines().next().unwrap_or_default()
    }

    /// Returns the text behind a mark like `# file:` in the first line.
    pub(super) fn marked(&self, mark: &str) -> Option<&str> {
        self.first_line().strip_prefix(mark).map(str::trim)
    }
}

/// Returns the name of a heading in links, as mdBook and GitHub make it.
fn anchor(heading: &str) -> String {
    let kept = heading.chars().filter_map(|c| match c {
        _ if c.is_whitespace() => Some('-'),
        _ if c.is_alphanumeric() || c == '-' || c == '_' => Some(c),
        _ => None,
    });
    kept.collect::<String>().to_lowercase()
}
