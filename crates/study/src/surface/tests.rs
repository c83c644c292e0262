use proptest::prelude::*;

use super::*;

fn npy(descr: &str, fortran: &str, shape: &str, body: &[u8]) -> Vec<u8> {
    let mut header =
        format!("{{'descr': {descr}, 'fortran_order': {fortran}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    bytes.extend(body);
    bytes
}

fn map(bytes: &[u8], reading: MapReading<'_>) -> Result<HeightMap, String> {
    read(bytes, &reading).map_err(|faults| faults.to_string())
}

fn in_unit(unit: &str) -> MapReading<'_> {
    MapReading { unit: Some(unit), ..MapReading::default() }
}

fn surface(text: &str) -> Surface {
    map(text.as_bytes(), in_unit("um")).unwrap_or_else(|why| panic!("{text:?}: {why}")).surface
}

fn refusal(text: &str) -> String {
    map(text.as_bytes(), in_unit("um")).map(|read| read.note).unwrap_err()
}

#[test]
fn text_and_npy_agree() {
    let expected = surface("# um\n1, 2, 3\n4, 5, 6 # last\n");
    assert_eq!((expected.columns(), expected.rows()), (3, 2));
    assert_eq!(expected.heights(), [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]);
    for text in [
        "1;2;3\r\n4;5;6",
        "\u{feff}1 2\t3\n\n  4 5 6\n",
        "1,2,3,\n4,5,6,\n",
        "1,2,3,\n4,5,6\n",
        "% heights\n1 2 3\n// more\n4 5 6\n! end",
        "; heights\n* of a punch\n'a text'\n\"1\",\"2\",\"3\"\n\"4\",\"5\",\"6\"",
        "1.0D0 2e0 3\r4 5 6.0d+00\r",
        "1,0 2,0 3,0\n4,0 5,0 6,0",
        "1,0;2;3\n4;5;6,0",
        "1,0\t2\t3\n4\t5\t6,0\t\n",
        "----------\n1 2 3\n4 5 6\n\u{1a}",
    ] {
        assert_eq!(surface(text), expected, "{text:?}");
    }
    let utf16: Vec<u8> = "1,2,3\r\n4,5,6".encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(map(&utf16, in_unit("um")).unwrap().surface, expected);
    let latin = b"# H\xf6he in \xb5m\n1 2 3\n4 5 6\n";
    assert_eq!(map(latin, in_unit("um")).unwrap().surface, expected);

    let of_npy = |descr: &str, fortran: &str, body: Vec<u8>| {
        map(&npy(descr, fortran, "(2, 3)", &body), in_unit("um")).unwrap().surface
    };
    let doubles: Vec<u8> = (1..=6).flat_map(|x| f64::from(x).to_le_bytes()).collect();
    assert_eq!(of_npy("'<f8'", "False", doubles), expected);
    let by_columns: Vec<u8> =
        [1, 4, 2, 5, 3, 6].iter().flat_map(|x| i16::to_be_bytes(*x)).collect();
    assert_eq!(of_npy("\">i2\"", "True", by_columns), expected);
    let halves = [0x3c00u16, 0x4000, 0x4200, 0x4400, 0x4500, 0x4600];
    assert_eq!(
        of_npy("'<f2'", "False", halves.iter().flat_map(|x| x.to_le_bytes()).collect()),
        expected
    );
    assert_eq!(
        of_npy("'>f2'", "False", halves.iter().flat_map(|x| x.to_be_bytes()).collect()),
        expected
    );
    assert_eq!(
        name(&expected),
        name(&map(b"1e-6 2e-6 3e-6\n4e-6 5e-6 6e-6", in_unit("m")).unwrap().surface)
    );
    assert_ne!(name(&expected), name(&surface("1 2\n3 4\n5 6")));
}

/// A unit moves the decimal point of the text, which is then rounded once.
#[test]
fn the_same_map_in_another_unit_has_the_same_name() {
    let micrometres = "-23.461914062 -21.997070312\n0.1 0.3\n";
    let millimetres = "-0.023461914062 -0.021997070312\n1e-4 0.0003\n";
    assert_eq!(
        name(&surface(micrometres)),
        name(&map(millimetres.as_bytes(), in_unit("mm")).unwrap().surface)
    );
}

#[test]
fn the_bytes_and_the_name_are_fixed() {
    let surface = map(b"1 2\n3 4\n0 -0\n", in_unit("m")).unwrap().surface;
    insta::assert_snapshot!(name(&surface), @"bf3de6e0509f95f2996d7e0e6a2c6cfff94ac546ded61b5277b27200a61da07b");
    assert_eq!(decode_surface(&encode_surface(&surface)).as_ref(), Ok(&surface));
    let excluded = surface.clone().excluding(vec![true, false, false, false, false, true]).unwrap();
    assert_eq!(decode_surface(&encode_surface(&excluded)).as_ref(), Ok(&excluded));
    assert_ne!(name(&excluded), name(&surface));
    assert!(decode_surface(&encode(&(2u64, 2u64, vec![0.0; 3]))).is_err());
    assert!(decode_surface(&encode(&(u64::MAX, u64::MAX, vec![0.0; 1]))).is_err());
    assert!(decode_surface(&encode(&(1u64, 1u64, vec![f64::NAN]))).is_err());
    assert!(decode_surface(&encode_as(2, &(1u64, 1u64, vec![0.0], vec![true]))).is_err());
}

#[test]
fn what_is_no_height_map_says_why() {
    let message = |bytes: &[u8]| map(bytes, in_unit("um")).unwrap_err();
    let ragged = "line 2: not as long as those before it: 1 against 2 numbers";
    assert_eq!(refusal("1 2\n3\n"), ragged);
    assert_eq!(
        refusal("1 2\n3\nx 5"),
        format!(
            "line 3: `x 5` is neither a number nor a comment, and no known line of a header; {ragged}"
        )
    );
    assert_eq!(refusal("1 2\n3 x"), "line 2, value 2: `x` is not a finite number");
    assert_eq!(
        refusal("0,05,0,06"),
        "line 1: `0,05,0,06` can be read with commas between numbers or in them; separate the numbers by semicolons or blanks"
    );
    assert!(
        refusal("0,5 0.6\n")
            .contains("line 1: `0,5 0.6` has a decimal point where line 1 has a comma")
    );
    assert_eq!(refusal(""), "there are no heights in it");
    assert_eq!(refusal("# only words\n"), "there are no heights in it");
    assert_eq!(message(&[0xff, 0xfe, 0x00]), "it is neither an NPY file nor text");
    assert_eq!(
        message(b"PK\x03\x04\x00"),
        "it is a ZIP archive, as NPZ and spreadsheets are; save the heights as text or NPY"
    );
    for (descr, shape, body, says) in [
        ("'<f8'", "(2,)", 0, "has 1 dimension, not 2"),
        ("'<f8'", "(2, 2, 2)", 0, "has 3 dimensions, not 2"),
        ("'<f8'", "(1, 1)", 7, "has 7 bytes of heights where its header says 8"),
        ("'<f8'", "(0, 4)", 0, "there are no heights in it"),
        ("'<c16'", "(1, 1)", 0, "holds complex numbers"),
        ("'|b1'", "(1, 1)", 0, "holds truth values"),
        ("'|O'", "(1, 1)", 0, "holds Python objects"),
        ("'<f16'", "(1, 1)", 0, "holds numbers of extended precision"),
        ("[('z', '<f8')]", "(1, 1)", 0, "holds records with named fields"),
        ("'<f8'", "(99999999999, 99999999999)", 0, "is too large"),
        ("'<f8'", "(-1, 2)", 0, "has a damaged header"),
    ] {
        let found = message(&npy(descr, "False", shape, &vec![0; body]));
        assert!(found.contains(says), "{descr} {shape}: {found}");
    }
    assert!(message(b"\x93NUMPY\x02\x00\xff\xff\x00\x00").contains("ends before"));
    assert!(
        message(b"\x93NUMPY\x02\x00\xff\xff\xff\xff").contains("has a header of 4294967295 bytes")
    );
    assert_eq!(map(b"1", in_unit("GPa")).unwrap_err(), "`GPa` is not a unit of length");
}

#[test]
fn all_faults_are_named_at_once() {
    let text = (0..20).map(|k| format!("1 {k}x\n")).collect::<String>();
    let said = refusal(&text);
    assert!(
        said.starts_with("line 1, value 2: `0x` is not a finite number; line 2, value 2:"),
        "{said}"
    );
    assert!(said.ends_with("line 10, value 2: `9x` is not a finite number; and 10 more"), "{said}");
}

/// The list of the case: a bump on a grid of 4 × 4.
fn bump(order: &[usize]) -> String {
    let place = |k: usize| -0.375 + 0.25 * k as f64;
    let height = |s: usize| -50.0 * (place(s % 4).powi(2) + place(s / 4).powi(2)) - s as f64;
    order.iter().map(|s| format!("{} {} {}\n", place(s % 4), place(s / 4), height(*s))).collect()
}

#[test]
fn lists_of_points_are_maps_in_any_order() {
    let order: Vec<usize> = (0..16).collect();
    let reading = MapReading { lateral_unit: Some("mm"), ..in_unit("um") };
    let plain = map(bump(&order).as_bytes(), reading).unwrap();
    assert_eq!((plain.surface.columns(), plain.surface.rows()), (4, 4));
    assert_eq!(
        plain.surface.heights()[1],
        -(50.0 * (0.375f64.powi(2) + 0.125f64.powi(2)) + 1.0) / 1e6
    );
    assert_eq!(plain.extents.map(|extent| extent.map(|extent| extent.width)), [Some(1e-3); 2]);
    assert!(
        plain.note.starts_with("a list of x, y and z, whose middle at (0 m, 0 m)"),
        "{}",
        plain.note
    );
    let shuffled: Vec<usize> = (0..16).map(|k| k * 7 % 16).collect();
    assert_eq!(map(bump(&shuffled).as_bytes(), reading).unwrap().surface, plain.surface);
    let titled = format!("X [mm]; Y [mm]; Z [µm]\n{}", bump(&order).replace(' ', ";"));
    assert_eq!(map(titled.as_bytes(), MapReading::default()).unwrap().surface, plain.surface);
    // A point that is missing is a missing pixel.
    let less = bump(&shuffled[1..]);
    assert!(
        map(less.as_bytes(), reading)
            .unwrap_err()
            .contains("1 of 16 pixels are missing, marked by `no point` (once)")
    );
    let filled =
        map(less.as_bytes(), MapReading { missing: MissingRule::Fill, ..reading }).unwrap();
    assert_eq!(filled.surface.columns(), 4);
    for (text, says) in [
        (bump(&order).replace("0.375", "0.3"), "points are not evenly spaced"),
        (bump(&[0, 1, 2, 3]), "all points lie on one line"),
        (bump(&[order.clone(), vec![3]].concat()), "point 17 lies where another one lies"),
        (bump(&order).replace('\n', " 1\n"), "leave out those behind z"),
    ] {
        let found = map(text.as_bytes(), reading).unwrap_err();
        assert!(found.contains(says), "{text}: {found}");
    }
    // Three columns of heights stay a matrix.
    let matrix = "0 1 0\n1 2 1\n1 2 1\n0 1 0\n";
    assert_eq!((surface(matrix).columns(), surface(matrix).rows()), (3, 4));
}

#[test]
fn headers_are_held_against_the_study() {
    let gwyddion = "# Channel: Height\n# Width: 10.00 µm\n# Height: 20.00 µm\n# Value units: m\n1e-6\t2e-6\n3e-6\t4e-6\n";
    let plain = map(gwyddion.as_bytes(), MapReading::default()).unwrap();
    assert_eq!(plain.surface.heights()[3], 4e-6);
    assert_eq!(
        plain.extents.map(|extent| extent.map(|extent| extent.width)),
        [Some(1e-5), Some(2e-5)]
    );
    assert_eq!(
        refusal(gwyddion),
        "line 4: the header says that the heights are in m, the study says um"
    );
    for (header, says) in [
        ("# x-pixels = 3", "line 1: the header says 3 columns, below it there are 2"),
        ("# Value units: V", "line 1: `Value units: V` names what is no unit of length known here"),
        ("# height conversion factor (-> m) = 1e-9", "gives a factor of the heights"),
        ("Serial: 77", "is neither a number nor a comment"),
        ("NX = x", "does not give a whole number"),
        ("# width: 3 furlongs", "gives a width in what is no unit of length"),
    ] {
        let found = refusal(&format!("{header}\n1 2\n3 4\n"));
        assert!(found.contains(says), "{header}: {found}");
    }
    // The first line of an ASCII grid is the northernmost one, and lines may be broken.
    let grid =
        "ncols 2\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0.5\nNODATA_value -9999\n1 2 3\n4\n";
    let read = map(grid.as_bytes(), in_unit("mm")).unwrap();
    assert_eq!(read.surface.heights(), [3e-3, 4e-3, 1e-3, 2e-3]);
    assert_eq!(read.extents[0].map(|extent| extent.width), Some(1e-3));
    assert!(read.note.contains("its first line at the highest y"), "{}", read.note);
    let missing = map(grid.replace("3\n4", "3\n-9999").as_bytes(), in_unit("mm")).unwrap_err();
    assert!(missing.starts_with("1 of 4 pixels are missing, marked by `-9999` (once), the first one in row 1 and column 2"), "{missing}");
}

#[test]
fn missing_pixels_are_counted_and_follow_the_rule() {
    for mark in [
        "nan",
        "NaN",
        "bad",
        "BAD",
        "---",
        "inf",
        "1e38",
        "3.4028235e38",
        "-9999",
        "2147483647",
        "-32768",
        "1.70141e+38",
        "*",
        "n/a",
    ] {
        let text = format!("1 2 3\n4 {mark} 6\n7 8 9\n");
        let found = refusal(&text);
        assert!(found.starts_with("1 of 9 pixels are missing, marked by"), "{mark}: {found}");
        let rule = |missing| map(text.as_bytes(), MapReading { missing, ..in_unit("um") });
        let filled = rule(MissingRule::Fill).unwrap();
        assert!((filled.surface.heights()[4] - 5e-6).abs() < 1e-18, "{mark}");
        assert!(
            filled.note.contains("; 1 missing pixel (") && filled.note.contains("filled"),
            "{}",
            filled.note
        );
        let excluded = rule(MissingRule::Exclude).unwrap();
        assert_eq!(excluded.surface.absent().iter().filter(|absent| **absent).count(), 1);
    }
    assert!(refusal("1,,3\n4,5,6\n").contains("marked by an empty field (once)"));
    assert_eq!(refusal("nan nan\nnan nan\n").split(',').next(), Some("4 of 4 pixels are missing"));
    // Numbers that could be heights are heights, and the study may say which one is none.
    assert_eq!(surface("0 999\n500 250").heights()[1], 999e-6);
    let stated =
        MapReading { missing_value: Some(250.0), missing: MissingRule::Fill, ..in_unit("um") };
    assert!((map(b"0 999\n501 250", stated).unwrap().surface.heights()[3] - 500e-6).abs() < 1e-18);
    let kept = MapReading { missing: MissingRule::Keep, ..in_unit("um") };
    assert_eq!(map(b"0 0\n0 -9999", kept).unwrap().surface.heights()[3], -9999e-6);
    let body: Vec<u8> = [1i16, 2, -32768, 4].iter().flat_map(|x| x.to_le_bytes()).collect();
    let found = map(&npy("'<i2'", "False", "(2, 2)", &body), in_unit("nm")).unwrap_err();
    assert!(found.contains("marked by `-32768` (once)"), "{found}");
}

#[test]
fn coordinates_around_a_matrix_are_not_heights() {
    let text = "0 10 20 30 40\n10 1 2 1 1\n20 2 7 3 1\n30 1 2 2 1\n";
    assert!(refusal(text).contains("they look like coordinates"));
    assert_eq!(surface("1 2 3 4\n2 3 4 5\n3 4 5 6\n4 5 6 7").columns(), 4);
}

/// Mutated input found that a separator at the ends of lines was counted as a third column.
#[test]
fn rows_of_two_numbers_are_no_points() {
    let rows = "3.0D-6,2.0d-6,\n".repeat(5);
    let read = surface(&format!("{rows}3.0D-6,2.0"));
    assert_eq!((read.columns(), read.rows()), (2, 6));
}

#[test]
fn numbers_of_lines_and_columns_are_not_heights() {
    let height = |i: usize, j: usize| format!("{}", (3 * i * i + 5 * j * j + i * j) % 11);
    let row = |j: usize| (0..7).map(|i| height(i, j)).collect::<Vec<_>>().join(",");
    let plain: String = (0..7).map(|j| row(j) + "\n").collect();
    assert_eq!(surface(&plain).columns(), 7);
    let titled = format!("0,1,2,3,4,5,6\n{plain}");
    assert!(refusal(&titled).starts_with("its first row is evenly spaced"), "{}", refusal(&titled));
    for first in [0, 1] {
        let numbered: String = (0..7).map(|j| format!("{},{}\n", j + first, row(j))).collect();
        let found = refusal(&numbered);
        assert!(found.starts_with("its first column is evenly spaced"), "{found}");
    }
    // A slope is evenly spaced everywhere.
    let slope: String = (0..7).map(|j| format!("{j} {} 9 8 7 6 5\n", j + 1)).collect();
    assert_eq!(surface(&slope).columns(), 7);
    for (text, says) in [
        ("1\n".repeat(20), "1 column and 20 rows: the heights of a map one after the other?"),
        ("1 2\n".repeat(20), "2 columns and 20 rows: a list of x and z?"),
        (format!("{0}\n{0}\n{0}", "1 2 ".repeat(20)), "40 columns and 3 rows: a list of x, y"),
    ] {
        assert!(refusal(&text).contains(says), "{}", refusal(&text));
    }
}

/// An NPY file states its shape, but nobody has a map of three columns and hundreds of rows.
#[test]
fn lists_in_npy_files_are_no_maps() {
    let scattered: Vec<u8> =
        (0..600u32).flat_map(|k| f64::from(k * k * 7 % 1009).to_le_bytes()).collect();
    let read = |shape: &str| map(&npy("'<f8'", "False", shape, &scattered), in_unit("um"));
    assert!(
        read("(200, 3)").unwrap_err().contains("it has 3 columns and 200 rows, but is no list")
    );
    assert!(read("(3, 200)").unwrap_err().contains("it has 3 rows of 200 numbers"));
    assert_eq!(read("(150, 4)").unwrap().surface.columns(), 4);
    let grid: Vec<u8> = [|k: u32| k % 4, |k: u32| k / 4, |k: u32| k * 7 % 5]
        .iter()
        .flat_map(|number| (0..16).flat_map(|k| f64::from(number(k)).to_le_bytes()))
        .collect();
    let found = map(&npy("'<f8'", "False", "(3, 16)", &grid), in_unit("um")).unwrap_err();
    assert!(found.contains("it has 3 rows of 16 numbers"), "{found}");
}

/// A sign within a word begins no comment: what stands before it is not the number.
#[test]
fn signs_within_words_begin_no_comment() {
    for mark in ["1.#QNAN", "-1.#IND", "1.#INF00e+000", "No Data", "n.d.", "BAD PIXEL", "<NA>"] {
        let found = refusal(&format!("1 2 3\n4 5 {mark}\n7 8 9"));
        assert!(found.starts_with("1 of 9 pixels are missing"), "{mark}: {found}");
    }
    for word in ["0.5%", "1.5#bad", "1//2", "0.5!"] {
        let found = refusal(&format!("1 2 3\n4 5 {word}\n7 8 9"));
        assert!(found.contains("is not a finite number"), "{word}: {found}");
    }
    assert_eq!(surface("1 2 3 # a\n4 5 6 // b\n7 8 9\t% c").heights()[5], 6e-6);
}

#[test]
fn titles_name_the_units_of_their_columns() {
    let list = |title: &str| {
        let point = |k: usize| format!("{},{},{}\n", k % 4, k / 4, (k * 7) % 5);
        map(
            format!("{title}\n{}", (0..16).map(point).collect::<String>()).as_bytes(),
            MapReading::default(),
        )
    };
    for title in [
        "X [mm],Y [mm],Z [µm]",
        "x_mm,y_mm,height_um",
        "X/mm,Y/mm,Z/µm",
        "x in mm,y in mm,z in microns",
        "\"x (mm)\",\"y (mm)\",\"z (um)\"",
        "x mm,y mm,z um",
        "x [mm] y [mm] z [um]",
    ] {
        let read = list(title).unwrap_or_else(|why| panic!("{title}: {why}"));
        assert_eq!(read.surface.heights()[1], 2e-6, "{title}");
        assert_eq!(read.extents[0].map(|extent| extent.width), Some(4e-3), "{title}");
    }
    let found = list("x [mm],y [mm],z [counts]").unwrap_err();
    assert!(found.contains("line 1: `counts` stands where a unit is due"), "{found}");
    // The title of heights gives their unit, with a comment sign or without.
    for title in ["# z [nm]", "Height Sensor(nm)", "\"Height (nm)\"", "% Topography / nm"] {
        let text = format!("{title}\n1 2\n3 4\n");
        let read = map(text.as_bytes(), MapReading::default()).unwrap();
        assert_eq!(read.surface.heights()[3], 4e-9, "{title}");
        let found = refusal(&text);
        assert!(found.contains("heights are in nm, the study says um"), "{title}: {found}");
    }
    assert!(refusal("# Height (V)\n1 2\n3 4").contains("gives heights in what is no unit"));
    assert_eq!(surface("# Height (see the paper)\n1 2\n3 4").columns(), 2);
}

#[test]
fn sizes_in_headers_agree_with_each_other_and_the_matrix() {
    let body = "1 2 3\n4 5 6\n";
    let widths = |header: &str| {
        let read = map(format!("{header}\n{body}").as_bytes(), MapReading::default());
        read.map(|read| read.extents.map(|extent| extent.map(|extent| extent.width)))
    };
    let (three, two) = (Some(3e-5), Some(2e-5));
    for header in [
        "# Size: 3 x 2 pixels, 30 µm x 20 µm",
        "# Dimensions: 30 um × 20 um",
        "# Scan size: 30 x 20 um",
        "# Resolution: 10 µm/pixel",
        "# Lateral resolution: 10 µm/px",
        "# X resolution: 10 um\n# Y resolution: 10 um",
        // Some programs count from the first centre to the last one.
        "# Width: 20 um\n# Height: 10 um\n# Pixel size: 10 um",
        "# Size X: 3\n# Size Y: 2\n# Unit X: mm\n# Spacing X: 0.01\n# Spacing Y: 0.01",
    ] {
        assert_eq!(widths(header), Ok([three, two]), "{header}");
    }
    for (header, says) in [
        ("# Width: 1 mm\n# Pixel size: 10 um", "the header gives a width of 1 mm, but"),
        ("# shape: (3, 2)", "the header says 2 columns, below it there are 3"),
        ("# Size: 4 x 2 px", "the header says 4 columns, below it there are 3"),
    ] {
        let found = widths(header).unwrap_err();
        assert!(found.contains(says), "{header}: {found}");
    }
    assert_eq!(widths("# Size: large"), Ok([None, None]));
    assert_eq!(
        map(format!("# Bit2nm = 1.0\n{body}").as_bytes(), MapReading::default())
            .unwrap()
            .surface
            .heights()[0],
        1e-9
    );
}

/// A round number far from all others marks missing pixels, of whatever size it is.
#[test]
fn round_numbers_far_apart_mark_missing_pixels() {
    for mark in ["-99", "255", "4095", "-1000", "1e6", "-1e5"] {
        let text = format!("0.1 0.25 0.3\n0.4 {mark} 0.6\n0.7 0.85 0.9\n");
        let found = refusal(&text);
        let shown = mark.replace("-1e5", "-100000");
        assert!(found.contains(&format!("marked by `{shown}` (once)")), "{mark}: {found}");
        let kept = MapReading { missing: MissingRule::Keep, ..in_unit("um") };
        assert!(map(text.as_bytes(), kept).is_ok());
    }
    // A pattern has few heights, and a peak need not be round.
    assert_eq!(surface("0 0 5\n0 0.01 5").columns(), 3);
    assert_eq!(surface("0.1 0.25 0.3\n0.4 99.7 0.6\n0.7 0.85 0.9").columns(), 3);
    let found = refusal("1 2 3\n4 1e38 6\n-999 8 9\n");
    assert!(found.contains("`-999` (once), `1e38` (once)"), "{found}");
    let body: Vec<u8> = [1.0, f64::NAN, 3.0, 4.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let found = map(&npy("'<f8'", "False", "(2, 2)", &body), in_unit("nm")).unwrap_err();
    assert!(found.contains("marked by `nan` (once)"), "{found}");
}

proptest! {
    #[test]
    fn damaged_files_never_panic(
        at in any::<prop::sample::Index>(),
        byte: u8,
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = npy("'<f8'", "False", "(2, 3)", &[0; 48]);
        let at = at.index(bytes.len());
        bytes[at] = byte;
        let _ = map(&bytes, in_unit("m"));
        bytes.truncate(cut.index(bytes.len()));
        let _ = map(&bytes, in_unit("m"));
        let _ = decode_surface(&bytes);
    }

    #[test]
    fn arbitrary_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..200)) {
        let _ = map(&bytes, in_unit("m"));
        let _ = map(&[NPY_MAGIC, &bytes].concat(), in_unit("m"));
        let _ = decode_surface(&[&[1], &bytes[..]].concat());
    }

    #[test]
    fn arbitrary_numbers_never_panic(text in "([0-9]{1,2}|-9999|nan|,|;|\t| |\n|1e38|x y z\n|ncols 2\n|# width: 3 mm\n|0,5){0,60}") {
        for missing in [MissingRule::Refuse, MissingRule::Fill, MissingRule::Exclude, MissingRule::Keep] {
            if let Ok(read) = map(text.as_bytes(), MapReading { missing, ..in_unit("mm") }) {
                prop_assert!(read.surface.heights().iter().all(|height| height.is_finite()));
            }
        }
    }
}
