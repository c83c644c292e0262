//! The page as HTML.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use serde_json::{Value, json};
use wording::visible;

use super::block::{Page, PageBlock, PageFigure, PageSection};
use crate::field::scales;
use crate::number::trim_zeros;
use crate::plot::{FigureSketch, FigureSpot};
use crate::table::{DataTable, TerminalLayout};

const TEMPLATE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPT: &str = concat!(include_str!("filter.js"), include_str!("page.js"));

/// The layout of numbers in tables.
const LAYOUT: TerminalLayout =
    TerminalLayout { width: None, digits: 6, prefixes: true, unicode: true };

impl Page {
    /// Writes the page. Everything that it says is text: nothing in a name, a reason or a study
    /// file is read as HTML or as a script.
    pub fn html(&self) -> String {
        let mut figures = Vec::new();
        let mut jobs = json!({ "columns": [], "keys": [], "rows": [], "fieldless": [] });
        let mut fields = Vec::new();
        let mut sections = String::new();
        for section in &self.sections {
            let PageSection { id, title, blocks } = section;
            sections += &format!("<section id=\"{id}\">\n<h2>{}</h2>\n", markup(title));
            for block in blocks {
                match block {
                    PageBlock::Figure(PageFigure::Sketch { sketch, jobs }) => {
                        figures.push(sketch_json(sketch, jobs));
                        sections += &format!(
                            "<div class=\"figure\" data-figure=\"{}\"><div class=\"scroll\">{}</div></div>\n",
                            figures.len() - 1,
                            visible(sketch.svg.trim_end())
                        );
                    }
                    PageBlock::Jobs(table) => jobs = table.json(),
                    PageBlock::Maps(maps) => {
                        fields = maps.iter().map(|maps| maps.json().clone()).collect();
                    }
                    _ => {}
                }
                sections += &words(block);
            }
            sections += "</section>\n";
        }
        let link = |PageSection { id, title, .. }: &PageSection| {
            format!("<a href=\"#{id}\">{}</a> ", markup(title))
        };
        let contents: String = self.sections.iter().map(link).collect();
        let [plain, signed, states] = scales();
        let data = json!({
            "report": visible(&self.command),
            "jobs": jobs,
            "figures": figures,
            "fields": fields,
            "colors": { "plain": plain, "signed": signed, "states": states },
        });
        let data = script_json(&data);
        let parts = [
            ("title", markup(&self.name)),
            ("style", STYLE.to_owned()),
            ("name", markup(&self.name)),
            ("question", markup(&self.question)),
            ("contents", contents),
            ("sections", sections),
            ("footer", prose(&self.footer)),
            ("data", data),
            ("script", SCRIPT.to_owned()),
        ];
        filled(TEMPLATE, &parts)
    }
}

/// Puts the parts into the places of a template, which stand there in the same order. What is put
/// in is not searched for places.
fn filled(template: &str, parts: &[(&str, String)]) -> String {
    let mut out = String::with_capacity(parts.iter().map(|(_, part)| part.len()).sum::<usize>());
    let mut rest = template;
    for (name, part) in parts {
        if let Some((before, after)) = rest.split_once(&format!("{{{name}}}")) {
            out += before;
            out += part;
            rest = after;
        }
    }
    out + rest
}

/// Returns a text for a place in HTML: between tags, or within the quotes of an attribute. What
/// would hide or reorder other text is [visible].
fn markup(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in visible(text).chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

/// Returns sentences for a place between tags; what stands between backquotes is set as code.
fn prose(text: &str) -> String {
    let parts: Vec<&str> = text.split('`').collect();
    if parts.len().is_multiple_of(2) {
        return markup(text);
    }
    let part = |(i, part): (usize, &&str)| match i % 2 {
        0 => markup(part),
        _ => format!("<code>{}</code>", markup(part)),
    };
    parts.iter().enumerate().map(part).collect()
}

/// Returns a text that keeps its lines and its tabs for a place between tags. What ends its lines
/// is the same in a browser.
fn source(text: &str) -> String {
    let text = text.replace("\r\n", "\n");
    text.split('\t').map(markup).collect::<Vec<_>>().join("\t")
}

/// Returns JSON for a place within a script: nothing in it ends the script or begins a comment.
fn script_json(value: &Value) -> String {
    let text = value.to_string();
    let mut out = String::with_capacity(text.len() + text.len() / 64);
    for c in text.chars() {
        match c {
            '<' => out += "\\u003c",
            '>' => out += "\\u003e",
            '&' => out += "\\u0026",
            '\u{2028}' => out += "\\u2028",
            '\u{2029}' => out += "\\u2029",
            c => out.push(c),
        }
    }
    out
}

/// Writes what a block says without a script.
fn words(block: &PageBlock) -> String {
    match block {
        PageBlock::Heading(text) => format!("<h3>{}</h3>\n", markup(text)),
        PageBlock::Words(text) => format!("<p>{}</p>\n", prose(text)),
        PageBlock::Warning(text) => format!("<p class=\"warning\">{}</p>\n", prose(text)),
        PageBlock::Command(text) => format!("<pre class=\"command\">{}</pre>\n", markup(text)),
        // The first end of line within the element is no part of it.
        PageBlock::Source(text) => format!("<pre>\n{}</pre>\n", source(text)),
        PageBlock::Table(table) => table_html(table),
        PageBlock::Figure(PageFigure::Sketch { .. }) => String::new(),
        PageBlock::Figure(PageFigure::Picture { png, title }) => format!(
            "<div class=\"figure\"><div class=\"scroll\">\
             <img alt=\"{}\" src=\"data:image/png;base64,{}\"></div></div>\n",
            markup(title),
            BASE64_STANDARD.encode(png)
        ),
        PageBlock::Jobs(_) => "<noscript><p>The table is shown by a script, which this browser \
                               does not run.</p></noscript>\n<div id=\"jobs-table\"></div>\n"
            .to_owned(),
        PageBlock::Maps(_) => "<noscript><p>The maps are drawn by a script, which this browser \
                               does not run.</p></noscript>\n<div id=\"one-job\"></div>\n"
            .to_owned(),
    }
}

/// Writes a table with its units and numbers as `query` prints them.
fn table_html(table: &DataTable) -> String {
    let columns = table.typeset(&LAYOUT);
    let class = |is_number: bool, name: &str| match (is_number, name) {
        (true, _) => " class=\"number\"",
        (false, "key") => " class=\"key\"",
        (false, _) => "",
    };
    let mut out = "<div class=\"scroll\"><table>\n<thead><tr>".to_owned();
    for (column, head) in columns.iter().zip(table.columns()) {
        let (name, unit) = column.head();
        out += &format!(
            "<th scope=\"col\"{}>{}",
            class(column.is_number(), &head.name),
            markup(&name.replace('_', " "))
        );
        if let Some(unit) = unit {
            out += &format!("<span class=\"unit\">{}</span>", markup(unit));
        }
        out += "</th>";
    }
    out += "</tr></thead>\n<tbody>\n";
    for row in 0..table.rows().len() {
        out += "<tr>";
        for (column, head) in columns.iter().zip(table.columns()) {
            let text = column.cell(row).trim();
            let text =
                if column.is_number() && !text.contains('e') { trim_zeros(text) } else { text };
            out += &format!("<td{}>{}</td>", class(column.is_number(), &head.name), markup(text));
        }
        out += "</tr>\n";
    }
    out + "</tbody></table></div>\n"
}

/// Returns a figure for the script. Each point is a list: panel, entry, place and values along x
/// and y, row of the table of jobs.
fn sketch_json(sketch: &FigureSketch, jobs: &[Option<usize>]) -> Value {
    let hundredths = |x: f64| (x * 100.0).round() / 100.0;
    let spot = |FigureSpot { panel, entry, place, values, row }: &FigureSpot| {
        let job = row.and_then(|row| jobs.get(row).copied().flatten());
        let (left, top) = (hundredths(place.0), hundredths(place.1));
        json!([panel, entry, left, top, values.0, values.1, job])
    };
    let axes: Vec<Value> = sketch
        .axes
        .iter()
        .map(|axes| {
            let said = axes.each_ref().map(|axis| {
                json!({
                    "label": visible(&axis.label),
                    "unit": if axis.unit == "1" { "" } else { axis.unit.as_str() },
                    "exponent": axis.exponent,
                    "categories": axis.categories.iter().map(|c| visible(c)).collect::<Vec<_>>(),
                })
            });
            json!(said)
        })
        .collect();
    json!({
        "axes": axes,
        "entries": sketch.entries.iter().map(|entry| visible(entry)).collect::<Vec<_>>(),
        "spots": sketch.spots.iter().map(spot).collect::<Vec<_>>(),
    })
}
