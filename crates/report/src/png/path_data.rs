//! The data of a path: `M1 2h3l-1 4Z`.

use tiny_skia::{Path, PathBuilder};

use super::attribute::coordinate;

/// Reads the data of a path of straight lines: `M`, `L`, `H`, `V`, `Z`, and the same from the last
/// point on in small letters. Returns what cannot be drawn if there is something else, and no path
/// if there is no line.
pub(super) fn path(data: &str) -> Result<Option<Path>, String> {
    let mut path = PathBuilder::new();
    let (mut x, mut y) = (0.0, 0.0);
    let mut start = (0.0, 0.0);
    let mut rest = data.trim_start();
    while let Some(command) = rest.chars().next() {
        let unknown = || format!("a path with `{}`", rest.chars().take(20).collect::<String>());
        let (numbers, behind) = numbers(rest.get(1..).ok_or_else(unknown)?).ok_or_else(unknown)?;
        let (from_x, from_y) = if command.is_ascii_lowercase() { (1.0, 1.0) } else { (0.0, 0.0) };
        let step = match command.to_ascii_uppercase() {
            'M' | 'L' => 2,
            'H' | 'V' => 1,
            'Z' if numbers.is_empty() => {
                path.close();
                (x, y) = start;
                rest = behind;
                continue;
            }
            _ => return Err(unknown()),
        };
        if numbers.is_empty() || numbers.len() % step != 0 {
            return Err(unknown());
        }
        for (i, numbers) in numbers.chunks(step).enumerate() {
            match (command.to_ascii_uppercase(), numbers) {
                ('H', [to]) => x = from_x * x + to,
                ('V', [to]) => y = from_y * y + to,
                (_, numbers) => {
                    (x, y) = (from_x * x + numbers[0], from_y * y + numbers[1]);
                }
            }
            // Points behind that of a move are those of lines.
            if i == 0 && command.eq_ignore_ascii_case(&'M') {
                path.move_to(x, y);
                start = (x, y);
            } else {
                path.line_to(x, y);
            }
        }
        rest = behind;
    }
    Ok(path.finish())
}

/// Reads numbers with blanks or commas between them, up to the next letter; returns what follows.
pub(super) fn numbers(text: &str) -> Option<(Vec<f32>, &str)> {
    let end = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (listed, behind) = text.split_at(end);
    // A sign begins a number, with or without a blank before it.
    let listed = listed.replace('-', " -");
    let numbers = listed.split([' ', ',', '\n']).filter(|number| !number.is_empty());
    let numbers: Option<Vec<f32>> = numbers.map(coordinate).collect();
    Some((numbers?, behind))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds(data: &str) -> [f32; 4] {
        let bounds = path(data).unwrap().unwrap().bounds();
        [bounds.left(), bounds.top(), bounds.right(), bounds.bottom()]
    }

    #[test]
    fn lines_go_to_points_and_by_steps() {
        assert_eq!(bounds("M1 2L4,6"), [1.0, 2.0, 4.0, 6.0]);
        assert_eq!(bounds("M1 2 4 6"), [1.0, 2.0, 4.0, 6.0]);
        assert_eq!(bounds("M10 10h5v-5l-20-1"), [-5.0, 4.0, 15.0, 10.0]);
        assert_eq!(bounds("M0 0H7V-3"), [0.0, -3.0, 7.0, 0.0]);
        // What follows a closed line begins where that began.
        assert_eq!(bounds("M2 2h4v4Zl-5 -5"), [-3.0, -3.0, 6.0, 6.0]);
        assert_eq!(bounds("M0 0l6 6m0 -6l-6 6"), [0.0, 0.0, 6.0, 6.0]);
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        for data in ["M1", "M1 2C3 4 5 6 7 8", "1 2", "M1 nan", "M1 1e99", "Z1", "é"] {
            assert!(path(data).unwrap_err().starts_with("a path with `"), "{data}");
        }
        assert!(path("").unwrap().is_none());
    }
}
