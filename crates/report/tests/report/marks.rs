//! The marks of figures beyond curves: fitted lines, bands between two ends, the front of the
//! cheapest points.

use report::{BandPoint, Cell, DataTable, FigureError, FigureSpec, PlotFigure, Style, TableColumn};

fn table(columns: &[(&str, &str)], rows: Vec<Vec<Cell>>) -> DataTable {
    DataTable::new(
        columns.iter().map(|(name, unit)| TableColumn::new(*name, *unit)).collect(),
        rows,
    )
    .unwrap()
}

/// Returns the elements within the frames of the panels and in the legend, without grids and axes.
fn inside(svg: &str) -> String {
    let axes = |line: &&str| {
        line.starts_with("<rect") && line.contains("#ffffff")
            || line.contains("stroke=\"#e4e4e4\"")
            || line.starts_with("<line") && line.contains("#1a1a1a")
            || line.starts_with("<text")
                && (line.contains("font-size=\"11\" text-anchor=\"middle\"")
                    || line.contains("text-anchor=\"end\""))
    };
    svg.lines().filter(|line| !axes(line)).collect::<Vec<_>>().join("\n")
}

/// Returns errors of the orders 1 (with a second order that dies out) and 2 for two scenes.
fn errors() -> DataTable {
    let mut rows = Vec::new();
    for (scene, scale) in [("sphere", 1.0), ("punch", 0.3)] {
        for mesh in [8_i64, 16, 32, 64, 128, 256] {
            let h = 1.0 / mesh as f64;
            rows.push(vec![
                mesh.into(),
                (scale * (h + 3.0 * h * h)).into(),
                (0.2 * scale * h * h).into(),
                scene.into(),
            ]);
        }
    }
    table(&[("mesh", ""), ("error_pressure", "1"), ("error_load", "1"), ("scene", "")], rows)
}

#[test]
fn fitted_lines_have_their_slopes_in_the_legend() {
    let y = ["error_pressure", "error_load"];
    let spec = FigureSpec {
        x: "mesh",
        y: &y,
        y_label: "error",
        log_x: true,
        log_y: true,
        fit: true,
        ..Default::default()
    };
    let sphere = errors().filter("scene == 'sphere'").unwrap();
    let figure = PlotFigure::from_table(&sphere, &spec).unwrap();
    let fits: Vec<_> = figure.panels[0].series.iter().map(|series| series.fit.unwrap()).collect();
    assert!((fits[1].slope + 2.0).abs() < 1e-12 && fits[1].points == 6, "{fits:?}");
    assert!(
        fits[0].from > 8.0 && (-1.1..-1.0).contains(&fits[0].slope),
        "what is not asymptotic is left out: {fits:?}"
    );
    let svg = figure.svg();
    assert!(
        svg.contains(">error pressure, slope −1.")
            && svg.contains(">error load, slope −2.000 ± &lt; 0.001</text>"),
        "{svg}"
    );
    assert!(svg.contains("± their standard error"), "a note says what a slope is");
    assert!(
        figure.panels[0].series.iter().all(|series| series.style == Style::Markers),
        "lines are fits and nothing else"
    );
    insta::assert_snapshot!(inside(&svg));
    let plain =
        PlotFigure::from_table(&sphere, &FigureSpec { fit: false, ..spec.clone() }).unwrap();
    assert!(!plain.svg().contains("slope") && !plain.svg().contains("standard error"));

    let panels = PlotFigure::from_table(&errors(), &FigureSpec { panels: Some("scene"), ..spec })
        .unwrap()
        .svg();
    assert!(panels.contains(">error load</text>"), "of several panels, the legend has names alone");
    assert_eq!(
        panels.matches(">slope −2.000 ± &lt; 0.001</text>").count(),
        2,
        "and each panel its slopes"
    );
}

#[test]
fn two_points_have_no_slope() {
    let two = errors().filter("scene == 'sphere' && mesh <= 16").unwrap();
    let spec = FigureSpec {
        x: "mesh",
        y: &["error_load"],
        log_x: true,
        log_y: true,
        fit: true,
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&two, &spec).unwrap();
    assert_eq!(
        (figure.panels[0].series[0].fit, figure.panels[0].series[0].style),
        (None, Style::LineAndMarkers)
    );
}

/// Returns brackets for two values of ν: closed ones, one without an upper end, and one that
/// failed.
fn brackets() -> DataTable {
    let rows = [
        (2, 0.3, Some(4.70), Some(4.70)),
        (3, 0.3, Some(3.27), Some(3.77)),
        (4, 0.3, Some(2.72), Some(3.49)),
        (8, 0.3, Some(2.33), None),
        (2, 0.0, Some(2.70), Some(2.70)),
        (3, 0.0, None, None),
        (4, 0.0, Some(1.58), Some(2.04)),
        (8, 0.0, Some(1.31), Some(f64::INFINITY)),
    ];
    let cell = |x: Option<f64>| x.map_or(Cell::Missing, Cell::Number);
    let rows = rows.map(|(n, nu, low, high): (i64, f64, _, _)| {
        vec![n.into(), nu.into(), cell(low), cell(high), "ok".into()]
    });
    table(
        &[("mesh", ""), ("poisson", "1"), ("mu_low", "1"), ("mu_high", "1"), ("status", "")],
        rows.to_vec(),
    )
}

#[test]
fn bands_lie_between_two_columns() {
    let spec = FigureSpec {
        x: "mesh",
        series: &["poisson"],
        band: Some(("mu_low", "mu_high")),
        y_label: "end of uniqueness",
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&brackets(), &spec).unwrap();
    let panel = &figure.panels[0];
    assert!(panel.series.is_empty());
    assert_eq!(
        panel.bands.iter().map(|band| (band.label.as_str(), band.joined)).collect::<Vec<_>>(),
        [("0", true), ("0.3", true)]
    );
    assert_eq!(panel.bands[1].points[1], BandPoint { x: 3.0, low: 3.27, high: 3.77 });
    let svg = figure.svg();
    insta::assert_snapshot!(inside(&svg));
    assert_eq!(svg.matches("no upper end known").count(), 1);
    assert!(svg.contains(">end of uniqueness [1]</text>") && !svg.contains("not drawn"));
    let closed = PlotFigure::from_table(&brackets().filter("mesh < 8").unwrap(), &spec).unwrap();
    assert!(!closed.svg().contains("no upper end known"));

    let alone = FigureSpec { series: &[], y_label: "", ..spec.clone() };
    let alone =
        PlotFigure::from_table(&brackets().filter("poisson == 0.3").unwrap(), &alone).unwrap();
    assert_eq!(
        (alone.panels[0].bands[0].label.as_str(), alone.panels[0].y.label.as_str()),
        ("mu low to mu high", "mu low, mu high")
    );
    let words =
        PlotFigure::from_table(&brackets(), &FigureSpec { x: "status", ..spec.clone() }).unwrap();
    assert!(words.panels[0].bands.iter().all(|band| !band.joined), "words are not joined");
    let curve =
        PlotFigure::from_table(&brackets(), &FigureSpec { y: &["mu_low"], ..spec }).unwrap();
    let labels =
        (curve.panels[0].series[0].label.as_str(), curve.panels[0].bands[0].label.as_str());
    assert_eq!(
        labels,
        ("0, mu low", "0, mu low to mu high"),
        "curves and a band say what they are"
    );
}

#[test]
fn the_ends_of_a_band_are_fitted() {
    let rows = [2_i64, 4, 8, 16].map(|n| {
        vec![n.into(), (4.0 / (n as f64).sqrt()).into(), (5.0 / (n as f64).sqrt()).into()]
    });
    let table = table(&[("mesh", ""), ("low", ""), ("high", "")], rows.to_vec());
    let spec = FigureSpec {
        x: "mesh",
        band: Some(("low", "high")),
        log_x: true,
        log_y: true,
        fit: true,
        ..Default::default()
    };
    let figure = PlotFigure::from_table(&table, &spec).unwrap();
    assert!(
        figure.panels[0].bands[0].fits.iter().all(|fit| (fit.unwrap().slope + 0.5).abs() < 1e-12)
    );
    let svg = figure.svg();
    assert!(
        svg.contains(">lower end: slope −0.5000 ± &lt; 0.0001</text>")
            && svg.contains(">upper end: slope"),
        "{svg}"
    );
}

/// Returns errors against seconds of two methods on some meshes.
fn costs() -> DataTable {
    let mut rows = Vec::new();
    for (method, seconds, order) in [("newton", 2e-4, 1.0), ("gradient", 5e-5, 1.3)] {
        for mesh in [16_i64, 32, 64, 128, 256] {
            let n = mesh as f64;
            rows.push(vec![
                (seconds * (n / 16.0).powf(2.0 * order)).into(),
                (0.4 / n).into(),
                mesh.into(),
                method.into(),
            ]);
        }
    }
    table(&[("seconds", "s"), ("error", "1"), ("mesh", ""), ("method", "")], rows)
}

#[test]
fn the_front_is_marked_and_named() {
    let spec = FigureSpec {
        x: "seconds",
        y: &["error"],
        series: &["method"],
        log_x: true,
        log_y: true,
        front: true,
        ..Default::default()
    };
    let named = FigureSpec { names: Some("mesh"), ..spec.clone() };
    let svg = PlotFigure::from_table(&costs(), &named).unwrap().svg();
    insta::assert_snapshot!(inside(&svg));
    // On equal meshes both err alike, so that the cheaper of the two is on the front.
    assert_eq!(svg.matches("r=\"6\"").count(), 5 + 1, "five rings and the legend's");
    assert_eq!(svg.matches("cheapest for its accuracy").count(), 1);
    let names = |svg: &str| svg.lines().filter(|line| line.contains("paint-order")).count();
    assert_eq!(names(&svg), 5, "each mesh has room for its name");
    assert_eq!(names(&PlotFigure::from_table(&costs(), &spec).unwrap().svg()), 0);
    let all =
        PlotFigure::from_table(&costs(), &FigureSpec { front: false, ..named }).unwrap().svg();
    assert!(names(&all) > 5 && !all.contains("cheapest"), "without a front every point has a name");
}

#[test]
fn what_has_no_points_in_order_of_x_is_refused() {
    let spec = FigureSpec { x: "mesh", y: &["mu_low"], ..Default::default() };
    let error = |spec: FigureSpec<'_>| PlotFigure::from_table(&brackets(), &spec).unwrap_err();
    let band = Some(("mu_low", "mu_high"));
    let all = [
        error(FigureSpec { x: "status", fit: true, ..spec.clone() }),
        error(FigureSpec { x: "status", front: true, ..spec.clone() }),
        error(FigureSpec { along: Some("mesh"), band, ..spec.clone() }),
        error(FigureSpec { band: Some(("mu_low", "status")), ..spec.clone() }),
        error(FigureSpec { band: Some(("mu_low", "mu_hihg")), ..spec.clone() }),
    ];
    insta::assert_snapshot!(all.map(|error| error.to_string()).join("\n"));
    assert_eq!(error(FigureSpec { y: &[], band, front: true, ..spec.clone() }), FigureError::NoY);
    assert_eq!(error(FigureSpec { y: &[], band, names: Some("mesh"), ..spec }), FigureError::NoY);
}
