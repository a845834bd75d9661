//! `perirobot schema`: the schemas with which editors complete and check study and scene files. Their text is in
//! `input::schema`.

use std::process::ExitCode;

use clap::ValueEnum;
use perirobot_march::Result;
use perirobot_study::input::schema;

/// Print the JSON schema of study or scene files
///
/// Write it to a file, and name that file in the first line of a study or scene: `#:schema study.schema.json`. Editors
/// that support Taplo (as Even Better TOML for Visual Studio Code) then complete keys, explain them, and mark errors.
/// `perirobot init` does both.
#[derive(clap::Args)]
pub(super) struct Args {
    /// The kind of file
    file: SchemaKind,
}

#[derive(Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// The sensors, poses and regions of a sweep
    Study,
    /// The objects of a cell
    Scene,
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::print(match args.file {
        SchemaKind::Study => schema::study(),
        SchemaKind::Scene => schema::scene(),
    })?;
    Ok(ExitCode::SUCCESS)
}
