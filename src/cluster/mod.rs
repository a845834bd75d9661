//! Writes scripts that submit the shards of a sweep to a cluster's own engine, and merge them afterwards. The
//! scripts are text; nothing is submitted here.

pub(crate) mod hyperqueue;
pub(crate) mod kubernetes;
pub(crate) mod slurm;
#[cfg(test)]
mod tests;
mod word;

use perirobot_march::Result;
use perirobot_march::error::Issue;
pub(crate) use word::VisibleWord;

/// How long a stopped sweep has to finish its batch and write it down, in seconds.
const NOTICE_S: u32 = 120;

/// A sweep in shards, as every engine needs to know it. Paths are those the tasks see.
#[derive(Clone, Debug)]
pub(crate) struct Job {
    /// The name of the job: a DNS label of at most [`LONGEST_NAME`] letters, which every engine takes.
    pub(crate) name: VisibleWord,
    /// The program `perirobot`.
    pub(crate) program: VisibleWord,
    /// The study file.
    pub(crate) study: VisibleWord,
    /// The folder for results, seen by all tasks.
    pub(crate) out: VisibleWord,
    /// How many shards, 2 at least.
    pub(crate) shards: u32,
    /// Further arguments of the sweep; the command line has checked them.
    pub(crate) sweep_arguments: Vec<VisibleWord>,
    /// Further arguments of the merge, checked likewise.
    pub(crate) merge_arguments: Vec<VisibleWord>,
    /// Processors of each task; the sweep takes as many threads unless it is told otherwise.
    pub(crate) cpus: u16,
    /// Memory of each task in MiB; the engine's own default without.
    pub(crate) memory_mib: Option<u64>,
    /// How often a shard that fails is tried again; being stopped after finishing rows is no failure.
    pub(crate) tries: u32,
}

/// Engines append to the name, and the whole must stay below 64 letters.
pub(crate) const LONGEST_NAME: usize = 40;

impl Job {
    /// Refuses a job that no engine could run, naming the argument.
    pub(crate) fn check(self) -> Result<Job> {
        let refuse = |what: String| Err(Issue::says(what).into());
        if self.shards < 2 {
            let shards = self.shards;
            return refuse(format!("--shards {shards}: must be at least 2; one alone is `perirobot sweep`"));
        }
        for (key, word) in [("STUDY", &self.study), ("--out", &self.out), ("--program", &self.program)] {
            let text = word.text();
            if text.starts_with('-') {
                return refuse(format!("{key} {text}: reads like an option; write ./{text}"));
            }
        }
        let name = self.name.text();
        if name != label(name) {
            return refuse(format!(
                "--name {name}: must be at most {LONGEST_NAME} lower-case letters, digits and single '-' between them, \
                 as in {}",
                label(name)
            ));
        }
        let takes = |argument: &VisibleWord, option: &str| {
            argument.text().strip_prefix(option).is_some_and(|rest| rest.is_empty() || rest.starts_with('='))
        };
        for (option, why) in [
            ("--shard", "the script gives each task its own"),
            ("--out", "give it before `--`, where it holds for the merge, too"),
            ("--table", "give it before `--`: it is the merge that writes the tables"),
            ("--restart", "each task that is tried again would begin anew; remove the folder instead"),
        ] {
            if self.sweep_arguments.iter().any(|argument| takes(argument, option)) {
                return refuse(format!("{option} after `--`: {why}"));
            }
        }
        Ok(self)
    }

    /// The command of a task, whose number comes from the engine's environment. How many shards there are is
    /// written out: an engine counts only the tasks that it was last given.
    pub(crate) fn sweep(&self) -> Vec<VisibleWord> {
        let shard = format!("auto/{}", self.shards);
        let fixed =
            [self.program.text(), "sweep", self.study.text(), "--out", self.out.text(), "--shard", &shard];
        let mut command: Vec<VisibleWord> = fixed.into_iter().map(VisibleWord::from_known).collect();
        if !self.sweep_arguments.iter().any(|argument| argument.text().starts_with("--threads")) {
            command.extend([
                VisibleWord::from_known("--threads"),
                VisibleWord::from_known(&self.cpus.to_string()),
            ]);
        }
        command.extend(self.sweep_arguments.iter().cloned());
        command
    }

    /// The command that merges what the tasks left, or names what is missing.
    pub(crate) fn merge(&self) -> Vec<VisibleWord> {
        let fixed = [self.program.text(), "merge", self.out.text()].map(VisibleWord::from_known);
        fixed.into_iter().chain(self.merge_arguments.iter().cloned()).collect()
    }
}

/// A name that every engine takes, from any text: `Exp 3.v2` becomes `exp-3-v2`.
pub(crate) fn label(text: &str) -> String {
    let kept = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { ' ' };
    let words: String = text.chars().map(kept).collect();
    let joined = words.split_whitespace().collect::<Vec<_>>().join("-");
    let short = &joined[..joined.len().min(LONGEST_NAME)];
    let name = short.trim_end_matches('-');
    if name.is_empty() { "sweep".into() } else { name.into() }
}

/// A command as a shell reads it.
fn shell(command: &[VisibleWord]) -> String {
    command.iter().map(VisibleWord::shell).collect::<Vec<_>>().join(" ")
}

/// What both shell scripts begin with: the job in variables and functions. The two commands replace the shell
/// that runs them, so that a signal sent to one in the background reaches the program.
fn shell_head(job: &Job) -> String {
    let Job { shards, tries, .. } = job;
    format!(
        "set -eu\n\
         out={}\n\
         shards={shards}\n\
         tries={tries} # how often a shard that fails is tried again\n\
         sweep() {{\n    exec {}\n}}\n\
         merge() {{\n    exec {}\n}}\n",
        job.out.shell(),
        shell(&job.sweep()),
        shell(&job.merge())
    )
}
