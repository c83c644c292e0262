//! The machine and the program as a run's account describes them.

use std::fs;

use study::account::{CommandWord, MachineAccount, ProgramBuild};

/// Returns the build of this program. Its commit and the state of its source are those at the time
/// of the build, which `build.rs` has looked up.
pub(crate) fn this_program() -> ProgramBuild {
    let commit = env!("TRIBOSWEEP_COMMIT");
    let dirty = match env!("TRIBOSWEEP_DIRTY") {
        "true" => Some(true),
        "false" => Some(false),
        _ => None,
    };
    ProgramBuild {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        commit: (!commit.is_empty()).then(|| commit.to_owned()),
        dirty,
    }
}

/// Names the build of this program, with which what it has learnt of records stays true.
pub(crate) fn build_words() -> String {
    let build = this_program();
    format!("{} {:?} {:?}", build.version, build.commit, build.dirty)
}

/// Returns a description of this machine.
pub(crate) fn this_machine() -> MachineAccount {
    let kernel = rustix::system::uname();
    let part = |part: &std::ffi::CStr| part.to_string_lossy().into_owned();
    let architecture = part(kernel.machine());
    let distribution =
        fs::read_to_string("/etc/os-release").ok().and_then(|text| pretty_name(&text));
    let kernel_words =
        format!("{} {} {architecture}", part(kernel.sysname()), part(kernel.release()));
    let processor =
        fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| processor_model(&text));
    MachineAccount {
        host: part(kernel.nodename()),
        processor: processor.unwrap_or(architecture),
        cores: std::thread::available_parallelism().map_or(1, |cores| cores.get() as u64),
        system: match distribution {
            Some(name) => format!("{name}, {kernel_words}"),
            None => kernel_words,
        },
    }
}

/// Returns the words of this process's command line. The program is called by the name of its file:
/// the directory in which it lies says nothing of a result.
pub(crate) fn command_line() -> Vec<CommandWord> {
    let mut words: Vec<_> = std::env::args_os().collect();
    if let Some(program) = words.first_mut()
        && let Some(name) = std::path::Path::new(program).file_name().map(ToOwned::to_owned)
    {
        *program = name;
    }
    let word = |word: std::ffi::OsString| match word.into_string() {
        Ok(text) => CommandWord::Text(text),
        Err(word) => CommandWord::Bytes(word.into_encoded_bytes()),
    };
    words.into_iter().map(word).collect()
}

/// Returns the model of the first processor that `/proc/cpuinfo` lists. ARM kernels name none.
fn processor_model(text: &str) -> Option<String> {
    let value = |line: &str| {
        let (name, value) = line.split_once(':')?;
        let is_model = ["model name", "cpu model", "cpu"].contains(&name.trim());
        (is_model && !value.trim().is_empty()).then(|| value.trim().to_owned())
    };
    text.lines().find_map(value)
}

/// Returns the name of a distribution from its `os-release`.
fn pretty_name(text: &str) -> Option<String> {
    let value = text.lines().find_map(|line| line.strip_prefix("PRETTY_NAME="))?;
    let name = value.trim().trim_matches(['"', '\'']);
    (!name.is_empty()).then(|| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processors_and_systems_are_found_in_the_files_of_several_kinds_of_machines() {
        let x86 =
            "processor\t: 0\nvendor_id\t: AuthenticAMD\nmodel\t\t: 1\nmodel name\t: AMD EPYC\n";
        assert_eq!(processor_model(x86).as_deref(), Some("AMD EPYC"));
        let power = "processor\t: 0\ncpu\t\t: POWER9, altivec supported\n";
        assert_eq!(processor_model(power).as_deref(), Some("POWER9, altivec supported"));
        let arm = "processor\t: 0\nBogoMIPS\t: 50.00\nCPU part\t: 0xd0c\n";
        assert_eq!(processor_model(arm), None);
        let debian = "NAME=\"Debian\"\nPRETTY_NAME=\"Debian GNU/Linux 13 (trixie)\"\n";
        assert_eq!(pretty_name(debian).as_deref(), Some("Debian GNU/Linux 13 (trixie)"));
        assert_eq!((pretty_name("NAME=x"), pretty_name("PRETTY_NAME=\"\"\n")), (None, None));
    }

    #[test]
    fn this_machine_and_this_program_are_known() {
        let MachineAccount { host, processor, cores, system } = this_machine();
        assert!(!host.is_empty() && !processor.is_empty() && cores > 0, "{host} {processor}");
        assert!(system.contains("Linux"), "{system}");
        let program = this_program();
        assert_eq!(program.version, env!("CARGO_PKG_VERSION"));
        // A commit is known with the state of the source, or neither is.
        assert!(program.commit.as_ref().is_none_or(|commit| commit.len() >= 40));
        assert!(program.commit.is_some() || program.dirty.is_none());
        let Some(CommandWord::Text(name)) = command_line().into_iter().next() else { panic!() };
        assert!(!name.contains('/'), "{name}");
    }
}
