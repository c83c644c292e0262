//! Every key of a scene and of its numerics: where it stands in a study file, what it measures and the column it
//! fills. The one list; the reader, the axes, the columns and the messages all go by it.

use crate::units::Dimension;

/// What may stand behind a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// A number in SI units, or a text with a unit.
    Number(Dimension),
    /// A whole number, 0 or above.
    Count,
    /// A whole number of elements or a pair of them.
    Mesh,
    /// One of these words.
    Choice(&'static [&'static str]),
    /// Any text.
    Text,
    /// A unit of length.
    LengthUnit,
}

impl Quantity {
    /// What would be right, for messages: `a pressure, for example "1 MPa", or a number in Pa`.
    pub fn expected(self) -> String {
        match self {
            Quantity::Number(Dimension::Pure) => "a number".to_owned(),
            Quantity::Number(dimension) => {
                let example = match dimension {
                    Dimension::Length => "0.5 mm",
                    Dimension::Angle => "5 deg",
                    Dimension::Pressure => "80 GPa",
                    Dimension::Force => "1 kN",
                    _ => return format!("a number in {}", dimension.unit()),
                };
                format!("{} like \"{example}\" or a number in {}", dimension.noun(), dimension.unit())
            }
            Quantity::Count => "a whole number".to_owned(),
            Quantity::Mesh => "a whole number of elements like 64, or a pair like [64, 32]".to_owned(),
            Quantity::Choice(words) => match words {
                [only] => format!("\"{only}\""),
                _ => format!("one of {}", quoted(words)),
            },
            Quantity::Text => "a text".to_owned(),
            Quantity::LengthUnit => {
                format!("a unit of length: {}", quoted(&Dimension::Length.units().collect::<Vec<_>>()))
            }
        }
    }
}

fn quoted(words: &[&str]) -> String {
    words.iter().map(|word| format!("\"{word}\"")).collect::<Vec<_>>().join(", ")
}

macro_rules! keys {
    ($($name:ident, $path:literal, $column:literal, $quantity:expr, $meaning:literal;)*) => {
        /// A key of a scene or of its numerics.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Key {
            $(#[doc = $meaning] $name,)*
        }

        impl Key {
            /// Every key, in the order of the scene's and the numerics' fields.
            pub const ALL: &'static [Key] = &[$(Key::$name),*];
            /// How many keys there are.
            pub const COUNT: usize = Key::ALL.len();

            /// Where it stands in a study file, from the top: `scene.friction.mu`.
            pub fn path(self) -> &'static str {
                match self { $(Key::$name => $path,)* }
            }

            /// The column it fills; an identifier, unique among all columns.
            pub fn column(self) -> &'static str {
                match self { $(Key::$name => $column,)* }
            }

            /// What may stand behind it.
            pub fn quantity(self) -> Quantity {
                match self { $(Key::$name => $quantity,)* }
            }

            /// What it means, in words.
            pub fn meaning(self) -> &'static str {
                match self { $(Key::$name => $meaning,)* }
            }
        }
    };
}

use Dimension::{Angle, Length, Pressure, Pure};
use Quantity::{Choice, Count, LengthUnit, Number, Text};

keys! {
    ShearModulus, "scene.foundation.base.shear_modulus", "shear_modulus", Number(Pressure), "shear modulus G of the foundation";
    Poisson, "scene.foundation.base.poisson", "poisson", Number(Pure), "Poisson's ratio ν of the foundation";
    Shape, "scene.punch.shape", "shape", Choice(&["sphere", "ellipsoid", "flat-rectangle", "flat-disk", "cone", "height-map"]), "shape of the punch";
    Radius, "scene.punch.radius", "radius", Number(Length), "radius of a sphere or a flat disk";
    RadiusX, "scene.punch.radius_x", "radius_x", Number(Length), "radius of curvature of an ellipsoid in the x–z plane";
    RadiusY, "scene.punch.radius_y", "radius_y", Number(Length), "radius of curvature of an ellipsoid in the y–z plane";
    WidthX, "scene.punch.width_x", "width_x", Number(Length), "extent of the punch along x";
    WidthY, "scene.punch.width_y", "width_y", Number(Length), "extent of the punch along y";
    ConeAngle, "scene.punch.angle", "angle", Number(Angle), "angle between a cone and the plane of contact";
    File, "scene.punch.file", "file", Text, "file with the heights of a height map: NPY or a matrix of text";
    HeightUnit, "scene.punch.unit", "unit", LengthUnit, "unit of the heights in the file, m unless given";
    Surface, "scene.punch.surface", "surface", Text, "name of a stored surface, the hash of its heights";
    PunchShearModulus, "scene.punch.material.shear_modulus", "punch_shear_modulus", Number(Pressure), "shear modulus G of an elastic punch";
    PunchPoisson, "scene.punch.material.poisson", "punch_poisson", Number(Pure), "Poisson's ratio ν of an elastic punch";
    Mu, "scene.friction.mu", "mu", Number(Pure), "coefficient of friction μ";
    DomainWidthX, "scene.domain.width_x", "domain_width_x", Number(Length), "extent of Ω along x";
    DomainWidthY, "scene.domain.width_y", "domain_width_y", Number(Length), "extent of Ω along y";
    DomainCenterX, "scene.domain.center_x", "domain_center_x", Number(Length), "x of the centre of Ω";
    DomainCenterY, "scene.domain.center_y", "domain_center_y", Number(Length), "y of the centre of Ω";
    Approach, "scene.loading.steps[0].approach", "approach", Number(Length), "approach δ of the punch, positive into the foundation";
    ShiftX, "scene.loading.steps[0].shift_x", "shift_x", Number(Length), "shift of the punch along x";
    ShiftY, "scene.loading.steps[0].shift_y", "shift_y", Number(Length), "shift of the punch along y";
    TiltX, "scene.loading.steps[0].tilt_x", "tilt_x", Number(Angle), "tilt of the punch about the x axis";
    TiltY, "scene.loading.steps[0].tilt_y", "tilt_y", Number(Angle), "tilt of the punch about the y axis";
    Twist, "scene.loading.steps[0].twist", "twist", Number(Angle), "twist of the punch about the z axis";
    Mesh, "numerics.mesh", "mesh", Quantity::Mesh, "elements across Ω";
    Projection, "numerics.projection", "projection", Choice(&["average", "midpoint"]), "how the continuous operator becomes a matrix";
    Epsilon, "numerics.epsilon", "epsilon", Number(Pure), "regularisation ε of equation (3)";
    Ceiling, "numerics.ceiling", "ceiling", Number(Pressure), "a-priori ceiling u on the pressure in equation (3)";
    Method, "numerics.method", "method", Choice(&["seidel"]), "solver";
    Tolerance, "numerics.tolerance", "tolerance", Number(Pure), "largest relative residual that counts as solved";
    MaxIterations, "numerics.max_iterations", "max_iterations", Count, "iterations after which the solver gives up";
}

impl Key {
    /// The path without `scene.` or `numerics.`, as axes and messages write it.
    pub fn short(self) -> &'static str {
        short(self.path())
    }

    /// The last segment of the path.
    pub fn name(self) -> &'static str {
        self.path().rsplit('.').next().unwrap_or_default()
    }

    /// The key with this path, short or from the top.
    pub fn find(path: &str) -> Option<Key> {
        Key::ALL.iter().copied().find(|key| key.path() == path || key.short() == path)
    }

    /// Whether the key stands inside the table.
    pub fn is_under(self, table: &Table) -> bool {
        self.path().strip_prefix(table.path).is_some_and(|rest| rest.starts_with('.'))
    }
}

/// A table of a study file whose keys are [`Key`]s; an axis may replace it as a whole.
#[derive(Debug, PartialEq, Eq)]
pub struct Table {
    /// Where it stands, from the top.
    pub path: &'static str,
    /// The column that an axis over it fills.
    pub column: &'static str,
}

/// Every such table, outer ones first.
pub const TABLES: &[Table] = &[
    Table { path: "scene", column: "scene" },
    Table { path: "scene.foundation", column: "foundation" },
    Table { path: "scene.foundation.base", column: "base" },
    Table { path: "scene.punch", column: "punch" },
    Table { path: "scene.punch.material", column: "punch_material" },
    Table { path: "scene.friction", column: "friction" },
    Table { path: "scene.domain", column: "domain" },
    Table { path: "scene.loading", column: "loading" },
    Table { path: "scene.loading.steps[0]", column: "step" },
    Table { path: "numerics", column: "numerics" },
];

impl Table {
    /// The path without `scene.`, as axes and messages write it.
    pub fn short(&self) -> &'static str {
        short(self.path)
    }

    /// The table with this path, short or from the top.
    pub fn find(path: &str) -> Option<&'static Table> {
        TABLES.iter().find(|table| table.path == path || table.short() == path)
    }

    /// The names that may stand directly in it.
    pub fn names(&self) -> Vec<&'static str> {
        let mut names = Vec::new();
        for key in Key::ALL.iter().filter(|key| key.is_under(self)) {
            let inner = key.path().get(self.path.len() + 1..).unwrap_or_default();
            let name = inner.split(['.', '[']).next().unwrap_or_default();
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

fn short(path: &'static str) -> &'static str {
    path.strip_prefix("scene.").or_else(|| path.strip_prefix("numerics.")).unwrap_or(path)
}

/// The candidate that was probably meant: one that ends in the word as a path segment, else the nearest by spelling
/// if it is near at all.
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let candidates: Vec<&str> = candidates.into_iter().collect();
    let ends_in_it = |candidate: &&&str| candidate.rsplit('.').next() == Some(word);
    if let Some(candidate) = candidates.iter().find(ends_in_it) {
        return Some(candidate);
    }
    let near = 1 + word.chars().count() / 4;
    candidates
        .into_iter()
        .map(|candidate| (strsim::damerau_levenshtein(&word.to_lowercase(), &candidate.to_lowercase()), candidate))
        .filter(|(distance, _)| *distance <= near)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_and_columns_are_unique() {
        let mut seen = std::collections::HashSet::new();
        for key in Key::ALL {
            assert!(seen.insert(key.path()) && seen.insert(key.short()), "{key:?}");
            assert_eq!(Key::find(key.path()), Some(*key));
            assert_eq!(Key::find(key.short()), Some(*key));
        }
        let mut columns = std::collections::HashSet::new();
        let names = Key::ALL.iter().map(|key| key.column()).chain(TABLES.iter().map(|table| table.column));
        for name in names {
            assert!(columns.insert(name), "{name}");
        }
    }

    #[test]
    fn every_table_holds_keys() {
        for table in TABLES {
            assert!(!table.names().is_empty(), "{table:?}");
        }
        assert_eq!(Table::find("loading").map(Table::names), Some(vec!["steps"]));
        assert_eq!(Table::find("loading.steps[0]").map(|t| t.names().len()), Some(6));
    }

    #[test]
    fn near_misses() {
        let keys = || Key::ALL.iter().map(|key| key.short());
        assert_eq!(nearest("mu", keys()), Some("friction.mu"));
        assert_eq!(nearest("friction.nu", keys()), Some("friction.mu"));
        assert_eq!(nearest("colour", keys()), None);
        assert_eq!(nearest("", keys()), None);
    }
}
