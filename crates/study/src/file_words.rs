//! The words that say what was read from the files of a job.

use contact::model::{Domain, Shape};
use contact::punch::{Profile, Surface, domain};

use crate::job::{Case, Job};
use crate::study::Study;
use crate::units::lengths;

impl Study {
    /// Says what was read from each file that a job of the study names: pixels, their size, the
    /// range of heights and which line is which y, or the points of a profile; and whether the
    /// `elements` along x and y are smaller than pixels.
    pub fn file_words(&self, job: &Job, elements: [usize; 2]) -> Vec<String> {
        let Some(case) = job.case() else { return Vec::new() };
        match &case.scene.punch.shape {
            Shape::HeightMap { surface, width_x, width_y } => {
                let Some(map) = self.surfaces().get(surface) else { return Vec::new() };
                let pixel = [width_x / map.columns() as f64, width_y / map.rows() as f64];
                let note = self.files.notes.get(surface).map_or("", |note| &note.words);
                let named = self.named("height map", surface);
                let mut words = vec![format!("{named}: {}; {note}", map_words(map, pixel))];
                words.extend(self.finer_words(case, pixel, elements));
                words
            }
            Shape::WheelOnRail(wheel) => [&wheel.wheel, &wheel.rail]
                .into_iter()
                .filter_map(|name| {
                    let profile = self.surfaces().profile(name)?;
                    let note = self.files.notes.get(name).map_or("", |note| &note.words);
                    let named = self.named("profile", name);
                    Some(format!("{named}: {}; {note}", profile_words(profile)))
                })
                .collect(),
            _ => Vec::new(),
        }
        .into_iter()
        .map(|line| line.trim_end_matches("; ").to_owned())
        .collect()
    }

    /// Returns the noun with the name of the file, if it came from one.
    fn named(&self, noun: &str, name: &str) -> String {
        match self.files.notes.get(name).map(|note| note.file.as_str()) {
            None | Some("") => noun.to_owned(),
            // A stored profile goes by its hash.
            Some(file) if file == name => noun.to_owned(),
            Some(file) => format!("{noun} {}", file.escape_debug()),
        }
    }

    /// Says that elements are smaller than pixels, if they are.
    fn finer_words(&self, case: &Case, pixel: [f64; 2], elements: [usize; 2]) -> Option<String> {
        let Domain { width_x, width_y, .. } = domain(&case.scene, self.surfaces()).ok()?;
        let element = [width_x / elements[0] as f64, width_y / elements[1] as f64];
        let is_finer = (0..2).any(|axis| element[axis] < pixel[axis] * (1.0 - 1e-9));
        is_finer.then(|| {
            format!(
                "elements of {} are finer than the map: what is between the pixels is interpolated",
                lengths(&element).join(" × ")
            )
        })
    }
}

fn map_words(map: &Surface, pixel: [f64; 2]) -> String {
    let is_present = |pixel: usize| map.absent().get(pixel).is_none_or(|absent| !absent);
    let heights = || map.heights().iter().enumerate().filter(|(pixel, _)| is_present(*pixel));
    let lowest = heights().map(|(_, height)| *height).fold(f64::INFINITY, f64::min);
    let highest = heights().map(|(_, height)| *height).fold(f64::NEG_INFINITY, f64::max);
    format!(
        "{} × {} pixels, {} each, heights from {}",
        map.columns(),
        map.rows(),
        lengths(&pixel).join(" × "),
        lengths(&[lowest, highest]).join(" to ")
    )
}

fn profile_words(profile: &Profile) -> String {
    let [y, z] = profile.extents();
    format!(
        "{}, {} points, y from {}, z from {}",
        profile.kind().noun(),
        profile.curve().points().len(),
        lengths(&y).join(" to "),
        lengths(&z).join(" to ")
    )
}
