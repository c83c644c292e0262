//! Says what accuracy costs: the error of every rung of a ladder against the time that it takes.
//!
//! The files below gather the rungs, find what their errors are measured against, and put the
//! outcome into words. They know [`comparison`](crate::comparison), places, rows and records, and
//! no kind of study.

mod reference;
mod rung;
mod ties;
mod words;

use contact::assess::closed_form;
use contact::model::{Control, Dof};
use contact::theory::PowerLaw;
use report::{Cell, DataTable, TableColumn};
use study::columns::Compared;
use study::key::Key;
use study::kind::cost::{Cost, is_rung};
use study::{Study, StudyPoint};

use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::place::{PointGroup, StudyPlace, group_points};
use crate::rows::digits;

use reference::{CostReference, SCALARS};
use rung::{CostRung, Laws, claim, rungs_of};
use ties::{CheapestRung, cheapest_for_their_error};
use words::{sentence, settings, several_settings};

/// Refuses a study whose error has nothing to be measured against, before anything is solved.
pub(crate) fn check(study: &Study, cost: &Cost, points: &[StudyPoint]) -> Result<(), AnswerError> {
    let Some(on) = cost.on.filter(|on| SCALARS.iter().all(|scalar| scalar.name != *on)) else {
        return Ok(());
    };
    let mut cases = points.iter().filter_map(|point| point.job.case());
    if cases.any(|case| closed_form(&case.scene).is_none()) {
        return Err(AnswerError::Refused(format!(
            "{}: [cost] on = \"{on}\" needs a scene with a closed form, and this one has none; \
             what is extrapolated instead is {}",
            study.path(),
            SCALARS.each_ref().map(|scalar| scalar.name).join(", ")
        )));
    }
    Ok(())
}

/// Holds every rung against the closed form of its scene, or else against what its tightest rungs
/// extrapolate to.
pub(crate) fn compare(evidence: &Evidence<'_>, cost: &Cost) -> Result<Comparison, AnswerError> {
    let Evidence { study, points, .. } = *evidence;
    let mut comparison = Comparison::of_points(points.len());
    let mut tables = CostTables::default();
    for group in group_points(study, points, |group| is_rung(&study.groups()[group])) {
        if let Some(ladder) = CostLadder::of(evidence, cost, group, &mut comparison.compared)? {
            tables.add(evidence, ladder);
        }
    }
    comparison.answers = tables.answers(study)?;
    Ok(comparison)
}

/// The rungs of one scene, with their errors and what these may claim.
struct CostLadder<'a> {
    place: StudyPlace,
    /// The error that counts.
    on: &'static str,
    rungs: Vec<CostRung<'a>>,
    /// The laws of each family of rungs.
    laws: Vec<Laws>,
    reference: CostReference,
}

impl<'a> CostLadder<'a> {
    /// Gathers the rungs of a scene and writes how far each is from the reference to `compared`,
    /// which has an entry for each point; `None` if nothing can be said yet.
    fn of(
        evidence: &Evidence<'a>,
        cost: &Cost,
        PointGroup { place, members }: PointGroup,
        compared: &mut [Option<Compared>],
    ) -> Result<Option<Self>, AnswerError> {
        let Some(case) = members.first().and_then(|first| evidence.case(*first)) else {
            return Ok(None);
        };
        let target = case
            .scene
            .loading
            .legs()
            .last()
            .map(|leg| leg.target)
            .ok_or(AnswerError::Inconsistent("a scene without a load step"))?;
        let on = cost.on.unwrap_or(match target[Dof::Approach] {
            Control::Motion(_) => "load",
            Control::Force(_) => "approach",
        });
        let mut rungs = rungs_of(evidence, &members);
        let Some(reference) = CostReference::of(evidence, &case.scene, &rungs, on) else {
            return Ok(None);
        };
        for rung in &mut rungs {
            let errors = reference.errors(evidence, rung, &target)?;
            rung.error = errors.as_ref().and_then(|errors| errors.get(on)).unwrap_or(f64::NAN);
            let reference = reference.full_name();
            let noise = Some(rung.noise);
            compared[rung.point] =
                errors.map(|errors| Compared { errors, reference, claim: None, noise });
        }
        rungs.retain(|rung| rung.error.is_finite() && rung.seconds > 0.0);
        if rungs.is_empty() {
            return Ok(None);
        }
        let laws = Laws::of_families(&rungs, reference.uncertainty());
        claim(&mut rungs, &laws, reference.uncertainty());
        for rung in &rungs {
            if let Some(compared) = &mut compared[rung.point] {
                compared.claim = Some(rung.claim);
            }
        }
        Ok(Some(Self { place, on, rungs, laws, reference }))
    }
}

/// The rows of what a study of cost says beyond its points.
#[derive(Default)]
struct CostTables {
    /// The place of some ladder, which has the same axes as all others.
    place: StudyPlace,
    fronts: Vec<Vec<Cell>>,
    laws: Vec<Vec<Cell>>,
    sentences: Vec<Vec<Cell>>,
}

impl CostTables {
    fn add(&mut self, evidence: &Evidence<'_>, ladder: CostLadder<'_>) {
        self.fronts.extend(front(evidence, &ladder));
        self.laws.extend(laws(evidence, &ladder));
        let mut row = ladder.place.cells();
        row.push(Cell::Text(sentence(evidence, &ladder.rungs, ladder.on)));
        self.sentences.push(row);
        self.place = ladder.place;
    }

    fn answers(self, study: &Study) -> Result<Vec<AnswerTable>, AnswerError> {
        if self.fronts.is_empty() {
            return Ok(Vec::new());
        }
        let table = |title: &'static str, heads: &[(&str, &str)], rows: Vec<Vec<Cell>>| {
            let heads = heads.iter().map(|(name, unit)| TableColumn::new(*name, *unit));
            let heads = self.place.heads(study).into_iter().chain(heads).collect();
            Ok::<_, AnswerError>(AnswerTable {
                title: title.into(),
                table: DataTable::new(heads, rows)?,
            })
        };
        let front = [
            ("error up to", ""),
            ("seconds", "s"),
            ("spread", ""),
            ("settings", ""),
            ("as cheap within the noise", ""),
        ];
        let laws = [
            ("with", ""),
            ("error of", ""),
            ("order in h", ""),
            ("±", ""),
            ("time ~ elements^", ""),
            // Two columns cannot share a name.
            ("± ", ""),
            ("reference", ""),
            ("its uncertainty", ""),
        ];
        Ok(vec![
            table("cheapest for their error", &front, self.fronts)?,
            table("laws", &laws, self.laws)?,
            table("cost", &[("answer", "")], self.sentences)?,
        ])
    }
}

/// Returns a row for each error that some rung has for a price that no other one clearly beats.
fn front(evidence: &Evidence<'_>, ladder: &CostLadder<'_>) -> Vec<Vec<Cell>> {
    let row = |choice: CheapestRung<'_, '_>| {
        let CheapestRung { rung, ties } = choice;
        let mut row = ladder.place.cells();
        row.extend([
            Cell::Number(rung.claim),
            Cell::Number(digits(rung.seconds, 2)),
            Cell::Number(digits(rung.spread, 1)),
            Cell::Text(settings(evidence, rung, |_| true)),
        ]);
        row.push(match &ties[..] {
            [] => Cell::Missing,
            ties => Cell::Text(several_settings(evidence, ties)),
        });
        row
    };
    cheapest_for_their_error(&ladder.rungs).into_iter().map(row).collect()
}

/// Returns a row for each family of rungs that has some.
fn laws(evidence: &Evidence<'_>, ladder: &CostLadder<'_>) -> Vec<Vec<Cell>> {
    let row = |(family, laws): (usize, &Laws)| {
        let first = ladder.rungs.iter().find(|rung| rung.family == family)?;
        let settings = settings(evidence, first, |key| !matches!(key, Key::Mesh | Key::Tolerance));
        let mut row = ladder.place.cells();
        row.push(if settings.is_empty() { Cell::Missing } else { Cell::Text(settings) });
        row.push(Cell::Text(ladder.on.replace('_', " ")));
        row.extend(slope(laws.order.as_ref()));
        row.extend(slope(laws.growth.as_ref()));
        row.extend([
            Cell::Text(ladder.reference.name().to_owned()),
            Cell::Number(digits(ladder.reference.uncertainty(), 1)),
        ]);
        Some(row)
    };
    ladder.laws.iter().enumerate().filter_map(row).collect()
}

/// Returns the slope of a law and its standard error.
fn slope(law: Option<&PowerLaw>) -> [Cell; 2] {
    match law {
        Some(law) => [law.slope, law.standard_error].map(|x| Cell::Number(digits(x, 2))),
        None => [const { Cell::Missing }; 2],
    }
}
