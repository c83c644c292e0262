//! The numbers of a distribution, and what they must be.

use std::collections::BTreeMap;

use toml::de::DeTable;

use crate::distribution::{BoundedNormal, Distribution};
use crate::error::{Mistake, Span};
use crate::read::{self, Node};
use crate::units::Dimension;

/// The largest standard normal number that a design draws, and some more.
const FURTHEST: f64 = 8.3;

/// The numbers that stand in the table of a distribution, with their places.
pub(super) struct Numbers<'n> {
    path: &'n str,
    node: &'n Node<'n>,
    read: BTreeMap<&'static str, (f64, Span)>,
}

impl<'n> Numbers<'n> {
    pub(super) fn read(
        path: &'n str,
        dimension: Dimension,
        table: &DeTable<'_>,
        node: &'n Node<'n>,
    ) -> Result<Self, Mistake> {
        let mut read = BTreeMap::new();
        for name in ["from", "to", "mean", "deviation", "median", "mode", "log_deviation"] {
            let Some(node) = table.get(name) else { continue };
            let dimension = if name == "log_deviation" { Dimension::Pure } else { dimension };
            let number = read::number(&format!("{path}: {name}"), dimension, node)?;
            read.insert(name, (number, node.span()));
        }
        Ok(Numbers { path, node, read })
    }

    fn has(&self, name: &str) -> bool {
        self.read.contains_key(name)
    }

    pub(super) fn required(&self, name: &str) -> Result<f64, Mistake> {
        self.read.get(name).map(|(number, _)| *number).ok_or_else(|| {
            let message = format!("the distribution of `{}` has no `{name}`", self.path);
            Mistake::new(self.node.span(), message, format!("needs `{name}`"))
        })
    }

    fn or(&self, name: &str, default: f64) -> f64 {
        self.read.get(name).map_or(default, |(number, _)| *number)
    }

    /// Makes a mistake at the place of a number, or at the whole table.
    fn mistake(&self, name: &str, message: String, expected: &str) -> Mistake {
        let span = self.read.get(name).map_or(self.node.span(), |(_, span)| span.clone());
        Mistake::new(span, message, expected)
    }

    pub(super) fn require_positive(&self, name: &str) -> Result<(), Mistake> {
        match self.read.get(name) {
            Some((number, _)) if *number <= 0.0 => {
                let message = format!("`{}: {name}` cannot be {number}", self.path);
                Err(self.mistake(name, message, "must be above 0"))
            }
            _ => Ok(()),
        }
    }

    /// Returns both ends of a range.
    pub(super) fn range(&self) -> Result<[f64; 2], Mistake> {
        let (from, to) = (self.required("from")?, self.required("to")?);
        self.check_order("from", "to")?;
        Ok([from, to])
    }

    /// Refuses bounds of which the second is not above the first; bounds that are left out are no
    /// mistake.
    fn check_order(&self, lower: &str, upper: &str) -> Result<(), Mistake> {
        let (Some((from, place)), Some((to, _))) = (self.read.get(lower), self.read.get(upper))
        else {
            return Ok(());
        };
        if from < to {
            return Ok(());
        }
        let message = format!("the distribution of `{}` ends where it begins or before", self.path);
        let mistake = self.mistake(upper, message, &format!("must be above `{lower}`"));
        Err(mistake.context(place.clone(), format!("`{lower}` is here")))
    }

    pub(super) fn triangular(&self) -> Result<Distribution, Mistake> {
        let ([from, to], mode) = (self.range()?, self.required("mode")?);
        if mode < from || mode > to {
            let message = format!("the mode of `{}` lies beyond its ends", self.path);
            return Err(self.mistake("mode", message, "must be from `from` to `to`"));
        }
        if !(to - from).is_finite() {
            return Err(self.too_wide());
        }
        Ok(Distribution::Triangular { from, mode, to })
    }

    fn too_wide(&self) -> Mistake {
        let message = format!("the distribution of `{}` reaches beyond all numbers", self.path);
        Mistake::new(self.node.span(), message, "must be narrower")
    }

    pub(super) fn normal(&self) -> Result<BoundedNormal, Mistake> {
        let (mean, deviation) = (self.required("mean")?, self.required("deviation")?);
        self.require_positive("deviation")?;
        self.check_order("from", "to")?;
        let (from, to) = (self.or("from", f64::NEG_INFINITY), self.or("to", f64::INFINITY));
        self.bounded(BoundedNormal { mean, deviation, from, to })
    }

    /// Refuses a normal distribution that is empty between its bounds, or wider than doubles.
    fn bounded(&self, normal: BoundedNormal) -> Result<BoundedNormal, Mistake> {
        let reach = FURTHEST * normal.deviation;
        if !(normal.mean - reach).is_finite() || !(normal.mean + reach).is_finite() {
            return Err(self.too_wide());
        }
        if normal.share() < f64::MIN_POSITIVE {
            let message = format!("the distribution of `{}` is nothing there", self.path);
            let bound = if self.has("from") { "from" } else { "to" };
            let expected = "must leave more of the distribution than its furthest tail";
            return Err(self.mistake(bound, message, expected));
        }
        Ok(normal)
    }

    pub(super) fn log_normal(&self) -> Result<Distribution, Mistake> {
        for name in ["mean", "deviation", "median", "log_deviation", "from", "to"] {
            self.require_positive(name)?;
        }
        self.check_order("from", "to")?;
        let of_logarithm = ["median", "log_deviation"].into_iter().find(|name| self.has(name));
        let of_value = ["mean", "deviation"].into_iter().find(|name| self.has(name));
        if let (Some(name), Some(other)) = (of_logarithm, of_value) {
            let message = format!("`{}` has `{other}` and `{name}`", self.path);
            let expected = "needs mean and deviation, or median and log_deviation";
            return Err(self.mistake(name, message, expected));
        }
        let (mean, deviation) = match of_logarithm {
            Some(_) => (libm::log(self.required("median")?), self.required("log_deviation")?),
            None => {
                let (mean, deviation) = (self.required("mean")?, self.required("deviation")?);
                // The variance of the logarithm is ln(1 + (s/m)²).
                let variance = libm::log1p((deviation / mean) * (deviation / mean));
                (libm::log(mean) - 0.5 * variance, variance.sqrt())
            }
        };
        let bound =
            |name: &str, default: f64| self.read.get(name).map_or(default, |(x, _)| libm::log(*x));
        let (from, to) = (bound("from", f64::NEG_INFINITY), bound("to", f64::INFINITY));
        let normal = self.bounded(BoundedNormal { mean, deviation, from, to })?;
        let [least, most] = [-FURTHEST, FURTHEST]
            .map(|reach| libm::exp((mean + reach * deviation).clamp(from, to)));
        if deviation <= 0.0 || !most.is_finite() || least < f64::MIN_POSITIVE {
            return Err(self.too_wide());
        }
        let (from, to) = (self.or("from", 0.0), self.or("to", f64::INFINITY));
        Ok(Distribution::LogNormal { logarithm: normal, from, to })
    }
}
