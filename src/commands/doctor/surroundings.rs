//! Things that stand around the program: the machine, the clock, the locale, Slurm, Python.

use std::io::{ErrorKind, Result};
use std::process::{Command, Output};
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use super::observation::Observation;
use crate::account::program_words;
use crate::machine::{this_machine, this_program};
use crate::output;
use crate::patience::answer_within;
use crate::scheduler::controller_config_within;
use crate::words::time_words;

/// The beginning of the year 2026, before which no program of this version was built [s since
/// 1970].
const EARLIEST: u64 = 1_767_225_600;

/// The most characters that are said of a controller that does not answer.
const LONGEST: usize = 200;

/// The time for which another program is waited for.
const PATIENCE: Duration = Duration::from_secs(10);

/// Asks a Python for its version and that of the package. It is isolated, so that no file of the
/// working directory is taken for a module; the user's own packages are named to it instead, which
/// a virtual environment does not see.
const ASK_PYTHON: &str = "
import importlib.metadata as m, platform, site, sys
print(platform.python_version())
if sys.prefix == sys.base_prefix:
    sys.path.append(site.getusersitepackages())
try: print(m.version('tribosweep'))
except m.PackageNotFoundError: pass
";

/// Says which program this is.
pub(super) fn program() -> Observation {
    Observation::fine("program", program_words(&this_program()))
}

/// Says which machine this is.
pub(super) fn machine() -> Observation {
    let machine = this_machine();
    Observation::fine("machine", format!("{}, {}", machine.processor, machine.system))
}

/// Says what time it is.
pub(super) fn clock() -> Observation {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |since| since.as_secs());
    if now < EARLIEST {
        let advice = "set the clock: results say when they were computed";
        return Observation::short("clock", time_words(now), advice);
    }
    Observation::fine("clock", time_words(now))
}

/// Says whether the terminal is said to show every letter.
pub(super) fn locale() -> Observation {
    locale_of(["LC_ALL", "LC_CTYPE", "LANG"].map(|name| std::env::var(name).unwrap_or_default()))
}

/// Judges the locale by the values of its variables, of which the first that is not empty counts.
fn locale_of(values: [String; 3]) -> Observation {
    let value = values.into_iter().find(|value| !value.is_empty()).unwrap_or_default();
    let capital = value.to_ascii_uppercase();
    if capital.contains("UTF-8") || capital.contains("UTF8") {
        return Observation::fine("locale", value);
    }
    let shown = if value.is_empty() { "none is set" } else { value.as_str() };
    Observation::short(
        "locale",
        format!("{shown}; letters such as µ and ² may be shown wrongly"),
        "export LC_ALL=C.UTF-8",
    )
}

/// Says whether studies can be submitted from here, and whether this is a job of Slurm.
pub(super) fn slurm() -> Observation {
    let variable = |name: &str| std::env::var(name).ok();
    let job = variable("SLURM_JOB_ID").map_or(String::new(), |job| format!("in job {job}, "));
    let is_there = std::env::var_os("PATH").is_some_and(|path| {
        std::env::split_paths(&path).any(|place| place.join("scontrol").is_file())
    });
    if !is_there {
        return Observation::fine("slurm", format!("{job}not installed; `submit` needs it"));
    }
    match controller_config_within(PATIENCE) {
        Ok(config) => {
            Observation::fine("slurm", format!("{job}MaxArraySize is {}", config.array_size))
        }
        Err(error) => Observation::short(
            "slurm",
            format!("{job}{}", wording::excerpt(&output::words(&error), LONGEST)),
            "`submit` needs the controller; a run does not",
        ),
    }
}

/// Says whether the Python of the PATH has the package.
pub(super) fn python() -> Observation {
    python_of(answer_within(Command::new("python3").args(["-I", "-B", "-c", ASK_PYTHON]), PATIENCE))
}

/// Judges Python by its version and that of the package, a line each.
fn python_of(answer: Result<Output>) -> Observation {
    let said = match answer {
        Ok(output) if output.status.success() => output.stdout,
        Ok(_) => Vec::new(),
        Err(error) if error.kind() == ErrorKind::NotFound => Vec::new(),
        Err(error) => {
            let found = format!("python3 cannot be asked: {error}; only the package needs it");
            return Observation::fine("python", found);
        }
    };
    let said = String::from_utf8_lossy(&said);
    let mut lines = said.lines();
    let install = "the package is not installed (`pip install ./python` in the sources)";
    match (lines.next(), lines.next()) {
        (None, _) => Observation::fine("python", "no python3 answers; only the package needs it"),
        (Some(python), None) => Observation::fine("python", format!("{python}; {install}")),
        (Some(python), Some(package)) if package == env!("CARGO_PKG_VERSION") => {
            Observation::fine("python", format!("{python} with the package tribosweep {package}"))
        }
        (Some(python), Some(package)) => Observation::short(
            "python",
            format!("{python} with the package tribosweep {package}"),
            format!(
                "install that of this program, {}: they read the same stores",
                env!("CARGO_PKG_VERSION")
            ),
        ),
    }
}

#[cfg(test)]
mod tests {
    use std::process::ExitStatus;

    use super::super::observation::Soundness;
    use super::*;

    #[test]
    fn the_first_variable_of_the_locale_counts() {
        let judged = |all: &str, lang: &str| locale_of([all, "", lang].map(str::to_owned));
        for (all, lang, soundness) in [
            ("", "de_DE.UTF-8", Soundness::Fine),
            ("C.utf8", "C", Soundness::Fine),
            ("C", "de_DE.UTF-8", Soundness::Short),
            ("", "", Soundness::Short),
        ] {
            assert_eq!(judged(all, lang).soundness, soundness, "{all} {lang}");
        }
        assert!(judged("", "").found.starts_with("none is set; "));
    }

    #[test]
    fn a_package_of_another_version_is_noticed() {
        let judged = |said: &str| {
            python_of(Ok(Output {
                status: ExitStatus::default(),
                stdout: said.into(),
                stderr: Vec::new(),
            }))
        };
        let own = judged(&format!("3.13.5\n{}\n", env!("CARGO_PKG_VERSION")));
        assert_eq!(own.soundness, Soundness::Fine);
        let other = judged("3.13.5\n0.0.1\n");
        assert_eq!(other.soundness, Soundness::Short);
        assert!(other.found.contains("tribosweep 0.0.1"), "{}", other.found);
        assert!(judged("3.13.5\n").found.contains("pip install"));
        for (kind, words) in [
            (ErrorKind::NotFound, "no python3 answers"),
            (ErrorKind::TimedOut, "python3 cannot be asked: timed out"),
        ] {
            let seen = python_of(Err(kind.into()));
            assert!(seen.found.starts_with(words), "{}", seen.found);
        }
    }
}
