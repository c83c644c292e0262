//! The limits of a controller, as `scontrol show config` says them.

/// The limits that a controller sets to arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ControllerConfig {
    /// The number of indices that an array may have, from 0 on; 0 if there are no arrays.
    pub(crate) array_size: u32,
    /// The number of jobs that the controller keeps at a time.
    pub(crate) jobs: u32,
}

impl Default for ControllerConfig {
    /// Returns the limits of a controller whose configuration sets none.
    fn default() -> Self {
        Self { array_size: 1001, jobs: 10_000 }
    }
}

impl ControllerConfig {
    /// Reads what `scontrol show config` prints. A limit that it does not name is the default one.
    pub(crate) fn parse(text: &str) -> Self {
        let mut config = Self::default();
        let mut array_tasks = None;
        for (name, value) in text.lines().filter_map(|line| line.split_once('=')) {
            let value = value.trim();
            match name.trim() {
                "MaxArraySize" => config.array_size = value.parse().unwrap_or(config.array_size),
                "MaxJobCount" => config.jobs = value.parse().unwrap_or(config.jobs),
                "SchedulerParameters" => {
                    array_tasks = value
                        .split(',')
                        .find_map(|word| word.trim().strip_prefix("max_array_tasks="))
                        .and_then(|number| number.parse().ok());
                }
                _ => {}
            }
        }
        if let Some(tasks) = array_tasks {
            config.array_size = config.array_size.min(tasks);
        }
        config
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_where_they_are_named() {
        let text = "Configuration data as of 2026-01-01T00:00:00\n\
                    MaxArraySize            = 8\nMaxJobCount             = 500\n\
                    SchedulerParameters     = bf_interval=1,max_array_tasks=5\n\
                    SwitchParameters        = (null)\n\nSlurmctld(primary) at n is UP\n";
        assert_eq!(ControllerConfig::parse(text), ControllerConfig { array_size: 5, jobs: 500 });
        assert_eq!(ControllerConfig::parse("MaxArraySize = 0\n").array_size, 0);
        assert_eq!(ControllerConfig::parse("no such thing"), ControllerConfig::default());
    }
}
