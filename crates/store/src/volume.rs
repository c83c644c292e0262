//! This file asks what the file system under the store allows.

use std::io;
use std::path::Path;

use rustix::fs::{statfs, statvfs};
use rustix::process::{Resource, getrlimit};

/// The space that is never used \[bytes\]. sled extends its file by whole segments of 512 KiB and
/// keeps several open, and the manifest is written beside its predecessor. With this reserve sled
/// never meets a full disk, which it does not survive.
pub(crate) const RESERVE: u64 = 8 << 20;

/// The file systems on which neither `flock` nor the durability of a rename is reliable, by the
/// magic number that `statfs` reports (linux/magic.h, and the sources of those that are not in it).
const NETWORK: [(u32, &str); 13] = [
    (0x0000_6969, "NFS"),
    (0x0000_517B, "SMB"),
    (0xFF53_4D42, "CIFS"),
    (0xFE53_4D42, "SMB2"),
    (0x0BD0_0BD0, "Lustre"),
    (0x4750_4653, "GPFS"),
    (0x1983_0326, "BeeGFS"),
    (0x00C3_6400, "Ceph"),
    (0x5346_414F, "AFS"),
    (0x6B41_4653, "AFS"),
    (0x7375_7245, "Coda"),
    (0xAAD7_AAEA, "PanFS"),
    (0x0102_1997, "9P"),
];

/// Returns the name of the network file system of `directory`, or `None` if it is on a local one.
pub(crate) fn network_file_system(directory: &Path) -> io::Result<Option<&'static str>> {
    // The width of f_type differs between platforms. The numbers have 32 bits.
    Ok(network_name(statfs(directory)?.f_type as u32))
}

fn network_name(magic: u32) -> Option<&'static str> {
    NETWORK.iter().find(|(number, _)| *number == magic).map(|(_, name)| *name)
}

/// The space on a file system.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Space {
    /// There is enough space.
    Enough,
    /// Writing could fill the file system.
    Short {
        /// The free space \[bytes\].
        free: u64,
        /// The space that must be free before writing is risked \[bytes\].
        needed: u64,
    },
    /// The database could grow beyond the largest size that a file may have.
    Limited {
        /// The largest size that a file may have \[bytes\].
        largest: u64,
        /// The size that must be allowed before writing is risked \[bytes\].
        needed: u64,
    },
}

/// Determines whether writing `bytes` to the store in `directory` could fill its file system, or
/// make the log of its database larger than a file may be.
pub(crate) fn space(directory: &Path, log: &Path, bytes: u64) -> io::Result<Space> {
    let volume = statvfs(directory)?;
    let free = volume.f_bavail.saturating_mul(volume.f_frsize);
    // A record is written once to the log and again when its page is consolidated.
    let needed = bytes.saturating_mul(4).saturating_add(RESERVE);
    if let Some(largest) = getrlimit(Resource::Fsize).current {
        let size = std::fs::metadata(log).map_or(0, |metadata| metadata.len());
        if size.saturating_add(needed) > largest {
            return Ok(Space::Limited { largest, needed: size.saturating_add(needed) });
        }
    }
    Ok(if free < needed { Space::Short { free, needed } } else { Space::Enough })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn network_file_systems_are_told_from_local_ones() {
        assert_eq!(network_name(0x6969), Some("NFS"));
        assert_eq!(network_name(0xFF53_4D42), Some("CIFS"));
        for local in [
            0xEF53,      /* ext4 */
            0x5846_5342, /* xfs */
            0x9123_683E, /* btrfs */
            0x0102_1994, /* tmpfs */
        ] {
            assert_eq!(network_name(local), None);
        }
        assert_eq!(network_file_system(Path::new("/proc")).ok(), Some(None));
    }

    #[test]
    fn no_volume_has_room_for_everything() {
        let directory = std::env::temp_dir();
        assert!(
            matches!(space(&directory, &directory, u64::MAX), Ok(Space::Short { needed, .. }) if needed == u64::MAX)
        );
    }
}
