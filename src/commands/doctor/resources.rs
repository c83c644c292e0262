//! Resources that the system gives: cores, memory, shared memory, files, threads, places for files.

use std::fs;
use std::io::{self, ErrorKind};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use indicatif::BinaryBytes;
use runner::{Room, SHARED_MEMORY, SharedMemory};

use super::observation::Observation;
use crate::execution::usual_memory;
use crate::threads::usable;
use crate::words::count;

/// The memory for jobs below which little more than coarse meshes are solved \[bytes\].
const LITTLE_MEMORY: u64 = 256 << 20;

/// Says how many cores this process may use, and what takes the others.
pub(super) fn cores(granted: usize) -> Observation {
    let affinity = rustix::thread::sched_getaffinity(None);
    let allowed = affinity.map_or(granted, |set| set.count() as usize);
    let listed = fs::read_to_string("/proc/cpuinfo").map_or(0, |text| listed_cores(&text));
    let mut found = core_words(granted, allowed, listed.max(allowed));
    let usable = usable(granted);
    if usable < granted {
        found += &format!("; RAYON_NUM_THREADS leaves {usable} to the threads of jobs");
    }
    Observation::fine("cores", found)
}

/// Counts the processors that `/proc/cpuinfo` lists.
fn listed_cores(text: &str) -> usize {
    text.lines().filter(|line| line.starts_with("processor")).count()
}

fn core_words(granted: usize, allowed: usize, there: usize) -> String {
    let mut found = granted.to_string();
    if granted < there {
        found += &format!(" of {there}");
    }
    if allowed < there {
        found += &format!(": the affinity of this process has {allowed} (taskset, a batch system)");
    }
    if granted < allowed {
        found += &format!(": the quota of its container or group (cgroup) has {granted}");
    }
    found
}

/// Says how much memory there is, and how much of it the jobs of a run may use.
pub(super) fn memory() -> Observation {
    let said = |bytes: Option<u64>| bytes.map_or("?".to_owned(), |n| BinaryBytes(n).to_string());
    let usual = usual_memory();
    let mut found =
        format!("{} available, {} for jobs", said(runner::available_memory()), BinaryBytes(usual));
    if let Some(limit) = runner::memory_of_group() {
        found += &format!("; a container or group (cgroup) has {}", BinaryBytes(limit));
    }
    if let Some(limit) = runner::memory_within_limits() {
        found += &format!("; a job may have {} (`ulimit -v`, `ulimit -d`)", BinaryBytes(limit));
    }
    if usual < LITTLE_MEMORY {
        return Observation::short(
            "memory",
            found,
            "fine meshes are left for another run; `tribosweep plan STUDY` says what a study needs",
        );
    }
    Observation::fine("memory", found)
}

/// Says how much shared memory there is, and whether it has room for as many workers as cores.
pub(super) fn shared_memory(cores: usize) -> Observation {
    shared_memory_of(runner::shared_memory(), runner::shared_memory_for(cores).as_ref())
}

/// Judges shared memory; `limited` is the room for workers in it, if that is not enough.
fn shared_memory_of(memory: io::Result<SharedMemory>, limited: Option<&Room>) -> Observation {
    let subject = "shared memory";
    let memory = match memory {
        Ok(memory) => memory,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            return Observation::missing(subject, format!("there is no {SHARED_MEMORY}"))
                .advised(format!("mount a tmpfs at {SHARED_MEMORY}"));
        }
        Err(error) => {
            return Observation::short(
                subject,
                format!("the system does not say how much {SHARED_MEMORY} has: {error}"),
                "the run below shows whether it can be used",
            );
        }
    };
    let (size, free) = (BinaryBytes(memory.size), BinaryBytes(memory.free));
    let found = format!("{SHARED_MEMORY} has {size}, {free} free");
    if let Some(room) = limited {
        let workers = count(room.workers, "worker", "workers");
        return Observation::short(
            subject,
            format!("{found}: room for {workers}"),
            "give a container more (`docker run --shm-size=1g`), or remove what fills it",
        );
    }
    Observation::fine(subject, found)
}

/// Says how many files the process may open.
pub(super) fn open_files() -> Observation {
    let found = match runner::free_files() {
        Some(free) => format!("{free} more may be open"),
        None => "without a limit".to_owned(),
    };
    Observation::fine("open files", found)
}

/// Says how many threads the user may have.
pub(super) fn threads() -> Observation {
    let found = match runner::thread_limit() {
        Some(limit) => format!("this user may have {limit} (`ulimit -u`)"),
        None => "without a limit of the user".to_owned(),
    };
    Observation::fine("threads", found)
}

/// Says how many workers a run would have.
pub(super) fn workers(cores: usize, limited: Option<&Room>) -> Observation {
    match limited {
        None => Observation::fine("workers", format!("{cores}, one for each core")),
        Some(Room { workers: 0, reason }) => {
            Observation::missing("workers", format!("no worker can be started: {reason}"))
        }
        Some(Room { workers, reason }) => Observation::short(
            "workers",
            format!("{} at a time: {reason}", count(*workers, "worker", "workers")),
            format!("a run goes on with fewer than the {cores} cores; raise the limit for all"),
        ),
    }
}

/// Says whether temporary files can be written.
pub(super) fn temporary_files() -> Observation {
    let place = std::env::temp_dir();
    match tempfile::tempfile_in(&place) {
        Ok(_) => {
            Observation::fine("temporary files", format!("{}{}", place.display(), free(&place)))
        }
        Err(error) => Observation::short(
            "temporary files",
            format!("cannot write in {}: {error}", place.display()),
            "set TMPDIR to a directory on a local disk; `run --export` keeps its store there",
        ),
    }
}

/// Says where the results would be kept.
pub(super) fn store(path: &Path) -> Observation {
    let shown = path.display();
    match directory_of(path) {
        Ok(place) => {
            let new = if path.is_dir() { "" } else { " (new)" };
            let kind = file_system(&place).map_or(String::new(), |kind| format!(", {kind}"));
            Observation::fine("store", format!("{shown}{new}{kind}{}", free(&place)))
        }
        Err(error) => Observation::missing("store", format!("{shown}: {error}"))
            .advised("name another directory: --store DIR"),
    }
}

/// Returns the directory of a store, or the one in which it would be made.
pub(super) fn directory_of(store: &Path) -> std::io::Result<PathBuf> {
    let absolute = std::path::absolute(store)?;
    let there = absolute.ancestors().find(|place| place.exists()).unwrap_or(Path::new("/"));
    // What is not a directory is refused by its name.
    fs::read_dir(there).map(|_| there.to_owned())
}

/// Returns the free space of a directory in words, to be appended.
fn free(place: &Path) -> String {
    rustix::fs::statvfs(place).map_or(String::new(), |volume| {
        format!(", {} free", BinaryBytes(volume.f_bavail.saturating_mul(volume.f_frsize)))
    })
}

/// Returns the kind of the file system of a directory.
fn file_system(place: &Path) -> Option<String> {
    let device = fs::metadata(place).ok()?.dev();
    let number = format!("{}:{}", rustix::fs::major(device), rustix::fs::minor(device));
    kind_of_mount(&fs::read_to_string("/proc/self/mountinfo").ok()?, &number)
}

/// Finds the kind of the file system with a number in the text of `mountinfo`.
fn kind_of_mount(mounts: &str, number: &str) -> Option<String> {
    mounts.lines().find_map(|line| {
        let (place, kind) = line.split_once(" - ")?;
        (place.split(' ').nth(2)? == number).then(|| kind.split(' ').next().map(str::to_owned))?
    })
}

#[cfg(test)]
mod tests {
    use super::super::observation::Soundness;
    use super::*;

    #[test]
    fn shared_memory_is_short_if_it_holds_too_few_workers_or_is_not_known() {
        let memory = || Ok(SharedMemory { size: 64 << 20, free: 1 << 20 });
        assert_eq!(shared_memory_of(memory(), None).soundness, Soundness::Fine);
        let room = Room { workers: 1, reason: "it is full".to_owned() };
        let short = shared_memory_of(memory(), Some(&room));
        assert_eq!(short.soundness, Soundness::Short);
        assert!(short.found.ends_with("1.00 MiB free: room for 1 worker"), "{}", short.found);
        let nowhere = shared_memory_of(Err(ErrorKind::NotFound.into()), None);
        assert_eq!(nowhere.soundness, Soundness::Missing);
        assert_eq!(nowhere.found, "there is no /dev/shm");
        let unknown = shared_memory_of(Err(ErrorKind::PermissionDenied.into()), None);
        assert_eq!(unknown.soundness, Soundness::Short);
        assert!(unknown.found.ends_with("/dev/shm has: permission denied"), "{}", unknown.found);
    }

    #[test]
    fn cores_are_told_from_those_that_others_have() {
        let cpuinfo = "processor\t: 0\nmodel name\t: x\n\nprocessor\t: 1\nmodel name\t: x\n";
        assert_eq!(listed_cores(cpuinfo), 2);
        assert_eq!(core_words(8, 8, 8), "8");
        assert!(core_words(4, 4, 64).starts_with("4 of 64: the affinity of this process has 4"));
        assert!(core_words(2, 8, 8).starts_with("2 of 8: the quota of its container"));
        let both = core_words(2, 4, 8);
        assert!(both.contains("affinity of this process has 4") && both.contains("(cgroup) has 2"));
    }

    #[test]
    fn the_kind_of_a_file_system_is_found_by_its_number() {
        let mounts = "22 1 8:1 / / rw - ext4 /dev/sda1 rw\n\
                      40 22 0:35 / /home rw,relatime shared:1 - nfs4 server:/home rw\nnonsense\n";
        assert_eq!(kind_of_mount(mounts, "0:35").as_deref(), Some("nfs4"));
        assert_eq!(kind_of_mount(mounts, "8:1").as_deref(), Some("ext4"));
        assert_eq!(kind_of_mount(mounts, "9:9"), None);
    }

    #[test]
    fn a_new_store_is_made_in_the_nearest_directory_that_is_there() {
        let place = tempfile::tempdir().unwrap();
        let file = place.path().join("file");
        fs::write(&file, "").unwrap();
        assert_eq!(directory_of(&place.path().join("a/b")).unwrap(), place.path());
        assert_eq!(directory_of(place.path()).unwrap(), place.path());
        assert!(directory_of(&file).is_err() && directory_of(&file.join("a")).is_err());
    }
}
