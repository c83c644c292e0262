//! Scenes at the limits meet the answers that are known: closed forms, statics, limits and scaling.

use super::*;
use contact::model::StepOutcome;
use contact::punch::SurfaceError;

fn load(case: &Case) -> f64 {
    solved(case).0.observables.load
}

fn near(name: &str, got: f64, expected: f64, tolerance: f64) {
    assert!(
        (got / expected - 1.0).abs() <= tolerance,
        "{name}: {got:e} instead of {expected:e}, off by {:e}",
        got / expected - 1.0
    );
}

#[test]
fn layers_tend_to_what_is_known() {
    let plain = |modulus: f64| {
        load(&case("half-space", Certified, |s, _| {
            (s.foundation, s.domain) = (half_space(modulus, 0.3), square(0.32))
        }))
    };
    let layered = |g: f64, thickness: f64, base: Base| {
        case("layer", Certified, |s, _| {
            (s.foundation, s.domain) =
                (Foundation { layers: vec![layer(g, thickness)], base }, square(0.32))
        })
    };
    let elastic = Base::Elastic(Material { shear_modulus: 1.0, poisson: 0.3 });
    for g in [0.1, 10.0] {
        near(
            "a layer of 1e-6 elements is not felt",
            load(&layered(g, 2e-8, elastic)),
            plain(1.0),
            1e-5,
        );
        near(
            "a layer of 1e6 elements is a half-space",
            load(&layered(g, 2e4, elastic)),
            plain(g),
            5e-5,
        );
    }
    near(
        "a base 1e12 times as stiff is rigid",
        load(&layered(1e-12, 0.1, elastic)),
        load(&layered(1e-12, 0.1, Base::Rigid)),
        1e-9,
    );
    let stiff = case("punch", Certified, |s, _| {
        s.punch.material = Some(Material { shear_modulus: 1e12, poisson: 0.3 })
    });
    near(
        "a punch 1e12 times as stiff is rigid",
        load(&stiff),
        load(&case("rigid", Certified, |_, _| {})),
        1e-9,
    );

    // Hogg's plate sinks by P l²/(3√3 D) under a point load, with l³ = D/K and D = Gh³/6(1−ν). Kk
    // is the pressure of the half-space, whose surface the plate keeps from moving sideways, under
    // a wave of unit height.
    let (p, nu, h) = (1e-3, 0.3, 0.1_f64);
    let (stiff, _) = solved(&case("plate", Certified, |s, _| {
        s.foundation.layers = vec![layer(1e12, h)];
        s.loading.steps = vec![loaded(p)];
    }));
    let bending = 1e12 * h.powi(3) / (6.0 * (1.0 - nu));
    let reaction = 1.0 / ((1.0 - nu) - (1.0 - 2.0 * nu).powi(2) / (4.0 * (1.0 - nu)));
    let plate = p * (bending / reaction).cbrt().powi(2) / (3.0 * 3f64.sqrt() * bending);
    let local = contact::theory::hertz_ellipse(2e12 / (1.0 - nu), 0.5, 0.5, p).approach;
    near("a layer 1e12 times as stiff is a plate", stiff.motion.approach, plate + local, 3e-4);
}

#[test]
fn thin_layers_on_rigid_bases_are_springs() {
    let thin = |poisson: f64, thickness: f64| {
        case("thin", Certified, |s, _| {
            s.domain = square(0.32);
            s.foundation = Foundation {
                layers: vec![Layer { poisson, ..layer(1.0, thickness) }],
                base: Base::Rigid,
            };
        })
    };
    // Each element stands for itself: p h / M = δ − g, with M = 2G(1−ν)/(1−2ν).
    let (case, h) = (thin(0.3, 2e-8), 0.02);
    let springs: f64 = (0..256)
        .map(|e| {
            [e % 16, e / 16]
                .map(|i| f64::from(i) - 7.5)
                .iter()
                .map(|x| (x * x + 1.0 / 12.0) * h * h / 2.0)
                .sum::<f64>()
        })
        .map(|gap| (0.01 - gap).max(0.0) * h * h * 2.0 * 0.7 / 0.4 / 2e-8)
        .sum();
    near("springs", load(&case), springs, 1e-5);
    // Once the layer is thin against the elements, the load that an incompressible one carries goes
    // as 1/h² for elements of constant pressure. Tangential displacements are a million times as
    // large as normal ones, and a residual in their units left 1 % of the load open.
    near("incompressible", load(&thin(0.5, 2e-8)), 100.0 * load(&thin(0.5, 2e-7)), 1e-3);
}

#[test]
fn materials_friction_and_regularisation_tend_to_what_is_known() {
    let nu =
        |poisson: f64| load(&case("ν", Certified, |s, _| s.foundation = half_space(1.0, poisson)));
    near("ν → ½", nu(0.499_999_9), nu(0.5), 1e-6);
    near("ν = ½ is Hertz's", nu(0.5), contact::theory::hertz_sphere(4.0, 1.0, 0.01).load, 1e-3);
    let mu = |mu: f64| load(&case("μ", Certified, |s, _| s.friction.mu = mu));
    near("μ → 0", mu(1e-12), mu(0.0), 1e-8);
    near("μ → ∞", mu(1e3), mu(1e300), 1e-8);
    let plain = load(&case("ε = 0", Certified, |_, _| {}));
    let epsilon = |epsilon: f64| case("ε", Certified, |_, n| n.epsilon = epsilon);
    near("ε → 0", load(&epsilon(1e-16)), plain, 1e-8);
    // For ε → ∞ the pressure is p₁ = (δ − g)/ε, in units of cℓ.
    let stiff = epsilon(1e9);
    let problem = Problem::new(&stiff.scene, &stiff.numerics, &stiff.surfaces).unwrap();
    let (end, fields) = solved(&stiff);
    let spring = 1e9 * problem.scale.length * problem.scale.compliance;
    let gaps = (0..fields.gap.len()).map(|e| (0.01 + problem.f[e] * problem.scale.length).max(0.0));
    near(
        "ε → ∞",
        end.observables.load,
        gaps.map(|f| f / spring * end.observables.element_x * end.observables.element_y).sum(),
        1e-7,
    );
    let ceiling = |ceiling: f64| {
        solved(&case("ceiling", Certified, |_, n| n.ceiling = Some(ceiling))).0.observables
    };
    near("a ceiling that is nowhere reached", ceiling(1e3).load, plain, 1e-8);
    let low = ceiling(1e-9);
    assert!(low.ceiling_elements == low.contact_elements && low.contact_elements > 150, "{low:?}");
    near("a ceiling that is reached everywhere", low.load, 1e-9 * low.contact_area, 1e-12);
}

#[test]
fn sizes_and_moduli_do_not_matter() {
    let plain = load(&case("1", Certified, |_, _| {}));
    for unit in [1e-300, 1e-20, 1e20, 1e300] {
        near(
            "modulus",
            load(&case("G", Certified, |s, _| s.foundation = half_space(unit, 0.3))) / unit,
            plain,
            1e-12,
        );
    }
    for unit in [1e-90_f64, 1e-20, 1e20, 1e90] {
        let sized = case("size", Certified, |s, _| {
            s.punch.shape = Shape::Sphere { radius: unit };
            s.loading.steps = vec![pressed(0.01 * unit)];
        });
        near("size", load(&sized) / unit / unit, plain, 1e-12);
    }
    // Under a load with an Ω that follows from it, P goes as δ^(3/2).
    let approach = |force: f64| {
        solved(&case("load", Certified, |s, _| s.loading.steps = vec![loaded(force)]))
            .0
            .motion
            .approach
    };
    for force in [1e-99_f64, 1e99] {
        near("load", approach(force) / (force / 1e-3).powf(2.0 / 3.0), approach(1e-3), 1e-7);
    }
}

#[test]
fn few_elements_and_all_of_them() {
    // One element in contact carries P = (δ − g) h²/A, with g = h²/12R.
    let one = |mesh: u32, width: f64, step: Step| {
        solved(&case("one", Certified, |s, n| {
            n.mesh = Mesh::Across(mesh);
            s.domain = square(width);
            s.loading.steps = vec![step];
        }))
        .0
    };
    let h = 0.02;
    let diagonal =
        contact::foundation::HalfSpace::new(&Material { shear_modulus: 1.0, poisson: 0.3 }, None)
            .influence([0.0; 2], h, h, Projection::Average)
            .nn;
    let far = one(15, 15.0 * h, loaded(1e-10));
    assert_eq!(far.observables.contact_elements, 1);
    near("one of many", far.motion.approach - h * h / 12.0, 1e-10 * diagonal / (h * h), 1e-7);
    let single = one(1, h, pressed(0.01));
    near("the only one", single.observables.load, (0.01 - h * h / 12.0) * h * h / diagonal, 1e-7);
    // A row of elements gives the same along x and along y.
    let row = |mesh: [u32; 2], step: Step| {
        load(&case("row", Certified, |s, n| {
            n.mesh = Mesh::Exact(mesh);
            s.domain = Some(Domain {
                width_x: 0.02 * f64::from(mesh[0]),
                width_y: 0.02 * f64::from(mesh[1]),
                center_x: 0.0,
                center_y: 0.0,
            });
            s.loading.steps = vec![step];
        }))
    };
    let along_x = row([20, 1], Step { shift_x: Some(0.002), ..pressed(0.01) });
    near("a row", row([1, 20], Step { shift_y: Some(0.002), ..pressed(0.01) }), along_x, 1e-9);
    // Elements 1000 times as long as wide give the same along x and along y.
    let strip = |width: [f64; 2], step: Step| {
        load(&case("strip", Certified, |s, n| {
            n.mesh = Mesh::Exact([16, 16]);
            s.punch.shape = rectangle(width[0], width[1]);
            s.loading.steps = vec![step];
        }))
    };
    let upright = strip([1e-3, 1.0], Step { shift_x: Some(0.001), ..pressed(0.01) });
    near(
        "a strip",
        strip([1.0, 1e-3], Step { shift_y: Some(0.001), ..pressed(0.01) }),
        upright,
        1e-7,
    );
    // If all elements are in contact, the punch's curvature is only an offset; a sphere without
    // curvature is flat.
    let flat = load(&case("flat", Certified, |s, _| s.punch.shape = rectangle(0.3, 0.3)));
    let round = load(&case("round", Certified, |s, _| {
        (s.domain, s.punch.shape) = (square(0.3), Shape::Sphere { radius: 1e100 })
    }));
    near("conforming", round, flat, 1e-9);
    let disk = case("disk", Certified, |s, n| {
        (s.friction.mu, s.punch.shape, n.mesh) =
            (0.0, Shape::FlatDisk { radius: 1.0 }, Mesh::Across(64));
    });
    near("sharp edges", load(&disk), contact::theory::flat_disk(2.0 / 0.7, 1.0, 0.01).load, 5e-3);
    let spots = solved(&spots()).0.observables;
    assert_eq!(spots.patches, 49);
    let corner = case("corner", Certified, |s, _| {
        s.punch.shape = rectangle(2.0, 1.0);
        s.loading.steps = vec![Step { tilt_x: Some(0.03), tilt_y: Some(-0.03), ..pressed(-0.028) }];
    });
    let (end, fields) = solved(&corner);
    let pressed: Vec<usize> =
        (0..fields.pressure.len()).filter(|e| fields.pressure[*e] > 0.0).collect();
    assert!(
        pressed.len() > 2 && pressed.iter().all(|e| e % 16 >= 13 && e / 16 >= 5),
        "{pressed:?} {:?}",
        end.observables
    );
}

#[test]
fn nothing_touches_a_punch_that_is_away() {
    for method in [Method::Auto, Method::Seidel, Method::Newton] {
        for approach in [-1e100, -0.01, 0.0, 1e-12] {
            let away = case("away", Certified, |s, n| {
                n.method = method;
                s.domain = square(0.3);
                s.loading.steps =
                    vec![pressed(approach), Step { shift_x: Some(1.0), ..Step::default() }];
            });
            let (end, fields) = solved(&away);
            assert_eq!(
                (end.observables.load, end.observables.contact_elements, end.observables.patches),
                (0.0, 0, 0)
            );
            assert!(fields.pressure.iter().chain(&fields.traction_x).all(|p| *p == 0.0));
        }
    }
}

#[test]
fn nearly_sliding_is_what_cattaneo_and_mindlin_say() {
    for share in [0.9, 0.999, 0.999_999] {
        let scene = case("nearly sliding", Certified, |s, n| {
            n.mesh = Mesh::Across(40);
            s.foundation = half_space(1.0, 0.0);
            s.punch.material = Some(Material { shear_modulus: 1.0, poisson: 0.0 });
            s.loading.steps = vec![loaded(0.003), pulled(share * 0.3 * 0.003)];
        });
        let exact = contact::assess::closed_form(&scene.scene).expect("like bodies with ν = 0");
        let (end, _) = solved(&scene);
        near("shift", end.motion.shift_x, exact.motion.shift_x, 5e-3);
        near("force", end.observables.force_x, share * 0.3 * 0.003, 1e-7);
    }
}

#[test]
fn two_hundred_steps_do_not_drift() {
    let cycle = case("cycle", Certified, |s, _| s.loading = two_hundred_steps());
    let (outcome, _) = run(&cycle, Method::Auto).unwrap();
    assert_eq!((outcome.status, outcome.steps.len()), (Status::Certified, 201));
    for pair in outcome.steps.iter().collect::<Vec<_>>()[1..].chunks_exact(2) {
        for (step, pulled) in pair.iter().zip([0.0006, -0.0006]) {
            near("load", step.observables.load, 0.003, 1e-8);
            near("force", step.observables.force_x, pulled, 1e-7);
        }
    }
    // Once the contact has shaken down, the same state comes back cycle after cycle.
    let end_of = |cycle: usize| &outcome.steps[2 * cycle];
    for (name, figure) in [
        ("energy", (|step: &StepOutcome| step.observables.energy) as fn(&StepOutcome) -> f64),
        ("dissipation", |step| step.observables.dissipation),
        ("approach", |step| step.motion.approach),
        ("shift", |step| step.motion.shift_x),
    ] {
        let (early, late) = (figure(end_of(50)), figure(end_of(100)));
        println!("{name}: {:e} {early:e} {late:e}", figure(end_of(2)));
        near(name, late, early, 1e-5);
    }
}

#[test]
fn heights_that_are_no_numbers_are_refused_with_their_place() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut heights = vec![0.0; 12];
        heights[7] = bad;
        let error = Surface::new(4, 3, heights).unwrap_err();
        assert!(matches!(error, SurfaceError::NotFinite { row: 1, column: 3, .. }), "{error}");
        assert!(
            error.to_string().contains("row 1, column 3 (counted from 0) is not a finite number"),
            "{error}"
        );
    }
}
