//! The page of `report` in a browser, as a reader uses it.
//!
//! Without Chromium these tests are skipped, with a line that says so (Debian: `apt-get install
//! chromium`).

mod browser;

use std::io::Write;
use std::sync::Once;

use report::{
    Cell, DataTable, FigureSpec, JobColumn, JobTable, Page, PageBlock, PageFigure, PageSection,
    PlotFigure, TableColumn,
};
use serde_json::{Value, json};

use crate::place::{Place, SMALL};

use browser::Browser;

/// Returns a directory with the page of a study that has run.
fn reported(study: &str) -> Place {
    let place = Place::with("small.toml", study);
    place.succeed("run small.toml --workers 2");
    place.succeed("report small");
    place
}

/// Returns the address of the page.
fn address(place: &Place) -> String {
    format!("file://{}", place.path("small.html").display())
}

/// Starts a browser, or says that the test is skipped.
fn browser() -> Option<Browser> {
    let browser = Browser::start();
    if browser.is_none() {
        static SAID: Once = Once::new();
        SAID.call_once(|| {
            // What is written so is seen although the tests pass.
            let _ = writeln!(std::io::stderr(), "skipped: the page is not tested without chromium");
        });
    }
    browser
}

fn set_look(browser: &mut Browser, scheme: &str, width: u32) {
    let features = json!([{ "name": "prefers-color-scheme", "value": scheme }]);
    browser.call("Emulation.setEmulatedMedia", json!({ "features": features }));
    let size = json!({ "width": width, "height": 900, "deviceScaleFactor": 1, "mobile": false });
    browser.call("Emulation.setDeviceMetricsOverride", size);
}

/// Returns the texts of the cells of a column of the table, from top to bottom.
fn cells(browser: &mut Browser, column: &str) -> Vec<String> {
    let expression = format!(
        "(() => {{ const heads = [...document.querySelectorAll('#jobs th')]; \
         const at = heads.findIndex(head => head.querySelector('[data-column=\"{column}\"]')); \
         return [...document.querySelectorAll('#jobs tbody tr')].map(row => row.cells[at].textContent); }})()"
    );
    serde_json::from_value(browser.value(&expression)).unwrap()
}

fn element(selector: &str) -> String {
    format!("document.querySelector({})", json!(selector))
}

fn text(browser: &mut Browser, selector: &str) -> String {
    let said = browser.value(&format!("{}.textContent", element(selector)));
    said.as_str().unwrap_or_else(|| panic!("{selector} has a text")).to_owned()
}

fn type_filter(browser: &mut Browser, words: &str) {
    browser.value("document.getElementById('jobs-filter').select()");
    browser.click(&element("#jobs-filter"));
    browser.value("document.getElementById('jobs-filter').select()");
    browser.call("Input.insertText", json!({ "text": words }));
}

/// Uses every part of a page that is open.
fn use_page(browser: &mut Browser) {
    // Sorting.
    assert_eq!(cells(browser, "mu"), ["0.05", "0.05", "0.2", "0.2", "0.6", "0.6"]);
    browser.click(&element("[data-column='mu']"));
    assert_eq!(cells(browser, "mu")[0], "0.05");
    browser.click(&element("[data-column='mu']"));
    assert_eq!(cells(browser, "mu"), ["0.6", "0.6", "0.2", "0.2", "0.05", "0.05"]);
    let sorted = element("th[aria-sort='descending'] button");
    assert_eq!(browser.value(&format!("{sorted}.dataset.column")), "mu");

    // Filtering.
    type_filter(browser, "poisson == 0.3 && mu < 0.5");
    assert_eq!(cells(browser, "mu"), ["0.2", "0.05"]);
    assert_eq!(text(browser, "#jobs-count"), "2 of 6 rows");
    type_filter(browser, "wind > 3");
    let alert = browser.value(&format!("{}.textContent", element("#jobs-table .warning")));
    assert_eq!(alert, "There is no column wind in this table. All rows are shown.");
    type_filter(browser, "certified");
    assert_eq!(cells(browser, "mu").len(), 6);

    // Choosing a job in the table.
    browser.click(&element("#jobs tbody tr:nth-child(3) td:nth-child(2)"));
    assert!(text(browser, "#job-title").starts_with("mu = 0.2, poisson = 0"));
    assert_eq!(cells(browser, "mu").len(), 6);
    let chosen = browser.value("document.querySelectorAll('#jobs tr.chosen').length");
    assert_eq!(chosen, 1);
    assert_eq!(browser.value("document.querySelectorAll('.spot.chosen').length"), 1);

    // A curve that goes and comes back.
    let curve = "getComputedStyle(document.querySelector('[data-entry=\"0\"]')).display";
    assert_ne!(browser.value(curve), "none");
    browser.click(&element("[data-legend='0']"));
    assert_eq!(browser.value(curve), "none");
    assert_eq!(browser.value(&format!("{}.ariaPressed", element("[data-legend='0']"))), "false");
    browser.click(&element("[data-legend='0']"));
    assert_ne!(browser.value(curve), "none");

    // The values under the pointer, and choosing a job in the figure.
    let point =
        element("[data-entry='1'] polygon:last-of-type, [data-entry='1'] circle:last-of-type");
    browser.point_at(&point);
    let tip = text(browser, ".tip");
    assert!(tip.contains("coefficient of friction = 0.6"), "{tip}");
    assert!(tip.contains("stick fraction = "), "{tip}");
    browser.click(&point);
    assert!(text(browser, "#job-title").starts_with("mu = 0.6, poisson = 0.3"));

    // The same with the keyboard.
    browser.value(&format!("{}.focus()", element(".figure svg")));
    browser.press("ArrowRight");
    assert!(text(browser, ".tip").contains("coefficient of friction = 0.05"));
    browser.press("Enter");
    assert!(text(browser, "#job-title").starts_with("mu = 0.05, poisson = 0"));

    use_maps(browser);
}

/// Uses the maps of the job that is chosen.
fn use_maps(browser: &mut Browser) {
    let painted = "(() => { const c = document.querySelector('#map canvas'); \
                   const p = c.getContext('2d').getImageData(0, 0, c.width, c.height).data; \
                   return new Set(Array.from({ length: p.length / 4 }, \
                   (_, i) => p.slice(4 * i, 4 * i + 4).join())).size; })()";
    let colors = browser.value(painted).as_u64().unwrap();
    assert!(colors >= 3, "the map of pressure has {colors} colours");
    browser.point_at(&element("#map"));
    let readout = text(browser, "#map-readout");
    assert!(readout.contains("pressure ") && readout.ends_with("Pa"), "{readout}");

    // The section line.
    let place = |browser: &mut Browser| -> i64 {
        let now = browser.value(&format!("{}.ariaValueNow", element("#map")));
        now.as_str().unwrap().parse().unwrap()
    };
    let line = format!("{}.getAttribute('d')", element("#section path"));
    browser.value(&format!("{}.focus()", element("#map")));
    let (before, curve) = (place(browser), browser.value(&line));
    browser.press("ArrowUp");
    assert_eq!(place(browser), before + 1);
    browser.press("ArrowUp");
    assert_ne!(browser.value(&line), curve, "another section is another curve");
    browser.click(&element("#map"));
    let counts = browser.value("document.querySelector('#map canvas').height").as_i64().unwrap();
    assert!((place(browser) - counts / 2).abs() <= 1, "a press sets the line");
    browser.click(&element("#section-turn"));
    assert!(text(browser, "#section").starts_with("pressure along y at x = "));

    // Another field.
    browser.click(&element("[data-field='state']"));
    assert!(text(browser, "#section").contains("stick"));
    assert!(text(browser, ".legend-of-states").contains("slip"));
    browser.click(&element("[data-field='pressure']"));
}

#[test]
fn a_reader_sorts_filters_chooses_and_asks_nobody() {
    let Some(mut browser) = browser() else { return };
    let place = reported(SMALL);
    let mut grounds = Vec::new();
    for scheme in ["light", "dark"] {
        set_look(&mut browser, scheme, 1100);
        browser.open(&address(&place));
        grounds.push(browser.value("getComputedStyle(document.body).backgroundColor"));
        use_page(&mut browser);
        assert_eq!(browser.complaints(), Vec::<&Value>::new(), "{scheme}");
        assert_eq!(browser.requests(), [address(&place)], "{scheme}");
    }
    assert_eq!(grounds, ["rgb(255, 255, 255)", "rgb(22, 24, 27)"]);
}

#[test]
fn the_page_fits_a_phone() {
    let Some(mut browser) = browser() else { return };
    let place = reported(SMALL);
    set_look(&mut browser, "light", 390);
    browser.open(&address(&place));
    let width = browser.value("document.documentElement.scrollWidth").as_i64().unwrap();
    assert!(width <= 390, "the page is {width} px wide");
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

/// The filter of the page means what `query --where` means, or says that it does not.
#[test]
fn the_filter_agrees_with_that_of_a_query() {
    let Some(mut browser) = browser() else { return };
    let place = reported(&SMALL.replace("mesh = 6", "mesh = 6\nmax_iterations = 30"));
    browser.open(&address(&place));
    let (mut answered, mut refused) = (0, 0);
    for condition in [
        "mu > 0.1",
        "mu < 0.1 || mu > 0.5",
        "!(mu > 0.1)",
        "!(mu > 0.1) && (poisson == 0.3 || mu == 0.05)",
        "mu < 0.1 || mu > 0.1 && poisson == 0.3",
        "0.1 < mu",
        "mu in [0.05, 0.6]",
        "status == \"certified\"",
        "status == 'certified' && mu != 0.2",
        "status != null",
        "reason == null",
        "stick_fraction >= 0 && stick_fraction <= 1e3",
        "mu > -1",
        "mu == \"0.2\"",
        "status > 3",
        "mu >",
        "mu",
        "(mu > 0.1",
        "mu > 0.1)",
        "mu = 0.2",
        "mu & 3",
        "wind > 3",
        "mu > null",
        "0.1 < mu < 0.5",
        "!mu > 0.1",
        "mu > \"a",
    ] {
        let query =
            place.words(&["query", "small", "--where", condition, "--select", "key", "--json"]);
        type_filter(&mut browser, condition);
        let is_refused = browser.value(&format!("!{}.hidden", element("#jobs-table .warning")));
        let shown: Vec<String> = serde_json::from_value(browser.value(
            "[...document.querySelectorAll('#jobs tbody td.job')].map(cell => cell.textContent)",
        ))
        .unwrap();
        if query.code != 0 {
            // A word alone is looked for in the rows.
            assert_eq!(is_refused, condition != "mu", "{condition}");
            refused += 1;
            continue;
        }
        // A column that is empty in every row is not in the page.
        if condition == "reason == null" {
            assert_eq!(is_refused, true, "{condition}");
            continue;
        }
        assert_eq!(is_refused, false, "{condition}");
        let rows: Value = serde_json::from_str(&query.out).unwrap();
        let keys = rows["rows"].as_array().unwrap().iter();
        let keys: Vec<&str> = keys.map(|row| &row["key"].as_str().unwrap()[..8]).collect();
        assert_eq!(shown, keys, "{condition}");
        answered += 1;
    }
    assert!(answered >= 12 && refused >= 12, "{answered} answered, {refused} refused");
    type_filter(&mut browser, "status == certified && mu in [0.6, 7]");
    assert_eq!(cells(&mut browser, "mu"), ["0.6", "0.6"]);
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

#[test]
fn a_finger_reads_the_values_of_points_and_maps() {
    let Some(mut browser) = browser() else { return };
    let place = reported(SMALL);
    let size = json!({ "width": 390, "height": 800, "deviceScaleFactor": 2, "mobile": true });
    browser.call("Emulation.setDeviceMetricsOverride", size);
    browser.call("Emulation.setTouchEmulationEnabled", json!({ "enabled": true }));
    browser.open(&address(&place));
    let point = element("[data-entry='0'] polygon, [data-entry='0'] circle");
    browser.tap(&point);
    assert!(text(&mut browser, ".tip").contains("coefficient of friction = "));
    assert!(text(&mut browser, "#job-title").starts_with("mu = "));
    browser.tap(&element("#map"));
    let readout = text(&mut browser, "#map-readout");
    assert!(readout.starts_with("x = "), "{readout}");
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

#[test]
fn a_printed_page_has_every_row_and_the_colours_of_maps() {
    let Some(mut browser) = browser() else { return };
    let study = SMALL
        .replace("mesh = 6", "mesh = 5")
        .replace("[0.05, 0.2, 0.6]", "{ from = 0.05, to = 0.6, count = 20 }");
    let place = reported(&study);
    browser.open(&address(&place));
    let rows = "document.querySelectorAll('#jobs tbody tr').length";
    assert_eq!(browser.value(rows), 25);
    browser
        .value(&format!("addEventListener('beforeprint', () => {{ window.printed = {rows}; }})"));
    let print = json!({ "paperWidth": 8.27, "paperHeight": 11.69, "printBackground": false });
    let printed = browser.call("Page.printToPDF", print);
    assert!(printed["data"].as_str().is_some_and(|data| data.len() > 10_000));
    assert_eq!(browser.value("window.printed"), 40);
    assert_eq!(browser.value(rows), 25, "on the screen everything is as before");
    browser.call("Emulation.setEmulatedMedia", json!({ "media": "print" }));
    for part in [".bar", ".map", ".map .line", ".thumbs canvas"] {
        let adjusts = format!("getComputedStyle({}).printColorAdjust", element(part));
        assert_eq!(browser.value(&adjusts), "exact", "{part}");
    }
}

const ATTACK: &str =
    r#"</script><script>window.attacked = 1</script><img src=x onerror=window.attacked=1>"#;

/// Opens a page and finds that nothing in it was obeyed.
fn expect_words(browser: &mut Browser, address: &str) {
    browser.open(address);
    assert_eq!(browser.value("window.attacked === undefined"), true);
    assert_eq!(browser.requests(), [address]);
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
    assert_eq!(browser.value("document.querySelectorAll('img, script').length"), 2);
}

#[test]
fn hostile_words_of_a_study_stay_words() {
    let Some(mut browser) = browser() else { return };
    // A name of a file has no slash.
    let file = "<img src=x onerror=window.attacked=1>.txt";
    let study = SMALL
        .replace("Does it slip?", ATTACK)
        .replace("[figure]\n", &format!("[figure]\ntitle = 'Of {ATTACK}'\n"))
        .replace(
            "shape = \"sphere\", radius = \"50 mm\"",
            &format!(
                "shape = \"height-map\", file = '{file}', unit = \"um\", width_x = 1e-3, width_y = 1e-3"
            ),
        )
        .replace("20 um", "0.1 um");
    let place = Place::empty();
    let height =
        |i: i32, j: i32| format!("{} ", -f64::from((i - 4).pow(2) + (j - 4).pow(2)) / 100.0);
    let heights: String =
        (0..9).map(|j| (0..9).map(|i| height(i, j)).collect::<String>() + "\n").collect();
    place.write(file, heights);
    place.write("small.toml", study);
    place.succeed("run small.toml --workers 2");
    let filter = format!("status != \"{}\"", ATTACK.replace('"', ""));
    assert_eq!(place.words(&["report", "small", "--where", &filter]).code, 0);
    expect_words(&mut browser, &address(&place));
    assert_eq!(text(&mut browser, "h1"), ATTACK);
    let said = browser.value("document.body.textContent");
    for words in [file, &filter] {
        assert!(said.as_str().unwrap().contains(words), "{words}");
    }
    let name = browser.value(&format!("{}.getAttribute('aria-label')", element(".figure svg")));
    assert!(
        name.as_str().unwrap().starts_with(&format!("Of {ATTACK}")),
        "the title of the figure: {name}"
    );
    // What is typed is words, too.
    type_filter(&mut browser, ATTACK);
    assert_eq!(browser.value("window.attacked === undefined"), true);
    assert_eq!(browser.value("document.querySelectorAll('img, script').length"), 2);
}

/// Labels and reasons come from results, which somebody else may have computed.
#[test]
fn hostile_words_of_results_stay_words() {
    let Some(mut browser) = browser() else { return };
    let columns = ["key", "mu", "label", "status", "reason"].map(|name| TableColumn::new(name, ""));
    let rows = (0..3).map(|i| {
        let key = format!("{i}{ATTACK}");
        let texts = [key.as_str(), ATTACK, "failed", ATTACK].map(Cell::from);
        let [key, label, status, reason] = texts;
        vec![key, Cell::Number(f64::from(i)), label, status, reason]
    });
    let table = DataTable::new(columns.to_vec(), rows.collect()).unwrap();
    let column = |name: &str| JobColumn {
        name: name.to_owned(),
        group: if name == "label" { "axis" } else { "status" },
        meaning: ATTACK.to_owned(),
        is_shown: true,
    };
    let jobs = JobTable::new(&table, &["mu", "label", "status", "reason"].map(column), 1 << 20);
    let spec = FigureSpec {
        x: "mu",
        y: &["mu"],
        series: &["label"],
        labels: &[("mu", ATTACK), ("label", ATTACK)],
        title: ATTACK,
        ..FigureSpec::default()
    };
    let sketch = PlotFigure::from_table(&table, &spec).unwrap().sketch();
    let figure = PageFigure::Sketch { sketch, jobs: vec![Some(0), Some(1), None] };
    let blocks = vec![
        PageBlock::Table(table),
        PageBlock::Figure(figure),
        PageBlock::Jobs(jobs.unwrap().with_fields(|row| row == 1)),
        PageBlock::Maps(Vec::new()),
    ];
    let page = Page {
        name: ATTACK.to_owned(),
        question: ATTACK.to_owned(),
        command: ATTACK.to_owned(),
        footer: ATTACK.to_owned(),
        sections: vec![PageSection { id: "only", title: "Only", blocks }],
    };
    let place = Place::empty();
    place.write("small.html", page.html());
    expect_words(&mut browser, &address(&place));
    for (row, said) in [(1, "This adds them:"), (2, "This job has left no fields.")] {
        browser.click(&element(&format!("#jobs tbody tr:nth-child({}) td:nth-child(2)", row + 1)));
        assert_eq!(text(&mut browser, "#one-job p.warning"), ATTACK);
        assert!(text(&mut browser, "#maps").contains(said), "row {row}");
    }
    // A point whose job is not in the table has values all the same.
    browser.value(&format!("{}.focus()", element(".figure svg")));
    for _ in 0..3 {
        browser.press("ArrowRight");
        browser.press("Enter");
        assert!(text(&mut browser, ".tip").contains(ATTACK));
    }
    assert_eq!(browser.value("window.attacked === undefined"), true);
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

#[test]
fn the_page_reads_without_scripts() {
    let Some(mut browser) = browser() else { return };
    let place = reported(SMALL);
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.open(&address(&place));
    let words = browser.value("document.body.innerText");
    let words = words.as_str().unwrap();
    for said in
        ["Does it slip?", "6 of 6 points are solved", "does not run", "tribosweep run small.toml"]
    {
        assert!(words.contains(said), "{said}");
    }
    let drawn =
        browser.value("document.querySelector('.figure svg').getBoundingClientRect().width");
    assert!(drawn.as_f64().unwrap() > 200.0, "the figure is there");
}
