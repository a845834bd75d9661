//! `perirobot schema`: what editors need to complete and check study and scene files. The text
//! is in `input::schema`.

use std::process::ExitCode;

use clap::ValueEnum;
use perirobot_march::Result;
use perirobot_study::input::schema;

/// Print the JSON schema of study or scene files
///
/// Write it into a file, and name that file in the first line of a study or scene: `#:schema
/// study.schema.json`. Editors that know Taplo (as Even Better TOML for Visual Studio Code) then complete
/// keys, explain them, and mark what is wrong. `perirobot init` does both.
#[derive(clap::Args)]
pub(super) struct Args {
    /// Which kind of file
    file: SchemaKind,
}

#[derive(Clone, Copy, ValueEnum)]
enum SchemaKind {
    /// What is swept over what
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
