//! The rolling of a step, whose keys stand beside the others of the step.
//!
//! A step rolls if it says `steady = true`, which is the limit of a long way, or a `distance`. The
//! distance is divided evenly, into `increments`, into parts no longer than `dq`, or else into
//! parts no longer than an element.

use contact::model::{ImposedCreepages, Loading, Rolling, RollingDirection, RollingHistory};

use crate::error::Mistake;
use crate::key::Key;
use crate::sheet::Sheet;
use crate::units::Compact;

/// The rolling of a step, if it rolls, and the increments in which the step is taken.
pub(super) struct RollingWay {
    pub(super) rolling: Option<Rolling>,
    pub(super) increments: u32,
}

/// Assembles the rolling of a step. If something is missing or out of place, a mistake is
/// noted.
pub(super) fn rolling(sheet: &Sheet<'_>, i: u32, mistakes: &mut Vec<Mistake>) -> RollingWay {
    let number = |key| sheet.number(key);
    let increments = sheet.count(Key::Increments(i)).unwrap_or(1);
    let (is_steady, distance) =
        (sheet.flag(Key::Steady(i)) == Some(true), number(Key::Distance(i)));
    let rolling = Rolling {
        creepage_x: number(Key::CreepageX(i)),
        creepage_y: number(Key::CreepageY(i)),
        spin: number(Key::Spin(i)),
        spin_center: number(Key::SpinCenter(i)).unwrap_or(0.0),
        direction: match sheet.word(Key::Direction(i)) {
            Some("backward") => RollingDirection::Backward,
            _ => RollingDirection::Forward,
        },
        dq: number(Key::Dq(i)),
        distance: None,
        history: RollingHistory::Steady,
        imposed: ImposedCreepages::default(),
    };
    if !is_steady && distance.is_none() {
        refuse_rolling(sheet, i, mistakes);
        return RollingWay { rolling: None, increments };
    }
    if rolling.spin.is_none()
        && let Some(center) = sheet.get(Key::SpinCenter(i))
    {
        let message = format!("`{}` has no spin to turn", Key::SpinCenter(i).short());
        let expected = "needs `spin` in the same step; a spin that `moment_z` governs turns \
                        about x = 0";
        mistakes.push(Mistake::new(center.span.clone(), message, expected));
    }
    match distance {
        Some(_) if is_steady => {
            let keys = [Key::Distance(i), Key::Steady(i)];
            let message = |key: Key, other: Key| {
                format!(
                    "`{}` cannot stand beside `{}`: what is steady has rolled far enough",
                    key.short(),
                    other.name()
                )
            };
            refuse_both(sheet, keys, message, mistakes);
            RollingWay { rolling: Some(rolling), increments: 1 }
        }
        Some(distance) => {
            let divided = divide(sheet, i, distance, mistakes);
            let (dq, distance) = match divided {
                Some(increments) => (Some(distance / f64::from(increments)), None),
                None => (None, Some(distance)),
            };
            let rolling = Rolling { dq, distance, history: RollingHistory::Transient, ..rolling };
            RollingWay { rolling: Some(rolling), increments: divided.unwrap_or(1) }
        }
        None => RollingWay { rolling: Some(rolling), increments },
    }
}

/// Returns the number of increments of a distance \[m\]; `None` if the elements decide on it.
fn divide(sheet: &Sheet<'_>, i: u32, distance: f64, mistakes: &mut Vec<Mistake>) -> Option<u32> {
    let given = |key: Key| sheet.get(key).map(|given| given.span.clone());
    let refuse = |key: Key, message: String, expected: &str| {
        given(key).map(|span| Mistake::new(span, message, expected))
    };
    let not_positive = |key: Key, value: f64| {
        let message = format!("`{}` cannot be {}", key.short(), Compact(value));
        let expected = "must be positive; `direction` says which way the contact rolls";
        refuse(key, message, expected)
    };
    let (by_count, by_length) = (sheet.count(Key::Increments(i)), sheet.number(Key::Dq(i)));
    let parts = by_length.map(|dq| Rolling::parts_of(distance, dq));
    let most = f64::from(Loading::MAX_INCREMENTS);
    let mistake = match (by_count, by_length, parts) {
        _ if distance <= 0.0 => not_positive(Key::Distance(i), distance),
        (Some(_), Some(_), _) => {
            let keys = [Key::Increments(i), Key::Dq(i)];
            let message = |key: Key, other: Key| {
                format!(
                    "`{}` cannot stand beside `{}`: each divides the distance",
                    key.short(),
                    other.name()
                )
            };
            refuse_both(sheet, keys, message, mistakes);
            None
        }
        (Some(increments), ..) if distance / f64::from(increments) == 0.0 => {
            let message = format!("`{}` cannot be {}", Key::Distance(i).short(), Compact(distance));
            refuse(Key::Distance(i), message, "must be longer, to be divided into increments")
        }
        (Some(increments), ..) => return Some(increments),
        (None, Some(dq), _) if dq <= 0.0 => not_positive(Key::Dq(i), dq),
        (None, Some(_), Some(parts)) if parts > most => {
            let count = if parts.is_finite() {
                // So many digits say enough.
                let rounded = format!("{parts:.3e}").parse().unwrap_or(parts);
                format!("{} increments", Compact(rounded))
            } else {
                "too many increments".to_owned()
            };
            let message = format!("`{}` divides the distance into {count}", Key::Dq(i).short());
            refuse(Key::Dq(i), message, "must leave at most 1000 increments")
        }
        (None, Some(_), Some(parts)) => return Some(parts as u32),
        (None, ..) => return None,
    };
    mistakes.extend(mistake);
    Some(1)
}

/// Notes the keys that are for rolling in a step that does not roll, at the first of them.
fn refuse_rolling(sheet: &Sheet<'_>, i: u32, mistakes: &mut Vec<Mistake>) {
    let of_rolling = [
        Key::CreepageX(i),
        Key::CreepageY(i),
        Key::Spin(i),
        Key::SpinCenter(i),
        Key::Direction(i),
        Key::Dq(i),
    ];
    let mut found: Vec<_> = of_rolling
        .into_iter()
        .filter_map(|key| Some((key, sheet.get(key)?.span.clone())))
        .collect();
    found.sort_by_key(|(_, span)| span.start);
    let Some(((first, span), others)) = found.split_first() else { return };
    let mut named = format!("`{}`", first.short());
    for (number, (key, _)) in others.iter().enumerate() {
        named += if number + 1 == others.len() { " and " } else { ", " };
        named += &format!("`{}`", key.name());
    }
    let verb = if others.is_empty() { "stands" } else { "stand" };
    let message = format!("{named} {verb} in a step that does not roll");
    let expected = "a step rolls if it has `steady = true` or a `distance`";
    mistakes.push(Mistake::new(span.clone(), message, expected));
}

/// Notes two keys that exclude each other, at the one that stands later in the file.
fn refuse_both(
    sheet: &Sheet<'_>,
    keys: [Key; 2],
    message: impl Fn(Key, Key) -> String,
    mistakes: &mut Vec<Mistake>,
) {
    let mut places: Vec<_> =
        keys.iter().filter_map(|key| Some((sheet.get(*key)?.span.clone(), *key))).collect();
    places.sort_by_key(|(span, _)| span.start);
    if let [(first, other), (span, key)] = &places[..] {
        let mistake = Mistake::new(span.clone(), message(*key, *other), "give one of the two");
        mistakes.push(mistake.context(first.clone(), "the other is here"));
    }
}
