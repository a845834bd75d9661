//! `perirobot completions` and `perirobot man`: shell completions and manual pages, generated from the program's
//! arguments.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::CommandFactory;
use clap_complete::Shell;
use perirobot_march::{Error, Result};

use super::Cli;

/// Print completions for a shell
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot completions bash > \\
    ~/.local/share/bash-completion/completions/perirobot
  perirobot completions zsh > ~/.zfunc/_perirobot
      (with fpath+=~/.zfunc before compinit)
  perirobot completions fish > ~/.config/fish/completions/perirobot.fish")]
pub(super) struct CompletionArgs {
    /// The shell
    shell: Shell,
}

/// Write manual pages, one for each subcommand
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot man ~/.local/share/man/man1      then: man perirobot-sweep")]
pub(super) struct ManArgs {
    /// The output folder; created if needed
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

pub(super) fn completions(args: &CompletionArgs) -> Result<ExitCode> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "perirobot", &mut script);
    super::print(&String::from_utf8_lossy(&script))?;
    Ok(ExitCode::SUCCESS)
}

pub(super) fn man(args: &ManArgs) -> Result<ExitCode> {
    let made = std::fs::create_dir_all(&args.folder);
    made.map_err(|e| Error::io(&args.folder, "cannot be made", e))?;
    let program = Cli::command().disable_help_subcommand(true);
    let count = pages(&program);
    let written = clap_mangen::generate_to(program, &args.folder);
    written.map_err(|e| Error::io(&args.folder, "its pages cannot be written", e))?;
    super::print(&format!("{count} pages in {}\n", args.folder.display()))?;
    Ok(ExitCode::SUCCESS)
}

/// The pages of the program, its subcommands and theirs.
fn pages(command: &clap::Command) -> usize {
    1 + command.get_subcommands().map(pages).sum::<usize>()
}
