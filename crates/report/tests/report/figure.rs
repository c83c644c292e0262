//! Figures: their content, the refusals, and that nothing panics.

use proptest::prelude::*;
use report::{
    BandPoint, Cell, DataTable, FigureError, FigureForm, FigureSpec, PlotAxis, PlotBand,
    PlotFigure, PlotPanel, Series, Style, TableColumn, png,
};

fn axis(label: &str, unit: &str, log: bool) -> PlotAxis {
    PlotAxis { label: label.into(), unit: unit.into(), log, ..PlotAxis::default() }
}

fn series(label: &str, points: &[(f64, f64)]) -> Series {
    Series { label: label.into(), points: points.to_vec(), ..Series::default() }
}

fn figure(points: &[(f64, f64)], log: bool) -> PlotFigure {
    let (x, y) = (axis("approach", "m", log), axis("load", "N", log));
    let panels = vec![PlotPanel {
        title: String::new(),
        x,
        y,
        series: vec![series("", points)],
        ..PlotPanel::default()
    }];
    PlotFigure { title: String::new(), legend: String::new(), notes: Vec::new(), panels }
}

fn table() -> DataTable {
    let columns =
        [("mu", "1"), ("mesh", ""), ("poisson", "1"), ("peak_pressure", "Pa"), ("status", "")];
    let mut rows = Vec::new();
    for poisson in [0.3, 0.0] {
        for mesh in [128_i64, 16] {
            for mu in [0.3, 0.1, 0.2] {
                let peak = if mu == 0.2 && mesh == 16 {
                    Cell::Missing
                } else {
                    (1e9 * mu * mesh as f64).into()
                };
                rows.push(vec![mu.into(), mesh.into(), poisson.into(), peak, "certified".into()]);
            }
        }
    }
    DataTable::new(columns.map(|(name, unit)| TableColumn::new(name, unit)).to_vec(), rows).unwrap()
}

#[test]
fn a_small_figure() {
    let mut small = figure(&[(1e-6, 1e3), (2e-6, 4e3), (3e-6, f64::NAN), (4e-6, 8e3)], false);
    small.title = "Load < 10 kN".into();
    small.panels[0].series[0].label = "mesh 64 & 65".into();
    insta::assert_snapshot!(small.svg());
}

#[test]
fn a_figure_from_a_table() {
    let spec = FigureSpec {
        x: "mu",
        y: &["peak_pressure"],
        series: &["mesh"],
        panels: Some("poisson"),
        title: "Peak",
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&table(), &spec).unwrap();
    assert_eq!(figure.legend, "mesh");
    assert_eq!(
        figure.panels.iter().map(|p| p.title.as_str()).collect::<Vec<_>>(),
        ["poisson = 0", "poisson = 0.3"]
    );
    let labels: Vec<&str> = figure.panels[0].series.iter().map(|s| s.label.as_str()).collect();
    assert_eq!(labels, ["16", "128"], "sorted by value");
    let points = &figure.panels[0].series[1].points;
    assert_eq!(points.iter().map(|p| p.0).collect::<Vec<_>>(), [0.1, 0.2, 0.3], "sorted by x");
    assert!(figure.panels[0].series[0].points[1].1.is_nan(), "a gap");
    assert_eq!(figure.panels[0].series[0].style, Style::LineAndMarkers);
    let svg = figure.svg();
    assert_eq!(
        svg.matches(">peak pressure [GPa]</text>").count(),
        1,
        "the shared axis is written once"
    );
    assert_eq!(svg.matches(">mu [1]</text>").count(), 2);
    assert_eq!(svg.matches(">128</text>").count(), 1, "one legend");
}

#[test]
fn points_with_the_same_x_are_not_joined() {
    let spec = FigureSpec { x: "mu", y: &["peak_pressure"], ..Default::default() };
    let figure = PlotFigure::from_table(&table(), &spec).unwrap();
    assert_eq!(figure.panels[0].series[0].style, Style::Markers);
    let spec =
        FigureSpec { x: "status", y: &["peak_pressure"], series: &["mesh"], ..Default::default() };
    let figure = PlotFigure::from_table(&table(), &spec).unwrap();
    assert_eq!(figure.panels[0].x.categories, ["certified"]);
    assert!(figure.svg().contains(">certified</text>"));
}

#[test]
fn a_histogram_counts_rows() {
    let form = FigureForm::Histogram { bins: Some(2), share: false };
    let spec = FigureSpec {
        form,
        x: "peak_pressure",
        series: &["poisson"],
        panels: Some("mesh"),
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&table(), &spec).unwrap();
    let bars = |panel: usize, series: usize| figure.panels[panel].series[series].points.clone();
    // At mesh 16 one of three values is missing for each ν; all panels have the same bins.
    let [least, middle, most] = [1.6e9, 20e9, 38.4e9];
    let expected =
        [(least, 0.0), (least, 2.0), (middle, 2.0), (middle, 0.0), (most, 0.0), (most, 0.0)];
    assert_eq!(bars(0, 0), expected);
    assert_eq!(
        bars(1, 1).iter().map(|point| point.1).collect::<Vec<_>>(),
        [0.0, 1.0, 1.0, 2.0, 2.0, 0.0]
    );
    assert!(figure.panels.iter().all(|panel| panel.y.label == "points" && panel.y.from_zero));
    let shares = FigureForm::Histogram { bins: Some(2), share: true };
    let shared = PlotFigure::from_table(&table(), &FigureSpec { form: shares, ..spec }).unwrap();
    assert_eq!(shared.panels[1].series[0].points[3].1, 2.0 / 3.0);
    insta::assert_snapshot!(shared.svg());

    let refused =
        |spec: &FigureSpec<'_>| PlotFigure::from_table(&table(), spec).unwrap_err().to_string();
    let text = FigureSpec { x: "status", series: &[], panels: None, ..spec };
    let words = "a histogram cannot be shown along `status`, which has text";
    assert!(refused(&text).starts_with(words), "{}", refused(&text));
    let nothing = table().filter("mesh == 1").unwrap();
    let error = PlotFigure::from_table(&nothing, &spec).unwrap_err();
    assert!(error.to_string().contains("there is nothing to count"), "{error}");
}

#[test]
fn scattered_points_are_joined_by_nothing() {
    let spec = FigureSpec {
        form: FigureForm::Scatter,
        x: "mu",
        y: &["peak_pressure"],
        series: &["mesh", "poisson"],
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&table(), &spec).unwrap();
    assert!(figure.panels[0].series.iter().all(|series| series.style == Style::Markers));
    // Very many are dots, one for each pixel.
    let many = (0..1000).map(|row| vec![f64::from(row % 7).into(), f64::from(row % 5).into()]);
    let heads = ["x", "y"].map(|name| TableColumn::new(name, "")).to_vec();
    let many = DataTable::new(heads, many.collect()).unwrap();
    let spec = FigureSpec { form: FigureForm::Scatter, x: "x", y: &["y"], ..Default::default() };
    let figure = PlotFigure::from_table(&many, &spec).unwrap();
    assert_eq!(figure.panels[0].series[0].style, Style::Dots);
    assert_eq!(figure.svg().matches("<circle").count(), 35);
}

/// There are two loops one after the other: each is joined in its own order, though x comes back,
/// and they are not joined to each other.
#[test]
fn paths_are_joined_in_their_own_order() {
    let columns = [("shift", "m"), ("force", "N"), ("increment", "")]
        .map(|(name, unit)| TableColumn::new(name, unit));
    let path = [(0.0, 0.0), (2.0, 1.0), (0.0, -1.0), (-2.0, -3.0)];
    let row =
        |(i, (x, y)): (usize, &(f64, f64))| vec![(*x).into(), (*y).into(), (i as i64 + 1).into()];
    let rows = [&path[..], &path[..2]]
        .into_iter()
        .flat_map(|path| path.iter().enumerate().map(row))
        .collect();
    let table = DataTable::new(columns.to_vec(), rows).unwrap();
    let spec =
        FigureSpec { x: "shift", y: &["force"], along: Some("increment"), ..Default::default() };
    let figure = PlotFigure::from_table(&table, &spec).unwrap();
    let series = &figure.panels[0].series[0];
    assert_eq!(series.style, Style::Path);
    assert_eq!(series.points[..4], path);
    assert!(series.points[4].0.is_nan(), "a gap between two paths");
    assert_eq!(series.points[5..], path[..2]);
    assert!(!figure.svg().contains("not drawn"));
    assert_eq!(figure.svg().matches("<circle").count(), 2, "each path is marked where it ends");
    assert!(PlotFigure::from_table(&table, &FigureSpec { along: Some("time"), ..spec }).is_err());
}

/// In black and white, lines without markers differ in their dashes, and markers in the legend
/// stand at the end as on the path.
#[test]
fn lines_without_markers_differ_in_dashes() {
    for style in [Style::Line, Style::Path] {
        let mut several = figure(&[(1.0, 1.0), (2.0, 2.0)], false);
        several.panels[0].series = (0..6)
            .map(|i| Series { style, ..series(&format!("number {i}"), &[(1.0, 1.0), (2.0, 3.0)]) })
            .collect();
        let svg = several.svg();
        let dashes: std::collections::HashSet<&str> = svg
            .split("stroke-dasharray=\"")
            .skip(1)
            .map(|rest| rest.split('"').next().unwrap())
            .collect();
        assert_eq!(dashes.len(), 5, "and one is solid: {dashes:?}");
    }
}

#[test]
fn several_columns_share_an_axis() {
    let columns =
        [("mu", ""), ("modulus", "Pa"), ("peak_pressure", "Pa"), ("hertz_peak_pressure", "Pa")];
    let row = |mu: f64, modulus: f64| {
        vec![mu.into(), modulus.into(), (2.0 * modulus).into(), modulus.into()]
    };
    let rows =
        [(0.1, 80e9), (0.2, 80e9), (0.1, 8e9), (0.2, 8e9)].map(|(mu, modulus)| row(mu, modulus));
    let table = DataTable::new(
        columns.map(|(name, unit)| TableColumn::new(name, unit)).to_vec(),
        rows.to_vec(),
    )
    .unwrap();
    let labels =
        [("hertz_peak_pressure", "Hertz's"), ("modulus", "shear modulus"), ("mu", "friction")];
    let y = ["peak_pressure", "hertz_peak_pressure"];
    let spec =
        FigureSpec { x: "mu", y: &y, y_label: "pressure", labels: &labels, ..Default::default() };
    let labelled = |spec: &FigureSpec<'_>| -> (PlotFigure, Vec<String>) {
        let figure = PlotFigure::from_table(&table, spec).unwrap();
        let labels = figure.panels[0].series.iter().map(|series| series.label.clone()).collect();
        (figure, labels)
    };
    let (figure, curves) = labelled(&FigureSpec { panels: Some("modulus"), ..spec.clone() });
    assert_eq!(curves, ["peak pressure", "Hertz's"]);
    assert_eq!(figure.panels[1].title, "shear modulus = 80 GPa");
    assert_eq!(
        figure.panels[1].series.iter().map(|series| series.style).collect::<Vec<_>>(),
        [Style::LineAndMarkers, Style::Line]
    );
    assert_eq!(figure.panels[1].series[0].points, [(0.1, 160e9), (0.2, 160e9)]);
    assert_eq!(figure.panels[1].series[1].points, [(0.1, 80e9), (0.2, 80e9)]);
    assert!(
        figure.svg().contains(">pressure [GPa]</text>")
            && figure.svg().contains(">friction</text>")
    );
    let (figure, curves) = labelled(&FigureSpec { series: &["modulus"], y_label: "", ..spec });
    assert_eq!(
        curves,
        ["8 GPa, peak pressure", "8 GPa, Hertz's", "80 GPa, peak pressure", "80 GPa, Hertz's"]
    );
    let colours: Vec<(&str, bool)> = figure
        .svg()
        .lines()
        .filter(|line| line.starts_with("<path") && line.contains("h26"))
        .map(|line| {
            (if line.contains("#0072B2") { "blue" } else { "other" }, line.contains("dasharray"))
        })
        .collect();
    assert_eq!(
        colours,
        [("blue", false), ("blue", true), ("other", false), ("other", true)],
        "one colour for each modulus"
    );
    let marked = FigureSpec { x: "peak_pressure", series: &["mu"], y: &y, ..Default::default() };
    assert!(labelled(&marked).0.panels[0].series.iter().all(|series| series.kin.is_some()));
    let twice =
        DataTable::new(table.columns().to_vec(), [table.rows(), table.rows()].concat()).unwrap();
    let figure_of_markers = PlotFigure::from_table(&twice, &marked).unwrap();
    let marks = &figure_of_markers.panels[0].series;
    assert!(
        marks.iter().all(|series| series.style == Style::Markers && series.kin.is_none()),
        "markers alone differ in colour"
    );
    assert_eq!(
        (figure.legend.as_str(), figure.panels[0].y.label.as_str()),
        ("shear modulus", "peak pressure, Hertz's")
    );
}

#[test]
fn a_long_panel_title_is_broken_and_not_cut() {
    let mut titled = figure(&[(1.0, 1.0), (2.0, 2.0)], false);
    titled.panels[0].title =
        "centre of the elastic foundation's domain along the x axis = 0.25 mm".into();
    let svg = titled.svg();
    assert!(svg.contains(">= 0.25 mm</text>") && !svg.contains('…'), "{svg}");
}

#[test]
fn a_gap_breaks_the_line() {
    let whole = figure(&[(1.0, 1.0), (2.0, 2.0), (3.0, 3.0), (4.0, 4.0)], false).svg();
    let broken =
        figure(&[(1.0, 1.0), (2.0, 2.0), (2.5, f64::NAN), (3.0, 3.0), (4.0, 4.0)], false).svg();
    let moves = |svg: &str| {
        let start = svg.find("<path d=\"M").unwrap();
        svg[start..start + svg[start..].find("fill").unwrap()].matches('M').count()
    };
    assert_eq!((moves(&whole), moves(&broken)), (1, 2));
}

#[test]
fn points_that_have_no_place_are_counted_in_the_figure() {
    let svg = figure(
        &[(1.0, 1.0), (2.0, -1.0), (3.0, 0.0), (4.0, f64::INFINITY), (5.0, f64::NAN), (6.0, 2.0)],
        true,
    )
    .svg();
    assert!(svg.contains("3 points are not drawn"), "{svg}");
    assert!(!figure(&[(1.0, -1.0)], false).svg().contains("not drawn"));
    let mut worded = figure(&[(0.0, 1.0), (1.0, 2.0), (1e18, 3.0)], false);
    worded.panels[0].x.categories = vec!["soft".into(), "hard".into()];
    assert!(worded.svg().contains("1 point is not drawn"), "beyond the categories");
}

#[test]
fn what_cannot_be_drawn_is_refused() {
    let spec = |x, y: &'static [&'static str]| FigureSpec { x, y, ..Default::default() };
    let error =
        |spec: FigureSpec<'_>| PlotFigure::from_table(&table(), &spec).unwrap_err().to_string();
    let mut all = vec![
        error(spec("mue", &["peak_pressure"])),
        error(spec("mu", &["status"])),
        error(FigureSpec { log_x: true, ..spec("status", &["mu"]) }),
        error(FigureSpec { panels: Some("mash"), ..spec("mu", &["peak_pressure"]) }),
        error(spec("mesh", &[])),
        error(spec("mesh", &["mu", "poisson", "peak_pressure"])),
        error(spec("mu", &["peak_pressure", "status"])),
    ];
    let negative = DataTable::new(
        vec![TableColumn::new("x", ""), TableColumn::new("y", "")],
        (0..60).map(|i| vec![i64::from(i).into(), Cell::Integer(-1)]).collect(),
    )
    .unwrap();
    let error = |table: &DataTable, spec: FigureSpec<'_>| {
        PlotFigure::from_table(table, &spec).unwrap_err().to_string()
    };
    all.push(error(&negative, FigureSpec { log_y: true, ..spec("x", &["y"]) }));
    all.push(error(&negative, FigureSpec { panels: Some("x"), ..spec("x", &["y"]) }));
    all.push(error(&negative, FigureSpec { series: &["x"], ..spec("x", &["y"]) }));
    let empty =
        DataTable::new(negative.columns().to_vec(), vec![vec![Cell::Missing, 1.0.into()]]).unwrap();
    all.push(error(&empty, spec("x", &["y"])));
    insta::assert_snapshot!(all.join("\n"));
    let none = DataTable::new(negative.columns().to_vec(), vec![]).unwrap();
    let error = PlotFigure::from_table(&none, &spec("x", &["y"])).unwrap_err();
    assert!(matches!(error, FigureError::NothingToDraw { rows: 0, .. }));
}

/// Returns the width, the height and the pixels of a PNG.
pub(crate) fn decode(bytes: &[u8]) -> (u32, u32, Vec<u8>) {
    let mut reader = ::png::Decoder::new(std::io::Cursor::new(bytes)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!(info.color_type, ::png::ColorType::Rgb);
    (info.width, info.height, pixels)
}

fn size(svg: &str) -> (f64, f64) {
    let number = |key: &str| {
        let rest = &svg[svg.find(key).unwrap() + key.len()..];
        rest[..rest.find('"').unwrap()].parse().unwrap()
    };
    (number(" width=\""), number(" height=\""))
}

#[test]
fn png_has_the_size_asked_for_and_shows_curves_and_text() {
    let svg = figure(&[(1e-6, 1e3), (2e-6, 4e3)], false).svg();
    let (w, h) = size(&svg);
    for dpi in [96.0, 200.0] {
        let (width, height, pixels) = decode(&png(&svg, dpi).unwrap());
        assert_eq!(
            (f64::from(width), f64::from(height)),
            ((w * dpi / 96.0).round(), (h * dpi / 96.0).round())
        );
        let count = |color: [u8; 3]| pixels.chunks_exact(3).filter(|p| *p == color).count();
        assert!(count([0, 0x72, 0xb2]) > 50, "the curve");
        assert!(count([255; 3]) > pixels.len() / 3 / 2, "the ground");
    }
    // The label of the y axis alone stands at the far left.
    let (width, height, pixels) = decode(&png(&svg, 96.0).unwrap());
    let dark = (0..height)
        .flat_map(|y| (0..30).map(move |x| (y * width + x) as usize * 3))
        .filter(|&i| pixels[i] < 128);
    assert!(dark.count() > 60, "the label");
}

#[test]
fn the_same_figure_is_the_same_bytes() {
    let svg = figure(&[(1e-6, 1e3), (2e-6, 4e3)], true).svg();
    assert_eq!(png(&svg, 150.0).unwrap(), png(&svg, 150.0).unwrap());
}

#[test]
fn pngs_that_cannot_be() {
    let svg = figure(&[], false).svg();
    for dpi in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 1e9] {
        assert!(png(&svg, dpi).is_err(), "{dpi}");
    }
    assert!(png("<svg", 96.0).is_err());
    for (part, refused) in [
        ("<ellipse/>", "an element `ellipse`"),
        ("<rect width=\"1\" height=\"1\" class=\"a\"/>", "an attribute `class` of `rect`"),
        ("<rect width=\"1\"/>", "an element `rect` without `height`"),
        ("<rect width=\"1\" height=\"1\" fill=\"red\"/>", "a colour `red`"),
        ("<rect width=\"1\" height=\"1\" fill=\"url(#a)\"/>", "no gradient `a`"),
        ("<rect width=\"1cm\" height=\"1\"/>", "a length `1cm`"),
        ("<rect x=\"1cm\" width=\"1\" height=\"1\"/>", "a length `1cm`"),
        ("<rect y=\"\" width=\"1\" height=\"1\"/>", "a length ``"),
        (
            "<rect width=\"1\" height=\"1\" transform=\"rotate(1 0 0)\"/>",
            "an attribute `transform` of `rect`",
        ),
        ("<path d=\"M0 0\" x=\"1\"/>", "an attribute `x` of `path`"),
        (
            "<circle cx=\"1\" cy=\"1\" r=\"1\" paint-order=\"fill\"/>",
            "an attribute `paint-order` that is `fill`",
        ),
        ("<defs><mask/></defs>", "an element `mask`"),
        ("<defs><rect/></defs>", "an element `rect` in `defs`"),
        ("<defs id=\"a\"/>", "an attribute `id` of `defs`"),
        (
            "<defs><linearGradient gradientTransform=\"\"/></defs>",
            "an attribute `gradientTransform` of `linearGradient`",
        ),
        (
            "<defs><linearGradient><stop stop-opacity=\"0\"/></linearGradient></defs>",
            "an attribute `stop-opacity` of `stop`",
        ),
        (
            "<defs><linearGradient><title/></linearGradient></defs>",
            "an element `title` in `linearGradient`",
        ),
        (
            "<text x=\"0\" y=\"0\" font-size=\"1\">a<tspan>b</tspan></text>",
            "an element `tspan` in `text`",
        ),
        (
            "<image preserveAspectRatio=\"xMidYMid\"/>",
            "an attribute `preserveAspectRatio` that is `xMidYMid`",
        ),
        ("<image image-rendering=\"smooth\"/>", "an attribute `image-rendering` that is `smooth`"),
        ("<path d=\"M0 0A1\"/>", "a path with `A1`"),
        (
            "<text x=\"0\" y=\"0\" font-size=\"1\" transform=\"scale(2)\">a</text>",
            "a transform `scale(2)`",
        ),
        ("<image width=\"1\" height=\"1\"/>", "an image that is no PNG inside the figure"),
    ] {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\">{part}</svg>"
        );
        let message = png(&svg, 96.0).unwrap_err().to_string();
        assert_eq!(message, format!("the figure has {refused}, which is not drawn as pixels"));
    }
    for (attribute, refused) in [
        ("viewBox=\"0 0 9 8\"", "a section `0 0 9 8`"),
        ("font-family=\"serif\"", "an attribute `font-family` that is `serif`"),
        ("fill=\"red\"", "a colour `red`"),
        ("style=\"fill:red\"", "an attribute `style` of `svg`"),
    ] {
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"9\" height=\"9\" {attribute}/>"
        );
        let message = png(&svg, 96.0).unwrap_err().to_string();
        assert_eq!(message, format!("the figure has {refused}, which is not drawn as pixels"));
    }
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        -1e3..1e3f64,
        Just(0.0),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(1e-320),
        Just(1.0)
    ]
}

fn figures() -> impl Strategy<Value = PlotFigure> {
    let style = prop_oneof![
        Just(Style::LineAndMarkers),
        Just(Style::Line),
        Just(Style::Path),
        Just(Style::Markers),
        Just(Style::Dots),
        Just(Style::Bars),
        Just(Style::WhiskerBars)
    ];
    let points = || proptest::collection::vec((coordinate(), coordinate()), 0..60);
    let one = (
        any::<String>(),
        points(),
        style,
        proptest::option::of(0usize..9),
        any::<[bool; 3]>(),
        "\\PC{0,9}",
    )
        .prop_map(|(label, points, style, kin, [fitted, log_x, log_y], name)| {
            let fit = if fitted { report::fit::straight(&points, log_x, log_y) } else { None };
            let names =
                (0..points.len() * usize::from(log_x)).map(|i| format!("{name}{i}")).collect();
            let noise = points.iter().map(|point| point.1).collect();
            let whiskers = points.iter().map(|(x, y)| [*y, *x]).collect();
            let bar_width = points.first().map_or(0.5, |point| point.0.abs());
            Series {
                label,
                points,
                style,
                kin,
                fit,
                noise,
                names,
                bar_width,
                whiskers,
                rows: Vec::new(),
            }
        });
    let end = (coordinate(), coordinate(), coordinate()).prop_map(|(x, low, high)| BandPoint {
        x,
        low,
        high,
    });
    let ends = proptest::collection::vec(end, 0..60);
    let band = (any::<String>(), ends, any::<bool>(), points()).prop_map(
        |(label, points, joined, fitted)| {
            let fits = [report::fit::power_law(&fitted), None];
            PlotBand { label, points, joined, fits, rows: Vec::new() }
        },
    );
    let axis = (
        "\\PC{0,40}",
        proptest::sample::select(&["", "1", "Pa", "m", "N/m", "m²", "s"][..]),
        any::<bool>(),
        0usize..4,
    )
        .prop_map(|(label, unit, log, n)| PlotAxis {
            label,
            unit: unit.into(),
            log,
            categories: (0..n * usize::from(!log)).map(|i| format!("category {i}")).collect(),
            from_zero: n == 1,
        });
    let drawn = (
        proptest::collection::vec(one, 0..4),
        proptest::collection::vec(band, 0..3),
        any::<bool>(),
    );
    let panel = (any::<String>(), axis.clone(), axis, drawn).prop_map(
        |(title, x, y, (series, bands, front))| PlotPanel {
            title,
            x,
            y,
            series,
            bands,
            front,
            level: None,
        },
    );
    let texts =
        (any::<String>(), any::<String>(), proptest::collection::vec(any::<String>(), 0..3));
    (texts, proptest::collection::vec(panel, 0..6))
        .prop_map(|((title, legend, notes), panels)| PlotFigure { title, legend, notes, panels })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..Default::default() })]
    #[test]
    fn every_figure_is_a_picture(figure in figures()) {
        let svg = figure.svg();
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"), "{}", svg);
        let picture = png(&svg, 24.0);
        prop_assert!(picture.is_ok(), "{}", picture.unwrap_err());
    }

    #[test]
    fn a_sketch_is_the_same_picture_in_groups(figure in figures()) {
        let sketch = figure.sketch();
        let is_drawn = |line: &&str| {
            !line.starts_with("<g ") && *line != "</g>" && !line.contains("fill=\"transparent\"")
        };
        let without: Vec<&str> = sketch.svg.lines().filter(is_drawn).collect();
        let svg = figure.svg();
        prop_assert_eq!(without, svg.lines().collect::<Vec<_>>());
        for spot in &sketch.spots {
            prop_assert!(spot.entry < sketch.entries.len() && spot.panel < sketch.axes.len());
        }
    }

    #[test]
    fn every_table_is_a_figure_or_an_error(
        rows in proptest::collection::vec((coordinate(), proptest::option::of(coordinate()), 0i64..3), 0..20),
        [log_x, log_y, fit, front, with_band] in any::<[bool; 5]>(),
    ) {
        let cells = |(x, y, s): (f64, Option<f64>, i64)| vec![x.into(), y.map_or(Cell::Missing, Cell::Number), s.into()];
        let columns = ["x", "y", "s"].map(|name| TableColumn::new(name, "Pa")).to_vec();
        let band = with_band.then_some(("s", "y"));
        let table = DataTable::new(columns, rows.into_iter().map(cells).collect()).unwrap();
        let spec = FigureSpec { x: "x", y: &["y"], series: &["s"], panels: Some("s"), log_x, log_y, band, fit, front, names: Some("s"), ..Default::default() };
        let bins = fit.then_some(7);
        for form in [FigureForm::Curves, FigureForm::Scatter, FigureForm::Histogram { bins, share: front }] {
            if let Ok(figure) = PlotFigure::from_table(&table, &FigureSpec { form, ..spec }) {
                let svg = figure.svg();
                prop_assert!(!svg.contains("NaN"));
            }
        }
    }
}
