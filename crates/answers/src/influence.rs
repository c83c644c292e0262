//! The influence of each key on a result, from the rows of a design: Sobol' indices or elementary
//! effects, the most influential key first.

use std::collections::BTreeMap;

use report::{Cell, DataTable, TableColumn};
use study::kind::sensitivity::{SensitivityMethod, SobolEstimators};
use study::{Column, Design, Study};

use crate::comparison::AnswerTable;
use crate::described::{ends, floor, independence, number, sentence};
use crate::error::AnswerError;
use crate::evidence::Evidence;
use crate::place::{PointGroup, StudyPlace, group_points};
use crate::sensitivity::morris;
use crate::sensitivity::sobol::{self, EstimatorForm, Estimators, SaltelliOutputs};
use crate::variation::noise;

/// The names of the columns of Sobol' indices, those of SALib.
const SOBOL: [&str; 6] = ["S1", "S1_low", "S1_high", "ST", "ST_low", "ST_high"];
/// The names of the columns of elementary effects, those of SALib.
const MORRIS: [&str; 5] = ["mu_star", "mu_star_low", "mu_star_high", "mu", "sigma"];

/// Returns the influence of each key on some results, a table for each, and how many rows count.
pub(crate) fn tables(
    evidence: &Evidence<'_>,
    columns: &[Column],
) -> Result<Vec<AnswerTable>, AnswerError> {
    let Some(frame) = DesignFrame::of(evidence)? else { return Ok(Vec::new()) };
    let mut tables = Vec::new();
    for column in columns {
        let (mut rows, mut said) = (Vec::new(), Vec::new());
        let floor = floor(evidence, column);
        for group in &frame.groups {
            let mut outputs = frame.outputs(evidence, column, group);
            outputs.floor = floor;
            let found = frame.influences(&outputs);
            said.push(frame.words(column, &group.place, &outputs, &found));
            rows.extend(frame.ranked(&group.place, found));
        }
        let table = DataTable::new(frame.heads(evidence.study, column), rows)?;
        let title = format!("sensitivity of {}", column.name);
        tables.push(AnswerTable { title: title.into(), table });
        let rows = sentence("", said.join("\n"))?;
        tables.push(AnswerTable { title: format!("rows of {}", column.name).into(), ..rows });
    }
    tables.push(sentence("independence", independence(frame.design.method()))?);
    Ok(tables)
}

/// The design of a study with its points.
struct DesignFrame<'a> {
    design: &'a Design,
    method: SensitivityMethod,
    /// The columns of the keys that are drawn.
    inputs: Vec<String>,
    /// The relative change below which a result counts as constant.
    noise: f64,
    /// The step of the design at each point.
    steps: Vec<usize>,
    groups: Vec<PointGroup>,
}

/// The outputs at the rows of a design.
struct RowOutputs {
    /// The index of each row whose points all have a value, with these values.
    whole: Vec<(usize, Vec<f64>)>,
    /// The number of rows that a point without a value spoils.
    failed: usize,
    /// The number of other rows that are not complete yet.
    left: usize,
    /// The change below which the outputs are the same, in their unit.
    floor: f64,
}

impl RowOutputs {
    /// Returns whether the outputs differ by more than a relative noise, and by more than the floor
    /// of their unit.
    fn vary(&self, noise: f64) -> bool {
        let all = || self.whole.iter().flat_map(|(_, values)| values.iter().copied());
        let least = all().fold(f64::INFINITY, f64::min);
        let most = all().fold(f64::NEG_INFINITY, f64::max);
        most - least > (noise * least.abs().max(most.abs())).max(self.floor)
    }
}

impl<'a> DesignFrame<'a> {
    fn of(evidence: &Evidence<'a>) -> Result<Option<Self>, AnswerError> {
        let Evidence { study, points, .. } = *evidence;
        let sample = study.sample().and_then(|group| Some((group, group.design()?)));
        let (Some((group, design)), Some(method)) = (sample, study.sensitivity()) else {
            return Ok(None);
        };
        let steps: Vec<usize> =
            study.indices().filter_map(|index| study.step_of_sample(index)).collect();
        if steps.len() != points.len() {
            return Err(AnswerError::Inconsistent("a point of the design is missing"));
        }
        let inputs = group.axes().iter().map(|axis| axis.column().into_owned()).collect();
        let is_of_sample = |group: usize| study.groups()[group].design().is_some();
        let groups = group_points(study, points, is_of_sample);
        let noise = noise(points);
        Ok(Some(Self { design, method, inputs, noise, steps, groups }))
    }

    /// Gathers the outputs of the rows at one place.
    fn outputs(&self, evidence: &Evidence<'_>, column: &Column, group: &PointGroup) -> RowOutputs {
        let length = self.design.row_length();
        // A shard has few of the rows, of which there may be thousands of millions.
        let mut members: BTreeMap<usize, Vec<Option<usize>>> = BTreeMap::new();
        for point in &group.members {
            let step = self.steps[*point];
            let row = members.entry(step / length).or_insert_with(|| vec![None; length]);
            row[step % length] = Some(*point);
        }
        let absent = (self.design.count() as usize).saturating_sub(members.len());
        let mut outputs = RowOutputs { whole: Vec::new(), failed: 0, left: absent, floor: 0.0 };
        for (row, points) in members {
            let value = |point: &Option<usize>| number(evidence, column, (*point)?);
            let has_ended = |point: &Option<usize>| {
                point
                    .is_some_and(|point| evidence.records.contains_key(&evidence.points[point].key))
            };
            match points.iter().map(value).collect::<Option<Vec<f64>>>() {
                Some(values) => outputs.whole.push((row, values)),
                None if points.iter().any(|point| has_ended(point) && value(point).is_none()) => {
                    outputs.failed += 1;
                }
                None => outputs.left += 1,
            }
        }
        outputs
    }

    fn heads(&self, study: &Study, column: &Column) -> Vec<TableColumn> {
        let mut heads =
            self.groups.first().map(|group| group.place.heads(study)).unwrap_or_default();
        heads.push(TableColumn::new("input", ""));
        match self.method {
            SensitivityMethod::Sobol(_) => {
                heads.extend(SOBOL.map(|name| TableColumn::new(name, "")));
            }
            SensitivityMethod::Morris => {
                heads.extend(MORRIS.map(|name| TableColumn::new(name, column.unit())));
            }
        }
        heads
    }

    /// Returns the influence of each key; none if the rows of the design say nothing.
    fn influences(&self, outputs: &RowOutputs) -> Vec<KeyInfluence> {
        match self.method {
            _ if !outputs.vary(self.noise) => Vec::new(),
            SensitivityMethod::Sobol(estimators) => self.indices(estimators, outputs),
            SensitivityMethod::Morris => self.effects(outputs),
        }
    }

    /// Returns a row of the table for each key, the most influential one first.
    fn ranked(&self, place: &StudyPlace, found: Vec<KeyInfluence>) -> Vec<Vec<Cell>> {
        let mut ranked: Vec<(&String, KeyInfluence)> = self.inputs.iter().zip(found).collect();
        // The sort is stable: of equal ones the first in the file stays first.
        ranked.sort_by(|(_, a), (_, b)| b.rank.total_cmp(&a.rank));
        let row = |(input, influence): (&String, KeyInfluence)| {
            let mut row = place.cells();
            row.push(Cell::Text(input.clone()));
            row.extend(influence.cells);
            row
        };
        ranked.into_iter().map(row).collect()
    }

    fn indices(&self, estimators: SobolEstimators, outputs: &RowOutputs) -> Vec<KeyInfluence> {
        let inputs = self.inputs.len();
        let member =
            |member: usize| outputs.whole.iter().map(|(_, values)| values[member]).collect();
        let outputs = SaltelliOutputs {
            a: member(0),
            ab: (1..=inputs).map(member).collect(),
            b: member(inputs + 1),
        };
        let indices = sobol::indices(&outputs, forms(estimators)).unwrap_or_default();
        let of_input = |indices: sobol::SobolIndices| {
            let of = [indices.first, indices.total];
            let cells = of.map(|index| {
                let [low, high] = ends(index.interval);
                [Cell::Number(index.value), low, high]
            });
            let cells = cells.concat().into_iter().map(without_rounding).collect();
            KeyInfluence { rank: indices.total.value, cells }
        };
        indices.into_iter().map(of_input).collect()
    }

    fn effects(&self, outputs: &RowOutputs) -> Vec<KeyInfluence> {
        let (length, inputs) = (self.design.row_length(), self.inputs.len());
        let place = |step: usize| {
            (0..inputs).map(|input| self.design.coordinate(step as u32, input)).collect()
        };
        let of_row = |(row, values): &(usize, Vec<f64>)| {
            let points: Vec<Vec<f64>> = (row * length..(row + 1) * length).map(place).collect();
            morris::elementary(&points, values)
        };
        let all: Vec<Vec<f64>> = outputs.whole.iter().filter_map(of_row).collect();
        let of_input = |input: usize| all.iter().map(|effects| effects[input]).collect();
        let elementary: Vec<Vec<f64>> = (0..inputs).map(of_input).collect();
        let influence = |effects: morris::InputEffects| {
            let [low, high] = ends(effects.interval);
            let deviation = effects.deviation.map_or(Cell::Missing, Cell::Number);
            let [absolute, mean] = [effects.absolute, effects.mean].map(Cell::Number);
            KeyInfluence {
                rank: effects.absolute,
                cells: vec![absolute, low, high, mean, deviation],
            }
        };
        let effects = morris::effects(&elementary).unwrap_or_default();
        effects.into_iter().map(influence).collect()
    }

    /// Says how many rows count, and what the indices of first order sum up to.
    fn words(
        &self,
        column: &Column,
        place: &StudyPlace,
        outputs: &RowOutputs,
        found: &[KeyInfluence],
    ) -> String {
        let RowOutputs { whole, failed, left, .. } = outputs;
        let (count, name) = (self.design.count(), &column.name);
        let rows = match self.method {
            SensitivityMethod::Sobol(_) => "rows",
            SensitivityMethod::Morris => "trajectories",
        };
        let mut words = match place.values.is_empty() {
            true => String::new(),
            false => format!("{}: ", place.scene()),
        };
        words += &format!("{} of {count} {rows} count for {name}", whole.len());
        if *failed > 0 {
            words += &format!("; {failed} with a point that failed or has no {name} are left out");
        }
        if *left > 0 {
            words += &format!("; {left} are not complete yet");
        }
        let is_sobol = matches!(self.method, SensitivityMethod::Sobol(_));
        if found.is_empty() {
            let why = match whole.len() {
                1 if is_sobol => "two rows are needed",
                0 => "none is whole",
                _ if outputs.vary(self.noise) => "it varies, and no estimate of that is finite",
                _ => "it does not vary by more than the solver's tolerance",
            };
            return words + &format!("; nothing moves it that could be told: {why}");
        }
        if !is_sobol {
            return words;
        }
        let first = |influence: &KeyInfluence| influence.cells[0].number().unwrap_or(0.0);
        let sum: f64 = found.iter().map(first).sum();
        words + &format!("; the indices of first order sum up to {sum:.2}")
    }
}

/// The influence of a key.
struct KeyInfluence {
    /// The figure by which keys are ranked.
    rank: f64,
    cells: Vec<Cell>,
}

/// Returns an index without what rounding leaves of 0: parts of 10⁻¹² of the variance.
fn without_rounding(cell: Cell) -> Cell {
    match cell {
        // The sum turns −0 into 0.
        Cell::Number(x) => Cell::Number((x * 1e12).round() / 1e12 + 0.0),
        cell => cell,
    }
}

fn forms(estimators: SobolEstimators) -> Estimators {
    let (first, total) = match estimators {
        SobolEstimators::Usual => (EstimatorForm::Products, EstimatorForm::Differences),
        SobolEstimators::Saltelli => (EstimatorForm::Products, EstimatorForm::Products),
        SobolEstimators::Jansen => (EstimatorForm::Differences, EstimatorForm::Differences),
    };
    Estimators { first, total }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::{RecordMap, Records, RecordsError};
    use crate::testing::SPHERE;

    #[test]
    fn what_is_noise_around_nothing_does_not_vary() {
        let outputs = |values: &[f64], floor: f64| RowOutputs {
            whole: values.iter().map(|value| (0, vec![*value])).collect(),
            failed: 0,
            left: 0,
            floor,
        };
        assert!(outputs(&[1e-13, -3e-13], 0.0).vary(1e-6));
        assert!(!outputs(&[1e-13, -3e-13], 1e-9).vary(1e-6));
        assert!(outputs(&[1.0, 1.1], 1e-9).vary(1e-6));
        assert!(!outputs(&[1.0, 1.0 + 1e-7], 1e-9).vary(1e-6));
    }

    /// A source without results.
    struct EmptySource;

    impl Records for EmptySource {
        fn select(&self, _: &[identity::JobKey]) -> Result<RecordMap, RecordsError> {
            Ok(RecordMap::new())
        }

        fn matching(&self, _: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
            Ok(RecordMap::new())
        }

        fn fields(&self, _: &study::Record) -> Result<contact::model::Fields, RecordsError> {
            Err("there are no fields".into())
        }

        fn account(&self, _: &[u8; 32]) -> Option<study::RunAccount> {
            None
        }
    }

    /// A shard has some rows of very many; the others take no memory.
    #[test]
    fn rows_that_are_not_there_are_counted() {
        let text = format!(
            "kind = \"sensitivity\"\n{SPHERE}[sample]\nmethod = \"sobol\"\ncount = 1000000000\n\
             [sample.keys]\nfriction.mu = {{ from = 0.1, to = 0.5 }}\n"
        );
        let study = Study::parse_sharded(&text, "sphere.toml", &mut |_| Err(String::new()))
            .unwrap_or_else(|error| panic!("{}", error.render(false)));
        // Two rows of three points, and a part of another.
        let part = study.restricted((0..6).chain([2_999_999_997]).collect()).unwrap();
        let (points, records) = (part.points(), RecordMap::new());
        let evidence =
            Evidence { study: &part, points: &points, records: &records, source: &EmptySource };
        let frame = DesignFrame::of(&evidence).unwrap().unwrap();
        let columns = part.columns();
        let load = study::columns::find(&columns, "load").unwrap();
        let RowOutputs { whole, failed, left, .. } =
            frame.outputs(&evidence, load, &frame.groups[0]);
        assert_eq!((whole.len(), failed, left), (0, 0, 1_000_000_000));
    }
}
