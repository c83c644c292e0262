//! The fields of stresses below the surface, on planes and sections: computed from the tractions of
//! a result when they are asked for, and never stored.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use contact::interior::{SectionStress, Subsurface};
use contact::model::{Fields, Stress};
use report::{CutPlane, Field, FieldGrid, Values};
use study::Job;
use study::units::{Dimension, quantity};

use crate::fields::check_among;

/// The names of the fields.
const FIELDS: [&str; 11] = [
    "von_mises",
    "tresca",
    "stress_xx",
    "stress_yy",
    "stress_zz",
    "stress_xy",
    "stress_yz",
    "stress_xz",
    "stress_first",
    "stress_second",
    "stress_third",
];

/// A plane or a section on which stresses are wanted.
pub(crate) struct WantedPlane {
    cut: CutPlane,
    /// The depth of a section \[m\].
    down_to: Option<f64>,
}

impl WantedPlane {
    /// Reads a plane like "z=0.1 mm" and the depth of a section.
    pub(crate) fn parse(plane: &str, down_to: Option<&str>) -> Result<Self> {
        let expected = "a plane is written \"z=0.1 mm\", a section \"x=0 mm\" or \"y=0 mm\"";
        let length = |option: &str, text: &str| -> Result<f64> {
            let bare = text.trim().parse::<f64>().ok();
            let value = match bare {
                Some(value) => value,
                None => quantity(text.trim(), Dimension::Length)
                    .map_err(|error| anyhow!("{option} {text}: {error}"))?,
            };
            if value.is_finite() { Ok(value) } else { bail!("{option} {text}: must be finite") }
        };
        let (axis, place) =
            plane.split_once('=').with_context(|| format!("--plane {plane}: {expected}"))?;
        let place = length("--plane", place)?;
        let down_to = down_to.map(|text| length("--down-to", text)).transpose()?;
        let cut = match axis.trim() {
            "x" => CutPlane::X(place),
            "y" => CutPlane::Y(place),
            "z" => CutPlane::Z(place),
            _ => bail!("--plane {plane}: {expected}"),
        };
        match cut {
            CutPlane::Z(depth) if depth < 0.0 => {
                bail!("--plane {plane}: a depth must be 0 or above, z points into the foundation")
            }
            CutPlane::Z(_) if down_to.is_some() => {
                bail!("--down-to: only a section goes down, \"{plane}\" is a plane")
            }
            _ if down_to.is_some_and(|depth| depth <= 0.0) => {
                bail!("--down-to: must be above 0, z points into the foundation")
            }
            _ => Ok(Self { cut, down_to }),
        }
    }
}

/// Checks the field's name and the file before anything is computed.
pub(crate) fn check(name: Option<&str>, file: Option<&Path>) -> Result<()> {
    if crate::fields::is_series(file) {
        bail!("a .pvd holds the fields of all increments, and a plane has those of the last");
    }
    check_among(&FIELDS, name, file)
}

/// Computes the field with this name, or all of them.
pub(crate) fn fields(
    job: &Job,
    fields: &Fields,
    WantedPlane { cut, down_to }: &WantedPlane,
    name: Option<&str>,
) -> Result<Vec<Field>> {
    let case = job.case().context("the job solves no scene, so it has no stresses")?;
    let below = Subsurface::new(&case.scene.foundation, fields);
    let corner = [0, 1].map(|axis| fields.origin[axis] - 0.5 * fields.element[axis]);
    let rigid = || anyhow!("the rigid base begins above this depth: there is no stress in it");
    let (cut, grid, stresses) = match *cut {
        CutPlane::Z(depth) => {
            let plane = below.plane(depth).ok_or_else(rigid)?;
            let [nx, ny] = fields.shape.map(|n| n as usize);
            let grid = FieldGrid { nx, ny, origin: corner, element: fields.element };
            (*cut, grid, plane.stresses)
        }
        CutPlane::X(place) | CutPlane::Y(place) => {
            let across = usize::from(matches!(cut, CutPlane::Y(_)));
            let along = 1 - across;
            let start = corner[across];
            let end = start + f64::from(fields.shape[across]) * fields.element[across];
            if !(start..=end).contains(&place) {
                bail!(
                    "--plane {}={place:e} m: must be in Ω, from {start:e} to {end:e} m: a section \
                     goes through its elements",
                    ["x", "y"][across]
                );
            }
            let SectionStress { place, row, rows, stresses } =
                below.section(across, place, *down_to).ok_or_else(rigid)?;
            let grid = FieldGrid {
                nx: fields.shape[along] as usize,
                ny: rows,
                origin: [corner[along], 0.0],
                element: [fields.element[along], row],
            };
            let cut = if across == 0 { CutPlane::X(place) } else { CutPlane::Y(place) };
            (cut, grid, stresses)
        }
    };
    let names: Vec<&str> = name.map_or(FIELDS.to_vec(), |name| vec![name]);
    names
        .into_iter()
        .map(|name| {
            let values = stresses.iter().map(|stress| value(stress, name)).collect();
            Ok(Field::new(name, "Pa", grid, Values::Number(values))?.on(cut))
        })
        .collect()
}

/// Returns the value of a field where there is this stress.
fn value(stress: &Stress, name: &str) -> f64 {
    match name {
        "von_mises" => stress.von_mises(),
        "tresca" => stress.tresca(),
        "stress_first" => stress.principal()[0],
        "stress_second" => stress.principal()[1],
        "stress_third" => stress.principal()[2],
        "stress_xx" => stress.xx,
        "stress_yy" => stress.yy,
        "stress_zz" => stress.zz,
        "stress_xy" => stress.xy,
        "stress_yz" => stress.yz,
        _ => stress.xz,
    }
}
