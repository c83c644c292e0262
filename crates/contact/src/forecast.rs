//! Forecasts of the time and the memory of a solve before it runs. They serve plans, the order of
//! jobs and their deadlines, and never results.

use std::hash::{DefaultHasher, Hash, Hasher};

use crate::foundation::relative_bodies;
use crate::interior;
use crate::model::{
    Effect, InteriorQuestion, Method, Numerics, RollingDirection, Scene, SceneError, Shape, refuse,
};
use crate::multiplicity::{Multiplicity, Search};
use crate::problem::{Effects, Layout, Operators, check_distances, on_grid};
use crate::punch::{Surfaces, domain};
use crate::uniqueness::branch::Branch;
use crate::uniqueness::{Question, WitnessSearch, lower};

/// The forecast of the time and the memory of a solve by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forecast {
    /// The numbers of elements along x and y.
    pub elements: [usize; 2],
    /// The number of increments of the path.
    pub increments: u64,
    /// The number of unknowns of all stages together, without those of effects that the scene does
    /// not call for.
    pub unknowns: usize,
    /// The time on a processor of about 2020, within a factor of a few \[s\].
    pub seconds: f64,
    /// The part of the time that the operator takes \[s\]. Of jobs that share one, and that a
    /// worker does one after another, only the first takes it.
    pub assembly: f64,
    /// The memory for operator and fields \[bytes\].
    pub memory: u64,
    /// A hint at the operator: scenes with the same number mostly share an operator, and those with
    /// different ones mostly do not. The parts that are left out of a solve, by mirror planes for
    /// one, make operators differ that have the same number here.
    pub operator: u64,
}

/// Forecasts the solution of a scene.
///
/// # Errors
/// A [`SceneError`] reports a scene that cannot be laid out on a grid, as
/// [`Problem::new`](crate::problem::Problem::new) would.
pub fn forecast(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
) -> Result<Forecast, SceneError> {
    let scene = &*on_grid(scene, numerics, surfaces)?;
    let domain = domain(scene, surfaces)?;
    let layout = Layout::new(scene, numerics, &domain);
    let bodies = relative_bodies(scene, layout.half_diameter);
    layout.scale(scene, &bodies)?;
    let element = layout.element.map(|side| side * layout.half_diameter);
    numerics.suit(&scene.loading)?;
    layout.check_reach(scene)?;
    check_distances(scene, element[0])?;
    if let Some(question) = &scene.interior {
        let size = [layout.nx as f64 * element[0], layout.ny as f64 * element[1]];
        let middle = [domain.center_x, domain.center_y];
        question.check_places(middle, size, element[0].min(element[1]))?;
    }
    let elements = layout.nx as f64 * layout.ny as f64;

    let mut hasher = DefaultHasher::new();
    (layout.nx, layout.ny, layout.element.map(f64::to_bits), numerics.projection).hash(&mut hasher);
    bodies.scaled(1.0 / bodies.reference_compliance()).hash_numbers(&mut hasher);
    // The mask is part of the operator.
    let sole = match scene.punch.shape {
        Shape::FlatRectangle { .. }
        | Shape::FlatDisk { .. }
        | Shape::HeightMap { .. }
        | Shape::WheelOnRail(_) => std::mem::discriminant(&scene.punch.shape),
        Shape::Sphere { .. } | Shape::Ellipsoid { .. } | Shape::Cone { .. } => {
            std::mem::discriminant(&Shape::Cone { angle: 0.0 })
        }
    };
    sole.hash(&mut hasher);
    // Each distance that is rolled has an operator of its own.
    let legs = scene.loading.legs();
    let mut rolled: Vec<(Option<u64>, RollingDirection)> = Vec::new();
    for rolling in legs.iter().filter_map(|leg| leg.rolling) {
        let distance = (rolling.dq.map(f64::to_bits), rolling.direction);
        if !rolled.contains(&distance) {
            rolled.push(distance);
            (distance.0, rolling.direction == RollingDirection::Forward).hash(&mut hasher);
        }
    }

    let effects = Effects::of(scene, numerics, [layout.nx, layout.ny], surfaces)?;
    let increments = scene.loading.increments();
    let method = numerics.method.chosen(&scene.loading, [layout.nx, layout.ny]).method;
    let unknowns = match method {
        Method::Seidel => 3 * layout.nx * layout.ny,
        Method::Newton | Method::Auto => {
            effects.stages(scene).iter().map(|stage| stage.unknowns([layout.nx, layout.ny])).sum()
        }
    };
    let rolled = if effects.has(Effect::Rolling) { rolled.len() as f64 } else { 0.0 };
    // The coefficients and their symbols (measured over the sweeps, from 8² to 128²).
    let is_layered = bodies.layers.is_some();
    let assembly = match is_layered {
        true => 8e-3 + 3.5e-6 * elements,
        false => 5e-4 + 3e-7 * elements,
    };
    let seconds = match method {
        // There are 3 ns per pair of a receiver and a source in contact, and about
        // 0.3·log₁₀(1/tolerance)·√k sweeps (measured on spheres and disks).
        Method::Seidel => {
            3e-9 * 0.5
                * elements
                * elements
                * 0.3
                * numerics.tolerance.log10().abs()
                * elements.sqrt()
        }
        // There are 42 applications and as many preconditionings, which together take 0.055 µs for
        // each unknown (measured on spheres up to 256², on a wheel up to 160 × 206, and over the
        // sweeps).
        Method::Newton | Method::Auto => 42.0 * 5.5e-8 * unknowns as f64,
    };
    // An increment that rolls takes so many times as long as another. On its way a path begins each
    // increment with what the one before has left (measured from 32² to 256² on like and unlike
    // bodies and on layers, with and without spin; within a factor of 2).
    let finer = (elements / 4096.0).max(1.0);
    let (steady, passing) = (1.1 * finer.powf(0.1), 0.3 * finer.powf(0.05));
    let rolling = legs.iter().filter(|leg| leg.rolling.is_some() && rolled > 0.0);
    let [mut steady_legs, mut slower] = [0.0; 2];
    for leg in rolling {
        match leg.is_steady() {
            true => (steady_legs, slower) = (steady_legs + 1.0, slower + steady - 1.0),
            false => slower += (passing - 1.0) * f64::from(leg.increments),
        }
    }
    let solves = increments as f64 + slower;
    let interior = scene
        .interior
        .as_ref()
        .map_or(Default::default(), |question| forecast_interior(scene, question, &layout));
    // To place a wheel on its rail takes as long as some thousand elements take to solve.
    let set_up = match scene.punch.shape {
        Shape::WheelOnRail(_) => 4e-3 + 1.5e-7 * elements,
        _ => 0.0,
    };
    // The memory holds table and symbols of the certificate's operator and of the solver's, a dozen
    // whole fields, and forty Krylov vectors.
    let memory = 8.0 * ((16.0 + 12.0 + 40.0) * elements + 46.0 * unknowns as f64);
    // Each distance that is rolled has a table, and symbols without symmetry; in steady rolling
    // the solver's operator has such symbols too. Of many, those used last are kept. The
    // certificate keeps the influences on two places of the distance rolled last.
    let operator = 8.0 * (16.0 + 72.0) * elements;
    let kept = (operator * rolled).min(Operators::BUDGET as f64 + operator)
        + if rolled > 0.0 { 8.0 * 14.0 * elements } else { 0.0 };
    let memory = memory + kept + if steady_legs > 0.0 { 8.0 * 24.0 * unknowns as f64 } else { 0.0 };
    // A height map holds a height and four numbers for the slopes of each pixel, and a search for
    // its highest point two more.
    let pixels = match &scene.punch.shape {
        Shape::HeightMap { surface, .. } => {
            surfaces.get(surface).map_or(0, |map| map.columns() * map.rows())
        }
        _ => 0,
    };
    let memory = memory + 56.0 * pixels as f64;
    let memory = memory + interior.bytes;
    // In layers the certificate of what rolls takes about as long as another table, in each job
    // anew (measured on 40²).
    let rolled_again = if is_layered { assembly * rolled } else { 0.0 };
    let assembly = assembly * (1.0 + rolled);
    let seconds = interior.seconds + set_up + assembly + rolled_again + seconds * solves + 2.5e-4;
    Ok(Forecast {
        elements: [layout.nx, layout.ny],
        increments,
        unknowns,
        seconds,
        assembly,
        memory: memory as u64,
        operator: hasher.finish(),
    })
}

/// The time and the memory that stresses below the surface take.
#[derive(Clone, Copy, Debug, Default)]
struct InteriorForecast {
    seconds: f64,
    bytes: f64,
}

/// Forecasts the stresses below the surface, for a contact that fills three fifths of Ω, as those
/// do whose Ω is chosen.
fn forecast_interior(
    scene: &Scene,
    InteriorQuestion { maximum, depths, points }: &InteriorQuestion,
    layout: &Layout,
) -> InteriorForecast {
    let elements = (layout.nx * layout.ny) as f64;
    let is_layered = relative_bodies(scene, 1.0).layers.is_some();
    // A plane, and a point per element under load (measured on spheres from 64² to 256²); layers
    // have tables for each depth.
    let [plane, point, table] = if is_layered { PLANE_IN_LAYERS } else { PLANE_IN_HALF_SPACE };
    let loaded = 0.6 * elements;
    let searched = if !maximum {
        0
    } else {
        // A contact that fills Ω is some 0.4 Ω in radius.
        let [hx, hy] = layout.element.map(|side| side * layout.half_diameter);
        let radius = 0.4 * (layout.nx as f64 * hx).min(layout.ny as f64 * hy);
        let deepest = depths.iter().copied().fold(0.0, f64::max);
        1 + interior::depths_searched(&scene.foundation, radius, hx.max(hy), deepest)
    };
    // The climbs to two largest stresses take some forty places each, at ten depths.
    let climbs = if *maximum { 2.0 } else { 0.0 };
    let planes = (depths.len() + searched) as f64;
    // Some points are computed again, by quarters of elements, and the loads at some depths have
    // tables of their own.
    let checked = points.len().min(16) as f64;
    let balanced = depths.len() as f64 + checked + climbs;
    let places = points.len() as f64 + 4.0 * checked + 40.0 * climbs;
    let tables = planes + points.len() as f64 + checked + 2.0 * balanced + 20.0 * climbs;
    let seconds = planes * plane * elements + places * point * loaded + tables * table;
    // A plane has its stresses, the blocks of its elements, and spectra of four times as many
    // elements for three loads and six stresses; a search keeps two measures of every plane.
    let fields = 18.0 + 8.0 + 4.0 * (3.0 + 2.0 * 6.0);
    let bytes = 8.0 * elements * (fields + 2.0 * searched as f64);
    InteriorForecast { seconds, bytes }
}

/// The seconds per element of a plane, per loaded element of a point, and for a depth.
const PLANE_IN_HALF_SPACE: [f64; 3] = [1.1e-6, 2.7e-7, 0.0];

/// The seconds per element of a plane, per loaded element of a point, and for a depth, in layers.
const PLANE_IN_LAYERS: [f64; 3] = [4.4e-6, 3.3e-6, 0.027];

/// Forecasts a search for every solution of a scene.
///
/// # Errors
/// A [`SceneError`] reports a scene that cannot be laid out on a grid, has too many elements to be
/// searched, or a search with too many starts.
pub fn forecast_search(
    scene: &Scene,
    numerics: &Numerics,
    surfaces: &Surfaces,
    search: &Search,
) -> Result<Forecast, SceneError> {
    search.validate()?;
    let whole = Numerics { simulate: Effect::OPTIONAL.to_vec(), ..numerics.clone() };
    let Forecast { elements, increments, unknowns, seconds, assembly, memory, operator } =
        forecast(scene, &whole, surfaces)?;
    let k = elements[0] * elements[1];
    if k > Multiplicity::MOST_ELEMENTS {
        let expected = format!(
            "must give no more than {} elements to search for every solution",
            Multiplicity::MOST_ELEMENTS
        );
        return Err(refuse(
            "numerics.mesh",
            format!("{} x {}", elements[0], elements[1]),
            &expected,
        ));
    }
    // A dense matrix of 3k rows is factored for most starts (measured on 2² and 4²).
    let rows = 3.0 * k as f64;
    let each = 1e-9 * rows.powi(3) + 3e-7 * rows + 4.5e-5;
    let searched = 4.0 * (f64::from(search.starts) + 20.0) * each;
    Ok(Forecast {
        elements,
        increments,
        unknowns,
        seconds: seconds + searched,
        assembly,
        memory: memory + (4.0 * 8.0 * rows * rows) as u64,
        operator,
    })
}

/// The time of a case of signs of a strip's elements \[s\].
const SECONDS_OF_CASE: f64 = 1e-7;

/// The time of a look at a cone over the square of the rows of its matrix \[s\]. A look took 11 ms
/// on 3 × 3 elements and 45 ms on 4 × 4, on a machine shared with other work.
const SECONDS_OF_CONE: f64 = 1.5e-5;

/// The mean number of cones that the job of a branch looks at. It was 10 on 3 × 3 elements and 6 on
/// 4 × 4.
const MEAN_CONES: f64 = 8.0;

/// The longest time that a search for cones takes before it is content with twice the width \[s\].
const MOST_SECONDS_OF_CONES: f64 = 150.0;

/// Returns the time of a bracket of this width by cones on `elements` elements. It was fitted to
/// 3 × 3 elements, where 3 % took 0.7 s and 0.3 % took 1.4 s, and to 4 × 4 elements, where 6 % took
/// 10 s and 3 % took 75 s, on a machine shared with other work.
fn seconds_of_cones(elements: f64, width: f64) -> f64 {
    let steepness = (0.36 * (elements - 9.0)).max(0.0) + 0.3;
    let seconds = 0.7 * 1.95_f64.powf(elements - 9.0) * (0.03 / width).powf(steepness);
    seconds.min(MOST_SECONDS_OF_CONES)
}

/// Forecasts the job of a branch of a search for cones.
///
/// # Errors
/// A [`SceneError`] reports a question or a branch that has no meaning.
pub fn forecast_branch(question: &Question, branch: &Branch) -> Result<Forecast, SceneError> {
    branch.validate(question)?;
    let (scene, numerics) = question.flat_punch();
    let Forecast { elements, memory, .. } = forecast(&scene, &numerics, &Surfaces::new())?;
    let rows = 3.0 * branch.states.len() as f64;
    Ok(Forecast {
        elements,
        increments: 0,
        unknowns: 3 * branch.states.len(),
        seconds: 0.01 + MEAN_CONES * SECONDS_OF_CONE * rows.powi(2),
        assembly: 0.0,
        memory: memory + 1_000_000,
        operator: 0,
    })
}

/// Forecasts the bracketing of μ*.
///
/// # Errors
/// A [`SceneError`] reports a question or a search that [`bracket`](crate::uniqueness::bracket)
/// refuses before it begins.
pub fn forecast_bracket(
    question: &Question,
    search: &WitnessSearch,
) -> Result<Forecast, SceneError> {
    search.validate()?;
    let (scene, numerics) = question.flat_punch();
    let Forecast { elements: [nx, ny], memory, .. } =
        forecast(&scene, &numerics, &Surfaces::new())?;
    if question.plane {
        // Each of 5ⁿ cases takes a few operations, for the search and for the check of its end.
        let seconds = 0.02 + SECONDS_OF_CASE * 5_f64.powi(nx as i32);
        return Ok(Forecast {
            elements: [nx, ny],
            increments: 0,
            unknowns: 2 * nx,
            seconds,
            assembly: 0.0,
            memory,
            operator: 0,
        });
    }
    let k = (nx * ny) as f64;
    let rows = 3.0 * k;
    // This is the time of Newton's method from a random start, or from stripes if elements are few
    // (measured on half-spaces with 2² to 48² elements).
    let newton = 0.006 * k + 4e-7 * rows.powi(3);
    let random = if k <= 100.0 { f64::from(search.starts) * (36.0 / k).min(1.0) } else { 0.0 };
    // There are a dozen stripes, and half as many again if x and y are not alike. If elements are
    // many, the stripes are tried on a part of Ω.
    let waves = if nx == ny { 12.0 } else { 18.0 };
    let stripes = waves * if k <= 16.0 { newton } else { 0.035 * k.min(64.0) };
    let kept = if k > 100.0 { 0.02 * k * f64::from(search.kept.max(1)) } else { 0.0 };
    // These figures are older than the method. Over the sweeps jobs took 0.06 to 0.31 of them
    // (measured from 2² to 16²).
    let searched = 0.15 * (0.02 + random * newton + stripes + kept);
    // Cases grow in number with the elements, and each takes longer (3 × 3 and 4 × 4 elements took
    // 2 s and 50 s on a machine shared with other work).
    let cases = match search.width {
        Some(width) => seconds_of_cones(k.min(16.0), width),
        None if search.cases => 0.03 * 1.58_f64.powf(k.min(16.0)),
        None => 0.0,
    };
    let seconds = searched + cases;
    // The matrices are the four blocks of the two mirror planes, with a form and its factor for
    // each of two threads. There are none if the blocks are too large to factor.
    let block = 0.75 * k;
    let factored =
        if block <= lower::FACTORED_ROWS as f64 { 8.0 * 8.0 * block * block } else { 0.0 };
    Ok(Forecast {
        elements: [nx, ny],
        increments: 0,
        unknowns: 3 * nx * ny,
        seconds,
        assembly: 0.0,
        memory: memory + factored as u64,
        operator: 0,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Foundation, Material, Mesh, Projection, sphere_on_half_space};
    use crate::problem::Problem;
    use crate::uniqueness::Sole;

    #[test]
    fn too_many_starts_are_refused_with_their_key() {
        let numerics: Numerics = serde_json::from_str(r#"{"mesh": 8}"#).unwrap();
        let question: Question = serde_json::from_str(
            r#"{"foundation": {"base": {"shear_modulus": 1.0, "poisson": 0.3}}, "sole": {"shape": "disk", "radius": 1.0}, "mesh": 4}"#,
        )
        .unwrap();
        for (starts, refused) in [(10_000, false), (10_001, true), (u32::MAX, true)] {
            let search = Search { starts, seed: 0 };
            let all =
                forecast_search(&sphere_on_half_space(), &numerics, &Surfaces::new(), &search);
            let brief = WitnessSearch { starts, ..Default::default() };
            for key in [all, forecast_bracket(&question, &brief)]
                .map(|forecast| forecast.map_err(|error| error.key))
            {
                assert_eq!(key.err().as_deref(), refused.then_some("search.starts"), "{starts}");
            }
        }
    }

    /// A block that is too large to factor takes no memory for factors.
    #[test]
    fn large_brackets_need_no_matrices() {
        let of = |n: u32| {
            let question = Question {
                foundation: Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 }),
                punch: None,
                sole: Sole::Rectangle { width_x: 1.0, width_y: 1.0 },
                mesh: Mesh::Exact([n, n]),
                projection: Projection::Average,
                epsilon: 0.0,
                plane: false,
            };
            forecast_bracket(&question, &WitnessSearch::default()).unwrap().memory
        };
        assert!(
            of(64) > 600_000_000 && of(64) < 900_000_000 && of(128) < of(64),
            "{} {}",
            of(64),
            of(128)
        );
    }

    #[test]
    fn equal_operators_have_equal_hashes_and_others_not() {
        let numerics: Numerics = serde_json::from_str(r#"{"mesh": 8}"#).unwrap();
        let of = |scene: &Scene, numerics: &Numerics| {
            (
                forecast(scene, numerics, &Surfaces::new()).unwrap().operator,
                Problem::new(scene, numerics, &Surfaces::new()).unwrap().operator_key(),
            )
        };
        let base = sphere_on_half_space();
        let mut variants = vec![(base.clone(), numerics.clone())];
        let mut stiffer = base.clone();
        stiffer.foundation = Foundation::half_space(Material { shear_modulus: 1e6, poisson: 0.3 });
        stiffer.friction.mu = 0.7;
        variants.push((stiffer, numerics.clone()));
        let mut softer = base.clone();
        softer.foundation = Foundation::half_space(Material { shear_modulus: 80e9, poisson: 0.2 });
        variants.push((softer, numerics.clone()));
        variants.push((base.clone(), Numerics { mesh: Mesh::Across(9), ..numerics.clone() }));
        let mut disk = base.clone();
        disk.punch.shape = Shape::FlatDisk { radius: 1.0 };
        variants.push((disk, numerics.clone()));
        for (a, of_a) in variants.iter().map(|(s, n)| of(s, n)).enumerate() {
            for (b, of_b) in variants.iter().map(|(s, n)| of(s, n)).enumerate() {
                assert_eq!(of_a.0 == of_b.0, of_a.1 == of_b.1, "{a} and {b}");
            }
        }
    }
}
