//! Studies and results in memory, for tests.

use std::cell::Cell;
use std::collections::HashMap;

use contact::Operators;
use contact::model::Fields;
use identity::JobKey;
use study::job::PHYSICS_VERSION;
use study::{Job, Provenance, Record, Study};

use crate::kind::perform;
use crate::perform::Performed;
use crate::records::{RecordMap, Records, RecordsError};

/// A sphere of 50 mm that is pressed 20 µm into steel, on a mesh of 8 unless an axis has another.
const SPHERE: &str = r#"
    name = "sphere"
    [scene]
    foundation.base = { shear_modulus = "80 GPa", poisson = 0.3 }
    punch = { shape = "sphere", radius = "50 mm" }
    loading.steps = [{ approach = "20 um" }]
"#;

/// Returns the study of a sphere with more lines, which begin with a table or are keys of the top.
pub(crate) fn study(lines: &str) -> Study {
    let numerics = if lines.contains("mesh") || lines.contains("accuracy") {
        ""
    } else {
        "    [numerics]\n    mesh = 8\n"
    };
    let friction = if lines.contains("friction.mu") { "" } else { "    friction.mu = 0.3\n" };
    let (top, tables) = lines.split_at(lines.find('[').unwrap_or(lines.len()));
    let text = format!("{top}\n{SPHERE}{friction}{numerics}{tables}");
    Study::parse(&text, "sphere.toml", &mut |file| Err(format!("no file {file}")))
        .unwrap_or_else(|error| panic!("{}", error.render(false)))
}

/// A store in memory, which counts how often it reads fields.
#[derive(Default)]
pub(crate) struct Shelf {
    pub(crate) results: HashMap<JobKey, (Record, Option<Fields>)>,
    pub(crate) fields_read: Cell<usize>,
}

impl Shelf {
    /// Does the jobs of a study's points and keeps what they have left.
    pub(crate) fn of(study: &Study) -> Self {
        let mut shelf = Self::default();
        for point in study.points() {
            shelf.solve(study, &point.job);
        }
        shelf
    }

    /// Does a job and keeps what it has left.
    pub(crate) fn solve(&mut self, study: &Study, job: &Job) {
        let mut operators = Operators::default();
        let Performed { ending, fields, times } =
            perform(job, study.surfaces(), &mut operators).unwrap();
        let provenance = Provenance::timed("test", 1.0, times);
        let (physics, job) = (PHYSICS_VERSION, job.canonical());
        let record = Record { physics, job, ending, fields: None, provenance };
        self.results.insert(record.key(), (record, fields));
    }
}

impl Records for Shelf {
    fn select(&self, keys: &[JobKey]) -> Result<RecordMap, RecordsError> {
        let record = |key: &JobKey| Some((*key, self.results.get(key)?.0.clone()));
        Ok(keys.iter().filter_map(record).collect())
    }

    fn matching(&self, is_wanted: &dyn Fn(&str) -> bool) -> Result<RecordMap, RecordsError> {
        let all = self.results.iter().map(|(key, (record, _))| (*key, record.clone()));
        Ok(all.filter(|(_, record)| is_wanted(&record.job)).collect())
    }

    fn fields(&self, record: &Record) -> Result<Fields, RecordsError> {
        self.fields_read.set(self.fields_read.get() + 1);
        let fields = self.results.get(&record.key()).and_then(|(_, fields)| fields.clone());
        fields.ok_or_else(|| format!("job {} left no fields", record.key()).into())
    }
}
