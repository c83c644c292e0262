//! A wheel on a rail meets CONTACT (tests/reference/wheel_rail.csv), and Hertz where his theory is
//! exact.

use crate::common::*;
use contact::model::{
    Domain, Loading, Material, Mesh, Projection, Scene, Shape, Side, Status, Step, StepOutcome,
    WheelRail,
};
use contact::punch::*;
use contact::theory::hertz_ellipse;
use std::f64::consts::PI;
use std::sync::Arc;

pub(crate) const STEEL: Material = Material { shear_modulus: 82e9, poisson: 0.28 };

/// The side of the benchmark's elements \[m\].
const ELEMENT: f64 = 0.2e-3;

fn benchmark(side: Side, position: &Position) -> WheelOnRail {
    let [wheel, rail] = [
        include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw"),
        include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr"),
    ]
    .map(|text| Profile::from_simpack(text).expect("a profile"));
    let wheelset =
        Wheelset { rolling_radius: 0.46, flange_back_distance: 1.36, flange_back_to_origin: 0.07 };
    WheelOnRail::new(
        &wheel,
        &rail,
        &wheelset,
        &Track { gauge: 1.435, gauge_depth: 0.014 },
        side,
        position,
    )
    .expect("a contact")
}

/// The gap above a plane of contact, as a height map on elements of which one has its centre in the
/// frame's origin.
struct Pressed {
    scene: Scene,
    surfaces: Surfaces,
    elements: [u32; 2],
}

impl Pressed {
    /// Builds the height map with room for all that overlaps up to an approach of `reach` \[m\].
    fn new(plane: &ContactPlane, reach: f64, element: f64) -> Self {
        let Extent { x, s } = plane.overlap(reach).expect("an overlap");
        let cells = |[low, high]: [f64; 2]| {
            ((low / element).floor() as i64, (high / element).ceil() as i64)
        };
        let ((i0, i1), (j0, j1)) = (cells(x), cells(s));
        let (columns, rows) = ((i1 - i0 + 1) as usize, (j1 - j0 + 1) as usize);
        let gap = |e: usize| {
            plane.gap(
                (i0 + (e % columns) as i64) as f64 * element,
                (j0 + (e / columns) as i64) as f64 * element,
            )
        };
        let gaps: Vec<f64> = (0..columns * rows)
            .map(|e| gap(e).expect("a gap wherever the bodies overlap"))
            .collect();
        let surface =
            Surface::new(columns, rows, gaps.iter().map(|gap| -gap).collect()).expect("a surface");
        let (width_x, width_y) = (columns as f64 * element, rows as f64 * element);
        let mut scene = scene(
            Shape::HeightMap { surface: "gap".to_owned(), width_x, width_y },
            STEEL.shear_modulus,
            STEEL.poisson,
            0.0,
            Step::default(),
        );
        scene.punch.material = Some(STEEL);
        let mut surfaces = Surfaces::new();
        surfaces.insert("gap".to_owned(), Arc::new(surface));
        Self { scene, surfaces, elements: [columns as u32, rows as u32] }
    }

    /// Solves the contact with the bodies approached by `approach` \[m\] from where they touch.
    fn approached(&self, approach: f64) -> StepOutcome {
        let mut scene = self.scene.clone();
        scene.loading = Loading::path(vec![Step { approach: Some(approach), ..Step::default() }]);
        certified_with(
            &scene,
            &numerics(Mesh::Exact(self.elements), Projection::Midpoint, 1e-5),
            &self.surfaces,
        )
        .0
    }

    /// Finds the approach \[m\] with the load `force` \[N\], starting from `guess`; the load goes
    /// nearly as the approach to the power of 3/2.
    fn loaded(&self, force: f64, guess: f64) -> (f64, StepOutcome) {
        let mut approach = guess;
        for _ in 0..6 {
            let outcome = self.approached(approach);
            let ratio = force / outcome.observables.load;
            if (ratio - 1.0).abs() < 2e-4 {
                return (approach, outcome);
            }
            approach *= ratio.powf(2.0 / 3.0);
        }
        panic!("no approach with the load {force} N");
    }
}

struct Row {
    side: Side,
    name: String,
    position: Position,
    height: f64,
    reference: [f64; 3],
    angle: f64,
    rail: [f64; 2],
    force: f64,
    approach: f64,
    peak: f64,
    elements: f64,
}

impl Row {
    /// Returns the case as a scene with a wheel on a rail and the load given.
    fn scene(&self) -> Scene {
        let Position { lateral, yaw, roll } = self.position;
        let shape = Shape::WheelOnRail(WheelRail {
            wheel: "wheel".to_owned(),
            rail: "rail".to_owned(),
            side: self.side,
            rolling_radius: 0.46,
            gauge: WheelRail::GAUGE,
            gauge_depth: WheelRail::GAUGE_DEPTH,
            flange_back_distance: WheelRail::FLANGE_BACK_DISTANCE,
            flange_back_to_origin: WheelRail::FLANGE_BACK_TO_ORIGIN,
            lateral,
            yaw,
            roll,
            motion: None,
        });
        let step = Step { normal_force: Some(self.force), ..Step::default() };
        let mut scene = scene(shape, STEEL.shear_modulus, STEEL.poisson, 0.3, step);
        scene.punch.material = Some(STEEL);
        scene
    }
}

/// Returns the profiles of the benchmark.
pub(crate) fn profiles() -> Surfaces {
    let mut surfaces = Surfaces::new();
    let profile = |text| Arc::new(Profile::from_simpack(text).expect("a profile"));
    surfaces.insert_profile(
        "wheel".to_owned(),
        profile(include_str!("../../../../sweeps/profiles/MBench_S1002_v3.prw")),
    );
    surfaces.insert_profile(
        "rail".to_owned(),
        profile(include_str!("../../../../sweeps/profiles/MBench_UIC60_v3.prr")),
    );
    surfaces
}

fn rows(of: Side) -> Vec<Row> {
    let text = reference("wheel_rail.csv");
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let text = |name: &str| fields[head.iter().position(|column| *column == name).unwrap()];
            let number = |name: &str| text(name).parse::<f64>().unwrap();
            assert_eq!(text("patch"), "1");
            Row {
                side: match text("wheel") {
                    "left" => Side::Left,
                    "right" => Side::Right,
                    other => panic!("a wheel on the {other}"),
                },
                name: text("case").to_owned(),
                position: Position {
                    lateral: number("wheelset_y_mm") * 1e-3,
                    yaw: number("yaw_rad"),
                    roll: number("roll_rad"),
                },
                height: number("wheelset_z_mm") * 1e-3,
                reference: ["xcp_track_mm", "ycp_track_mm", "zcp_track_mm"]
                    .map(|name| number(name) * 1e-3),
                angle: number("contact_angle_rad"),
                rail: ["ycp_rail_mm", "zcp_rail_mm"].map(|name| number(name) * 1e-3),
                force: number("FN_N"),
                approach: number("approach_mm") * 1e-3,
                peak: number("pmax_MPa") * 1e6,
                elements: number("elements_in_contact"),
            }
        })
        .filter(|row| row.side == of)
        .collect()
}

/// CONTACT prints the location to 0.05 µm, angles to 0.05 mrad, approach and load to 0.05 %, and
/// the roll to 5e-8 below a milliradian and 5e-6 above, which lowers the wheel by 750 mm times as
/// much. Two differences are beyond these digits. In the middle of the track (case 1) the flat gap
/// leaves the weighted centre 1 µm uncertain. Peak pressures part by up to 0.3 % as yaw and roll
/// grow, probably because CONTACT interpolates the turned wheel on a grid of the elements' size:
/// Hertz's theory with the analytic curvatures sides with ours to 0.1 %. Areas are counted in
/// elements and differ by at most two of them.
#[test]
fn the_benchmarks_positions_meet_contact() {
    println!(
        "own minus CONTACT's: location and height in µm, angle in mrad, the rest in %; \
         then Hertz's ellipse minus our own in %"
    );
    println!(
        "case      x      y      z  angle  height  approach   peak   area elements |  peak   area"
    );
    let composite = STEEL.shear_modulus / (1.0 - STEEL.poisson);
    let rows = rows(Side::Left);
    assert_eq!(rows.len(), 11);
    for row in rows {
        let pair = benchmark(Side::Left, &row.position);
        let frame = pair.overlap_frame(row.approach / row.angle.cos());
        let plane = ContactPlane::new(&pair, frame, 0.0);
        let (approach, outcome) =
            Pressed::new(&plane, 1.03 * row.approach, ELEMENT).loaded(row.force, row.approach);
        let found = outcome.observables;
        let [x, y, z] = [0, 1, 2].map(|c| (frame.origin[c] - row.reference[c]) * 1e6);
        let angle = (frame.angle - row.angle) * 1e3;
        let height = (pair.height() + approach / frame.angle.cos() - row.height) * 1e6;
        let percent = |value: f64, reference: f64| (value / reference - 1.0) * 100.0;
        let (approach, peak) =
            (percent(approach, row.approach), percent(found.peak_pressure, row.peak));
        let area = percent(found.contact_area, row.elements * ELEMENT * ELEMENT);
        let elements = found.contact_elements as f64 - row.elements;
        let ([small, large], _) = pair.curvatures().principal();
        let hertz = hertz_ellipse(composite, 0.5 * small, 0.5 * large, row.force);
        let hertz_peak = percent(hertz.peak_pressure, found.peak_pressure);
        let hertz_area = percent(PI * hertz.semi_axis_x * hertz.semi_axis_y, found.contact_area);
        println!(
            "{:>4} {x:6.2} {y:6.2} {z:6.2} {angle:6.3} {height:7.2} {approach:9.2} \
             {peak:6.2} {area:6.2} {elements:8} | {hertz_peak:5.1} {hertz_area:6.1}",
            row.name
        );
        let case = &row.name;
        assert!(
            x.abs() < 0.1 && y.abs() < 1.0 && z.abs() < 0.06,
            "case {case}: location ({x}, {y}, {z}) µm"
        );
        let on_rail = pair.to_rail(frame.origin);
        assert!(
            (0..2).all(|c| (on_rail[c] - row.rail[c]).abs() < 1e-6),
            "case {case}: {on_rail:?} on the rail"
        );
        assert!(angle.abs() < 0.06, "case {case}: angle by {angle} mrad");
        let roll_digit = if row.position.roll.abs() < 1e-3 { 5e-8 } else { 5e-6 };
        assert!(height.abs() < 0.1 + 0.75e6 * roll_digit, "case {case}: height by {height} µm");
        assert!(
            approach.abs() < 0.1 && peak.abs() < 0.3 && elements.abs() <= 2.0,
            "case {case}: {approach} % {peak} % {elements}"
        );
        // If the wheelset stands in the middle, the wheel's and the rail's profiles nearly follow
        // each other, and Hertz's paraboloid is no picture of the gap. Elements counted whole
        // exceed the area by a fraction of the outermost ones.
        if case == "1" {
            assert!(hertz_peak > 4.0 && hertz_area < -15.0);
        } else {
            assert!(
                hertz_peak.abs() < 0.2 && (-4.0..0.0).contains(&hertz_area),
                "case {case}: Hertz {hertz_peak} % {hertz_area} %"
            );
        }
    }
}

/// A user has the benchmark as a scene with a wheel on a rail and the load given: the program
/// chooses the plane of contact, Ω and its elements before the approach is known. The limits are
/// those of use: 0.05 mm, peak pressure 1 %, area 3 %.
#[test]
fn scenes_of_a_wheel_on_a_rail_meet_contact() {
    let surfaces = profiles();
    println!(
        "case     x      y      z in µm  angle in mrad  approach  peak  area in %  \
         Hertz's peak and area over ours"
    );
    for row in rows(Side::Left) {
        let scene = row.scene();
        let numerics = numerics(Mesh::Across(64), Projection::Average, 1e-7);
        let (outcome, _) =
            contact::solve(&scene, &numerics, &surfaces, &mut contact::Operators::default())
                .unwrap();
        assert_eq!(outcome.status, Status::Certified);
        let (end, rail, hertz) =
            (outcome.last().unwrap(), outcome.rail.unwrap(), outcome.hertz.unwrap());
        let percent = |value: f64, reference: f64| (value / reference - 1.0) * 100.0;
        let off = [0, 1, 2].map(|c| (rail.track[c] - row.reference[c]) * 1e6);
        let area = percent(end.observables.contact_area, row.elements * ELEMENT * ELEMENT);
        let peak = percent(end.observables.peak_pressure, row.peak);
        let approach = percent(end.motion.approach, row.approach);
        println!(
            "{:>4} {:6.1} {:6.1} {:6.1} {:6.3} {approach:6.2} {peak:6.2} {area:6.2} {:7.3} {:6.3}",
            row.name,
            off[0],
            off[1],
            off[2],
            (rail.angle - row.angle) * 1e3,
            hertz.peak_pressure / end.observables.peak_pressure,
            hertz.area / end.observables.contact_area
        );
        assert_eq!(
            (end.observables.edge_elements, end.observables.patches),
            (0, 1),
            "case {}",
            row.name
        );
        assert!(end.observables.force_x.abs() < 1e-6 * row.force, "like materials do not couple");
        assert!(
            off.iter().all(|off| off.abs() < 5.0) && ((rail.angle - row.angle) * 1e3).abs() < 0.1,
            "case {}: {off:?} µm",
            row.name
        );
        assert!(
            approach.abs() < 1.0 && peak.abs() < 1.0 && area.abs() < 3.0,
            "case {}: {approach} % {peak} % {area} %",
            row.name
        );
    }
}

/// Returns the mesh of elements that are at most as large as CONTACT's.
pub(crate) fn fine_mesh(domain: &Domain) -> Mesh {
    Mesh::Exact([domain.width_x, domain.width_y].map(|width| (width / ELEMENT).ceil() as u32))
}

fn solved_on(mesh: Mesh, scene: &Scene, surfaces: &Surfaces) -> contact::model::Outcome {
    let numerics = numerics(mesh, Projection::Midpoint, 1e-6);
    let (outcome, _) =
        contact::solve(scene, &numerics, surfaces, &mut contact::Operators::default()).unwrap();
    assert_eq!(outcome.status, Status::Certified);
    outcome
}

/// The right wheel of the benchmark comes to its flange, on which the plane of contact is steep,
/// and in case 11 it stands on its tread and on the root of its flange. The elements are CONTACT's.
#[test]
fn the_right_wheel_meets_contact_on_tread_and_flange() {
    let surfaces = profiles();
    println!(
        "case     x      y      z in µm  angle in mrad  height in µm  approach  peak in %  elements"
    );
    let rows = rows(Side::Right);
    assert_eq!(rows.len(), 11);
    for row in rows {
        let scene = row.scene();
        let domain = domain(&scene, &surfaces).expect("an Ω");
        let mesh = fine_mesh(&domain);
        let outcome = solved_on(mesh, &scene, &surfaces);
        let (end, rail) = (outcome.last().unwrap(), outcome.rail.unwrap());
        let percent = |value: f64, reference: f64| (value / reference - 1.0) * 100.0;
        let off = [0, 1, 2].map(|c| (rail.track[c] - row.reference[c]) * 1e6);
        let [nx, ny] = mesh.sides().map(f64::from);
        let element = domain.width_x * domain.width_y / (nx * ny);
        let angle = (rail.angle - row.angle) * 1e3;
        let height = (rail.wheelset_height - row.height) * 1e6;
        let approach = percent(end.motion.approach, row.approach);
        let peak = percent(end.observables.peak_pressure, row.peak);
        let elements =
            end.observables.contact_elements as f64 * element / (ELEMENT * ELEMENT) / row.elements;
        println!(
            "{:>4} {:6.1} {:6.1} {:6.1} {angle:6.3} {height:6.2} {approach:6.2} {peak:6.2} \
             {elements:6.3} {mesh:?}",
            row.name, off[0], off[1], off[2],
        );
        let case = &row.name;
        if case == "11" {
            // CONTACT leaves out a part of what the patches lower each other (see the test below).
            assert_eq!(end.observables.patches, 2);
            assert!(
                (2.0..4.0).contains(&approach) && (1.0..3.0).contains(&peak),
                "{approach} {peak}"
            );
            continue;
        }
        assert_eq!(end.observables.patches, 1, "case {case}");
        assert!(off.iter().all(|off| off.abs() < 2.0), "case {case}: {off:?} µm");
        assert!(angle.abs() < 0.15 && height.abs() < 0.5, "case {case}: {angle} mrad {height} µm");
        assert!(approach.abs() < 0.7 && peak.abs() < 0.6, "case {case}: {approach} % {peak} %");
        // On the flange the contact is three elements wide.
        assert!((elements - 1.0).abs() < 0.1, "case {case}: {elements}");
    }
}

/// In case 11 the wheel stands on its tread and on the root of its flange, 12 mm apart. CONTACT
/// puts both into one plane of contact, and, as they are more than 4 mm apart, counts only a part
/// of what one patch lowers the surface under the other. At CONTACT's approach the
/// plane and the height of the wheelset are CONTACT's, and its load lies between those of patches
/// that feel each other fully and not at all.
#[test]
fn a_wheel_on_two_patches_has_the_plane_of_contacts() {
    let surfaces = profiles();
    let row = rows(Side::Right).into_iter().find(|row| row.name == "11").expect("case 11");
    let mut scene = row.scene();
    scene.loading = Loading::path(vec![Step { approach: Some(row.approach), ..Step::default() }]);
    let both = domain(&scene, &surfaces).expect("an Ω");
    let solve = |domain: Domain| {
        let scene = Scene { domain: Some(domain), ..scene.clone() };
        solved_on(fine_mesh(&domain), &scene, &surfaces)
    };
    let outcome = solve(both);
    let rail = outcome.rail.unwrap();
    let off = [0, 1, 2].map(|c| (rail.track[c] - row.reference[c]) * 1e6);
    let angle = (rail.angle - row.angle) * 1e3;
    let height = (rail.wheelset_height - row.height) * 1e6;
    println!("{off:?} µm, {angle} mrad, height {height} µm");
    // The two patches weigh as the third power of their depths, so that 1 % of a depth moves the
    // common centre by 0.1 mm.
    assert!(off[0].abs() < 50.0 && off[1].abs() < 250.0, "{off:?} µm");
    // CONTACT prints the height to 0.05 µm, and the roll of 5e-8 is 0.04 µm.
    assert!(angle.abs() < 4.0 && height.abs() < 0.2, "{angle} mrad, {height} µm");
    let end = outcome.last().unwrap().observables;
    assert_eq!(end.patches, 2);
    // Each half of Ω holds one patch.
    let half = |side: f64| Domain {
        width_y: 0.5 * both.width_y,
        center_y: both.center_y + side * 0.25 * both.width_y,
        ..both
    };
    let alone = [-1.0, 1.0].map(|side| solve(half(side)).last().unwrap().observables);
    assert!(alone.iter().all(|alone| alone.patches == 1));
    let apart: f64 = alone.iter().map(|alone| alone.load).sum();
    let counted = (apart - row.force) / (apart - end.load);
    let elements: u64 = alone.iter().map(|alone| alone.contact_elements).sum();
    println!(
        "load {} N together, {apart} N apart: CONTACT counts {counted:.2} of the interaction; \
         elements {} together, {elements} apart",
        end.load, end.contact_elements
    );
    // CONTACT's factor of ((8 mm − d)/4 mm)^0.8 is 0.26 for regions of overlap d = 7.3 mm apart.
    assert!((0.1..0.5).contains(&counted), "{counted}");
}

/// A forecast counts the time to place the wheel, which few elements take no longer than.
#[test]
fn forecasts_count_the_placing_of_the_wheel() {
    let surfaces = profiles();
    let scene = rows(Side::Right)[4].scene();
    let [few, some, many] = [8, 20, 160].map(|n| {
        let numerics = numerics(Mesh::Across(n), Projection::Average, 1e-7);
        contact::forecast(&scene, &numerics, &surfaces).expect("a forecast").seconds
    });
    assert!(few > 4e-3 && some < 2.0 * few && many > 5.0 * few, "{few} {some} {many}");
}

/// Returns points of an arc of `radius` around (0, `center`), upwards (−1) or downwards (1), `half`
/// to either side.
fn arc(center: f64, radius: f64, direction: f64, half: f64) -> Vec<[f64; 2]> {
    (-400..=400)
        .map(|i| f64::from(i) / 400.0 * half / radius)
        .map(|a| [radius * a.sin(), center + direction * radius * a.cos()])
        .collect()
}

/// A wheel whose profile is an arc around a point of the axle is a part of a sphere: no yaw and no
/// roll can be felt. On a rail with a round top the gap and Hertz's contact are known.
#[test]
fn a_spherical_wheel_on_a_round_rail_is_hertzs() {
    let (radius, crown) = (0.46, 0.3);
    let wheel = Profile::from_points(ProfileKind::Wheel, arc(-radius, radius, 1.0, 0.05))
        .expect("a profile");
    let rail =
        Profile::from_points(ProfileKind::Rail, arc(crown, crown, -1.0, 0.04)).expect("a profile");
    let wheelset = Wheelset {
        rolling_radius: radius,
        flange_back_distance: 1.36,
        flange_back_to_origin: 0.07,
    };
    let track = Track { gauge: 1.45, gauge_depth: 0.002 };
    for position in [
        Position::default(),
        Position { lateral: 3e-3, yaw: 0.02, roll: -0.004 },
        Position { lateral: -2e-3, yaw: -0.03, roll: 0.01 },
    ] {
        for side in [Side::Left, Side::Right] {
            let pair = WheelOnRail::new(&wheel, &rail, &wheelset, &track, side, &position)
                .expect("a contact");
            let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
            for i in -20..=20 {
                for j in -20..=20 {
                    let (x, s) = (3e-4 * f64::from(i), 3e-4 * f64::from(j));
                    // The formula is radius − √(radius² − r²) without cancellation.
                    let drop = |radius: f64, r2: f64| r2 / (radius + (radius * radius - r2).sqrt());
                    let exact = drop(radius, x * x + s * s) + drop(crown, s * s);
                    // The splines' error is of the fourth power of a step of 0.1 mm.
                    assert!((plane.gap(x, s).expect("a gap") - exact).abs() < 1e-11, "{x} {s}");
                }
            }
        }
    }

    let pair = WheelOnRail::new(
        &wheel,
        &rail,
        &wheelset,
        &track,
        Side::Left,
        &Position { lateral: 3e-3, yaw: 0.02, roll: -0.004 },
    )
    .unwrap();
    let (along, across) = (0.5 / radius, 0.5 / radius + 0.5 / crown);
    let force = 1e4;
    let hertz = hertz_ellipse(STEEL.shear_modulus / (1.0 - STEEL.poisson), along, across, force);
    let plane = ContactPlane::new(&pair, pair.tangent_frame(), 0.0);
    let mut errors = Vec::new();
    for element in [0.4e-3, 0.2e-3] {
        let (approach, outcome) =
            Pressed::new(&plane, 1.1 * hertz.approach, element).loaded(force, hertz.approach);
        errors.push((approach / hertz.approach - 1.0).abs());
        assert!((approach / hertz.approach - 1.0).abs() < 1e-3, "{approach} {}", hertz.approach);
        assert!(
            (outcome.observables.peak_pressure / hertz.peak_pressure - 1.0).abs() < 3e-3,
            "{outcome:?} {hertz:?}"
        );
        let area = outcome.observables.contact_area / (PI * hertz.semi_axis_x * hertz.semi_axis_y);
        let outline = PI * (hertz.semi_axis_x + hertz.semi_axis_y) * 0.5 * element
            / (PI * hertz.semi_axis_x * hertz.semi_axis_y);
        assert!((area - 1.0).abs() < outline, "{area}");
    }
    println!("approach beside Hertz's at elements of 0.4 and 0.2 mm: {errors:?}");
}
