//! Stresses below the surface against closed forms and references. `laws` needs no reference;
//! `limits` goes to the ends of what can be asked.

mod laws;
mod limits;

use crate::common::*;
use crate::rolling::{case, problem, step};
use contact::interior::{Subsurface, examine};
use contact::model::*;
use contact::{Cancellation, Operators, punch::Surfaces, solve};

/// Returns a half-space with G = 1.
fn half_space(poisson: f64) -> Foundation {
    Foundation::half_space(Material { shear_modulus: 1.0, poisson })
}

/// Returns fields on n × n elements of the square |x| < a, |y| < b with these tractions (pressure,
/// along x, along y) of the mean over an element of `shape`.
fn spread(
    n: u32,
    [a, b]: [f64; 2],
    tractions: [f64; 3],
    shape: impl Fn(f64, f64) -> f64,
) -> Fields {
    /// The number of points along an element's side that make the mean.
    const POINTS: u32 = 8;
    let element = [2.0 * a / f64::from(n), 2.0 * b / f64::from(n)];
    let origin = [-a + 0.5 * element[0], -b + 0.5 * element[1]];
    let mean = |e: u32| {
        let [x, y] = [0, 1].map(|i| origin[i] + f64::from([e % n, e / n][i]) * element[i]);
        let part = |k: u32| (f64::from(k) + 0.5) / f64::from(POINTS) - 0.5;
        let points = (0..POINTS * POINTS)
            .map(|k| shape(x + part(k % POINTS) * element[0], y + part(k / POINTS) * element[1]));
        points.sum::<f64>() / f64::from(POINTS * POINTS)
    };
    let means: Vec<f64> = (0..n * n).map(mean).collect();
    let times = |factor: f64| means.iter().map(|mean| factor * mean).collect();
    Fields {
        shape: [n, n],
        origin,
        element,
        pressure: times(tractions[0]),
        traction_x: times(tractions[1]),
        traction_y: times(tractions[2]),
        ..Fields::default()
    }
}

/// Returns Hertz's pressure on an ellipse with these semi-axes, over its peak.
fn hertz(axes: [f64; 2]) -> impl Fn(f64, f64) -> f64 {
    move |x, y| (1.0 - (x / axes[0]).powi(2) - (y / axes[1]).powi(2)).max(0.0).sqrt()
}

/// A row of subsurface_stress.csv.
struct Row {
    kind: String,
    id: String,
    poisson: f64,
    axes: [f64; 2],
    /// The pressure, and the traction along x and y.
    tractions: [f64; 3],
    place: [f64; 3],
    stress: [f64; 6],
    mises: f64,
}

fn rows(kind: &str) -> Vec<Row> {
    reference("subsurface_stress.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |i: usize| cells[i].parse::<f64>().unwrap_or(f64::NAN);
            Row {
                kind: cells[0].to_owned(),
                id: cells[1].to_owned(),
                poisson: number(2),
                axes: [3, 4].map(number),
                tractions: [7, 5, 6].map(number),
                place: [8, 9, 10].map(number),
                stress: [11, 12, 13, 14, 15, 16].map(number),
                mises: number(17),
            }
        })
        .filter(|row| row.kind == kind)
        .collect()
}

/// Returns the largest difference of the components, over the largest component of the row.
fn error(stress: &Stress, row: &Row) -> f64 {
    let size = row.stress.iter().fold(0.0_f64, |most, part| most.max(part.abs()));
    let parts = stress.components().into_iter().zip(row.stress);
    parts.fold(0.0_f64, |most, (got, exact)| most.max((got - exact).abs())) / size
}

#[test]
fn rectangles_meet_the_reference() {
    let rows = rows("rectangle");
    assert_eq!(rows.len(), 100);
    for row in rows {
        let fields = spread(1, row.axes, row.tractions, |_, _| 1.0);
        let foundation = half_space(row.poisson);
        let stress = Subsurface::new(&foundation, &fields).at(row.place).unwrap();
        let error = error(&stress, &row);
        assert!(error < 1e-9, "{} {:?}: {error:e}", row.id, row.place);
        assert!((stress.von_mises() - row.mises).abs() < 1e-9 * row.mises.max(1e-2));
    }
}

/// Below a fine mesh the error falls with the square of the element, or nearly so: the means of the
/// pressure are exact, and only elements on the contact's edge are mixed.
#[test]
fn hertzian_contacts_meet_the_reference_with_second_order() {
    for kind in ["hertz_circle", "hertz_ellipse"] {
        let rows = rows(kind);
        let worst = [48, 96].map(|n| {
            let of_contact = |rows: &[Row]| {
                let Row { axes, tractions, poisson, .. } = rows[0];
                let fields = spread(n, axes.map(|axis| 1.05 * axis), tractions, hertz(axes));
                let foundation = half_space(poisson);
                let below = Subsurface::new(&foundation, &fields);
                let deep = rows.iter().filter(|row| row.place[2] >= 0.3);
                deep.map(|row| error(&below.at(row.place).unwrap(), row)).fold(0.0, f64::max)
            };
            rows.chunk_by(|a, b| a.id == b.id).map(of_contact).fold(0.0, f64::max)
        });
        let order = (worst[0] / worst[1]).log2();
        assert!(worst[1] < 1e-3 && order > 1.8, "{kind}: {worst:?}, order {order}");
    }
}

/// The tractions are those of this program's own solutions.
#[test]
fn stresses_below_rolling_contacts_meet_the_reference() {
    let rows = rows("discrete");
    assert_eq!(rows.len(), 60);
    for of_case in rows.chunk_by(|a, b| a.id == b.id) {
        let case = case("steady", &of_case[0].id);
        let (scene, numerics) = problem(&case, vec![step(&case, &case["step"])]);
        let (_, fields) = certified(&scene, &numerics);
        let below = Subsurface::new(&scene.foundation, &fields);
        for row in of_case {
            // The places are printed in nine digits.
            let place = [0, 1].map(|i| {
                let index = ((row.place[i] - fields.origin[i]) / fields.element[i]).round();
                fields.origin[i] + index * fields.element[i]
            });
            let stress = below.at([place[0], place[1], row.place[2]]).unwrap();
            let error = error(&stress, row);
            assert!(error < 1e-8, "{} {:?}: {error:e}", row.id, row.place);
            assert!((stress.von_mises() - row.mises).abs() < 1e-8 * row.mises);
        }
    }
}

/// The largest stress is that of a function of the place, not the best of a grid; extrapolated over
/// the mesh it meets the closed form's.
#[test]
fn largest_stresses_meet_the_reference_with_second_order() {
    for line in reference("subsurface_maxima.csv").lines().skip(1) {
        let cells: Vec<f64> = line.split(',').take(7).map(|cell| cell.parse().unwrap()).collect();
        let [poisson, mu, below, x, z, surface, surface_x] = cells[..] else { panic!("{line}") };
        let question = InteriorQuestion { maximum: true, ..InteriorQuestion::default() };
        let foundation = half_space(poisson);
        let found = [24, 48, 96].map(|n| {
            let fields = spread(n, [1.05; 2], [1.0, mu, 0.0], hertz([1.0; 2]));
            let answer =
                examine(&foundation, &question, &fields, &Cancellation::default()).unwrap();
            assert!(answer.residual.unwrap() < 1e-8, "{:?}", answer.residual);
            answer.von_mises.unwrap()
        });
        let values = found.map(|largest| largest.below.unwrap().stress);
        let errors = values.map(|value| (value - below).abs() / below);
        let extrapolated = values[2] + (values[2] - values[1]) / 3.0;
        assert!(errors[2] < 3e-4 && errors[0] / errors[2] > 8.0, "{line}: {errors:?}");
        assert!((extrapolated / below - 1.0).abs() < 1e-4, "{line}: {extrapolated}");
        let place = found[2].below.unwrap().place;
        assert!((place[0] - x).abs() < 2e-3 && (place[2] - z).abs() < 2e-3, "{line}: {place:?}");
        assert!(place[1].abs() < 2e-3, "{line}: {place:?}");
        // On the surface the edge's elements count, which are mixed.
        let on_surface = found[2].surface;
        assert!((on_surface.stress / surface - 1.0).abs() < 0.1, "{line}: {on_surface:?}");
        assert!((on_surface.place[0].hypot(on_surface.place[1]) - surface_x.abs()).abs() < 0.05);
        let is_below = found[2].overall().place[2] > 0.0;
        assert_eq!(is_below, line.ends_with("below"), "{line}");
    }
}

/// A scene that asks has the answer beside its outcome; one that does not ask has nothing.
#[test]
fn a_scene_that_asks_is_answered() {
    let press = Step { approach: Some(0.005), ..Step::default() };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.0, press);
    let numerics = numerics(Mesh::Across(32), Projection::Average, 1e-8);
    let solved = |scene: &Scene| {
        solve(scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap()
    };
    let (outcome, silent) = solved(&scene);
    assert!(outcome.further.is_empty());
    scene.interior = Some(InteriorQuestion {
        maximum: true,
        depths: Vec::new(),
        points: vec![[0.0, 0.0, 0.04], [0.0, 0.0, 1e3]],
    });
    let (outcome, fields) = solved(&scene);
    assert_eq!(silent, fields);
    let answer = outcome.further.interior.unwrap();
    assert!(answer.residual.unwrap() < 1e-8, "{:?}", answer.residual);
    let hertz = outcome.hertz.unwrap();
    let below = answer.von_mises.unwrap().below.unwrap();
    assert!((below.stress / hertz.peak_pressure / 0.62 - 1.0).abs() < 0.02, "{below:?}");
    assert!((below.place[2] / hertz.semi_axis_a / 0.481 - 1.0).abs() < 0.03, "{below:?}");
    assert_eq!(answer.points.len(), 2);
    // Far away only the load counts: −3P/2πz².
    let load = outcome.steps[0].observables.load;
    let far = -3.0 * load / (std::f64::consts::TAU * 1e6);
    assert!((answer.points[1].stress.zz / far - 1.0).abs() < 1e-7);
    // Planes that are asked for leave the search alone, but that it goes down to the deepest.
    let [first, last] = answer.searched.unwrap();
    for (depths, searched) in [(vec![0.0], last), (vec![0.04, 0.0], last), (vec![9.0], 9.0)] {
        scene.interior =
            Some(InteriorQuestion { maximum: true, depths: depths.clone(), points: Vec::new() });
        let (outcome, _) = solved(&scene);
        let answer = outcome.further.interior.unwrap();
        assert_eq!(answer.searched, Some([first, searched]));
        assert_eq!(answer.planes.len(), depths.len());
        let again = answer.von_mises.unwrap().below.unwrap();
        assert!((again.stress / below.stress - 1.0).abs() < 1e-5, "{again:?} {below:?}");
    }
    // What checks nothing has no residual.
    scene.interior = Some(InteriorQuestion::default());
    let fields = Fields { pressure: vec![0.0; fields.pressure.len()], ..fields };
    let nothing = InteriorQuestion::default();
    let cancellation = Cancellation::default();
    let answer = examine(&scene.foundation, &nothing, &fields, &cancellation).unwrap();
    assert_eq!(answer.residual, None);
    // Tractions that are no numbers leave no residual that looks small.
    let fields = Fields { pressure: vec![f64::NAN; fields.pressure.len()], ..fields };
    for question in [
        InteriorQuestion { depths: vec![0.04], ..InteriorQuestion::default() },
        InteriorQuestion { points: vec![[0.0, 0.0, 0.04]], ..InteriorQuestion::default() },
    ] {
        let answer = examine(&scene.foundation, &question, &fields, &cancellation).unwrap();
        assert_eq!(answer.residual, Some(f64::INFINITY));
    }
    cancellation.request();
    let question = InteriorQuestion { maximum: true, ..InteriorQuestion::default() };
    assert_eq!(examine(&scene.foundation, &question, &fields, &cancellation), None);
}

/// The maxima of a contact on a coating much thinner than an element are those of the base, not
/// those of the steps of traction from element to element; a stiff base below a soft layer is
/// reached.
#[test]
fn maxima_are_none_of_the_mesh() {
    let question = InteriorQuestion { maximum: true, ..InteriorQuestion::default() };
    let fields = spread(24, [1.05; 2], [1.0, 0.3, 0.0], hertz([1.0; 2]));
    let largest = |foundation: &Foundation| {
        let answer = examine(foundation, &question, &fields, &Cancellation::default()).unwrap();
        assert!(answer.residual.unwrap() < 1e-6, "{:?}", answer.residual);
        (answer.von_mises.unwrap().below.unwrap(), answer.searched.unwrap())
    };
    let mut foundation = half_space(0.3);
    let (bare, [first, _]) = largest(&foundation);
    foundation.layers = vec![Layer { shear_modulus: 5.0, poisson: 0.3, thickness: 0.003 }];
    let (coated, searched) = largest(&foundation);
    assert_eq!(searched[0], first);
    assert!((coated.place[2] - bare.place[2]).abs() < 0.05, "{coated:?} {bare:?}");
    assert!((coated.stress / bare.stress - 1.0).abs() < 0.05, "{coated:?} {bare:?}");
    // A stiff base far below the contact is within reach.
    foundation.layers = vec![Layer { shear_modulus: 1e-3, poisson: 0.3, thickness: 3.0 }];
    let (_, searched) = largest(&foundation);
    assert!(searched[1] > 3.0, "{searched:?}");
}

/// Places that doubles do not tell from others are refused before anything is solved.
#[test]
fn places_beyond_doubles_are_refused() {
    let press = Step { approach: Some(0.005), ..Step::default() };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.0, press);
    let numerics = numerics(Mesh::Across(16), Projection::Average, 1e-8);
    let points = [[1e200, 0.0, 1e-3], [0.0, -1e12, 1e-3], [1.7e308; 3], [0.0, 0.0, 5e-324]]
        .map(|point| InteriorQuestion { points: vec![point], ..InteriorQuestion::default() });
    let depths = [5e-324, 1e-16, 1e290]
        .map(|depth| InteriorQuestion { depths: vec![depth], ..InteriorQuestion::default() });
    for question in points.into_iter().chain(depths) {
        let key = if question.points.is_empty() { "interior.depths" } else { "interior.points" };
        scene.interior = Some(question);
        let said = solve(&scene, &numerics, &Surfaces::new(), &mut Operators::default());
        assert_eq!(said.unwrap_err().key, key, "{:?}", scene.interior);
        let said = contact::forecast(&scene, &numerics, &Surfaces::new());
        assert_eq!(said.unwrap_err().key, key, "{:?}", scene.interior);
    }
}

#[test]
fn what_cannot_be_asked_is_refused_with_its_key() {
    let press = Step { approach: Some(0.005), ..Step::default() };
    let refused = |question: InteriorQuestion| {
        let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.3, 0.0, press);
        scene.foundation.layers = vec![Layer { shear_modulus: 1.0, poisson: 0.3, thickness: 0.5 }];
        scene.foundation.base = Base::Rigid;
        scene.interior = Some(question);
        scene.validate().map_err(|error| error.key)
    };
    let depths = |depths: Vec<f64>| InteriorQuestion { depths, ..InteriorQuestion::default() };
    let points = |points: Vec<[f64; 3]>| InteriorQuestion { points, ..InteriorQuestion::default() };
    let key = |key: &str| Err(key.to_owned());
    assert_eq!(refused(InteriorQuestion::default()), key("interior"));
    assert_eq!(refused(depths(vec![0.2, 0.5])), Ok(()));
    for wrong in [-1e-9, f64::NAN, f64::INFINITY, 0.51] {
        assert_eq!(refused(depths(vec![0.1, wrong])), key("interior.depths"));
        assert_eq!(refused(points(vec![[0.0, 0.0, wrong]])), key("interior.points"));
    }
    assert_eq!(refused(points(vec![[f64::NAN, 0.0, 0.1]])), key("interior.points"));
    assert_eq!(refused(depths(vec![0.1; 65])), key("interior.depths"));
    assert_eq!(refused(points(vec![[0.1; 3]; 1001])), key("interior.points"));
}
