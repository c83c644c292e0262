//! What accuracy costs: the error of every rung of a ladder against the time it takes.

use contact::assess::{ClosedForm, Errors, closed_form};
use contact::model::{Control, Dof, FigureErrors, Mesh, Numerics, PerDof, StepOutcome};
use contact::theory::{PowerLaw, power_law, richardson};
use report::{Cell, DataTable, TableColumn, pareto_front};
use study::columns::Compared;
use study::key::Key;
use study::kind::cost::{Cost, is_rung};
use study::{Study, StudyPoint, Value};

use crate::comparison::{AnswerTable, Comparison};
use crate::error::AnswerError;
use crate::ladders::members;
use crate::records::{RecordMap, Records};
use crate::rows::{cell, digits};

/// A rung: settings, their error and their time.
struct Rung<'a> {
    index: usize,
    tolerance: f64,
    /// What else it is solved with: which of the families of rungs it belongs to.
    family: usize,
    /// Diagonal of an element \[m\].
    h: f64,
    elements: f64,
    end: &'a StepOutcome,
    seconds: f64,
    spread: f64,
    /// Relative error, as it is measured.
    error: f64,
    /// Relative error that can be relied on.
    claim: f64,
}

/// How the error and the time of a family of rungs go with the mesh, at the tightest tolerance.
#[derive(Default)]
struct Laws {
    order: Option<PowerLaw>,
    growth: Option<PowerLaw>,
}

/// Refuses a study whose error has nothing to be an error from, before anything is solved.
pub fn check(study: &Study, cost: &Cost, points: &[StudyPoint]) -> Result<(), AnswerError> {
    let Some(on) = cost.on.filter(|on| SCALARS.iter().all(|(known, _)| known != on)) else {
        return Ok(());
    };
    match points
        .iter()
        .filter_map(|point| point.job.case())
        .find(|case| closed_form(&case.scene).is_none())
    {
        Some(_) => Err(AnswerError::Refused(format!(
            "{}: [cost] on = \"{on}\" needs a scene with a closed form, and this one has none; what is extrapolated instead is {}",
            study.path(),
            SCALARS.map(|(name, _)| name).join(", ")
        ))),
        None => Ok(()),
    }
}

/// Holds every rung against the closed form of its scene, or else against what its tightest rungs
/// extrapolate to.
pub fn compare(
    study: &Study,
    cost: &Cost,
    points: &[StudyPoint],
    records: &RecordMap,
    source: &dyn Records,
) -> Result<Comparison, AnswerError> {
    let mut compared: Vec<Option<Compared>> = points.iter().map(|_| None).collect();
    let (mut fronts, mut fits, mut words) = (Vec::new(), Vec::new(), Vec::new());
    let mut axes: Vec<String> = Vec::new();
    for (at, members) in members(study, |group| is_rung(&study.groups()[group]), points) {
        let Some(case) = members.first().and_then(|first| points[*first].job.case()) else {
            continue;
        };
        let controls = case
            .scene
            .loading
            .legs()
            .last()
            .map(|leg| leg.target)
            .ok_or(AnswerError::Inconsistent("a scene without a load step"))?;
        let on = cost.on.unwrap_or(if matches!(controls[Dof::Approach], Control::Motion(_)) {
            "load"
        } else {
            "approach"
        });
        let exact = closed_form(&case.scene);
        let mut rungs = Vec::new();
        let mut families: Vec<Numerics> = Vec::new();
        for index in members {
            let Some(numerics) = points[index].job.case().map(|case| &case.numerics) else {
                continue;
            };
            let Some(record) =
                records.get(&points[index].key).filter(|record| record.is_certified())
            else {
                continue;
            };
            let Some(end) = record.outcome().and_then(|outcome| outcome.last()) else { continue };
            let o = &end.observables;
            let (least, most) = record
                .provenance
                .times
                .iter()
                .fold((f64::INFINITY, 0.0_f64), |(l, m), t| (l.min(*t), m.max(*t)));
            let of = Numerics { mesh: Mesh::Across(1), tolerance: 0.5, ..numerics.clone() };
            let family = families.iter().position(|known| *known == of).unwrap_or(families.len());
            if family == families.len() {
                families.push(of);
            }
            rungs.push(Rung {
                index,
                tolerance: numerics.tolerance,
                family,
                h: o.element_x.hypot(o.element_y),
                elements: o.mesh_x as f64 * o.mesh_y as f64,
                end,
                seconds: record.provenance.seconds,
                spread: (most - least).max(0.0) / record.provenance.seconds,
                error: f64::NAN,
                claim: f64::NAN,
            });
        }
        let tightest = tightest(points, &rungs);
        let (reference, uncertainty) = match &exact {
            Some(exact) => (format!("{} ({})", exact.name, exact.source), 0.0),
            None => {
                let Some(limits) =
                    Limits::of(&tightest.iter().map(|at| &rungs[*at]).collect::<Vec<_>>())
                else {
                    continue;
                };
                let Some(uncertainty) = limits.uncertainty(on) else { continue };
                for rung in &rungs {
                    let errors = limits.errors(rung.end, &controls);
                    let reference = "the limit of the finest meshes".to_owned();
                    compared[rung.index] = Some(Compared { errors, reference, claim: None });
                }
                ("extrapolated".to_owned(), uncertainty)
            }
        };
        if let Some(exact) = &exact {
            for rung in &rungs {
                compared[rung.index] =
                    against(exact, rung.end, points, records, rung.index, source)?.map(|errors| {
                        Compared { errors, reference: reference.clone(), claim: None }
                    });
            }
        }
        for rung in &mut rungs {
            rung.error = compared[rung.index]
                .as_ref()
                .and_then(|compared| compared.errors.get(on))
                .unwrap_or(f64::NAN);
        }
        rungs.retain(|rung| rung.error.is_finite() && rung.seconds > 0.0);
        if rungs.is_empty() {
            continue;
        }
        let laws: Vec<Laws> =
            (0..families.len()).map(|family| Laws::of(&rungs, family, uncertainty)).collect();
        claim(&mut rungs, &laws, uncertainty);
        for rung in &rungs {
            if let Some(compared) = &mut compared[rung.index] {
                compared.claim = Some(rung.claim);
            }
        }
        axes = at.iter().map(|(name, _)| name.clone()).collect();
        let head: Vec<Cell> = at.iter().map(|(_, value)| cell(value.clone())).collect();
        let spots: Vec<(f64, f64)> = rungs.iter().map(|rung| (rung.seconds, rung.claim)).collect();
        for rung in pareto_front(&spots).into_iter().map(|at| &rungs[at]) {
            let mut row = head.clone();
            row.extend([
                Cell::Number(rung.claim),
                Cell::Number(digits(rung.seconds, 2)),
                Cell::Number(digits(rung.spread, 1)),
                Cell::Text(settings(study, &points[rung.index], |_| true)),
            ]);
            fronts.push(row);
        }
        for (family, laws) in laws.iter().enumerate() {
            let Some(first) = rungs.iter().find(|rung| rung.family == family) else { continue };
            let mut row = head.clone();
            let pair = |law: &Option<PowerLaw>| match law {
                Some(law) => [law.slope, law.standard_error].map(|x| Cell::Number(digits(x, 2))),
                None => [const { Cell::Missing }; 2],
            };
            let own = settings(study, &points[first.index], |key| {
                !matches!(key, Key::Mesh | Key::Tolerance)
            });
            row.push(if own.is_empty() { Cell::Missing } else { Cell::Text(own) });
            row.push(Cell::Text(on.replace('_', " ")));
            row.extend(pair(&laws.order));
            row.extend(pair(&laws.growth));
            row.extend([
                Cell::Text(reference.split(" (").next().unwrap_or_default().to_owned()),
                Cell::Number(digits(uncertainty, 1)),
            ]);
            fits.push(row);
        }
        let mut row = head;
        row.push(Cell::Text(sentence(study, points, &rungs, on)));
        words.push(row);
    }
    let columns = study.columns();
    let unit = |name: &str| study::columns::find(&columns, name).map_or("", study::Column::unit);
    let table = |own: &[(&str, &str)], rows: Vec<Vec<Cell>>| {
        let heads = axes.iter().map(|name| TableColumn::new(name.as_str(), unit(name)));
        DataTable::new(
            heads.chain(own.iter().map(|(name, unit)| TableColumn::new(*name, *unit))).collect(),
            rows,
        )
    };
    let mut answers = Vec::new();
    if !fronts.is_empty() {
        let front = table(
            &[("error up to", ""), ("seconds", "s"), ("spread", ""), ("settings", "")],
            fronts,
        )?;
        answers.push(AnswerTable { title: "cheapest for their error", table: front });
        let own = [
            ("with", ""),
            ("error of", ""),
            ("order in h", ""),
            ("±", ""),
            ("time ~ elements^", ""),
            ("± ", ""),
            ("reference", ""),
            ("its uncertainty", ""),
        ];
        answers.push(AnswerTable { title: "laws", table: table(&own, fits)? });
        answers.push(AnswerTable { title: "cost", table: table(&[("answer", "")], words)? });
    }
    Ok(Comparison { compared, answers })
}

impl Laws {
    /// Of errors that the reference is certain enough to tell.
    fn of(rungs: &[Rung<'_>], family: usize, uncertainty: f64) -> Self {
        let own = || rungs.iter().filter(|rung| rung.family == family);
        let least = own().map(|rung| rung.tolerance).fold(f64::INFINITY, f64::min);
        let mut line: Vec<&Rung<'_>> = own().filter(|rung| rung.tolerance == least).collect();
        // from the coarsest mesh to the finest
        line.sort_by(|a, b| b.h.total_cmp(&a.h));
        let errors =
            line.iter().filter(|rung| rung.error > uncertainty).map(|rung| (rung.h, rung.error));
        Laws {
            order: power_law(&errors.collect::<Vec<_>>()).ok(),
            growth: power_law(
                &line.iter().map(|rung| (rung.elements, rung.seconds)).collect::<Vec<_>>(),
            )
            .ok(),
        }
    }
}

/// What error each rung can be relied on to keep: its own and those of the rungs of its family that
/// are as fine and as tight or more so, none of which may be better by chance, and what the
/// family's law gives on its mesh; to which the uncertainty of the reference comes.
fn claim(rungs: &mut [Rung<'_>], laws: &[Laws], uncertainty: f64) {
    let claims: Vec<f64> = rungs
        .iter()
        .map(|rung| {
            let finer = |other: &&Rung<'_>| {
                other.family == rung.family
                    && other.h <= rung.h
                    && other.tolerance <= rung.tolerance
            };
            let largest = rungs.iter().filter(finer).map(|other| other.error).fold(0.0, f64::max);
            // a line that does not fall tells nothing
            let law = laws[rung.family]
                .order
                .as_ref()
                .filter(|law| law.slope > 0.0 && rung.h <= law.range[0]);
            largest.max(law.map_or(0.0, |law| law.at(rung.h))) + uncertainty
        })
        .collect();
    rungs.iter_mut().zip(claims).for_each(|(rung, claim)| rung.claim = two_digits_up(claim));
}

/// The next number of two digits that is not below, so that no rung seems better for a third one.
fn two_digits_up(x: f64) -> f64 {
    if x <= 0.0 || !x.is_finite() {
        return x;
    }
    let unit = 10_f64.powi(x.log10().floor() as i32 - 1);
    // what has two digits already keeps them
    digits((x / unit - 1e-9).ceil() * unit, 1)
}

fn against(
    exact: &ClosedForm,
    end: &StepOutcome,
    points: &[StudyPoint],
    records: &RecordMap,
    index: usize,
    source: &dyn Records,
) -> Result<Option<Errors>, AnswerError> {
    let Some(record) = records.get(&points[index].key) else { return Ok(None) };
    Ok(Errors::against_closed_form(
        end,
        &source.fields(record).map_err(AnswerError::Records)?,
        exact,
    ))
}

/// The rungs that differ from the best in their mesh only: of the smallest tolerance and ε, in the
/// first method and projection.
fn tightest(points: &[StudyPoint], rungs: &[Rung<'_>]) -> Vec<usize> {
    (0..rungs.len()).filter(|at| tightest_has(points, rungs, &rungs[*at])).collect()
}

fn tightest_has(points: &[StudyPoint], rungs: &[Rung<'_>], rung: &Rung<'_>) -> bool {
    let numerics = |rung: &Rung<'_>| points[rung.index].job.case().map(|case| &case.numerics);
    let Some(own) = numerics(rung) else { return false };
    let all = || rungs.iter().filter_map(numerics);
    let least =
        |read: fn(&contact::model::Numerics) -> f64| all().map(read).fold(f64::INFINITY, f64::min);
    let first = all().next();
    own.tolerance == least(|numerics| numerics.tolerance)
        && own.epsilon == least(|numerics| numerics.epsilon)
        && first
            .is_some_and(|first| (first.method, first.projection) == (own.method, own.projection))
}

/// What scalar figures extrapolate to, with uncertainties; `None` where they do not.
struct Limits([Option<(f64, f64)>; 5]);

type Scalar = (&'static str, fn(&StepOutcome) -> f64);

const SCALARS: [Scalar; 5] = [
    ("load", |end| end.observables.load),
    ("approach", |end| end.motion.approach),
    ("peak_pressure", |end| end.observables.peak_pressure),
    ("contact_area", |end| end.observables.contact_area),
    ("stick_area", |end| end.observables.stick_area),
];

/// Where in [`SCALARS`].
const CONTACT_AREA: usize = 3;

impl Limits {
    fn of(rungs: &[&Rung<'_>]) -> Option<Self> {
        let mut rungs = rungs.to_vec();
        rungs.sort_by(|a, b| b.h.total_cmp(&a.h));
        (rungs.len() >= 3).then(|| {
            Limits(SCALARS.map(|(_, read)| {
                let ladder: Vec<(f64, f64)> =
                    rungs.iter().map(|rung| (rung.h, read(rung.end))).collect();
                richardson(&ladder).ok().map(|limit| (limit.value, limit.uncertainty))
            }))
        })
    }

    /// What an error of a quantity is relative to: itself, or of what sticks, what is in contact.
    fn unit(&self, which: usize) -> Option<f64> {
        let (limit, _) =
            self.0[if SCALARS[which].0 == "stick_area" { CONTACT_AREA } else { which }]?;
        (limit != 0.0).then_some(limit.abs())
    }

    /// The relative uncertainty of a quantity's limit.
    fn uncertainty(&self, name: &str) -> Option<f64> {
        let which = SCALARS.iter().position(|(known, _)| *known == name)?;
        Some(self.0[which]?.1 / self.unit(which)?)
    }

    fn errors(&self, end: &StepOutcome, controls: &PerDof<Control>) -> Errors {
        let error = |which: usize| {
            Some((SCALARS[which].1(end) - self.0[which]?.0).abs() / self.unit(which)?)
        };
        let is_force = matches!(controls[Dof::Approach], Control::Force(_));
        let figures = FigureErrors {
            load: error(0).filter(|_| !is_force),
            approach: error(1).filter(|_| is_force),
            peak_pressure: error(2),
            contact_area: error(CONTACT_AREA),
            stick_area: error(4),
            ..FigureErrors::default()
        };
        Errors { figures, ..Errors::default() }
    }
}

/// The settings of a rung, as they differ along the ladder, those of some keys.
fn settings(study: &Study, point: &StudyPoint, of: fn(Key) -> bool) -> String {
    let is_meant = |key: Key| key.path().starts_with("numerics.") && of(key);
    let own = study.axes().zip(&point.values).filter(|(axis, _)| axis.key().is_some_and(is_meant));
    let said: Vec<String> =
        own.map(|(axis, value)| format!("{} {}", axis.column(), shown(value))).collect();
    said.join(", ")
}

fn shown(value: &Value) -> String {
    match value {
        Value::Number(x) if *x != 0.0 && x.abs() < 1e-3 => format!("{x:e}"),
        value => value.to_string(),
    }
}

/// Errors to ask the price of.
const TARGETS: [f64; 6] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6];

/// "1 % of the load costs 0.02 s (mesh 24, tolerance 1e-4); the next digit 9 times that."
fn sentence(study: &Study, points: &[StudyPoint], rungs: &[Rung<'_>], on: &str) -> String {
    let reaching = |target: f64| rungs.iter().filter(move |rung| rung.claim <= target);
    let cheapest = |target: f64| reaching(target).min_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let mut priced: Vec<(f64, &Rung<'_>)> = Vec::new();
    for target in TARGETS {
        let Some(rung) = cheapest(target) else { break };
        // the same rung gives one more digit for nothing
        priced.retain(|(_, other)| other.index != rung.index);
        priced.push((target, rung));
    }
    let Some((_, first)) = priced.first() else {
        return format!("no rung gives the {} to {} %", on.replace('_', " "), TARGETS[0] * 100.0);
    };
    let mut said = Vec::new();
    let mut last = first.seconds;
    for (target, rung) in &priced {
        let (price, settings) =
            (price(rung.seconds), settings(study, &points[rung.index], |_| true));
        let percent = digits(target * 100.0, 3);
        said.push(match said.len() {
            0 => format!("{percent} % of the {} costs {price} ({settings})", on.replace('_', " ")),
            _ => format!(
                "{percent} % costs {price}, {:.1} times that ({settings})",
                rung.seconds / last
            ),
        });
        last = rung.seconds;
    }
    said.join("; ")
}

/// Two digits of a time.
fn price(seconds: f64) -> String {
    let (value, unit) = match seconds {
        s if s < 1e-3 => (s * 1e6, "µs"),
        s if s < 1.0 => (s * 1e3, "ms"),
        s => (s, "s"),
    };
    format!("{} {unit}", digits(value, 1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rungs of h, tolerance, family and error.
    fn rungs<'e>(end: &'e StepOutcome, of: &[(f64, f64, usize, f64)]) -> Vec<Rung<'e>> {
        let rung = |(index, (h, tolerance, family, error)): (usize, &(f64, f64, usize, f64))| {
            let (h, tolerance, family, error) = (*h, *tolerance, *family, *error);
            let elements = (1.0 / h).powi(2);
            Rung {
                index,
                tolerance,
                family,
                h,
                elements,
                end,
                seconds: 1e-6 * elements,
                spread: 0.0,
                error,
                claim: f64::NAN,
            }
        };
        of.iter().enumerate().map(rung).collect()
    }

    fn claims(of: &[(f64, f64, usize, f64)], families: usize, uncertainty: f64) -> Vec<f64> {
        let end = StepOutcome::default();
        let mut rungs = rungs(&end, of);
        let laws: Vec<Laws> =
            (0..families).map(|family| Laws::of(&rungs, family, uncertainty)).collect();
        claim(&mut rungs, &laws, uncertainty);
        rungs.iter().map(|rung| rung.claim).collect()
    }

    #[test]
    fn a_rung_that_is_good_by_chance_claims_what_finer_ones_have() {
        let claimed = claims(
            &[
                (0.4, 1e-8, 0, 0.1),
                (0.2, 1e-8, 0, 1e-6),
                (0.1, 1e-8, 0, 0.01),
                (0.05, 1e-8, 0, 0.004),
            ],
            1,
            1e-3,
        );
        assert!(
            claimed[0] >= 0.101 && claimed[1] >= 0.011,
            "the second error is one of a change of sign: {claimed:?}"
        );
        // a loose solve of a fine mesh does not tell of tight ones
        assert_eq!(claims(&[(0.2, 1e-8, 0, 0.01), (0.1, 1e-2, 0, 0.5)], 1, 0.0), [0.01, 0.5]);
        // another family is not told of
        assert_eq!(claims(&[(0.2, 1e-8, 0, 0.01), (0.1, 1e-8, 1, 0.5)], 2, 0.0), [0.01, 0.5]);
    }

    #[test]
    fn claims_have_two_digits() {
        assert_eq!(
            [0.01, 0.0101, 0.0999, 3.5e-5, 0.0].map(two_digits_up),
            [0.01, 0.011, 0.1, 3.5e-5, 0.0]
        );
    }

    #[test]
    fn nothing_below_the_uncertainty_of_the_reference_is_claimed() {
        let line: Vec<_> = [0.4_f64, 0.2, 0.1, 0.05, 0.025].map(|h| (h, 1e-8, 0, h * h)).to_vec();
        let claimed = claims(&line, 1, 0.1);
        assert!(claimed.iter().all(|claim| *claim >= 0.1), "{claimed:?}");
        let end = StepOutcome::default();
        assert!(
            Laws::of(&rungs(&end, &line), 0, 0.1).order.is_none(),
            "one error is left, no line"
        );
        let laws = Laws::of(&rungs(&end, &line), 0, 1e-9);
        assert!(
            (laws.order.unwrap().slope - 2.0).abs() < 1e-9
                && (laws.growth.unwrap().slope - 1.0).abs() < 1e-9
        );
    }

    #[test]
    fn the_finest_rung_is_not_better_than_its_law() {
        let mut line: Vec<_> =
            [0.4_f64, 0.2, 0.1, 0.05, 0.025].map(|h| (h, 1e-8, 0, h * h)).to_vec();
        line[4].3 *= 0.95;
        let claimed = claims(&line, 1, 0.0);
        assert!(claimed[4] > line[4].3, "{claimed:?}");
    }

    #[test]
    fn families_have_laws_of_their_own() {
        let of = |family: usize, order: i32| {
            [0.4_f64, 0.2, 0.1, 0.05].map(|h| (h, 1e-8, family, h.powi(order)))
        };
        let end = StepOutcome::default();
        let all = rungs(&end, &[of(0, 1), of(1, 2)].concat());
        let order = |family: usize| Laws::of(&all, family, 0.0).order.unwrap().slope;
        assert!((order(0) - 1.0).abs() < 1e-9 && (order(1) - 2.0).abs() < 1e-9);
    }
}
