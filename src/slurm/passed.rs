//! Options that are passed on to `sbatch` as they are.

/// An option that may not be passed on.
struct Reserved {
    name: &'static str,
    /// The short form.
    letter: Option<char>,
    /// The words that say what would be right.
    advice: &'static str,
}

const fn reserved(name: &'static str, letter: char, advice: &'static str) -> Reserved {
    Reserved { name, letter: if letter == ' ' { None } else { Some(letter) }, advice }
}

/// The options that `submit` sets itself, or that would make it do something else.
const RESERVED: [Reserved; 30] = [
    reserved("array", 'a', "the array follows from --shards, its limit from --nodes"),
    reserved("dependency", 'd', "the merge depends on the arrays, and they on nothing"),
    reserved("wrap", ' ', "what runs is a shard of the study"),
    reserved("time", 't', "give --time to `submit` itself, before `--`"),
    reserved("mem", ' ', "give --mem to `submit` itself, before `--`"),
    reserved("partition", 'p', "give --partition to `submit` itself, before `--`"),
    reserved("account", 'A', "give --account to `submit` itself, before `--`"),
    reserved("cpus-per-task", 'c', "give --cpus-per-task to `submit` itself, before `--`"),
    reserved("nodes", 'N', "a shard runs on one node; --nodes of `submit` limits how many run"),
    reserved("ntasks", 'n', "a shard is one task with threads; give it --cpus-per-task"),
    reserved("ntasks-per-node", ' ', "a shard is one task with threads; give it --cpus-per-task"),
    reserved("ntasks-per-core", ' ', "a shard is one task with threads; give it --cpus-per-task"),
    reserved("ntasks-per-socket", ' ', "a shard is one task with threads; give it --cpus-per-task"),
    reserved("job-name", 'J', "the jobs are called after the study"),
    reserved("output", 'o', "what a shard says is in the log directory"),
    reserved("error", 'e', "what a shard says is in the log directory"),
    reserved("open-mode", ' ', "a shard that starts again continues its log"),
    reserved("requeue", ' ', "every shard may be queued again"),
    reserved("no-requeue", ' ', "a shard that is not queued again stays unfinished"),
    reserved("signal", ' ', "the signal tells a shard to stop in time"),
    reserved("kill-on-invalid-dep", ' ', "it is set for the merge"),
    reserved("chdir", 'D', "give --directory to `submit` itself, before `--`"),
    reserved("parsable", ' ', "it is set already"),
    reserved("test-only", ' ', "--dry-run of `submit` shows what would be submitted"),
    reserved("wait", 'W', "`submit` does not wait; `squeue` tells how far the jobs are"),
    reserved("clusters", 'M', "`submit` asks the cluster on which it runs"),
    reserved("cluster", ' ', "`submit` asks the cluster on which it runs"),
    reserved("help", 'h', "`sbatch --help` prints it"),
    reserved("usage", 'u', "`sbatch --usage` prints it"),
    reserved("version", 'V', "`sbatch --version` prints it"),
];

/// The short options of `sbatch` that have a value, which follows in the same word.
const WITH_VALUE: &str = "ABCDFGJLMNSabcdeimnopqtwx";

/// Checks an option that is to be passed on to `sbatch`.
///
/// # Errors
/// Returns in words why it cannot be: it is set already, or it is no option.
pub(crate) fn check_passed(word: &str) -> Result<(), String> {
    let shown = wording::excerpt(word, 60);
    // sbatch does not know the quotes that these would need.
    if wording::one_line(word) != word {
        return Err(format!("`{shown}` has a character that is not shown; it must have none"));
    }
    let clash = if let Some(long) = word.strip_prefix("--") {
        let name = long.split_once('=').map_or(long, |(name, _)| name);
        if name.is_empty() {
            return Err(format!("`{shown}` is no option of sbatch"));
        }
        // sbatch takes a name for what it begins.
        let exact = RESERVED.iter().find(|option| option.name == name);
        exact.or_else(|| RESERVED.iter().find(|option| option.name.starts_with(name)))
    } else if let Some((letter, value)) = word.strip_prefix('-').and_then(|short| {
        let mut letters = short.chars();
        letters.next().map(|letter| (letter, letters.as_str()))
    }) {
        let clash = RESERVED.iter().find(|option| option.letter == Some(letter));
        if clash.is_none() {
            check_alone(letter, value, &shown)?;
        }
        clash
    } else {
        return Err(format!(
            "`{shown}` would be taken for a script's name; write an option and its value as one \
             word, such as --constraint=haswell"
        ));
    };
    match clash {
        Some(Reserved { name, advice, .. }) => Err(format!(
            "`{shown}` cannot be passed to sbatch, for `submit` decides on --{name}: {advice}"
        )),
        None => Ok(()),
    }
}

/// Checks that a short option is one option: a letter with its value, or a letter that has none.
/// `sbatch` would take what follows another letter for further options, and the next word for a
/// value that is missing.
fn check_alone(letter: char, value: &str, shown: &str) -> Result<(), String> {
    match (WITH_VALUE.contains(letter), value.is_empty()) {
        (true, true) => {
            Err(format!("`{shown}` lacks its value, which must follow in the same word"))
        }
        (false, false) => Err(format!(
            "`{shown}` would be taken for several options; write -{letter} alone, and others as \
             words of their own"
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_are_set_already_are_found_in_every_spelling() {
        for word in [
            "--array=1-3",
            "--arr=1",
            "-a1-3",
            "--dependency=afterok:1",
            "--dep=x",
            "-d",
            "--wrap=ls",
            "--wr",
            "--output=x",
            "-ox",
            "--time=5",
            "-t5",
            "--nodes=2",
            "-N2",
            "--no=2",
            "--mem=1G",
            "--signal=B:TERM@9",
            "-W",
            "--chdir=/",
            "--job=x",
        ] {
            let said = check_passed(word).unwrap_err();
            assert!(said.contains("`submit` decides on --"), "{word}: {said}");
        }
        for word in ["script.sh", "", "--", "-", "--comment=a\nb"] {
            assert!(!check_passed(word).unwrap_err().contains("decides"), "{word}");
        }
    }

    #[test]
    fn a_short_option_is_one_letter_with_its_value() {
        for word in ["-HW", "-Ha1-3", "-kJx", "-QN2"] {
            let said = check_passed(word).unwrap_err();
            assert!(said.contains("would be taken for several options"), "{word}: {said}");
        }
        for word in ["-C", "-q"] {
            assert!(check_passed(word).unwrap_err().contains("lacks its value"), "{word}");
        }
    }

    #[test]
    fn other_options_pass() {
        for word in [
            "--constraint=haswell",
            "-Chaswell",
            "-H",
            "-qlong",
            "--exclusive",
            "--qos=long",
            "--time-min=5",
            "--mem-per-cpu=2G",
            "--gres=gpu:1",
            "--mail-type=END",
            "--exclude=n1",
            "--reservation=x",
            "--export=ALL,A=b c",
            "--nodelist=n2",
            "--nice",
        ] {
            assert_eq!(check_passed(word), Ok(()), "{word}");
        }
    }
}
