use super::*;

fn design(method: SamplingMethod, count: u32) -> Design {
    Design::new(method, count, 7, 6)
}

/// Returns how many of the first points lie in each of `parts` equal intervals of a dimension.
fn occupation(design: &Design, count: u32, dimension: usize, parts: usize) -> Vec<u32> {
    let mut points = vec![0; parts];
    for index in 0..count {
        points[(design.coordinate(index, dimension) * parts as f64) as usize] += 1;
    }
    points
}

/// A change of these numbers gives every stored sample other points.
#[test]
fn the_points_are_fixed() {
    let first = |method| {
        let design = design(method, 12);
        let point = |index| [0, 5].map(|dimension| design.coordinate(index, dimension));
        format!("{:?} {:?}", point(0), point(11))
    };
    insta::assert_snapshot!(SamplingMethod::ALL.map(first).join("\n"));
}

#[test]
fn every_coordinate_is_inside_the_unit_interval() {
    for method in SamplingMethod::ALL {
        for count in [1, 2, 3, 12, 100, 1024] {
            let design = Design::new(method, count, 0, MOST_DIMENSIONS);
            for dimension in [0, 1, MOST_DIMENSIONS - 1] {
                for index in [0, count / 2, count - 1] {
                    let x = design.coordinate(index, dimension);
                    assert!(x > 0.0 && x < 1.0, "{method:?} {count}: {x}");
                }
            }
        }
    }
    // The last index of all, where it need not be one of a hypercube.
    for method in [SamplingMethod::Sobol, SamplingMethod::Halton, SamplingMethod::Random] {
        assert!(design(method, u32::MAX).coordinate(u32::MAX, 5) < 1.0);
    }
    assert!(design(SamplingMethod::LatinHypercube, u32::MAX).coordinate(u32::MAX - 1, 5) < 1.0);
}

#[test]
fn more_points_keep_those_that_there_are() {
    let keeps = |method: SamplingMethod, fewer: u32, more: u32| {
        let (fewer, more) = (design(method, fewer), design(method, more));
        let is_kept = (0..fewer.count()).all(|index| {
            (0..6).all(|axis| fewer.coordinate(index, axis) == more.coordinate(index, axis))
        });
        assert_eq!(fewer.is_kept_by(&more), is_kept, "{method:?}");
        is_kept
    };
    for method in [SamplingMethod::Sobol, SamplingMethod::Halton, SamplingMethod::Random] {
        assert!(keeps(method, 10, 11) && keeps(method, 64, 100));
    }
    assert!(keeps(SamplingMethod::LatinHypercube, 12, 12));
    assert!(keeps(SamplingMethod::LatinHypercube, 12, 24));
    assert!(keeps(SamplingMethod::LatinHypercube, 25, 400));
    assert!(keeps(SamplingMethod::LatinHypercube, 1, 64));
    assert!(!keeps(SamplingMethod::LatinHypercube, 12, 13));
    assert!(!keeps(SamplingMethod::LatinHypercube, 12, 36));
}

#[test]
fn seeds_and_dimensions_differ() {
    for method in SamplingMethod::ALL {
        let column = |seed: u32, dimension: usize| -> Vec<u64> {
            let design = Design::new(method, 16, seed, 2);
            (0..16).map(|index| design.coordinate(index, dimension).to_bits()).collect()
        };
        assert!(column(1, 0) != column(2, 0) && column(1, 0) != column(1, 1), "{method:?}");
    }
}

#[test]
fn each_interval_has_its_points() {
    // The first bⁿ points of a sequence in base b, and all points of a hypercube.
    let sobol = design(SamplingMethod::Sobol, 256);
    assert!((0..6).all(|dimension| occupation(&sobol, 256, dimension, 256) == [1; 256]));
    let halton = design(SamplingMethod::Halton, 1000);
    for (dimension, count) in [(0, 64), (1, 81), (2, 125), (3, 343), (4, 121), (5, 169)] {
        let occupied = occupation(&halton, count, dimension, count as usize);
        assert!(occupied.iter().all(|points| *points == 1), "{dimension}");
    }
    for count in [1, 2, 3, 7, 12, 25, 50, 64, 100, 999] {
        let hypercube = design(SamplingMethod::LatinHypercube, count);
        for dimension in 0..6 {
            let occupied = occupation(&hypercube, count, dimension, count as usize);
            assert!(occupied.iter().all(|points| *points == 1), "{count}: {occupied:?}");
        }
    }
}

#[test]
fn two_dimensions_of_sobol_fill_every_box() {
    let sobol = design(SamplingMethod::Sobol, 256);
    for powers in 0..=8 {
        let sides = [1_usize << powers, 1 << (8 - powers)];
        let mut boxes = vec![0; 256];
        for index in 0..256 {
            let [x, y] = [0, 1].map(|axis| sobol.coordinate(index, axis) * sides[axis] as f64);
            boxes[x as usize * sides[1] + y as usize] += 1;
        }
        assert!(boxes.iter().all(|points| *points == 1), "{sides:?}");
    }
}

/// The mean of a smooth function is known to 1/n for the sequences, and to 1/√n at random.
#[test]
fn means_converge_as_they_should() {
    let error = |method: SamplingMethod, seed: u32| {
        let design = Design::new(method, 4096, seed, 5);
        let value = |index: u32| -> f64 {
            (0..5).map(|dimension| 0.5 + design.coordinate(index, dimension)).product()
        };
        ((0..4096).map(value).sum::<f64>() / 4096.0 - 1.0).abs()
    };
    let typical = |method| (0..20).map(|seed| error(method, seed)).sum::<f64>() / 20.0;
    let [sobol, halton, hypercube, random] = SamplingMethod::ALL.map(typical);
    // One point by itself deviates by √((13/12)⁵ − 1) = 0.70, the mean of all by 0.0088 typically.
    assert!(random > 0.004 && random < 0.014, "{random}");
    // A hypercube leaves what is no sum of functions of one dimension: √(0.0755/0.492) = 0.39.
    assert!((0.25..0.55).contains(&(hypercube / random)), "{hypercube}");
    assert!(halton < 0.2 * random && sobol < 0.05 * random, "{halton} {sobol}");
}

/// In many hypercubes of three points, each pairing of two dimensions comes as often.
#[test]
fn the_pairings_of_a_hypercube_are_random() {
    let mut pairings = std::collections::HashMap::new();
    for seed in 0..6000 {
        let design = Design::new(SamplingMethod::LatinHypercube, 3, seed, 2);
        let mut points: Vec<[u32; 2]> = (0..3)
            .map(|index| [0, 1].map(|axis| (design.coordinate(index, axis) * 3.0) as u32))
            .collect();
        points.sort_unstable();
        *pairings.entry(points).or_insert(0_u32) += 1;
    }
    assert_eq!(pairings.len(), 6);
    // Six pairings of 1000 each deviate by 29.
    assert!(pairings.values().all(|count| (850..1150).contains(count)), "{pairings:?}");
}
