//! Effects that are asked for by name: `numerics.simulate`.

use proptest::prelude::*;

use contact::model::Effect;
use study::{Job, Study, Value, columns};

use crate::sphere::sphere;

fn read(more: &str) -> Result<Study, study::StudyError> {
    Study::parse(&sphere("", &format!("{more}\n")), "study.toml", &mut |name| {
        Err(format!("no file {name}"))
    })
}

fn jobs(more: &str) -> Vec<Job> {
    read(more)
        .unwrap_or_else(|error| panic!("{error}"))
        .points()
        .into_iter()
        .map(|point| point.job)
        .collect()
}

fn column(more: &str) -> Vec<Value> {
    let study = read(more).unwrap_or_else(|error| panic!("{error}"));
    let columns = study.columns();
    let column = columns::find(&columns, "simulate").unwrap();
    study.points().iter().map(|point| column.value(point, None)).collect()
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

#[test]
fn effects_are_read_and_fill_their_column() {
    assert_eq!(
        jobs("simulate = [\"traction-y\"]")[0].case().unwrap().numerics.simulate,
        [Effect::TractionY]
    );
    assert_eq!(
        column("simulate = [\"asymmetry-x\", \"coupling\"]"),
        [text("coupling asymmetry-x")]
    );
    assert_eq!(column("simulate = []"), [Value::Missing]);
    assert_eq!(column(""), [Value::Missing]);
    assert_eq!(jobs("simulate = []")[0].key(), jobs("")[0].key());
    assert!(
        jobs("simulate = [\"coupling\"]")[0].canonical().ends_with(r#","simulate":["coupling"]}}"#)
    );
}

#[test]
fn an_axis_is_a_list_of_lists() {
    let axis = "[sweep]\nsimulate = [[], [\"coupling\"], [\"asymmetry-y\", \"asymmetry-x\"]]";
    assert_eq!(column(axis), [text("none"), text("coupling"), text("asymmetry-x asymmetry-y")]);
    let asked: Vec<_> =
        jobs(axis).into_iter().map(|job| job.case().unwrap().numerics.simulate.clone()).collect();
    assert_eq!(
        asked,
        [vec![], vec![Effect::Coupling], vec![Effect::AsymmetryX, Effect::AsymmetryY]]
    );
}

#[test]
fn what_cannot_be_asked_for_is_refused() {
    let refusals = [
        "simulate = [\"couplin\"]",
        "simulate = [\"friction\", \"weather\"]",
        "simulate = [\"coupling\", 3]",
        "simulate = \"coupling\"",
        "simulate = [\"friction\", \"history\"]",
        "[sweep]\nsimulate = [[], [\"layers\"]]",
        "[sweep]\nsimulate = [\"coupling\"]",
        "[sweep]\nsimulate = [[\"coupling\"], [\"coupling\", \"coupling\"]]",
        "[sweep]\nsimulate = { from = 1, to = 2, count = 2 }",
        "simulat = [\"coupling\"]",
    ];
    let said = refusals.map(|more| format!("{more}\n{}\n", read(more).expect_err(more)));
    insta::assert_snapshot!(said.join("\n"));
}

proptest! {
    /// However the list is spelled, the job is the same; and another list is another job.
    #[test]
    fn order_and_repetition_leave_no_trace(mut names in prop::collection::vec(prop::sample::select(Effect::OPTIONAL.to_vec()), 0..12)) {
        let spelled: Vec<String> = names.iter().map(|effect| format!("\"{}\"", effect.name())).collect();
        let job = jobs(&format!("simulate = [{}]", spelled.join(", "))).remove(0);
        let mut unsorted = job.case().unwrap().clone();
        unsorted.numerics.simulate.clone_from(&names);
        prop_assert_eq!(Job::Solve(unsorted).key(), job.key());
        names.sort();
        names.dedup();
        prop_assert_eq!(&job.case().unwrap().numerics.simulate, &names);
        prop_assert_eq!(job.key() == jobs("")[0].key(), names.is_empty());
        prop_assert_eq!(Job::parse(&job.canonical()).ok(), Some(job));
    }
}
