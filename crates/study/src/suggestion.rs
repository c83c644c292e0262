//! Guesses at the name that was meant: by spelling, and by what others call the same thing.

use crate::key::{Key, Table, pattern_of, short};

/// The length of the longest word for which anything is suggested, in bytes. Longer ones are no
/// misspelt names, and comparing them would take long.
const LONGEST: usize = 64;

/// Names and words of a study file, each with what else it is called: without capitals, and without
/// anything but letters and digits.
const SYNONYMS: &[(&str, &[&str])] = &[
    (
        "youngs_modulus",
        &[
            "e",
            "young",
            "youngs",
            "youngmodulus",
            "modulus",
            "emodulus",
            "emod",
            "modulusofelasticity",
            "elasticmodulus",
            "elasticitymodulus",
            "elasticity",
            "stiffness",
        ],
    ),
    (
        "shear_modulus",
        &["g", "shear", "gmodulus", "gmod", "modulus", "rigidity", "modulusofrigidity"],
    ),
    ("poisson", &["nu", "ν", "v", "pr", "poissonratio", "poissonsratio", "poissonnumber"]),
    ("radius", &["r", "rad", "radii"]),
    ("radius_x", &["rx", "r1", "a"]),
    ("radius_y", &["ry", "r2", "b"]),
    ("width_x", &["lx", "wx", "sx", "sizex", "lengthx", "length", "width", "size"]),
    ("width_y", &["ly", "wy", "sy", "sizey", "lengthy"]),
    ("center_x", &["centrex", "x0", "cx"]),
    ("center_y", &["centrey", "y0", "cy"]),
    ("angle", &["alpha", "slope"]),
    ("thickness", &["h", "t", "d", "height", "depth"]),
    (
        "normal_force",
        &[
            "f",
            "fz",
            "fn",
            "p",
            "n",
            "w",
            "force",
            "forcez",
            "load",
            "normalload",
            "loadz",
            "weight",
            "forcenormal",
        ],
    ),
    (
        "approach",
        &[
            "delta",
            "δ",
            "d",
            "z",
            "uz",
            "dz",
            "depth",
            "indentation",
            "penetration",
            "interference",
            "displacement",
            "displacementz",
            "shiftz",
            "crushing",
        ],
    ),
    (
        "mu",
        &[
            "µ",
            "μ",
            "f",
            "cof",
            "friction",
            "coulomb",
            "coefficient",
            "coefficientoffriction",
            "frictioncoefficient",
        ],
    ),
    ("friction", &["cof", "coulomb"]),
    ("coefficient", &["k", "archard", "wearcoefficient", "wearrate", "specificwearrate", "kh"]),
    ("wear", &["archard"]),
    ("repeat", &["cyclejump", "jump", "jumps", "cyclesperupdate", "cycles", "deltan", "n"]),
    ("shift_x", &["ux", "dx", "x", "shift", "displacementx", "tangentialdisplacement", "slide"]),
    ("shift_y", &["uy", "dy", "y", "displacementy"]),
    ("force_x", &["fx", "q", "qx", "t", "tx", "tangentialforce", "shearforce", "tangentialload"]),
    ("force_y", &["fy", "qy", "ty"]),
    ("tilt_x", &["rotx", "rotationx", "thetax"]),
    ("tilt_y", &["roty", "rotationy", "thetay"]),
    ("twist", &["phi", "φ", "spin", "rotz", "rotation", "rotationz", "thetaz", "tiltz"]),
    ("moment_x", &["mx", "torquex"]),
    ("moment_y", &["my", "torquey"]),
    ("moment_z", &["mz", "m", "moment", "torque", "torquez", "torsion"]),
    ("speed", &["v", "vs", "vx", "velocity", "speedx", "velocityx", "forwardspeed"]),
    ("angular_speed", &["omega", "ω", "vpitch", "pitchrate", "pitchvelocity", "rotation"]),
    ("lateral_velocity", &["vy", "velocityy", "lateralspeed"]),
    ("yaw_rate", &["vyaw", "yawvelocity", "yawspeed"]),
    ("roll_rate", &["vroll", "rollvelocity", "rollspeed"]),
    ("increments", &["n", "substeps", "increment", "nsteps"]),
    (
        "creepage_x",
        &[
            "xi",
            "ξ",
            "creep",
            "creepage",
            "creepx",
            "slip",
            "slipx",
            "cksi",
            "longitudinalcreepage",
        ],
    ),
    ("creepage_y", &["eta", "η", "creepy", "slipy", "ceta", "lateralcreepage"]),
    ("spin", &["cphi", "spincreepage"]),
    ("distance", &["s", "rollingdistance", "travel", "length"]),
    ("dq", &["ds", "rollingstep", "stepsize"]),
    ("direction", &["sense", "chi"]),
    ("steady", &["stationary", "steadystate"]),
    ("steps", &["step", "path", "history", "loads", "load"]),
    ("mesh", &["n", "nx", "grid", "elements", "resolution", "cells", "points", "size"]),
    ("tolerance", &["tol", "rtol", "precision", "eps"]),
    ("max_iterations", &["iterations", "maxiter", "niter", "maxit"]),
    ("epsilon", &["eps", "ε", "regularisation", "regularization"]),
    ("method", &["solver", "algorithm"]),
    ("base", &["material", "halfspace", "substrate", "body"]),
    ("material", &["base", "body"]),
    ("layers", &["coating", "coatings", "film"]),
    ("punch", &["indenter", "indentor", "body", "roughness", "wheel"]),
    ("foundation", &["halfspace", "substrate", "base", "body", "material"]),
    ("shape", &["type", "geometry", "form", "kind"]),
    ("file", &["path", "filename", "heights", "map"]),
    ("scene", &["problem", "model", "physics", "contact"]),
    ("sweep", &["sweeps", "axes", "vary", "parameters", "grid", "parametric"]),
    ("numerics", &["solver", "settings", "numeric", "discretization", "discretisation"]),
    ("figure", &["plot", "plots", "figures", "chart"]),
    ("name", &["title", "id"]),
    ("question", &["description", "comment"]),
    ("count", &["n", "num", "steps", "points"]),
    ("from", &["start", "min", "begin"]),
    ("to", &["stop", "end", "max"]),
    ("sphere", &["ball", "paraboloid", "hertz", "spherical"]),
    ("flat-rectangle", &["rectangle", "square", "box", "flat", "block"]),
    ("flat-disk", &["disk", "disc", "flatdisc", "cylinder", "circle", "flatpunch"]),
    ("height-map", &["rough", "surface", "topography", "map", "heights", "roughness"]),
    ("wheel-on-rail", &["wheel", "rail", "wheelrail"]),
];

/// Returns the candidate that was probably meant: one that ends in the word as a path segment, else
/// one that others call so, else the nearest by spelling if one is near at all.
pub(crate) fn nearest<'a>(
    word: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    if word.len() > LONGEST {
        return None;
    }
    let candidates: Vec<&str> = candidates.into_iter().collect();
    called(word, &candidates).or_else(|| spelled_like(word, &candidates))
}

/// Returns the path from the top of the key or table that has this name, or that others call so,
/// but that stands elsewhere; below `prefix` if one does.
pub(crate) fn standing_elsewhere(name: &str, prefix: &str) -> Option<String> {
    if name.len() > LONGEST {
        return None;
    }
    let known = || {
        let keys = Key::ALL.iter().map(|key| key.pattern());
        keys.chain(Table::ALL.iter().map(|table| table.pattern))
    };
    let below: Vec<&str> = known()
        .filter(|path| path.strip_prefix(prefix).is_some_and(|rest| rest.starts_with(['.', '['])))
        .collect();
    let found = called(name, &below).or_else(|| called(name, &known().collect::<Vec<_>>()))?;
    Some(found.replace("[i]", "[0]"))
}

/// Returns the path, as short as may be, of the key or table that was probably meant.
pub(crate) fn nearest_path(path: &str) -> Option<String> {
    let pattern = pattern_of(path);
    let (word, index) = pattern.as_ref().map_or((path, 0), |(pattern, index)| (pattern, *index));
    let keys = Key::ALL.iter().map(|key| short(key.pattern()));
    let known = keys.chain(Table::ALL.iter().map(|table| short(table.pattern)));
    nearest(word, known).map(|suggestion| suggestion.replace("[i]", &format!("[{index}]")))
}

/// Returns the candidate whose last segment the word is, or is another name of. What the word has
/// in front of it must be segments of the candidate. Entries of lists come last.
fn called<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let (front, name) = word.rsplit_once('.').unwrap_or(("", word));
    let is_below = |candidate: &&&str| {
        front
            .split('.')
            .filter(|segment| !segment.is_empty())
            .all(|segment| candidate.split('.').any(|other| other == segment))
    };
    let spelling = plain(name);
    let of_name = |spelling: &str| {
        let last = |candidate: &str| candidate.rsplit('.').next().map(plain);
        let ends_in_it = |candidate: &&&str| last(candidate).as_deref() == Some(spelling);
        let found = || candidates.iter().filter(ends_in_it).filter(is_below);
        found().find(|candidate| !candidate.contains('[')).or_else(|| found().next()).copied()
    };
    let others = SYNONYMS.iter().filter(|(_, others)| others.contains(&spelling.as_str()));
    if spelling.is_empty() {
        return None;
    }
    of_name(&spelling).or_else(|| others.filter_map(|(name, _)| of_name(&plain(name))).next())
}

/// Returns a name as [`SYNONYMS`] spells it.
fn plain(name: &str) -> String {
    name.chars().filter(|c| c.is_alphanumeric()).flat_map(char::to_lowercase).collect()
}

fn spelled_like<'a>(word: &str, candidates: &[&'a str]) -> Option<&'a str> {
    let near = 1 + word.chars().count() / 4;
    let word = word.to_lowercase();
    let distance = |candidate: &str| strsim::damerau_levenshtein(&word, &candidate.to_lowercase());
    candidates
        .iter()
        .map(|candidate| (distance(candidate), *candidate))
        .filter(|(distance, _)| *distance <= near)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys() -> impl Iterator<Item = &'static str> {
        Key::ALL.iter().map(|key| short(key.pattern()))
    }

    #[test]
    fn near_misses() {
        assert_eq!(nearest("mu", keys()), Some("friction.mu"));
        assert_eq!(nearest("friction.nu", keys()), Some("friction.mu"));
        assert_eq!(nearest("colour", keys()), None);
        assert_eq!(nearest("", keys()), None);
        assert_eq!(nearest(&"mu".repeat(1000), keys()), None);
        assert_eq!(
            nearest_path("loading.steps[7].aproach").as_deref(),
            Some("loading.steps[7].approach")
        );
    }

    #[test]
    fn what_others_call_a_key_is_understood() {
        for (said, meant) in [
            ("E", "foundation.base.youngs_modulus"),
            ("young", "foundation.base.youngs_modulus"),
            ("Young's modulus", "foundation.base.youngs_modulus"),
            ("foundation.base.E", "foundation.base.youngs_modulus"),
            ("foundation.E", "foundation.base.youngs_modulus"),
            ("punch.material.E", "punch.material.youngs_modulus"),
            ("foundation.layers[2].nu", "foundation.layers[2].poisson"),
            ("nu", "foundation.base.poisson"),
            ("G", "foundation.base.shear_modulus"),
            ("R", "punch.radius"),
            ("F", "loading.steps[0].normal_force"),
            ("loading.steps[1].F", "loading.steps[1].normal_force"),
            ("load", "loading.steps[0].normal_force"),
            ("force_z", "loading.steps[0].normal_force"),
            ("cof", "friction.mu"),
            ("grid", "mesh"),
        ] {
            assert_eq!(nearest_path(said).as_deref(), Some(meant), "{said}");
        }
        let step = ["approach", "normal_force", "shift_x", "force_x"];
        assert_eq!(nearest("F", step), Some("normal_force"));
        assert_eq!(nearest("Fx", step), Some("force_x"));
        assert_eq!(nearest("indentation", step), Some("approach"));
    }

    #[test]
    fn a_key_that_stands_elsewhere_is_found_below_its_table_first() {
        let found = |name: &str, prefix: &str| standing_elsewhere(name, prefix);
        assert_eq!(found("mu", "scene").as_deref(), Some("scene.friction.mu"));
        let punch = found("E", "scene.punch");
        assert_eq!(punch.as_deref(), Some("scene.punch.material.youngs_modulus"));
        assert_eq!(found("punch", "").as_deref(), Some("scene.punch"));
        assert_eq!(found("approach", "scene").as_deref(), Some("scene.loading.steps[0].approach"));
        assert_eq!(found("colour", "scene"), None);
    }

    #[test]
    fn every_synonym_is_spelled_plainly() {
        for (name, others) in SYNONYMS {
            for other in *others {
                assert_eq!(plain(other), *other, "of {name}");
            }
        }
    }
}
