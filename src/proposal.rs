//! Commands that are proposed to the user, ready to be pasted.

use std::ffi::OsStr;
use std::path::Path;

/// The variable that names the store where no option does.
pub(crate) const STORE_VARIABLE: &str = "TRIBOSWEEP_STORE";

/// The store where no option and no variable names one.
pub(crate) const USUAL_STORE: &str = ".tribosweep";

/// Returns a command of this program on a store, with its arguments quoted. The store is named
/// unless every command finds it by itself.
pub(crate) fn command<Word: AsRef<OsStr>>(
    store: &Path,
    arguments: impl IntoIterator<Item = Word>,
) -> String {
    let is_usual = store == Path::new(USUAL_STORE) && std::env::var_os(STORE_VARIABLE).is_none();
    let mut words: Vec<_> =
        arguments.into_iter().map(|word| word.as_ref().to_os_string()).collect();
    if !is_usual {
        words.extend([OsStr::new("--store").into(), wording::file_argument(store).into_owned()]);
    }
    wording::command(words)
}
