//! The one list of the works that the method and the effects are taken from.
//!
//! [`sources`] says for every [`CitedSubject`] which works treat it, or what was derived here. The
//! comments of the code cite the same works where they use them.

use serde::Serialize;

use crate::model::Effect;

/// A work that can be cited.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct CitedWork {
    /// The name in a bibliography: the first author and the year.
    pub key: &'static str,
    /// The form of the publication.
    pub form: WorkForm,
    /// The authors, each with the family name first.
    pub authors: &'static [&'static str],
    /// The title.
    pub title: &'static str,
    /// The journal, or the publisher of a book.
    pub published_in: &'static str,
    /// The volume; empty if there is none.
    pub volume: &'static str,
    /// The pages; empty if the work is cited as a whole.
    pub pages: &'static str,
    /// The year; `None` if the source of the citation has none.
    pub year: Option<u32>,
    /// The digital object identifier; `None` if the sources of this project have none.
    pub doi: Option<&'static str>,
}

/// The form of a publication.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum WorkForm {
    /// A paper in a journal.
    Article,
    /// A book.
    Book,
    /// A program.
    Software,
}

/// A part of the program that has sources.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum CitedSubject {
    /// The equation that is solved and its discretisation.
    Equation,
    /// Newton's method and its linear solver.
    Newton,
    /// Seidel's iteration.
    Seidel,
    /// An effect that is simulated.
    Effect(Effect),
    /// The mirror planes, where an asymmetry is left out.
    MirrorPlanes,
    /// The surface through the pixels of a height map.
    HeightMap,
    /// The smoothing of the profiles of a wheel and a rail.
    Profiles,
    /// The creepages that follow from the motion of a wheelset.
    WheelCreepages,
    /// The limit of a ladder of meshes, and its uncertainty.
    Ladder,
    /// The search for several solutions.
    Multiplicity,
    /// The ends of uniqueness sets.
    Uniqueness,
    /// The ends of uniqueness sets of strips.
    Strips,
    /// The search for the places at which a result takes a value.
    Roots,
    /// The points that are added where a curve or a map bends.
    Filling,
    /// Intervals of what the points of a sample say.
    Bootstrap,
    /// The shares of the variance that keys make.
    SobolIndices,
    /// The elementary effects of keys.
    ElementaryEffects,
}

impl CitedSubject {
    /// Returns every subject.
    pub fn all() -> Vec<CitedSubject> {
        let effects = Effect::ALL.map(CitedSubject::Effect);
        let before = [CitedSubject::Equation, CitedSubject::Newton, CitedSubject::Seidel];
        let after = [
            CitedSubject::MirrorPlanes,
            CitedSubject::HeightMap,
            CitedSubject::Profiles,
            CitedSubject::WheelCreepages,
            CitedSubject::Ladder,
            CitedSubject::Multiplicity,
            CitedSubject::Uniqueness,
            CitedSubject::Strips,
            CitedSubject::Roots,
            CitedSubject::Filling,
            CitedSubject::Bootstrap,
            CitedSubject::SobolIndices,
            CitedSubject::ElementaryEffects,
        ];
        [&before[..], &effects, &after].concat()
    }

    /// Returns what it is called in a list of references.
    pub fn title(self) -> &'static str {
        match self {
            CitedSubject::Equation => "equation",
            CitedSubject::Newton => "newton",
            CitedSubject::Seidel => "seidel",
            CitedSubject::Effect(effect) => effect.name(),
            CitedSubject::MirrorPlanes => "mirror planes",
            CitedSubject::HeightMap => "height map",
            CitedSubject::Profiles => "profiles",
            CitedSubject::WheelCreepages => "creepages of a wheel",
            CitedSubject::Ladder => "ladder of meshes",
            CitedSubject::Multiplicity => "multiplicity",
            CitedSubject::Uniqueness => "uniqueness",
            CitedSubject::Strips => "uniqueness of strips",
            CitedSubject::Roots => "finding roots",
            CitedSubject::Filling => "filling of curves and maps",
            CitedSubject::Bootstrap => "intervals of samples",
            CitedSubject::SobolIndices => "sobol indices",
            CitedSubject::ElementaryEffects => "elementary effects",
        }
    }
}

/// The sources of a subject.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sources {
    /// The works.
    pub works: &'static [&'static CitedWork],
    /// The part that was derived in this project; empty if the works have everything.
    pub derived: &'static str,
}

/// Returns the sources of a subject: works, or what was derived here, or both.
pub fn sources(subject: CitedSubject) -> Sources {
    let works = |works: &'static [&'static CitedWork]| Sources { works, derived: "" };
    let derived = |derived: &'static str| Sources { works: &[], derived };
    match subject {
        CitedSubject::Equation => works(&[&ALEXANDROV, &JOHNSON]),
        CitedSubject::Newton => Sources {
            works: &[&CHRISTENSEN, &SAAD, &DANIEL, &CHAN],
            derived: "the reduction to the unknowns of contact and the preconditioner",
        },
        CitedSubject::Seidel => Sources {
            works: &[&ALEXANDROV],
            derived: "one step length for both tangential rows, where elements are not square",
        },
        CitedSubject::Effect(Effect::Friction) => works(&[&ALEXANDROV]),
        CitedSubject::Effect(Effect::Coupling) => works(&[&JOHNSON]),
        CitedSubject::Effect(Effect::TractionX | Effect::TractionY) => {
            derived("the conditions under which one direction of traction stays empty")
        }
        CitedSubject::Effect(Effect::AsymmetryX | Effect::AsymmetryY) => {
            derived("the conditions under which the two sides of the domain are mirror images")
        }
        CitedSubject::Effect(Effect::Layers) => Sources {
            works: &[&TALMAN],
            derived: "the surface compliance of bonded layers by decaying exponentials only",
        },
        CitedSubject::Effect(Effect::Regularisation | Effect::Ceiling) => works(&[&ALEXANDROV]),
        CitedSubject::Effect(Effect::History) => {
            derived("the equation of an increment, with slip counted from the increment before")
        }
        CitedSubject::Effect(Effect::LoadControl) => {
            derived("the motions that forces govern as unknowns beside the tractions")
        }
        CitedSubject::Effect(Effect::Wear) => Sources {
            works: &[&ARCHARD, &MCCOLL],
            derived: "the depth on the material that passes through a rolling contact, and the \
                      bound up to which the pressure follows the shape that wears",
        },
        CitedSubject::Effect(Effect::Rolling) => Sources {
            works: &[&CARTER, &KALKER_THESIS, &KALKER, &VERMEULEN, &SHEN],
            derived: "the operator of what is steady, evaluated between elements, and its \
                      preconditioner, which sums tractions from the leading edge; the \
                      coefficients of the linear theory by spherical harmonics",
        },
        CitedSubject::Effect(Effect::Interior) => Sources {
            works: &[&LOVE, &JOHNSON, &TALMAN],
            derived: "the stresses at a depth of bonded layers in the Fourier plane, without \
                      differences of large numbers, and the climb to the largest ones",
        },
        CitedSubject::MirrorPlanes => works(&[&MAKHOUL]),
        CitedSubject::HeightMap => works(&[&AKIMA_ROW, &AKIMA_SURFACE]),
        CitedSubject::Profiles => works(&[&REINSCH]),
        CitedSubject::WheelCreepages => Sources {
            works: &[&VOLLEBREGT],
            derived: "the vertical velocity with which the wheel stays on its rail",
        },
        CitedSubject::Ladder => works(&[&ROACHE, &ECA]),
        CitedSubject::Multiplicity => works(&[&FARRELL, &STEELE]),
        CitedSubject::Uniqueness => Sources {
            works: &[&ALEXANDROV, &KNYAZEV, &NOCEDAL, &LEWIS],
            derived: "both sides of the bracket: the certificate below and the witness above",
        },
        CitedSubject::Strips => Sources {
            works: &[&JOLDES],
            derived: "the determinants whose signs decide, and the order of their elimination",
        },
        CitedSubject::Roots => works(&[&OLIVEIRA, &CHANDRUPATLA]),
        CitedSubject::Filling => Sources {
            works: &[&NIJHOLT, &BABUSKA],
            derived: "halved cells in place of triangles, and their estimated deviation",
        },
        CitedSubject::Bootstrap => works(&[&EFRON]),
        CitedSubject::SobolIndices => works(&[&SOBOL, &SALTELLI, &JANSEN]),
        CitedSubject::ElementaryEffects => works(&[&MORRIS, &CAMPOLONGO]),
    }
}

const ALEXANDROV: CitedWork = CitedWork {
    key: "alexandrov",
    form: WorkForm::Article,
    authors: &["Alexandrov, A. I."],
    title: "The solution of elastic contact problems with the use of nonlinear integral equations",
    published_in: "Reports of the National Academy of Sciences of Ukraine",
    volume: "",
    pages: "",
    year: None,
    doi: None,
};

const JOHNSON: CitedWork = CitedWork {
    key: "johnson1985",
    form: WorkForm::Book,
    authors: &["Johnson, K. L."],
    title: "Contact Mechanics",
    published_in: "Cambridge University Press",
    volume: "",
    pages: "",
    year: Some(1985),
    doi: None,
};

const ARCHARD: CitedWork = CitedWork {
    key: "archard1953",
    form: WorkForm::Article,
    authors: &["Archard, J. F."],
    title: "Contact and Rubbing of Flat Surfaces",
    published_in: "Journal of Applied Physics",
    volume: "24",
    pages: "981–988",
    year: Some(1953),
    doi: Some("10.1063/1.1721448"),
};

const MCCOLL: CitedWork = CitedWork {
    key: "mccoll2004",
    form: WorkForm::Article,
    authors: &["McColl, I. R.", "Ding, J.", "Leen, S. B."],
    title: "Finite element simulation and experimental validation of fretting wear",
    published_in: "Wear",
    volume: "256",
    pages: "1114–1127",
    year: Some(2004),
    doi: Some("10.1016/j.wear.2003.07.001"),
};

const LOVE: CitedWork = CitedWork {
    key: "love1929",
    form: WorkForm::Article,
    authors: &["Love, A. E. H."],
    title: "The stress produced in a semi-infinite solid by pressure on part of the boundary",
    published_in: "Philosophical Transactions of the Royal Society A",
    volume: "228",
    pages: "377–420",
    year: Some(1929),
    doi: Some("10.1098/rsta.1929.0009"),
};

const KALKER: CitedWork = CitedWork {
    key: "kalker1990",
    form: WorkForm::Book,
    authors: &["Kalker, J. J."],
    title: "Three-Dimensional Elastic Bodies in Rolling Contact",
    published_in: "Kluwer Academic Publishers",
    volume: "",
    pages: "",
    year: Some(1990),
    doi: Some("10.1007/978-94-015-7889-9"),
};

const KALKER_THESIS: CitedWork = CitedWork {
    key: "kalker1967",
    form: WorkForm::Book,
    authors: &["Kalker, J. J."],
    title: "On the Rolling Contact of Two Elastic Bodies in the Presence of Dry Friction",
    published_in: "Delft University of Technology",
    volume: "",
    pages: "",
    year: Some(1967),
    doi: None,
};

const CARTER: CitedWork = CitedWork {
    key: "carter1926",
    form: WorkForm::Article,
    authors: &["Carter, F. W."],
    title: "On the action of a locomotive driving wheel",
    published_in: "Proceedings of the Royal Society A",
    volume: "112",
    pages: "151–157",
    year: Some(1926),
    doi: Some("10.1098/rspa.1926.0100"),
};

const VERMEULEN: CitedWork = CitedWork {
    key: "vermeulen1964",
    form: WorkForm::Article,
    authors: &["Vermeulen, P. J.", "Johnson, K. L."],
    title: "Contact of nonspherical elastic bodies transmitting tangential forces",
    published_in: "Journal of Applied Mechanics",
    volume: "31",
    pages: "338–340",
    year: Some(1964),
    doi: Some("10.1115/1.3629610"),
};

const SHEN: CitedWork = CitedWork {
    key: "shen1983",
    form: WorkForm::Article,
    authors: &["Shen, Z. Y.", "Hedrick, J. K.", "Elkins, J. A."],
    title: "A comparison of alternative creep force models for rail vehicle dynamic analysis",
    published_in: "Vehicle System Dynamics",
    volume: "12",
    pages: "79–83",
    year: Some(1983),
    doi: Some("10.1080/00423118308968725"),
};

const VOLLEBREGT: CitedWork = CitedWork {
    key: "vollebregt2022",
    form: WorkForm::Article,
    authors: &["Vollebregt, E. A. H."],
    title: "Detailed wheel/rail geometry processing using the planar contact approach",
    published_in: "Vehicle System Dynamics",
    volume: "60",
    pages: "1253–1291",
    year: Some(2022),
    doi: Some("10.1080/00423114.2020.1853180"),
};

const CHRISTENSEN: CitedWork = CitedWork {
    key: "christensen1998",
    form: WorkForm::Article,
    authors: &["Christensen, P. W.", "Klarbring, A.", "Pang, J. S.", "Strömberg, N."],
    title: "Formulation and comparison of algorithms for frictional contact problems",
    published_in: "International Journal for Numerical Methods in Engineering",
    volume: "42",
    pages: "145–173",
    year: Some(1998),
    doi: Some("10.1002/(SICI)1097-0207(19980515)42:1<145::AID-NME358>3.0.CO;2-L"),
};

const SAAD: CitedWork = CitedWork {
    key: "saad1986",
    form: WorkForm::Article,
    authors: &["Saad, Y.", "Schultz, M. H."],
    title: "GMRES: a generalized minimal residual algorithm for solving nonsymmetric linear systems",
    published_in: "SIAM Journal on Scientific and Statistical Computing",
    volume: "7",
    pages: "856–869",
    year: Some(1986),
    doi: Some("10.1137/0907058"),
};

const DANIEL: CitedWork = CitedWork {
    key: "daniel1976",
    form: WorkForm::Article,
    authors: &["Daniel, J. W.", "Gragg, W. B.", "Kaufman, L.", "Stewart, G. W."],
    title: "Reorthogonalization and stable algorithms for updating the Gram–Schmidt QR factorization",
    published_in: "Mathematics of Computation",
    volume: "30",
    pages: "772–795",
    year: Some(1976),
    doi: Some("10.1090/S0025-5718-1976-0431641-8"),
};

const CHAN: CitedWork = CitedWork {
    key: "chan1988",
    form: WorkForm::Article,
    authors: &["Chan, T. F."],
    title: "An optimal circulant preconditioner for Toeplitz systems",
    published_in: "SIAM Journal on Scientific and Statistical Computing",
    volume: "9",
    pages: "766–771",
    year: Some(1988),
    doi: Some("10.1137/0909051"),
};

const MAKHOUL: CitedWork = CitedWork {
    key: "makhoul1980",
    form: WorkForm::Article,
    authors: &["Makhoul, J."],
    title: "A fast cosine transform in one and two dimensions",
    published_in: "IEEE Transactions on Acoustics, Speech, and Signal Processing",
    volume: "28",
    pages: "27–34",
    year: Some(1980),
    doi: Some("10.1109/TASSP.1980.1163351"),
};

const TALMAN: CitedWork = CitedWork {
    key: "talman1978",
    form: WorkForm::Article,
    authors: &["Talman, J. D."],
    title: "Numerical Fourier and Bessel transforms in logarithmic variables",
    published_in: "Journal of Computational Physics",
    volume: "29",
    pages: "35–48",
    year: Some(1978),
    doi: None,
};

const AKIMA_ROW: CitedWork = CitedWork {
    key: "akima1970",
    form: WorkForm::Article,
    authors: &["Akima, H."],
    title: "A new method of interpolation and smooth curve fitting based on local procedures",
    published_in: "Journal of the ACM",
    volume: "17",
    pages: "589–602",
    year: Some(1970),
    doi: Some("10.1145/321607.321609"),
};

const AKIMA_SURFACE: CitedWork = CitedWork {
    key: "akima1974",
    form: WorkForm::Article,
    authors: &["Akima, H."],
    title: "A method of bivariate interpolation and smooth surface fitting based on local procedures",
    published_in: "Communications of the ACM",
    volume: "17",
    pages: "18–20",
    year: Some(1974),
    doi: Some("10.1145/360767.360779"),
};

const REINSCH: CitedWork = CitedWork {
    key: "reinsch1967",
    form: WorkForm::Article,
    authors: &["Reinsch, C. H."],
    title: "Smoothing by spline functions",
    published_in: "Numerische Mathematik",
    volume: "10",
    pages: "177–183",
    year: Some(1967),
    doi: Some("10.1007/BF02162161"),
};

const ROACHE: CitedWork = CitedWork {
    key: "roache1997",
    form: WorkForm::Article,
    authors: &["Roache, P. J."],
    title: "Quantification of uncertainty in computational fluid dynamics",
    published_in: "Annual Review of Fluid Mechanics",
    volume: "29",
    pages: "123–160",
    year: Some(1997),
    doi: Some("10.1146/annurev.fluid.29.1.123"),
};

const ECA: CitedWork = CitedWork {
    key: "eca2014",
    form: WorkForm::Article,
    authors: &["Eça, L.", "Hoekstra, M."],
    title: "A procedure for the estimation of the numerical uncertainty of CFD calculations based \
            on grid refinement studies",
    published_in: "Journal of Computational Physics",
    volume: "262",
    pages: "104–130",
    year: Some(2014),
    doi: Some("10.1016/j.jcp.2014.01.006"),
};

const FARRELL: CitedWork = CitedWork {
    key: "farrell2015",
    form: WorkForm::Article,
    authors: &["Farrell, P. E.", "Birkisson, Á.", "Funke, S. W."],
    title: "Deflation techniques for finding distinct solutions of nonlinear partial differential \
            equations",
    published_in: "SIAM Journal on Scientific Computing",
    volume: "37",
    pages: "A2026–A2045",
    year: Some(2015),
    doi: Some("10.1137/140984798"),
};

const STEELE: CitedWork = CitedWork {
    key: "steele2014",
    form: WorkForm::Article,
    authors: &["Steele, G. L.", "Lea, D.", "Flood, C. H."],
    title: "Fast splittable pseudorandom number generators",
    published_in: "ACM SIGPLAN Notices",
    volume: "49",
    pages: "453–472",
    year: Some(2014),
    doi: Some("10.1145/2714064.2660195"),
};

const KNYAZEV: CitedWork = CitedWork {
    key: "knyazev2001",
    form: WorkForm::Article,
    authors: &["Knyazev, A. V."],
    title: "Toward the optimal preconditioned eigensolver: locally optimal block preconditioned \
            conjugate gradient method",
    published_in: "SIAM Journal on Scientific Computing",
    volume: "23",
    pages: "517–541",
    year: Some(2001),
    doi: None,
};

const NOCEDAL: CitedWork = CitedWork {
    key: "nocedal2006",
    form: WorkForm::Book,
    authors: &["Nocedal, J.", "Wright, S. J."],
    title: "Numerical Optimization, 2nd edition",
    published_in: "Springer",
    volume: "",
    pages: "",
    year: Some(2006),
    doi: None,
};

const JOLDES: CitedWork = CitedWork {
    key: "joldes2017",
    form: WorkForm::Article,
    authors: &["Joldes, M.", "Muller, J.-M.", "Popescu, V."],
    title: "Tight and rigorous error bounds for basic building blocks of double-word arithmetic",
    published_in: "ACM Transactions on Mathematical Software",
    volume: "44",
    pages: "15res",
    year: Some(2017),
    doi: Some("10.1145/3121432"),
};

const LEWIS: CitedWork = CitedWork {
    key: "lewis2013",
    form: WorkForm::Article,
    authors: &["Lewis, A. S.", "Overton, M. L."],
    title: "Nonsmooth optimization via quasi-Newton methods",
    published_in: "Mathematical Programming",
    volume: "141",
    pages: "135–163",
    year: Some(2013),
    doi: None,
};

const OLIVEIRA: CitedWork = CitedWork {
    key: "oliveira2020",
    form: WorkForm::Article,
    authors: &["Oliveira, I. F. D.", "Takahashi, R. H. C."],
    title: "An enhancement of the bisection method average performance preserving minmax \
            optimality",
    published_in: "ACM Transactions on Mathematical Software",
    volume: "47",
    pages: "5:1–5:24",
    year: Some(2020),
    doi: Some("10.1145/3423597"),
};

const CHANDRUPATLA: CitedWork = CitedWork {
    key: "chandrupatla1997",
    form: WorkForm::Article,
    authors: &["Chandrupatla, T. R."],
    title: "A new hybrid quadratic/bisection algorithm for finding the zero of a nonlinear function \
            without using derivatives",
    published_in: "Advances in Engineering Software",
    volume: "28",
    pages: "145–149",
    year: Some(1997),
    doi: Some("10.1016/S0965-9978(96)00051-8"),
};

const NIJHOLT: CitedWork = CitedWork {
    key: "nijholt2019",
    form: WorkForm::Software,
    authors: &["Nijholt, B.", "Weston, J.", "Hoofwijk, J.", "Akhmerov, A."],
    title: "Adaptive: parallel active learning of mathematical functions",
    published_in: "Zenodo",
    volume: "",
    pages: "",
    year: Some(2019),
    doi: Some("10.5281/zenodo.1182437"),
};

const BABUSKA: CitedWork = CitedWork {
    key: "babuska1984",
    form: WorkForm::Article,
    authors: &["Babuška, I.", "Vogelius, M."],
    title: "Feedback and adaptive finite element solution of one-dimensional boundary value \
            problems",
    published_in: "Numerische Mathematik",
    volume: "44",
    pages: "75–102",
    year: Some(1984),
    doi: Some("10.1007/BF01389757"),
};

const EFRON: CitedWork = CitedWork {
    key: "efron1979",
    form: WorkForm::Article,
    authors: &["Efron, B."],
    title: "Bootstrap methods: another look at the jackknife",
    published_in: "The Annals of Statistics",
    volume: "7",
    pages: "1–26",
    year: Some(1979),
    doi: Some("10.1214/aos/1176344552"),
};

const SOBOL: CitedWork = CitedWork {
    key: "sobol2001",
    form: WorkForm::Article,
    authors: &["Sobol', I. M."],
    title: "Global sensitivity indices for nonlinear mathematical models and their Monte Carlo \
            estimates",
    published_in: "Mathematics and Computers in Simulation",
    volume: "55",
    pages: "271–280",
    year: Some(2001),
    doi: Some("10.1016/S0378-4754(00)00270-6"),
};

const SALTELLI: CitedWork = CitedWork {
    key: "saltelli2010",
    form: WorkForm::Article,
    authors: &[
        "Saltelli, A.",
        "Annoni, P.",
        "Azzini, I.",
        "Campolongo, F.",
        "Ratto, M.",
        "Tarantola, S.",
    ],
    title: "Variance based sensitivity analysis of model output. Design and estimator for the \
            total sensitivity index",
    published_in: "Computer Physics Communications",
    volume: "181",
    pages: "259–270",
    year: Some(2010),
    doi: Some("10.1016/j.cpc.2009.09.018"),
};

const JANSEN: CitedWork = CitedWork {
    key: "jansen1999",
    form: WorkForm::Article,
    authors: &["Jansen, M. J. W."],
    title: "Analysis of variance designs for model output",
    published_in: "Computer Physics Communications",
    volume: "117",
    pages: "35–43",
    year: Some(1999),
    doi: Some("10.1016/S0010-4655(98)00154-4"),
};

const MORRIS: CitedWork = CitedWork {
    key: "morris1991",
    form: WorkForm::Article,
    authors: &["Morris, M. D."],
    title: "Factorial sampling plans for preliminary computational experiments",
    published_in: "Technometrics",
    volume: "33",
    pages: "161–174",
    year: Some(1991),
    doi: Some("10.1080/00401706.1991.10484804"),
};

const CAMPOLONGO: CitedWork = CitedWork {
    key: "campolongo2007",
    form: WorkForm::Article,
    authors: &["Campolongo, F.", "Cariboni, J.", "Saltelli, A."],
    title: "An effective screening design for sensitivity analysis of large models",
    published_in: "Environmental Modelling & Software",
    volume: "22",
    pages: "1509–1518",
    year: Some(2007),
    doi: Some("10.1016/j.envsoft.2006.10.004"),
};

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// Returns true if a text has the form of a DOI: 10, four to nine digits, and a suffix without
    /// blanks.
    fn is_doi(text: &str) -> bool {
        let Some((registrant, suffix)) =
            text.strip_prefix("10.").and_then(|rest| rest.split_once('/'))
        else {
            return false;
        };
        (4..=9).contains(&registrant.len())
            && registrant.bytes().all(|byte| byte.is_ascii_digit())
            && !suffix.is_empty()
            && suffix.bytes().all(|byte| byte.is_ascii_graphic())
    }

    #[test]
    fn every_subject_has_a_source_or_was_derived_here() {
        for subject in CitedSubject::all() {
            let Sources { works, derived } = sources(subject);
            assert!(!works.is_empty() || !derived.is_empty(), "{subject:?}");
        }
        for effect in Effect::ALL {
            assert!(CitedSubject::all().contains(&CitedSubject::Effect(effect)), "{effect:?}");
        }
    }

    #[test]
    fn works_are_cited_in_full_and_named_once() {
        let mut known: BTreeMap<&str, &CitedWork> = BTreeMap::new();
        for work in CitedSubject::all().into_iter().flat_map(|subject| sources(subject).works) {
            assert_eq!(**known.entry(work.key).or_insert(work), **work, "{}", work.key);
        }
        for work in known.values() {
            assert!(!work.authors.is_empty() && !work.title.is_empty(), "{work:?}");
            assert!(work.authors.iter().all(|author| author.contains(", ")), "{work:?}");
            assert!(!work.published_in.is_empty(), "{work:?}");
            assert!(work.doi.is_none_or(is_doi), "{work:?}");
            let is_placed = work.form != WorkForm::Article || !work.volume.is_empty();
            assert!(is_placed || work.key == "alexandrov", "{work:?}");
            let year = work.year.map(|year| year.to_string()).unwrap_or_default();
            assert!(work.key.ends_with(&year), "{work:?}");
        }
        let dois: Vec<&str> = known.values().filter_map(|work| work.doi).collect();
        assert!(dois.len() >= 10, "{dois:?}");
        for (text, expected) in
            [("10.1137/0907058", true), ("10.1/x", false), ("10.1137/", false), ("x", false)]
        {
            assert_eq!(is_doi(text), expected, "{text}");
        }
    }

    /// The list and the comments of the code say the same.
    #[test]
    fn every_doi_of_the_list_stands_where_the_work_is_used() {
        fn texts(directory: &std::path::Path, found: &mut String) {
            for entry in std::fs::read_dir(directory).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    texts(&path, found);
                } else if path.extension().is_some_and(|end| end == "rs")
                    && !path.ends_with("literature.rs")
                {
                    found.push_str(&std::fs::read_to_string(&path).unwrap());
                }
            }
        }
        let mut code = String::new();
        // The crates beside this one use some of the works.
        texts(&std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(".."), &mut code);
        for work in CitedSubject::all().into_iter().flat_map(|subject| sources(subject).works) {
            assert!(work.doi.is_none_or(|doi| code.contains(doi)), "{work:?}");
        }
    }
}
