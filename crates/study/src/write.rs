//! Writes a job as the text of a study that asks for it.

use crate::job::Job;
use crate::key::Key;
use crate::quantity::Quantity;
use crate::settings::{length, setting, settings};
use crate::sheet::Setting;

impl Job {
    /// Returns the job as a study file asks for it, in SI units. If the text is read back, the job
    /// is the study's only point. A study of cost needs `[sweep]` with at least three meshes beside
    /// it, and the job is one of its points if its own mesh is among them.
    pub fn to_toml(&self) -> String {
        let settings = settings(self);
        let mut text = self.kind().to_toml(self);
        // The increments of a distance divide it.
        let is_distance = |step| setting(self, Key::Distance(step)).is_some();
        let goes_without_saying = |key: Key, setting: &Setting| match key {
            Key::Increments(step) => *setting == Setting::Count(1) && !is_distance(step),
            Key::Cycles | Key::WearRepeat => *setting == Setting::Count(1),
            Key::WearUpdate => *setting == Setting::Flag(false),
            Key::SpinCenter(_) | Key::LateralVelocity | Key::YawRate | Key::RollRate => {
                *setting == Setting::Number(0.0)
            }
            Key::Direction(_) => *setting == Setting::Word("forward".to_owned()),
            Key::Steady(_) => *setting == Setting::Flag(false),
            Key::Dq(step) => is_distance(step),
            // One depth is written as a number.
            Key::InteriorDepths => matches!(setting, Setting::Lengths(depths) if depths.len() == 1),
            _ => false,
        };
        let written =
            || settings.iter().filter(|(key, setting)| !goes_without_saying(*key, setting));
        for (key, setting) in written().filter(|(key, _)| key.index().is_none()) {
            if !matches!(key.quantity(), Quantity::List(_)) {
                text += &format!("{} = {setting}\n", key.path());
                continue;
            }
            let entry = |index| {
                let keys = written()
                    .filter(|(of, _)| of.list() == Some(*key) && of.index() == Some(index));
                let keys: Vec<String> =
                    keys.map(|(key, setting)| format!("{} = {setting}", key.name())).collect();
                if keys.is_empty() { "{}".to_owned() } else { format!("{{ {} }}", keys.join(", ")) }
            };
            let entries: Vec<String> = (0..length(self, *key)).map(entry).collect();
            if !entries.is_empty() {
                text += &format!("{} = [{}]\n", key.path(), entries.join(", "));
            }
        }
        text
    }
}
