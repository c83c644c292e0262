//! The stresses below the surface that a study asks for, in its table `[interior]`.

use contact::model::InteriorQuestion;

use super::Assembler;
use crate::error::Mistake;
use crate::key::{Key, Table};
use crate::sheet::Setting;

/// The keys of the table.
const KEYS: [Key; 4] =
    [Key::InteriorMaximum, Key::InteriorDepth, Key::InteriorDepths, Key::InteriorPoints];

impl Assembler<'_> {
    /// Assembles what is asked of the stresses below the surface; `None` if nothing is. A table
    /// that was begun and holds nothing has lost something, which the scene finds.
    pub(super) fn interior(&mut self) -> Option<InteriorQuestion> {
        let is_begun = Table::find("interior").is_some_and(|table| self.places.has(&table));
        let given = KEYS.map(|key| self.sheet.get(key));
        if !is_begun && given.iter().all(Option::is_none) {
            return None;
        }
        if let [_, Some(depth), Some(depths), _] = given {
            // The one that stands later in the file is the one too many.
            let (first, second) = if depth.span.start <= depths.span.start {
                (depth, depths)
            } else {
                (depths, depth)
            };
            let mistake = Mistake::new(
                second.span.clone(),
                "`interior.depth` and `interior.depths` are both given",
                "give one of the two: `depths` is a list, `depth` may be an axis",
            );
            let mistake = mistake.context(first.span.clone(), "the other is here");
            self.mistakes.push(mistake);
        }
        let question = InteriorQuestion {
            maximum: self.sheet.flag(Key::InteriorMaximum).unwrap_or(false),
            depths: match given[2].map(|depths| &depths.setting) {
                Some(Setting::Lengths(depths)) => depths.clone(),
                _ => self.sheet.number(Key::InteriorDepth).into_iter().collect(),
            },
            points: match given[3].map(|points| &points.setting) {
                Some(Setting::Places(points)) => points.clone(),
                _ => Vec::new(),
            },
        };
        // Who says that nothing is sought has asked for nothing.
        let is_nothing = question == InteriorQuestion::default() && given[0].is_some();
        (!is_nothing).then_some(question)
    }
}
