//! The fields of a result, drawn on the terminal or written to files.

use std::ffi::OsStr;
use std::io::IsTerminal;
use std::path::Path;

use anyhow::{Result, bail};
use contact::model::Fields;
use contact::multiplicity::Multiplicity;
use report::{Field, FieldGrid, TerminalInk, Values, field_csv, vti};

use crate::figures::RESOLUTION;
use crate::output::{self, Finish};
use crate::written_file;

/// The names of the fields that every scene has.
const FIELDS: [&str; 9] = [
    "pressure",
    "traction_x",
    "traction_y",
    "traction",
    "gap",
    "slip_x",
    "slip_y",
    "friction_work",
    "state",
];

/// The field of scenes that wear.
const WEAR_DEPTH: &str = "wear_depth";

/// The endings of files that hold one field.
const SINGLE: [&str; 3] = ["png", "svg", "npy"];

/// The endings of files that hold one field or all.
const SEVERAL: [&str; 3] = ["vti", "csv", SERIES];

/// The ending of a series over all increments.
const SERIES: &str = "pvd";

fn ending(file: &Path) -> Option<&str> {
    file.extension().and_then(OsStr::to_str)
}

/// Returns whether a file is a series over all increments.
pub(crate) fn is_series(file: Option<&Path>) -> bool {
    file.and_then(ending) == Some(SERIES)
}

/// Checks the field's name and the file's extension and its place before anything is computed.
pub(crate) fn check_field(name: Option<&str>, file: Option<&Path>) -> Result<()> {
    let mut known = FIELDS.to_vec();
    known.push(WEAR_DEPTH);
    check_among(&known, name, file)
}

/// Checks a field's name, which is one of those `known`, and the file's extension and its place.
pub(crate) fn check_among(known: &[&str], name: Option<&str>, file: Option<&Path>) -> Result<()> {
    if let Some(name) = name.filter(|name| !known.contains(name)) {
        bail!("there is no field `{name}`; there are {}", known.join(", "));
    }
    let Some(file) = file else { return Ok(()) };
    match ending(file) {
        Some(ending) if SEVERAL.contains(&ending) => {}
        Some(ending) if SINGLE.contains(&ending) => {
            if name.is_none() {
                bail!(
                    "{}: a .{ending} holds one field; name it by --field ({})",
                    file.display(),
                    known.join(", ")
                );
            }
        }
        _ => bail!(
            "{}: a field is written as .{}",
            file.display(),
            [SINGLE, SEVERAL].concat().join(", .")
        ),
    }
    written_file::check(file)
}

/// Returns the field with this name, or all of them.
pub(crate) fn chosen_fields(fields: &Fields, name: Option<&str>) -> Result<Vec<Field>> {
    match name {
        Some(name) => Ok(vec![field(fields, name)?]),
        None => FIELDS.into_iter().chain(wear(fields)).map(|name| field(fields, name)).collect(),
    }
}

/// Returns the name of the field that only a scene which wears has.
fn wear(fields: &Fields) -> Option<&'static str> {
    (!fields.further.wear_depth.is_empty()).then_some(WEAR_DEPTH)
}

/// Returns one of the fields of a result; masked elements have no value.
fn field(fields: &Fields, name: &str) -> Result<Field> {
    let [nx, ny] = fields.shape.map(|n| n as usize);
    let corner = [0, 1].map(|axis| fields.origin[axis] - 0.5 * fields.element[axis]);
    let grid = FieldGrid { nx, ny, origin: corner, element: fields.element };
    let on_sole = |values: &[f64]| -> Values {
        Values::Number(
            values
                .iter()
                .zip(&fields.state)
                .map(|(value, state)| if *state == 0 { f64::NAN } else { *value })
                .collect(),
        )
    };
    let lengths =
        |x: &[f64], y: &[f64]| -> Vec<f64> { x.iter().zip(y).map(|(x, y)| x.hypot(*y)).collect() };
    let (unit, values) = match name {
        "pressure" => ("Pa", on_sole(&fields.pressure)),
        "traction_x" => ("Pa", on_sole(&fields.traction_x)),
        "traction_y" => ("Pa", on_sole(&fields.traction_y)),
        "traction" => ("Pa", on_sole(&lengths(&fields.traction_x, &fields.traction_y))),
        "slip" => ("m", on_sole(&lengths(&fields.slip_x, &fields.slip_y))),
        "gap" => ("m", on_sole(&fields.gap)),
        "slip_x" => ("m", on_sole(&fields.slip_x)),
        "slip_y" => ("m", on_sole(&fields.slip_y)),
        WEAR_DEPTH if wear(fields).is_none() => {
            bail!("this scene has no field `{WEAR_DEPTH}`: it has no `wear`")
        }
        WEAR_DEPTH => ("m", on_sole(&fields.further.wear_depth)),
        "friction_work" => ("J/m²", on_sole(&fields.friction_work())),
        "state" => {
            let names = ["outside", "open", "stick", "slip"].map(str::to_owned).to_vec();
            ("", Values::Category { states: fields.state.clone(), names })
        }
        other => bail!("there is no field `{other}`"),
    };
    Ok(Field::new(name, unit, grid, values)?)
}

/// Returns the fields of a result that a page shows, of which the last one holds the states.
pub(crate) fn page_fields(fields: &Fields) -> Result<Vec<Field>> {
    let names = ["pressure", "traction", "gap", "slip", "friction_work"];
    let names = names.into_iter().chain(wear(fields)).chain(["state"]);
    names.map(|name| field(fields, name)).collect()
}

/// Draws a field on standard output or writes it to a file by its ending; without a name that is
/// every field.
pub(crate) fn show_field(
    fields: &Fields,
    name: Option<&str>,
    file: Option<&Path>,
) -> Result<Finish> {
    check_field(name, file)?;
    show_fields(&chosen_fields(fields, name)?, file)
}

/// Draws the first of some fields on standard output, or writes all to a file by its ending.
pub(crate) fn show_fields(chosen: &[Field], file: Option<&Path>) -> Result<Finish> {
    let all: Vec<&Field> = chosen.iter().collect();
    let field = all[0];
    let Some(file) = file else {
        let ink = if std::io::stdout().is_terminal() && std::env::var_os("NO_COLOR").is_none() {
            TerminalInk::Color
        } else {
            TerminalInk::Ascii
        };
        return output::print_raw(&field.terminal(output::terminal_width().unwrap_or(80), ink));
    };
    let bytes = match ending(file) {
        Some("png") => report::png(&field.svg(), RESOLUTION)?,
        Some("svg") => field.svg().into_bytes(),
        Some("npy") => field.npy(),
        Some("vti") => vti(&all)?.into_bytes(),
        Some("csv") => field_csv(&all)?.into_bytes(),
        _ => bail!("{}: a field is not written so", file.display()),
    };
    written_file::write(file, &bytes)?;
    output::print(&format!("{}\n", file.display()))
}

/// Returns the fields of the solution with this index, of the first one by default.
pub(crate) fn solution_fields(found: &Multiplicity, index: Option<usize>) -> Result<Fields> {
    let index = index.unwrap_or(0);
    match found.solutions.get(index) {
        Some(solution) => Ok(solution.fields.clone()),
        None => bail!(
            "there is no solution {index}: the search found {}, counted from 0",
            found.solutions.len()
        ),
    }
}

/// Refuses an index of a solution for a job that does not search for several.
pub(crate) fn only_of_a_search(index: Option<usize>) -> Result<()> {
    match index {
        Some(index) => {
            bail!("--solution {index}: only a study of kind \"multiplicity\" has several solutions")
        }
        None => Ok(()),
    }
}
