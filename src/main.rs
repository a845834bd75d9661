//! The command line: arguments in, exit codes out. Each subcommand is one file in `cli`.

mod cli;

fn main() -> std::process::ExitCode {
    cli::run()
}
