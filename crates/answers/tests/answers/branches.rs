//! Brackets that branches narrow: what is said of them, and what proves it.

use answers::choice::{Discovery, Finding, PointChoice, choose};
use answers::{Proof, RecordMap, Results, proof};
use contact::uniqueness::cones::ConeNode;
use study::Record;

use super::parse;
use super::shelf::Shelf;

#[test]
fn no_bracket_is_said_of_branches_with_a_hole() {
    let study = parse(
        "name = \"test\"\nkind = \"uniqueness\"
         [scene]\nfoundation.base = { shear_modulus = \"80 GPa\", poisson = 0 }
         punch = { shape = \"flat-rectangle\", width_x = \"3 mm\", width_y = \"3 mm\" }
         [numerics]\nmesh = 3\n[search]\nstarts = 1\n[branch]\nto = \"1%\"\n",
    );
    let mut shelf = Shelf::default();
    let choice = shelf.run(&study);
    let ends = |choice: &PointChoice| match choice.findings[..] {
        [Finding { discovery: Discovery::Branched { ends: Some(ends), reason, .. }, .. }] => {
            Some((ends, reason))
        }
        [Finding { discovery: Discovery::Pending, .. }] => None,
        _ => panic!("{:?}", choice.findings),
    };
    let (found, reason) = ends(&choice).unwrap();
    assert!(found[0] >= 0.99 * found[1] && reason == "branches show it", "{found:?} {reason}");
    assert!(choice.points.len() > 6, "{}", choice.points.len());
    let results = Results::read(study.clone(), &shelf).unwrap();
    let records: RecordMap = choice
        .points
        .iter()
        .map(|point| (point.key, results.record(point).unwrap().clone()))
        .collect();
    let chosen = |records: &RecordMap| choose(&study, records).unwrap();
    assert_eq!(ends(&chosen(&records)), Some((found, reason)));
    let keys: Vec<_> = choice.points.iter().map(|point| point.key).collect();
    // Every proof survives its way through bytes, and each record is needed.
    for key in &keys {
        let again = Record::decode(&records[key].encode()).unwrap();
        assert!(matches!(proof(&again), Some(Proof::Holds(_))));
        let mut fewer = records.clone();
        fewer.remove(key);
        assert_eq!(ends(&chosen(&fewer)), None, "a missing record is waited for");
    }
    // The record of another branch, a failed one and one of another kind are no results of a
    // branch, and what is changed proves nothing.
    let last = keys[keys.len() - 1];
    let changed = |change: &dyn Fn(&mut Record)| {
        let mut records = records.clone();
        change(records.get_mut(&last).unwrap());
        let claimed = ends(&chosen(&records));
        (claimed.is_none_or(|(ends, _)| ends[0] < found[0]), proof(&records[&last]))
    };
    let (is_safe, _) = changed(&|record| *record = records[&keys[keys.len() - 2]].clone());
    assert!(is_safe, "the record of another branch");
    let (is_safe, _) = changed(&|record| record.ending = records[&keys[0]].ending.clone());
    assert!(is_safe, "a bracket in the place of a branch");
    let (is_safe, proved) = changed(&|record| {
        let study::Ending::Branched(found) = &mut record.ending else { panic!("no branch") };
        found.status = contact::model::Status::Failed { reason: "for a test".to_owned() };
    });
    assert!(is_safe && proved.is_none(), "a failed job");
    let (is_safe, proved) = changed(&|record| {
        let study::Ending::Branched(found) = &mut record.ending else { panic!("no branch") };
        found.cases[0].nodes.pop();
    });
    assert!(is_safe && matches!(proved, Some(Proof::Wrong(_))), "a tree without its end");
    let (_, proved) = changed(&|record| {
        let study::Ending::Branched(found) = &mut record.ending else { panic!("no branch") };
        for node in found.cases.iter_mut().flat_map(|case| &mut case.nodes) {
            if let ConeNode::Excluded(weights) = node {
                weights.beta.iter_mut().for_each(|beta| *beta *= 2.0);
                weights.products.iter_mut().for_each(|product| *product *= 9.0);
            }
        }
    });
    assert!(matches!(proved, Some(Proof::Wrong(_))), "weights that exclude nothing");
    let (_, proved) = changed(&|record| record.job = records[&keys[1]].job.clone());
    assert!(matches!(proved, Some(Proof::Wrong(_))), "the job of another branch");
}
