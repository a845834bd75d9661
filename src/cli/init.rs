//! `perirobot init`: a first study to change, with the files that it needs. They are beside this file, and in
//! `scenes/paper/`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use perirobot_march::{Error, Result};
use perirobot_study::input::schema;
use perirobot_sweep::results::files::write_whole;

/// Write a small study with comments to begin with
///
/// The folder then holds a study, its cell (a room, a table, a robot, a person who walks up to it), the
/// robot's and the person's files, and the schemas by which editors complete and check keys. Nothing that is
/// there is overwritten.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot init my-cell
      then: perirobot check my-cell/study.toml")]
pub(super) struct Args {
    /// The folder that the files go to; made if needed
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// Their names, and what is in them.
fn files() -> [(&'static str, &'static str); 6] {
    [
        ("study.toml", include_str!("init/study.toml")),
        ("cell.toml", include_str!("init/cell.toml")),
        ("operator.csv", perirobot_shipped::OPERATOR),
        ("robot.urdf", perirobot_shipped::UR10),
        ("schemas/study.schema.json", schema::study()),
        ("schemas/scene.schema.json", schema::scene()),
    ]
}

fn write(files: &[(PathBuf, &str)]) -> Result<()> {
    for (path, text) in files {
        let folder = path.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "cannot be made", e))?;
        write_whole(path, text.as_bytes()).map_err(|error| match error {
            Error::Storage(issue) => Error::Storage(
                issue.with_advice("Nothing is left behind: mend that and run the same command again"),
            ),
            other => other,
        })?;
    }
    Ok(())
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let files = files().map(|(name, text)| (args.folder.join(name), text));
    // A link that leads nowhere counts as a file, too.
    if let Some((path, _)) = files.iter().find(|(path, _)| path.symlink_metadata().is_ok()) {
        let what = "is there already and would be lost: name another folder";
        return Err(Error::input(path, what));
    }
    let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let schemas = args.folder.join("schemas");
    let made: Vec<PathBuf> = schemas.ancestors().take_while(missing).map(Path::to_path_buf).collect();
    if let Err(error) = write(&files) {
        // The same command must find nothing in its way.
        files.iter().for_each(|(path, _)| drop(std::fs::remove_file(path)));
        made.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
        return Err(error);
    }
    let folder = args.folder.display();
    super::print(&format!(
        "{} files in {folder}. Next:\n\
         \x20 perirobot check {folder}/study.toml                   what it contains, and how long it takes\n\
         \x20 perirobot sweep {folder}/study.toml --out {folder}/out       score all poses\n\
         \x20 perirobot summary {folder}/out                        the tables behind the best\n\
         \x20 perirobot why {folder}/out                            what the best poses miss, and why\n\
         \x20 perirobot report {folder}/out                         all of it as one page, with a 3D view\n\
         Then change {folder}/study.toml and {folder}/cell.toml: every line says what it is for.\n",
        files.len()
    ))?;
    Ok(ExitCode::SUCCESS)
}
