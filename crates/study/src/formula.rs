//! Formulas over keys, with units: `0.1 * punch.radius`, `2 mm + sqrt(radius * approach)`.
//!
//! A formula has numbers, with a unit or without, keys by their paths or the names of their
//! columns, `+ - * / ^`, parentheses, `pi`, and the functions below. A unit by itself is one of it,
//! and units that follow each other are their product, as in `1e-5 mm^3/(N m)`. A power after a
//! unit is one of the unit: `2 mm^2` are two square millimetres.
//! Dimensions are checked when the formula is read: a length and a force cannot be added, and the
//! root of a pressure times an area is that of a force. An angle counts as a pure number, as the
//! radian does. The crates for units fix dimensions when Rust is compiled, and those that evaluate
//! texts know none, so the few lines of a reader are here.
//!
//! A value is rounded to 15 significant digits, and to 13 where a function is used whose last
//! digits are not exact: `0.1 * radius` with a radius of 3 mm is the job of 0.3 mm. The functions
//! are those of `libm`, which are the same on every machine. A formula that is a key alone has its
//! value, to the last bit.

mod node;
mod reader;
mod unit_powers;

use crate::key::Key;
use crate::sheet::Sheet;
use node::FormulaNode;
pub(crate) use reader::FormulaFault;
use reader::{FormulaReader, Measured};
pub(crate) use unit_powers::UnitPowers;

/// A formula whose keys are known and whose dimensions fit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Formula {
    node: FormulaNode,
    dimension: UnitPowers,
    keys: Vec<Key>,
    /// The number of significant digits of a value; `None` if it is not rounded.
    digits: Option<usize>,
}

impl Formula {
    /// Reads a formula. `find` returns the key that a name means, or says why there is none.
    pub(crate) fn read(
        text: &str,
        find: &dyn Fn(&str) -> Result<Key, FormulaFault>,
    ) -> Result<Formula, FormulaFault> {
        if text.trim().is_empty() {
            return Err(FormulaFault::new("the formula is empty", "needs \"0.1 * punch.radius\""));
        }
        let mut reader = FormulaReader::new(text, find);
        let Measured { node, dimension } = reader.whole()?;
        let digits = match (&node, reader.is_inexact) {
            (FormulaNode::Key(_), _) => None,
            (_, true) => Some(13),
            (_, false) => Some(15),
        };
        Ok(Formula { node, dimension, keys: reader.keys, digits })
    }

    /// Returns the dimension of its values.
    pub(crate) fn dimension(&self) -> UnitPowers {
        self.dimension
    }

    /// Returns the keys that it uses.
    pub(crate) fn keys(&self) -> &[Key] {
        &self.keys
    }

    /// Returns the value for the keys of a sheet, in SI units.
    ///
    /// # Errors
    ///
    /// Returns a key that the sheet does not have, or has as something else than a number.
    pub(crate) fn value(&self, sheet: &Sheet<'_>) -> Result<f64, Key> {
        let value = self.node.value(sheet)?;
        Ok(match self.digits {
            Some(digits) => format!("{value:.*e}", digits - 1).parse().unwrap_or(value),
            None => value,
        })
    }
}

#[cfg(test)]
mod tests {
    use contact::model::Mesh;
    use proptest::prelude::*;

    use super::reader::DEEPEST;
    use super::*;
    use crate::sheet::{Given, Setting};

    fn find(name: &str) -> Result<Key, FormulaFault> {
        Key::find(name).or_else(|| Key::of_column(name)).ok_or_else(|| FormulaFault::new("", ""))
    }

    /// Returns the value of a formula where the radius is 3 mm, μ = 0.25 and the mesh has 48.
    fn value(text: &str) -> Result<f64, FormulaFault> {
        let given = |setting| Given { setting, span: 0..0, nth: None };
        let given = [
            (Key::Radius, given(Setting::Number(3e-3))),
            (Key::Mu, given(Setting::Number(0.25))),
            (Key::ShearModulus, given(Setting::Number(8e10))),
            (Key::Mesh, given(Setting::Mesh(Mesh::Across(48)))),
        ];
        let sheet = Sheet::new(given.iter().map(|(key, given)| (*key, given)));
        Formula::read(text, &find).map(|formula| formula.value(&sheet).unwrap_or(f64::NAN))
    }

    #[test]
    fn formulas_have_the_values_of_arithmetic() {
        for (text, expected) in [
            ("0.1 * punch.radius", 3e-4),
            ("2 mm + 0.1 * radius", 2.3e-3),
            ("-radius^2 * 4 / radius", -1.2e-2),
            ("2^3^2", 512.0),
            ("(1 + 2) * 3 - 4 / 2 - 1", 6.0),
            ("2 - 3 - 4", -5.0),
            ("8 / 4 / 2", 1.0),
            ("sqrt(radius * 27 mm)", 9e-3),
            ("min(radius, 1 mm, 2 mm) + max(0 m, 1 um)", 1.001e-3),
            ("abs(-mu)", 0.25),
            ("round(mesh * 0.26)", 12.0),
            ("radius / mm", 3.0),
            ("210 N/mm^2", 210e6),
            ("(radius^3)^(1/3)", 3e-3),
            ("1.5e-3 m", 1.5e-3),
            ("10 µm", 1e-5),
            ("90 deg / pi", 0.5),
            ("tan(45 deg)", 1.0),
            ("scene.foundation.base.shear_modulus * radius ^ 2 / kN", 720.0),
            ("radius", 3e-3),
            ("20 m/s", 20.0),
            ("72 km/h", 20.0),
            ("90 km / 1.25 h", 20.0),
            ("40 rad/s", 40.0),
            ("30 rpm / pi", 1.0),
            ("2 min - 60 s", 60.0),
            ("radius / (2 s)", 1.5e-3),
            ("2 N m", 2.0),
            ("3 kN mm / radius", 1e3),
            ("2 mm^2", 2e-6),
            ("(2 mm)^2", 4e-6),
            ("2 mm^2 m", 2e-6),
            ("1e-5 mm^3/(N m)", 1e-14),
            ("1e-5 mm^3/N m", 1e-14),
            ("1e-5 mm^3 / J", 1e-14),
            ("mu * mm^3/(N m)", 2.5e-10),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    /// The last digits of the functions of a platform are its own, and a key must not be.
    #[test]
    fn functions_are_those_of_one_library() {
        type Function = fn(f64) -> f64;
        let functions: [(&str, Function); 7] = [
            ("exp(mu)", libm::exp),
            ("ln(mu)", libm::log),
            ("sin(mu)", libm::sin),
            ("cos(mu)", libm::cos),
            ("tan(mu)", libm::tan),
            ("atan(mu)", libm::atan),
            ("mu^2.3", |x| libm::pow(x, 2.3)),
        ];
        for (text, function) in functions {
            let formula = Formula::read(text, &find).unwrap();
            for n in 1..2000 {
                let x = f64::from(n) * 0.007_3;
                let given = Given { setting: Setting::Number(x), span: 0..0, nth: None };
                let sheet = Sheet::new([(Key::Mu, &given)]);
                assert_eq!(formula.node.value(&sheet), Ok(function(x)), "{text} at {x}");
            }
        }
    }

    #[test]
    fn dimensions_are_known_before_values_are() {
        let noun = |text: &str| Formula::read(text, &find).map(|f| f.dimension().noun());
        for (text, expected) in [
            ("radius * radius", "an area"),
            ("shear_modulus * radius^2", "a force"),
            ("sqrt(shear_modulus / shear_modulus)", "a pure number"),
            ("radius / radius", "a pure number"),
            ("sqrt(radius)", "a quantity in m^0.5"),
            ("1 kN * radius", "a moment"),
            ("1 / radius", "a quantity in m^-1"),
            ("radius / s", "a velocity"),
            ("72 km/h", "a velocity"),
            ("40 rad/s", "an angular velocity"),
            ("3 h", "a time"),
            ("1e-5 mm^3/(N m)", "one over a pressure"),
            ("2 N m", "a moment"),
        ] {
            assert_eq!(noun(text).as_deref(), Ok(expected), "{text}");
        }
        for (text, words) in [
            ("radius + mu", "a length and a pure number cannot be added or subtracted"),
            ("max(radius, 1 kN)", "a length and a force cannot be compared"),
            ("2^radius", "an exponent is a length"),
            ("radius^mu", "a power of a length that changes"),
            ("sin(radius)", "`sin` of a length"),
            ("shape * 2", "`shape` is a text"),
            ("20 m/s + 3 s", "a velocity and a time cannot be added or subtracted"),
            ("1 mm^radius", "an exponent is a length"),
            ("(N radius)", "unexpected `radius)` at character 4"),
            ("3 hours", "`hours` after 3 is no unit"),
        ] {
            assert_eq!(noun(text).map_err(|fault| fault.message), Err(words.to_owned()), "{text}");
        }
    }

    proptest! {
        #[test]
        fn any_text_is_a_formula_or_a_fault(text in "[-+*/^().,0-9a-z \\[\\]µ]{0,40}") {
            let _ = value(&text);
        }

        #[test]
        fn nesting_ends(depth in 0usize..2000) {
            let text = format!("{}1{}", "(".repeat(depth), ")".repeat(depth));
            prop_assert_eq!(value(&text).is_ok(), depth < DEEPEST / 2);
        }
    }
}
