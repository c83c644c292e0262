//! The fields of all increments of a path as a series of files for ParaView and PyVista.

use std::ops::ControlFlow;
use std::path::Path;

use anyhow::{Context, Result, bail};
use contact::Cancellation;
use report::{Field, SeriesFile, pvd, vti};

use crate::fields::chosen_fields;
use crate::increments::PathJob;
use crate::output::{self, Finish};
use crate::written_file::write;

/// Writes a field of every increment, or all fields, to files `NAME/0001.vti` and so on, and the
/// file `NAME.pvd`, which is `file`, as their index. The index comes last, and in it the number of
/// an increment along the path, counted from 1, stands as its time.
///
/// # Errors
/// The path cannot be solved again, or a file cannot be written.
pub(crate) fn write_series(path: &PathJob<'_>, name: Option<&str>, file: &Path) -> Result<Finish> {
    path.increments()?;
    let folder = file.with_extension("");
    let Some(stem) = folder.file_name().and_then(|name| name.to_str()).map(str::to_owned) else {
        bail!("{}: the name of a series is text", file.display());
    };
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut files = Vec::new();
    path.follow(&Cancellation::default(), &mut |increment| {
        let chosen = chosen_fields(increment.fields, name)?;
        let bytes = vti(&chosen.iter().collect::<Vec<&Field>>())?;
        let of_increment = format!("{:04}.vti", increment.number);
        write(&folder.join(&of_increment), bytes.as_bytes())?;
        let path = format!("{stem}/{of_increment}");
        files.push(SeriesFile { time: increment.number as f64, path });
        Ok(ControlFlow::Continue(()))
    })?;
    write(file, pvd(&files).as_bytes())?;
    output::print(&format!("{}\n", file.display()))
}
