//! One page of HTML that holds a study: words, tables, figures, and the maps of some jobs.
//!
//! The page asks nobody for anything: its style and its script stand in it, and a policy in its
//! head forbids every request. Without scripts it still reads as text with figures. The files read
//! downwards: `block` says what a page is made of, `job_table` and `job_maps` hold what the script
//! shows, `html` writes the page. They know tables, figures and fields, and no study.
//!
//! `page/page.html`, `page.css` and `page.js` are the template, kept by hand.

mod block;
mod html;
mod job_maps;
mod job_table;
mod quantity;

pub use block::{Page, PageBlock, PageFigure, PageSection};
pub use job_maps::JobMaps;
pub use job_table::{ColumnRoom, FittedTable, JobColumn, JobTable};
pub use quantity::quantity_words;
