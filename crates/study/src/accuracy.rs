//! The accuracy that stands in place of a mesh: the study says how good its results must be, and
//! each of its points gets the mesh that makes them so.
//!
//! ```toml
//! accuracy = "0.1%"           # in place of numerics.mesh: of the load, or of the approach
//!                             # where the load is given
//! ```
//! ```toml
//! [accuracy]                  # the same with more to say
//! of = "peak_pressure"        # the figure that counts: one with an estimated error,
//!                             # `estimate_peak_pressure`
//! is = "0.1%"                 # the estimate of its relative error, and what the solver left, are
//!                             # together no more than this
//! at_most = 512               # elements across Ω beyond which no mesh is tried; 1024 if left out
//! ```
//!
//! If `numerics.tolerance` is left out, it follows from the accuracy. Every other key of the
//! numerics stays as it is given. The meshes are chosen by the results that are there: see
//! `tribosweep answer`.

use toml::de::DeValue;

use contact::model::{Control, Dof, FigureErrors, Loading, Mesh, PerDof, Shape};

use crate::axis::Group;
use crate::bounds::{ANY, inside, within};
use crate::error::{Mistake, Span};
use crate::fallback::Fallback;
use crate::job::Job;
use crate::key::Key;
use crate::kind::Kind;
use crate::quantity::one_of;
use crate::read::{self, Node};
use crate::sheet::{Given, Setting};
use crate::suggestion::nearest;
use crate::table_key::{KeyTable, PART, TableValue, table_key};

/// The quality that the results of a study must have.
#[derive(Clone, Debug, PartialEq)]
pub struct Accuracy {
    /// The figure that counts, one of those of [`FigureErrors`]. `None` stands for the load, or for
    /// the approach if the load is given.
    pub of: Option<&'static str>,
    /// The largest relative error that is accepted, as it is estimated.
    pub is: f64,
    /// The number of elements across Ω beyond which no mesh is tried.
    pub at_most: u32,
    span: Span,
}

/// The number of elements across Ω of the mesh that is tried first.
pub const FIRST: u32 = 8;

/// The number of elements across Ω beyond which no mesh is tried if the study does not say.
pub(crate) const AT_MOST: u32 = 1024;

/// The table, in whose place a study may have what `is` has.
pub(crate) const TABLE: KeyTable = KeyTable {
    path: "accuracy",
    is_list: false,
    meaning: "the accuracy that each point is to have, in place of a mesh; `accuracy = \"0.1%\"` is \
              short for `is`",
    keys: &[
        table_key(
            "of",
            COLUMN_OF_ESTIMATE,
            ANY,
            DEFAULT,
            "\"peak_pressure\"",
            "figure that counts",
        ),
        table_key(
            "is",
            PART,
            inside(0.0, 1.0),
            Fallback::Needed,
            "\"0.1%\"",
            "largest estimate of its relative error, with what the solver left, that is accepted",
        ),
        table_key(
            "at_most",
            TableValue::Count,
            within(FIRST as f64, Mesh::MAX_SIDE as f64),
            Fallback::Count(AT_MOST),
            "512",
            "elements across Ω beyond which no mesh is tried",
        ),
    ],
};

const COLUMN_OF_ESTIMATE: TableValue =
    TableValue::Other("the name of a figure with an estimated error");
const DEFAULT: Fallback = Fallback::Follows("`load`, or `approach` where the load is given");

impl Accuracy {
    /// Returns the figure that counts for a job.
    pub fn of(&self, job: &Job) -> &'static str {
        let default = || match controls(job) {
            Some(controls) if matches!(controls[Dof::Approach], Control::Force(_)) => "approach",
            _ => "load",
        };
        self.of.unwrap_or_else(default)
    }

    /// Returns the tolerance with which the solver takes no more than a tenth of the accuracy: the
    /// estimate of what the solver leaves is four times the residual of each increment. The
    /// tolerance is a power of ten, so that studies share results.
    pub fn tolerance(&self, job: &Job) -> f64 {
        let increments = job.case().map_or(1, |case| match &case.scene.loading {
            // The elements are not chosen yet.
            loading if loading.is_divided_by_elements() => u64::from(Loading::MAX_INCREMENTS),
            loading => loading.increments(),
        });
        let exponent =
            (self.is / (40.0 * increments.max(1) as f64)).log10().floor().clamp(-12.0, -1.0);
        format!("1e{exponent}").parse().unwrap_or(1e-12)
    }

    /// Refuses a figure that the job gives, or that has no limit.
    pub(crate) fn check(&self, job: &Job) -> Result<(), Mistake> {
        let (Some(of), Some(controls)) = (self.of, controls(job)) else { return Ok(()) };
        let all = |dofs: &[Dof], force: bool| {
            dofs.iter().all(|dof| matches!(controls[*dof], Control::Force(_)) == force)
        };
        let given = match of {
            "load" => all(&[Dof::Approach], true),
            "approach" => all(&[Dof::Approach], false),
            "tangential_force" => all(&Dof::SHIFTS, true),
            "shift" => all(&Dof::SHIFTS, false),
            "moment" => all(&Dof::ROTATIONS, true),
            "rotation" => all(&Dof::ROTATIONS, false),
            _ => false,
        };
        let words = of.replace('_', " ");
        if given {
            let message = format!("the accuracy of the {words} is no question: the scene gives it");
            return Err(Mistake::new(
                self.span.clone(),
                message,
                "must be a figure that the scene leaves open",
            ));
        }
        let case = job.case();
        let is_cone = case.is_some_and(|case| {
            matches!(case.scene.punch.shape, Shape::Cone { .. }) && case.numerics.ceiling.is_none()
        });
        if of == "peak_pressure" && is_cone && case.is_some_and(|case| case.numerics.epsilon == 0.0)
        {
            let message =
                "the peak pressure under a cone has no limit that a mesh could come near to"
                    .to_owned();
            return Err(Mistake::new(
                self.span.clone(),
                message,
                "must be a figure with a limit, for example the load",
            ));
        }
        Ok(())
    }

    /// Returns its place in the file.
    pub(crate) fn place(&self) -> Span {
        self.span.clone()
    }

    /// Returns the mesh that stands in the study's base until another one is chosen.
    pub(crate) fn first_mesh(&self) -> (Key, Given) {
        (
            Key::Mesh,
            Given {
                setting: Setting::Mesh(Mesh::Across(FIRST)),
                span: self.span.clone(),
                nth: None,
            },
        )
    }
}

/// Returns what the loading path prescribes at its end.
fn controls(job: &Job) -> Option<PerDof<Control>> {
    Some(job.case()?.scene.loading.legs().last()?.target)
}

/// Reads `accuracy`, which is a proportion or a table.
pub(crate) fn read(
    node: &Node<'_>,
    kind: Kind,
    base: &[(Key, Given)],
    groups: &[Group],
    mistakes: &mut Vec<Mistake>,
) -> Option<Accuracy> {
    let before = mistakes.len();
    let mut accuracy = Accuracy { of: None, is: f64::NAN, at_most: AT_MOST, span: node.span() };
    match node.get_ref() {
        DeValue::Table(table) => {
            read::refuse_unknown(table, "`[accuracy]`", &TABLE.names(), mistakes);
            match table.get("is").map(|node| read::proportion("accuracy.is", node)) {
                Some(Ok(is)) => accuracy.is = is,
                Some(Err(mistake)) => mistakes.push(mistake),
                None => mistakes.push(Mistake::new(
                    node.span(),
                    "`accuracy.is` is missing",
                    "needs is = \"0.1%\" or the like",
                )),
            }
            if let Some(node) = table.get("of") {
                accuracy.span = node.span();
                match figure(node) {
                    Ok(of) => accuracy.of = Some(of),
                    Err(mistake) => mistakes.push(mistake),
                }
            }
            if let Some(node) = table.get("at_most") {
                match at_most("accuracy.at_most", node, FIRST, "with which it begins") {
                    Ok(n) => accuracy.at_most = n,
                    Err(mistake) => mistakes.push(mistake),
                }
            }
        }
        _ => match read::proportion("accuracy", node) {
            Ok(is) => accuracy.is = is,
            Err(mistake) => mistakes.push(mistake),
        },
    }
    if !kind.has_accuracy() {
        let message = format!("a study of kind \"{}\" has no `accuracy`", kind.name());
        mistakes.push(
            Mistake::new(node.span(), message, "leave this out")
                .help("only studies of kind \"solve\" choose meshes by their accuracy"),
        );
    }
    let axes = groups.iter().flat_map(Group::axes).filter(|axis| {
        axis.choices.iter().any(|c| c.given.iter().any(|(key, _)| *key == Key::Mesh))
    });
    let meshes = base
        .iter()
        .filter(|(key, _)| *key == Key::Mesh)
        .map(|(_, given)| given.span.clone())
        .chain(axes.map(|axis| axis.span.clone()));
    for span in meshes {
        let mistake = Mistake::new(
            span,
            "a study has either a mesh or an accuracy",
            "leave one of the two out",
        );
        mistakes.push(mistake.context(node.span(), "which chooses the mesh"));
    }
    (mistakes.len() == before).then_some(accuracy)
}

fn figure(node: &Node<'_>) -> Result<&'static str, Mistake> {
    let word = read::text("accuracy.of", node)?;
    // The name of the estimate's column means the same figure.
    let bare = word.strip_prefix("estimate_").unwrap_or(&word);
    let figures = FigureErrors::default().named().map(|(name, _)| name);
    figures.into_iter().find(|known| *known == bare).ok_or_else(|| {
        let mistake = |expected: String| {
            Mistake::new(
                node.span(),
                format!("`accuracy.of`: no error of `{word}` is estimated"),
                expected,
            )
        };
        match nearest(bare, figures) {
            Some(suggestion) => mistake(format!("did you mean \"{suggestion}\"?"))
                .help(format!("must be {}", one_of(&figures))),
            None => mistake(format!("must be {}", one_of(&figures))),
        }
    })
}

/// Reads the number of elements across Ω beyond which no mesh is tried. `reason` says why the
/// number cannot be below `least`.
pub(crate) fn at_most(
    name: &str,
    node: &Node<'_>,
    least: u32,
    reason: &str,
) -> Result<u32, Mistake> {
    let DeValue::Integer(n) = node.get_ref() else {
        return Err(read::mistyped(name, node, "a whole number of elements across Ω, like 512"));
    };
    match read::whole(name, n, node.span())? {
        n if (least..=Mesh::MAX_SIDE).contains(&n) => Ok(n),
        n => {
            let expected = format!("must be from {least}, {reason}, to {}", Mesh::MAX_SIDE);
            Err(Mistake::new(node.span(), format!("`{name}` cannot be {n}"), expected))
        }
    }
}
