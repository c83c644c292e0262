//! Writers are killed with SIGKILL at any moment.

use std::collections::BTreeMap;
use std::time::Duration;

use store::Store;

use super::child::{Player, command, removed, size};
use super::{key, record};

/// The expectation follows what is removed and added, and knows which jobs may be either way.
#[test]
fn what_was_acknowledged_survives_every_kill() {
    let directory = tempfile::tempdir().unwrap();
    let mut expected: BTreeMap<u64, bool> = BTreeMap::new(); // This maps a job to its presence.
    let mut random = 1u64;
    for round in 0..40 {
        let first = 1_000_000 * round;
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        // The number is 0 … 31; with none at all the writer is killed while it opens the store.
        let acknowledgements = random >> 59;
        let delay = Duration::from_micros((random >> 40) % 4000);
        let mut writer = Player::start(command("write", directory.path(), first));
        let mut seen = Vec::new();
        for _ in 0..acknowledgements {
            seen.push(writer.line().expect("the writer goes on until it is killed"));
        }
        std::thread::sleep(delay);
        writer.kill();
        while let Some(line) = writer.line() {
            seen.push(line);
        }

        let mut next = (0, "committed"); // This is what it was doing when it was killed.
        for line in &seen {
            let (what, group) = line.split_once(' ').unwrap();
            let group: u64 = group.parse().unwrap();
            assert_eq!((group, what), next);
            let start = first + 100 * group;
            if what == "committed" {
                expected.extend((start..start + size(group)).map(|i| (i, true)));
                next = if group % 3 == 2 { (group, "removed") } else { (group + 1, "committed") };
            } else {
                expected.extend((start - 100..start - 100 + removed(group)).map(|i| (i, false)));
                next = (group + 1, "committed");
            }
        }
        let (group, what) = next;
        let start = first + 100 * group;
        let undecided = if what == "committed" {
            start..start + size(group)
        } else {
            start - 100..start - 100 + removed(group)
        };

        let store = Store::open(directory.path()).unwrap();
        for i in undecided {
            let found = store.get(&key(i)).unwrap();
            assert!(found.is_none() || found == Some(record(i)));
            expected.insert(i, found.is_some());
        }
        for (i, present) in &expected {
            assert_eq!(
                store.get(&key(*i)).unwrap(),
                present.then(|| record(*i)),
                "job {i} after round {round}"
            );
        }
        assert_eq!(store.len(), expected.values().filter(|present| **present).count());
    }
    assert!(expected.len() > 1000, "the writers were killed too early to show anything");
}
