//! The rolling of a step, whose keys stand beside the others of the step.
//!
//! A step rolls if it says `steady = true`, which is the limit of a long way, or a `distance`. The
//! distance is divided evenly, into `increments` or into parts no longer than `dq`.

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

/// The part of an increment that a distance may lack or have in excess and still be a whole number
/// of them: quotients of decimal numbers are rounded.
const ROUNDING: f64 = 1e-12;

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
            let increments = divide(sheet, i, distance, mistakes);
            let dq = Some(distance / f64::from(increments));
            let rolling = Rolling { dq, history: RollingHistory::Transient, ..rolling };
            RollingWay { rolling: Some(rolling), increments }
        }
        None => RollingWay { rolling: Some(rolling), increments },
    }
}

/// Returns the number of increments of a distance \[m\].
fn divide(sheet: &Sheet<'_>, i: u32, distance: f64, mistakes: &mut Vec<Mistake>) -> u32 {
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
    let parts = by_length.map(|dq| (distance / dq * (1.0 - ROUNDING)).ceil().max(1.0));
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
        (Some(increments), ..) => return increments,
        (None, Some(dq), _) if dq <= 0.0 => not_positive(Key::Dq(i), dq),
        (None, Some(_), Some(parts)) if parts > most => {
            let message = format!("`{}` divides the distance into {parts}", Key::Dq(i).short());
            refuse(Key::Dq(i), message, "must leave at most 1000 increments")
        }
        (None, Some(_), Some(parts)) => return parts as u32,
        (None, ..) => {
            let message = format!("`{}` is not divided", Key::Distance(i).short());
            let expected = "needs `increments` beside it, or `dq`, the longest way of an \
                            increment";
            let advice = "an element is a good length: the result's column `element_x` has it";
            refuse(Key::Distance(i), message, expected).map(|mistake| mistake.help(advice))
        }
    };
    mistakes.extend(mistake);
    1
}

/// Notes the first key that is for rolling in a step that does not roll.
fn refuse_rolling(sheet: &Sheet<'_>, i: u32, mistakes: &mut Vec<Mistake>) {
    let of_rolling = [
        Key::CreepageX(i),
        Key::CreepageY(i),
        Key::Spin(i),
        Key::SpinCenter(i),
        Key::Direction(i),
        Key::Dq(i),
    ];
    for key in of_rolling {
        let Some(given) = sheet.get(key) else { continue };
        let message = format!("`{}` stands in a step that does not roll", key.short());
        let expected = "a step rolls if it has `steady = true` or a `distance`";
        mistakes.push(Mistake::new(given.span.clone(), message, expected));
        return;
    }
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
