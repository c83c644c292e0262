//! The killing of processes at random moments.

use std::time::Duration;

use super::place::Running;

/// The number of SIGKILLs that must have met a live process.
pub(super) const KILLS: usize = 50;

/// A generator of random numbers (SplitMix64).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (bits ^ (bits >> 31)) % end
    }

    pub(super) fn moment(&mut self, end: Duration) -> Duration {
        Duration::from_micros(self.below(end.as_micros() as u64))
    }
}

/// The processes that are killed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Blow {
    Worker,
    Coordinator,
    Both,
    All,
}

/// The blows that meet one launch, in the order of their moments.
///
/// A job that loses three workers in one launch is to blame for it and set aside, so at most two
/// are killed before the coordinator is.
pub(super) fn blows(random: &mut Random, window: Duration) -> Vec<(Duration, Blow)> {
    let last = match random.below(7) {
        0 | 1 => Some(Blow::Coordinator),
        2 | 3 => Some(Blow::Both),
        4 | 5 => Some(Blow::All),
        _ => None,
    };
    let most = if matches!(last, Some(Blow::Both | Blow::All)) { 1 } else { 2 };
    let mut moments: Vec<Duration> =
        (0..random.below(most + 1)).map(|_| random.moment(window)).collect();
    let mut blows: Vec<(Duration, Blow)> = Vec::new();
    moments.extend(last.map(|_| random.moment(window)));
    moments.sort();
    let workers = moments.len() - usize::from(last.is_some());
    blows.extend(moments[..workers].iter().map(|moment| (*moment, Blow::Worker)));
    blows.extend(last.map(|blow| (moments[workers], blow)));
    blows
}

/// Deals a blow. Returns the number of workers that were killed before their coordinator, and of
/// all that were killed: those that are killed after it die of its death as well.
pub(super) fn strike(running: &mut Running, blow: Blow, random: &mut Random) -> (usize, usize) {
    let mut workers = running.workers();
    match blow {
        Blow::Coordinator => workers.clear(),
        Blow::Worker | Blow::Both if !workers.is_empty() => {
            workers = vec![workers[random.below(workers.len() as u64) as usize]]
        }
        Blow::Worker | Blow::Both | Blow::All => {}
    }
    let coordinator_first = random.below(2) == 0;
    if blow != Blow::Worker && coordinator_first {
        running.kill();
    }
    let met = workers.into_iter().filter(|pid| running.kill_worker(*pid)).count();
    if blow != Blow::Worker && !coordinator_first {
        running.kill();
    }
    (if blow != Blow::Worker && coordinator_first { 0 } else { met }, met)
}

/// The numbers of SIGKILLs that met a live process.
#[derive(Debug, Default)]
pub(super) struct Hits {
    pub(super) workers: usize,
    pub(super) coordinators: usize,
    /// The launches that lost the coordinator and a worker in one blow.
    pub(super) both: usize,
}

impl Hits {
    pub(super) fn suffice(&self) -> bool {
        self.workers + self.coordinators >= KILLS
            && self.workers >= 10
            && self.coordinators >= 10
            && self.both >= 5
    }
}
