//! The parts of a page, from top to bottom.

use super::job_maps::JobMaps;
use super::job_table::JobTable;
use crate::plot::FigureSketch;
use crate::table::DataTable;

/// A page about a study.
#[derive(Clone, Debug, Default)]
pub struct Page {
    /// The name of the study.
    pub name: String,
    /// The question that it asks.
    pub question: String,
    /// The command that writes the page, to which the script adds options.
    pub command: String,
    /// The sentences at the foot.
    pub footer: String,
    /// The sections, from top to bottom.
    pub sections: Vec<PageSection>,
}

/// A part of a page under a heading.
#[derive(Clone, Debug)]
pub struct PageSection {
    /// The identifier in links, of small letters and dashes.
    pub id: &'static str,
    /// The heading.
    pub title: &'static str,
    /// The contents, from top to bottom.
    pub blocks: Vec<PageBlock>,
}

/// A piece of a section.
#[derive(Clone, Debug)]
pub enum PageBlock {
    /// A smaller heading.
    Heading(String),
    /// A sentence or several.
    Words(String),
    /// A sentence that is to be noticed.
    Warning(String),
    /// A command that can be pasted.
    Command(String),
    /// A text that keeps its lines.
    Source(String),
    /// A table to be read as it is.
    Table(DataTable),
    /// A figure.
    Figure(PageFigure),
    /// The table of all jobs, which can be sorted and filtered. A page has one at most.
    Jobs(JobTable),
    /// The numbers of a job that is chosen, and the maps of those that have some. A page has one
    /// such place at most.
    Maps(Vec<JobMaps>),
}

/// A figure of a page.
#[derive(Clone, Debug)]
pub enum PageFigure {
    /// A drawing whose points have values under the pointer.
    Sketch {
        /// The drawing.
        sketch: FigureSketch,
        /// The row of the page's table of jobs for each row of the table that the figure was drawn
        /// from.
        jobs: Vec<Option<usize>>,
    },
    /// A picture as PNG, for a drawing that would be too large.
    Picture {
        /// The bytes of the file.
        png: Vec<u8>,
        /// The description.
        title: String,
    },
}
