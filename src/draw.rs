//! Figures and fields as files: `plot`, and the fields of `show` and `solve`.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use contact::outcome::Fields;
use report::{Field, Figure, FigureSpec, Grid, Table, TerminalInk, Values, field_csv, vti};
use store::Store;

use crate::cli::PlotArgs;
use crate::output::{self, Finish};
use crate::query::tell_origin;
use crate::results::{Results, stored_study};

/// Dots per inch of PNG files.
const RESOLUTION: f64 = 300.0;

/// The two files of a figure whose name has no ending yet.
pub(crate) fn figure_files(stem: &Path) -> Vec<PathBuf> {
    ["svg", "png"].map(|ending| PathBuf::from(format!("{}.{ending}", stem.display()))).to_vec()
}

/// Draws a table's columns to files that end in .svg or .png.
pub(crate) fn write_figure(table: &Table, columns: &study::Figure, title: &str, files: &[PathBuf]) -> Result<()> {
    let series: Vec<&str> = columns.series.iter().map(String::as_str).collect();
    let spec = FigureSpec {
        x: &columns.x,
        y: &columns.y,
        series: &series,
        panels: columns.panels.as_deref(),
        along: columns.steps.then_some("increment"),
        title,
        log_x: columns.log_x,
        log_y: columns.log_y,
    };
    let svg = Figure::from_table(table, &spec)?.svg();
    for file in files {
        match file.extension().and_then(OsStr::to_str) {
            Some("svg") => write(file, svg.as_bytes())?,
            Some("png") => write(file, &report::png(&svg, RESOLUTION)?)?,
            _ => bail!("{}: a figure is written as .svg or .png", file.display()),
        }
    }
    Ok(())
}

fn write(file: &Path, bytes: &[u8]) -> Result<()> {
    std::fs::write(file, bytes).with_context(|| format!("cannot write {}", file.display()))
}

pub(crate) fn plot(args: &PlotArgs) -> Result<Finish> {
    let reader = Store::read(&args.store.store)?;
    tell_origin(&reader);
    let results = Results::read(&reader, stored_study(&reader, &args.name)?)?;
    let asked = args.x.is_some() || args.y.is_some();
    let own = results.study.figure();
    let column = |asked: &Option<String>, own: Option<&String>| asked.as_ref().or(own).cloned();
    let (Some(x), Some(y)) = (column(&args.x, own.map(|figure| &figure.x)), column(&args.y, own.map(|figure| &figure.y))) else {
        bail!("the study suggests no figure; name its columns with --x and --y (`tribosweep query {} --columns` lists them)", args.name);
    };
    let series = args.series.clone().or_else(|| own.map(|figure| figure.series.clone())).unwrap_or_default();
    let panels = column(&args.panels, own.and_then(|figure| figure.panels.as_ref()));
    let figure = study::Figure {
        // a column cannot be drawn along x and tell the curves apart at once
        series: series.into_iter().filter(|name| *name != x).collect(),
        panels: panels.filter(|name| *name != x),
        // who asks for another abscissa asks for another figure
        steps: args.steps || args.x.is_none() && own.is_some_and(|figure| figure.steps),
        log_x: args.log_x || own.is_some_and(|figure| figure.log_x),
        log_y: args.log_y || own.is_some_and(|figure| figure.log_y),
        x,
        y,
    };
    let mut table = results.figure_table(figure.steps)?;
    if let Some(expression) = &args.filter {
        table = table.filter(expression)?;
    }
    let title = if asked { results.study.name() } else { results.study.question() };
    let files = args.output.clone().map_or_else(|| figure_files(Path::new(results.study.name())), |file| vec![file]);
    write_figure(&table, &figure, title, &files)?;
    if args.json {
        return output::print_json(&files);
    }
    output::print(&files.iter().map(|file| format!("{}\n", file.display())).collect::<String>())
}

/// The fields by name.
const FIELDS: [&str; 8] = ["pressure", "traction_x", "traction_y", "traction", "gap", "slip_x", "slip_y", "state"];

/// One of the fields of a result; masked elements have no value.
pub(crate) fn field(fields: &Fields, name: &str) -> Result<Field> {
    let [nx, ny] = fields.shape.map(|n| n as usize);
    let corner = [0, 1].map(|c| fields.origin[c] - 0.5 * fields.element[c]);
    let grid = Grid { nx, ny, origin: corner, element: fields.element };
    let on_sole = |values: &[f64]| -> Values {
        Values::Number(values.iter().zip(&fields.state).map(|(value, state)| if *state == 0 { f64::NAN } else { *value }).collect())
    };
    let traction: Vec<f64>;
    let (unit, values) = match name {
        "pressure" => ("Pa", on_sole(&fields.pressure)),
        "traction_x" => ("Pa", on_sole(&fields.traction_x)),
        "traction_y" => ("Pa", on_sole(&fields.traction_y)),
        "traction" => {
            traction = fields.traction_x.iter().zip(&fields.traction_y).map(|(x, y)| x.hypot(*y)).collect();
            ("Pa", on_sole(&traction))
        }
        "gap" => ("m", on_sole(&fields.gap)),
        "slip_x" => ("m", on_sole(&fields.slip_x)),
        "slip_y" => ("m", on_sole(&fields.slip_y)),
        "state" => {
            let names = ["outside", "open", "stick", "slip"].map(str::to_owned).to_vec();
            ("", Values::Category { of: fields.state.clone(), names })
        }
        other => bail!("there is no field `{other}`; there are {}", FIELDS.join(", ")),
    };
    Ok(Field::new(name, unit, grid, values)?)
}

/// Draws a field on standard output or writes it to a file by its ending.
pub(crate) fn show_field(fields: &Fields, name: &str, file: Option<&Path>) -> Result<Finish> {
    let field = field(fields, name)?;
    let Some(file) = file else {
        let ink =
            if std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none() { TerminalInk::Color } else { TerminalInk::Ascii };
        return output::print(&field.terminal(output::terminal_width().unwrap_or(80), ink));
    };
    let bytes = match file.extension().and_then(OsStr::to_str) {
        Some("png") => report::png(&field.svg(), RESOLUTION)?,
        Some("svg") => field.svg().into_bytes(),
        Some("npy") => field.npy()?,
        Some("vti") => vti(&[&field])?.into_bytes(),
        Some("csv") => field_csv(&[&field])?.into_bytes(),
        _ => bail!("{}: a field is written as .png, .svg, .npy, .vti or .csv", file.display()),
    };
    write(file, &bytes)?;
    output::print(&format!("{}\n", file.display()))
}
