//! Fields: maps, drawings in a terminal, files.

use proptest::prelude::*;
use report::{Field, FieldError, FieldGrid, TerminalInk, Values, VtiError, field_csv, png, vti};

fn grid(nx: usize, ny: usize) -> FieldGrid {
    FieldGrid { nx, ny, origin: [-1e-3, 0.0], element: [2e-3 / nx as f64, 1e-3 / ny as f64] }
}

/// Returns a pressure that grows in x; at the lowest y there is none.
fn pressure() -> Field {
    let values = (0..8).map(|e| if e < 4 { f64::NAN } else { 1e9 * (e - 3) as f64 }).collect();
    Field::new("contact_pressure", "Pa", grid(4, 2), Values::Number(values)).unwrap()
}

fn state() -> Field {
    let names = ["outside", "open", "stick", "slip"].map(String::from).to_vec();
    Field::new(
        "state",
        "",
        grid(4, 2),
        Values::Category { states: vec![0, 1, 1, 0, 3, 2, 2, 3], names },
    )
    .unwrap()
}

fn decode(bytes: &[u8]) -> (usize, usize, Vec<u8>) {
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    (info.width as usize, info.height as usize, pixels)
}

/// Returns the number of pixels of a colour, and the mean of their places.
fn find(svg: &str, color: [u8; 3]) -> (usize, f64, f64) {
    let (width, _, pixels) = decode(&png(svg, 96.0).unwrap());
    let places: Vec<usize> =
        (0..pixels.len() / 3).filter(|&i| pixels[3 * i..3 * i + 3] == color).collect();
    let n = places.len().max(1) as f64;
    let mean = |of: fn(usize, usize) -> usize| {
        places.iter().map(|&i| of(i, width) as f64).sum::<f64>() / n
    };
    (places.len(), mean(|i, w| i % w), mean(|i, w| i / w))
}

#[test]
fn a_map_shows_each_element_at_its_place() {
    let svg = state().svg();
    let stick = find(&svg, [0x00, 0x72, 0xb2]);
    let slip = find(&svg, [0xd5, 0x5e, 0x00]);
    let open = find(&svg, [0xd9, 0xd9, 0xd9]);
    // A state has two elements of 75 by 75 pixels each and a swatch.
    for (count, ..) in [stick, slip, open] {
        assert!((10_500..11_800).contains(&count), "{count}");
    }
    assert!(stick.2 < open.2 - 40.0, "y points upwards: {stick:?} {open:?}");
    for name in ["outside", "open", "stick", "slip"] {
        assert!(svg.contains(&format!(">{name}</text>")), "{name}");
    }
}

#[test]
fn a_map_has_a_bar_with_unit_and_equal_scales() {
    let svg = pressure().svg();
    for text in [">contact pressure [GPa]</text>", ">x [mm]</text>", ">y [mm]</text>"] {
        assert!(svg.contains(text), "{text}");
    }
    assert!(svg.contains(r#"width="300" height="150" preserveAspectRatio="none""#), "2 mm by 1 mm");
    // The end of viridis colours the upper right element and next to nothing of the bar.
    let (count, ..) = find(&svg, [0xfd, 0xe7, 0x25]);
    assert!((5_000..7_000).contains(&count), "{count}");
}

#[test]
fn zero_is_nearly_white_when_both_signs_occur() {
    let values = vec![-1.0, 0.0, 2.0];
    let field = Field::new("q", "Pa", grid(3, 1), Values::Number(values)).unwrap();
    let text = field.terminal(80, TerminalInk::Color);
    assert!(text.contains("38;2;241;239;237;48;2;241;239;237m▀"), "{text:?}");
}

#[test]
fn terminal_drawings() {
    insta::assert_snapshot!(pressure().terminal(40, TerminalInk::Ascii));
    insta::assert_snapshot!(state().terminal(24, TerminalInk::Ascii));
    insta::assert_snapshot!(state().terminal(8, TerminalInk::Color).replace('\u{1b}', "␛"));
}

/// `numpy.load` of NumPy 2 reads these files with the shape and the values that went in.
#[test]
fn npy_files() {
    let (header, values) = npy_parts(&pressure().npy());
    assert_eq!(header, "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 4, ), }");
    let numbers: Vec<f64> =
        values.chunks_exact(8).map(|bytes| f64::from_le_bytes(bytes.try_into().unwrap())).collect();
    assert!(numbers[..4].iter().all(|x| x.is_nan()));
    assert_eq!(numbers[4..], [1e9, 2e9, 3e9, 4e9]);
    let (header, values) = npy_parts(&state().npy());
    assert_eq!(header, "{'descr': '|u1', 'fortran_order': False, 'shape': (2, 4, ), }");
    assert_eq!(values, [0, 1, 1, 0, 3, 2, 2, 3]);
}

/// Takes the header and the bytes of the values from an NPY file of version 1.
fn npy_parts(file: &[u8]) -> (String, Vec<u8>) {
    assert_eq!(&file[..8], b"\x93NUMPY\x01\x00");
    let end = 10 + usize::from(u16::from_le_bytes([file[8], file[9]]));
    assert_eq!(end % 64, 0, "the values are aligned");
    let header = std::str::from_utf8(&file[10..end]).unwrap();
    assert!(header.ends_with('\n'));
    (header.trim_end().to_owned(), file[end..].to_vec())
}

/// VTK 9.6 (through PyVista) reads this file with the values, the extent and the unit that went in.
#[test]
fn vti_file() {
    insta::assert_snapshot!(vti(&[&pressure(), &state()]).unwrap());
}

#[test]
fn csv_file() {
    insta::assert_snapshot!(field_csv(&[&pressure(), &state()]).unwrap());
}

#[test]
fn fields_that_cannot_share_a_file() {
    let other = Field::new("other", "", grid(2, 2), Values::Number(vec![0.0; 4])).unwrap();
    assert_eq!(vti(&[]).unwrap_err(), VtiError::Empty);
    let error = VtiError::Grids { first: "state".into(), other: "other".into() };
    assert_eq!(vti(&[&state(), &other]).unwrap_err(), error);
    assert_eq!(field_csv(&[&state(), &state()]).unwrap_err(), VtiError::Duplicate("state".into()));
}

#[test]
fn fields_that_cannot_be() {
    let field = |grid, values| Field::new("f", "m", grid, values).unwrap_err();
    let numbers = |n| Values::Number(vec![0.0; n]);
    assert!(matches!(
        field(grid(3, 2), numbers(5)),
        FieldError::Length { found: 5, expected: 6, .. }
    ));
    assert!(matches!(
        field(FieldGrid { nx: 0, ..grid(1, 1) }, numbers(0)),
        FieldError::Grid { .. }
    ));
    assert!(matches!(
        field(FieldGrid { nx: usize::MAX, ..grid(1, 2) }, numbers(1)),
        FieldError::Grid { .. }
    ));
    for (origin, element) in [
        (0.0, 0.0),
        (0.0, -1.0),
        (0.0, f64::NAN),
        (f64::INFINITY, 1.0),
        (f64::NAN, 1.0),
        (0.0, 1e300),
        (1.0, 1e-30),
    ] {
        let grid = FieldGrid { nx: 1, ny: 1, origin: [origin, 0.0], element: [element, 1.0] };
        assert!(
            matches!(field(grid, numbers(1)), FieldError::Geometry { .. }),
            "{origin} {element}"
        );
    }
    let states = Values::Category { states: vec![0, 4], names: vec!["a".into(); 4] };
    assert!(matches!(
        field(grid(2, 1), states),
        FieldError::UnknownState { state: 4, element: 1, names: 4, .. }
    ));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..Default::default() })]
    #[test]
    fn every_field_is_drawn(
        (nx, ny, values) in (1usize..20, 1usize..20).prop_flat_map(|(nx, ny)| {
            let value = prop_oneof![any::<f64>(), Just(0.0), Just(f64::NAN), -1.0..1.0f64, Just(f64::INFINITY)];
            (Just(nx), Just(ny), proptest::collection::vec(value, nx * ny))
        }),
        origin in proptest::array::uniform2(-1e3..1e3f64),
        element in proptest::array::uniform2(1e-6..1e3f64),
        name: String,
        width in 0usize..200,
    ) {
        let states = values.iter().map(|x| if *x > 0.5 { 2 } else { u8::from(*x > 0.0) }).collect();
        let names = vec![name.clone(), "b".into(), "c".into()];
        let grid = FieldGrid { nx, ny, origin, element };
        for values in [Values::Number(values), Values::Category { states, names }] {
            let field = Field::new(name.clone(), "Pa", grid, values).unwrap();
            let svg = field.svg();
            prop_assert!(!svg.contains("\"NaN\""));
            prop_assert!(png(&svg, 24.0).is_ok());
            let text = field.terminal(width, TerminalInk::Ascii);
            prop_assert!(text.chars().all(|c| c == '\n' || !c.is_control()));
            let drawn = text.lines().skip(1).count() - 2;
            prop_assert!(text.lines().skip(1).take(drawn).all(|line| line.chars().count() <= width.max(8)));
            field.terminal(width, TerminalInk::Color);
            let xml = vti(&[&field]).unwrap();
            prop_assert!(roxmltree::Document::parse(&xml).is_ok());
        }
    }
}
