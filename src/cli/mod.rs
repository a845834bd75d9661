//! Subcommands and what they share: messages, exit codes, the progress bar. Nothing is computed here.

mod backend;
mod bench;
mod bytes;
mod cluster;
mod compare;
mod devices;
mod packages;
mod study;
mod summary;
mod sweep;
mod voxelize;

use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use perirobot::{Error, Result};

/// Score where to put the sensors of a robot cell.
///
/// perirobot voxelizes a cell, casts every ray of every candidate sensor pose through it, compares what the sensor
/// would claim (occupied, free, unknown) with the truth in regions of interest, and scores the pose with F1 and
/// Cohen's kappa. The counts are the same integers on every device.
#[derive(Parser)]
#[command(name = "perirobot", bin_name = "perirobot", version, max_term_width = 100, after_help = AFTER_HELP)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const AFTER_HELP: &str = "\
First steps:
  perirobot sweep scenes/quick.toml --out out/quick   score the poses of a study that ships
  perirobot summary out/quick                         the tables of the paper from those results
  perirobot compare scenes/tiny.toml                  prove that all backends agree
  perirobot devices                                   see which GPU would be used

Exit codes: 0 done; 1 backends disagree (compare, bench); 2 bad input or arguments; 3 a device failed.";

#[derive(Subcommand)]
enum Command {
    Sweep(sweep::Args),
    Summary(summary::Args),
    Cluster(cluster::Args),
    Compare(compare::Args),
    Bench(bench::Args),
    Devices(devices::Args),
    Voxelize(voxelize::Args),
}

/// Runs the command line and turns its outcome into an exit code.
pub(crate) fn run() -> ExitCode {
    let outcome = match Cli::parse().command {
        Command::Sweep(args) => sweep::run(&args),
        Command::Summary(args) => summary::run(&args),
        Command::Cluster(args) => cluster::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Voxelize(args) => voxelize::run(&args),
    };
    match outcome {
        Ok(code) => code,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::from(match error {
                Error::Input(_) => 2,
                Error::Device(_) => 3,
            })
        }
    }
}

/// Prints each different warning once, with the scenes that have it.
fn warn<'a>(scenes: impl Iterator<Item = (&'a str, &'a [String])>) {
    let mut all: Vec<(&str, Vec<&str>)> = Vec::new();
    for (scene, warnings) in scenes {
        for warning in warnings {
            match all.iter_mut().find(|(text, _)| text == warning) {
                Some((_, names)) => names.push(scene),
                None => all.push((warning, vec![scene])),
            }
        }
    }
    for (warning, scenes) in all {
        eprintln!("warning: {}: {warning}", scenes.join(", "));
    }
}

/// A bar with rate and time left; hidden where nobody watches.
fn progress(total: u64, what: &str) -> ProgressBar {
    if !std::io::stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let template = format!("{{bar:30}} {{pos}}/{{len}} {what}  {{per_sec}}  {{eta}} left");
    let style = ProgressStyle::with_template(&template).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(total).with_style(style)
}

/// Writes to standard output; a reader that went away (`| head`) is no failure.
fn print(text: &str) -> Result<()> {
    use std::io::Write;
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Error::Device(format!("cannot write to standard output: {e}")))
        }
        _ => Ok(()),
    }
}
