//! The arguments of what reads results.

use std::path::PathBuf;

use answers::shards::Shard;
use clap::{Args, ValueEnum};

use super::shared::StoreArgs;

#[derive(Args)]
pub(crate) struct StatusArgs {
    /// Name of a study [default: all]
    pub(crate) name: Option<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct AnswerArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Column that the points of a sample are to describe, in place of those of the figures; may be
    /// given several times
    #[arg(long, value_delimiter = ',')]
    pub(crate) column: Vec<String>,
    /// Print JSON
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// The formats of a table.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum TableFormat {
    /// A table for reading
    Table,
    /// RFC 4180, with numbers in full precision
    Csv,
    /// An array of objects
    Json,
    /// A Parquet file, with every column unless --select names some; it needs --output
    Parquet,
}

#[derive(Args)]
pub(crate) struct QueryArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Keep the rows for which this holds, for example 'mu > 0.3 && mesh == 32'
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// Columns, separated by commas [default: the axes and the usual figures]
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS")]
    pub(crate) select: Vec<String>,
    /// Columns to sort by, separated by commas; -column sorts downwards (write --sort=-column)
    #[arg(long, value_delimiter = ',', value_name = "COLUMNS", allow_hyphen_values = true)]
    pub(crate) sort: Vec<String>,
    /// Print it in this form
    #[arg(long, value_enum, default_value = "table")]
    pub(crate) format: TableFormat,
    /// Print JSON, as --format json does
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,
    /// Write it to a file
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// List the columns that can be selected, and their units
    #[arg(long, conflicts_with_all = ["filter", "select", "sort"])]
    pub(crate) columns: bool,
    /// Print a row for each increment of the loading paths, which the columns step, cycle and
    /// increment tell apart
    #[arg(long)]
    pub(crate) steps: bool,
    /// Keep the points of one of so many parts of the study, for example 3/16
    #[arg(long, value_name = "I/N")]
    pub(crate) shard: Option<Shard>,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct ShowArgs {
    /// Key of the result, or its first characters
    pub(crate) key: String,
    /// Draw a field: pressure, traction_x, traction_y, traction, gap, slip_x, slip_y,
    /// friction_work, state, or wear_depth of a scene that wears
    #[arg(long, value_name = "FIELD")]
    pub(crate) field: Option<String>,
    /// Draw the field of the solution with this index, where a search found several [default: 0]
    #[arg(long, value_name = "INDEX", requires = "field")]
    pub(crate) solution: Option<usize>,
    /// Write the field to a file: .png .svg .npy .vti .csv, or the fields of all increments: .pvd
    /// (their path is solved again). Without --field, .vti .csv .pvd hold every field
    #[arg(long, value_name = "FILE", conflicts_with_all = ["steps", "json"])]
    pub(crate) output: Option<PathBuf>,
    /// Take the fields below the surface on a plane, "z=0.1 mm", or on a section, "y=0 mm":
    /// von_mises, tresca, stress_xx … stress_xz, stress_first … stress_third
    #[arg(long, value_name = "PLANE", conflicts_with_all = ["steps", "json", "solution"])]
    pub(crate) plane: Option<String>,
    /// Depth of a section, "0.5 mm" [default: twice the radius of the disk of the loaded area]
    #[arg(long, value_name = "DEPTH", requires = "plane")]
    pub(crate) down_to: Option<String>,
    /// Print the increments of its loading path as a table
    #[arg(long, conflicts_with = "field")]
    pub(crate) steps: bool,
    /// Print JSON
    #[arg(long, conflicts_with = "field")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct PlotArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Draw only the figure of this name; a figure without a name is called by its number [default:
    /// all]
    #[arg(long, value_name = "NAME")]
    pub(crate) figure: Option<String>,
    /// Form of the figure [default: that of the study's figure; scatter for a sample]
    #[arg(long, value_name = "KIND", value_parser = ["curves", "scatter", "histogram"])]
    pub(crate) kind: Option<String>,
    /// Number of bins of a histogram [default: by the rule of Freedman and Diaconis]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) bins: Option<u32>,
    /// Draw a histogram of parts of the points, and not of counts
    #[arg(long)]
    pub(crate) share: bool,
    /// Column along x [default: the study's figure]
    #[arg(long)]
    pub(crate) x: Option<String>,
    /// Column along y, or several of one unit, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub(crate) y: Vec<String>,
    /// Columns that tell the curves apart, separated by commas
    #[arg(long, value_delimiter = ',')]
    pub(crate) series: Option<Vec<String>>,
    /// Column that tells the panels apart
    #[arg(long)]
    pub(crate) panels: Option<String>,
    /// Draw every increment, joined along its loading path, for example --x at_shift_x --y force_x
    #[arg(long)]
    pub(crate) steps: bool,
    /// Keep the rows for which this holds
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// Draw x on a logarithmic axis
    #[arg(long)]
    pub(crate) log_x: bool,
    /// Draw y on a logarithmic axis
    #[arg(long)]
    pub(crate) log_y: bool,
    /// File to write, .svg or .png [default: NAME.svg and NAME.png in the current directory,
    /// NAME-FIGURE for the other figures]
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Print JSON: the files written
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

#[derive(Args)]
pub(crate) struct ReportArgs {
    /// Name of the study
    pub(crate) name: String,
    /// Keep the jobs for which this holds, for example 'mu > 0.3 && mesh == 32'
    #[arg(long = "where", value_name = "EXPRESSION")]
    pub(crate) filter: Option<String>,
    /// The jobs whose fields the page has: keys, or their first characters, separated by commas, or
    /// how many at most, from 0 to 999 [default: a handful that tell most]
    #[arg(long, value_name = "KEYS|N", value_parser = FieldChoice::parse)]
    pub(crate) fields: Option<FieldChoice>,
    /// File to write [default: NAME.html in the current directory]
    #[arg(long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
    /// Write an RO-Crate into this new directory instead: the page with the study's files, its
    /// results, its figures, its references and what computed it
    #[arg(long = "crate", value_name = "DIR", conflicts_with_all = ["filter", "output"])]
    pub(crate) research_object: Option<PathBuf>,
    /// Licence of the RO-Crate, as the address of its text
    #[arg(long, value_name = "URL", requires = "research_object")]
    pub(crate) license: Option<String>,
    /// Author of the RO-Crate, as a name or as "NAME, https://orcid.org/…"; once for each author
    #[arg(long = "author", value_name = "NAME", requires = "research_object")]
    pub(crate) authors: Vec<String>,
    /// Print JSON: the file, its size, the jobs whose fields it has, what it leaves out
    #[arg(long)]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}

/// The jobs whose fields a page has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum FieldChoice {
    /// At most so many, which tell most.
    Count(usize),
    /// The jobs whose keys begin so.
    Keys(Vec<String>),
}

impl FieldChoice {
    /// Parses a count of at most three digits, or beginnings of keys.
    fn parse(text: &str) -> Result<Self, String> {
        let is_digits = text.bytes().all(|byte| byte.is_ascii_digit());
        if let (true, 1..=3, Ok(count)) = (is_digits, text.len(), text.parse()) {
            return Ok(Self::Count(count));
        }
        let keys: Vec<String> =
            text.split(',').map(|key| key.trim().to_ascii_lowercase()).collect();
        match keys.iter().find(|key| {
            !(1..=64).contains(&key.len()) || !key.bytes().all(|byte| byte.is_ascii_hexdigit())
        }) {
            Some(key) => Err(format!(
                "`{key}` is neither a number up to 999 nor the beginning of a key, which has \
                 hexadecimal digits"
            )),
            None => Ok(Self::Keys(keys)),
        }
    }
}

/// The formats of a list of references.
#[derive(Clone, Copy, ValueEnum)]
pub(crate) enum CitationFormat {
    /// A text for reading: what is used, by how many jobs, and the works
    Text,
    /// References in BibTeX, each work once
    Bibtex,
}

#[derive(Args)]
pub(crate) struct CiteArgs {
    /// Name of the study in the store, or a study file
    pub(crate) name: String,
    /// Print it in this form
    #[arg(long, value_enum, default_value = "text")]
    pub(crate) format: CitationFormat,
    /// Print JSON
    #[arg(long, conflicts_with = "format")]
    pub(crate) json: bool,
    #[command(flatten)]
    pub(crate) store: StoreArgs,
}
