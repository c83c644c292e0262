//! Convergence studies, which solve every point and compare it with the limit of a ladder. The
//! ladder is the axis along which the points come closer to that limit.
//!
//! ```toml
//! kind = "convergence"
//!
//! [convergence]               # may be left out
//! along = "mesh"              # or "epsilon"; the mesh if it is an axis
//! reference = "closed-form"   # or "finest"; the closed form along meshes, if every scene has one
//! ```
//!
//! Along meshes, solutions for ε = 0 converge to the closed form. Those for ε > 0 converge to a
//! limit of their own, which is not known: the finest mesh stands for it. Along ε, the solution for
//! the smallest ε on the same mesh stands for the limit; that is the solution for ε = 0 if it is
//! there.

use super::solve;
use super::spec::{KindSpec, KindTable, TableSpec};
use crate::axis::{Group, SweepAxis};
use crate::bounds::ANY;
use crate::columns::column::{Column, ColumnSource};
use crate::columns::result_columns::result_columns;
use crate::error::{Mistake, Span};
use crate::fallback::Fallback::Follows;
use crate::figure::{self, Figure};
use crate::job::Job;
use crate::key::Key;
use crate::table_key::{KeyTable, TableValue, table_key};
use crate::value::Value;

/// The description of the kind.
pub(crate) const SPEC: KindSpec = KindSpec {
    name: "convergence",
    table: Some(TableSpec {
        table: KeyTable {
            path: "convergence",
            is_list: false,
            meaning: "the ladder of a study of kind \"convergence\"",
            keys: &[
                table_key(
                    "along",
                    TableValue::Word(&ALONG),
                    ANY,
                    Follows("the mesh if it is an axis, else epsilon"),
                    "\"mesh\"",
                    "axis along which the rungs come closer to the limit",
                ),
                table_key(
                    "reference",
                    TableValue::Word(&REFERENCES),
                    ANY,
                    Follows(
                        "the closed form along meshes, if every scene has one, else the finest",
                    ),
                    "\"finest\"",
                    "what the rungs are compared with",
                ),
            ],
        },
        check,
        advice: "or say kind = \"convergence\" at the top",
    }),
    has_accuracy: false,
    further_columns: &[ERRORS],
    usual_columns: &["load", "peak_pressure", "status"],
    suggestions,
    ..solve::SPEC
};

/// The ladder of a convergence study.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ladder {
    /// The index of the group of axes that makes its rungs.
    pub group: usize,
    /// The axis of that group along which the rungs converge: [`Key::Mesh`] or [`Key::Epsilon`].
    pub along: Key,
    /// The reference of its rungs; `None` leaves the choice to the scene.
    pub reference: Option<Reference>,
}

/// The reference with which the rungs of a ladder are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reference {
    /// The closed form of the rung's scene.
    ClosedForm,
    /// The finest rung.
    Finest,
}

const ALONG: [&str; 2] = ["mesh", "epsilon"];
const REFERENCES: [&str; 2] = ["closed-form", "finest"];

impl Ladder {
    /// Returns the ladder that `[convergence]` and the axes make. Without the table it is the axis
    /// of meshes, else that of ε. Returns `None` if there is no such axis, or if it has a single
    /// value.
    pub(crate) fn of(table: &KindTable, groups: &[Group]) -> Option<Ladder> {
        let group_of = |key: Key| {
            let is_ladder = |group: &Group| {
                group.design().is_none() && group.axes().iter().any(|axis| axis.key() == Some(key))
            };
            groups.iter().position(is_ladder)
        };
        let (along, group) = wanted(table).iter().find_map(|key| Some((*key, group_of(*key)?)))?;
        let reference = table.word("reference").map(|word| match word {
            "closed-form" => Reference::ClosedForm,
            _ => Reference::Finest,
        });
        (groups[group].len() >= 2).then_some(Ladder { group, along, reference })
    }
}

/// Returns the keys whose axis may be the ladder, the preferred one first.
fn wanted(table: &KindTable) -> &'static [Key] {
    match table.word("along") {
        Some("mesh") => &[Key::Mesh],
        Some(_) => &[Key::Epsilon],
        None => &[Key::Mesh, Key::Epsilon],
    }
}

/// Refuses axes without a ladder, and a closed form along ε.
fn check(table: &KindTable, span: &Span, groups: &[Group], mistakes: &mut Vec<Mistake>) {
    match Ladder::of(table, groups) {
        Some(Ladder { along: Key::Epsilon, reference: Some(Reference::ClosedForm), .. }) => {
            let mistake = Mistake::new(
                span.clone(),
                "along ε the closed form is no reference: the mesh keeps the solutions away from \
                 it",
                "",
            );
            mistakes.push(mistake.help("leave `reference` out, or converge along the mesh"));
        }
        Some(Ladder { group, along, .. }) => {
            let axes = groups[group].axes().iter();
            let repeats = |axis: &&SweepAxis| axis.key() == Some(along) && !axis.is_distinct();
            if let Some(axis) = axes.into_iter().find(repeats) {
                let message =
                    format!("the ladder is the axis `{}`, and a value of it repeats", axis.path());
                mistakes.push(
                    Mistake::new(axis.span.clone(), message, "must be different values").help(
                        "what else varies needs an axis of its own, and has a ladder for each \
                         value",
                    ),
                );
            }
        }
        None => {
            let names: Vec<String> =
                wanted(table).iter().map(|key| format!("`{}`", key.name())).collect();
            let message = format!(
                "a convergence study needs {} as an axis, of at least two values",
                names.join(" or ")
            );
            mistakes.push(Mistake::new(
                span.clone(),
                message,
                "needs for example mesh = [8, 16, 32, 64] below [sweep]",
            ));
        }
    }
}

/// Makes the figure of the errors along the ladder, with a curve for each combination of the other
/// axes.
fn suggestions(table: &KindTable, groups: &[Group], _: &[Job]) -> Vec<Figure> {
    let Some(Ladder { group, along, .. }) = Ladder::of(table, groups) else { return Vec::new() };
    let others = figure::telling(groups).filter(|axis| !groups[group].axes().contains(axis));
    let series = others.map(|axis| axis.column().into_owned()).collect();
    let y = ["error_pressure", "error_peak_pressure", "error_contact_area"].map(str::to_owned);
    let figure = Figure::new(along.column().into_owned(), y.to_vec());
    vec![Figure { series, fit: true, log_x: true, log_y: true, ..figure }]
}

/// Reads a relative error.
macro_rules! error {
    ($($field:ident).+) => {
        ColumnSource::Compared(|compared| {
            compared.errors.$($field).+.map_or(Value::Missing, Value::Number)
        })
    };
}

/// The columns of errors, and of what they are measured against.
pub(crate) const ERRORS: &[Column] = result_columns! {
    Error "error_load" Pure "relative error of the normal force" error!(figures.load);
    Error "error_approach" Pure "relative error of the approach" error!(figures.approach);
    Error "error_tangential_force" Pure "relative error of the tangential force"
        error!(figures.tangential_force);
    Error "error_shift" Pure "relative error of the shift" error!(figures.shift);
    Error "error_moment" Pure "relative error of the moments" error!(figures.moment);
    Error "error_rotation" Pure "relative error of the rotations" error!(figures.rotation);
    Error "error_peak_pressure" Pure "relative error of the largest pressure"
        error!(figures.peak_pressure);
    Error "error_contact_area" Pure "relative error of the area in contact"
        error!(figures.contact_area);
    Error "error_stick_area" Pure "error of the area that sticks over the area in contact"
        error!(figures.stick_area);
    Error "error_pressure" Pure "relative error of the pressure in L2" error!(figures.pressure);
    Error "error_traction" Pure "relative error of the tangential traction in L2"
        error!(figures.traction);
    Error "error_local_pressure" Pure
        "relative error of the local means of the pressure, a weak measure"
        error!(local.pressure);
    Error "error_local_traction" Pure
        "relative error of the local means of the traction, a weak measure"
        error!(local.traction);
    Error "reference" Text "what the errors are measured against"
        ColumnSource::Compared(|compared| Value::Text(compared.reference.clone()));
};
