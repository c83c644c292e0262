//! Other users, read-only media and full disks: whoever may read a store can read it, and whoever
//! may not write to it is told why.

use std::fs::{self, Permissions};
use std::os::unix::fs::{PermissionsExt, chown};
use std::path::Path;
use std::process::{Command, Output};

use store::Store;

use super::child::{Player, command};
use super::records;

/// A user and a group that are nobody's on this machine.
const STRANGER: u32 = 54_321;

/// Makes a store that everybody may read and only root may write.
fn make(directory: &Path) {
    fs::set_permissions(directory, Permissions::from_mode(0o755)).unwrap();
    let store = Store::open(&directory.join("store")).unwrap();
    store.commit(&records(0..300)).unwrap();
    store.put_study("sweep", b"mu = [0.1, 0.3]").unwrap();
}

/// Returns `command` as one that the stranger runs, or `None` if this user may not do that.
fn as_stranger(command: Command) -> Option<Command> {
    as_user(STRANGER, command)
}

/// Returns `command` as one that another user runs, or `None` if this user may not do that.
fn as_user(user: u32, command: Command) -> Option<Command> {
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: acting as another user takes privileges that this user lacks");
        return None;
    }
    let mut words = ["--reuid", "--regid"].map(|id| format!("{id}={user}")).to_vec();
    words.push("--clear-groups".to_owned());
    Some(wrapped("setpriv", &words, command))
}

fn wrapped(program: &str, words: &[String], inner: Command) -> Command {
    let mut outer = Command::new(program);
    outer.args(words).arg(inner.get_program()).args(inner.get_args());
    outer.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
    outer.stdin(std::process::Stdio::piped()).stdout(std::process::Stdio::piped());
    outer
}

/// Runs a part as another user.
fn play(part: &str, store: &Path) -> Option<Vec<String>> {
    let program = as_stranger(stranger_program(part, store))?;
    Some(Player::start(program).transcript_of_dismissed())
}

/// Returns the command that plays a part, with this binary where every user can run it.
fn stranger_program(part: &str, store: &Path) -> Command {
    let copy = store.parent().unwrap().join("program");
    if !copy.exists() {
        fs::copy(std::env::current_exe().unwrap(), &copy).unwrap();
    }
    let inner = command(part, store, 300);
    let mut there = Command::new(copy);
    there.args(inner.get_args());
    there.envs(inner.get_envs().filter_map(|(name, value)| Some((name, value?))));
    there
}

#[test]
fn another_users_store_is_read_and_not_written() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = directory.path().join("store");
    let Some(said) = play("read", &store) else { return };
    assert_eq!(said.len(), 1, "{said:?}");
    assert!(said[0].starts_with("300 records, read from a private copy"), "{said:?}");
    assert!(said[0].contains("belongs to root"), "{said:?}");
    for part in ["race", "salvage"] {
        let said = play(part, &store).unwrap().concat();
        assert!(
            said.contains(" belongs to root; this user (user 54321) may not write to it"),
            "{said}"
        );
    }

    // While its owner writes it, too.
    let mut writer = Player::start(command("write", &store, 1_000_000));
    for _ in 0..5 {
        writer.line().unwrap();
    }
    let said = play("read", &store).unwrap().concat();
    let count = said.split(' ').next().unwrap().parse::<u64>();
    assert!(count.is_ok_and(|count| count >= 300), "{said}");
    writer.kill();

    // A store that nobody else may look into is not said to be absent.
    fs::set_permissions(&store, Permissions::from_mode(0o700)).unwrap();
    let said = play("read", &store).unwrap().concat();
    assert!(said.contains("belongs to root; this user (user 54321) may not read it"), "{said}");
}

#[test]
fn nobody_else_can_hold_the_lock() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let lock = directory.path().join("store/lock");
    for before in [0o600, 0o644, 0o666] {
        fs::set_permissions(&lock, Permissions::from_mode(before)).unwrap();
        drop(Store::open(&directory.path().join("store")).unwrap());
        assert_eq!(fs::metadata(&lock).unwrap().permissions().mode() & 0o777, 0o600);
        let mut holding = Command::new("flock");
        holding.arg("-n").arg(&lock).arg("true");
        let Some(mut holding) = as_stranger(holding) else { return };
        let Output { status, stderr, .. } =
            holding.stderr(std::process::Stdio::piped()).output().unwrap();
        assert!(!status.success());
        let said = String::from_utf8_lossy(&stderr);
        assert!(said.contains("Permission denied"), "{said}");
    }
}

/// A run as root must not shut out the owner without a word.
#[test]
fn an_owner_whose_lock_belongs_to_root_is_told_so_and_can_read() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = directory.path().join("store");
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: giving files away takes privileges that this user lacks");
        return;
    }
    chown(&store, Some(STRANGER), Some(STRANGER)).unwrap();
    let said = play("race", &store).unwrap().concat();
    assert!(said.contains("lock belongs to root; this user (user 54321) may not write"), "{said}");
    let said = play("read", &store).unwrap().concat();
    assert!(said.starts_with("300 records, "), "{said}");
}

/// Root may be asked to mend a store, which stays its owner's.
#[test]
fn what_root_mends_stays_its_owners() {
    let directory = tempfile::tempdir().unwrap();
    if !rustix::process::geteuid().is_root() {
        eprintln!("skipped: giving files away takes privileges that this user lacks");
        return;
    }
    fs::set_permissions(directory.path(), Permissions::from_mode(0o755)).unwrap();
    let home = directory.path().join("home");
    fs::create_dir(&home).unwrap();
    chown(&home, Some(STRANGER), Some(STRANGER)).unwrap();
    let place = home.join("store");
    let store = Store::open(&place).unwrap();
    store.commit(&records(0..300)).unwrap();
    drop(store);
    let salvage = Store::salvage(&place, |_, _| Vec::new()).unwrap();
    assert_eq!(salvage.kept, 300);
    let others = Command::new("find")
        .args([home.as_os_str(), "!".as_ref(), "-uid".as_ref()])
        .arg(STRANGER.to_string())
        .output()
        .unwrap();
    assert_eq!(String::from_utf8_lossy(&others.stdout), "");
}

/// sled waits for ever for threads that it does not get.
#[test]
fn too_few_threads_end_in_words() {
    let directory = tempfile::tempdir().unwrap();
    make(directory.path());
    let store = directory.path().join("store");
    // The system counts the processes of a user, so this one has no others.
    let user = 100_000 + std::process::id();
    let mut refused = 0;
    for processes in [1, 2, 4, 7, 8, 12] {
        let limits = [format!("--nproc={processes}")];
        let mut limited = wrapped("prlimit", &limits, stranger_program("read", &store));
        limited.env("RUST_TEST_THREADS", "1");
        let Some(limited) = as_user(user, limited) else { return };
        let said = Player::start(limited).transcript_of_dismissed().concat();
        eprintln!("{processes} processes: {said}");
        if said.contains("the system refuses them") {
            refused += 1;
        } else {
            assert!(said.starts_with("300 records, "), "{processes}: {said}");
        }
    }
    assert!((1..6).contains(&refused), "{refused} were refused");
}

/// Mounts `place` as `options` say while `act` runs, or says that this user may not.
fn mounted(place: &Path, options: &[&str], act: impl FnOnce() + std::panic::UnwindSafe) {
    let done = Command::new("mount").args(options).arg(place).output();
    if !done.is_ok_and(|run| run.status.success()) {
        eprintln!("skipped: mounting takes privileges that this user lacks");
        return;
    }
    let outcome = std::panic::catch_unwind(act);
    assert!(Command::new("umount").arg("-l").arg(place).status().unwrap().success());
    outcome.unwrap();
}

#[test]
fn a_read_only_medium_is_read_and_a_write_says_why_not() {
    let directory = tempfile::tempdir().unwrap();
    let place = directory.path().to_owned();
    mounted(&place.clone(), &["-t", "tmpfs", "-o", "size=24m", "tmpfs"], move || {
        make(&place);
        let remount = Command::new("mount").args(["-o", "remount,ro"]).arg(&place).status();
        assert!(remount.unwrap().success());
        let store = place.join("store");
        let reader = Store::read(&store).unwrap();
        assert_eq!(reader.keys().unwrap().len(), 300);
        assert!(reader.verify(|_, _| Vec::new()).unwrap().is_sound());
        let said = reader.origin().to_string();
        assert!(said.contains("private copy") && said.contains("may not write"), "{said}");
        for error in [
            Store::open(&store).err().unwrap(),
            Store::salvage(&store, |_, _| Vec::new()).err().unwrap(),
        ] {
            let said = error.to_string();
            assert!(said.contains("mounted read-only"), "{said}");
        }
    });
}

#[test]
fn a_full_disk_is_read() {
    let directory = tempfile::tempdir().unwrap();
    let place = directory.path().to_owned();
    mounted(&place.clone(), &["-t", "tmpfs", "-o", "size=12m", "tmpfs"], move || {
        make(&place);
        let mut rest = vec![0; 1 << 20];
        let mut filler = fs::File::create(place.join("filler")).unwrap();
        while std::io::Write::write_all(&mut filler, &rest).is_ok() {}
        rest.truncate(1);
        while std::io::Write::write_all(&mut filler, &rest).is_ok() {}
        assert_eq!(Store::read(&place.join("store")).unwrap().keys().unwrap().len(), 300);
        let error = Store::open(&place.join("store")).err().unwrap().to_string();
        assert!(error.contains("is full"), "{error}");
    });
}
