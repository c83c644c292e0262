//! Names beside points, as far as there is room for them.

use super::canvas::{PlotPoint, Segment};
use crate::axis::INK;
use crate::font::text_width;
use crate::svg::{Drawing, Rect, n};
use crate::text::escape;

/// The font size, in pixels as all lengths here.
const NAME_SIZE: f64 = 10.0;
/// The height of a digit above the baseline, as a fraction of the font size.
const ASCENT: f64 = 0.74;
/// The depth of a letter below the baseline, as a fraction of the font size.
const DESCENT: f64 = 0.2;
/// The largest number of names that are tried: no figure has room for more.
const MOST: usize = 80;

/// The shapes that names must not cover.
pub(super) struct Obstacles {
    /// The frame that names must not leave.
    pub(super) frame: Rect,
    /// The middles of markers with their radii.
    pub(super) markers: Vec<(PlotPoint, f64)>,
    /// The pieces of curves. A name may stand on one if there is no other room.
    pub(super) lines: Vec<Segment>,
    /// The stairs of a front, whose dashes would read as a minus.
    pub(super) stairs: Vec<Segment>,
}

/// Writes each name beside its point, `clear` pixels from it: on a side where it covers no curve if
/// there is one, otherwise on a side where it covers neither marker nor stair nor other name,
/// otherwise not at all.
pub(super) fn draw(
    drawing: &mut Drawing,
    wanted: &[(PlotPoint, &str)],
    clear: f64,
    taken: &Obstacles,
) {
    let every = wanted.len().div_ceil(MOST).max(1);
    let mut names: Vec<Rect> = Vec::new();
    for &(point, name) in wanted.iter().step_by(every).filter(|(_, name)| !name.is_empty()) {
        let sides = sides(point, text_width(name, NAME_SIZE), clear);
        let free =
            |rect: &&Rect| taken.has_room(rect) && !names.iter().any(|other| overlap(other, rect));
        let side = sides
            .iter()
            .filter(free)
            .find(|rect| !taken.crosses(rect))
            .or_else(|| sides.iter().find(free));
        let Some(&side) = side else { continue };
        let baseline = side.y + ASCENT * NAME_SIZE;
        // The white rim keeps a line of the grid or of a curve from running through the letters.
        drawing.push(&format!(
            r##"<text x="{}" y="{}" font-size="{NAME_SIZE}" text-anchor="start" fill="{INK}" stroke="#ffffff" stroke-width="2.5" paint-order="stroke">{}</text>"##,
            n(side.x),
            n(baseline),
            escape(name)
        ));
        names.push(side);
    }
}

/// Returns the places for a name, in the order in which they are tried: right and left above, right
/// and left below, beside, above, below.
fn sides((x, y): PlotPoint, width: f64, clear: f64) -> [Rect; 8] {
    let height = (ASCENT + DESCENT) * NAME_SIZE;
    // At a corner the distance is along a diagonal.
    let corner = 0.8 * clear;
    let [right, left, middle] = [x + clear, x - clear - width, x - width / 2.0];
    let rect = |x: f64, y: f64| Rect { x, y, width, height };
    [
        rect(x + corner, y - corner - height),
        rect(x - corner - width, y - corner - height),
        rect(x + corner, y + corner),
        rect(x - corner - width, y + corner),
        rect(right, y - height / 2.0),
        rect(left, y - height / 2.0),
        rect(middle, y - clear - height),
        rect(middle, y + clear),
    ]
}

/// Says whether two names come too close to each other.
fn overlap(a: &Rect, b: &Rect) -> bool {
    const APART: f64 = 1.5;
    a.x < b.right() + APART
        && b.x < a.right() + APART
        && a.y < b.bottom() + APART
        && b.y < a.bottom() + APART
}

impl Obstacles {
    /// Says whether a rectangle is within the frame and covers no marker and no stair.
    fn has_room(&self, rect: &Rect) -> bool {
        let frame = &self.frame;
        let inside = rect.x > frame.x + 2.0
            && rect.right() < frame.right() - 2.0
            && rect.y > frame.y + 2.0
            && rect.bottom() < frame.bottom() - 2.0;
        let covers = |&((x, y), radius): &(PlotPoint, f64)| {
            (rect.x - radius..rect.right() + radius).contains(&x)
                && (rect.y - radius..rect.bottom() + radius).contains(&y)
        };
        inside
            && !self.markers.iter().any(covers)
            && !self.stairs.iter().any(|&line| crosses(rect, line))
    }

    /// Says whether a curve runs through a rectangle.
    fn crosses(&self, rect: &Rect) -> bool {
        self.lines.iter().any(|&line| crosses(rect, line))
    }
}

/// Says whether a piece of a line runs through a rectangle: whether anything is left of it between
/// the four sides.
fn crosses(rect: &Rect, ((x1, y1), (x2, y2)): Segment) -> bool {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (start, step, low, high) in
        [(x1, x2 - x1, rect.x, rect.right()), (y1, y2 - y1, rect.y, rect.bottom())]
    {
        if step == 0.0 {
            if start < low || start > high {
                return false;
            }
            continue;
        }
        let (a, b) = ((low - start) / step, (high - start) / step);
        from = from.max(a.min(b));
        to = to.min(a.max(b));
    }
    from <= to
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAME: Rect = Rect { x: 0.0, y: 0.0, width: 200.0, height: 100.0 };

    /// Returns x, baseline and text of each name that was written.
    fn written(
        wanted: &[(PlotPoint, &str)],
        markers: &[PlotPoint],
        lines: &[Segment],
    ) -> Vec<(String, String, String)> {
        let mut drawing = Drawing::default();
        draw(
            &mut drawing,
            wanted,
            6.0,
            &Obstacles {
                frame: FRAME,
                markers: markers.iter().map(|&marker| (marker, 3.5)).collect(),
                lines: lines.to_vec(),
                stairs: Vec::new(),
            },
        );
        let svg = drawing.finish(1.0, 1.0, "");
        let texts = svg.lines().filter(|line| line.starts_with("<text"));
        let piece = |line: &str, before: &str, after: char| {
            let rest = &line[line.find(before).unwrap() + before.len()..];
            rest[..rest.find(after).unwrap()].to_owned()
        };
        texts
            .map(|line| {
                (piece(line, "x=\"", '"'), piece(line, "y=\"", '"'), piece(line, "\">", '<'))
            })
            .collect()
    }

    #[test]
    fn a_name_stands_on_a_side_that_is_free() {
        let middle = (100.0, 50.0);
        let alone = written(&[(middle, "64")], &[middle], &[]);
        assert_eq!(alone[0].0, "104.8", "right above");
        let crossed = written(&[(middle, "64")], &[middle], &[(middle, (200.0, 0.0))]);
        assert_ne!(crossed[0].0, "104.8", "not on the curve");
        let corner = (199.0, 1.0);
        assert!(
            written(&[(corner, "64")], &[corner], &[])[0].0.parse::<f64>().unwrap() < 199.0,
            "within the frame"
        );
    }

    #[test]
    fn names_without_room_are_left_out() {
        let crowd: Vec<PlotPoint> = (0..40)
            .flat_map(|i| (0..20).map(move |j| (5.0 * f64::from(i), 5.0 * f64::from(j))))
            .collect();
        assert_eq!(written(&[((100.0, 50.0), "64")], &crowd, &[]), []);
        let same: Vec<(PlotPoint, &str)> = vec![((100.0, 50.0), "a long name"); 20];
        assert!(
            (1..8).contains(&written(&same, &[(100.0, 50.0)], &[]).len()),
            "names do not cover each other"
        );
    }

    #[test]
    fn lines_cross_rectangles() {
        let rect = Rect { x: 1.0, y: 1.0, width: 2.0, height: 1.0 };
        for (line, expected) in [
            (((0.0, 0.0), (4.0, 3.0)), true),
            (((0.0, 1.5), (4.0, 1.5)), true),
            (((2.0, 0.0), (2.0, 9.0)), true),
            (((1.5, 1.5), (1.6, 1.5)), true),
            (((0.0, 3.0), (4.0, 3.0)), false),
            (((0.0, 1.5), (0.5, 1.5)), false),
            (((0.0, 2.0), (1.0, 9.0)), false),
        ] {
            assert_eq!(crosses(&rect, line), expected, "{line:?}");
        }
    }
}
