//! The memory that a run may use: of the machine, and of the container (cgroup v2 or v1) that it is
//! in.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Returns the memory that this process and its children may take now \[bytes\]: what the machine
/// has available, or what is left of the limit of a container around it. It is `None` where the
/// system does not tell.
pub fn available_memory() -> Option<u64> {
    let of_machine = read_field(Path::new("/proc/meminfo"), "MemAvailable:").map(|kb| kb * 1024);
    groups().iter().filter_map(MemoryGroup::left).chain(of_machine).min()
}

/// Returns the least limit that a container or another group of processes around this one sets to
/// its memory \[bytes\], or `None` if there is none.
pub fn memory_of_group() -> Option<u64> {
    groups().iter().filter_map(MemoryGroup::limit).min()
}

/// A group of processes whose memory is limited together.
#[derive(Debug, PartialEq)]
struct MemoryGroup {
    directory: PathBuf,
    version: Version,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Version {
    V1,
    V2,
}

impl MemoryGroup {
    /// Returns what is left of the limit \[bytes\], or `None` if there is no limit. Cached files
    /// that nobody uses count as left, since the system gives them up first.
    fn left(&self) -> Option<u64> {
        let (usage, cache) = match self.version {
            Version::V1 => ("memory.usage_in_bytes", "total_inactive_file"),
            Version::V2 => ("memory.current", "inactive_file"),
        };
        let limit = self.limit()?;
        let cache = read_field(&self.directory.join("memory.stat"), cache).unwrap_or(0);
        let used = self.number(usage).unwrap_or(0).saturating_sub(cache);
        Some(limit.saturating_sub(used))
    }

    /// Returns the limit of the group \[bytes\], or `None` if there is none.
    fn limit(&self) -> Option<u64> {
        let name = match self.version {
            Version::V1 => "memory.limit_in_bytes",
            Version::V2 => "memory.max",
        };
        // Version 1 says "no limit" by a number beyond all memory, version 2 by a word.
        self.number(name).filter(|&limit| limit < 1 << 60)
    }

    /// Returns the number that stands alone in a file of the group.
    fn number(&self, name: &str) -> Option<u64> {
        std::fs::read_to_string(self.directory.join(name)).ok()?.trim().parse().ok()
    }

    /// Returns how many processes of the group the system has killed for want of memory.
    fn kills(&self) -> u64 {
        let name = match self.version {
            Version::V1 => "memory.oom_control",
            Version::V2 => "memory.events",
        };
        read_field(&self.directory.join(name), "oom_kill").unwrap_or(0)
    }
}

/// Returns the number behind `name` in a file of lines of names and numbers.
fn read_field(path: &Path, name: &str) -> Option<u64> {
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        (words.next()? == name).then(|| words.next()?.parse().ok()).flatten()
    })
}

/// Returns the groups of this process that limit memory, from its own up to the outermost that can
/// be seen from here.
fn groups() -> Vec<MemoryGroup> {
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    groups_of(&read("/proc/self/cgroup"), &read("/proc/self/mountinfo"))
}

/// Finds the groups by the texts of `/proc/PID/cgroup` and `/proc/PID/mountinfo`.
fn groups_of(memberships: &str, mounts: &str) -> Vec<MemoryGroup> {
    let mut found = Vec::new();
    for membership in memberships.lines() {
        let mut parts = membership.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (parts.next(), parts.next()) else { continue };
        let version = match controllers {
            "" => Version::V2,
            some if some.split(',').any(|name| name == "memory") => Version::V1,
            _ => continue,
        };
        let Some(mount) = mounts.lines().find_map(|line| Mount::of(line, version)) else {
            continue;
        };
        // In a container the mount shows the hierarchy from the container's own group downwards.
        let path = Path::new(path);
        let below = path.strip_prefix(&mount.root).unwrap_or(Path::new(""));
        for part in below.ancestors() {
            found.push(MemoryGroup { directory: mount.point.join(part), version });
        }
    }
    found
}

/// The place where a hierarchy of groups is mounted.
struct Mount {
    /// The group that the mount shows as its root.
    root: PathBuf,
    point: PathBuf,
}

impl Mount {
    /// Reads a line of mountinfo, and returns `None` if it is about something else.
    fn of(line: &str, version: Version) -> Option<Mount> {
        let (place, file_system) = line.split_once(" - ")?;
        let mut place = place.split(' ').skip(3);
        let mut file_system = file_system.split(' ');
        let (kind, options) = (file_system.next()?, file_system.nth(1)?);
        let fits = match version {
            Version::V1 => kind == "cgroup" && options.split(',').any(|name| name == "memory"),
            Version::V2 => kind == "cgroup2",
        };
        fits.then(|| Some(Mount { root: place.next()?.into(), point: place.next()?.into() }))?
    }
}

/// The time for which a kill by the system explains the death of a worker, since it was found.
const LATELY: Duration = Duration::from_secs(10);
/// The share of the last ten seconds in which some process waited for memory, above which the
/// system is called short of it \[percent\].
const PRESSURE: f64 = 20.0;

/// A watch over the processes that the system kills for want of memory.
#[derive(Debug)]
pub(crate) struct Starvation {
    /// The number of kills at the last look.
    kills: u64,
    /// The time of the last look that found more of them.
    found: Option<Instant>,
}

impl Starvation {
    pub(crate) fn watch() -> Starvation {
        Starvation { kills: kills(), found: None }
    }

    /// Returns true if the system has killed a process for want of memory since the last look,
    /// however long ago that was, or if a look found so less than [`LATELY`] ago, or if the system
    /// is short of memory.
    pub(crate) fn is_felt(&mut self) -> bool {
        let kills = kills();
        if kills > self.kills {
            (self.kills, self.found) = (kills, Some(Instant::now()));
        }
        self.found.is_some_and(|found| found.elapsed() < LATELY) || pressure() > PRESSURE
    }
}

/// Counts the processes that the system has killed for want of memory.
fn kills() -> u64 {
    let of_machine = read_field(Path::new("/proc/vmstat"), "oom_kill").unwrap_or(0);
    of_machine + groups().iter().map(MemoryGroup::kills).sum::<u64>()
}

/// Returns the share of the last ten seconds in which some process waited for memory \[percent\].
fn pressure() -> f64 {
    let text = std::fs::read_to_string("/proc/pressure/memory").unwrap_or_default();
    let some = text.lines().find_map(|line| line.strip_prefix("some avg10="));
    some.and_then(|rest| rest.split(' ').next()?.parse().ok()).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_group_is_found_through_its_mount() {
        let mounts = "30 24 0:26 / /proc rw - proc proc rw\n\
                      31 24 0:27 /docker/ab /sys/fs/cgroup/memory rw,relatime - cgroup cgroup rw,memory\n\
                      32 24 0:28 / /sys/fs/cgroup/unified rw - cgroup2 cgroup2 rw\n";
        let directories = |memberships| {
            groups_of(memberships, mounts)
                .into_iter()
                .map(|group| group.directory.display().to_string())
                .collect::<Vec<_>>()
        };
        assert_eq!(
            directories("4:memory:/docker/ab/job\n1:cpu:/x\n"),
            ["/sys/fs/cgroup/memory/job", "/sys/fs/cgroup/memory/"]
        );
        let unified = "/sys/fs/cgroup/unified/";
        assert_eq!(
            directories("0::/a/b\n"),
            [&format!("{unified}a/b"), &format!("{unified}a"), unified]
        );
        assert_eq!(directories("4:memory:/elsewhere\n"), ["/sys/fs/cgroup/memory/"]);
        assert_eq!(directories("nonsense\n::\n"), ["/sys/fs/cgroup/unified/"]);
    }

    #[test]
    fn what_is_left_is_the_limit_without_what_is_used() {
        let place = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(place.path().join(name), text).unwrap();
        let group = |version| MemoryGroup { directory: place.path().to_owned(), version };
        assert_eq!(group(Version::V2).left(), None);
        write("memory.max", "max\n");
        assert_eq!((group(Version::V2).left(), group(Version::V2).limit()), (None, None));
        write("memory.max", "1000000\n");
        write("memory.current", "600000\n");
        write("memory.stat", "anon 1\nfile 2\ninactive_file 100000\n");
        assert_eq!(group(Version::V2).left(), Some(500_000));
        assert_eq!(group(Version::V2).limit(), Some(1_000_000));
        write("memory.events", "low 0\noom 3\noom_kill 2\n");
        assert_eq!(group(Version::V2).kills(), 2);
        write("memory.limit_in_bytes", "9223372036854771712\n");
        assert_eq!((group(Version::V1).left(), group(Version::V1).limit()), (None, None));
        write("memory.limit_in_bytes", "300\n");
        write("memory.usage_in_bytes", "400\n");
        assert_eq!((group(Version::V1).left(), group(Version::V1).limit()), (Some(0), Some(300)));
    }

    #[test]
    fn this_machine_has_memory_left() {
        assert!(available_memory().unwrap() > 0);
    }
}
