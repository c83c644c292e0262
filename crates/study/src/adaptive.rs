//! Studies that choose points as they go. Meshes are refined until a result holds still or is
//! [accurate](crate::accuracy), or one axis is halved.
//!
//! ```toml
//! [refine]                    # doubles numerics.mesh, at every point of the axes, until
//! on = "peak_pressure"        # this result
//! until = "0.1%"              # changes by no more than this
//! at_most = 512               # or the mesh would be finer than this; 1024 if left out, and no
//!                             # less than twice numerics.mesh
//! ```
//! ```toml
//! [bisect]                    # halves the intervals of an axis (equal ratios, if logarithmic)
//! axis = "friction.mu"        # on which
//! on = "stick_area > 0"       # this, as in `query --where`, begins or ceases to hold
//! to = "1%"                   # until they are no longer than this part of their upper end; of the
//!                             # whole axis, where they begin at 0 or below
//! ```
//!
//! The choice follows from the results alone. A study that was killed therefore goes on where it
//! was, and its points are the same on any number of workers.

mod axis;
mod bisect;
mod refine;
mod rule;
mod table;

use toml::de::DeTable;

use crate::axis::Group;
use crate::columns::Column;
use crate::error::Mistake;
use crate::key::Key;
use crate::sheet::Given;

use bisect::read_bisect;
use refine::read_refine;

pub use rule::Adaptive;
pub use table::OF_ONE_JOB;

/// Reads `[refine]` or `[bisect]` at the `root` of a study, which exclude each other and
/// `accuracy`. `base`, `groups` and `columns` are the study's.
pub(crate) fn read(
    root: &DeTable<'_>,
    base: &[(Key, Given)],
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let before = mistakes.len();
    let [accuracy, refine, bisect] = ["accuracy", "refine", "bisect"].map(|name| root.get(name));
    if let (Some(accuracy), Some(other)) = (accuracy, refine.or(bisect)) {
        let mistake = Mistake::new(
            other.span(),
            "a study chooses its points in one way only",
            "needs one of the two",
        );
        mistakes.push(mistake.context(accuracy.span(), "the other is here"));
    }
    let read = match (refine, bisect) {
        (Some(refine), Some(bisect)) => {
            let mistake = Mistake::new(
                bisect.span(),
                "a study cannot both refine and bisect",
                "needs one of the two",
            );
            mistakes.push(mistake.context(refine.span(), "the other is here"));
            None
        }
        (Some(node), None) => read_refine(node, base, groups, columns, mistakes),
        (None, Some(node)) => read_bisect(node, groups, mistakes),
        (None, None) => None,
    };
    read.filter(|_| mistakes.len() == before)
}
