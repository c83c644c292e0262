//! Forces and creepages are inverses of each other, away from saturation, where creepages no longer
//! follow from forces.

use super::{STEADY, case, number, problem, step};
use crate::common::*;
use contact::model::*;

/// The cases that are too near to saturation: the creepage has next to no part in the force.
const SATURATED: [&str; 1] = ["long_saturated"];

/// Prescribes forces of a steady case, and the moment too if `turns`, instead of its creepages and
/// spin, which must come back.
fn come_back(id: &str, turns: bool) {
    let case = case("steady", id);
    let mut given = step(&case, &case["step"]);
    let known = given.rolling.unwrap();
    let result = |name: &str| Some(number(&case["result"], name));
    given.rolling = Some(Rolling { creepage_x: None, creepage_y: None, ..known });
    (given.force_x, given.force_y) = (result("force_x"), result("force_y"));
    if turns {
        // The place about which a spin turns only counts where it is given.
        given.rolling =
            given.rolling.map(|rolling| Rolling { spin: None, spin_center: 0.0, ..rolling });
        given.moment_z = result("moment_z");
    }
    let (scene, numerics) = problem(&case, vec![given]);
    let (end, fields) = certified(&scene, &numerics);
    assert_eq!(end.route, Route::Newton, "{id}");
    let distance = known.dq.unwrap();
    let reach = 0.5 * f64::from(fields.shape[0]) * fields.element[0];
    let Motion { shift_x, shift_y, twist, .. } = end.motion;
    let spin = known.spin.unwrap();
    let found = [
        -shift_x / distance,
        -shift_y / distance + spin * known.spin_center,
        -twist / distance * reach,
    ];
    let wanted = [known.creepage_x.unwrap(), known.creepage_y.unwrap(), spin * reach];
    // Where a case has neither, the slip of the bodies is of the size of μ.
    let size = wanted[0].hypot(wanted[1]).max(wanted[2].abs()).max(1e-3 * number(&case, "mu"));
    for (found, wanted) in found.iter().zip(wanted) {
        let error = (found - wanted).abs() / size;
        assert!(error <= 1e-6, "{id}: {found:e} instead of {wanted:e}, off by {error:e}");
    }
    assert_eq!(Some(end.observables.stick_elements), case["result"]["n_stick"].as_u64(), "{id}");
}

fn tested() -> impl Iterator<Item = &'static str> {
    STEADY.iter().copied().filter(|id| !SATURATED.contains(id))
}

#[test]
fn creepages_come_back_from_their_forces() {
    tested().for_each(|id| come_back(id, false));
}

#[test]
fn creepages_and_spin_come_back_from_forces_and_moment() {
    tested().for_each(|id| come_back(id, true));
}
