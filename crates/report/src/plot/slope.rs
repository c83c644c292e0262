//! Fitted lines and the text of their slopes.

use super::canvas::{Canvas, PlotPoint};
use super::figure::PlotPanel;
use crate::axis::TICK_SIZE;
use crate::fit::Fit;
use crate::font::shorten;
use crate::number::{decade, power_of_ten};
use crate::palette::Look;
use crate::svg::{Anchor, Drawing, n};
use crate::unit::PrefixedUnit;

/// The dashes of a line fitted to the ends of a band, which tell it from the band's edge.
pub(super) const FIT_OF_BAND: &str = r#" stroke-dasharray="5 3""#;

/// A fitted line of a panel.
pub(super) struct FittedLine<'a> {
    /// True if the line belongs to a band and not to a series.
    pub(super) of_band: bool,
    /// The label of the band or the series.
    pub(super) label: &'a str,
    /// The words that tell the two lines of a band apart; empty for a series.
    pub(super) end: &'static str,
    pub(super) fit: &'a Fit,
}

/// Iterates over the fitted lines of a panel: those of its series, then those of its bands.
pub(super) fn fitted_lines(panel: &PlotPanel) -> impl Iterator<Item = FittedLine<'_>> {
    let curves = panel.series.iter().filter_map(|series| {
        let fit = series.fit.as_ref()?;
        Some(FittedLine { of_band: false, label: &series.label, end: "", fit })
    });
    let bands = panel.bands.iter().flat_map(|band| {
        let [low, high] = &band.fits;
        [(high, "upper end: "), (low, "lower end: ")].into_iter().filter_map(|(fit, end)| {
            Some(FittedLine { of_band: true, label: &band.label, end, fit: fit.as_ref()? })
        })
    });
    curves.chain(bands)
}

/// Returns the ends of a fitted line, as values.
pub(super) fn ends(fit: &Fit) -> [PlotPoint; 2] {
    [fit.from, fit.to].map(|x| (x, fit.at(x)))
}

/// Draws a fitted line over the range it was fitted on.
pub(super) fn draw(drawing: &mut Drawing, canvas: &Canvas<'_>, fit: &Fit, color: &str, dash: &str) {
    if let [Some((x1, y1)), Some((x2, y2))] = ends(fit).map(|end| canvas.place(end)) {
        drawing.push(&format!(
            r#"<line x1="{}" y1="{}" x2="{}" y2="{}" stroke="{color}" stroke-width="1"{dash}/>"#,
            n(x1),
            n(y1),
            n(x2),
            n(y2)
        ));
    }
}

/// A fitted line and the text of its slope, above one of several panels.
#[derive(Clone)]
pub(super) struct SlopeKey {
    pub(super) look: Look,
    pub(super) of_band: bool,
    pub(super) text: String,
}

impl SlopeKey {
    /// Draws the key with its left end at `x` and its baseline at `baseline`, `width` pixels wide.
    pub(super) fn draw(&self, drawing: &mut Drawing, (x, baseline): PlotPoint, width: f64) {
        const LINE: f64 = 17.0;
        const TEXT: f64 = 22.0;
        let middle = baseline - 0.36 * TICK_SIZE;
        let dash = if self.of_band { FIT_OF_BAND } else { "" };
        let color = self.look.color;
        drawing.push(&format!(
            r#"<path d="M{} {}h{LINE}" fill="none" stroke="{color}" stroke-width="1"{dash}/>"#,
            n(x),
            n(middle)
        ));
        drawing.push(&self.look.marker(x + LINE / 2.0, middle));
        let text = shorten(&self.text, width - TEXT, TICK_SIZE);
        drawing.text((x + TEXT, baseline), TICK_SIZE, Anchor::Start, &text);
    }
}

/// Writes a slope as `slope −0.97 ± 0.02`, in the units of the axes: a power on logarithmic axes,
/// otherwise a number with a unit.
pub(super) fn text(fit: &Fit, x: &PrefixedUnit, y: &PrefixedUnit) -> String {
    // On a logarithmic axis a prefix moves the line and does not turn it.
    let over = |unit: &PrefixedUnit, log: bool| if log { 1.0 } else { unit.of_si(1.0) };
    let scale = over(y, fit.log_y) / over(x, fit.log_x);
    let pure =
        |unit: &PrefixedUnit| if unit.name == "1" { String::new() } else { unit.name.clone() };
    let unit = match (fit.log_x, fit.log_y) {
        (true, true) => String::new(),
        (true, false) => format!("{} per decade", pure(y)),
        (false, true) => {
            format!("decades per {}", if pure(x).is_empty() { "1".to_owned() } else { pure(x) })
        }
        (false, false) => match (pure(y), pure(x)) {
            (y, x) if x.is_empty() => y,
            (y, x) => format!("{} per {x}", if y.is_empty() { "1" } else { &y }),
        },
    };
    format!("slope {} {}", with_error(fit.slope * scale, fit.standard_error * scale), unit.trim())
        .trim_end()
        .to_owned()
}

/// Writes a number with its error, to the first digit that is uncertain and to four digits at most.
fn with_error(x: f64, error: f64) -> String {
    // A number as small as this is a rounding error, and its power of ten has no inverse.
    let [x, error] = [x, error].map(|x| if x.abs() < 1e-290 { 0.0 } else { x });
    let largest = x.abs().max(error);
    let leading = if largest > 0.0 { decade(largest, 4) } else { 0 };
    let power = if (-3..5).contains(&leading) { 0 } else { leading };
    let (x, error) = (x / 10f64.powi(power), error / 10f64.powi(power));
    let finest = leading - power - 3;
    let last = if error > 0.0 { decade(error, 1).max(finest) } else { finest };
    let decimals = usize::try_from(-last).unwrap_or(0);
    let smallest = 10f64.powi(-(decimals as i32));
    let error = if error < 0.5 * smallest {
        format!("< {smallest:.decimals$}")
    } else {
        format!("{error:.decimals$}")
    };
    let number = format!("{x:.decimals$} ± {error}").replacen('-', "−", 1);
    if power == 0 { number } else { format!("({number})·{}", power_of_ten(power)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_end_where_the_error_begins() {
        for (x, error, text) in [
            (-0.9712, 0.0231, "−0.97 ± 0.02"),
            (-0.9712, 0.23, "−1.0 ± 0.2"),
            (2.0, 3.0, "2 ± 3"),
            (-1.0, 0.0, "−1.000 ± < 0.001"),
            (-1.0, 1e-9, "−1.000 ± < 0.001"),
            (-0.031_25, 0.000_96, "−0.031 ± 0.001"),
            (1234.6, 56.7, "1235 ± 57"),
            (2.345e9, 1.2e7, "(2.35 ± 0.01)·10⁹"),
            (-2.345e-9, 1.2e-10, "(−2.3 ± 0.1)·10⁻⁹"),
            (0.0, 0.0, "0.000 ± < 0.001"),
            (0.0, 0.02, "0.00 ± 0.02"),
            (1e-280, 2e100, "(0 ± 2)·10¹⁰⁰"),
        ] {
            assert_eq!(with_error(x, error), text, "{x} ± {error}");
        }
    }

    #[test]
    fn a_slope_has_the_units_of_its_axes() {
        let fit = |log_x, log_y| Fit {
            slope: -2e12,
            standard_error: 1e11,
            intercept: 0.0,
            from: 1.0,
            to: 2.0,
            points: 3,
            log_x,
            log_y,
        };
        let power = Fit { slope: -2.0, standard_error: 0.1, ..fit(true, true) };
        let (length, pressure, none) = (
            PrefixedUnit::fitting("m", 1e-3),
            PrefixedUnit::fitting("Pa", 1e9),
            PrefixedUnit::plain("1"),
        );
        assert_eq!(text(&power, &length, &pressure), "slope −2.0 ± 0.1");
        assert_eq!(text(&fit(false, false), &length, &pressure), "slope −2.0 ± 0.1 GPa per mm");
        assert_eq!(
            text(&Fit { slope: 3e9, standard_error: 1e8, ..fit(true, false) }, &none, &pressure),
            "slope 3.0 ± 0.1 GPa per decade"
        );
        assert_eq!(
            text(&Fit { slope: -200.0, standard_error: 10.0, ..fit(false, true) }, &length, &none),
            "slope −0.20 ± 0.01 decades per mm"
        );
        assert_eq!(
            text(&Fit { slope: -2.0, standard_error: 0.1, ..fit(false, false) }, &none, &none),
            "slope −2.0 ± 0.1"
        );
    }
}
