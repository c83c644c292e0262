//! Drawing as SVG: shapes and text. Lengths are pixels of 1/96 inch, and y runs downwards.

use std::fmt::Write;

use crate::font::FAMILIES;
use crate::number::trim_zeros;
use crate::text::escape;

/// A rectangle of the drawing with its corner at the top left.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// The end of a text that stands at its x.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// A drawing in progress. Every shape is opaque, except for bands.
#[derive(Debug, Default)]
pub(crate) struct Drawing {
    body: String,
    /// True if the parts that a page shows and hides are groups.
    grouped: bool,
}

impl Drawing {
    /// Makes an empty drawing; `grouped` says whether [`begin`](Drawing::begin) has an effect.
    pub(crate) fn new(grouped: bool) -> Self {
        Drawing { body: String::new(), grouped }
    }

    /// Begins a group with attributes, if the drawing is grouped.
    pub(crate) fn begin(&mut self, attributes: std::fmt::Arguments<'_>) {
        if self.grouped {
            self.push(&format!("<g {attributes}>"));
        }
    }

    /// Ends the group, if the drawing is grouped.
    pub(crate) fn end(&mut self) {
        if self.grouped {
            self.push("</g>");
        }
    }

    /// Adds an invisible rectangle that a pointer meets, if the drawing is grouped.
    pub(crate) fn target(&mut self, rect: Rect) {
        if self.grouped {
            self.rect(rect, "transparent", "none", 0.0);
        }
    }

    /// Adds an element that is SVG already.
    pub(crate) fn push(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// Adds a line of a width from one point to another.
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

    /// Adds a rectangle with a fill and an outline of a width.
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

    /// Adds a line of text whose baseline is at `y`.
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

    /// Adds a line of text that is read from below, centred on `y`, with its baseline at `x`.
    pub(crate) fn text_upwards(&mut self, (x, y): (f64, f64), size: f64, text: &str) {
        let (x, y) = (n(x), n(y));
        self.push(&format!(
            r#"<text x="{x}" y="{y}" font-size="{}" text-anchor="middle" transform="rotate(-90 {x} {y})">{}</text>"#,
            n(size),
            escape(text)
        ));
    }

    /// Returns the finished document on a white ground.
    pub(crate) fn finish(self, width: f64, height: f64, title: &str) -> String {
        let (w, h) = (n(width.ceil()), n(height.ceil()));
        let mut out = String::with_capacity(self.body.len() + 512);
        // Writing to a string does not fail.
        let _ = writeln!(
            out,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" \
             xmlns:xlink=\"http://www.w3.org/1999/xlink\" role=\"img\" \
             width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"{FAMILIES}\" fill=\"#1a1a1a\">"
        );
        let _ = writeln!(out, "<title>{}</title>", escape(title));
        let _ = writeln!(out, "<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
        out += &self.body;
        out += "</svg>\n";
        out
    }
}

/// Writes a coordinate with two decimals, which is finer than print.
pub(crate) fn n(x: f64) -> String {
    let text = format!("{x:.2}");
    match trim_zeros(&text) {
        "-0" => "0".to_owned(),
        trimmed => trimmed.to_owned(),
    }
}
