//! Tests of the partition as a whole.

use std::collections::BTreeSet;

use super::*;
use crate::kind::forecast;
use crate::testing::{SPHERE, study};

fn shard(index: u64, count: u64) -> Shard {
    Shard::new(index, count).unwrap()
}

/// Returns the points of every shard, after checking that each point is in one.
fn parts(partition: &Partition, points: usize) -> Vec<Vec<usize>> {
    let count = u64::from(partition.count());
    let parts: Vec<Vec<usize>> =
        (1..=count).map(|index| partition.indices(shard(index, count))).collect();
    let mut all: Vec<usize> = parts.iter().flatten().copied().collect();
    all.sort_unstable();
    assert_eq!(all, (0..points).collect::<Vec<_>>());
    for (index, part) in (1..).zip(&parts) {
        assert_eq!(partition.load(shard(index, count)).points, part.len() as u64);
    }
    parts
}

/// Returns both partitions of a study, by its list and by its lattice.
fn both(study: &Study, count: u32) -> [Partition; 2] {
    let (lattice, pieces) = Lattice::of(study).unwrap();
    [
        Partition::of(study, count).unwrap(),
        Partition { row: SequenceRow::new(pieces, count), members: Members::Lattice(lattice) },
    ]
}

#[test]
fn a_shard_is_written_as_an_index_and_a_count() {
    for (text, expected) in [
        ("3/16", Ok(Shard { index: 3, count: 16 })),
        ("1/1", Ok(Shard::WHOLE)),
        ("0/4", Err(ShardError::Zero(4))),
        ("5/4", Err(ShardError::Beyond { index: 5, count: 4 })),
        ("1/0", Err(ShardError::Count(0))),
        ("1/65537", Err(ShardError::Count(65_537))),
        ("99999999999999999999/4", Err(ShardError::Beyond { index: u64::MAX, count: 4 })),
        ("3", Err(ShardError::Form)),
        ("-1/4", Err(ShardError::Form)),
        ("1/+4", Err(ShardError::Form)),
        ("1 / 4", Err(ShardError::Form)),
        ("", Err(ShardError::Form)),
    ] {
        assert_eq!(text.parse::<Shard>(), expected, "{text}");
    }
    assert_eq!(shard(3, 16).to_string(), "3/16");
}

/// Meshes make operators, and loads do not; half of the frictions need fewer unknowns.
const SWEEP: &str = "[sweep]\n\"loading.steps[0].approach\" = { from = \"1 um\", to = \"20 um\", \
                     count = 12 }\n\"friction.mu\" = [0, 0.1, 0.2, 0.3]\n\"numerics.mesh\" = [8, \
                     12, 16]\n";

#[test]
fn every_point_is_in_one_shard_and_the_work_is_even() {
    let study = study(SWEEP);
    for count in [1, 2, 3, 5, 8, 13] {
        for partition in both(&study, count) {
            parts(&partition, study.len());
            let loads: Vec<f64> = (1..=u64::from(count))
                .map(|index| partition.load(shard(index, count.into())).seconds)
                .collect();
            let mean = loads.iter().sum::<f64>() / f64::from(count);
            let longest = study
                .points()
                .iter()
                .map(|point| forecast(&point.job, study.surfaces()).unwrap().seconds)
                .fold(0.0, f64::max);
            let fullest = loads.iter().copied().fold(0.0, f64::max);
            assert!(fullest <= mean + longest + 1e-8, "{fullest} of {mean} for {count}");
        }
    }
}

#[test]
fn few_shards_share_an_operator() {
    let study = study(SWEEP);
    for partition in both(&study, 8) {
        let operators: usize = (1..=8).map(|index| partition.load(shard(index, 8)).operators).sum();
        // There are three operators, and each of the seven cuts can make one more.
        assert!((8..=10).contains(&operators), "{operators}");
    }
}

/// Returns a study of a sphere with lines before its tables and axes at its end.
fn headed(head: &str, sweep: &str) -> Study {
    let text = format!("{head}\n{}{sweep}", SPHERE.replace("mesh = 8\n", ""));
    Study::parse(&text, "sphere.toml", &mut |_| Err(String::new()))
        .unwrap_or_else(|error| panic!("{}", error.render(false)))
}

/// Four values of a fast axis.
const LOADS: &str = "\"loading.steps[0].approach\" = [\"1 um\", \"2 um\", \"3 um\", \"4 um\"]\n";

#[test]
fn lines_ladders_and_points_of_one_scene_stay_whole() {
    let bisect = study(&format!(
        "[bisect]\naxis = \"friction.mu\"\non = \"stick_fraction > 0.5\"\nto = \
         \"1%\"\n[sweep]\n\"friction.mu\" = [0.1, 0.3, 0.5]\n{LOADS}"
    ));
    let find = study(&format!(
        "[find]\naxis = \"friction.mu\"\ncolumn = \"load\"\nvalue = 1\nto = \"1%\"\n[sweep]\n\
         \"friction.mu\" = [0.1, 0.3, 0.5]\n{LOADS}"
    ));
    let fill = study(&format!(
        "[fill]\naxis = \"friction.mu\"\ncolumn = \"load\"\nto = \"1%\"\n[sweep]\n\
         \"friction.mu\" = [0.1, 0.3, 0.5]\n{LOADS}"
    ));
    let meshes = format!("[sweep]\nmesh = [8, 12, 16]\n{LOADS}");
    let tolerances = format!("[sweep]\n\"numerics.tolerance\" = [1e-6, 1e-7, 1e-8]\n{LOADS}");
    for study in [
        bisect,
        find,
        fill,
        headed("kind = \"convergence\"", &meshes),
        headed("kind = \"cost\"", &meshes),
        headed("accuracy = \"1%\"", &tolerances),
    ] {
        for partition in both(&study, 3) {
            for part in parts(&partition, study.len()) {
                let loads: BTreeSet<usize> = part.iter().map(|index| index % 4).collect();
                assert_eq!(part.len(), 3 * loads.len(), "{:?} {part:?}", study.kind());
            }
        }
    }
}

/// Returns a study that is too large to be listed.
fn large(sweep: &str) -> Study {
    let text = format!("{}[sweep]\n{sweep}", SPHERE.replace("mesh = 8\n", ""));
    let study = Study::parse_sharded(&text, "large.toml", &mut |_| Err(String::new()))
        .unwrap_or_else(|error| panic!("{}", error.render(false)));
    assert!(!study.is_listed());
    study
}

/// Coarse meshes cost next to nothing beside fine ones, and still no run takes very many of them.
#[test]
fn no_shard_has_more_points_than_a_run_takes_if_that_can_be() {
    let study = large(
        "\"friction.mu\" = { from = 0.01, to = 0.9, count = 1000 }\n\
         \"loading.steps[0].approach\" = { from = \"1 um\", to = \"20 um\", count = 1000 }\n\
         mesh = [4, 256]\n",
    );
    let partition = Partition::of(&study, 20).unwrap();
    let loads: Vec<ShardLoad> = (1..=20).map(|index| partition.load(shard(index, 20))).collect();
    assert_eq!(loads.iter().map(|load| load.points).sum::<u64>(), 2_000_000);
    assert!(loads.iter().all(|load| load.points <= 200_000), "{loads:?}");
    // Ten shards cannot hold them, which is said before they are listed.
    let few = Partition::of(&study, 9).unwrap();
    let refused = (1..=9).map(|index| few.part(&study, shard(index, 9)));
    let words = refused.filter_map(Result::err).map(|error| error.to_string());
    assert!(words.into_iter().any(|words| words.contains("more than 200000")));
}

/// There are too many combinations of meshes and Poisson's ratios to keep them apart.
#[test]
fn similar_costs_stand_for_each_other_where_there_are_too_many() {
    let meshes: Vec<String> = (4..404).map(|n: u32| n.to_string()).collect();
    let study = large(&format!(
        "\"foundation.base.poisson\" = {{ from = 0.0, to = 0.49, count = 400 }}\n\
         \"punch.radius\" = {{ from = \"10 mm\", to = \"50 mm\", count = 4 }}\nmesh = [{}]\n",
        meshes.join(", ")
    ));
    // The mesh is the fastest axis, and the only one that changes a forecast by much.
    let seconds: Vec<f64> = (0..400)
        .map(|index| forecast(&study.point(index).unwrap().job, study.surfaces()).unwrap().seconds)
        .collect();
    let partition = Partition::of(&study, 64).unwrap();
    let parts: Vec<Vec<usize>> =
        (1..=64).map(|index| partition.indices(shard(index, 64))).collect();
    assert_eq!(parts.iter().map(Vec::len).sum::<usize>(), study.len());
    let load = |part: &Vec<usize>| part.iter().map(|index| seconds[index % 400]).sum::<f64>();
    let loads: Vec<f64> = parts.iter().map(load).collect();
    let mean = loads.iter().sum::<f64>() / 64.0;
    assert!(loads.iter().all(|load| (load / mean - 1.0).abs() < 0.15), "{loads:?} {mean}");
}

#[test]
fn a_study_of_a_thousand_million_points_is_cut_without_listing_it() {
    let axis = |name: &str, from: &str, to: &str| {
        format!("\"{name}\" = {{ from = {from}, to = {to}, count = 1000 }}\n")
    };
    let text = format!(
        "{}[sweep]\n{}{}{}numerics.mesh = [4, 8]\n",
        SPHERE.replace("mesh = 8\n", ""),
        axis("friction.mu", "0.01", "0.9"),
        axis("loading.steps[0].approach", "\"1 um\"", "\"20 um\""),
        axis("scene.foundation.base.shear_modulus", "\"1 GPa\"", "\"200 GPa\"")
    );
    let parse = |sharded: bool| match sharded {
        true => Study::parse_sharded(&text, "big.toml", &mut |_| Err(String::new())),
        false => Study::parse(&text, "big.toml", &mut |_| Err(String::new())),
    };
    let refused = parse(false).unwrap_err().render(false);
    assert!(refused.contains("--shard 1/10000"), "{refused}");
    let study = parse(true).unwrap();
    assert_eq!((study.len(), study.is_listed()), (2_000_000_000, false));
    let partition = Partition::of(&study, 10_000).unwrap();
    let loads: Vec<ShardLoad> =
        (1..=10_000).map(|index| partition.load(shard(index, 10_000))).collect();
    assert_eq!(loads.iter().map(|load| load.points).sum::<u64>(), 2_000_000_000);
    let mean = loads.iter().map(|load| load.seconds).sum::<f64>() / 1e4;
    assert!(loads.iter().all(|load| (load.seconds / mean - 1.0).abs() < 0.01));
    assert!(loads.iter().filter(|load| load.operators > 1).count() <= 1);
    // Neighbours share no point, and what a shard has are points of the study.
    let finer = Partition::of(&study, 50_000).unwrap();
    let [one, next] = [25_000, 25_001].map(|index| finer.indices(shard(index, 50_000)));
    let load = finer.load(shard(25_000, 50_000));
    assert_eq!(load.points, one.len() as u64);
    assert!(load.points > 1000);
    let both: BTreeSet<usize> = one.iter().chain(&next).copied().collect();
    assert_eq!(both.len(), one.len() + next.len());
    assert_eq!(study.restricted(one.clone()).unwrap().points().len(), one.len());
    let too_many = study.restricted((0..200_001).collect()).unwrap_err().render(false);
    assert!(too_many.contains("needs more shards"), "{too_many}");
}

/// Conditions hold in every shard, and what they leave out may make no sense.
#[test]
fn conditions_leave_out_points_of_every_shard() {
    let text = |count: usize, other: usize| {
        format!(
            "{}[sweep]\n\"friction.mu\" = {{ from = -1, to = 1, count = {count} }}\n\
             \"scene.foundation.base.shear_modulus\" = {{ from = 1e9, to = 2e9, count = {other} }}\n\
             mesh = [4, 8]\n[[exclude]]\nwhen = \"mu < 0\"\n",
            SPHERE.replace("mesh = 8\n", "")
        )
    };
    let small = Study::parse(&text(5, 2), "small.toml", &mut |_| Err(String::new())).unwrap();
    assert_eq!((small.len(), small.excluded()), (20, 8));
    let partition = Partition::of(&small, 3).unwrap();
    let mut indices: Vec<usize> =
        (1..=3).flat_map(|index| partition.indices(shard(index, 3))).collect();
    indices.sort_unstable();
    assert_eq!(indices, small.indices().collect::<Vec<_>>());
    let text = text(501, 300);
    let large = Study::parse_sharded(&text, "large.toml", &mut |_| Err(String::new())).unwrap();
    assert_eq!((large.len(), large.is_listed()), (300_600, false));
    let partition = Partition::of(&large, 8).unwrap();
    let parts: Vec<Study> =
        (1..=8).map(|index| partition.part(&large, shard(index, 8)).unwrap()).collect();
    let kept: usize = parts.iter().map(|part| part.indices().count()).sum();
    let left_out: usize = parts.iter().map(Study::excluded).sum();
    assert_eq!((kept, left_out), (150_600, 150_000));
}

/// A sample of 4·10⁹ points is neither listed nor weighed point by point.
#[test]
fn a_sample_of_any_length_is_cut_by_some_of_its_points() {
    let sampled = |count: u32| {
        let text = format!(
            "{}[sample]\nmethod = \"sobol\"\ncount = {count}\n[sample.keys]\n\
             \"friction.mu\" = {{ from = 0.1, to = 0.5 }}\n\
             mesh = {{ values = [8, 64], weights = [3, 1] }}\n",
            SPHERE.replace("mesh = 8\n", "")
        );
        Study::parse_sharded(&text, "sampled.toml", &mut |_| Err(String::new()))
            .unwrap_or_else(|error| panic!("{}", error.render(false)))
    };
    let study = sampled(4_000_000_000);
    let partition = Partition::of(&study, 40_000).unwrap();
    let loads: Vec<ShardLoad> =
        (1..=40_000).map(|index| partition.load(shard(index, 40_000))).collect();
    assert_eq!(loads.iter().map(|load| load.points).sum::<u64>(), 4_000_000_000);
    assert!(loads.iter().all(|load| load.points <= 200_000));
    let part = partition.indices(shard(20_000, 40_000));
    let seconds = |index: &usize| {
        forecast(&study.point(*index).unwrap().job, study.surfaces()).unwrap().seconds
    };
    let mean = part.iter().take(4096).map(seconds).sum::<f64>() / 4096.0;
    let expected = loads[19_999].seconds / loads[19_999].points as f64;
    assert!((mean / expected - 1.0).abs() < 0.05, "{mean} {expected}");
    // Each point of a smaller one is in one shard.
    let study = sampled(300_000);
    parts(&Partition::of(&study, 7).unwrap(), study.len());
}
