//! Studies around a single key: what must stand beside the key so that the study can be read.

use std::collections::BTreeMap;

use study::reference::{ReferenceKey, ReferenceTable, reference};
use study::{NamedFile, Study, StudyError};

use crate::jobs::{RAIL, WHEEL, from_store, named};

/// Reads a study whose files are those of the examples.
pub(crate) fn read(text: &str) -> Result<Study, StudyError> {
    Study::parse(text, "study.toml", &mut file)
}

fn file(name: &str) -> Result<NamedFile, String> {
    match name {
        "profiles/wheel.prw" => named(WHEEL.to_vec()),
        "profiles/rail.prr" => named(RAIL.to_vec()),
        "heights.csv" => named(b"0 1e-6\n2e-6 3e-6\n".to_vec()),
        "points.csv" => named(b"mu,radius\n0.1,1 mm\n0.2,2 mm\n".to_vec()),
        "measured.csv" => named(b"friction\n0.1\n0.2\n".to_vec()),
        _ => from_store(name),
    }
}

/// The keys of a scene and its numerics, by their paths, with their values as text.
#[derive(Clone)]
pub(crate) struct Scaffold {
    kind: &'static str,
    keys: BTreeMap<String, String>,
}

impl Scaffold {
    /// A sphere that is pressed into a half-space.
    fn sphere() -> Self {
        let keys = [
            ("scene.foundation.base.shear_modulus", "\"80 GPa\""),
            ("scene.foundation.base.poisson", "0.3"),
            ("scene.punch.shape", "\"sphere\""),
            ("scene.punch.radius", "\"10 mm\""),
            ("scene.friction.mu", "0.3"),
            ("scene.loading.steps[0].approach", "\"1 um\""),
            ("numerics.mesh", "16"),
        ];
        let own = |(path, value): (&str, &str)| (path.to_owned(), value.to_owned());
        Scaffold { kind: "solve", keys: keys.map(own).into() }
    }

    /// Returns what must stand around a key of the scene or the numerics, without the key.
    pub(crate) fn around(key: &ReferenceKey) -> Self {
        let mut scaffold = Scaffold::sphere();
        let path = key.path.replace("[i]", "[0]");
        if let Some(with) = key.shapes.first() {
            scaffold.take_shape(with.shape);
        }
        let (table, name) = path.rsplit_once('.').unwrap_or(("", &path));
        match (table, name) {
            ("scene.foundation", "base") => {
                scaffold.take("scene.foundation.base");
                scaffold.put_table("scene.foundation.layers[i]");
            }
            ("scene.foundation.layers[0]", _) => scaffold.put_table("scene.foundation.layers[i]"),
            ("scene.punch.material", _) => {
                scaffold.put("scene.punch.material.shear_modulus", "1e9");
                scaffold.put("scene.punch.material.poisson", "0.3");
            }
            ("scene.punch", "surface") => scaffold.take("scene.punch.file"),
            (
                "scene.punch",
                "speed" | "angular_speed" | "lateral_velocity" | "yaw_rate" | "roll_rate",
            ) => {
                scaffold.put("scene.punch.speed", "20");
                scaffold.put("scene.loading.steps[0].steady", "true");
            }
            ("scene.wear", _) => {
                scaffold.put("scene.wear.coefficient", "0");
                scaffold.put("scene.wear.update", "false");
                scaffold.put("scene.loading.cycle_from", "0");
            }
            ("scene.domain", _) => {
                scaffold.put("scene.domain.width_x", "1e-3");
                scaffold.put("scene.domain.width_y", "1e-3");
            }
            ("scene.loading", "steps") => scaffold.take("scene.loading.steps[0]"),
            ("scene.loading", "cycles") => scaffold.put("scene.loading.cycle_from", "0"),
            ("scene.loading.steps[0]", "normal_force") => {
                scaffold.take("scene.loading.steps[0].approach");
            }
            (
                "scene.loading.steps[0]",
                "creepage_x" | "creepage_y" | "spin" | "direction" | "dq",
            ) => scaffold.put("scene.loading.steps[0].steady", "true"),
            ("scene.loading.steps[0]", "spin_center") => {
                scaffold.put("scene.loading.steps[0].steady", "true");
                scaffold.put("scene.loading.steps[0].spin", "0.1");
            }
            ("interior", "maximum") => scaffold.put("interior.depth", "1e-3"),
            ("interior", _) => scaffold.put("interior.maximum", "true"),
            ("search", "plane") => {
                scaffold = Scaffold::of_kind("uniqueness");
                scaffold.take_shape("flat-rectangle");
                scaffold.put("numerics.mesh", "[3, 1]");
            }
            ("search", "cases") => {
                scaffold = Scaffold::of_kind("uniqueness");
                scaffold.put("numerics.mesh", "3");
            }
            ("search", "width") => {
                scaffold = Scaffold::of_kind("uniqueness");
                scaffold.put("numerics.mesh", "3");
                scaffold.put("search.cases", "true");
            }
            ("search", _) => scaffold.kind = "multiplicity",
            _ => {}
        }
        // Each of the two moduli stands in the place of the other.
        match name {
            "youngs_modulus" => scaffold.take(&format!("{table}.shear_modulus")),
            "shear_modulus" => scaffold.take(&format!("{table}.youngs_modulus")),
            _ => {}
        }
        scaffold.take(&path);
        scaffold
    }

    /// Returns the study without the axes of anything, of another kind.
    pub(crate) fn of_kind(kind: &'static str) -> Self {
        let mut scaffold = Scaffold { kind, ..Scaffold::sphere() };
        if kind == "uniqueness" {
            for table in ["scene.loading", "scene.friction"] {
                scaffold.take(table);
            }
            scaffold.take_shape("flat-disk");
        }
        scaffold
    }

    /// Returns what must stand around a key of another table.
    pub(crate) fn beside(table: &str, name: &str) -> Self {
        let mut scaffold = Scaffold::sphere();
        match (table, name) {
            ("accuracy", _) | ("", "accuracy") => scaffold.take("numerics.mesh"),
            ("branch", _) => {
                scaffold = Scaffold::of_kind("uniqueness");
                scaffold.put("numerics.mesh", "3");
            }
            ("refine", _) => scaffold.put("numerics.mesh", "1"),
            ("derive", _) => scaffold.put("scene.loading.steps[0].shift_x", "0"),
            ("convergence" | "cost" | "sensitivity", _) => {
                scaffold.kind = match table {
                    "convergence" => "convergence",
                    "cost" => "cost",
                    _ => "sensitivity",
                };
            }
            _ => {}
        }
        scaffold
    }

    fn take_shape(&mut self, shape: &str) {
        self.take("scene.punch");
        self.put("scene.punch.shape", &format!("\"{shape}\""));
        for table in reference() {
            for key in table.keys {
                let is_of_shape = key.shapes.iter().any(|with| with.shape == shape);
                let is_needed = key.shapes.iter().any(|with| with.shape == shape && with.is_needed);
                if is_of_shape && is_needed {
                    self.put(&key.path, key.example);
                }
            }
        }
    }

    /// Puts what a table needs.
    fn put_table(&mut self, path: &str) {
        for table in reference().into_iter().filter(|table| table.path == path) {
            for key in table.keys.iter().filter(|key| key.name != "shear_modulus") {
                self.put(&key.path.replace("[i]", "[0]"), key.example);
            }
        }
    }

    fn put(&mut self, path: &str, value: &str) {
        self.keys.insert(path.to_owned(), value.to_owned());
    }

    /// Takes a key away, or all that a table holds.
    pub(crate) fn take(&mut self, path: &str) {
        let below = [format!("{path}."), format!("{path}[")];
        let is_meant = |key: &str| key == path || below.iter().any(|below| key.starts_with(below));
        self.keys.retain(|key, _| !is_meant(key));
    }

    /// Returns the text of the study with a key.
    pub(crate) fn with(&self, path: &str, value: &str) -> String {
        let mut scaffold = self.clone();
        scaffold.put(&path.replace("[i]", "[0]"), value);
        scaffold.text()
    }

    /// Returns the text of the study.
    pub(crate) fn text(&self) -> String {
        let mut text = format!("kind = \"{}\"\n", self.kind);
        let mut entries: BTreeMap<&str, Vec<String>> = BTreeMap::new();
        for (path, value) in &self.keys {
            match path.split_once("[0].") {
                Some((list, name)) => {
                    entries.entry(list).or_default().push(format!("{name} = {value}"));
                }
                None => text += &format!("{path} = {value}\n"),
            }
        }
        // A list whose only entry says nothing is there all the same.
        for (list, entry) in entries {
            text += &format!("{list} = [{{ {} }}]\n", entry.join(", "));
        }
        format!("name = \"study\"\n{text}")
    }
}

/// Returns the keys of the scene and the numerics, or those of the tables beside them.
pub(crate) fn keys_of(is_scene: bool) -> Vec<(ReferenceTable, ReferenceKey)> {
    let of = |table: ReferenceTable| {
        let keys = table.keys.clone();
        keys.into_iter().map(move |key| (table.clone(), key))
    };
    let all = reference().into_iter().flat_map(of);
    all.filter(|(_, key)| key.column.is_some() == is_scene).collect()
}
