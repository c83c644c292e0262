//! The page of `report` in a browser, as a reader uses it.
//!
//! Without Chromium these tests are skipped, with a line that says so (Debian: `apt-get install
//! chromium`).

mod browser;

use std::fs;
use std::io::Write;
use std::process::{Command, Stdio};
use std::sync::Once;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::browser::Browser;

const STUDY: &str = include_str!("../cli/studies/small.toml");

/// A directory with the page of a study that has run.
struct ReportPlace {
    directory: TempDir,
}

impl ReportPlace {
    fn new(study: &str) -> Self {
        let place = Self { directory: TempDir::new().unwrap() };
        fs::write(place.directory.path().join("small.toml"), study).unwrap();
        place.run(&["run", "small.toml", "--workers", "2"]);
        place.run(&["report", "small"]);
        place
    }

    fn run(&self, words: &[&str]) {
        let status = Command::new(env!("CARGO_BIN_EXE_tribosweep"))
            .args(words)
            .current_dir(self.directory.path())
            .env_remove("TRIBOSWEEP_STORE")
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .unwrap();
        assert!(status.success(), "{words:?}");
    }

    fn address(&self) -> String {
        format!("file://{}", self.directory.path().join("small.html").display())
    }
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
    assert_eq!(alert, "There is no column wind in this table.");
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
    let place = ReportPlace::new(STUDY);
    let mut grounds = Vec::new();
    for scheme in ["light", "dark"] {
        set_look(&mut browser, scheme, 1100);
        browser.open(&place.address());
        grounds.push(browser.value("getComputedStyle(document.body).backgroundColor"));
        use_page(&mut browser);
        assert_eq!(browser.complaints(), Vec::<&Value>::new(), "{scheme}");
        assert_eq!(browser.requests(), [place.address()], "{scheme}");
    }
    assert_eq!(grounds, ["rgb(255, 255, 255)", "rgb(22, 24, 27)"]);
}

#[test]
fn the_page_fits_a_phone() {
    let Some(mut browser) = browser() else { return };
    let place = ReportPlace::new(STUDY);
    set_look(&mut browser, "light", 390);
    browser.open(&place.address());
    let width = browser.value("document.documentElement.scrollWidth").as_i64().unwrap();
    assert!(width <= 390, "the page is {width} px wide");
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

#[test]
fn hostile_words_stay_words() {
    let Some(mut browser) = browser() else { return };
    let attack =
        r#"</script><script>window.attacked = 1</script><img src=x onerror=window.attacked=1>"#;
    let study = STUDY.replace("Does it slip?", attack);
    let place = ReportPlace::new(&study);
    browser.open(&place.address());
    assert_eq!(browser.value("window.attacked === undefined"), true);
    assert_eq!(text(&mut browser, "h1"), attack);
    assert_eq!(browser.requests(), [place.address()]);
    assert_eq!(browser.complaints(), Vec::<&Value>::new());
}

#[test]
fn the_page_reads_without_scripts() {
    let Some(mut browser) = browser() else { return };
    let place = ReportPlace::new(STUDY);
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.open(&place.address());
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
