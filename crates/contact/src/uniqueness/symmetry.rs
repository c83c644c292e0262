//! The symmetries of Ω with its mesh, and the operator in a basis adapted to them.
//!
//! The reflections x → −x, y → −y and, for squares of square elements, x ↔ y map the operator onto
//! itself as far as they map Ω onto itself. A form with weights that are constant on their orbits
//! then falls into blocks, one for each combination of signs that a field can take under them. With
//! all three (the group D₄ of the square) there are four blocks of an eighth of the size, and one
//! of a quarter that occurs twice.

use faer::Mat;

use super::system::System;
use crate::influence::Entry;

/// The reflections, out of three, that map Ω and its mesh onto themselves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Symmetries {
    /// The reflection x → −x.
    pub(super) x: bool,
    /// The reflection y → −y.
    pub(super) y: bool,
    /// The exchange x ↔ y.
    pub(super) swap: bool,
}

/// A product of reflections, of which the swap comes last.
#[derive(Clone, Copy)]
struct GridSymmetry {
    x: bool,
    y: bool,
    swap: bool,
}

impl Symmetries {
    /// Finds the symmetries of the system under which a number per element of Ω has the same value
    /// on images. `same` compares the numbers of two elements.
    pub(super) fn of(system: &System, same: impl Fn(usize, usize) -> bool) -> Self {
        let grid = system.grid();
        let (nx, ny) = (grid.nx(), grid.ny());
        let number = numbers(system);
        let keeps = |symmetry: GridSymmetry| {
            (0..grid.len()).all(|e| {
                match (number[e], number[symmetry.element(grid.position(e), nx, ny)]) {
                    (Some(a), Some(b)) => same(a, b),
                    (None, None) => true,
                    _ => false,
                }
            })
        };
        let none = GridSymmetry { x: false, y: false, swap: false };
        Self {
            x: keeps(GridSymmetry { x: true, ..none }),
            y: keeps(GridSymmetry { y: true, ..none }),
            swap: nx == ny
                && asymmetry(system) < 1e-11
                && keeps(GridSymmetry { swap: true, ..none }),
        }
    }

    fn members(self) -> impl Iterator<Item = GridSymmetry> {
        let all = [false, true];
        all.into_iter()
            .flat_map(move |swap| {
                all.into_iter()
                    .flat_map(move |y| all.into_iter().map(move |x| GridSymmetry { x, y, swap }))
            })
            .filter(move |symmetry| {
                (self.x || !symmetry.x) && (self.y || !symmetry.y) && (self.swap || !symmetry.swap)
            })
    }

    /// Returns the image of each element of Ω under each product of the reflections.
    pub(super) fn images(self, system: &System) -> Vec<Vec<usize>> {
        let grid = system.grid();
        let number = numbers(system);
        self.members()
            .map(|symmetry| {
                grid.active()
                    .filter_map(|e| {
                        number[symmetry.element(grid.position(e), grid.nx(), grid.ny())]
                    })
                    .collect()
            })
            .collect()
    }

    /// Returns for each element of Ω its orbit. Orbits are numbered in the order of their first
    /// elements.
    pub(super) fn orbits(self, system: &System) -> Vec<usize> {
        let grid = system.grid();
        let number = numbers(system);
        let mut orbit = vec![usize::MAX; system.elements()];
        let mut count = 0;
        for (place, e) in grid.active().enumerate() {
            if orbit[place] == usize::MAX {
                for symmetry in self.members() {
                    if let Some(image) =
                        number[symmetry.element(grid.position(e), grid.nx(), grid.ny())]
                    {
                        orbit[image] = count;
                    }
                }
                count += 1;
            }
        }
        orbit
    }

    /// Returns the combinations of signs that fields can take under the reflections: the
    /// reflections that matter, and the signs under x → −x, y → −y and x ↔ y.
    fn characters(self) -> Vec<(Self, [f64; 3])> {
        let signs = [1.0, -1.0];
        if self.x && self.y && self.swap {
            // The reflections x → −x and y → −y are conjugate. Fields that are even under one and
            // odd under the other come in pairs, images of each other under x ↔ y: one of the two
            // blocks stands for both.
            let mut all: Vec<_> =
                signs.iter().flat_map(|&s| signs.map(|t| (self, [s, s, t]))).collect();
            all.push((Self { swap: false, ..self }, [1.0, -1.0, 1.0]));
            return all;
        }
        let choices = |has: bool| if has { &signs[..] } else { &signs[..1] };
        let mut all = Vec::new();
        for &x in choices(self.x) {
            for &y in choices(self.y) {
                for &t in choices(self.swap) {
                    all.push((self, [x, y, t]));
                }
            }
        }
        all
    }

    /// Returns the blocks of the operator, without the empty ones.
    pub(super) fn blocks(self, system: &System) -> Vec<Block> {
        let orbit = self.orbits(system);
        let characters = self.characters();
        characters
            .into_iter()
            .map(|(group, signs)| Block::new(system, group, signs, &orbit))
            .filter(|b| !b.is_empty())
            .collect()
    }

    /// Returns the rows of the largest block, without making it.
    pub(super) fn rows(self, system: &System) -> usize {
        self.characters()
            .into_iter()
            .map(|(group, signs)| basis(system, group, signs).len())
            .max()
            .unwrap_or(0)
    }
}

impl GridSymmetry {
    fn element(self, (i, j): (usize, usize), nx: usize, ny: usize) -> usize {
        let (i, j) = (if self.x { nx - 1 - i } else { i }, if self.y { ny - 1 - j } else { j });
        if self.swap { i * nx + j } else { j * nx + i }
    }

    /// Returns the image of a component n = 0, x = 1, y = 2, and its sign.
    fn component(self, c: usize) -> (usize, f64) {
        let sign = if (self.x && c == 1) || (self.y && c == 2) { -1.0 } else { 1.0 };
        (if self.swap && c > 0 { 3 - c } else { c }, sign)
    }

    fn character(self, signs: [f64; 3]) -> f64 {
        [self.x, self.y, self.swap]
            .into_iter()
            .zip(signs)
            .map(|(does, sign)| if does { sign } else { 1.0 })
            .product()
    }
}

/// Returns the place of each element of the grid among those of Ω.
fn numbers(system: &System) -> Vec<Option<usize>> {
    let mut numbers = vec![None; system.grid().len()];
    for (place, e) in system.grid().active().enumerate() {
        numbers[e] = Some(place);
    }
    numbers
}

/// Measures how far the operator is from symmetric under x ↔ y: the sum of |difference| over all
/// coefficients, in units of the largest diagonal entry. It is infinite unless the grid is square.
pub(super) fn asymmetry(system: &System) -> f64 {
    let (table, n) = (system.table(), system.grid().nx());
    if n != system.grid().ny() {
        return f64::INFINITY;
    }
    let value = |entry: Entry, di: usize, dj: usize| table.row(entry, dj as i64)[n - 1 + di];
    let mut sum = 0.0;
    for dj in 0..n {
        for di in 0..n {
            for (a, b) in [
                (Entry::Nn, Entry::Nn),
                (Entry::Xx, Entry::Yy),
                (Entry::Xy, Entry::Xy),
                (Entry::Nx, Entry::Ny),
            ] {
                // There are four quadrants, and each pair stands for at most four entries of the
                // 3×3 block.
                sum += 16.0 * (value(a, di, dj) - value(b, dj, di)).abs();
            }
        }
    }
    sum / system.largest_diagonal()
}

/// The operator εI + A on the fields with one combination of signs under the reflections, in an
/// orthonormal basis of sums of images.
pub(super) struct Block {
    /// The matrix.
    pub(super) matrix: Mat<f64>,
    /// The orbit of elements of each basis vector.
    pub(super) orbit: Vec<usize>,
    /// True for each basis vector of pressures, false for one of tangential tractions.
    pub(super) normal: Vec<bool>,
    /// The largest possible distance of the matrix from the exact one of the table's coefficients,
    /// in the ∞-norm. An entry is a sum of up to eight of them of both signs, times the rounded
    /// root of a power of two. So it may be smaller than the numbers that its rounding goes by.
    pub(super) rounding: f64,
}

/// An image of an element's component under a symmetry.
struct Image {
    /// The element of the grid.
    element: usize,
    /// The component n = 0, x = 1, y = 2.
    component: usize,
    /// The sign with which it belongs to a sum of images.
    sign: f64,
}

/// Returns the images that each basis vector is the sum of, the first with sign 1.
fn basis(system: &System, group: Symmetries, signs: [f64; 3]) -> Vec<Vec<Image>> {
    let grid = system.grid();
    let number = numbers(system);
    let mut seen = vec![[false; 3]; system.elements()];
    let mut basis = Vec::new();
    for c in 0..3 {
        for (place, e) in grid.active().enumerate() {
            if seen[place][c] {
                continue;
            }
            let mut images: Vec<Image> = Vec::with_capacity(8);
            for symmetry in group.members() {
                let element = symmetry.element(grid.position(e), grid.nx(), grid.ny());
                let (component, sign) = symmetry.component(c);
                let sign = sign * symmetry.character(signs);
                if let Some(number) = number[element] {
                    seen[number][component] = true;
                }
                match images
                    .iter_mut()
                    .find(|image| (image.element, image.component) == (element, component))
                {
                    Some(image) => image.sign += sign,
                    None => images.push(Image { element, component, sign }),
                }
            }
            // A field that a reflection maps onto itself with the other sign vanishes.
            let times = images[0].sign;
            if times != 0.0 {
                let scaled = |image: Image| Image { sign: image.sign / times, ..image };
                basis.push(images.into_iter().map(scaled).collect());
            }
        }
    }
    basis
}

impl Block {
    fn new(system: &System, group: Symmetries, signs: [f64; 3], orbit: &[usize]) -> Self {
        let grid = system.grid();
        let number = numbers(system);
        let basis = basis(system, group, signs);
        let table = system.table();
        let entry = |row: usize, column: usize| {
            let Image { element: e, component: c, .. } = basis[row][0];
            let (ei, ej) = grid.position(e);
            let (mut sum, mut sizes) = (0.0, 0.0);
            for &Image { element: f, component: d, sign } in &basis[column] {
                let (fi, fj) = grid.position(f);
                let block = table.coefficient(ei as i64 - fi as i64, ej as i64 - fj as i64).block();
                let regular = if (e, c) == (f, d) { system.epsilon() } else { 0.0 };
                sum += sign * (block[c][d] + regular);
                sizes += block[c][d].abs() + regular;
            }
            let root = (basis[row].len() as f64 / basis[column].len() as f64).sqrt();
            (sum * root, sizes * root)
        };
        let size = basis.len();
        let mut matrix = Mat::zeros(size, size);
        let mut sums = vec![0.0; size];
        for column in 0..size {
            for row in column..size {
                let (value, sizes) = entry(row, column);
                matrix[(row, column)] = value;
                matrix[(column, row)] = value;
                sums[row] += sizes;
                if row != column {
                    sums[column] += sizes;
                }
            }
        }
        // Each of up to eight images takes a sum of two; a root and a product follow. These are at
        // most eleven roundings.
        let rounding = 16.0 * 0.5 * f64::EPSILON * sums.into_iter().fold(0.0, f64::max);
        let orbit = basis
            .iter()
            .filter_map(|images| number[images[0].element].map(|place| orbit[place]))
            .collect();
        let normal = basis.iter().map(|images| images[0].component == 0).collect();
        Self { matrix, orbit, normal, rounding }
    }

    /// Returns the number of unknowns.
    pub(super) fn len(&self) -> usize {
        self.matrix.nrows()
    }

    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}
