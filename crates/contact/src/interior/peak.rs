//! A place where a function of the place is largest, between the points of a grid.

/// The place of a maximum, in the box in which it was sought.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Climbed {
    pub(super) value: f64,
    pub(super) place: [f64; 3],
}

/// Climbs from `start` to a maximum of `f`, which takes several places at a time, in the box
/// between the corners `low` and `high`. It fits a quadratic function through ten places `steps`
/// apart and goes to where that is largest, but no farther than the steps; then with smaller
/// steps. A direction in which the box has no extent is left alone.
///
/// It ends when the steps are 1e-3 of their beginning; the value of a smooth maximum inside the box
/// is then good to 1e-6 of what it changes by in one step of the beginning, and the place to 1e-3
/// of the steps. A climb along a ridge or a wall may end before, after 24 rounds, at the highest
/// place that it has seen.
pub(super) fn climb(
    start: [f64; 3],
    steps: [f64; 3],
    [low, high]: [[f64; 3]; 2],
    f: impl Fn(&[[f64; 3]]) -> Vec<f64>,
) -> Climbed {
    let one = |place: [f64; 3]| f(&[place]).first().copied().unwrap_or(f64::NAN);
    let clamp = |place: [f64; 3]| [0, 1, 2].map(|i| place[i].clamp(low[i], high[i]));
    let free: Vec<usize> = (0..3).filter(|i| high[*i] > low[*i]).collect();
    let mut best = Climbed { value: one(clamp(start)), place: clamp(start) };
    let mut size = 0.5;
    for _ in 0..24 {
        if size < 1e-3 {
            break;
        }
        // The middle of the stencil keeps it inside the box.
        let middle = [0, 1, 2].map(|i| {
            let step = size * steps[i];
            let (least, most) = (low[i] + step, high[i] - step);
            if least <= most { best.place[i].clamp(least, most) } else { 0.5 * (low[i] + high[i]) }
        });
        let place_of =
            |offset: [f64; 3]| clamp([0, 1, 2].map(|i| middle[i] + offset[i] * size * steps[i]));
        let mut offsets = vec![[0.0; 3]];
        for (n, i) in free.iter().enumerate() {
            for sign in [1.0, -1.0] {
                let mut offset = [0.0; 3];
                offset[*i] = sign;
                offsets.push(offset);
            }
            for j in &free[n + 1..] {
                let mut offset = [0.0; 3];
                (offset[*i], offset[*j]) = (1.0, 1.0);
                offsets.push(offset);
            }
        }
        let values = f(&offsets.iter().map(|offset| place_of(*offset)).collect::<Vec<_>>());
        let value_at = |offset: [f64; 3]| {
            let found = offsets.iter().position(|other| *other == offset);
            found.map_or(f64::NAN, |index| values[index])
        };
        let unit = |i: usize, sign: f64| {
            let mut offset = [0.0; 3];
            offset[i] = sign;
            offset
        };
        let zero = values[0];
        let (mut slope, mut curvature) = ([0.0; 3], [[0.0; 3]; 3]);
        for i in &free {
            let (up, down) = (value_at(unit(*i, 1.0)), value_at(unit(*i, -1.0)));
            slope[*i] = 0.5 * (up - down);
            curvature[*i][*i] = up - 2.0 * zero + down;
        }
        for (n, i) in free.iter().enumerate() {
            for j in &free[n + 1..] {
                let mut both = unit(*i, 1.0);
                both[*j] = 1.0;
                let (up_i, up_j) = (value_at(unit(*i, 1.0)), value_at(unit(*j, 1.0)));
                let mixed = value_at(both) - up_i - up_j + zero;
                (curvature[*i][*j], curvature[*j][*i]) = (mixed, mixed);
            }
        }
        let before = best.value;
        for (offset, value) in offsets.iter().zip(&values) {
            if *value > best.value {
                best = Climbed { value: *value, place: place_of(*offset) };
            }
        }
        let target = place_of(summit(&slope, &curvature, &free));
        let value = one(target);
        if value > best.value {
            best = Climbed { value, place: target };
        }
        // The steps are kept while the climb goes on at their scale.
        let moved = (0..3)
            .filter(|i| steps[*i] > 0.0)
            .fold(0.0_f64, |most, i| most.max((best.place[i] - middle[i]).abs() / steps[i]));
        if best.value <= before || moved < 0.7 * size {
            size *= 0.3;
        }
    }
    best
}

/// Returns where a quadratic function is largest in the box |offset| ≤ 1: by coordinates, each in
/// turn, which ends at the maximum of a concave one and climbs in any.
fn summit(slope: &[f64; 3], curvature: &[[f64; 3]; 3], free: &[usize]) -> [f64; 3] {
    let mut offset = [0.0_f64; 3];
    for _ in 0..60 {
        for i in free {
            let others: f64 = (0..3).filter(|j| j != i).map(|j| curvature[*i][j] * offset[j]).sum();
            let rise = slope[*i] + others;
            offset[*i] = if curvature[*i][*i] < 0.0 {
                (-rise / curvature[*i][*i]).clamp(-1.0, 1.0)
            } else {
                rise.signum()
            };
        }
    }
    offset
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_maximum_is_found_between_places() {
        let top = [0.31, -0.17, 0.46];
        let f = |p: [f64; 3]| {
            let d = [0, 1, 2].map(|i| p[i] - top[i]);
            (-d[0] * d[0] - 2.0 * d[1] * d[1] - d[2] * d[2] - 0.8 * d[0] * d[2]).exp()
                + 0.1 * d[0].powi(3)
        };
        let bounds = [[-1.0, -1.0, 0.0], [1.0, 1.0, 2.0]];
        let found = climb([0.0, 0.0, 0.7], [0.3, 0.3, 0.3], bounds, |places| {
            places.iter().copied().map(f).collect()
        });
        assert!((found.value - 1.0).abs() < 1e-6, "{found:?}");
        assert!((0..3).all(|i| (found.place[i] - top[i]).abs() < 1e-3), "{found:?}");
    }

    #[test]
    fn a_wall_holds_the_climber() {
        let bounds = [[-1.0, -1.0, 0.5], [0.2, 1.0, 0.5]];
        let found = climb([-0.5, 0.3, 0.5], [0.1, 0.1, 0.1], bounds, |places| {
            places.iter().map(|[x, y, z]| x - y * y + z).collect()
        });
        assert!((found.place[0] - 0.2).abs() < 1e-6 && found.place[1].abs() < 1e-4, "{found:?}");
        assert_eq!(found.place[2], 0.5);
    }
}
