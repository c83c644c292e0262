//! The laws of wear: Archard's volume against the energy lost, contacts that do not wear, orders in
//! the increments, what passes through a rolling contact, and shapes that wear away.

use crate::common::*;
use contact::model::*;
use contact::multiplicity::{Search, search};
use contact::punch::Surfaces;
use contact::{Operators, assess::closed_form, solve};

/// A coefficient in 1/Pa where moduli are about 1 Pa.
const COEFFICIENT: f64 = 1e-3;

fn wearing(coefficient: f64) -> Option<Wear> {
    Some(Wear { coefficient, update: false, repeat: 1 })
}

fn updating(coefficient: f64, repeat: u32) -> Option<Wear> {
    Some(Wear { coefficient, update: true, repeat })
}

fn newton(mesh: u32) -> Numerics {
    numerics(Mesh::Across(mesh), Projection::Average, 1e-9)
}

fn solved(scene: &Scene, numerics: &Numerics) -> (Outcome, Fields) {
    let (outcome, fields) =
        solve(scene, numerics, &Surfaces::new(), &mut Operators::default()).unwrap();
    assert_eq!(outcome.status, Status::Certified);
    assert_eq!(outcome.further.wear.len(), outcome.steps.len());
    (outcome, fields)
}

fn volume(outcome: &Outcome) -> f64 {
    outcome.further.wear.iter().map(|worn| worn.volume).sum()
}

fn pressed(normal_force: f64) -> Step {
    Step { normal_force: Some(normal_force), ..Step::default() }
}

fn shifted(shift_x: f64, increments: u32) -> Step {
    Step { shift_x: Some(shift_x), increments, ..Step::default() }
}

/// Returns a sphere of radius 1 on a half-space with this ν, G = 1, μ = 0.3 and a contact of radius
/// about 0.5, that goes to and fro so many times.
fn fretting(poisson: f64, amplitude: f64, increments: u32, cycles: u32) -> Scene {
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, poisson, 0.3, Step::default());
    let (there, back) = (shifted(amplitude, 2 * increments), shifted(-amplitude, 2 * increments));
    let steps = vec![pressed(0.3), shifted(amplitude, increments), back, there];
    scene.loading = Loading { steps, cycle_from: Some(2), cycles };
    scene.domain = square(1.6);
    scene
}

/// Archard's volume is k/μ times the energy lost, in each increment and whatever is simulated: with
/// coupling and without, with ε, with a ceiling, in partial slip and in gross sliding.
#[test]
fn the_volume_is_the_energy_lost_over_the_coefficient_of_friction() {
    let regularised = Numerics { epsilon: 0.05, ..newton(16) };
    let capped = Numerics { ceiling: Some(0.5), ..newton(16) };
    for (poisson, amplitude, numerics) in [
        (0.5, 0.02, newton(16)),
        (0.5, 0.3, newton(16)),
        (0.2, 0.02, newton(16)),
        (0.2, 0.3, newton(16)),
        (0.3, 0.05, regularised),
        (0.5, 0.05, capped),
    ] {
        let mut scene = fretting(poisson, amplitude, 3, 2);
        scene.wear = wearing(COEFFICIENT);
        let (outcome, fields) = solved(&scene, &numerics);
        let mut volumes = 0.0;
        for (step, worn) in outcome.steps.iter().zip(&outcome.further.wear) {
            let expected = COEFFICIENT / 0.3 * step.observables.dissipation;
            let scale = COEFFICIENT / 0.3 * outcome.dissipation();
            assert!((worn.volume - expected).abs() <= 1e-8 * scale, "{worn:?}, {expected}");
            volumes += worn.volume;
        }
        assert!(volumes > 0.0, "ν {poisson}, amplitude {amplitude}");
        let depth = &fields.further.wear_depth;
        let [width, height] = fields.element;
        let sum: f64 = depth.iter().sum::<f64>() * width * height;
        assert!((sum / volumes - 1.0).abs() < 1e-13, "{sum} {volumes}");
        let deepest = depth.iter().copied().fold(0.0, f64::max);
        assert_eq!(outcome.further.wear.last().unwrap().depth, deepest);
        let depths: Vec<f64> = outcome.further.wear.iter().map(|worn| worn.depth).collect();
        assert!(depths.is_sorted(), "{depths:?}");
    }
}

/// A disk that sticks everywhere wears exactly nothing, although its slip is what the solver has
/// left of 0; so does a sphere that nothing moves sideways.
#[test]
fn what_sticks_does_not_wear() {
    let mut disk = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.5, 2.0, pressed(1.0));
    disk.loading.steps.push(shifted(0.05, 4));
    disk.wear = wearing(COEFFICIENT);
    let (outcome, fields) = solved(&disk, &newton(24));
    assert_eq!(outcome.last().unwrap().observables.slip_elements, 0);
    assert!(fields.slip_x.iter().any(|slip| *slip != 0.0), "the solver leaves something");
    assert!(outcome.further.wear.iter().all(|worn| *worn == Worn::default()));
    assert!(fields.further.wear_depth.iter().all(|depth| *depth == 0.0));
    let mut still = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.5, 0.3, pressed(0.3));
    still.wear = wearing(COEFFICIENT);
    let (outcome, _) = solved(&still, &newton(16));
    assert_eq!(outcome.further.wear, [Worn::default()]);
}

/// Wear on the undeformed shape is no part of the contact: without it every figure and field is the
/// same, bit for bit, and nothing is worn.
#[test]
fn wear_on_the_undeformed_shape_changes_nothing_else() {
    let mut scene = fretting(0.3, 0.05, 2, 1);
    let (plain, plain_fields) =
        solve(&scene, &newton(16), &Surfaces::new(), &mut Operators::default()).unwrap();
    assert!(plain.further.is_empty() && plain_fields.further.is_empty());
    for coefficient in [0.0, COEFFICIENT] {
        scene.wear = wearing(coefficient);
        let (mut outcome, mut fields) = solved(&scene, &newton(16));
        assert_eq!(volume(&outcome) > 0.0, coefficient > 0.0);
        outcome.further.wear.clear();
        fields.further = FurtherFields::default();
        assert_eq!((&outcome, &fields), (&plain, &plain_fields));
    }
}

/// Twice the coefficient wears twice as much, and sizes and moduli in other units the same.
#[test]
fn wear_is_proportional_and_knows_no_units() {
    let mut scene = fretting(0.3, 0.05, 2, 1);
    scene.wear = wearing(COEFFICIENT);
    let (once, fields) = solved(&scene, &newton(16));
    scene.wear = wearing(2.0 * COEFFICIENT);
    let (twice, twice_fields) = solved(&scene, &newton(16));
    assert_eq!(volume(&twice), 2.0 * volume(&once));
    let doubled: Vec<f64> = fields.further.wear_depth.iter().map(|depth| 2.0 * depth).collect();
    assert_eq!(twice_fields.further.wear_depth, doubled);
    // Lengths in units of 1/4 m and moduli in units of 1/1024 Pa are exact.
    let (length, modulus) = (4.0, 1024.0);
    let force = modulus * length * length;
    scene.foundation = Foundation::half_space(Material { shear_modulus: modulus, poisson: 0.3 });
    scene.punch.shape = Shape::Sphere { radius: length };
    scene.domain = square(1.6 * length);
    let amplitude = 0.05 * length;
    let (there, back) = (shifted(amplitude, 4), shifted(-amplitude, 4));
    scene.loading.steps = vec![pressed(0.3 * force), shifted(amplitude, 2), back, there];
    scene.wear = wearing(COEFFICIENT / modulus);
    let (scaled, scaled_fields) = solved(&scene, &newton(16));
    let ratio = volume(&scaled) / (volume(&once) * length.powi(3));
    assert!((ratio - 1.0).abs() < 1e-9, "{ratio}");
    for (scaled, depth) in scaled_fields.further.wear_depth.iter().zip(&fields.further.wear_depth) {
        assert!((scaled / length - depth).abs() <= 1e-9 * once.further.wear[0].depth.max(1e-3));
    }
}

/// The pressure counts at the end of an increment. Where the load grows while the punch slides, the
/// volume of n increments is off by a first-order term; at a constant load two increments are as
/// good as many.
#[test]
fn the_volume_is_of_first_order_in_the_increments() {
    let of = |end: f64, increments: u32| {
        let mut scene = scene(Shape::FlatDisk { radius: 1.0 }, 1.0, 0.5, 0.3, Step::default());
        let slide = Step { normal_force: Some(end), ..shifted(3.0, increments) };
        scene.loading = Loading::path(vec![pressed(0.1), shifted(1.0, 1), slide]);
        scene.wear = wearing(COEFFICIENT);
        let (outcome, _) = solved(&scene, &newton(12));
        outcome.further.wear[2..].iter().map(|worn| worn.volume).sum::<f64>()
    };
    let growing = [1, 2, 4, 8].map(|increments| of(0.3, increments));
    let order = ((growing[0] - growing[1]) / (growing[1] - growing[2])).log2();
    let finer = ((growing[1] - growing[2]) / (growing[2] - growing[3])).log2();
    assert!((order - 1.0).abs() < 0.05 && (finer - 1.0).abs() < 0.05, "{order} {finer}");
    // Twice the last less the one before is off by the second order: ∫ P ds = 0.2 · 2 less the
    // elastic part of the way.
    let limit = 2.0 * growing[3] - growing[2];
    assert!((limit / (COEFFICIENT * 0.4) - 1.0).abs() < 0.05, "{limit}");
    let constant = [1, 8].map(|increments| of(0.1, increments));
    assert!((constant[0] / constant[1] - 1.0).abs() < 1e-8, "{constant:?}");
    assert!((constant[0] / (COEFFICIENT * 0.1 * 2.0) - 1.0).abs() < 1e-8, "{constant:?}");
}

/// Returns a sphere that rolls by creepages and spin, with ν = ¼.
fn rolling(step: Rolling, steps: u32) -> Scene {
    let step = Step { rolling: Some(step), increments: steps, ..pressed(0.3) };
    let mut scene = scene(Shape::Sphere { radius: 1.0 }, 1.0, 0.25, 0.3, step);
    scene.punch.material = Some(Material { shear_modulus: 1.0, poisson: 0.25 });
    scene.domain = square(1.6);
    scene.wear = wearing(COEFFICIENT);
    scene
}

fn creeping(direction: RollingDirection, dq: f64, history: RollingHistory) -> Rolling {
    Rolling {
        creepage_x: Some(0.05),
        creepage_y: Some(0.02),
        spin: Some(0.1),
        spin_center: 0.0,
        direction,
        dq: Some(dq),
        distance: None,
        history,
        imposed: ImposedCreepages::default(),
    }
}

/// Returns the depths behind the contact, one for each row.
fn profile(fields: &Fields, is_forward: bool) -> Vec<f64> {
    let nx = fields.shape[0] as usize;
    let rows = fields.further.wear_depth.chunks_exact(nx);
    rows.map(|row| if is_forward { row[0] } else { row[nx - 1] }).collect()
}

/// In steady rolling the profile of a pass has the volume that is worn per length: k/μ times the
/// energy lost per length, whatever the distance of an increment.
#[test]
fn a_pass_wears_the_volume_per_length() {
    use RollingDirection::{Backward, Forward};
    let element = 1.6 / 24.0;
    for (direction, dq) in [(Forward, 1.0), (Forward, 0.5), (Forward, 2.5), (Backward, 1.0)] {
        let steady = creeping(direction, dq * element, RollingHistory::Steady);
        let (outcome, fields) = solved(&rolling(steady, 1), &newton(24));
        let per_length = outcome.further.wear[0].volume / (dq * element);
        let lost = outcome.last().unwrap().observables.dissipation / (dq * element);
        assert!((per_length / (COEFFICIENT / 0.3 * lost) - 1.0).abs() < 1e-7);
        let profile = profile(&fields, direction == Forward);
        let area: f64 = profile.iter().sum::<f64>() * fields.element[1];
        assert!((area / per_length - 1.0).abs() < 1e-12, "dq {dq}: {area} {per_length}");
        let deepest = profile.iter().copied().fold(0.0, f64::max);
        assert_eq!(outcome.further.wear[0].depth, deepest, "the depth is that of a pass");
    }
}

/// On a way that begins with the steady state each increment wears the same volume. Material that
/// has passed the contact has lost the depth of a pass; where an increment is several elements
/// long, as many elements have it together.
#[test]
fn a_way_on_from_the_steady_state_goes_on_wearing_as_it_does() {
    use RollingDirection::{Backward, Forward};
    use RollingHistory::{Steady, Transient};
    let element = 1.6 / 16.0;
    for (direction, elements) in [(Forward, 1.0), (Forward, 0.5), (Backward, 0.25), (Backward, 2.0)]
    {
        let step = |history| creeping(direction, elements * element, history);
        let mut scene = rolling(step(Steady), 1);
        let (_, steady) = solved(&scene, &newton(16));
        let onwards = Step { rolling: Some(step(Transient)), increments: 16, ..Step::default() };
        scene.loading.steps.push(onwards);
        let (outcome, fields) = solved(&scene, &newton(16));
        let volume = outcome.further.wear[0].volume;
        for worn in &outcome.further.wear {
            assert!((worn.volume / volume - 1.0).abs() < 1e-6, "{worn:?}");
        }
        let largest = outcome.further.wear[0].depth;
        // Where parts of elements are rolled, depths are shared between neighbours.
        let error = if elements == 1.0 { 1e-6 } else { 0.2 };
        for (depth, steady) in fields.further.wear_depth.iter().zip(&steady.further.wear_depth) {
            assert!(elements > 1.0 || (depth - steady).abs() < error * largest, "{depth} {steady}");
        }
        if elements < 1.0 {
            continue;
        }
        let passed = |columns: std::ops::Range<usize>| {
            let rows = fields.further.wear_depth.chunks_exact(16);
            rows.map(|row| row[columns.clone()].iter().sum::<f64>()).sum::<f64>() * element.powi(2)
        };
        let first = if direction == Forward { 0 } else { 14 };
        let of_two = 2.0 / elements * volume;
        assert!((passed(first..first + 2) / of_two - 1.0).abs() < 1e-6, "{elements} elements");
    }
}

/// Every pass of a steady step meets fresh material, so that cycles of them wear the volume of each
/// and no deeper. The material of a transient one goes on as in a path without cycles.
#[test]
fn cycles_that_roll_wear_fresh_material() {
    use RollingDirection::Forward;
    let element = 1.6 / 16.0;
    let of = |history, increments: u32, cycles: u32| {
        let mut scene = rolling(creeping(Forward, 0.7 * element, history), increments);
        scene.loading.steps.insert(0, pressed(0.3));
        scene.loading = Loading { cycle_from: Some(1), cycles, ..scene.loading };
        solved(&scene, &newton(16))
    };
    let (once, fields) = of(RollingHistory::Steady, 1, 1);
    let (thrice, thrice_fields) = of(RollingHistory::Steady, 1, 3);
    let worn = once.further.wear[1];
    assert!(worn.depth > 0.0 && thrice.further.wear.len() == 4);
    for again in &thrice.further.wear[1..] {
        assert!((again.depth / worn.depth - 1.0).abs() < 1e-6, "{again:?}");
        assert!((again.volume / worn.volume - 1.0).abs() < 1e-6, "{again:?}");
    }
    assert!(difference(&fields, &thrice_fields) < 1e-6);
    let (path, fields) = of(RollingHistory::Transient, 12, 1);
    let (cycles, cycle_fields) = of(RollingHistory::Transient, 4, 3);
    assert_eq!(path.further, cycles.further);
    assert_eq!(fields.further, cycle_fields.further);
}

/// A contact that goes the other way leaves the mirror image.
#[test]
fn rolling_backwards_wears_the_mirror_image() {
    use RollingDirection::{Backward, Forward};
    let element = 1.6 / 16.0;
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        let increments = if history == RollingHistory::Steady { 1 } else { 5 };
        let of = |direction: RollingDirection| {
            let sign = if direction == Forward { 1.0 } else { -1.0 };
            let step = creeping(direction, 1.5 * element, history);
            let step = Rolling { creepage_x: Some(0.05 * sign), spin: Some(0.1 * sign), ..step };
            solved(&rolling(step, increments), &newton(16)).1.further.wear_depth
        };
        let (forward, backward) = (of(Forward), of(Backward));
        let largest = forward.iter().copied().fold(0.0, f64::max);
        for (row, mirrored) in forward.chunks_exact(16).zip(backward.chunks_exact(16)) {
            for (depth, image) in row.iter().zip(mirrored.iter().rev()) {
                assert!((depth - image).abs() < 1e-7 * largest, "{history:?}: {depth} {image}");
            }
        }
    }
}

/// With the shape updated, the volume is still k/μ times the energy lost, each increment is
/// certified, and nothing claims the theory of the shape that was.
#[test]
fn a_sphere_that_frets_wears_a_scar() {
    let mut scene = fretting(0.3, 0.2, 4, 6);
    scene.domain = square(2.4);
    scene.wear = wearing(0.15);
    let (fixed, _) = solved(&scene, &newton(24));
    scene.wear = updating(0.15, 1);
    let (worn, fields) = solved(&scene, &newton(24));
    let expected = 0.15 / 0.3 * worn.dissipation();
    assert!((volume(&worn) / expected - 1.0).abs() < 1e-7);
    let [first, last] = [&fixed, &worn].map(|outcome| outcome.last().unwrap().observables);
    assert!(last.contact_area > 1.2 * first.contact_area, "{last:?}");
    assert!(last.peak_pressure < 0.8 * first.peak_pressure, "{last:?}");
    assert!((last.load / first.load - 1.0).abs() < 1e-7);
    let deepest = worn.further.wear.last().unwrap().depth;
    assert!(deepest < fixed.further.wear.last().unwrap().depth, "{deepest}");
    assert!(fixed.hertz.is_some() && worn.hertz.is_none());
    // The gap that is certified is that of the worn shape: where it touches, the surfaces have
    // followed what is gone.
    let k = fields.pressure.len();
    let touching = (0..k).filter(|e| fields.pressure[*e] > 0.0);
    assert!(touching.clone().count() > 0);
    assert!(touching.map(|e| fields.gap[e].abs()).fold(0.0, f64::max) < 1e-7);
    let mut exact = scene.clone();
    (exact.friction.mu, exact.foundation) =
        (0.3, Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.5 }));
    exact.loading = Loading::path(vec![pressed(0.3)]);
    exact.wear = updating(0.15, 1);
    assert!(closed_form(&exact).is_none());
    // Wear that is off takes nothing from what is said.
    for wear in [wearing(0.15), updating(0.0, 1)] {
        exact.wear = wear;
        assert!(closed_form(&exact).is_some());
        assert!(solved(&exact, &newton(12)).0.hertz.is_some());
    }
}

/// The effects that a solve leaves out by stages, directions and mirror planes change neither the
/// wear nor the shape that is left.
#[test]
fn effects_left_out_wear_the_same_shape() {
    let mut scene = fretting(0.5, 0.2, 4, 2);
    scene.wear = updating(0.1, 1);
    let (reduced, fields) = solved(&scene, &newton(16));
    let whole = Numerics { simulate: Effect::OPTIONAL.to_vec(), ..newton(16) };
    let (full, full_fields) = solved(&scene, &whole);
    for (worn, expected) in reduced.further.wear.iter().zip(&full.further.wear) {
        let scale = full.further.wear.last().unwrap();
        assert!((worn.depth - expected.depth).abs() < 1e-6 * scale.depth, "{worn:?} {expected:?}");
        assert!((worn.volume - expected.volume).abs() < 1e-6 * scale.volume, "{worn:?}");
    }
    assert!(difference(&fields, &full_fields) < 1e-6);
}

/// A flat punch that slides to and fro under a constant load wears until its pressure is the same
/// everywhere, which is Archard's limit of conforming contacts: then it wears evenly.
#[test]
fn a_flat_punch_wears_until_its_pressure_is_even() {
    let mut scene =
        scene(Shape::FlatRectangle { width_x: 1.0, width_y: 1.0 }, 1.0, 0.5, 0.2, Step::default());
    let steps = vec![pressed(0.01), shifted(1.0, 5), shifted(-1.0, 10), shifted(1.0, 10)];
    scene.loading = Loading { steps, cycle_from: Some(2), cycles: 8 };
    let unevenness = |outcome: &Outcome, index: usize| {
        let observables = outcome.steps[index].observables;
        observables.peak_pressure * observables.sole_area / observables.load - 1.0
    };
    scene.wear = updating(0.04, 1);
    let (outcome, fields) = solved(&scene, &newton(8));
    let last = outcome.steps.len() - 1;
    assert!(unevenness(&outcome, 0) > 0.5, "{}", unevenness(&outcome, 0));
    assert!(unevenness(&outcome, last) < 0.02, "{}", unevenness(&outcome, last));
    let pressures = &fields.pressure;
    let least = pressures.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((least / 0.01 - 1.0).abs() < 0.02, "{least}");
    // What wears in an increment is then k p |s| with the mean pressure, as deep everywhere.
    let [before, end] = [last - 1, last].map(|index| outcome.further.wear[index].depth);
    let even = 0.04 * 0.01 * 0.2;
    assert!(((end - before) / even - 1.0).abs() < 0.03, "{} {even}", end - before);
}

/// On the undeformed shape each cycle wears so many times as much as it stands for, and what comes
/// before the cycles wears once.
#[test]
fn cycles_that_stand_for_many_wear_so_many_times_as_much() {
    let mut scene = fretting(0.3, 0.05, 2, 2);
    let mut of = |repeat: u32| {
        scene.wear = Some(Wear { repeat, ..wearing(COEFFICIENT).unwrap() });
        solved(&scene, &newton(16)).0
    };
    let (once, often) = (of(1), of(64));
    for ((one, many), step) in once.further.wear.iter().zip(&often.further.wear).zip(&once.steps) {
        let factor = if step.cycle > 0 { 64.0 } else { 1.0 };
        assert_eq!(many.volume, factor * one.volume);
    }
    // Each element loses what it lost before the cycles, and so many times what it lost in them.
    let before = once.steps.iter().take_while(|step| step.cycle == 0).count();
    let [start, end] = [before - 1, once.steps.len() - 1].map(|step| once.further.wear[step].depth);
    let depth = often.further.wear.last().unwrap().depth;
    assert!((64.0 * (end - start)..=64.0 * end).contains(&depth), "{depth}");
}

/// With the shape updated, a cycle that stands for many leads to the shape of as many cycles, with
/// an error of the first order in their number.
#[test]
fn cycles_that_stand_for_many_lead_to_the_same_shape() {
    let of = |repeat: u32| {
        let mut scene = fretting(0.5, 0.2, 4, 12 / repeat);
        scene.domain = square(2.4);
        scene.wear = updating(0.01, repeat);
        let (outcome, _) = solved(&scene, &newton(16));
        let end = outcome.last().unwrap().observables;
        let depth = outcome.further.wear.last().unwrap().depth;
        [depth, volume(&outcome), end.peak_pressure, end.energy]
    };
    let [one, two, four] = [1, 2, 4].map(of);
    for (figure, one) in one.into_iter().enumerate() {
        let [two, four] = [two, four].map(|all| all[figure] / one - 1.0);
        assert!(two.abs() < 0.02, "figure {figure}: {two} {four}");
        // The errors are those of N − 1 cycles that are left out.
        assert!((four / two / 3.0 - 1.0).abs() < 0.1, "figure {figure}: {two} {four}");
    }
}

/// Returns the largest part of a pressure that alternates from element to element, over its peak,
/// where all neighbours are in contact.
fn alternating(fields: &Fields) -> f64 {
    let (p, nx) = (&fields.pressure, fields.shape[0] as usize);
    let is_inside = |e: &usize| {
        [e - nx - 1, e - nx, e - nx + 1, e - 1, *e, e + 1, e + nx - 1, e + nx, e + nx + 1]
            .into_iter()
            .all(|e| p[e] > 0.0)
    };
    let part = |e: usize| {
        let edges = p[e - 1] + p[e + 1] + p[e - nx] + p[e + nx];
        let corners = p[e - nx - 1] + p[e - nx + 1] + p[e + nx - 1] + p[e + nx + 1];
        (p[e] - edges / 2.0 + corners / 4.0).abs() / 4.0
    };
    let inside = (nx + 1..p.len() - nx - 1).filter(is_inside);
    inside.map(part).fold(0.0, f64::max) / p.iter().copied().fold(0.0, f64::max)
}

/// As much wear at once as a mesh bears leaves an even pressure, on elements of any shape and under
/// coatings of any stiffness; what is more is refused.
#[test]
fn wear_that_a_mesh_bears_leaves_no_chequerboard() {
    let coated = |shear_modulus: f64| Foundation {
        layers: vec![Layer { shear_modulus, poisson: 0.3, thickness: 0.1 }],
        base: Base::Elastic(Material { shear_modulus: 1.0, poisson: 0.3 }),
    };
    let soft = Foundation::half_space(Material { shear_modulus: 1.0, poisson: 0.3 });
    let across = |mesh| Numerics { mesh, ..newton(16) };
    for (name, foundation, mesh) in [
        ("squares", soft.clone(), Mesh::Exact([16, 16])),
        ("elongated", soft, Mesh::Exact([8, 48])),
        ("stiff", coated(10.0), Mesh::Exact([16, 16])),
        ("very stiff", coated(100.0), Mesh::Exact([16, 16])),
    ] {
        let mut scene = fretting(0.3, 0.2, 4, 3);
        scene.foundation = foundation;
        let numerics = across(mesh);
        let solve = |scene: &Scene| {
            solve(scene, &numerics, &Surfaces::new(), &mut Operators::default()).unwrap()
        };
        // The words name the compliance that the pressure follows.
        scene.wear = updating(1e3, 1);
        let Status::Failed { reason } = solve(&scene).0.status else { panic!("{name}: certified") };
        let words = reason.split("follows it up to ").nth(1).expect("a compliance");
        let most: f64 = words.split(' ').next().unwrap().parse().expect("a number");
        // An increment slides by 0.05 at most.
        scene.wear = updating(0.9 * most / 0.05, 1);
        let (outcome, fields) = solve(&scene);
        assert_eq!(outcome.status, Status::Certified, "{name}");
        assert!(alternating(&fields) < 0.1, "{name}: {}", alternating(&fields));
        scene.wear = updating(1.5 * most / 0.05, 1);
        let Status::Failed { reason } = solve(&scene).0.status else { panic!("{name}: certified") };
        assert!(reason.contains("the shape would yield"), "{name}: {reason}");
    }
}

/// A path ends in words with wear that the pressure cannot follow, or doubles cannot hold.
#[test]
fn wear_that_is_too_fast_ends_the_path_in_words() {
    let reason = |scene: &Scene| {
        let (outcome, _) =
            solve(scene, &newton(8), &Surfaces::new(), &mut Operators::default()).unwrap();
        match outcome.status {
            Status::Failed { reason } => reason,
            Status::Certified => panic!("certified"),
        }
    };
    let mut scene = fretting(0.5, 0.3, 2, 2);
    scene.wear = updating(10.0, 1);
    let fast = reason(&scene);
    assert!(
        fast.starts_with("loading.steps[1], increment 1 of 2: the shape would yield"),
        "{fast}"
    );
    assert!(fast.contains("take more increments, a smaller `wear.repeat`"), "{fast}");
    scene.wear = updating(0.01, 1000);
    assert!(reason(&scene).contains("the shape would yield"));
    for wear in [wearing(f64::MAX), updating(f64::MAX, 2)] {
        scene.wear = wear;
        scene.foundation = Foundation::half_space(Material { shear_modulus: 1e9, poisson: 0.5 });
        scene.loading.steps[0] = pressed(0.3e9);
        let huge = reason(&scene);
        assert!(huge.contains("beyond the range of double precision"), "{huge}");
    }
    // The smallest coefficients wear what they wear, down to nothing.
    for coefficient in [1e-300, f64::MIN_POSITIVE, 5e-324] {
        for wear in [wearing(coefficient), updating(coefficient, 1)] {
            scene.wear = wear;
            let (outcome, _) = solved(&scene, &newton(8));
            let expected = coefficient * (outcome.dissipation() / 0.3);
            // Below the normal doubles a pressure, a slip and a sum each round by half the smallest
            // double at most.
            let roundings = 3 * 64 * outcome.steps.len();
            let error = 1e-7 * expected + 5e-324 * roundings as f64;
            assert!((volume(&outcome) - expected).abs() <= error, "{coefficient:e}");
        }
    }
}

#[test]
fn wear_without_a_meaning_is_refused() {
    let refused = |change: &dyn Fn(&mut Scene)| {
        let mut scene = fretting(0.5, 0.3, 2, 2);
        scene.wear = wearing(COEFFICIENT);
        change(&mut scene);
        let error = solve(&scene, &newton(8), &Surfaces::new(), &mut Operators::default());
        error.expect_err("a refusal").key
    };
    for coefficient in [-1e-3, f64::NAN, f64::INFINITY] {
        assert_eq!(refused(&|scene| scene.wear = wearing(coefficient)), "wear.coefficient");
    }
    assert_eq!(refused(&|scene| scene.friction.mu = 0.0), "friction.mu");
    for cycles in [0, 1_000_001] {
        let wear = Wear { repeat: cycles, ..wearing(COEFFICIENT).unwrap() };
        assert_eq!(refused(&|scene| scene.wear = Some(wear)), "wear.repeat", "{cycles}");
    }
    let without_cycle = |scene: &mut Scene| {
        scene.wear = updating(COEFFICIENT, 2);
        (scene.loading.cycle_from, scene.loading.cycles) = (None, 1);
    };
    assert_eq!(refused(&without_cycle), "wear.repeat");
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        let rolls = |scene: &mut Scene| {
            scene.wear = updating(COEFFICIENT, 1);
            let rolling = creeping(RollingDirection::Forward, 0.1, history);
            scene.loading.steps.push(Step { rolling: Some(rolling), ..Step::default() });
        };
        assert_eq!(refused(&rolls), "wear.update");
    }
    for history in [RollingHistory::Steady, RollingHistory::Transient] {
        let rolls = |from: u32| {
            move |scene: &mut Scene| {
                scene.wear = Some(Wear { repeat: 2, ..wearing(COEFFICIENT).unwrap() });
                let rolling = creeping(RollingDirection::Forward, 0.1, history);
                scene.loading.steps[2] = Step { rolling: Some(rolling), ..Step::default() };
                scene.loading.cycle_from = Some(from);
            }
        };
        assert_eq!(refused(&rolls(2)), "wear.repeat");
        assert_eq!(refused(&rolls(0)), "wear.repeat");
        // What rolls before the cycles is worn once in any case.
        let mut scene = fretting(0.5, 0.3, 2, 2);
        rolls(3)(&mut scene);
        assert_eq!(scene.validate(), Ok(()));
    }
    let mut scene = fretting(0.5, 0.3, 2, 1);
    scene.wear = wearing(COEFFICIENT);
    let found =
        search(&scene, &newton(8), &Surfaces::new(), &mut Operators::default(), &Search::default());
    assert_eq!(found.unwrap_err().key, "wear.coefficient");
}
