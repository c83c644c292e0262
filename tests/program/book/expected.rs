//! What a page says that a command prints: `[..]` stands for any text within a line, and a line
//! `...` for any number of lines.

/// Whether the output is what the page says. Blanks at the ends of lines do not count.
pub(super) fn is_met(expected: &[&str], actual: &[&str]) -> bool {
    match expected.split_first() {
        None => actual.is_empty(),
        Some((&"...", rest)) => (0..=actual.len()).any(|from| is_met(rest, &actual[from..])),
        Some((line, rest)) => actual
            .split_first()
            .is_some_and(|(first, others)| is_line(line, first) && is_met(rest, others)),
    }
}

fn is_line(expected: &str, actual: &str) -> bool {
    let (expected, actual) = (expected.trim_end(), actual.trim_end());
    let mut parts = expected.split("[..]");
    let begin = parts.next().unwrap();
    let Some(mut rest) = actual.strip_prefix(begin) else { return false };
    let mut parts = parts.peekable();
    if parts.peek().is_none() {
        return rest.is_empty();
    }
    while let Some(part) = parts.next() {
        if parts.peek().is_none() {
            return rest.ends_with(part);
        }
        let Some(at) = rest.find(part) else { return false };
        rest = &rest[at + part.len()..];
    }
    unreachable!("the last part returns")
}

#[test]
fn wildcards_stand_for_words_and_lines() {
    let met = |expected: &str, actual: &str| {
        is_met(&expected.lines().collect::<Vec<_>>(), &actual.lines().collect::<Vec<_>>())
    };
    assert!(met("a\nb", "a\nb  "));
    assert!(met("", ""));
    assert!(!met("", "a"));
    assert!(!met("a", "a\nb"));
    assert!(!met("a\nb", "a"));
    assert!(met("in [..] s, [..] left", "in 1.5 s, 3 left"));
    assert!(!met("in [..] s, [..] left", "in 1.5 s, 3 lost"));
    assert!(!met("in [..]", "on 3"));
    assert!(!met("[..]aa", "a"));
    assert!(met("a\n...\nd", "a\nb\nc\nd"));
    assert!(met("...\nd", "d"));
    assert!(!met("a\n...\nd", "a\nb\nc"));
}
