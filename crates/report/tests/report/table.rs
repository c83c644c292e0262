//! Tables: text, CSV, JSON, selection, order and filters.

use proptest::prelude::*;
use report::{Cell, DataTable, FilterError, TableColumn, TableError, TerminalLayout};

fn sample() -> DataTable {
    let columns = [
        ("mu", "1"),
        ("mesh", ""),
        ("peak_pressure", "Pa"),
        ("friction.cap", "Pa"),
        ("layers[0].poisson", "1"),
        ("status", ""),
    ];
    let columns = columns.map(|(name, unit)| TableColumn::new(name, unit)).to_vec();
    let row = |mu: f64, mesh: i64, peak: Cell, cap: f64, poisson: f64, status: Cell| {
        vec![mu.into(), mesh.into(), peak, cap.into(), poisson.into(), status]
    };
    DataTable::new(
        columns,
        vec![
            row(0.1, 64, 2.5e9.into(), 1e8, 0.3, "certified".into()),
            row(0.35, 64, Cell::Missing, 1e8, 0.3, Cell::Missing),
            row(0.4, 128, 3.125e9.into(), 1.5e-7, 0.0, "not converged, \"ε\" too small".into()),
            row(1.0 / 3.0, 8, f64::NAN.into(), -2e8, 0.49, "certified".into()),
        ],
    )
    .unwrap()
}

#[test]
fn terminal_text() {
    insta::assert_snapshot!(sample().terminal(&TerminalLayout::default()));
}

#[test]
fn terminal_text_with_prefixes_and_few_digits() {
    let layout = TerminalLayout { prefixes: true, digits: 3, ..TerminalLayout::default() };
    insta::assert_snapshot!(sample().terminal(&layout));
}

#[test]
fn narrow_terminals_get_several_blocks() {
    let layout = TerminalLayout { width: Some(44), unicode: false, ..TerminalLayout::default() };
    let text = sample().terminal(&layout);
    insta::assert_snapshot!(text);
    assert!(text.lines().all(|line| line.len() <= 44));
}

#[test]
fn escape_sequences_do_not_reach_the_terminal() {
    let table =
        DataTable::new(vec![TableColumn::new("a\u{7}", "")], vec![vec!["\u{1b}[31mred\n".into()]])
            .unwrap();
    let text = table.terminal(&TerminalLayout::default());
    assert!(!text.chars().any(|c| c.is_control() && c != '\n'), "{text:?}");
    assert_eq!(text.lines().count(), 5);
}

#[test]
fn csv_text() {
    insta::assert_snapshot!(sample().csv());
}

#[test]
fn json_text() {
    insta::assert_snapshot!(sample().json());
}

#[test]
fn tables_that_cannot_be() {
    let columns = || vec![TableColumn::new("a", ""), TableColumn::new("b", "")];
    let error = DataTable::new(columns(), vec![vec![1.0.into()]]).unwrap_err();
    assert_eq!(error, TableError::RowLength { row: 0, found: 1, expected: 2 });
    let error = DataTable::new(vec![TableColumn::new("a", ""), TableColumn::new("a", "m")], vec![])
        .unwrap_err();
    assert_eq!(error, TableError::Duplicate("a".into()));
    assert_eq!(sample().select(&["mu", "mu"]).unwrap_err(), TableError::Duplicate("mu".into()));
    insta::assert_snapshot!(sample().select(&["peak_presure"]).unwrap_err());
    insta::assert_snapshot!(sample().sort(&["-nothing like it"]).unwrap_err());
}

fn column(table: &DataTable, name: &str) -> Vec<Cell> {
    let i = table.column(name).unwrap();
    table.rows().iter().map(|row| row[i].clone()).collect()
}

#[test]
fn selection_takes_the_order_asked_for() {
    let table = sample().select(&["status", "mu"]).unwrap();
    assert_eq!(
        table.columns().iter().map(|c| c.name.as_str()).collect::<Vec<_>>(),
        ["status", "mu"]
    );
    assert_eq!(table.rows()[0], ["certified".into(), 0.1.into()]);
}

#[test]
fn order_by_several_keys() {
    let sorted = sample().sort(&["-mesh", "mu"]).unwrap();
    assert_eq!(column(&sorted, "mesh"), [128, 64, 64, 8].map(Cell::Integer));
    assert_eq!(column(&sorted, "mu"), [0.4, 0.1, 0.35, 1.0 / 3.0].map(Cell::Number));
}

#[test]
fn missing_values_and_nan_come_last_both_ways() {
    for (key, first) in [("peak_pressure", 2.5e9), ("-peak_pressure", 3.125e9)] {
        let peaks = column(&sample().sort(&[key]).unwrap(), "peak_pressure");
        assert_eq!(peaks[0], Cell::Number(first));
        assert!(peaks[2..].iter().all(Cell::is_missing), "{peaks:?}");
    }
}

#[test]
fn integers_and_numbers_are_compared_without_rounding() {
    let big = 1_i64 << 53;
    let rows = vec![
        vec![(big + 1).into()],
        vec![(big as f64).into()],
        vec![big.into()],
        vec![9.3e18.into()],
        vec!["a".into()],
    ];
    let table = DataTable::new(vec![TableColumn::new("n", "")], rows).unwrap();
    let sorted = table.sort(&["n"]).unwrap();
    let expected = [(big as f64).into(), big.into(), (big + 1).into(), 9.3e18.into(), "a".into()];
    assert_eq!(column(&sorted, "n"), expected);
    let numbers = sorted.rows()[..4].to_vec();
    let numbers = DataTable::new(vec![TableColumn::new("n", "")], numbers).unwrap();
    assert_eq!(numbers.filter("n == 9007199254740993").unwrap().rows(), [[Cell::Integer(big + 1)]]);
    assert_eq!(numbers.filter("n <= 9007199254740992.0").unwrap().rows().len(), 2);
}

fn selected(expression: &str) -> Vec<usize> {
    let table = sample();
    let kept = table.filter(expression).unwrap_or_else(|e| panic!("{expression}: {e}"));
    let mus = column(&table, "mu");
    column(&kept, "mu").iter().map(|mu| mus.iter().position(|m| m == mu).unwrap()).collect()
}

#[test]
fn filters_mean_what_an_engineer_expects() {
    for (expression, rows) in [
        ("mu > 0.3", &[1, 2, 3][..]),
        ("mu > 0.3 && mesh == 64", &[1]),
        ("mu > 0.3 && mesh == 64 && status == \"certified\"", &[]),
        ("status == 'certified'", &[0, 3]),
        // Integers and numbers mix.
        ("mesh == 64.0", &[0, 1]),
        ("mesh >= 63.5 && mesh < 1e2", &[0, 1]),
        ("mu * mesh > 20", &[1, 2]),
        ("mesh / 3 == 64 / 3.0", &[0, 1]),
        ("mesh % 3 == 2", &[2, 3]),
        ("2 * mu == 0.8", &[2]),
        ("-mu < -0.39", &[2]),
        ("abs(mu - 1 / 3) < 1e-12", &[3]),
        ("mesh in [8, 128]", &[2, 3]),
        ("status in ['certified']", &[0, 3]),
        ("mesh == 64 ? mu > 0.2 : mu > 0.35", &[1, 2]),
        ("mu > .35 || mesh == 8", &[2, 3]),
        ("true", &[0, 1, 2, 3]),
        ("1 > 2", &[]),
        // Missing values and NaN are unknown.
        ("peak_pressure > 3e9", &[2]),
        ("!(peak_pressure > 3e9)", &[0]),
        ("peak_pressure != 2.5e9", &[2]),
        ("peak_pressure + 1 > 0", &[0, 2]),
        ("peak_pressure > 3e9 || mesh == 64", &[0, 1, 2]),
        ("peak_pressure > 0 && mesh == 64", &[0]),
        ("peak_pressure == null", &[1, 3]),
        ("peak_pressure != null", &[0, 2]),
        ("null == status", &[1]),
        ("status != 'certified'", &[2]),
        ("mu / 0 > 1", &[0, 1, 2, 3]),
        ("(mu - mu) / 0 > 1 || (mu - mu) / 0 <= 1", &[]),
        // Text is compared and searched.
        ("status.startsWith('cert')", &[0, 3]),
        ("status.contains('\"ε\"')", &[2]),
        ("!status.endsWith('small')", &[0, 3]),
        ("status < 'd'", &[0, 3]),
        // Names may have dots and indices.
        ("friction.cap < 0", &[3]),
        ("layers[0].poisson >= 0.3", &[0, 1, 3]),
        // An expression may have several lines.
        ("mu > 0.3\n  && mesh == 8", &[3]),
    ] {
        assert_eq!(selected(expression), rows, "{expression}");
    }
}

#[test]
fn comparison_with_nan_is_unknown_not_an_error() {
    assert_eq!(selected("peak_pressure * 0 / 0 > 1"), [0usize; 0]);
}

#[test]
fn filters_that_are_refused() {
    let mut all = String::new();
    for expression in [
        "",
        "  ",
        "mu",
        "mu + 1",
        "muu > 0.3",
        "Mesh == 64",
        "friction.cup > 1",
        "layers[1].poisson > 1",
        "qqq == 1",
        "mesh = 64",
        "mu > 0.3 and mesh == 64",
        "mu > 0.3 & mesh == 64",
        "mu > ",
        "(mu > 0.3",
        "mu > 0.3)",
        "mu > 0.3 &&\nmesh => 64",
        "mu > 99999999999999999999",
        "mesh == '64'",
        "status == 1",
        "status > mu",
        "0.1 < mu < 0.3",
        "mu && mesh == 64",
        "!mu",
        "mu[mesh] > 1",
        "abs() > 1",
        "abs(mu, mesh) > 1",
        "mu > 1 ? 2",
        "-status == 'a'",
        "status + 'a' == 'ba'",
        "mesh in 64",
        "mesh in ['a']",
        "mu < null",
        "mu > 1 ? 1 : 'a'",
        "size(status) > 2",
        "status.matches('a')",
        "mu.contains('a')",
        "[1, 2].exists(x, x > mu)",
        "[mu]",
        "{'a': mu}",
        "b'a' == status",
        "'unfinished == status",
    ] {
        all += &format!("{expression}\n→ {}\n\n", sample().filter(expression).unwrap_err());
    }
    insta::assert_snapshot!(all);
}

#[test]
fn a_column_that_mixes_text_and_numbers_says_which_row_does_not_fit() {
    let rows = vec![vec![1.into()], vec!["a".into()]];
    let table = DataTable::new(vec![TableColumn::new("n", "")], rows).unwrap();
    insta::assert_snapshot!(table.filter("n > 0").unwrap_err());
    insta::assert_snapshot!(table.filter("n").unwrap_err());
}

#[test]
fn a_column_without_values_fits_any_comparison() {
    let table = DataTable::new(vec![TableColumn::new("n", "")], vec![vec![Cell::Missing]]).unwrap();
    assert_eq!(table.filter("n > 0 || n == 'a'").unwrap().rows().len(), 0);
}

#[test]
fn deep_and_long_expressions_are_refused_or_answered() {
    let table = sample();
    let deep = |open: &str, middle: &str, close: &str, times: usize| {
        format!("{}{middle}{}", open.repeat(times), close.repeat(times))
    };
    for expression in [
        deep("(", "mu > 1", ")", 2000),
        deep("!", "true", "", 4000),
        deep("-", "mu > 1", "", 4000),
        deep("mu + ", "mu > 1", "", 800),
        deep("mu > 1 || ", "true", "", 400),
        deep("mu > 1 ? true : ", "true", "", 200),
        deep("[", "", "]", 2000),
        deep("mu", "", ".mu", 1300),
        deep("mu", "", "[0]", 1300),
        deep("mu in [", "mu", "]", 400),
    ] {
        let _ = table.filter(&expression);
    }
    let length = 20_000;
    assert_eq!(table.filter(&"(".repeat(length)).unwrap_err(), FilterError::TooLong { length });
    let refused = table.filter(&deep("(", "mu > 1", ")", 200)).unwrap_err().to_string();
    assert!(
        refused.starts_with("too many brackets inside each other at character 97"),
        "{refused}"
    );
}

fn cells() -> impl Strategy<Value = Cell> {
    prop_oneof![
        any::<f64>().prop_map(Cell::Number),
        any::<i64>().prop_map(Cell::Integer),
        any::<bool>().prop_map(Cell::Flag),
        "\\PC{0,12}".prop_map(Cell::Text),
        any::<String>().prop_map(Cell::Text),
        Just(Cell::Missing),
    ]
}

fn tables() -> impl Strategy<Value = DataTable> {
    (1usize..5).prop_flat_map(|columns| {
        proptest::collection::vec(proptest::collection::vec(cells(), columns), 0..8).prop_map(
            move |rows| {
                let names = ["mu", "mesh", "p, \"q\"", "ünits"];
                let columns = (0..columns)
                    .map(|i| TableColumn::new(names[i], ["1", "", "Pa", "m²"][i]))
                    .collect();
                DataTable::new(columns, rows).unwrap()
            },
        )
    })
}

/// The pieces of expressions, right and wrong.
const PIECES: &[&str] = &[
    "mu",
    "mesh",
    "status",
    "x",
    "1",
    "0.5",
    "1e400",
    "\"a\"",
    "'",
    "null",
    "true",
    "&&",
    "||",
    "==",
    "!=",
    "<",
    "<=",
    ">",
    ">=",
    "+",
    "-",
    "*",
    "/",
    "%",
    "!",
    "(",
    ")",
    "[",
    "]",
    "{",
    "}",
    ",",
    ".",
    "?",
    ":",
    "in",
    "=",
    "&",
    "has(mu)",
    "b'a'",
    "9223372036854775808",
    "-9223372036854775808",
    "0x",
    "1u",
    "\\",
    "\n",
    "é",
    "`a`",
    "mu.contains(",
    ".exists(x, x)",
    "r'",
    "//",
];

fn expressions() -> impl Strategy<Value = String> {
    proptest::collection::vec(proptest::sample::select(PIECES), 0..16).prop_map(|p| p.join(" "))
}

/// Returns a text as CSV has it: what a spreadsheet would compute has a `'` in front.
fn inert(text: &str) -> String {
    let is_formula = text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']);
    format!("{}{text}", if is_formula { "'" } else { "" })
}

#[test]
fn no_text_is_a_formula_in_csv_and_numbers_stay_numbers() {
    let columns = ["text", "number"].map(|name| TableColumn::new(name, "")).to_vec();
    let rows = ["=1+1", "+1", "-1", "@SUM(A1)", "\t=1", "a=1", "'a"]
        .map(|text| vec![text.into(), Cell::Number(-1.5)])
        .to_vec();
    let csv = DataTable::new(columns, rows).unwrap().csv();
    let lines = [
        "text,number",
        "'=1+1,-1.5",
        "'+1,-1.5",
        "'-1,-1.5",
        "'@SUM(A1),-1.5",
        "'\t=1,-1.5",
        "a=1,-1.5",
        "'a,-1.5",
    ];
    assert_eq!(csv.lines().collect::<Vec<_>>(), lines);
}

proptest! {
    #[test]
    fn no_expression_panics(expression in expressions(), table in tables()) {
        if let Err(error) = table.filter(&expression) {
            prop_assert!(!error.to_string().is_empty());
        }
    }

    #[test]
    fn no_text_panics(expression in any::<String>()) {
        let _ = sample().filter(&expression).map_err(|e| e.to_string());
    }

    #[test]
    fn csv_reads_back(table in tables()) {
        let text = table.csv();
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let names: Vec<String> = table.columns().iter().map(|c| inert(&c.name)).collect();
        prop_assert_eq!(reader.headers().unwrap().iter().collect::<Vec<_>>(), names);
        let records: Vec<csv::StringRecord> = reader.records().collect::<Result<_, _>>().unwrap();
        prop_assert_eq!(records.len(), table.rows().len());
        for (record, row) in records.iter().zip(table.rows()) {
            for (field, cell) in record.iter().zip(row) {
                match cell {
                    Cell::Number(x) if x.is_nan() => prop_assert_eq!(field, "NaN"),
                    Cell::Number(x) => prop_assert_eq!(field.parse::<f64>().unwrap().to_bits(), x.to_bits()),
                    Cell::Integer(i) => prop_assert_eq!(field.parse::<i64>().unwrap(), *i),
                    Cell::Flag(yes) => prop_assert_eq!(field, yes.to_string()),
                    Cell::Text(text) => prop_assert_eq!(field, inert(text)),
                    Cell::Missing => prop_assert_eq!(field, ""),
                }
            }
        }
    }

    #[test]
    fn json_reads_back(table in tables()) {
        let json: serde_json::Value = serde_json::from_str(&table.json()).unwrap();
        for (i, row) in table.rows().iter().enumerate() {
            for (column, cell) in table.columns().iter().zip(row) {
                let value = &json["rows"][i][&column.name];
                match cell {
                    Cell::Number(x) if x.is_finite() => prop_assert_eq!(value.as_f64(), Some(*x)),
                    Cell::Number(_) | Cell::Missing => prop_assert!(value.is_null()),
                    Cell::Integer(i) => prop_assert_eq!(value.as_i64(), Some(*i)),
                    Cell::Flag(yes) => prop_assert_eq!(value.as_bool(), Some(*yes)),
                    Cell::Text(text) => prop_assert_eq!(value.as_str(), Some(text.as_str())),
                }
                prop_assert_eq!(json["units"][&column.name].as_str(), Some(column.unit.as_str()));
            }
        }
    }

    #[test]
    fn terminal_text_keeps_every_row(table in tables(), width in proptest::option::of(0usize..120), prefixes: bool, digits in 0usize..40) {
        let layout = TerminalLayout { width, digits, prefixes, unicode: true };
        let text = table.terminal(&layout);
        prop_assert!(text.lines().count() >= table.rows().len() + 3);
        prop_assert_eq!(&text, &table.terminal(&layout));
    }

    #[test]
    fn sorting_is_a_permutation_in_order(table in tables(), descending: bool) {
        let key = if descending { "-mu" } else { "mu" };
        let sorted = table.sort(&[key]).unwrap();
        let mut before: Vec<String> = table.rows().iter().map(|r| format!("{r:?}")).collect();
        let mut after: Vec<String> = sorted.rows().iter().map(|r| format!("{r:?}")).collect();
        let numbers: Vec<f64> = sorted.rows().iter().filter_map(|r| r[0].number()).collect();
        for pair in numbers.windows(2) {
            let ordered = if descending { pair[0] >= pair[1] } else { pair[0] <= pair[1] };
            prop_assert!(ordered, "{:?}", pair);
        }
        before.sort();
        after.sort();
        prop_assert_eq!(before, after);
    }
}
