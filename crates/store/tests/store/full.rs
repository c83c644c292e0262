//! The disk is full.

use std::path::Path;
use std::process::Command;

use store::{OpenError, Store, WriteError};

use super::child::{Player, command};
use super::key;

/// Checks that everything is there that a "fill" part has acknowledged.
fn check(directory: &Path, transcript: &[String]) {
    let groups = transcript.iter().filter(|line| line.starts_with("committed")).count() as u64;
    assert!(groups > 3, "{transcript:?}");
    let store = Store::open(directory).unwrap();
    for group in 0..groups {
        for i in 0..10 {
            assert_eq!(store.get(&key(10 * group + i)).unwrap(), Some(vec![group as u8; 16 << 10]));
        }
    }
    store.commit(&[(key(u64::MAX), b"there is room again")]).unwrap();
}

/// The database comes near the limit of a file's size. sled does not survive a write that the
/// kernel refuses, so the store stops before.
#[test]
fn a_write_beyond_the_limit_of_a_file_is_said_and_loses_nothing_acknowledged() {
    for (mebibytes, count) in [(11, 2), (14, 1), (17, 1)] {
        let directory = tempfile::tempdir().unwrap();
        let inner = command("fill", directory.path(), 0);
        let mut outer = Command::new("bash");
        outer
            .arg("-c")
            .arg(format!("trap '' XFSZ; ulimit -f {}; exec \"$0\" \"$@\"", mebibytes * 1024));
        outer.arg(inner.get_program()).args(inner.get_args());
        outer.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
        outer.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
        let transcript = Player::start(outer).transcript();
        let failures: Vec<_> =
            transcript.iter().filter(|line| line.starts_with("failed: ")).collect();
        assert_eq!(failures.len(), count, "{failures:?}");
        assert!(
            failures.iter().all(|line| line.contains("nothing that was done is lost")),
            "{failures:?}"
        );
        assert_eq!(transcript.last().map(String::as_str), Some("closed"));
        check(directory.path(), &transcript);
    }
}

/// The file system is really full.
#[test]
fn a_disk_nearly_full_is_not_written_to() {
    let directory = tempfile::tempdir().unwrap();
    let volume = directory.path().join("volume");
    std::fs::create_dir(&volume).unwrap();
    let mounted = |options: &str| {
        Command::new("mount").args(["-t", "tmpfs", "-o", options, "tmpfs"]).arg(&volume).output()
    };
    if !mounted("size=24m").is_ok_and(|run| run.status.success()) {
        eprintln!("skipped: mounting a small file system takes privileges that this user lacks");
        return;
    }
    let outcome = std::panic::catch_unwind(|| {
        let transcript = Player::start(command("fill", &volume.join("store"), 0)).transcript();
        let failures: Vec<_> =
            transcript.iter().filter(|line| line.starts_with("failed: ")).collect();
        assert_eq!(failures.len(), 2, "{failures:?}");
        assert!(
            failures.iter().all(|line| line.contains("the disk of") && line.contains("is full")),
            "{failures:?}"
        );
        // The store is not salvaged there either.
        let store = volume.join("store");
        assert!(matches!(
            Store::salvage(&store, |_, _| Vec::new()),
            Err(OpenError::Write(WriteError::DiskFull { .. }))
        ));
        assert!(
            !store.join("records.salvaged").exists() && !store.join("records.damaged-1").exists()
        );
        assert!(mounted("remount,size=64m").unwrap().status.success());
        check(&volume.join("store"), &transcript);
    });
    assert!(Command::new("umount").arg("-l").arg(&volume).status().unwrap().success());
    outcome.unwrap();
}
