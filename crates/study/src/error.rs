//! The mistakes in a study file, with their places.

use std::fmt;
use std::ops::Range;

use annotate_snippets::{AnnotationKind, Renderer};
use wording::{excerpt, visible};

mod picture;

use picture::{Mark, Picture, floor};

/// A place in a study's text, in byte offsets.
pub type Span = Range<usize>;

/// One mistake in a study file.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Mistake {
    /// The fault, as a lower-case fragment.
    pub message: String,
    /// The place.
    pub span: Span,
    /// The remedy, which is shown at the place.
    pub expected: String,
    /// The advice beyond the place; it may be empty.
    pub help: String,
    /// A second place that matters, and the reason why it does.
    pub context: Option<Box<(Span, String)>>,
}

impl Mistake {
    /// Makes a mistake at a place.
    pub(crate) fn new(span: Span, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Mistake {
            message: message.into(),
            span,
            expected: expected.into(),
            help: String::new(),
            context: None,
        }
    }

    /// Adds advice.
    pub(crate) fn help(mut self, help: impl Into<String>) -> Self {
        self.help = help.into();
        self
    }

    /// Suggests a key that stands elsewhere, with what was expected as the advice beyond that.
    pub(crate) fn instead(mut self, path: &str) -> Self {
        self.help = std::mem::replace(&mut self.expected, format!("did you mean `{path}`?"));
        self
    }

    /// Returns the mistake as it is drawn.
    fn picture(&self) -> Picture<'_> {
        let context = self.context.as_deref().map(|(span, reason)| Mark {
            span,
            label: reason,
            kind: AnnotationKind::Context,
        });
        Picture {
            message: &self.message,
            help: &self.help,
            primary: Mark {
                span: &self.span,
                label: &self.expected,
                kind: AnnotationKind::Primary,
            },
            context,
        }
    }

    /// Adds a second place.
    pub(crate) fn context(mut self, span: Span, label: impl Into<String>) -> Self {
        self.context = Some(Box::new((span, label.into())));
        self
    }
}

/// The reason why a text is no study: at least one [`Mistake`], in the order of the file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StudyError {
    path: String,
    text: String,
    mistakes: Vec<Mistake>,
}

/// The number of mistakes that are shown; the others are only counted.
const MOST_SHOWN: usize = 20;

/// The number of mistakes after which no more are looked for.
const MOST_COUNTED: usize = 1000;

/// The length of the longest message, in characters. Messages quote what is in the file.
const LONGEST_MESSAGE: usize = 400;

/// The length of the longest advice, in characters. Advice lists what there is.
const LONGEST_ADVICE: usize = 4000;

/// Returns whether there are so many mistakes that no more need be looked for.
pub(crate) fn are_enough(mistakes: &[Mistake]) -> bool {
    mistakes.len() >= MOST_COUNTED
}

impl StudyError {
    pub(crate) fn new(path: &str, text: &str, mut mistakes: Vec<Mistake>) -> Self {
        for mistake in &mut mistakes {
            mistake.span = within(text, &mistake.span);
            mistake.message = excerpt(&mistake.message, LONGEST_MESSAGE);
            for advice in [&mut mistake.expected, &mut mistake.help] {
                *advice = shortened(advice);
            }
            if let Some(context) = &mut mistake.context {
                context.0 = within(text, &context.0);
            }
        }
        let mut seen = std::collections::HashSet::new();
        mistakes.retain(|mistake| seen.insert(mistake.clone()));
        mistakes.sort_by_key(|mistake| mistake.span.start);
        StudyError { path: path.to_owned(), text: text.to_owned(), mistakes }
    }

    /// Returns the mistakes, in the order of the file.
    pub fn mistakes(&self) -> &[Mistake] {
        &self.mistakes
    }

    /// Returns the line and the column of a mistake, counted from 1, columns in characters.
    pub fn position(&self, mistake: &Mistake) -> (usize, usize) {
        let before = self.text.get(..mistake.span.start).unwrap_or(&self.text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
    }

    /// Renders every mistake with its line of the file and a caret under the place, with ANSI
    /// `colours` on demand.
    pub fn render(&self, colours: bool) -> String {
        let renderer = if colours { Renderer::styled() } else { Renderer::plain() };
        let mut shown: Vec<String> = self
            .mistakes
            .iter()
            .take(MOST_SHOWN)
            .map(|mistake| mistake.picture().draw(&self.path, &self.text, &renderer))
            .collect();
        if let Some(rest) = self.mistakes.len().checked_sub(MOST_SHOWN).filter(|rest| *rest > 0) {
            let so_far = if are_enough(&self.mistakes) { " at least" } else { "" };
            shown.push(format!("and {rest} more{so_far}"));
        }
        shown.join("\n\n")
    }
}

impl fmt::Display for StudyError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.render(false))
    }
}

impl std::error::Error for StudyError {}

/// Returns advice with its lines, cut if it is too long.
fn shortened(advice: &str) -> String {
    match advice.char_indices().nth(LONGEST_ADVICE) {
        Some((end, _)) => format!("{}…", visible(&advice[..end])),
        None => visible(advice).into_owned(),
    }
}

/// Cuts the span to the text, to character boundaries and to its first line, so that it can always
/// be shown.
fn within(text: &str, span: &Span) -> Span {
    let start = floor(text, span.start);
    let end = floor(text, span.end).max(start);
    let first_line = text[start..end].find('\n').map_or(end, |newline| start + newline);
    start..first_line
}
