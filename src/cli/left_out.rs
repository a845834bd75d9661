//! The commands `report`, `plan` and `figures` of a program built without the feature `report`.

use std::ffi::OsString;
use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;

/// (not in this program, which was built without the feature `report`)
#[derive(clap::Args)]
pub(super) struct Args {
    /// Any arguments
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

pub(super) fn run(_: &Args) -> Result<ExitCode> {
    Err(Issue::left_out("this command", "report").into())
}
