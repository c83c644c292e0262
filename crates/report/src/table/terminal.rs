//! A table as text for a terminal.

use comfy_table::{
    CellAlignment, ColumnConstraint, ContentArrangement, LineStyle, TableStyle, Width,
};
use unicode_width::UnicodeWidthStr;

use super::cell::Cell;
use super::rows::{DataTable, TableColumn};
use super::setting::{ColumnForm, ColumnSurvey, TerminalLayout, TextWidths};

/// The number of blanks on both sides of a cell together.
const PADDING: usize = 2;
/// The number of blanks between two columns.
const SEPARATOR: usize = 1;
/// The least width to which a column of text is wrapped.
const NARROWEST_TEXT: usize = 20;

/// A column that is ready to be set.
pub(crate) struct TypesetColumn {
    form: ColumnForm,
    cells: Vec<String>,
    widths: TextWidths,
}

impl TypesetColumn {
    /// Sets the header and some cells of a column.
    fn of<'c>(
        column: &TableColumn,
        cells: impl Iterator<Item = &'c Cell> + Clone,
        layout: &TerminalLayout,
    ) -> Self {
        let mut survey = ColumnSurvey::new();
        cells.clone().for_each(|cell| survey.see(cell));
        let form = survey.form(column, layout);
        let widest = |widest: TextWidths, cell| widest.or(form.widths(cell));
        let widths = cells.clone().fold(TextWidths::default(), widest);
        TypesetColumn { cells: cells.map(|cell| form.text(cell, widths)).collect(), form, widths }
    }

    /// Returns the name and, if there is one, the unit in brackets.
    pub(crate) fn head(&self) -> (&str, Option<&str>) {
        let header = &self.form.header;
        (header.first().map_or("", String::as_str), header.get(1).map(String::as_str))
    }

    /// Returns whether its cells are numbers.
    pub(crate) fn is_number(&self) -> bool {
        self.form.numeric
    }

    /// Returns the text of the cell in a row.
    pub(crate) fn cell(&self, row: usize) -> &str {
        self.cells.get(row).map_or("", String::as_str)
    }

    fn sized(&self) -> SizedColumn<'_> {
        SizedColumn::of(&self.form, self.widths)
    }
}

impl DataTable {
    /// Sets every column.
    pub(crate) fn typeset(&self, layout: &TerminalLayout) -> Vec<TypesetColumn> {
        let columns = self.columns().iter().enumerate();
        columns
            .map(|(index, column)| TypesetColumn::of(column, self.cells(index), layout))
            .collect()
    }

    /// Writes the table as text: a header with units, numbers aligned at the decimal point, a
    /// newline at the end.
    ///
    /// When the columns do not fit into the width, they are set in several blocks, each of which
    /// begins with the first column. Characters that a terminal would obey are shown escaped.
    pub fn terminal(&self, layout: &TerminalLayout) -> String {
        let columns = self.typeset(layout);
        let sized: Vec<SizedColumn<'_>> = columns.iter().map(TypesetColumn::sized).collect();
        let mut out = String::new();
        for block in blocks(&sized, layout.width) {
            if !out.is_empty() {
                out.push('\n');
            }
            match ColumnBlock::fitting(&sized, &block, layout) {
                Some(set) => {
                    out += &set.head();
                    for row in 0..self.rows().len() {
                        out += &set.line(block.iter().map(|&i| columns[i].cell(row)));
                    }
                    out += &set.rule();
                }
                None => out += &wrapped(&columns, &block, self.rows().len(), layout),
            }
        }
        out
    }
}

/// Writes a table that comes in blocks of rows as [`DataTable::terminal`] does that of all rows.
/// The blocks pass by several times: to learn the forms of the columns, to learn their widths, and
/// to be written. Returns false if nothing was written, since a text would be wrapped, which takes
/// all rows at once.
///
/// # Errors
/// The visit of the blocks fails, or the writer does.
pub fn set_in_blocks<E>(
    layout: &TerminalLayout,
    mut visit: impl FnMut(&mut dyn FnMut(&DataTable) -> Result<(), E>) -> Result<(), E>,
    mut write: impl FnMut(&str) -> Result<(), E>,
) -> Result<bool, E> {
    let mut heads: Vec<TableColumn> = Vec::new();
    let mut surveys: Vec<ColumnSurvey> = Vec::new();
    visit(&mut |table| {
        if surveys.is_empty() {
            heads = table.columns().to_vec();
            surveys = heads.iter().map(|_| ColumnSurvey::new()).collect();
        }
        for row in table.rows() {
            surveys.iter_mut().zip(row).for_each(|(survey, cell)| survey.see(cell));
        }
        Ok(())
    })?;
    let forms = surveys.iter().zip(&heads).map(|(survey, head)| survey.form(head, layout));
    let forms: Vec<ColumnForm> = forms.collect();
    let mut widths = vec![TextWidths::default(); forms.len()];
    visit(&mut |table| {
        for row in table.rows() {
            for ((widest, form), cell) in widths.iter_mut().zip(&forms).zip(row) {
                *widest = widest.or(form.widths(cell));
            }
        }
        Ok(())
    })?;
    let sized = forms.iter().zip(&widths).map(|(form, widths)| SizedColumn::of(form, *widths));
    let sized: Vec<SizedColumn<'_>> = sized.collect();
    let blocks = blocks(&sized, layout.width);
    let fitting = blocks.iter().map(|block| ColumnBlock::fitting(&sized, block, layout));
    let Some(sets) = fitting.collect::<Option<Vec<ColumnBlock<'_>>>>() else { return Ok(false) };
    for (number, (block, set)) in blocks.iter().zip(&sets).enumerate() {
        if number > 0 {
            write("\n")?;
        }
        write(&set.head())?;
        visit(&mut |table| {
            let mut lines = String::new();
            for row in table.rows() {
                let texts = block.iter().map(|&i| forms[i].text(&row[i], widths[i]));
                lines += &set.line(texts);
            }
            write(&lines)
        })?;
        write(&set.rule())?;
    }
    Ok(true)
}

/// A column whose widths are known.
#[derive(Clone, Copy)]
struct SizedColumn<'c> {
    form: &'c ColumnForm,
    /// The width below which the column is not squeezed, in characters.
    least: usize,
    /// The width of the widest line of the header and the cells, in characters.
    whole: usize,
}

impl<'c> SizedColumn<'c> {
    fn of(form: &'c ColumnForm, widths: TextWidths) -> Self {
        let (header, content) = (form.header_width(), widths.content());
        let least = if form.numeric { content } else { content.min(NARROWEST_TEXT) };
        SizedColumn { form, least: header.max(least), whole: header.max(content) }
    }
}

/// A block of columns of which no text is wrapped.
struct ColumnBlock<'c> {
    columns: Vec<SizedColumn<'c>>,
    /// The character of the rules above, below the header and at the end.
    rule: char,
}

impl<'c> ColumnBlock<'c> {
    /// Returns a block of some columns if each text has one line.
    fn fitting(
        columns: &[SizedColumn<'c>],
        block: &[usize],
        layout: &TerminalLayout,
    ) -> Option<Self> {
        let columns: Vec<SizedColumn<'c>> = block.iter().map(|&i| columns[i]).collect();
        let set = ColumnBlock { columns, rule: if layout.unicode { '─' } else { '-' } };
        let least = set.width(|column| column.least);
        let fits = |width: usize| set.width(|column| column.whole) <= width.max(least);
        (!set.columns.is_empty() && layout.width.is_none_or(fits)).then_some(set)
    }

    /// Returns the length of a line, given the width of each column.
    fn width(&self, of: impl Fn(&SizedColumn<'c>) -> usize) -> usize {
        let columns = self.columns.iter().map(|column| of(column) + PADDING + SEPARATOR);
        columns.sum::<usize>().saturating_sub(SEPARATOR)
    }

    fn rule(&self) -> String {
        let width = self.width(|column| column.whole);
        std::iter::repeat_n(self.rule, width).chain(['\n']).collect()
    }

    /// Writes the names and units between two rules. Units stand on one line, also under names that
    /// have none.
    fn head(&self) -> String {
        let header = |column: &SizedColumn<'c>| column.form.header.len();
        let tall = self.columns.iter().map(header).max().unwrap_or(0);
        let mut text = self.rule();
        for number in 0..tall {
            let words = self.columns.iter().map(|column| column.form.header.get(number));
            text += &self.line(words.map(|words| words.map_or("", String::as_str)));
        }
        text + &self.rule()
    }

    /// Writes a line with a text for each column.
    fn line(&self, texts: impl Iterator<Item = impl AsRef<str>>) -> String {
        let mut line = String::new();
        for (number, (column, text)) in self.columns.iter().zip(texts).enumerate() {
            let text = text.as_ref();
            let blanks = column.whole.saturating_sub(text.width());
            let [before, after] = if column.form.numeric { [blanks, 0] } else { [0, blanks] };
            let gap = if number == 0 { 0 } else { SEPARATOR };
            line.extend(std::iter::repeat_n(' ', gap + PADDING / 2 + before));
            line += text;
            line.extend(std::iter::repeat_n(' ', after + PADDING / 2));
        }
        line.truncate(line.trim_end().len());
        line.push('\n');
        line
    }
}

/// Divides the columns into as few blocks as fit into the width, as indices of columns.
fn blocks(columns: &[SizedColumn<'_>], width: Option<usize>) -> Vec<Vec<usize>> {
    let Some(width) = width else { return vec![(0..columns.len()).collect()] };
    let space = |i: usize| columns[i].least + PADDING;
    let mut blocks: Vec<Vec<usize>> = Vec::new();
    let mut used = 0;
    for i in 0..columns.len() {
        match blocks.last_mut() {
            Some(block) if used + SEPARATOR + space(i) <= width => {
                block.push(i);
                used += SEPARATOR + space(i);
            }
            Some(block) if block.len() == 1 => {
                // Nothing fits beside the key column: the block overflows rather than repeat the
                // key column alone for ever.
                block.push(i);
                used = width;
            }
            Some(_) => {
                blocks.push(vec![0, i]);
                used = space(0) + SEPARATOR + space(i);
            }
            None => {
                blocks.push(vec![0]);
                used = space(0);
            }
        }
    }
    blocks
}

/// Writes one block of columns, some texts of which are wrapped.
fn wrapped(
    columns: &[TypesetColumn],
    block: &[usize],
    rows: usize,
    layout: &TerminalLayout,
) -> String {
    let mut table = comfy_table::Table::new();
    // There are rules above, below the header and at the end, as in a printed table.
    let rule = if layout.unicode { '─' } else { '-' };
    let line = LineStyle::none().fill(rule).junction(rule);
    table.load_style(TableStyle::new().top_border(line).header_separator(line).bottom_border(line));
    let least = block
        .iter()
        .map(|&i| columns[i].sized().least + PADDING + SEPARATOR)
        .sum::<usize>()
        .saturating_sub(SEPARATOR);
    if let Some(width) = layout.width {
        table.set_content_arrangement(ContentArrangement::Dynamic);
        table.set_width(u16::try_from(width.max(least)).unwrap_or(u16::MAX));
    }
    let tall = block.iter().map(|&i| columns[i].form.header.len()).max().unwrap_or(0);
    table.set_header(block.iter().map(|&i| {
        // Units stand on one line, also under names that have none.
        let mut lines = columns[i].form.header.clone();
        lines.resize(tall, String::new());
        lines.join("\n")
    }));
    for row in 0..rows {
        table.add_row(block.iter().map(|&i| columns[i].cells[row].as_str()));
    }
    for (position, &i) in block.iter().enumerate() {
        if let Some(column) = table.column_mut(position) {
            let alignment =
                if columns[i].form.numeric { CellAlignment::Right } else { CellAlignment::Left };
            column.set_cell_alignment(alignment);
            let least = u16::try_from(columns[i].sized().least + PADDING).unwrap_or(u16::MAX);
            column.set_constraint(if columns[i].form.numeric {
                ColumnConstraint::Absolute(Width::Fixed(least))
            } else {
                ColumnConstraint::LowerBoundary(Width::Fixed(least))
            });
        }
    }
    let mut text = String::new();
    for line in table.lines() {
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn cells() -> impl Strategy<Value = Cell> {
        prop_oneof![
            any::<f64>().prop_map(Cell::Number),
            (-9999i64..9999).prop_map(|n| Cell::Number(n as f64 * 1e-3)),
            any::<i64>().prop_map(Cell::Integer),
            any::<bool>().prop_map(Cell::Flag),
            "\\PC{0,12}".prop_map(Cell::Text),
            "[a-c ]{0,60}".prop_map(Cell::Text),
            Just(Cell::Missing),
        ]
    }

    fn tables() -> impl Strategy<Value = DataTable> {
        let column = proptest::collection::vec(prop_oneof![cells(), Just(0.25.into())], 9);
        (proptest::collection::vec(column, 1..5), 0..9usize).prop_map(|(columns, count)| {
            let heads = [("mu", "1"), ("a longer name", ""), ("p", "Pa"), ("ü", "m²")];
            let heads = heads.iter().take(columns.len()).map(|(n, u)| TableColumn::new(*n, *u));
            let row = |row: usize| columns.iter().map(|cells| cells[row].clone()).collect();
            DataTable::new(heads.collect(), (0..count).map(row).collect()).unwrap()
        })
    }

    proptest! {
        /// Lines that need no wrapping are those that the library would set, and a table in blocks
        /// is that of all rows.
        #[test]
        fn lines_are_those_of_the_library_and_of_the_whole(
            table in tables(), width in proptest::option::of(20usize..150), prefixes: bool,
            at_once in 1..5usize,
        ) {
            let layout = TerminalLayout { width, prefixes, ..TerminalLayout::default() };
            let columns = table.typeset(&layout);
            let sized: Vec<_> = columns.iter().map(TypesetColumn::sized).collect();
            let blocks = blocks(&sized, width);
            let library = |block: &Vec<usize>| wrapped(&columns, block, table.rows().len(), &layout);
            let expected: Vec<String> = blocks.iter().map(library).collect();
            let text = table.terminal(&layout);
            prop_assert_eq!(&text, &expected.join("\n"));
            let mut written = String::new();
            let visit = |visitor: &mut dyn FnMut(&DataTable) -> Result<(), ()>| {
                visitor(&table.without_rows())?;
                table.rows().chunks(at_once).try_for_each(|rows| {
                    visitor(&DataTable::new(table.columns().to_vec(), rows.to_vec()).unwrap())
                })
            };
            let write = |lines: &str| {
                written += lines;
                Ok(())
            };
            match set_in_blocks(&layout, visit, write).unwrap() {
                true => prop_assert_eq!(written, text),
                false => prop_assert!(written.is_empty() && width.is_some()),
            }
        }
    }
}
