//! Counts and times in words.

use std::time::Duration;

/// Returns a count with its noun.
pub(crate) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Returns a time in words, given in seconds.
pub(crate) fn duration(seconds: f64) -> String {
    if seconds < 0.9995 {
        return format!("{:.0} ms", seconds.max(0.0) * 1e3);
    }
    if seconds < 59.95 {
        return format!("{seconds:.1} s");
    }
    let whole = Duration::try_from_secs_f64(seconds.round())
        .map_or(u64::MAX, |duration| duration.as_secs());
    match whole {
        0..3600 => format!("{} min {} s", whole / 60, whole % 60),
        3600..172_800 => format!("{} h {} min", whole / 3600, whole / 60 % 60),
        _ => format!("{} days", whole / 86_400),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_read_well_at_every_size() {
        let shown = [0.0, 0.0123, 1.0, 59.9, 59.96, 61.0, 3600.0, 90_000.0, 1e7, f64::INFINITY]
            .map(duration);
        assert_eq!(
            shown[..9],
            [
                "0 ms",
                "12 ms",
                "1.0 s",
                "59.9 s",
                "1 min 0 s",
                "1 min 1 s",
                "1 h 0 min",
                "25 h 0 min",
                "115 days"
            ]
        );
    }
}
