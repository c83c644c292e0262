//! A job: the question about one point of a study, and the identity under which its result is kept.

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;

use contact::model::{
    Base, Domain, Foundation, Friction, InteriorQuestion, Loading, Material, Mesh, Method,
    Numerics, Punch, Scene, SceneError, Shape, Wear,
};
use contact::multiplicity::Search;
use contact::uniqueness::branch::Branch;
use contact::uniqueness::{Question, WitnessSearch};
use identity::JobKey;

/// The version of the physics, which is part of every [`JobKey`]. It changes whenever the same job
/// would give different numbers.
pub const PHYSICS_VERSION: u32 = 4;

/// The question about one point of a study: everything that determines the result, and nothing
/// else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Job {
    /// The solution of a scene.
    Solve(Case),
    /// The solution of a scene, and the time that it takes by itself.
    Cost {
        /// The scene.
        case: Case,
        /// The number of times it is solved.
        repeat: u32,
        /// The number of threads on which it is solved.
        threads: u32,
    },
    /// Every solution of a scene.
    Multiplicity {
        /// The scene. The tolerance in its numerics counts, the method does not.
        case: Case,
        /// The extent of the search.
        search: Search,
    },
    /// The end μ* of a uniqueness set.
    Uniqueness {
        /// The bodies and the sole on which it depends.
        question: Question,
        /// The extent of the search for a witness.
        #[serde(rename = "effort", with = "effort")]
        search: WitnessSearch,
    },
    /// A part of the fields that would bring the end μ* of a uniqueness set down to some friction.
    Branch {
        /// The bodies and the sole.
        question: Question,
        /// The part, and the friction for which it is to be excluded.
        branch: Branch,
    },
}

/// A scene, and the accuracy with which it is to be solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "CaseText", into = "WrittenCase")]
pub struct Case {
    /// The scene.
    pub scene: Scene,
    /// The numerics.
    pub numerics: Numerics,
}

/// Writes and reads the search for a witness as the text of a job has it, `{"search": …}`.
mod effort {
    use contact::uniqueness::WitnessSearch;
    use serde::{Deserialize, Deserializer, Serialize, Serializer};

    #[derive(Serialize, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Effort {
        #[serde(default)]
        search: WitnessSearch,
    }

    pub(super) fn serialize<S: Serializer>(
        search: &WitnessSearch,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        Effort { search: *search }.serialize(serializer)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(
        deserializer: D,
    ) -> Result<WitnessSearch, D::Error> {
        Ok(Effort::deserialize(deserializer)?.search)
    }
}

impl Job {
    /// Returns the scene that is to be solved, once or often.
    pub fn case(&self) -> Option<&Case> {
        match self {
            Job::Solve(case) | Job::Cost { case, .. } | Job::Multiplicity { case, .. } => {
                Some(case)
            }
            Job::Uniqueness { .. } | Job::Branch { .. } => None,
        }
    }

    /// Returns the elements that the job asks for.
    pub fn mesh(&self) -> Mesh {
        match self {
            Job::Solve(case) | Job::Cost { case, .. } | Job::Multiplicity { case, .. } => {
                case.numerics.mesh
            }
            Job::Uniqueness { question, .. } | Job::Branch { question, .. } => question.mesh,
        }
    }

    /// Refuses a job without a mechanical meaning.
    ///
    /// # Errors
    ///
    /// Returns the first error of the scene, the numerics, the question or the search.
    pub(crate) fn validate(&self) -> Result<(), SceneError> {
        match self {
            Job::Solve(case) | Job::Cost { case, .. } => case.validate(),
            Job::Multiplicity { case, search } => {
                case.validate()?;
                search.validate()
            }
            Job::Uniqueness { question, search } => {
                question.validate()?;
                search.validate()?;
                search.suits(question)
            }
            Job::Branch { question, branch } => {
                question.validate()?;
                branch.validate(question)
            }
        }
    }

    /// Returns the canonical text of the job. It is JSON with the fields in their declared order
    /// and with numbers in SI units in their shortest exact form, without defaults and without what
    /// goes without saying on the loading path. Spelling, order and units of the study file leave
    /// no trace in it.
    pub fn canonical(&self) -> String {
        let mut job = self.clone();
        job.normalise();
        serde_json::to_string(&job).expect("a job is plain data with finite numbers")
    }

    /// Returns the [canonical](Job::canonical) text of a job that solves a scene once, cut into the
    /// [parts](TextPart) that different keys make; `None` for other jobs.
    pub(crate) fn text_parts(&self) -> Option<[String; TextPart::COUNT]> {
        let Job::Solve(case) = self else { return None };
        let mut case = case.clone();
        case.normalise();
        let WrittenCase { scene, interior, numerics } = case.into();
        let Scene { foundation, punch, friction, wear, domain, loading, interior: _ } = &scene;
        let mut texts = [const { String::new() }; TextPart::COUNT];
        let mut add = |part: TextPart, name: &str, value: Option<String>| {
            if let Some(value) = value {
                texts[part as usize] += name;
                texts[part as usize] += &value;
            }
        };
        let closed = |value: Option<String>| value.map(|value| value + "}");
        add(TextPart::Foundation, r#"{"kind":"solve","scene":{"foundation":"#, json(foundation));
        add(TextPart::Punch, r#","punch":"#, json(punch));
        add(TextPart::Surface, r#","friction":"#, json(friction));
        add(TextPart::Surface, r#","wear":"#, wear.as_ref().and_then(json));
        add(TextPart::Domain, r#","domain":"#, domain.as_ref().and_then(json));
        add(TextPart::Loading, r#","loading":"#, closed(json(loading)));
        add(TextPart::Interior, r#","interior":"#, interior.as_ref().and_then(json));
        add(TextPart::Numerics, r#","numerics":"#, closed(json(&numerics)));
        Some(texts)
    }

    /// Returns the scene of a job that solves one, once or often, as it stands in the job's
    /// [canonical](Job::canonical) text; `None` for other jobs.
    pub fn scene_text(&self) -> Option<String> {
        let (Job::Solve(case) | Job::Cost { case, .. }) = self else { return None };
        let mut case = case.clone();
        case.normalise();
        Some(serde_json::to_string(&case.scene).expect("a scene is plain data with finite numbers"))
    }

    /// Returns the [scene](Job::scene_text) in a job's canonical text without reading the rest of
    /// the text.
    pub fn scene_in(canonical: &str) -> Option<&str> {
        let job: SceneInJob<'_> = serde_json::from_str(canonical).ok()?;
        let scene = match job.kind {
            "solve" => job.scene?,
            "cost" => job.case?.scene,
            _ => return None,
        };
        Some(scene.get())
    }

    /// Returns the identity of the job: BLAKE3 of the physics version and the canonical text.
    pub fn key(&self) -> JobKey {
        JobKey::of(PHYSICS_VERSION, &self.canonical())
    }

    /// Reads a [canonical](Job::canonical) text, bit for bit what was written.
    ///
    /// # Errors
    ///
    /// Returns an error if the text is no job's JSON, if the job has no mechanical meaning, or if
    /// the text is not its canonical text.
    pub fn parse(text: &str) -> Result<Job, JobError> {
        let job: Job = serde_json::from_str(text)?;
        job.validate()?;
        if job.canonical() == text { Ok(job) } else { Err(JobError::NotCanonical) }
    }

    /// Makes two jobs equal that ask for the same.
    fn normalise(&mut self) {
        match self {
            Job::Solve(case) | Job::Cost { case, .. } => case.normalise(),
            Job::Multiplicity { case, .. } => {
                case.normalise();
                (case.numerics.method, case.numerics.simulate) = (Method::default(), Vec::new());
            }
            Job::Uniqueness { question, search } => {
                normalise(&mut question.foundation, &mut question.punch);
                question.epsilon += 0.0;
                if question.plane {
                    *search = WitnessSearch::default();
                }
            }
            Job::Branch { question, .. } => {
                normalise(&mut question.foundation, &mut question.punch);
                question.epsilon += 0.0;
            }
        }
    }
}

/// A part of the canonical text of a job that solves a scene, in the order of the text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TextPart {
    Foundation,
    Punch,
    /// The friction and the wear.
    Surface,
    Domain,
    Loading,
    Interior,
    Numerics,
}

impl TextPart {
    /// The number of parts.
    pub(crate) const COUNT: usize = 7;

    /// Every part, in the order of the text.
    pub(crate) const ALL: [TextPart; Self::COUNT] = [
        TextPart::Foundation,
        TextPart::Punch,
        TextPart::Surface,
        TextPart::Domain,
        TextPart::Loading,
        TextPart::Interior,
        TextPart::Numerics,
    ];

    /// Returns the parts that the keys make whose paths begin with a pattern. What goes without
    /// saying on the loading path depends on the punch as well, for a wheelset may move.
    pub(crate) fn of_pattern(pattern: &str) -> &'static [TextPart] {
        let names = pattern.strip_prefix("scene.").unwrap_or(pattern);
        match names.split(['.', '[']).next() {
            Some("foundation") => &[TextPart::Foundation],
            Some("punch") => &[TextPart::Punch, TextPart::Loading],
            Some("friction" | "wear") => &[TextPart::Surface],
            Some("domain") => &[TextPart::Domain],
            Some("loading") => &[TextPart::Loading],
            Some("interior") => &[TextPart::Interior],
            Some("numerics") => &[TextPart::Numerics],
            _ => &TextPart::ALL,
        }
    }
}

fn json(value: &impl Serialize) -> Option<String> {
    Some(serde_json::to_string(value).expect("a job is plain data with finite numbers"))
}

impl Case {
    fn validate(&self) -> Result<(), SceneError> {
        self.scene.validate()?;
        self.numerics.validate()?;
        self.numerics.suit(&self.scene.loading)
    }

    fn normalise(&mut self) {
        // −0 becomes 0.
        let scene = &mut self.scene;
        let is_imposed = matches!(
            &scene.punch.shape,
            Shape::WheelOnRail(wheel) if wheel.motion.is_some()
        );
        scene.loading = scene.loading.normalised(is_imposed);
        scene.friction.mu += 0.0;
        scene.wear = scene.wear.map(Wear::normalised);
        normalise(&mut scene.foundation, &mut scene.punch.material);
        if let Shape::WheelOnRail(wheel) = &mut scene.punch.shape {
            for x in [
                &mut wheel.gauge_depth,
                &mut wheel.flange_back_to_origin,
                &mut wheel.lateral,
                &mut wheel.yaw,
                &mut wheel.roll,
            ] {
                *x += 0.0;
            }
            if let Some(motion) = &mut wheel.motion {
                motion.angular_speed = motion.angular_speed.map(|speed| speed + 0.0);
                for x in [&mut motion.lateral_velocity, &mut motion.yaw_rate, &mut motion.roll_rate]
                {
                    *x += 0.0;
                }
            }
        }
        scene.interior = scene.interior.as_ref().map(InteriorQuestion::normalised);
        self.numerics.epsilon += 0.0;
        self.numerics.simulate.sort();
        self.numerics.simulate.dedup();
    }
}

/// Turns −0 into 0.
fn normalise(foundation: &mut Foundation, punch: &mut Option<Material>) {
    for layer in &mut foundation.layers {
        layer.poisson += 0.0;
    }
    if let Base::Elastic(material) = &mut foundation.base {
        material.poisson += 0.0;
    }
    if let Some(material) = punch {
        material.poisson += 0.0;
    }
}

/// A case as it is written: what is asked beyond the solution stands beside the scene.
#[derive(Serialize)]
struct WrittenCase {
    scene: Scene,
    #[serde(skip_serializing_if = "Option::is_none")]
    interior: Option<InteriorQuestion>,
    numerics: Numerics,
}

impl From<Case> for WrittenCase {
    fn from(Case { scene, numerics }: Case) -> Self {
        Self { interior: scene.interior.clone(), scene, numerics }
    }
}

/// A case as it is read. Serde reads no flattened field in a struct that denies unknown fields, as
/// the scene's punch does. [`Job::parse`] finds unknown fields by comparing texts.
#[derive(Deserialize)]
struct CaseText {
    scene: SceneText,
    interior: Option<InteriorQuestion>,
    numerics: Numerics,
}

#[derive(Deserialize)]
struct SceneText {
    foundation: Foundation,
    punch: PunchText,
    friction: Friction,
    wear: Option<Wear>,
    domain: Option<Domain>,
    loading: Loading,
}

#[derive(Deserialize)]
struct PunchText {
    #[serde(flatten)]
    shape: Shape,
    material: Option<Material>,
}

impl From<CaseText> for Case {
    fn from(CaseText { scene, interior, numerics }: CaseText) -> Case {
        let SceneText {
            foundation,
            punch: PunchText { shape, material },
            friction,
            wear,
            domain,
            loading,
        } = scene;
        Case {
            scene: Scene {
                foundation,
                punch: Punch { shape, material },
                friction,
                wear,
                domain,
                loading,
                interior,
            },
            numerics,
        }
    }
}

/// The place of the scene in the text of a job that solves one, once or often.
#[derive(Deserialize)]
struct SceneInJob<'a> {
    kind: &'a str,
    #[serde(borrow)]
    scene: Option<&'a RawValue>,
    #[serde(borrow)]
    case: Option<SceneInCase<'a>>,
}

#[derive(Deserialize)]
struct SceneInCase<'a> {
    #[serde(borrow)]
    scene: &'a RawValue,
}

/// The reason why a text is not a job.
#[derive(Debug, thiserror::Error)]
pub enum JobError {
    /// The text is not a job's JSON.
    #[error("not a job: {0}")]
    Json(#[from] serde_json::Error),
    /// The text says something that is no part of a job, or says it otherwise than this program.
    #[error("not a job: the text is not the canonical text of the job that it describes")]
    NotCanonical,
    /// The job has no mechanical meaning.
    #[error("not a job: {0}")]
    Scene(#[from] SceneError),
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use contact::model::{Layer, Step};
    use contact::uniqueness::cover::NormalCase;

    use super::*;

    pub(crate) fn job() -> Job {
        Job::Solve(case())
    }

    fn with(change: impl FnOnce(&mut Case)) -> Job {
        let mut case = case();
        change(&mut case);
        Job::Solve(case)
    }

    fn case() -> Case {
        let numerics = Numerics {
            mesh: Mesh::Across(16),
            projection: Default::default(),
            epsilon: 0.0,
            ceiling: None,
            method: Default::default(),
            tolerance: 1e-8,
            max_iterations: 20_000,
            simulate: Vec::new(),
        };
        Case {
            scene: Scene {
                foundation: Foundation::half_space(Material { shear_modulus: 80e9, poisson: 0.3 }),
                punch: Punch { shape: Shape::Sphere { radius: 0.05 }, material: None },
                friction: Friction { mu: 0.3 },
                wear: None,
                domain: None,
                loading: Loading::path(vec![Step { approach: Some(2e-5), ..Step::default() }]),
                interior: None,
            },
            numerics,
        }
    }

    /// A change of this text or key orphans every stored result; it needs a new
    /// [`PHYSICS_VERSION`].
    #[test]
    fn the_canonical_text_is_fixed() {
        insta::assert_snapshot!(job().canonical(), @r#"{"kind":"solve","scene":{"foundation":{"base":{"shear_modulus":80000000000.0,"poisson":0.3}},"punch":{"shape":"sphere","radius":0.05},"friction":{"mu":0.3},"loading":{"steps":[{"approach":0.00002}]}},"numerics":{"mesh":16,"projection":"average","method":"auto","tolerance":1e-8,"max_iterations":20000}}"#);
        insta::assert_snapshot!(job().key(), @"94ea56560682e1b511a4b36fe89bca3118e6a5d42d2f1176f85aea5b75f9e58e");
        assert_eq!(job().key().to_string().parse(), Ok(job().key()));
        assert!("12ab".parse::<JobKey>().is_err());
    }

    #[test]
    fn the_scene_of_a_job_stands_in_its_text() {
        let mut case = case();
        case.scene.friction.mu = -0.0;
        let cost = Job::Cost { case: case.clone(), repeat: 5, threads: 1 };
        for job in [Job::Solve(case.clone()), cost] {
            let scene = job.scene_text().unwrap();
            assert!(job.canonical().contains(&format!("\"scene\":{scene},\"numerics\":")));
            assert_eq!(Job::scene_in(&job.canonical()), Some(&*scene));
        }
        let search = Job::Multiplicity { case, search: Search::default() };
        assert_eq!((search.scene_text(), Job::scene_in(&search.canonical())), (None, None));
        assert_eq!(Job::scene_in("{}"), None);
    }

    #[test]
    fn negative_zero_is_zero() {
        let text = |zero: f64| {
            let job = with(|Case { scene, .. }| {
                scene.loading.steps[0].shift_x = Some(zero);
                scene.loading.steps.push(Step {
                    shift_x: Some(1e-6),
                    shift_y: Some(zero),
                    ..Step::default()
                });
                scene.foundation =
                    Foundation::half_space(Material { shear_modulus: 1e9, poisson: zero });
                scene.foundation.layers =
                    vec![Layer { shear_modulus: 1e9, poisson: zero, thickness: 1e-3 }];
                scene.punch.material = Some(Material { shear_modulus: 1e9, poisson: zero });
            });
            job.canonical()
        };
        assert_eq!(text(-0.0), text(0.0));
    }

    #[test]
    fn what_goes_without_saying_is_no_other_job() {
        assert_eq!(with(|case| case.scene.loading.steps[0].shift_x = Some(0.0)).key(), job().key());
        let wordy = with(|case| case.scene.loading.steps.push(case.scene.loading.steps[0]));
        assert_ne!(wordy.key(), job().key(), "a step that holds still is an increment of its own");
        assert!(wordy.canonical().contains(r#""steps":[{"approach":0.00002},{}]"#));
        assert_eq!(Job::parse(&wordy.canonical()).map(|job| job.key()).ok(), Some(wordy.key()));
    }

    #[test]
    fn what_is_not_a_job_is_refused() {
        assert!(Job::parse("{}").is_err());
        assert!(
            Job::parse(&job().canonical().replace("\"poisson\":0.3", "\"poisson\":0.6")).is_err()
        );
        assert!(
            Job::parse(&job().canonical().replace("\"mesh\":16", "\"mesh\":16,\"colour\":1"))
                .is_err()
        );
    }

    proptest! {
        /// Branches are told apart to the last bit of their forms.
        #[test]
        fn forms_travel_bit_for_bit(bits in proptest::collection::vec(any::<u32>(), 4)) {
            let form: Vec<f32> = bits.into_iter().map(f32::from_bits).collect();
            prop_assume!(form.iter().all(|value| value.is_finite()));
            let question = r#"{"foundation":{"base":{"shear_modulus":1.0,"poisson":0.3}},
                "sole":{"shape":"rectangle","width_x":2.0,"width_y":1.0},"mesh":[2,1]}"#;
            let states = vec![NormalCase::Closed, NormalCase::Open];
            let job = Job::Branch {
                question: serde_json::from_str(question).unwrap(),
                branch: Branch { mu: 1.25, states, forms: vec![form.clone()] },
            };
            let Ok(Job::Branch { branch, .. }) = Job::parse(&job.canonical()) else {
                return Err(TestCaseError::fail("it is another job"));
            };
            let found: Vec<u32> = branch.forms[0].iter().map(|value| value.to_bits()).collect();
            prop_assert_eq!(found, form.iter().map(|value| value.to_bits()).collect::<Vec<_>>());
        }

        /// The text travels to another process; the last bit of every number must arrive.
        #[test]
        fn numbers_travel_bit_for_bit(
            modulus in 1e-300..1e300f64,
            mu in 0.0..10.0f64,
            approach: f64,
        ) {
            prop_assume!(approach.is_finite());
            let job = with(|Case { scene, .. }| {
                scene.foundation.base =
                    Base::Elastic(Material { shear_modulus: modulus, poisson: 0.3 });
                scene.friction.mu = mu;
                scene.loading.steps[0].approach = Some(approach);
            });
            let back = Job::parse(&job.canonical());
            prop_assert_eq!(back.ok(), Some(job));
        }
    }
}
