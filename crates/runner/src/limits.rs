//! The limits of this process and of its user, and what a run needs of them.
//!
//! They are compared before anything starts: libraries meet a limit with a panic, a signal or an
//! endless wait.

use std::sync::{Arc, Condvar, Mutex, PoisonError};

use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};

use crate::root::{SHARED_MEMORY, free_shared_memory};
use crate::signals::refuse_oversized_writes;

/// The descriptors that the coordinator needs for a worker (measured: 25).
const FILES_PER_WORKER: u64 = 26;
/// The descriptors that the program needs for everything else: the store, its readers, figures.
const FILES: u64 = 40;
/// The shared memory that one channel takes from the start \[bytes\], with room to spare (measured:
/// 0.1 MiB).
const CHANNEL: u64 = 1 << 20;
/// The shared memory that must stay free \[bytes\], so that others do not meet SIGBUS either.
pub(crate) const RESERVE: u64 = 16 << 20;
/// The threads that a worker has, its process counted as one, if its jobs use a single thread.
const THREADS_PER_WORKER: usize = 3;
/// The most threads of workers that are tried: a machine that grants so many grants more.
const MOST_TRIED: usize = 3 << 10;
/// The threads that the program needs for the store and for itself, beside one for each core
/// (measured: 9, and one more for each reader and while a worker is started).
const THREADS: usize = 14;
/// The address space that the program needs beyond what it has when it starts \[bytes\] (measured:
/// 110 MiB); most of it is reserved for the arenas and stacks of threads, and not used.
const ADDRESS_SPACE: u64 = 256 << 20;
/// The address space of the stack of a thread, of which there is one for each core \[bytes\].
const THREAD_STACK: u64 = 2 << 20;
/// The private memory that the program needs beyond what it has when it starts \[bytes\] (measured:
/// 50 MiB).
const PRIVATE_MEMORY: u64 = 96 << 20;
/// The address space that a worker needs beside its job \[bytes\] (measured: 170 MiB).
const WORKER_ADDRESS_SPACE: u64 = 256 << 20;
/// The private memory that a worker needs beside its job \[bytes\] (measured: 24 MiB).
const WORKER_PRIVATE_MEMORY: u64 = 64 << 20;
/// The size from which on a block of memory goes back to the system when it is freed \[bytes\].
#[cfg(target_env = "gnu")]
const LARGE: i32 = 4 << 20;
/// The stack that the first thread needs \[bytes\].
const STACK: u64 = 1 << 20;

/// A limit that leaves too little room.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct LimitError(String);

/// Prepares the process for the work of any command: it may open as many files as its hard limit
/// allows, and a write beyond the largest file size is an error instead of a signal.
///
/// # Errors
/// [`LimitError`] if a limit of the process is so low that a library would fail without a word.
pub fn prepare_process() -> Result<(), LimitError> {
    refuse_oversized_writes().map_err(|error| {
        LimitError(format!("the system does not say when a file becomes too large: {error}"))
    })?;
    let files = getrlimit(Resource::Nofile);
    // The hard limit may be beyond what the kernel grants now; then the soft one stays.
    let _ = setrlimit(Resource::Nofile, Rlimit { current: files.maximum, maximum: files.maximum });
    enough_address_space()?;
    let free = free_files().unwrap_or(u64::MAX);
    if free < FILES {
        return Err(LimitError(format!(
            "{free} more files may be open here, and {FILES} are needed: raise the limit with \
             `ulimit -n`"
        )));
    }
    let threads = THREADS + cores();
    let granted = threads_granted(threads);
    if granted < threads {
        return Err(LimitError(format!(
            "this user may start {granted} more threads here, and {threads} are needed: raise the \
             limit with `ulimit -u`, or end other processes"
        )));
    }
    Ok(())
}

/// Checks that the first thread has enough stack to read a command line.
///
/// # Errors
/// [`LimitError`] if it has not.
pub fn enough_stack() -> Result<(), LimitError> {
    match getrlimit(Resource::Stack).current.filter(|&stack| stack < STACK) {
        Some(stack) => Err(LimitError(format!(
            "the stack may have {} here, and {} are needed: raise the limit with `ulimit -s`",
            size(stack),
            size(STACK)
        ))),
        None => Ok(()),
    }
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

fn enough_address_space() -> Result<(), LimitError> {
    if memory_within_limits().is_some() {
        reserve_little();
    }
    // Some systems count private memory only, and limit that.
    let resources = [
        (Resource::As, 0, ADDRESS_SPACE + cores() as u64 * THREAD_STACK, "-v"),
        (Resource::Data, 5, PRIVATE_MEMORY, "-d"),
    ];
    for (resource, column, more, option) in resources {
        let Some(limit) = getrlimit(resource).current else { continue };
        let needed = used_memory(column).saturating_add(more);
        if limit < needed {
            return Err(LimitError(format!(
                "a process may reserve {} of memory here, and {} are needed: raise the limit with \
                 `ulimit {option}`",
                size(limit),
                size(needed)
            )));
        }
    }
    Ok(())
}

/// Makes threads share two arenas, where each would reserve 64 MiB of address space for one of its
/// own. That costs time only where many threads allocate at once.
fn reserve_little() {
    #[cfg(target_env = "gnu")]
    set_allocator(nix::libc::M_ARENA_MAX, 2);
}

/// Lets the process keep little of the memory that it has freed, for one that lives longer than
/// what it has in memory. There are no more arenas than cores, so that threads share what others
/// have freed, and what is large goes back to the system. By itself the limit of what is large
/// rises to 32 MiB with the blocks that are freed: a run of 400 000 small jobs ended with 92 MiB of
/// memory of its own in place of 129.
pub fn keep_little() {
    #[cfg(target_env = "gnu")]
    {
        let arenas = if memory_within_limits().is_some() { 2 } else { cores().max(2) };
        set_allocator(nix::libc::M_ARENA_MAX, i32::try_from(arenas).unwrap_or(i32::MAX));
        set_allocator(nix::libc::M_MMAP_THRESHOLD, LARGE);
    }
}

/// Returns to the system what the process has freed, by whole pages.
#[allow(unsafe_code)]
pub fn return_freed() {
    #[cfg(target_env = "gnu")]
    // SAFETY: malloc_trim may be called at any time.
    unsafe {
        nix::libc::malloc_trim(0);
    }
}

#[cfg(target_env = "gnu")]
#[allow(unsafe_code)]
fn set_allocator(parameter: i32, value: i32) {
    // SAFETY: mallopt may be called at any time, and refuses a value that a parameter cannot have.
    unsafe {
        nix::libc::mallopt(parameter, value);
    }
}

/// Returns the number of processes and threads that the user may have by a limit of this process,
/// or `None` if there is no limit.
pub fn thread_limit() -> Option<u64> {
    getrlimit(Resource::Nproc).current
}

/// Returns a number of pages in `/proc/self/statm` as \[bytes\]; 0 if it cannot be read.
fn used_memory(column: usize) -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    let pages = text.split_whitespace().nth(column).and_then(|pages| pages.parse::<u64>().ok());
    pages.unwrap_or(0) * rustix::param::page_size() as u64
}

/// Returns the memory that a job may take by the limits that a worker inherits \[bytes\], or `None`
/// if there is no limit.
pub fn memory_within_limits() -> Option<u64> {
    let limits = [(Resource::As, WORKER_ADDRESS_SPACE), (Resource::Data, WORKER_PRIVATE_MEMORY)];
    let left = |(resource, base): (_, u64)| Some(getrlimit(resource).current?.saturating_sub(base));
    limits.into_iter().filter_map(left).min()
}

/// The workers for which there is room.
#[derive(Clone, Debug, PartialEq)]
pub struct Room {
    /// The number of workers that a run has at a time.
    pub workers: usize,
    /// The reason why there is not room for more.
    pub reason: String,
}

/// Returns how many workers have room whose jobs use so many threads, if it is fewer than `wanted`.
/// [`run`](crate::run) starts no more.
pub fn room(wanted: usize, threads: usize) -> Option<Room> {
    let limited = |workers: u64, reason: String| Room { workers: workers as usize, reason };
    let mut rooms = Vec::new();
    if let Some(files) = free_files() {
        rooms.push(limited(
            files.saturating_sub(FILES) / FILES_PER_WORKER,
            format!("a worker needs {FILES_PER_WORKER} open files, and {files} more may be open (`ulimit -n`)"),
        ));
    }
    rooms.extend(shared_memory_for(wanted));
    let tried = wanted.saturating_mul(threads_of_worker(threads)).min(MOST_TRIED) + THREADS;
    let granted = threads_granted(tried);
    rooms.extend((granted < tried).then(|| room_in_threads(granted, threads)));
    rooms.into_iter().filter(|room| room.workers < wanted).min_by_key(|room| room.workers)
}

/// Returns the number of threads of a worker whose jobs use so many of them. Its own is one of
/// those.
fn threads_of_worker(threads: usize) -> usize {
    threads.saturating_sub(1).saturating_add(THREADS_PER_WORKER)
}

/// Returns how many workers have room whose jobs use so many threads, when the program and its
/// workers may start `granted` threads.
fn room_in_threads(granted: usize, threads: usize) -> Room {
    let needed = threads_of_worker(threads);
    Room {
        workers: granted.saturating_sub(THREADS) / needed,
        reason: format!(
            "a worker needs {needed} threads, and this user may start {granted} more (`ulimit -u`)"
        ),
    }
}

/// Returns how many workers have room in shared memory for their channels, if they are fewer than
/// `wanted`.
pub fn shared_memory_for(wanted: usize) -> Option<Room> {
    let free = free_shared_memory()?;
    let workers = (free.saturating_sub(RESERVE) / CHANNEL) as usize;
    (workers < wanted).then(|| Room {
        workers,
        reason: format!(
            "a worker needs {} in {SHARED_MEMORY}, which has {} free and must keep {} for others",
            size(CHANNEL),
            size(free),
            size(RESERVE)
        ),
    })
}

/// Returns how many files the process may open beside those that are open, or `None` if there is no
/// limit.
pub fn free_files() -> Option<u64> {
    let limit = getrlimit(Resource::Nofile).current?;
    let open = std::fs::read_dir("/proc/self/fd").map_or(FILES, |found| found.count() as u64);
    Some(limit.saturating_sub(open))
}

/// Starts threads that do nothing until there are `wanted` of them or the system grants no more,
/// and returns their number. The limit is of the user and not of the process, so it is tried.
fn threads_granted(wanted: usize) -> usize {
    let mut threads = Vec::with_capacity(wanted);
    let end = Arc::new((Mutex::new(false), Condvar::new()));
    for _ in 0..wanted {
        let end = end.clone();
        let wait = move || {
            let (ended, change) = &*end;
            let ended = ended.lock().unwrap_or_else(PoisonError::into_inner);
            drop(change.wait_while(ended, |ended| !*ended));
        };
        match std::thread::Builder::new().stack_size(64 << 10).spawn(wait) {
            Ok(thread) => threads.push(thread),
            Err(_) => break,
        }
    }
    let granted = threads.len();
    *end.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
    end.1.notify_all();
    for thread in threads {
        let _ = thread.join();
    }
    granted
}

/// Returns a size in words.
pub(crate) fn size(bytes: u64) -> String {
    let units = [(1u64 << 30, "GiB"), (1 << 20, "MiB"), (1 << 10, "KiB")];
    match units.iter().find(|(unit, _)| bytes >= *unit) {
        Some((unit, name)) => format!("{:.1} {name}", bytes as f64 / *unit as f64),
        None => format!("{bytes} bytes"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_has_room_for_a_worker() {
        assert_eq!(room(1, 1), None);
        assert_eq!(threads_granted(3), 3);
    }

    #[test]
    fn there_is_no_room_for_any_number_of_workers() {
        let room = room(usize::MAX / 8, 1).unwrap();
        assert!(room.workers < usize::MAX / 8 && room.reason.starts_with("a worker needs"));
    }

    #[test]
    fn workers_with_many_threads_have_less_room() {
        let workers = [1, 2, 8, usize::MAX].map(|threads| {
            let Room { workers, reason } = room_in_threads(THREADS + 12, threads);
            assert!(reason.ends_with("this user may start 26 more (`ulimit -u`)"), "{reason}");
            workers
        });
        assert_eq!(workers, [4, 3, 1, 0]);
        assert!(room_in_threads(5, 4).reason.starts_with("a worker needs 6 threads, and"));
    }

    #[test]
    fn sizes_are_said_in_the_largest_unit() {
        let said = [0, 1023, 1024, 3 << 19, 5 << 30].map(size);
        assert_eq!(said, ["0 bytes", "1023 bytes", "1.0 KiB", "1.5 MiB", "5.0 GiB"]);
    }
}
