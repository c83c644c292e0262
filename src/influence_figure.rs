//! The figure of the influence of each key on results: bars with whiskers, a panel for each result.

use answers::Results;
use anyhow::Result;
use report::{BarColumns, BarsSpec, Cell, DataTable, FigureError, PlotFigure};
use study::columns::find;
use study::label::label;

/// The largest number of keys that a panel shows.
const MOST_KEYS: usize = 20;

/// The longest label of a key, in characters. A longer one would be cut, and the words of its
/// column stand in its place.
const LONGEST: usize = 20;

/// Draws the influence of each key on the results along y, with a note of what is `missing`.
///
/// # Errors
/// There is nothing to draw, or too much; or the results cannot be read.
pub(crate) fn picture(
    results: &Results<'_>,
    figure: &study::Figure,
    missing: Option<&str>,
) -> Result<PlotFigure> {
    let study = results.study();
    let columns = study.columns();
    let mut notes = vec!["Whiskers are intervals of 95 %.".to_owned()];
    notes.extend(missing.map(|missing| format!("{missing}.")));
    let mut drawn: Option<PlotFigure> = None;
    for (name, table) in results.influence(figure)? {
        let result = find(&columns, &name).map_or(name.clone(), |column| label(column, &columns));
        let keys = study.sample().map_or(0, |sample| sample.axes().len());
        if table.rows().is_empty() {
            notes.push(format!("There is nothing to say of the {result}."));
            continue;
        }
        if keys > MOST_KEYS {
            notes.push(format!("Of {keys} keys the {MOST_KEYS} most influential ones are shown."));
        }
        let one = bars(&labelled(&table, results, keys)?, &result)?;
        match &mut drawn {
            Some(drawn) => drawn.panels.extend(one.panels),
            None => drawn = Some(one),
        }
    }
    let mut drawn = drawn.ok_or_else(|| FigureError::NothingToDraw {
        x: "input".to_owned(),
        y: figure.y.join(", "),
        rows: 0,
    })?;
    notes.dedup();
    drawn.notes = notes;
    drawn.title = figure.title.clone().unwrap_or_else(|| study.question().to_owned());
    Ok(drawn)
}

/// Makes the panels of one result.
fn bars(table: &DataTable, result: &str) -> Result<PlotFigure, FigureError> {
    let sobol = [
        BarColumns { label: "first order", value: "S1", ends: Some(["S1_low", "S1_high"]) },
        BarColumns { label: "total", value: "ST", ends: Some(["ST_low", "ST_high"]) },
    ];
    let morris = [
        BarColumns {
            label: "mean absolute effect μ*",
            value: "mu_star",
            ends: Some(["mu_star_low", "mu_star_high"]),
        },
        BarColumns { label: "deviation of effects σ", value: "sigma", ends: None },
    ];
    let is_sobol = table.column("S1").is_ok();
    let first = table.column("input")?;
    let panels: Vec<&str> =
        table.columns()[..first].iter().map(|column| column.name.as_str()).collect();
    let spec = BarsSpec {
        x: "input",
        bars: if is_sobol { &sobol } else { &morris },
        y_label: if is_sobol { "share of the variance" } else { "effect" },
        panels: &panels,
        ..BarsSpec::default()
    };
    let mut figure = PlotFigure::bars_from_table(table, &spec)?;
    for panel in &mut figure.panels {
        let place =
            if panel.title.is_empty() { String::new() } else { format!(", {}", panel.title) };
        panel.title = format!("{result}{place}");
        // No row of the table is a job.
        panel.series.iter_mut().for_each(|series| series.rows.clear());
    }
    Ok(figure)
}

/// Returns the rows of the most influential keys at each place, which are called as in other
/// figures.
fn labelled(table: &DataTable, results: &Results<'_>, keys: usize) -> Result<DataTable> {
    let columns = results.study().columns();
    let input = table.column("input")?;
    let named = |row: &Vec<Cell>| {
        let mut row = row.clone();
        if let Cell::Text(name) = &mut row[input]
            && let Some(column) = find(&columns, name)
        {
            let label = label(column, &columns);
            *name = match label.chars().count() {
                0..=LONGEST => label,
                _ => name.replace('_', " "),
            };
        }
        row
    };
    let rows = table.rows().chunks(keys.max(1)).flat_map(|place| place.iter().take(MOST_KEYS));
    Ok(DataTable::new(table.columns().to_vec(), rows.map(named).collect())?)
}
