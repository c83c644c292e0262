//! Records that are too large for a store.

use contact::model::Status;

/// The size of a record that is larger than a store keeps \[bytes\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordSize {
    /// The size of the record.
    pub bytes: usize,
    /// The most that a record may have.
    pub limit: usize,
}

impl RecordSize {
    /// Returns the failure of a job whose record would hold `content`, on so many elements.
    pub(super) fn failure(self, content: &str, elements: usize) -> Status {
        let RecordSize { bytes, limit } = self;
        let most = elements * limit / bytes.max(1);
        Status::Failed {
            reason: format!(
                "{content}: a record of {bytes} bytes, where the store keeps at most {limit}; \
                 needs a mesh of at most about {most} elements"
            ),
        }
    }
}
