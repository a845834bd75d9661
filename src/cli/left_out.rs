//! What stands in the place of `report`, `plan` and `figures` where the feature `report` was left out.

use std::ffi::OsString;
use std::process::ExitCode;

use perirobot_march::Result;
use perirobot_march::error::Issue;

/// (not in this program, which was built without the feature `report`)
#[derive(clap::Args)]
pub(super) struct Args {
    /// Whatever the command takes elsewhere
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    words: Vec<OsString>,
}

pub(super) fn run(_: &Args) -> Result<ExitCode> {
    Err(Issue::left_out("this command", "report").into())
}
