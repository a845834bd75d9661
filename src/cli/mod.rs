//! The subcommands, with their messages and exit codes.

// `--help` prints the comments on arguments; their brackets are TOML.
#![allow(rustdoc::broken_intra_doc_links)]

/// Writes a line on standard error.
macro_rules! say {
    ($($text:tt)*) => { crate::cli::terminal::say(&format!($($text)*)) };
}

mod approach;
mod backend;
mod bench;
mod check;
mod choice;
mod choose;
mod cluster;
mod compare;
mod completions;
mod contents;
mod devices;
mod export;
mod field;
#[cfg(feature = "report")]
mod figures;
mod flags;
mod init;
mod judge;
#[cfg(not(feature = "report"))]
mod left_out;
mod log;
mod merge;
mod onlooker;
mod outcome;
mod packages;
#[cfg(feature = "report")]
mod plan;
mod progress;
mod quantity;
mod render;
#[cfg(feature = "report")]
mod report;
mod schema;
mod score;
mod score_map;
mod sensors;
mod shard;
mod sight;
mod stop;
mod study;
mod summary;
mod sweep;
mod swept;
mod terminal;
mod verify_backends;
mod voxelize;
mod why;

#[cfg(not(feature = "report"))]
use left_out as figures;
#[cfg(not(feature = "report"))]
use left_out as plan;
#[cfg(not(feature = "report"))]
use left_out as report;
use std::ffi::OsString;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use perirobot_march::error::{catch_panic, latest_backtrace, record_panics};
use perirobot_march::{Error, Result};
use terminal::{print, print_next};

/// Score where to put the sensors of a robot cell.
///
/// perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, compares the sensor's labels
/// (occupied, free, unknown) with the truth in regions of interest, and scores the pose with F1 and Cohen's kappa. The
/// counts are the same integers on every device.
#[derive(Parser)]
#[command(name = "perirobot", bin_name = "perirobot", version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// Log to standard error: files read, scenes voxelized, devices opened; -vv: also each batch
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
}

const AFTER_HELP: &str = "\
First steps:
  perirobot init my-cell
      write a small study to begin with
  perirobot check my-cell/study.toml
      what it contains, what is wrong, how long it takes
  perirobot choose scenes/cheapest.toml --out out/cheapest
      the cheapest sensors that meet all requirements of a study that ships
  perirobot sweep scenes/quick.toml --out out/quick
      score every pose of another one
  perirobot summary out/quick
      the tables of the paper from those results
  perirobot why out/quick
      what the best poses miss, and why
  perirobot report out/quick
      all of it as one page, with plots and a 3D view
  perirobot sweep scenes/quick.toml --out out/quick
      repeat it: a stopped sweep resumes, a finished one has nothing to do
  perirobot verify-backends scenes/tiny.toml
      prove that all backends agree
  perirobot devices
      see which GPU would be used

Exit codes: 0 done; 1 backends disagree; 2 bad input or arguments; 3 a device
or the disk failed; 4 a requirement is missed (judge)
or no set passes (choose); 75 a sweep was stopped
before its end (Ctrl-C, SIGTERM, SIGUSR1, --max-time), or another run uses
its folder: the same command resumes it, now or later; 70 a bug of perirobot:
its message contains what to report.";

/// The commands by purpose, in the order of first use.
const GROUPS: [(&str, &[&str]); 6] = [
    ("Start", &["init", "plan", "check", "sensors"]),
    ("Look", &["render", "voxelize", "compare", "field"]),
    ("Run", &["sweep", "merge", "choose"]),
    ("Explain", &["summary", "judge", "why", "approach", "report", "figures", "export", "score"]),
    ("Clusters", &["cluster"]),
    ("Developers", &["verify-backends", "bench", "devices", "schema", "completions", "man"]),
];

/// The program with its commands listed by groups.
fn command() -> clap::Command {
    let command = Cli::command();
    let mut list = String::new();
    for (title, names) in GROUPS {
        list += &format!("{title}:\n");
        for name in names {
            let about = command.find_subcommand(name).and_then(|found| found.get_about());
            list += &format!("  {name:<16} {}\n", about.map(|about| about.to_string()).unwrap_or_default());
        }
        list.push('\n');
    }
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}{{after-help}}"
    );
    command.help_template(template)
}

#[derive(Subcommand)]
enum Command {
    Init(init::Args),
    Plan(plan::Args),
    Check(check::Args),
    Sweep(sweep::Args),
    Merge(merge::Args),
    Choose(choose::Args),
    Summary(summary::Args),
    Judge(judge::Args),
    Compare(compare::Args),
    Why(why::Args),
    Approach(approach::Args),
    Report(report::Args),
    Figures(figures::Args),
    Export(export::Args),
    Score(score_map::Args),
    Render(render::Args),
    Cluster(cluster::Args),
    VerifyBackends(verify_backends::Args),
    Bench(bench::Args),
    Devices(devices::Args),
    Voxelize(voxelize::Args),
    Field(field::Args),
    Sensors(sensors::Args),
    Schema(schema::Args),
    Completions(completions::CompletionArgs),
    Man(completions::ManArgs),
}

/// The command line, with the program's name first.
static WORDS: OnceLock<Vec<OsString>> = OnceLock::new();

fn words() -> &'static [OsString] {
    WORDS.get().map_or(&[], Vec::as_slice)
}

/// Runs a command line, with the program's name first, and returns its exit code. To be called once per process.
pub fn run(words: Vec<OsString>) -> ExitCode {
    WORDS.get_or_init(|| words);
    record_panics();
    exit_code(catch_panic(run_command))
}

/// The exit code of a bug (`EX_SOFTWARE`).
const BUG: u8 = 70;

fn run_command() -> Result<ExitCode> {
    let Cli { command, verbose } = parse();
    log::start(verbose);
    match command {
        Command::Init(args) => init::run(&args),
        Command::Plan(args) => plan::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Sweep(args) => sweep::run(&args),
        Command::Merge(args) => merge::run(&args),
        Command::Choose(args) => choose::run(&args),
        Command::Summary(args) => summary::run(&args),
        Command::Judge(args) => judge::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Why(args) => why::run(&args),
        Command::Approach(args) => approach::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Figures(args) => figures::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Score(args) => score_map::run(&args),
        Command::Render(args) => render::run(&args),
        Command::Cluster(args) => cluster::run(&args),
        Command::VerifyBackends(args) => verify_backends::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Voxelize(args) => voxelize::run(&args),
        Command::Field(args) => field::run(&args),
        Command::Sensors(args) => sensors::run(&args),
        Command::Schema(args) => schema::run(&args),
        Command::Completions(args) => completions::completions(&args),
        Command::Man(args) => completions::man(&args),
    }
}

/// Prints an error and returns its exit code.
fn exit_code(outcome: Result<ExitCode>) -> ExitCode {
    let error = match outcome {
        Ok(code) => return code,
        Err(error) => error,
    };
    say!("error: {}", flags::to_text(&error));
    ExitCode::from(match error {
        Error::Disagreement(_) => 1,
        Error::Input(_) => 2,
        Error::Device(_) | Error::Storage(_) => 3,
        Error::Busy(_) | Error::Stopped(_) => stop::TRY_AGAIN,
        Error::Bug(_) => {
            if let Some(backtrace) = latest_backtrace() {
                say!("{}", backtrace.trim_end());
            }
            say!("{}", report_request(words()));
            BUG
        }
    })
}

/// The request to report a bug.
fn report_request(words: &[OsString]) -> String {
    let command: Vec<_> = words.iter().map(|word| word.to_string_lossy()).collect();
    let to = match env!("CARGO_PKG_REPOSITORY") {
        "" => "to the maintainers of perirobot",
        _ => concat!("to ", env!("CARGO_PKG_REPOSITORY")),
    };
    format!(
        "This is a bug of perirobot {}. Please report the message above, this command and its files {to}:\n  {}\n\
         Finished rows of a sweep are kept: the same command resumes it.",
        env!("CARGO_PKG_VERSION"),
        command.join(" ")
    )
}

/// Reads the arguments. Error messages quote wrong arguments, so these are escaped for terminals.
fn parse() -> Cli {
    let harmless = |word: OsString| OsString::from(&*terminal::harmless(&word.to_string_lossy()));
    let read = |words: Vec<OsString>| {
        command().try_get_matches_from(words).and_then(|found| Cli::from_arg_matches(&found))
    };
    read(words().to_vec()).unwrap_or_else(|wrong| {
        let again = read(words().iter().cloned().map(harmless).collect());
        again.err().unwrap_or(wrong).exit()
    })
}

/// The most warnings before a job begins; the manifest of a sweep has all.
const MOST_WARNINGS: usize = 20;

/// The most scenes named in a warning; the others are counted.
const FEW_SCENES: usize = 3;

/// Prints each different warning once, with its scenes, at most `most` of them; returns the number of all.
fn warn<'a>(scenes: impl Iterator<Item = (&'a str, &'a [String])>, most: usize) -> usize {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for (scene, warnings) in scenes {
        for warning in warnings {
            match all.iter_mut().find(|(text, _)| text == warning) {
                Some((_, names)) => names.push(scene),
                None => all.push((warning, vec![scene])),
            }
        }
    }
    for (warning, scenes) in all.iter().take(most) {
        let more = match scenes.len().saturating_sub(FEW_SCENES) {
            0 => String::new(),
            more if most == usize::MAX => format!(", {}", scenes[scenes.len() - more..].join(", ")),
            more => format!(" and {more} more scenes"),
        };
        let first = scenes[..scenes.len().min(FEW_SCENES)].join(", ");
        say!("warning: {first}{more}: {warning}");
    }
    if all.len() > most {
        say!("and {} more warnings (perirobot check --all)", all.len() - most);
    }
    all.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_reported_with_its_place_and_the_command() {
        record_panics();
        let outcome = catch_panic(|| -> Result<ExitCode> { panic!("no row {}", std::hint::black_box(3)) });
        // Other tests need the default panic output.
        drop(std::panic::take_hook());
        let error = outcome.unwrap_err();
        assert!(matches!(error, Error::Bug(_)), "{error:?}");
        let message = error.to_string();
        assert!(message.starts_with("panicked: no row 3 (at src/cli/mod.rs:"), "{message}");
        assert_eq!(format!("{:?}", exit_code(Err(error))), format!("{:?}", ExitCode::from(70)));
        let request = report_request(&["perirobot", "sweep", "a b.toml"].map(OsString::from));
        for part in [env!("CARGO_PKG_VERSION"), "Please report", "\n  perirobot sweep a b.toml\n"] {
            assert!(request.contains(part), "no {part:?} in {request}");
        }
    }

    #[test]
    fn each_command_is_in_one_group() {
        let mut grouped: Vec<&str> = GROUPS.iter().flat_map(|(_, names)| names.iter().copied()).collect();
        let program = Cli::command();
        let mut known: Vec<&str> = program.get_subcommands().map(|command| command.get_name()).collect();
        grouped.sort_unstable();
        known.sort_unstable();
        assert_eq!(grouped, known);
    }
}
