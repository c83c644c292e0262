//! Histograms: rows counted by the value of a column.

use super::error::{FigureError, MOST_SERIES};
use super::figure::{PlotAxis, PlotFigure, PlotPanel, Series, Style};
use super::groups::{Groups, numbers, text_in};
use super::spec::FigureSpec;
use crate::axis::drawable;
use crate::table::DataTable;

/// The largest number of bins that are chosen.
const MOST_BINS: usize = 100;

/// Makes a histogram of a column. All panels and series have the same bins, which are `bins` if
/// that is given and else as wide as Freedman and Diaconis (1981, doi:10.1007/BF01025868)
/// recommend. With `share`, bars are parts of the rows of their series in their panel.
///
/// # Errors
/// [`FigureError`], which says what cannot be drawn and what to choose instead.
pub(super) fn figure(
    table: &DataTable,
    spec: &FigureSpec<'_>,
    bins: Option<usize>,
    share: bool,
) -> Result<PlotFigure, FigureError> {
    let column = table.column(spec.x)?;
    let panel_column = spec.panels.map(|name| table.column(name)).transpose()?;
    let series_columns =
        spec.series.iter().map(|name| table.column(name)).collect::<Result<Vec<_>, _>>()?;
    if let Some(example) = text_in(table, column) {
        let why = format!("which has text, such as {example:?}");
        return Err(FigureError::NotAlong { what: "a histogram", x: spec.x.to_owned(), why });
    }
    let panels = Groups::panels(table, spec, panel_column)?;
    let series = Groups::new(table, &series_columns);
    if series.labels.len() > MOST_SERIES {
        let (columns, count) = (spec.series.join(", "), series.labels.len());
        return Err(FigureError::TooManySeries { columns, count });
    }
    let values = numbers(table, column);
    let drawn = || values.iter().copied().filter(|x| x.is_finite());
    if drawn().next().is_none() {
        return Err(FigureError::NothingToCount { column: spec.x.to_owned(), rows: values.len() });
    }
    let edges = edges(drawn().filter(|x| drawable(*x, spec.log_x)).collect(), bins, spec.log_x);
    if edges.is_empty() {
        return Err(FigureError::NothingPositive { column: spec.x.to_owned() });
    }
    let unit = table.columns()[column].unit.clone();
    let made = (0..panels.labels.len()).map(|panel| {
        let bars = |group: usize| {
            let belongs =
                |row: &usize| panels.of_row[*row] == panel && series.of_row[*row] == group;
            let rows: Vec<f64> = (0..values.len())
                .filter(belongs)
                .map(|row| values[row])
                .filter(|x| drawable(*x, spec.log_x))
                .collect();
            let whole = if share { rows.len() as f64 } else { 1.0 };
            (!rows.is_empty()).then(|| Series {
                label: series.labels[group].clone(),
                points: outline(&edges, &rows, whole),
                style: Style::Bars,
                ..Series::default()
            })
        };
        PlotPanel {
            title: panels.panel_title(panel, table, spec, panel_column),
            x: PlotAxis {
                label: spec.label(spec.x),
                unit: unit.clone(),
                log: spec.log_x,
                ..PlotAxis::default()
            },
            y: PlotAxis {
                label: if share { "share of the points" } else { "points" }.to_owned(),
                from_zero: true,
                ..PlotAxis::default()
            },
            series: (0..series.labels.len()).filter_map(bars).collect(),
            ..PlotPanel::default()
        }
    });
    let legend = spec.series.iter().map(|name| spec.label(name)).collect::<Vec<_>>().join(", ");
    let mut notes: Vec<String> = spec.notes.iter().map(|note| (*note).to_owned()).collect();
    let left_out = drawn().filter(|x| !drawable(*x, spec.log_x)).count();
    if left_out > 0 {
        let are = if left_out == 1 { "value is" } else { "values are" };
        notes.push(format!("{left_out} {are} not counted: not positive on a logarithmic axis."));
    }
    Ok(PlotFigure { title: spec.title.to_owned(), legend, notes, panels: made.collect() })
}

/// Returns the edges of bins that hold some values, or their logarithms if the axis has these; none
/// without values.
fn edges(mut values: Vec<f64>, bins: Option<usize>, log: bool) -> Vec<f64> {
    if log {
        values.iter_mut().for_each(|x| *x = x.ln());
    }
    values.sort_by(f64::total_cmp);
    let (Some(least), Some(most)) = (values.first().copied(), values.last().copied()) else {
        return Vec::new();
    };
    let back = |x: f64| if log { x.exp() } else { x };
    if most - least <= 1e-12 * most.abs().max(least.abs()) {
        // All values are one, in the middle of the only bin.
        let half = if least == 0.0 || log { 0.5 } else { 0.05 * least.abs() };
        return vec![back(least - half), back(most + half)];
    }
    let count = bins.unwrap_or_else(|| recommended(&values));
    let edge = |i: usize| match i {
        0 => least,
        i if i == count => most,
        i => least + (most - least) * (i as f64 / count as f64),
    };
    (0..=count).map(|i| back(edge(i))).collect()
}

/// Returns the number of bins of Freedman and Diaconis for sorted values that are not all the same;
/// that of Sturges (1926, doi:10.1080/01621459.1926.10502161) if half of them are the same.
fn recommended(values: &[f64]) -> usize {
    let n = values.len() as f64;
    let quartile = |part: f64| values[((n - 1.0) * part).round() as usize];
    let width = 2.0 * (quartile(0.75) - quartile(0.25)) / n.cbrt();
    let range = values[values.len() - 1] - values[0];
    let count = if width > 0.0 { (range / width).ceil() } else { n.log2().ceil() + 1.0 };
    (count as usize).clamp(1, MOST_BINS)
}

/// Returns the outline of the bars: from the foot of the first one along their tops to the foot of
/// the last one. Each bin has its lower edge, and the last one its upper edge as well.
fn outline(edges: &[f64], values: &[f64], whole: f64) -> Vec<(f64, f64)> {
    let mut counts = vec![0_usize; edges.len() - 1];
    let last = counts.len() - 1;
    for x in values {
        counts[edges[1..].partition_point(|edge| edge <= x).min(last)] += 1;
    }
    let mut outline = vec![(edges[0], 0.0)];
    for (bin, count) in counts.iter().enumerate() {
        let height = *count as f64 / whole;
        outline.extend([(edges[bin], height), (edges[bin + 1], height)]);
    }
    outline.push((edges[edges.len() - 1], 0.0));
    outline
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_have_the_recommended_width() {
        // Quartiles at 250 and 749 of 1000 equal steps: 2·499/10 = 99.8 is the width.
        let values: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(recommended(&values), 11);
        assert_eq!(edges(values.clone(), Some(3), false), [0.0, 333.0, 666.0, 999.0]);
        // Half of the values are one: Sturges' rule.
        let mut heaped = vec![5.0; 60];
        heaped.extend([0.0, 1.0, 9.0, 10.0]);
        heaped.sort_by(f64::total_cmp);
        assert_eq!(recommended(&heaped), 7);
        let decades = edges(vec![1.0, 10.0, 100.0], Some(2), true);
        assert!((decades[1] - 10.0).abs() < 1e-12, "{decades:?}");
        assert_eq!(edges(vec![2.0, 2.0], None, false), [1.9, 2.1]);
        assert_eq!(edges(vec![0.0], None, false), [-0.5, 0.5]);
    }

    #[test]
    fn every_value_is_counted_once() {
        let edges = [0.0, 1.0, 2.0];
        let values = [0.0, 0.5, 1.0, 1.5, 2.0];
        let expected = [(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 3.0), (2.0, 3.0), (2.0, 0.0)];
        assert_eq!(outline(&edges, &values, 1.0), expected);
        assert_eq!(outline(&edges, &values, 5.0)[1].1, 0.4);
    }
}
