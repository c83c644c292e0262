//! Tables, filters, figures and fields, against approved texts and pictures.

mod field;
mod figure;
mod marks;
mod page;
mod table;
