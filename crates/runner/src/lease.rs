//! A lease is a job in the hands of one worker.

use std::collections::BTreeMap;

/// The number of a lease. It is never used twice in a run, so the result of a lost lease is
/// recognised as stale.
pub(crate) type LeaseId = u64;

/// The number of a worker process. A replacement gets a new one.
pub(crate) type WorkerId = u32;

/// A job in the hands of a worker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lease {
    pub(crate) job: usize,
    pub(crate) worker: WorkerId,
}

/// All leases that are out.
#[derive(Debug, Default)]
pub(crate) struct Leases {
    out: BTreeMap<LeaseId, Lease>,
    granted: LeaseId,
}

impl Leases {
    /// Hands a job to a worker.
    pub(crate) fn grant(&mut self, job: usize, worker: WorkerId) -> LeaseId {
        self.granted += 1;
        self.out.insert(self.granted, Lease { job, worker });
        self.granted
    }

    /// Ends a lease that `worker` claims to have. Returns `None` if the worker never had it or has
    /// it no more.
    pub(crate) fn end(&mut self, id: LeaseId, worker: WorkerId) -> Option<Lease> {
        match self.out.get(&id) {
            Some(lease) if lease.worker == worker => self.out.remove(&id),
            _ => None,
        }
    }

    /// Returns the lease of this number while it is out.
    pub(crate) fn get(&self, id: LeaseId) -> Option<&Lease> {
        self.out.get(&id)
    }

    /// Returns the leases of a job and their workers.
    #[cfg(any(test, debug_assertions))]
    pub(crate) fn of_job(&self, job: usize) -> impl Iterator<Item = (LeaseId, WorkerId)> {
        let of_job = self.out.iter().filter(move |(_, lease)| lease.job == job);
        of_job.map(|(&id, lease)| (id, lease.worker))
    }

    /// Returns the number of leases that are out.
    #[cfg(any(test, debug_assertions))] // The invariants count them.
    pub(crate) fn len(&self) -> usize {
        self.out.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_holder_ends_a_lease_and_only_once() {
        let mut leases = Leases::default();
        let id = leases.grant(4, 1);
        assert_eq!(leases.end(id, 2), None);
        assert_eq!(leases.end(id, 1), Some(Lease { job: 4, worker: 1 }));
        assert_eq!(leases.end(id, 1), None);
        assert_ne!(leases.grant(4, 1), id);
    }
}
