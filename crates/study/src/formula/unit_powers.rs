//! The units of a formula's parts, as powers of SI units.

use crate::units::Dimension;

/// The powers of a metre, a newton and a second in a unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct UnitPowers {
    metre: f64,
    newton: f64,
    second: f64,
}

impl UnitPowers {
    /// The powers of a pure number.
    pub(super) const PURE: UnitPowers = UnitPowers { metre: 0.0, newton: 0.0, second: 0.0 };

    /// Returns the powers in the SI unit of a dimension.
    pub(crate) fn of(dimension: Dimension) -> UnitPowers {
        let [metre, newton, second] = match dimension {
            Dimension::Pure | Dimension::Angle => [0.0, 0.0, 0.0],
            Dimension::Length => [1.0, 0.0, 0.0],
            Dimension::Area => [2.0, 0.0, 0.0],
            Dimension::Volume => [3.0, 0.0, 0.0],
            Dimension::Pressure => [-2.0, 1.0, 0.0],
            Dimension::PerPressure => [2.0, -1.0, 0.0],
            Dimension::Force | Dimension::EnergyPerLength => [0.0, 1.0, 0.0],
            Dimension::AnglePerLength => [-1.0, 0.0, 0.0],
            Dimension::Moment | Dimension::Energy => [1.0, 1.0, 0.0],
            Dimension::Time => [0.0, 0.0, 1.0],
            Dimension::Velocity => [1.0, 0.0, -1.0],
            Dimension::AngularVelocity => [0.0, 0.0, -1.0],
        };
        UnitPowers { metre, newton, second }
    }

    /// Returns whether two units measure the same. Powers are quotients of small whole numbers.
    pub(crate) fn fits(self, other: UnitPowers) -> bool {
        let pairs =
            [(self.metre, other.metre), (self.newton, other.newton), (self.second, other.second)];
        pairs.iter().all(|(power, other)| (power - other).abs() < 1e-9)
    }

    /// Returns whether it is the unit of a pure number.
    pub(super) fn is_pure(self) -> bool {
        self.fits(Self::PURE)
    }

    /// Returns the powers of a product with the `count`-th power of another unit.
    pub(super) fn times(self, other: UnitPowers, count: f64) -> UnitPowers {
        UnitPowers {
            metre: self.metre + count * other.metre,
            newton: self.newton + count * other.newton,
            second: self.second + count * other.second,
        }
    }

    /// Returns the name with its article, for messages.
    pub(crate) fn noun(self) -> String {
        let named = [
            Dimension::Pure,
            Dimension::Length,
            Dimension::Area,
            Dimension::Pressure,
            Dimension::Force,
            Dimension::Moment,
            Dimension::PerPressure,
            Dimension::Velocity,
            Dimension::AngularVelocity,
            Dimension::Time,
        ];
        if let Some(dimension) = named.into_iter().find(|known| self.fits(Self::of(*known))) {
            return dimension.noun().to_owned();
        }
        let power = |(symbol, count): (&str, f64)| {
            let count = (count * 1e6).round() / 1e6;
            match count {
                0.0 => None,
                1.0 => Some(symbol.to_owned()),
                count => Some(format!("{symbol}^{count}")),
            }
        };
        let powers = [("N", self.newton), ("m", self.metre), ("s", self.second)]
            .into_iter()
            .filter_map(power);
        format!("a quantity in {}", powers.collect::<Vec<_>>().join(" "))
    }
}
