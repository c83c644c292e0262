//! The labels of columns in pictures: `layer0_thickness` is "thickness of layer 0".
//!
//! A name is made of words, so most labels are the words of the name. The labels of other keys
//! stand in a list here, those of other results stand with their columns.

use crate::columns::{Column, Role};
use crate::units::Dimension;

/// The labels of keys that are not the words of their names; those of keys of layers and steps are
/// without the layer or the step.
const LABELS: &[(&str, &str)] = &[
    ("poisson", "Poisson's ratio"),
    ("layers", "number of layers"),
    ("punch_shear_modulus", "shear modulus of the punch"),
    ("punch_poisson", "Poisson's ratio of the punch"),
    ("radius_x", "radius of curvature along x"),
    ("radius_y", "radius of curvature along y"),
    ("angle", "angle of the cone"),
    ("flange_back_to_origin", "distance from flange back to origin"),
    ("lateral", "lateral displacement"),
    ("mu", "coefficient of friction"),
    ("domain_width_x", "width of Ω along x"),
    ("domain_width_y", "width of Ω along y"),
    ("domain_center_x", "x of the centre of Ω"),
    ("domain_center_y", "y of the centre of Ω"),
    ("steps", "number of load steps"),
    ("cycle_from", "first step of the cycle"),
    ("cycles", "number of cycles"),
    ("epsilon", "regularisation ε"),
    ("ceiling", "pressure ceiling"),
    ("max_iterations", "most iterations"),
];

/// Returns the label of a column beside the `others` of its table.
pub fn label(column: &Column, others: &[Column]) -> String {
    if let Some(label) = column.label {
        return label.to_owned();
    }
    let name = column.name.as_ref();
    if let Some((index, key)) = indexed(name, "layer") {
        return format!("{} of layer {index}", words(key));
    }
    if let Some((index, key)) = indexed(name, "step") {
        return format!("{} in step {index}", words(key));
    }
    // A motion that was reached is the same quantity as a motion that is prescribed.
    let reached = name.strip_prefix("at_").filter(|_| column.role == Role::Observable);
    let layered = others.iter().any(|other| indexed(&other.name, "layer").is_some());
    match reached.unwrap_or(name) {
        // Without layers there is one foundation.
        key @ ("shear_modulus" | "poisson") if layered => format!("{} of the base", words(key)),
        other => words(other),
    }
}

/// Returns the name of the quantity that a dimension measures.
pub fn quantity_name(dimension: Dimension) -> &'static str {
    let noun = dimension.noun();
    noun.split_once(' ').map_or(noun, |(_, name)| name)
}

/// Splits `layer0_thickness` into `0` and `thickness`.
fn indexed<'n>(name: &'n str, list: &str) -> Option<(&'n str, &'n str)> {
    let (index, key) = name.strip_prefix(list)?.split_once('_')?;
    (!index.is_empty() && index.bytes().all(|byte| byte.is_ascii_digit())).then_some((index, key))
}

fn words(name: &str) -> String {
    if let Some((_, label)) = LABELS.iter().find(|(known, _)| *known == name) {
        return (*label).to_owned();
    }
    for (prefix, noun) in [("error_", "error"), ("estimate_", "estimated error")] {
        let Some(of) = name.strip_prefix(prefix) else { continue };
        return match (of, of.strip_prefix("local_")) {
            (_, Some(of)) => format!("{noun} of local means of the {of}"),
            ("pressure" | "traction", _) => format!("{noun} of the {of} in L2"),
            _ => format!("{noun} of the {}", of.replace('_', " ")),
        };
    }
    match name.rsplit_once('_') {
        Some((rest @ ("tilt" | "moment"), axis)) => format!("{rest} about {axis}"),
        Some((rest, axis @ ("x" | "y" | "z"))) => {
            format!("{} along {axis}", rest.replace('_', " "))
        }
        _ => name.replace('_', " "),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::{HashMap, HashSet};

    use super::*;
    use crate::columns::along_path;
    use crate::key::Key;
    use crate::kind::Kind;

    #[test]
    fn no_two_columns_of_one_study_are_called_the_same() {
        let layered = Kind::Solve.columns([], Key::all(|_| 12));
        let bare = Kind::Solve.columns([], Key::all(|_| 0));
        let kinds = Kind::ALL.iter().map(|kind| kind.columns([], Key::all(|_| 1)));
        for columns in [along_path(layered.clone()), layered, bare].into_iter().chain(kinds) {
            let mut called = HashMap::new();
            for column in &columns {
                let label = label(column, &columns);
                assert!(!label.contains('_') && !label.is_empty(), "{label}");
                // A motion that is prescribed and one that was reached are the same quantity.
                let before = called
                    .insert((label.clone(), column.name.starts_with("at_")), column.name.clone());
                assert!(before.is_none(), "{before:?} and {} are both called {label}", column.name);
            }
        }
    }

    #[test]
    fn every_label_in_the_list_belongs_to_a_column() {
        let all =
            || Kind::ALL.iter().flat_map(|kind| along_path(kind.columns([], Key::all(|_| 1))));
        let all: Vec<Column> = all().collect();
        let names: HashSet<&str> = all
            .iter()
            .map(|column| {
                indexed(&column.name, "layer").map_or(column.name.as_ref(), |(_, key)| key)
            })
            .collect();
        for (name, _) in LABELS {
            assert!(names.contains(name), "{name}");
        }
    }

    #[test]
    fn labels_read_well() {
        let columns = along_path(Kind::Solve.columns([], Key::all(|_| 12)));
        for (name, expected) in [
            ("layer0_thickness", "thickness of layer 0"),
            ("layer11_poisson", "Poisson's ratio of layer 11"),
            ("poisson", "Poisson's ratio of the base"),
            ("step1_force_x", "force along x in step 1"),
            ("step2_moment_z", "moment about z in step 2"),
            ("at_shift_x", "shift along x"),
            ("at_tilt_y", "tilt about y"),
            ("stick_fraction", "stick fraction"),
            ("mu", "coefficient of friction"),
            ("estimate_peak_pressure", "estimated error of the peak pressure"),
            ("estimate_traction", "estimated error of the traction in L2"),
        ] {
            let column = columns.iter().find(|column| column.name == name).unwrap();
            assert_eq!(label(column, &columns), expected);
        }
        let bare = Kind::Solve.columns([], Key::all(|_| 0));
        assert_eq!(
            label(bare.iter().find(|column| column.name == "poisson").unwrap(), &bare),
            "Poisson's ratio"
        );
    }
}
