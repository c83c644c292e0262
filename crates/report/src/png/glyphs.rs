//! Lines of text as outlines of the embedded font.

use std::sync::LazyLock;

use tiny_skia::{Path, PathBuilder};
use ttf_parser::gpos::{PairAdjustment, PositioningSubtable};
use ttf_parser::{Face, GlyphId, OutlineBuilder};

use crate::font::{FONT, is_ignorable};

static FACE: LazyLock<Option<Face<'static>>> = LazyLock::new(|| Face::parse(FONT, 0).ok());

/// A line of text as one outline that begins at the origin of its baseline; y runs downwards.
pub(super) struct TextOutline {
    /// The outline; a line of blanks has none.
    pub(super) path: Option<Path>,
    /// The advance of the whole line \[pixels\].
    pub(super) width: f32,
}

impl TextOutline {
    /// Sets a line in a size \[pixels\], with the kerning of the font. A character that the font
    /// lacks is a box of one em, as [`text_width`](crate::font::text_width) has it; one without a
    /// look of its own is left out.
    ///
    /// Text is not shaped: characters follow each other from the left to the right as they are
    /// stored. An accent that is a character of its own stands beside its letter, so that text is
    /// to be composed (NFC), and scripts that join letters or run from the right are not set.
    pub(super) fn new(text: &str, size: f32) -> TextOutline {
        let Some(face) = FACE.as_ref() else { return TextOutline { path: None, width: 0.0 } };
        let em = f32::from(face.units_per_em());
        let mut pen = ScaledPen { path: PathBuilder::new(), scale: size / em, advance: 0.0 };
        let mut last = None;
        for c in text.chars().filter(|&c| !is_ignorable(c)) {
            // The font's own glyph for what it lacks is empty, and would hide that it is lacking.
            let Some(glyph) = face.glyph_index(c) else {
                pen.missing(em);
                last = None;
                continue;
            };
            if let Some(last) = last {
                pen.advance += f32::from(kerning(face, last, glyph).unwrap_or(0));
            }
            // A blank has no outline.
            let _ = face.outline_glyph(glyph, &mut pen);
            pen.advance += f32::from(face.glyph_hor_advance(glyph).unwrap_or(0));
            last = Some(glyph);
        }
        TextOutline { width: pen.advance * pen.scale, path: pen.path.finish() }
    }
}

/// Returns what the font adds between two glyphs, in its units; `None` if it has nothing to say of
/// them.
fn kerning(face: &Face<'_>, first: GlyphId, second: GlyphId) -> Option<i16> {
    let lookups = face.tables().gpos?.lookups;
    let tables = lookups.into_iter().flat_map(|lookup| lookup.subtables.into_iter());
    for table in tables {
        let PositioningSubtable::Pair(pairs) = table else { continue };
        let Some(index) = pairs.coverage().get(first) else { continue };
        let values = match pairs {
            PairAdjustment::Format1 { sets, .. } => sets.get(index).and_then(|set| set.get(second)),
            PairAdjustment::Format2 { classes, matrix, .. } => {
                matrix.get((classes.0.get(first), classes.1.get(second)))
            }
        };
        if let Some((value, _)) = values {
            return Some(value.x_advance);
        }
    }
    None
}

/// A pen that draws glyphs beside each other.
struct ScaledPen {
    path: PathBuilder,
    /// The pixels of a unit of the font.
    scale: f32,
    /// The place where the glyph begins, in units of the font.
    advance: f32,
}

impl ScaledPen {
    /// Draws a frame as wide as an em in the place of a character.
    fn missing(&mut self, em: f32) {
        // The inner side runs the other way, so that it stays empty.
        for (left, right, edge) in [(0.1, 0.9, 0.0), (0.85, 0.15, 0.05)] {
            self.move_to(left * em, edge * em);
            self.line_to(left * em, (0.7 - edge) * em);
            self.line_to(right * em, (0.7 - edge) * em);
            self.line_to(right * em, edge * em);
            self.close();
        }
        self.advance += em;
    }

    fn x(&self, x: f32) -> f32 {
        (self.advance + x) * self.scale
    }

    fn y(&self, y: f32) -> f32 {
        -y * self.scale
    }
}

impl OutlineBuilder for ScaledPen {
    fn move_to(&mut self, x: f32, y: f32) {
        self.path.move_to(self.x(x), self.y(y));
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.path.line_to(self.x(x), self.y(y));
    }

    fn quad_to(&mut self, cx0: f32, cy0: f32, x: f32, y: f32) {
        self.path.quad_to(self.x(cx0), self.y(cy0), self.x(x), self.y(y));
    }

    fn curve_to(&mut self, cx0: f32, cy0: f32, cx1: f32, cy1: f32, x: f32, y: f32) {
        let (first, second, end) =
            ((self.x(cx0), self.y(cy0)), (self.x(cx1), self.y(cy1)), (self.x(x), self.y(y)));
        self.path.cubic_to(first.0, first.1, second.0, second.1, end.0, end.1);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_the_advance_of_their_characters_with_kerning() {
        let width = |text| TextOutline::new(text, 2048.0).width;
        // Advances of Arial in units of 1/2048 em: A 1366, V 1366, digits 1139; A and V are 152
        // closer.
        assert_eq!(width("00"), 2.0 * 1139.0);
        assert_eq!(width("AA"), 2.0 * 1366.0);
        assert_eq!(width("AV"), 2.0 * 1366.0 - 152.0);
    }

    #[test]
    fn a_missing_character_is_a_box_and_an_ignorable_one_is_nothing() {
        let line = |text| TextOutline::new(text, 2048.0);
        let (with, without) = (line("A\u{200B}V\u{AD}\u{FE0F}"), line("AV"));
        // The kerning goes on across what is left out.
        assert_eq!(with.width, without.width);
        assert_eq!(with.path, without.path);
        assert!(line("\u{200B}").path.is_none());
        let (missing, other) = (line("面"), line("色"));
        assert_eq!(missing.width, 2048.0);
        assert!(missing.path.is_some());
        assert_eq!(missing.path, other.path, "both are the box");
    }

    #[test]
    fn outlines_stand_on_the_baseline() {
        let bounds = TextOutline::new("H", 100.0).path.unwrap().bounds();
        assert_eq!(bounds.bottom(), 0.0);
        assert!((-75.0..-65.0).contains(&bounds.top()), "{bounds:?}");
        assert!(TextOutline::new(" ", 100.0).path.is_none());
    }
}
