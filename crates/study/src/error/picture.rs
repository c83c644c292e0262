//! The picture of a mistake: the line of the file with a mark under the place.
//!
//! Only the lines around the places are looked at, and only the part of a long line around its
//! place is drawn, so that a picture of a large file costs as much as one of a small file.

use std::ops::Range;

use annotate_snippets::{Annotation, AnnotationKind, Level, Renderer, Snippet};
use wording::{one_line, visible};

/// The largest number of lines between two places that are drawn together.
const NEAR: usize = 40;

/// The length of the longest line that is drawn whole, in bytes.
const LONG: usize = 240;

/// The bytes of a longer line that are drawn before a place, and of the place and after it.
const AROUND: usize = 80;

/// A mistake as it is drawn.
pub(super) struct Picture<'m> {
    pub(super) message: &'m str,
    pub(super) help: &'m str,
    /// The place of the mistake.
    pub(super) primary: Mark<'m>,
    /// Another place that matters.
    pub(super) context: Option<Mark<'m>>,
}

impl Picture<'_> {
    /// Draws the mistake in the text of a file.
    pub(super) fn draw(&self, path: &str, text: &str, renderer: &Renderer) -> String {
        let Picture { message, help, primary, context } = self;
        let path = one_line(path);
        let groups = match context {
            Some(context) if are_near(text, primary.span, context.span) => {
                vec![vec![*primary, *context]]
            }
            Some(context) => vec![vec![*primary], vec![*context]],
            None => vec![vec![*primary]],
        };
        let mut group = Level::ERROR
            .primary_title(*message)
            .elements(groups.iter().map(|marks| snippet(&path, text, marks)));
        if !help.is_empty() {
            group = group.element(Level::HELP.message(*help));
        }
        let drawn = renderer.render(&[group]);
        // The column of a place in a line that is cut or escaped is not the one that is drawn.
        let place = DrawnPlace::of(text, primary.span);
        let position = |column: usize| format!("{path}:{}:{column}", place.line);
        drawn.replacen(&position(place.drawn), &position(place.column), 1)
    }
}

/// The position of a place, counted from 1.
struct DrawnPlace {
    line: usize,
    /// The column in the file, in characters.
    column: usize,
    /// The column in the picture.
    drawn: usize,
}

impl DrawnPlace {
    fn of(text: &str, span: &Range<usize>) -> Self {
        let start = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
        let line = line_around(text, span);
        let place = span.start - start..(span.end - start).min(line.len());
        let DrawnLine { text: drawn, places } = DrawnLine::of(line, &[place]);
        let before = places.first().and_then(|place| drawn.get(..place.start)).unwrap_or_default();
        Self {
            line: text[..start].bytes().filter(|byte| *byte == b'\n').count() + 1,
            column: text[start..span.start].chars().count() + 1,
            drawn: before.chars().count() + 1,
        }
    }
}

/// A place that is marked.
#[derive(Clone, Copy)]
pub(super) struct Mark<'m> {
    pub(super) span: &'m Range<usize>,
    /// The words beside the mark; there may be none.
    pub(super) label: &'m str,
    pub(super) kind: AnnotationKind,
}

/// Returns whether two places fit into one snippet.
fn are_near(text: &str, a: &Range<usize>, b: &Range<usize>) -> bool {
    let between = &text[a.start.min(b.start)..a.end.max(b.end)];
    match between.match_indices('\n').nth(NEAR) {
        Some(_) => false,
        // On one line they must both be in the part that is drawn.
        None if !between.contains('\n') => {
            between.len() <= AROUND || line_around(text, a).len() <= LONG
        }
        None => between.len() <= NEAR * LONG,
    }
}

/// Returns the line on which a place begins.
fn line_around<'t>(text: &'t str, span: &Range<usize>) -> &'t str {
    let start = text[..span.start].rfind('\n').map_or(0, |end| end + 1);
    text[start..].split('\n').next().unwrap_or_default()
}

/// Returns the lines with the marks, from the first mark to the last.
fn snippet<'m>(path: &'m str, text: &str, marks: &[Mark<'m>]) -> Snippet<'m, Annotation<'m>> {
    let first = marks.iter().map(|mark| mark.span.start).min().unwrap_or(0);
    let last = marks.iter().map(|mark| mark.span.end).max().unwrap_or(0);
    let mut start = text[..first].rfind('\n').map_or(0, |end| end + 1);
    let end = text[last..].find('\n').map_or(text.len(), |newline| last + newline);
    let number = text[..start].bytes().filter(|byte| *byte == b'\n').count() + 1;
    let mut source = String::new();
    let mut spans: Vec<Range<usize>> = vec![0..0; marks.len()];
    for line in text[start..end].split('\n') {
        let inside: Vec<usize> =
            (0..marks.len()).filter(|mark| is_in(marks[*mark].span, start, line)).collect();
        let places: Vec<Range<usize>> = inside
            .iter()
            .map(|mark| marks[*mark].span.start - start..marks[*mark].span.end - start)
            .collect();
        let drawn = DrawnLine::of(line, &places);
        for (mark, span) in inside.iter().zip(&drawn.places) {
            spans[*mark] = source.len() + span.start..source.len() + span.end;
        }
        source += &drawn.text;
        source.push('\n');
        start += line.len() + 1;
    }
    source.pop();
    let snippet = Snippet::source(source).path(path).line_start(number);
    marks.iter().zip(spans).fold(snippet, |snippet, (mark, span)| {
        let label = (!mark.label.is_empty()).then_some(mark.label);
        snippet.annotation(mark.kind.span(span).label(label))
    })
}

/// Returns whether a place is on the line that begins at an offset.
fn is_in(span: &Range<usize>, start: usize, line: &str) -> bool {
    (start..=start + line.len()).contains(&span.start)
}

/// A line as it is drawn.
struct DrawnLine {
    text: String,
    /// The places in it.
    places: Vec<Range<usize>>,
}

impl DrawnLine {
    fn of(line: &str, places: &[Range<usize>]) -> Self {
        let line = line.strip_suffix('\r').unwrap_or(line);
        let window = window(line, places);
        let cut = |offset: usize| floor(line, offset.clamp(window.start, window.end));
        let mut text = if window.start > 0 { "…".to_owned() } else { String::new() };
        // Escaped text is longer, so each offset is found by what is written before it.
        let mut offsets: Vec<usize> =
            places.iter().flat_map(|place| [cut(place.start), cut(place.end)]).collect();
        offsets.sort_unstable();
        offsets.dedup();
        let mut written = window.start;
        let mut positions = Vec::with_capacity(offsets.len());
        for offset in offsets {
            text += &plain(&line[written..offset]);
            positions.push((offset, text.len()));
            written = offset;
        }
        text += &plain(&line[written..window.end]);
        if window.end < line.len() {
            text.push('…');
        }
        let position = |offset: usize| {
            positions
                .iter()
                .find(|(known, _)| *known == offset)
                .map_or(0, |(_, position)| *position)
        };
        let places =
            places.iter().map(|place| position(cut(place.start))..position(cut(place.end)));
        let places = places.collect();
        Self { text, places }
    }
}

/// Returns the part of a line that is drawn.
fn window(line: &str, places: &[Range<usize>]) -> Range<usize> {
    if line.len() <= LONG {
        return 0..line.len();
    }
    let first = places.iter().map(|place| place.start).min().unwrap_or(0);
    floor(line, first.saturating_sub(AROUND))..floor(line, first + 2 * AROUND)
}

/// Returns text that takes as much room as it seems to.
fn plain(text: &str) -> String {
    visible(&text.replace('\t', "    ")).into_owned()
}

/// Returns the last boundary of a character that is not beyond an offset.
pub(super) fn floor(text: &str, offset: usize) -> usize {
    let mut offset = offset.min(text.len());
    while !text.is_char_boundary(offset) {
        offset -= 1;
    }
    offset
}
