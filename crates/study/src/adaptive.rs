//! Studies that choose points as they go. Meshes are refined until a result holds still or is
//! [accurate](crate::accuracy), or points are added along axes: where a condition changes, where a
//! result takes a value, or where a curve or a map bends.
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
//! ```toml
//! [find]                      # finds every value
//! axis = "friction.mu"        # of an axis
//! column = "stick_fraction"   # at which this result
//! value = 0.5                 # crosses this: a number, or a text with a unit; between which of
//! to = "0.1%"                 # the given values it does tells where to look, until the bracket
//!                             # is no longer than this part of its upper end; of the whole axis,
//!                             # where the given values begin at 0 or below
//! ```
//! ```toml
//! [fill]                      # adds points
//! axis = "friction.mu"        # along an axis, or two for a map
//! column = "stick_fraction"   # where this result bends most
//! to = "1%"                   # until straight lines between the points are off by no more than
//!                             # this part of the column's range, by estimate, or the points are
//!                             # no further apart than this part of the axis
//! at_most = 40                # or so many points have been added, at each combination of the
//!                             # other axes; 1000 if left out
//! ```
//!
//! ```toml
//! [branch]                    # narrows the bracket of a uniqueness set
//! to = "1%"                   # until it is no longer than this part of its upper end
//! at_most = 20000             # or the jobs of a point have looked at so many cones
//! ```
//!
//! The choice follows from the results alone. A study that was killed therefore goes on where it
//! was, and its points are the same on any number of workers.

mod axis;
mod bisect;
mod branch;
mod figure;
mod fill;
mod find;
mod refine;
mod rule;
mod table;

use toml::de::DeTable;

use crate::axis::Group;
use crate::columns::Column;
use crate::error::Mistake;
use crate::key::Key;
use crate::kind::Kind;
use crate::read::Node;
use crate::sheet::Given;
use crate::table_key::KeyTable;

use bisect::{BISECT, read_bisect};
use branch::{BRANCH, read_branch};
use fill::{FILL, read_fill};
use find::{FIND, read_find};
use refine::{REFINE, read_refine};

pub(crate) use branch::check_branched;
pub use rule::{Adaptive, Filling, RootSearch};
pub use table::OF_ONE_JOB;

/// The rules of which a study has at most one. `accuracy` is read by itself.
pub(crate) const RULES: [&str; 6] = ["accuracy", "refine", "bisect", "find", "fill", "branch"];

/// The tables of the rules, but for that of `accuracy`.
pub(crate) const TABLES: [&KeyTable; 5] = [&REFINE, &BISECT, &FIND, &FILL, &BRANCH];

/// Reads the rule at the `root` of a study, which excludes any other. `kind`, `base`, `groups` and
/// `columns` are the study's.
pub(crate) fn read(
    root: &DeTable<'_>,
    kind: Kind,
    base: &[(Key, Given)],
    groups: &[Group],
    columns: &[Column],
    mistakes: &mut Vec<Mistake>,
) -> Option<Adaptive> {
    let before = mistakes.len();
    let given: Vec<(&str, &Node<'_>)> =
        RULES.iter().filter_map(|name| Some((*name, root.get(*name)?))).collect();
    if let [(first, place), (second, node), ..] = given[..] {
        let message = format!("a study chooses its points in one way, and not by `{second}` too");
        let mistake = Mistake::new(node.span(), message, "needs one of the two");
        mistakes.push(mistake.context(place.span(), format!("`{first}` is here")));
        return None;
    }
    let read = match given[..] {
        [("refine", node)] => read_refine(node, base, groups, columns, mistakes),
        [("bisect", node)] => read_bisect(node, groups, mistakes),
        [("find", node)] => read_find(node, groups, columns, mistakes),
        [("fill", node)] => read_fill(node, groups, columns, mistakes),
        [("branch", node)] => read_branch(node, kind, base, groups, mistakes),
        _ => None,
    };
    read.filter(|_| mistakes.len() == before)
}
