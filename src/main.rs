//! The command line: arguments in, exit codes out. Each subcommand is one file in `cli`.

fn main() -> std::process::ExitCode {
    perirobot::cli::run(std::env::args_os().collect())
}
