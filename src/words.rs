//! Counts and times in words.

use std::time::{Duration, UNIX_EPOCH};

/// Returns a count with its noun.
pub(crate) fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

/// Says in parentheses how many points are excluded; nothing if there are none.
pub(crate) fn excluded_words(n: usize) -> String {
    if n == 0 { String::new() } else { format!(" ({n} more excluded)") }
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

/// Returns a time of the calendar, given in seconds since 1970-01-01 UTC.
pub(crate) fn time_words(seconds: u64) -> String {
    // The last second of the year 9999 is the last that can be written.
    let time = UNIX_EPOCH.checked_add(Duration::from_secs(seconds.min(253_402_300_799)));
    time.map_or(String::new(), |time| humantime::format_rfc3339_seconds(time).to_string())
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
