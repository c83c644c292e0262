//! The font and the measure of text. Lengths are pixels of 1/96 inch.

use std::ops::RangeInclusive;
use std::sync::LazyLock;

use ttf_parser::Face;

/// Arimo, which has the metrics of Arial and Helvetica, so that the measures taken here hold with
/// each of them.
pub(crate) const FONT: &[u8] = include_bytes!("../font/Arimo-Regular.ttf");
/// The font families of a figure; a viewer takes the first that it has.
pub(crate) const FAMILIES: &str = "Arimo, 'Liberation Sans', Arial, Helvetica, sans-serif";

/// The advance of every character of the font, as a fraction of the font size, in order of
/// characters.
static ADVANCES: LazyLock<Vec<(u32, f32)>> = LazyLock::new(|| {
    let Ok(face) = Face::parse(FONT, 0) else { return Vec::new() };
    let em = f32::from(face.units_per_em());
    let mut advances = Vec::new();
    for table in face.tables().cmap.iter().flat_map(|map| map.subtables) {
        if table.is_unicode() {
            table.codepoints(|c| {
                let glyph = table.glyph_index(c);
                let advance = glyph.and_then(|glyph| face.glyph_hor_advance(glyph));
                advances.extend(advance.map(|advance| (c, f32::from(advance) / em)));
            });
        }
    }
    advances.sort_by_key(|&(c, _)| c);
    advances.dedup_by_key(|&mut (c, _)| c);
    advances
});

/// The characters without a look of their own, whose font need not have them: Unicode's
/// `Default_Ignorable_Code_Point`.
const IGNORABLE: [RangeInclusive<char>; 17] = [
    '\u{AD}'..='\u{AD}',
    '\u{34F}'..='\u{34F}',
    '\u{61C}'..='\u{61C}',
    '\u{115F}'..='\u{1160}',
    '\u{17B4}'..='\u{17B5}',
    '\u{180B}'..='\u{180F}',
    '\u{200B}'..='\u{200F}',
    '\u{202A}'..='\u{202E}',
    '\u{2060}'..='\u{206F}',
    '\u{3164}'..='\u{3164}',
    '\u{FE00}'..='\u{FE0F}',
    '\u{FEFF}'..='\u{FEFF}',
    '\u{FFA0}'..='\u{FFA0}',
    '\u{FFF0}'..='\u{FFF8}',
    '\u{1BCA0}'..='\u{1BCA3}',
    '\u{1D173}'..='\u{1D17A}',
    '\u{E0000}'..='\u{E0FFF}',
];

/// Tells whether a character has no look of its own, such as a break without width or a selector of
/// a variant.
pub(crate) fn is_ignorable(c: char) -> bool {
    IGNORABLE.iter().any(|range| range.contains(&c))
}

/// Returns the width of a line of text. Characters that the font lacks count as one em, which no
/// font exceeds by much; those without a look of their own have no width.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    let advance = |c: char| match ADVANCES.binary_search_by_key(&u32::from(c), |&(c, _)| c) {
        _ if is_ignorable(c) => 0.0,
        Ok(i) => f64::from(ADVANCES[i].1),
        Err(_) => 1.0,
    };
    text.chars().map(advance).sum::<f64>() * size
}

/// Cuts a text to a width, with an ellipsis if anything is lost.
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

/// Breaks a text between words into at most `lines` lines of a width, and cuts the rest.
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

/// Says whether another word fits at the end of a line.
fn wrapped_fits(line: &str, word: &str, width: f64, size: f64) -> bool {
    text_width(line, size) + text_width(" ", size) + text_width(word, size) <= width
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
    fn characters_without_a_look_have_no_width() {
        let width = |text| text_width(text, 100.0);
        assert_eq!(width("a\u{AD}b\u{200B}c\u{FE0F}\u{E0100}"), width("abc"));
        // The font has no letters of Chinese.
        assert_eq!(width("面"), 100.0);
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
