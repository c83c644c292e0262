//! The answers of studies whose results are in memory.

mod blocks;
mod branches;
mod doubts;
mod figures;
mod shelf;

use answers::choice::Discovery;
use answers::effects::{OverviewDraft, overview, variants};
use answers::{AnswerError, AnswerTable, Progress, Proof, Results, check, is_timed, proof};
use report::{Cell, DataTable};
use study::{Kind, Record, Study};

use shelf::Shelf;

/// A sphere pressed into a half-space of the same material: the normal problem is Hertz's.
const SPHERES: &str = r#"
[scene]
foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
punch.shape = "sphere"
punch.radius = "10 mm"
punch.material = { shear_modulus = "80 GPa", poisson = 0.3 }
friction.mu = 0.3
"#;

fn parse(text: &str) -> Study {
    Study::parse(text, "test.toml", &mut |file| Err(format!("no file {file}")))
        .unwrap_or_else(|error| panic!("{}", error.render(false)))
}

fn convergence() -> Study {
    parse(&format!(
        "name = \"test\"\nkind = \"convergence\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]
         [numerics]\nmesh = 8\n[sweep]\nmesh = [8, 16, 32]\n"
    ))
}

fn answer<'r>(results: &'r Results<'_>, title: &str) -> &'r DataTable {
    let answers = results.answers().unwrap();
    let found = answers.iter().find(|answer| answer.title == title);
    &found.unwrap_or_else(|| panic!("no answer `{title}`")).table
}

/// Returns the cell of a column in the row in which another column has a text.
fn cell_beside<'t>(table: &'t DataTable, text: &str, column: &str) -> &'t Cell {
    let is_meant = |row: &&Vec<Cell>| row.contains(&Cell::Text(text.to_owned()));
    let row = table.rows().iter().find(is_meant).unwrap_or_else(|| panic!("no row of {text}"));
    &row[table.column(column).unwrap()]
}

#[test]
fn meshes_converge_to_hertz() {
    let (study, mut shelf) = (convergence(), Shelf::default());
    shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let orders = answer(&results, "orders");
    let order = cell_beside(orders, "load", "order").number().unwrap();
    assert!((0.8..3.0).contains(&order), "{orders:?}");
    let reference = cell_beside(orders, "load", "reference");
    assert!(matches!(reference, Cell::Text(name) if name.contains("Hertz")), "{reference:?}");
    assert!(cell_beside(answer(&results, "limits"), "load", "limit").number().is_some());
    assert_eq!(
        results.progress(),
        Progress { points: 3, done: 3, failed: 0, left: 0, excluded: 0 }
    );
}

#[test]
fn rows_read_no_fields_unless_a_column_of_errors_is_mentioned() {
    let (study, mut shelf) = (convergence(), Shelf::default());
    shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let columns = ["mesh", "load", "status"];
    let plain = results.table(&columns).unwrap();
    assert_eq!(shelf.fields_read.get(), 0);
    let mentions: [&[&str]; 3] =
        [&["mesh", "error_load"], &["-error_load"], &["mesh", "error_load < 0.01 && mesh > 8"]];
    for mention in mentions {
        let compared = results.table(mention).unwrap();
        let errors = compared.select(&["error_load"]).unwrap();
        assert!(errors.rows().iter().all(|row| row[0].number().is_some()), "{mention:?}");
        assert_eq!(compared.select(&columns), plain.select(&columns), "the rest stays");
    }
    let read = shelf.fields_read.get();
    assert_eq!(read, 3, "each rung is read once, however often columns are asked for");
}

#[test]
fn a_study_without_results_answers_with_empty_tables() {
    let (study, shelf) = (convergence(), Shelf::default());
    assert_eq!(Progress::read(&study, &shelf).unwrap().left, 3);
    let results = Results::read(study, &shelf).unwrap();
    let answers = results.answers().unwrap();
    assert!(
        matches!(answers, [AnswerTable { title, table }] if title == "orders" && table.rows().is_empty())
    );
}

#[test]
fn a_mesh_is_doubled_until_the_load_holds_still() {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}]
         [numerics]\nmesh = 4\n[refine]\non = \"load\"\nuntil = \"2%\"\nat_most = 64\n"
    ));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let Discovery::Still { mesh: [x, y], change, .. } = choice.findings[0].discovery else {
        panic!("{:?}", choice.findings)
    };
    assert!(x == y && x == 4 << (choice.points.len() - 1) && change <= 0.02, "{choice:?}");
    let results = Results::read(study, &shelf).unwrap();
    let found = answer(&results, "found");
    assert_eq!(cell_beside(found, "holds still", "mesh"), &Cell::Text(x.to_string()));
}

#[test]
fn an_axis_is_halved_where_a_condition_begins_to_hold() {
    let study = parse(&format!(
        "name = \"test\"\n{SPHERES}
         loading.steps = [{{ approach = \"1 um\" }}, {{ shift_x = \"0.1 um\" }}]
         [numerics]\nmesh = 8\n[sweep]
         \"loading.steps[1].shift_x\" = [\"0.1 um\", \"0.6 um\"]
         [bisect]\naxis = \"loading.steps[1].shift_x\"\non = \"stick_area == 0\"\nto = \"10%\"\n"
    ));
    let choice = Shelf::default().run(&study);
    let Discovery::Changes { from, to, becomes: true } = choice.findings[0].discovery else {
        panic!("{:?}", choice.findings)
    };
    // Cattaneo and Mindlin: μ (2 − ν) / (2 (1 − ν)) times the approach is 0.364 µm.
    assert!(from < 0.39e-6 && to > 0.34e-6 && to - from <= 0.1 * to, "{from} to {to}");
}

#[test]
fn an_accuracy_is_met_by_what_any_study_has_left() {
    let text = |top: &str, numerics: &str| {
        format!(
            "name = \"test\"\n{top}\n{SPHERES}
             loading.steps = [{{ approach = \"1 um\" }}]\n{numerics}"
        )
    };
    let study = parse(&text("accuracy = \"1%\"", ""));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let Discovery::Within { mesh, tolerance, error } = choice.findings[0].discovery else {
        panic!("{:?}", choice.findings)
    };
    assert!(error <= 0.01, "{error}");
    // A study on that very mesh leaves the same result, and nothing is left to do.
    let numerics = format!("[numerics]\nmesh = {}\ntolerance = {tolerance}\n", mesh[0]);
    let mut other = Shelf::default();
    other.run(&parse(&text("", &numerics)));
    assert_eq!(Progress::read(&study, &other).unwrap().done, 1);
}

#[test]
fn a_cost_tells_what_a_digit_takes() {
    let text = |on: &str| {
        format!(
            "name = \"test\"\nkind = \"cost\"\n
             [scene]\nfoundation.base = {{ shear_modulus = \"80 GPa\", poisson = 0.3 }}
             punch = {{ shape = \"sphere\", radius = \"10 mm\" }}\nfriction.mu = 0.3
             loading.steps = [{{ approach = \"1 um\" }}]\n[numerics]\nmesh = 8
             [cost]\nrepeat = 1\n{on}\n[sweep]\nmesh = [8, 16, 32]\n"
        )
    };
    let study = parse(&text(""));
    assert!(is_timed(study.kind()) && !is_timed(Kind::Solve));
    let mut shelf = Shelf::default();
    shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    let laws = answer(&results, "laws");
    let growth = cell_beside(laws, "load", "time ~ elements^").number().unwrap();
    assert_eq!(growth, 1.0, "a microsecond for an element");
    let [row] = answer(&results, "cost").rows() else { panic!("one scene, one sentence") };
    let [Cell::Text(sentence)] = &row[..] else { panic!("{row:?}") };
    assert!(sentence.contains("% of the load costs"), "{sentence}");
    assert_eq!(shelf.fields_read.get(), 0, "scalars are extrapolated without fields");

    // With friction that couples, pressures have no closed form to be compared with.
    let study = parse(&text("on = \"pressure\""));
    let refused = check(&study, &study.points()).unwrap_err();
    assert!(matches!(refused, AnswerError::Refused(reason) if reason.contains("closed form")));
}

#[test]
fn jobs_are_grouped_by_the_effects_that_they_call_for() {
    let study = parse(
        "name = \"test\"
         [scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = 0.3 }
         punch = { shape = \"sphere\", radius = \"10 mm\" }
         loading.steps = [{ approach = \"1 um\" }]\n[numerics]\nmesh = 8
         [sweep]\n\"friction.mu\" = [0, 0.1, 0.2, 0.3, 0.4, 0.5]\n",
    );
    let points = study.points();
    let overview = overview(&study, &points).unwrap();
    let groups: Vec<(&str, usize)> =
        overview.groups.iter().map(|group| (&group.label[..], group.jobs)).collect();
    assert_eq!(groups, [("mu = 0", 1), ("mu = 0.1 … 0.5", 5)]);
    assert!(overview.common.iter().all(|line| line.effect.name() != "friction"));
    let sets = variants(points[0].job.case().unwrap(), study.surfaces()).unwrap();
    assert!(
        sets[0].is_empty() && sets.iter().all(|set| set.len() != 1 || set[0].name() != "coupling")
    );
}

/// Points that share a job are one job with one set of effects, wherever the blocks end in which
/// they come.
#[test]
fn points_of_one_job_are_grouped_as_one_job_in_blocks_of_any_size() {
    let study = parse(
        "name = \"test\"
         [scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = 0.3 }
         loading.steps = [{ approach = \"1 um\" }]\n[numerics]\nmesh = 8
         [sweep]\n\"friction.mu\" = [0, 0.1]
         punch = [{ label = \"a\", shape = \"sphere\", radius = \"1 mm\" },
         { label = \"b\", shape = \"sphere\", radius = \"2 mm\" },
         { label = \"c\", shape = \"sphere\", radius = \"1 mm\" }]\n",
    );
    let points = study.points();
    let whole = overview(&study, &points).unwrap();
    let groups: Vec<(&str, usize, usize)> =
        whole.groups.iter().map(|group| (&group.label[..], group.first, group.jobs)).collect();
    assert_eq!((whole.jobs, groups), (4, vec![("mu = 0", 0, 2), ("mu = 0.1", 3, 2)]));
    assert_eq!(OverviewDraft::of(&study).first_of_jobs(&points), [0, 1, 3, 4]);
    for size in 1..points.len() {
        let mut draft = OverviewDraft::of(&study);
        study.point_blocks(size).try_for_each(|block| draft.add(&block)).unwrap();
        assert_eq!(draft.first_of_jobs(&points), [0; 0], "all were added");
        assert_eq!(draft.overview(), whole, "in blocks of {size}");
    }
}

/// Returns the record of the bracket for a rectangle of square elements.
fn bracket_record(poisson: f64, [nx, ny]: [u32; 2], search: &str) -> Record {
    let study = parse(&format!(
        "name = \"test\"\nkind = \"uniqueness\"
         [scene]\nfoundation.base = {{ shear_modulus = \"80 GPa\", poisson = {poisson} }}
         punch = {{ shape = \"flat-rectangle\", width_x = \"{nx} mm\", width_y = \"{ny} mm\" }}
         [numerics]\nmesh = [{nx}, {ny}]\n[search]\n{search}\n"
    ));
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let results = Results::read(study, &shelf).unwrap();
    results.record(&choice.points[0]).unwrap().clone()
}

#[test]
fn a_uniqueness_set_without_coupling_has_no_end_and_that_is_proved() {
    let record = bracket_record(0.5, [3, 3], "");
    assert_eq!(proof(&record), Some(Proof::Holds(None)));
    let forged = Record { job: record.job.replace("0.5", "0.3"), ..record.clone() };
    assert!(matches!(proof(&forged), Some(Proof::Wrong(_))), "the claim is of another job");
}

#[test]
fn a_strip_is_proved_anew_and_a_forged_one_is_not() {
    use contact::uniqueness::Bracket;
    use contact::uniqueness::strip::ElementCase;
    let record = bracket_record(0.3, [3, 1], "plane = true");
    assert!(matches!(proof(&record), Some(Proof::Holds(Some(_)))));
    let forge = |change: &dyn Fn(&mut Bracket)| {
        let mut forged = record.clone();
        let study::Ending::Bracketed(found) = &mut forged.ending else { panic!("no bracket") };
        change(found.bracket.as_mut().unwrap());
        proof(&forged)
    };
    let changes: [&dyn Fn(&mut Bracket); 6] = [
        &|bracket| {
            let Bracket::Strip { lower, .. } = bracket else { panic!("no strip") };
            lower.mu *= 1.0 + 1e-6;
        },
        &|bracket| {
            let Bracket::Strip { lower, .. } = bracket else { panic!("no strip") };
            lower.critical = vec![ElementCase::Stick; 3];
        },
        &|bracket| {
            let Bracket::Strip { lower, .. } = bracket else { panic!("no strip") };
            lower.critical.pop();
        },
        &|bracket| {
            let Bracket::Strip { upper, .. } = bracket else { panic!("no strip") };
            upper.mu *= 1.0 - 1e-6;
        },
        &|bracket| {
            let Bracket::Strip { upper, .. } = bracket else { panic!("no strip") };
            upper.x.swap(0, 1);
        },
        &|bracket| *bracket = Bracket::Unbounded,
    ];
    for (number, change) in changes.into_iter().enumerate() {
        assert!(matches!(forge(change), Some(Proof::Wrong(_))), "{number}");
    }
    // In space the same record would claim what its bracket does not show.
    let space = Record { job: record.job.replace(",\"plane\":true", ""), ..record.clone() };
    assert!(matches!(proof(&space), Some(Proof::Wrong(_))));
}

#[test]
fn cases_are_proved_anew_and_forged_ones_are_not() {
    use contact::uniqueness::Bracket;
    let record = bracket_record(0.0, [3, 2], "starts = 1\ncases = true");
    assert!(matches!(proof(&record), Some(Proof::Holds(Some(_)))));
    for change in 0..3 {
        let mut forged = record.clone();
        let study::Ending::Bracketed(found) = &mut forged.ending else { panic!("no bracket") };
        let Some(Bracket::Cases { lower, upper }) = &mut found.bracket else { panic!("no cases") };
        match change {
            0 => lower.mu *= 1.05,
            1 => drop(lower.cases.pop()),
            _ => upper.mu = 0.5 * (lower.mu + upper.mu),
        }
        assert!(matches!(proof(&forged), Some(Proof::Wrong(_))), "{change}");
    }
}

#[test]
fn cones_are_proved_anew_and_forged_ones_are_not() {
    use contact::uniqueness::Bracket;
    let record = bracket_record(0.0, [3, 2], "starts = 1\ncases = true\nwidth = 0.01");
    assert!(matches!(proof(&record), Some(Proof::Holds(Some(_)))));
    // A proof survives its way through the bytes of a record.
    let again = Record::decode(&record.encode()).unwrap();
    assert!(matches!(proof(&again), Some(Proof::Holds(Some(_)))));
    for change in 0..4 {
        let mut forged = record.clone();
        let study::Ending::Bracketed(found) = &mut forged.ending else { panic!("no bracket") };
        let Some(Bracket::Cones { lower, upper }) = &mut found.bracket else { panic!("no cones") };
        match change {
            0 => lower.mu *= 1.02,
            1 => drop(lower.cases.pop()),
            2 => drop(lower.cases[0].nodes.pop()),
            _ => upper.mu = 0.5 * (lower.mu + upper.mu),
        }
        assert!(matches!(proof(&forged), Some(Proof::Wrong(_))), "{change}");
    }
}
