//! The depth of wear on the material of the foundation, which goes through Ω where the path rolls.

/// The depth on the material at points that stand still in it. A material that passes takes its
/// points along, so that its depths are interpolated once, where they are read, and not in each
/// increment.
#[derive(Clone, Debug)]
pub(super) struct WornMaterial {
    /// The number of elements along x.
    nx: usize,
    /// The depths \[m\], rows of nx + 1 points of which point k stands at the place k − 1 + `ahead`
    /// in units of elements, counted from the centre of the first.
    points: Vec<f64>,
    /// The distance of the points ahead of the elements' centres, from 0 to less than 1.
    ahead: f64,
}

impl WornMaterial {
    /// Returns material on so many elements along x and y that has lost nothing.
    pub(super) fn new([nx, ny]: [usize; 2]) -> Self {
        Self { nx, points: vec![0.0; (nx + 1) * ny], ahead: 0.0 }
    }

    /// Returns the depth at each element \[m\].
    pub(super) fn depth(&self) -> Vec<f64> {
        let rows = self.points.chunks_exact(self.nx + 1);
        let between = |pair: &[f64]| {
            if self.ahead == 0.0 {
                pair[1]
            } else {
                self.ahead * pair[0] + (1.0 - self.ahead) * pair[1]
            }
        };
        rows.flat_map(|row| row.windows(2).map(between)).collect()
    }

    /// Returns the largest depth of a point \[m\].
    pub(super) fn largest(&self) -> f64 {
        self.points.iter().copied().fold(0.0, f64::max)
    }

    /// Returns whether all depths are numbers.
    pub(super) fn is_finite(&self) -> bool {
        self.points.iter().all(|depth| depth.is_finite())
    }

    /// Takes away the depths `worn` \[m\], one for each element, from material that stays where it
    /// is.
    pub(super) fn wear_still(&mut self, worn: &[f64]) {
        if self.ahead != 0.0 {
            self.replace(&self.depth());
        }
        for (points, worn) in
            self.points.chunks_exact_mut(self.nx + 1).zip(worn.chunks_exact(self.nx))
        {
            points[1..].iter_mut().zip(worn).for_each(|(depth, worn)| *depth += worn);
        }
    }

    /// Lets the contact go on towards +x by so many `elements`, which may be below 0, and takes
    /// away the depths `worn` \[m\] from the material that then stands at the elements. Between
    /// elements both share it, so that the volume stays; what comes from outside of Ω is unworn.
    pub(super) fn wear_passing(&mut self, worn: &[f64], elements: f64) {
        self.shift(elements.clamp(f64::MIN, f64::MAX));
        let (ahead, nx) = (self.ahead, self.nx);
        for (points, worn) in self.points.chunks_exact_mut(nx + 1).zip(worn.chunks_exact(nx)) {
            for (pair, worn) in worn.iter().enumerate() {
                points[pair] += ahead * worn;
                points[pair + 1] += (1.0 - ahead) * worn;
            }
        }
    }

    /// Replaces the depths by what unworn material loses that passes the contact in the same way
    /// all along: `worn` \[m\] over so many `elements` towards +x, which may be below 0.
    pub(super) fn wear_steadily(&mut self, worn: &[f64], elements: f64) {
        let mut depth = passed(worn, self.nx, elements.is_sign_positive());
        depth.iter_mut().for_each(|depth| *depth /= elements.abs());
        self.replace(&depth);
    }

    /// Replaces the points by those at the elements' centres, with these depths.
    fn replace(&mut self, depth: &[f64]) {
        self.ahead = 0.0;
        for (points, depth) in
            self.points.chunks_exact_mut(self.nx + 1).zip(depth.chunks_exact(self.nx))
        {
            points[0] = 0.0;
            points[1..].copy_from_slice(depth);
        }
    }

    /// Moves the points against a contact that goes on by so many `elements`, and forgets those
    /// that leave Ω.
    fn shift(&mut self, elements: f64) {
        let place = self.ahead - elements;
        let nearest = place.round();
        let is_whole = (place - nearest).abs() <= 1e-9 * nearest.abs().max(1.0);
        let place = if is_whole { nearest } else { place };
        let whole = place.floor();
        self.ahead = place - whole;
        for points in self.points.chunks_exact_mut(self.nx + 1) {
            let before = points.to_vec();
            for (k, depth) in points.iter_mut().enumerate() {
                let from = k as f64 - whole;
                let is_here = (0.0..before.len() as f64).contains(&from);
                *depth = if is_here { before[from as usize] } else { 0.0 };
            }
            if self.ahead == 0.0 {
                points[0] = 0.0;
            }
        }
    }
}

/// Returns the sums of `worn` over each element and those ahead of it, row by row.
fn passed(worn: &[f64], nx: usize, is_forward: bool) -> Vec<f64> {
    let mut sums = worn.to_vec();
    for row in sums.chunks_exact_mut(nx) {
        if is_forward {
            row.reverse();
        }
        let mut sum = 0.0;
        for depth in row.iter_mut() {
            sum += *depth;
            *depth = sum;
        }
        if is_forward {
            row.reverse();
        }
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two rows of four elements.
    const DEPTH: [f64; 8] = [0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0, 0.0];
    const NOTHING: [f64; 8] = [0.0; 8];

    fn worn(depth: &[f64], size: [usize; 2]) -> WornMaterial {
        let mut material = WornMaterial::new(size);
        material.wear_still(depth);
        material
    }

    #[test]
    fn material_passes_with_its_wear_and_keeps_the_volume() {
        let after = |elements: f64| {
            let mut material = worn(&DEPTH, [4, 2]);
            material.wear_passing(&NOTHING, elements);
            material
        };
        let volume = |depth: &[f64]| depth.iter().sum::<f64>();
        assert_eq!(after(1.0).depth(), [1.0, 2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0]);
        assert_eq!(after(-1.0).depth(), [0.0, 0.0, 1.0, 2.0, 0.0, 0.0, 0.0, 4.0]);
        assert_eq!(after(1.0 + 1e-13).depth(), after(1.0).depth());
        assert_eq!(after(0.25).depth(), [0.25, 1.25, 1.5, 0.0, 0.0, 1.0, 3.0, 0.0]);
        for elements in [0.25, 0.5, -0.75, 0.0, -1.0, 1.0] {
            assert_eq!(volume(&after(elements).depth()), volume(&DEPTH), "{elements}");
            assert_eq!(after(elements).largest(), 4.0, "{elements}");
        }
        // Whatever leaves Ω is gone, however far the contact goes.
        for elements in [5.0, -5.0, 1e300, f64::MAX, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(after(elements).depth(), NOTHING, "{elements}");
        }
    }

    /// A depth comes along as it is, however many increments the way has, and whatever parts of
    /// elements they are.
    #[test]
    fn a_long_way_does_not_smear_a_depth() {
        let mut spike = vec![0.0; 64];
        spike[40] = 3.0;
        for (elements, increments, end) in
            [(0.3, 100, 10), (-0.1, 200, 60), (1.0 / 3.0, 90, 10), (-1.25, 16, 60)]
        {
            let mut material = worn(&spike, [64, 1]);
            for _ in 0..increments {
                material.wear_passing(&[0.0; 64], elements);
                assert_eq!(material.largest(), 3.0, "{elements}");
            }
            let depth = material.depth();
            assert_eq!((depth[end], depth.iter().sum::<f64>()), (3.0, 3.0), "{elements}");
        }
        let mut material = worn(&spike, [64, 1]);
        (0..7).for_each(|_| material.wear_passing(&[0.0; 64], 0.1));
        let depth = material.depth();
        assert!((depth[39] - 2.1).abs() < 1e-14 && (depth[40] - 0.9).abs() < 1e-14);
        // What stays where it is afterwards is worn where it is.
        material.wear_still(&spike);
        assert!((material.depth()[40] - 3.9).abs() < 1e-14);
    }

    #[test]
    fn what_passes_loses_what_it_has_slipped_by() {
        let after = |elements: f64| {
            let mut material = WornMaterial::new([4, 2]);
            material.wear_passing(&DEPTH, elements);
            material.depth()
        };
        for elements in [1.0, -1.0, 2.0, 1e-300, -1e-300, f64::MAX] {
            assert_eq!(after(elements), DEPTH, "{elements}");
        }
        for elements in [1e-5, -1e-5, 4.0 - 1e-5] {
            let pairs = after(elements).into_iter().zip(DEPTH);
            pairs.for_each(|(depth, worn)| assert!((depth - worn).abs() < 1e-4, "{elements}"));
        }
        let mut long = [0.0; 32];
        long[16] = 2.0;
        for elements in [0.125, -0.125, 0.75, -1.5] {
            let mut material = WornMaterial::new([32, 1]);
            for _ in 0..4 {
                material.wear_passing(&long, elements);
            }
            assert!((material.depth().iter().sum::<f64>() - 8.0).abs() < 1e-14, "{elements}");
        }
    }

    /// In steps of an element the material stays as it is; in others, it does behind the contact.
    #[test]
    fn steady_wear_sums_from_the_leading_edge_and_goes_on_so() {
        let steady = |elements: f64| {
            let mut material = worn(&DEPTH, [4, 2]);
            material.wear_steadily(&DEPTH, elements);
            material
        };
        assert_eq!(steady(1.0).depth(), [3.0, 3.0, 2.0, 0.0, 4.0, 4.0, 4.0, 0.0]);
        assert_eq!(steady(-1.0).depth(), [0.0, 1.0, 3.0, 3.0, 0.0, 0.0, 4.0, 4.0]);
        assert_eq!(steady(2.0).depth(), [1.5, 1.5, 1.0, 0.0, 2.0, 2.0, 2.0, 0.0]);
        for elements in [1.0, -1.0] {
            let mut material = steady(elements);
            for _ in 0..3 {
                material.wear_passing(&DEPTH, elements);
                assert_eq!(material.depth(), steady(elements).depth());
            }
        }
        for elements in [0.25, -0.25, 0.5, -0.125] {
            let mut material = steady(elements);
            (0..48).for_each(|_| material.wear_passing(&DEPTH, elements));
            let behind = if elements > 0.0 { [0, 4] } else { [3, 7] };
            let expected = steady(elements).depth();
            for e in behind {
                assert!((material.depth()[e] - expected[e]).abs() < 1e-12, "{elements}");
            }
        }
    }
}
