//! The way of every part of a job through a file and back.

use proptest::prelude::*;

use contact::model::{Mesh, RollingHistory, Shape, Step};
use study::key::Key;
use study::{Job, Study, Value, columns};

use crate::accepted::no_files;
use crate::jobs::{from_store, job, plain_job, read_job, solved_job};

/// Returns the text of a study that has a job as its first: one of cost compares three meshes.
fn written(job: &Job) -> String {
    let text = job.to_toml();
    let Job::Cost { case, .. } = job else { return text };
    let [x, y] = case.numerics.mesh.sides();
    let first = match case.numerics.mesh {
        Mesh::Across(n) => n.to_string(),
        Mesh::Exact(_) => format!("[{x}, {y}]"),
    };
    let others: Vec<u32> = (1..5).filter(|n| *n != x && *n != y).take(2).collect();
    format!("{text}[sweep]\nnumerics.mesh = [{first}, {}, {}]\n", others[0], others[1])
}

proptest! {
    /// Serde's names are the file's names, but those of what rolls, which stand deeper: what serde writes
    /// as TOML is read as the same job.
    #[test]
    fn what_serde_writes_is_read(job in plain_job()) {
        let written = toml::to_string(&job).unwrap();
        prop_assert_eq!(read_job(&written), job);
    }

    #[test]
    fn what_a_job_writes_is_read(job in job()) {
        prop_assert_eq!(read_job(&written(&job)), job.clone());
        let mut plain = job.clone();
        let (Job::Solve(case) | Job::Cost { case, .. }) = &mut plain else { panic!("{job:?}") };
        let is_imposed = matches!(&case.scene.punch.shape, Shape::WheelOnRail(wheel) if wheel.motion.is_some());
        case.scene.loading = case.scene.loading.normalised(is_imposed);
        prop_assert_eq!(plain.key(), job.key());
        prop_assert_eq!(read_job(&written(&plain)).canonical(), job.canonical());
        prop_assert_eq!(Job::parse(&job.canonical()).ok(), Some(plain));
    }

    /// Every key that a study gives has a column, with the value that was given, under its name and
    /// under its path.
    #[test]
    fn every_key_of_a_job_fills_its_column(job in solved_job()) {
        let study = Study::parse(&format!("name = \"job\"\n{}", job.to_toml()), "job.toml", &mut from_store).unwrap();
        let point = study.point(0).unwrap();
        let columns = study.columns();
        let value = |name: &str| columns::find(&columns, name).map(|column| column.value(&point, None));
        let json = serde_json::to_value(&job).unwrap();
        let scene = &job.case().unwrap().scene;
        for key in Key::all(|list| if list == Key::Layers { scene.foundation.layers.len() as u32 } else { scene.loading.steps.len() as u32 }) {
            let mut path = key.path().replace('[', ".").replace(']', "");
            // A distance is written with the increments that divide it.
            let is_passing = |step: &Step| step.rolling.is_some_and(|rolling| rolling.history == RollingHistory::Transient);
            if matches!(key, Key::Dq(step) if is_passing(&scene.loading.steps[step as usize])) {
                continue;
            }
            let is_of_rolling = matches!(key, Key::CreepageX(_) | Key::CreepageY(_) | Key::Spin(_) | Key::Dq(_));
            let is_of_motion = matches!(key, Key::Speed | Key::AngularSpeed | Key::LateralVelocity | Key::YawRate | Key::RollRate);
            if is_of_rolling || is_of_motion {
                let (table, name) = path.rsplit_once('.').unwrap();
                path = format!("{table}.{}.{name}", if is_of_rolling { "rolling" } else { "motion" });
            }
            let given = path.split('.').try_fold(&json, |at, name| match name.parse::<usize>() {
                Ok(index) => at.get(index),
                Err(_) => at.get(name),
            });
            let expected = match given {
                Some(serde_json::Value::Number(x)) => Some(x.to_string().parse().unwrap()),
                Some(serde_json::Value::Array(list)) if !matches!(key, Key::Mesh | Key::Simulate | Key::InteriorDepths | Key::InteriorPoints) => Some(list.len() as f64),
                _ => None,
            };
            if let Some(expected) = expected {
                for name in [key.column(), key.path(), key.short()] {
                    prop_assert_eq!(value(&name).and_then(|value| value.as_f64()), Some(expected), "{}", name);
                }
            } else if given.is_none() && !matches!(key, Key::InteriorDepth | Key::Layers | Key::Cycles | Key::Increments(_) | Key::Distance(_) | Key::Steady(_) | Key::Direction(_) | Key::SpinCenter(_) | Key::WearUpdate | Key::WearRepeat | Key::Epsilon | Key::DomainCenterX | Key::DomainCenterY) {
                // A key without a default is missing, if there is a column for it at all.
                prop_assert_eq!(value(&key.column()).unwrap_or(Value::Missing), Value::Missing, "{}", key.column());
            }
        }
    }

    #[test]
    fn any_text_is_a_study_or_an_error(text in "\\PC*", at in any::<prop::sample::Index>()) {
        let _ = Study::parse(&text, "x.toml", &mut no_files).map_err(|error| error.to_string());
        // The same is true of any text inside a good study.
        let good = include_str!("../../../../sweeps/stick-zone.toml");
        let at = (0..=at.index(good.len())).rev().find(|at| good.is_char_boundary(*at)).unwrap();
        let (before, after) = good.split_at(at);
        for spoilt in [format!("{before}{text}{after}"), before.to_owned(), after.to_owned()] {
            let _ = Study::parse(&spoilt, "x.toml", &mut no_files).map_err(|error| error.to_string());
        }
    }
}
