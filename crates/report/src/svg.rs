//! Drawing as SVG: shapes, text and the measure of text.

use std::fmt::Write;
use std::sync::LazyLock;

use skrifa::instance::{LocationRef, Size};
use skrifa::{FontRef, MetadataProvider};

/// Arimo: metrically compatible with Arial and Helvetica, so that what is measured here holds with
/// each of them.
pub(crate) const FONT: &[u8] = include_bytes!("../font/Arimo-Regular.ttf");
const FAMILIES: &str = "Arimo, 'Liberation Sans', Arial, Helvetica, sans-serif";

/// Advance of every character of the font, as a fraction of the font size.
static ADVANCES: LazyLock<Vec<(u32, f32)>> = LazyLock::new(|| {
    let Ok(font) = FontRef::new(FONT) else { return Vec::new() };
    let metrics = font.glyph_metrics(Size::new(1.0), LocationRef::default());
    let mut advances: Vec<(u32, f32)> = font
        .charmap()
        .mappings()
        .map(|(c, glyph)| (c, metrics.advance_width(glyph).unwrap_or(0.6)))
        .collect();
    advances.sort_by_key(|&(c, _)| c);
    advances
});

/// The width of a line of text; characters that the font lacks count as one em, which no font
/// exceeds by much.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match ADVANCES.binary_search_by_key(&u32::from(c), |&(c, _)| c) {
        Ok(i) => f64::from(ADVANCES[i].1),
        Err(_) => 1.0,
    };
    text.chars().map(advance).sum::<f64>() * size
}

/// The text cut to a width, with an ellipsis if anything is lost.
pub(crate) fn shorten(text: &str, width: f64, size: f64) -> String {
    if text_width(text, size) <= width {
        return text.to_owned();
    }
    let mut kept = String::new();
    for c in text.chars() {
        kept.push(c);
        if text_width(&kept, size) + size > width {
            kept.pop();
            break;
        }
    }
    format!("{}…", kept.trim_end())
}

/// The text broken between words into at most `lines` lines of a width; what does not fit is cut.
pub(crate) fn wrap(text: &str, width: f64, size: f64, lines: usize) -> Vec<String> {
    let mut wrapped: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match wrapped.last_mut() {
            Some(line) if wrapped_fits(line, word, width, size) => {
                line.push(' ');
                line.push_str(word);
            }
            _ => wrapped.push(word.to_owned()),
        }
    }
    if wrapped.len() > lines {
        let rest = wrapped.split_off(lines - 1).join(" ");
        wrapped.push(rest);
    }
    wrapped.iter().map(|line| shorten(line, width, size)).collect()
}

fn wrapped_fits(line: &str, word: &str, width: f64, size: f64) -> bool {
    text_width(line, size) + text_width(" ", size) + text_width(word, size) <= width
}

/// A rectangle of the drawing: the corner at the top left, y downwards.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Rect {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Rect {
    pub(crate) fn right(&self) -> f64 {
        self.x + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.y + self.height
    }
}

/// Where a text is anchored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

impl Anchor {
    fn name(self) -> &'static str {
        match self {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        }
    }
}

/// A drawing in progress. Lengths are pixels of 1/96 inch; every piece is opaque, but for bands.
#[derive(Debug, Default)]
pub(crate) struct Drawing {
    body: String,
}

impl Drawing {
    /// Any element, as SVG.
    pub(crate) fn push(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    pub(crate) fn line(
        &mut self,
        (x1, y1): (f64, f64),
        (x2, y2): (f64, f64),
        color: &str,
        width: f64,
    ) {
        self.push(&format!(
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="{color}" stroke-width="{}"/>"#,
            n(x1),
            n(y1),
            n(x2),
            n(y2),
            n(width)
        ));
    }

    pub(crate) fn rect(&mut self, rect: Rect, fill: &str, stroke: &str, width: f64) {
        self.push(&format!(
            r#"<rect x="{}" y="{}" width="{}" height="{}" fill="{fill}" stroke="{stroke}" stroke-width="{}"/>"#,
            n(rect.x),
            n(rect.y),
            n(rect.width),
            n(rect.height),
            n(width)
        ));
    }

    /// A line of text whose baseline is at `y`.
    pub(crate) fn text(&mut self, (x, y): (f64, f64), size: f64, anchor: Anchor, text: &str) {
        let anchor = anchor.name();
        self.push(&format!(
            r#"<text x="{}" y="{}" font-size="{}" text-anchor="{anchor}">{}</text>"#,
            n(x),
            n(y),
            n(size),
            escape(text)
        ));
    }

    /// A line of text read from below, centred on `y`, whose baseline is at `x`.
    pub(crate) fn text_upwards(&mut self, (x, y): (f64, f64), size: f64, text: &str) {
        let (x, y) = (n(x), n(y));
        self.push(&format!(
            r#"<text x="{x}" y="{y}" font-size="{}" text-anchor="middle" transform="rotate(-90 {x} {y})">{}</text>"#,
            n(size),
            escape(text)
        ));
    }

    /// The finished document on a white ground.
    pub(crate) fn finish(self, width: f64, height: f64, title: &str) -> String {
        let (w, h) = (n(width.ceil()), n(height.ceil()));
        let mut out = String::with_capacity(self.body.len() + 512);
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" xmlns:xlink=\"http://www.w3.org/1999/xlink\" role=\"img\" \
             width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" font-family=\"{FAMILIES}\" fill=\"#1a1a1a\">"
        );
        let _ = writeln!(out, "<title>{}</title>", escape(title));
        let _ = writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
        out += &self.body;
        out += "</svg>\n";
        out
    }
}

/// A coordinate with two decimals, which is finer than print.
pub(crate) fn n(x: f64) -> String {
    let text = format!("{x:.2}");
    match crate::si::trim_zeros(&text) {
        "-0" => "0".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}

/// Text for XML: what XML 1.0 cannot hold at all becomes `�`.
pub(crate) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\n' | '\r' | '\t' => out.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_measured_as_arial() {
        // Widths of Arial in units of 1/2048 em: A 1366, digits 1139, blank 569.
        assert!((text_width("A0 ", 2048.0) - (1366.0 + 1139.0 + 569.0)).abs() < 1.0);
    }

    #[test]
    fn long_text_is_broken_and_cut() {
        let width = text_width("stick fraction", 12.0) + 0.1;
        assert_eq!(
            wrap("stick fraction of the punch", width, 12.0, 9),
            ["stick fraction", "of the punch"]
        );
        let cut = wrap("stick fraction of the punch", width, 12.0, 1);
        assert!(cut[0].ends_with('…') && text_width(&cut[0], 12.0) <= width, "{cut:?}");
        assert!(wrap("", width, 12.0, 1).is_empty());
    }
}
