//! Says which effects the jobs of a study call for, and what leaving the others out saves.
//!
//! The file below groups jobs that call for the same effects and names the groups. It knows the
//! effects of a single job, which stand in another file, and no kind of study.

mod groups;
mod job;

pub use groups::{EffectGroup, Overview, OverviewDraft, overview};
pub use job::{
    EffectLine, JobEffects, JobMethod, Prediction, SolverChoice, effects, effects_of_job,
    missing_surface, variants,
};
