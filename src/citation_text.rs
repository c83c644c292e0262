//! Lists of references: to be read, as BibTeX and as JSON.

use answers::{Results, SubjectCounts, UsedSubject};
use anyhow::Result;
use contact::literature::{CitedWork, Sources, WorkForm, sources};
use study::account::ProgramBuild;
use study::{Study, StudyPoint};

use crate::account::program_words;
use crate::machine::this_program;
use crate::words::count;

/// The place where the program's source is.
pub(crate) const REPOSITORY: &str = env!("CARGO_PKG_REPOSITORY");

/// The references of a study.
pub(crate) struct ReferenceList {
    /// The name of the study.
    pub(crate) study: String,
    /// The number of its jobs.
    pub(crate) jobs: usize,
    /// The subjects that they use.
    pub(crate) used: Vec<UsedSubject>,
    /// The program that lists them.
    pub(crate) program: ProgramBuild,
}

impl ReferenceList {
    /// Lists the references of some points of a study.
    pub(crate) fn of(study: &Study, points: &[StudyPoint]) -> Result<Self> {
        let mut subjects = SubjectCounts::of(study);
        subjects.add(points)?;
        Ok(Self::counted(study, subjects))
    }

    /// Lists the references of the points of a study that has results.
    pub(crate) fn of_results(results: &Results<'_>) -> Result<Self> {
        let mut subjects = SubjectCounts::of(results.study());
        results.visit_points(&mut |points| subjects.add(points))?;
        Ok(Self::counted(results.study(), subjects))
    }

    fn counted(study: &Study, subjects: SubjectCounts<'_>) -> Self {
        Self {
            study: study.name().to_owned(),
            jobs: subjects.jobs(),
            used: subjects.used(),
            program: this_program(),
        }
    }

    /// Returns the works, each once, in the order in which they are listed.
    pub(crate) fn works(&self) -> Vec<&'static CitedWork> {
        let mut works: Vec<&CitedWork> = Vec::new();
        for work in self.used.iter().flat_map(|used| sources(used.subject).works) {
            if !works.iter().any(|known| known.key == work.key) {
                works.push(work);
            }
        }
        works
    }

    /// Returns the list to be read.
    pub(crate) fn text(&self) -> String {
        let Self { jobs, used, program, .. } = self;
        let mut text = format!("program\n  tribosweep {}, {REPOSITORY}\n", program_words(program));
        for UsedSubject { subject, jobs: using } in used {
            let of = match using {
                _ if using == jobs && *jobs == 1 => "the only job".to_owned(),
                _ if using == jobs => format!("all {jobs} jobs"),
                _ => format!("{using} of {}", count(*jobs, "job", "jobs")),
            };
            text += &format!("{} ({of})\n", subject.title());
            let Sources { works, derived } = sources(*subject);
            works.iter().for_each(|work| text += &format!("  {}\n", work_words(work)));
            if !derived.is_empty() {
                text += &format!("  derived here: {derived}\n");
            }
        }
        text
    }

    /// Returns the list as BibTeX, each work once.
    pub(crate) fn bibtex(&self) -> String {
        let program = &self.program;
        let mut text = format!(
            "@misc{{tribosweep,\n  title = {{{{tribosweep}}: parameter studies of elastic contact with \
             Coulomb friction}},\n  howpublished = {{\\url{{{REPOSITORY}}}}},\n  note = {{version {}}},\n}}\n",
            program_words(program)
        );
        self.works().iter().for_each(|work| text += &bibtex_entry(work));
        text
    }

    /// Returns the list as JSON.
    pub(crate) fn json(&self) -> serde_json::Value {
        let subject = |used: &UsedSubject| {
            let Sources { works, derived } = sources(used.subject);
            serde_json::json!({
                "subject": used.subject.title(),
                "jobs": used.jobs,
                "works": works,
                "derived_here": (!derived.is_empty()).then_some(derived),
            })
        };
        let used: Vec<_> = self.used.iter().map(subject).collect();
        serde_json::json!({
            "study": self.study,
            "jobs": self.jobs,
            "program": { "name": "tribosweep", "build": self.program, "repository": REPOSITORY },
            "subjects": used,
        })
    }
}

/// Returns a work as a sentence.
fn work_words(work: &CitedWork) -> String {
    let CitedWork { authors, title, published_in, volume, pages, year, doi, .. } = work;
    let mut text = format!("{}: {title}. {published_in}", authors.join(", "));
    if !volume.is_empty() {
        text += &format!(" {volume}");
    }
    if let Some(year) = year {
        text += &format!(" ({year})");
    }
    if !pages.is_empty() {
        text += &format!(" {pages}");
    }
    if let Some(doi) = doi {
        text += &format!(", doi:{doi}");
    }
    text
}

/// Returns a work as an entry of a BibTeX file.
fn bibtex_entry(work: &CitedWork) -> String {
    let CitedWork { key, form, authors, title, published_in, volume, pages, year, doi } = work;
    let (kind, place) = match form {
        WorkForm::Article => ("article", "journal"),
        WorkForm::Book => ("book", "publisher"),
        WorkForm::Software => ("misc", "publisher"),
    };
    let year = year.map(|year| year.to_string());
    let fields = [
        ("author", authors.join(" and ")),
        // Braces keep the capital letters of names.
        ("title", format!("{{{title}}}")),
        (place, (*published_in).to_owned()),
        ("volume", (*volume).to_owned()),
        ("pages", pages.replace('–', "--")),
        ("year", year.unwrap_or_default()),
        ("doi", doi.unwrap_or_default().to_owned()),
    ];
    let given = fields.iter().filter(|(_, value)| !value.is_empty());
    let lines: String = given
        .map(|(name, value)| format!("  {name} = {{{}}},\n", value.replace('&', "\\&")))
        .collect();
    format!("@{kind}{{{key},\n{lines}}}\n")
}

#[cfg(test)]
mod tests {
    use contact::literature::CitedSubject;

    use super::*;

    fn list() -> ReferenceList {
        let used = |subject: CitedSubject, jobs| UsedSubject { subject, jobs };
        ReferenceList {
            study: "small".to_owned(),
            jobs: 6,
            used: CitedSubject::all()
                .into_iter()
                .zip(1..)
                .map(|(subject, i)| used(subject, i))
                .collect(),
            program: ProgramBuild { version: "1.2.3".to_owned(), ..ProgramBuild::default() },
        }
    }

    #[test]
    fn every_form_has_every_work() {
        let list = list();
        let (text, bibtex) = (list.text(), list.bibtex());
        let json = list.json().to_string();
        assert!(list.works().len() > 12);
        for work in list.works() {
            assert_eq!(bibtex.matches(&format!("{{{},\n", work.key)).count(), 1, "{}", work.key);
            assert!(text.contains(work.title) && json.contains(work.title), "{}", work.key);
            let doi = work.doi.unwrap_or_default();
            assert!(text.contains(doi) && bibtex.contains(doi) && json.contains(doi), "{doi}");
        }
        assert!(bibtex.contains("version 1.2.3 (commit unknown)"));
        assert_eq!(bibtex.matches('{').count(), bibtex.matches('}').count());
    }
}
