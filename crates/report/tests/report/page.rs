//! Pages: what is said in them is text, whatever it is, and the script reads what was put in.

use proptest::prelude::*;
use report::{
    Cell, DataTable, Field, FieldGrid, FigureSpec, JobColumn, JobMaps, JobTable, Page, PageBlock,
    PageFigure, PageSection, PlotFigure, TableColumn, Values,
};
use serde_json::{Value, json};

/// A name that would break out of every place in a page.
const HOSTILE: &str = "</script><script>alert(1)</script><img src=x onerror=alert(2)>\"' & \
                       <!-- {data} {script} ]]> \u{202e}drawkcab\u{2066}\u{0}\u{1b}[2J \
                       \u{1f9ea}\u{200d}\u{1f52c} العربية \u{2028}";

/// Returns the data of a page as its script reads them.
fn data(html: &str) -> Value {
    let (_, rest) = html.split_once("<script type=\"application/json\" id=\"data\">").unwrap();
    serde_json::from_str(rest.split_once("</script>").unwrap().0).unwrap()
}

fn page(blocks: Vec<PageBlock>) -> Page {
    let sections = vec![PageSection { id: "only", title: "Only", blocks }];
    Page { name: "small".into(), question: "Does it slip?".into(), sections, ..Page::default() }
}

fn jobs(text: &str) -> DataTable {
    let columns = [("key", ""), ("label", ""), ("load", "N"), ("same", "1"), ("empty", "m")];
    let rows = (0..3).map(|i| {
        vec![
            format!("{i}abc").as_str().into(),
            if i == 0 { text.into() } else { "plain".into() },
            [Cell::Number(0.1 + 0.2), Cell::Number(f64::INFINITY), Cell::Missing][i].clone(),
            Cell::Integer(7),
            Cell::Missing,
        ]
    });
    let columns = columns.map(|(name, unit)| TableColumn::new(name, unit)).to_vec();
    DataTable::new(columns, rows.collect()).unwrap()
}

fn columns(meaning: &str) -> Vec<JobColumn> {
    let column = |name: &str, is_shown| JobColumn {
        name: name.to_owned(),
        group: "axis",
        meaning: meaning.to_owned(),
        is_shown,
    };
    vec![column("label", true), column("load", false), column("same", false), column("empty", true)]
}

fn field(name: &str, grid: FieldGrid, values: Values) -> Field {
    Field::new(name, "Pa", grid, values).unwrap()
}

const GRID: FieldGrid = FieldGrid { nx: 3, ny: 2, origin: [0.0, -1.0], element: [0.5, 1.0] };

fn states(grid: FieldGrid) -> Field {
    let names = ["outside", "stick"].map(str::to_owned).to_vec();
    field("state", grid, Values::Category { states: vec![1; grid.nx * grid.ny], names })
}

fn figure(table: &DataTable) -> PageBlock {
    let spec = FigureSpec { x: "x", y: &["y"], series: &["s"], ..FigureSpec::default() };
    let sketch = PlotFigure::from_table(table, &spec).unwrap().sketch();
    PageBlock::Figure(PageFigure::Sketch { sketch, jobs: vec![Some(1), None] })
}

fn points(text: &str) -> DataTable {
    let columns = ["x", "y", "s"].map(|name| TableColumn::new(name, "")).to_vec();
    let rows = vec![
        vec![1.0.into(), 2.0.into(), text.into()],
        vec![3.0.into(), 4.0.into(), "other".into()],
    ];
    DataTable::new(columns, rows).unwrap()
}

#[test]
fn nothing_that_is_said_is_read_as_html_or_script() {
    let text = || HOSTILE.to_owned();
    let table = DataTable::new(
        vec![TableColumn::new(HOSTILE, HOSTILE)],
        vec![vec![HOSTILE.into()], vec!["plain".into()]],
    );
    let fields = [field(HOSTILE, GRID, Values::Number(vec![0.0; 6])), states(GRID)];
    let page = Page {
        name: text(),
        question: text(),
        command: text(),
        footer: text(),
        ..page(vec![
            PageBlock::Heading(text()),
            PageBlock::Words(format!("`{HOSTILE}`")),
            PageBlock::Warning(text()),
            PageBlock::Command(text()),
            PageBlock::Source(format!("{HOSTILE}\nsecond line")),
            PageBlock::Table(table.unwrap()),
            figure(&points(HOSTILE)),
            PageBlock::Figure(PageFigure::Picture { png: vec![1, 2, 3], title: text() }),
            PageBlock::Jobs(JobTable::new(&jobs(HOSTILE), &columns(HOSTILE), 1 << 20).unwrap()),
            PageBlock::Maps(vec![JobMaps::new(HOSTILE, &[text()], &fields)]),
        ])
    };
    let html = page.html();
    assert_eq!(html.matches("<script").count(), 2);
    assert_eq!(html.matches("</script").count(), 2);
    assert_eq!(html.matches("<img").count(), 1, "only the picture");
    for hidden in ['\u{202e}', '\u{2066}', '\u{0}', '\u{1b}', '\u{2028}'] {
        assert!(!html.contains(hidden), "{hidden:?}");
    }
    // Joined emoji and scripts from right to left are text like any other.
    assert!(html.contains("\u{1f9ea}\u{200d}\u{1f52c} العربية"));
    let data = data(&html);
    let label = data["jobs"]["rows"][0][0].as_str().unwrap();
    assert!(label.starts_with("</script><script>alert(1)</script>"), "{label}");
    assert_eq!(data["figures"][0]["spots"].as_array().unwrap().len(), 2);
}

#[test]
fn a_page_asks_nobody_for_anything() {
    let html = page(vec![PageBlock::Words("Nothing.".into())]).html();
    let policy = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                  img-src data:; base-uri 'none'; form-action 'none'";
    assert!(html.contains(policy));
    let (before, _) = html.split_once("<style>").unwrap();
    assert!(before.contains("Content-Security-Policy"), "the policy comes before what it rules");
    let addresses: Vec<_> = html.match_indices("://").collect();
    assert_eq!(addresses.len(), 1, "the name of SVG is the only address: {addresses:?}");
    for word in
        ["fetch(", "XMLHttpRequest", "WebSocket", "sendBeacon", "import(", "@import", "url("]
    {
        assert!(!html.contains(word), "{word}");
    }
    let html = html.replace("${", "");
    for place in ["title", "style", "name", "question", "contents", "sections", "footer", "data"] {
        assert!(!html.contains(&format!("{{{place}}}")), "{place} is filled");
    }
}

#[test]
fn numbers_reach_the_script_whole() {
    let table = JobTable::new(&jobs("first"), &columns("meaning"), 1 << 20).unwrap();
    assert_eq!(table.names().collect::<Vec<_>>(), ["label", "load", "same"], "empty is left out");
    let jobs = &data(&page(vec![PageBlock::Jobs(table)]).html())["jobs"];
    assert_eq!(jobs["keys"], json!(["0abc", "1abc", "2abc"]));
    assert_eq!(
        jobs["rows"],
        json!([["first", 0.300_000_000_000_000_04], ["plain", "inf"], ["plain", null]])
    );
    assert_eq!(jobs["columns"][2]["same"], 7, "what is the same for all is there once");
    assert_eq!(jobs["columns"][1]["slot"], 1);
}

#[test]
fn a_table_that_is_too_large_loses_columns_before_rows() {
    let rows = (0..100).map(|i| {
        vec![
            format!("{i:064}").as_str().into(),
            Cell::Number(f64::from(i) / 7.0),
            i64::from(i).into(),
        ]
    });
    let names = ["key", "load", "count"].map(|name| TableColumn::new(name, "")).to_vec();
    let table = DataTable::new(names, rows.collect()).unwrap();
    let column = |name: &str, is_shown| JobColumn {
        name: name.to_owned(),
        group: "work",
        meaning: String::new(),
        is_shown,
    };
    let columns = [column("load", true), column("count", false)];
    let fitted = |room| {
        let fitted = JobTable::new(&table, &columns, room).unwrap();
        (fitted.names().map(str::to_owned).collect::<Vec<_>>(), fitted.rows())
    };
    assert_eq!(fitted(20_000), (vec!["load".to_owned(), "count".to_owned()], 100));
    assert_eq!(fitted(8_900), (vec!["load".to_owned()], 100));
    let (names, rows) = fitted(4_000);
    assert_eq!(names, ["load"]);
    assert!((30..60).contains(&rows), "{rows}");
}

/// Returns the values of a map as the script decodes them.
fn decoded(map: &Value) -> Vec<f64> {
    use base64::Engine;
    let bytes = base64::prelude::BASE64_STANDARD.decode(map["data"].as_str().unwrap()).unwrap();
    let bits = map["bits"].as_u64().unwrap();
    let codes: Vec<u16> = match bits {
        8 => bytes.iter().map(|code| u16::from(*code)).collect(),
        _ => bytes.chunks(2).map(|pair| u16::from_le_bytes([pair[0], pair[1]])).collect(),
    };
    let (low, high) = (map["low"].as_f64().unwrap(), map["high"].as_f64().unwrap());
    let step = (high - low) / ((1u32 << bits) - 2) as f64;
    let value = |code: u16| if code == 0 { f64::NAN } else { low + f64::from(code - 1) * step };
    codes.into_iter().map(value).collect()
}

#[test]
fn fields_are_coded_to_half_a_step() {
    for (side, steps) in [(20, 65_534.0), (80, 254.0)] {
        let grid = FieldGrid { nx: side, ny: side, origin: [0.0; 2], element: [1e-3; 2] };
        let values: Vec<f64> = (0..side * side)
            .map(|i| if i % 7 == 3 { f64::NAN } else { -2e9 + 1e7 * (i as f64).sin().exp() })
            .collect();
        let fields = [field("pressure", grid, Values::Number(values.clone())), states(grid)];
        let maps = JobMaps::new("ab", &[], &fields);
        let data = data(&page(vec![PageBlock::Maps(vec![maps])]).html());
        let map = &data["fields"][0]["maps"][0];
        let (low, high) = (map["low"].as_f64().unwrap(), map["high"].as_f64().unwrap());
        for (value, held) in values.iter().zip(decoded(map)) {
            let is_near = (value - held).abs() <= 0.51 * (high - low) / steps;
            assert!(is_near || value.is_nan() && held.is_nan(), "{value} {held}");
        }
        assert_eq!(data["fields"][0]["maps"][1]["names"], json!(["outside", "stick"]));
    }
    // A field that is the same everywhere is a number.
    let flat = [field("slip", GRID, Values::Number(vec![0.25; 6])), states(GRID)];
    let data = data(&page(vec![PageBlock::Maps(vec![JobMaps::new("ab", &[], &flat)])]).html());
    let map = &data["fields"][0]["maps"][0];
    assert_eq!((&map["data"], &map["low"], &map["high"]), (&json!(""), &json!(0.25), &json!(0.25)));
}

#[test]
fn points_of_a_figure_know_their_values_and_their_job() {
    let data = data(&page(vec![figure(&points("one")), figure(&points("two"))]).html());
    let spots = &data["figures"][1]["spots"];
    let values = |i: usize| [1, 4, 5, 6].map(|slot| spots[i][slot].clone());
    let entries = data["figures"][1]["entries"].as_array().unwrap();
    let entry = |i: usize| entries[spots[i][1].as_u64().unwrap() as usize].clone();
    let first = (0..2).find(|i| entry(*i) == "two").unwrap();
    assert_eq!(values(first)[1..], [json!(1.0), json!(2.0), json!(1)]);
    assert_eq!(values(1 - first)[1..], [json!(3.0), json!(4.0), json!(null)]);
    assert_eq!(entry(1 - first), "other");
}

#[test]
fn figures_of_one_page_share_no_identifier() {
    let html = page(vec![figure(&points("one")), figure(&points("two"))]).html();
    let (_, body) = html.split_once("<main>").unwrap();
    let (body, _) = body.split_once("</main>").unwrap();
    let ids: Vec<&str> =
        body.split(" id=\"").skip(1).map(|rest| rest.split_once('"').unwrap().0).collect();
    let mut distinct = ids.clone();
    distinct.sort_unstable();
    distinct.dedup();
    assert_eq!(ids.len(), distinct.len(), "{ids:?}");
}

proptest! {
    #[test]
    fn any_text_stays_text(text in any::<String>()) {
        let html = page(vec![
            PageBlock::Words(text.clone()),
            PageBlock::Jobs(JobTable::new(&jobs(&text), &columns(&text), 1 << 20).unwrap()),
        ])
        .html();
        prop_assert_eq!(html.matches("<script").count(), 2);
        let (_, words) = html.split_once("<h2>Only</h2>\n<p>").unwrap();
        let (words, _) = words.split_once("</p>").unwrap();
        prop_assert!(!words.replace("<code>", "").replace("</code>", "").contains(['<', '>', '"']));
        let rows = &data(&html)["jobs"];
        prop_assert_eq!(rows["keys"].as_array().unwrap().len(), 3);
    }
}
