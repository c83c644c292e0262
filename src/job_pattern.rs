//! This file finds what the jobs of a study have in common, to tell which others it may choose.

use std::collections::BTreeMap;

use serde_json::Value;

/// The key of a job under which its mesh stands, which a study may refine.
const MESH: &str = "mesh";

/// The canonical texts of jobs, where whatever tells them apart is free. The mesh is free in any
/// case.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum JobPattern {
    /// Anything may stand here, or nothing.
    Free,
    /// This value.
    Fixed(Value),
    /// An object.
    Fields(BTreeMap<String, JobPattern>),
    /// A list of this length.
    Items(Vec<JobPattern>),
}

impl JobPattern {
    /// Returns what some canonical texts have in common; everything is free where there is none.
    pub(crate) fn of(jobs: impl Iterator<Item = String>) -> Self {
        let read = |job: String| serde_json::from_str(&job).map_or(Self::Free, Self::exactly);
        jobs.map(read).reduce(Self::joined).unwrap_or(Self::Free)
    }

    /// Returns whether a canonical text has what the texts of the pattern have in common.
    pub(crate) fn matches(&self, job: &str) -> bool {
        serde_json::from_str(job).is_ok_and(|job| self.allows(&job))
    }

    fn exactly(value: Value) -> Self {
        match value {
            Value::Object(fields) => Self::Fields(
                fields
                    .into_iter()
                    .map(|(name, value)| match name == MESH {
                        true => (name, Self::Free),
                        false => (name, Self::exactly(value)),
                    })
                    .collect(),
            ),
            Value::Array(items) => Self::Items(items.into_iter().map(Self::exactly).collect()),
            value => Self::Fixed(value),
        }
    }

    fn joined(self, other: Self) -> Self {
        match (self, other) {
            (Self::Fields(mut fields), Self::Fields(mut others)) => {
                let names: Vec<String> = fields.keys().chain(others.keys()).cloned().collect();
                let join = |name: String| {
                    let common = match (fields.remove(&name), others.remove(&name)) {
                        (Some(one), Some(other)) => one.joined(other),
                        // The names that both have come twice.
                        (None, None) => return None,
                        _ => Self::Free,
                    };
                    Some((name, common))
                };
                Self::Fields(names.into_iter().filter_map(join).collect())
            }
            (Self::Items(items), Self::Items(others)) if items.len() == others.len() => {
                let pairs = items.into_iter().zip(others);
                Self::Items(pairs.map(|(one, other)| one.joined(other)).collect())
            }
            (one, other) if one == other => one,
            _ => Self::Free,
        }
    }

    fn allows(&self, value: &Value) -> bool {
        match (self, value) {
            (Self::Free, _) => true,
            (Self::Fixed(known), value) => known == value,
            (Self::Fields(fields), Value::Object(values)) => {
                let is_present = |(name, field): (&String, &Self)| {
                    *field == Self::Free
                        || values.get(name).is_some_and(|value| field.allows(value))
                };
                fields.iter().all(is_present) && values.keys().all(|name| fields.contains_key(name))
            }
            (Self::Items(items), Value::Array(values)) => {
                items.len() == values.len()
                    && items.iter().zip(values).all(|(item, value)| item.allows(value))
            }
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_tells_jobs_apart_is_free() {
        let job = |mu: f64, load: f64, mesh: u32, steps: &str| {
            format!(
                r#"{{"scene":{{"mu":{mu},"load":{load}}},"numerics":{{"mesh":{mesh}}},"steps":{steps}}}"#
            )
        };
        let known = [job(0.1, 1.0, 8, "[1,2]"), job(0.3, 1.0, 8, "[1,3]")];
        let pattern = JobPattern::of(known.iter().cloned());
        assert!(known.iter().all(|job| pattern.matches(job)));
        assert!(pattern.matches(&job(0.2, 1.0, 16, "[1,7]")));
        for other in [
            job(0.2, 2.0, 8, "[1,2]"),
            job(0.2, 1.0, 8, "[2,2]"),
            job(0.2, 1.0, 8, "[1,2,3]"),
            job(0.2, 1.0, 8, "{}"),
            job(0.2, 1.0, 8, "[1,2],\"more\":1"),
            "no job".to_owned(),
        ] {
            assert!(!pattern.matches(&other), "{other}");
        }
        assert!(JobPattern::of(std::iter::empty()).matches("{}"));
    }
}
