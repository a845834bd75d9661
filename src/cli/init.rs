//! `perirobot init`: writes a first study with the files that it needs, or a template of a typical cell. The files are
//! next to this one and in `scenes/`.

mod templates;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use perirobot_march::{Error, Result};
use perirobot_study::input::schema;
use perirobot_sweep::results::files::write_whole;
pub(super) use templates::Template;

/// Write a small study with comments to begin with
///
/// The folder then contains a study, its cell (a room, a table, a robot, a person who walks up to it), the robot's and
/// the person's files, and the schemas with which editors complete and check keys. Existing files are never
/// overwritten.
///
/// With --template it is a typical cell with people at several moments, prices and requirements, and a plan that misses
/// some of them.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  perirobot init my-cell
      then: perirobot check my-cell/study.toml
  perirobot init --template palletiser my-palletiser
      then: perirobot choose my-palletiser/study.toml --out out")]
pub(super) struct Args {
    /// Start from a typical cell instead
    #[arg(long, value_name = "NAME")]
    template: Option<Template>,
    /// The folder for the files; created if needed
    #[arg(value_name = "DIR")]
    folder: PathBuf,
}

/// The names and texts of the files.
fn files() -> Vec<(String, &'static str)> {
    let own = [
        ("study.toml", include_str!("init/study.toml")),
        ("cell.toml", include_str!("init/cell.toml")),
        ("operator.csv", perirobot_shipped::OPERATOR),
        ("robot.urdf", perirobot_shipped::UR10),
    ];
    own.into_iter().chain(schemas()).map(|(name, text)| (name.into(), text)).collect()
}

/// The schemas for editors.
fn schemas() -> [(&'static str, &'static str); 2] {
    [("schemas/study.schema.json", schema::study()), ("schemas/scene.schema.json", schema::scene())]
}

fn write(files: &[(PathBuf, &str)]) -> Result<()> {
    for (path, text) in files {
        let folder = path.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "cannot be made", e))?;
        write_whole(path, text.as_bytes()).map_err(|error| match error {
            Error::Storage(issue) => Error::Storage(
                issue.with_advice("Nothing was written: fix this and run the same command again"),
            ),
            other => other,
        })?;
    }
    Ok(())
}

/// Writes files into a folder, or nothing if one of them exists.
pub(super) fn write_into(folder: &Path, files: Vec<(String, &str)>) -> Result<usize> {
    let files: Vec<(PathBuf, &str)> =
        files.into_iter().map(|(name, text)| (folder.join(name), text)).collect();
    // A dangling link counts as a file.
    if let Some((path, _)) = files.iter().find(|(path, _)| path.symlink_metadata().is_ok()) {
        let what = "exists and would be overwritten: name another folder";
        return Err(Error::input(path, what));
    }
    let missing = |folder: &&Path| !folder.as_os_str().is_empty() && !folder.exists();
    let inner = files.iter().filter_map(|(path, _)| path.parent());
    let mut made: Vec<PathBuf> = Vec::new();
    for folder in inner.flat_map(|folder| folder.ancestors().take_while(missing)) {
        if !made.iter().any(|known| known == folder) {
            made.push(folder.into());
        }
    }
    // Innermost first, so that each is empty when it is removed.
    made.sort_by_key(|folder| std::cmp::Reverse(folder.components().count()));
    if let Err(error) = write(&files) {
        // The same command must find an empty place again.
        files.iter().for_each(|(path, _)| drop(std::fs::remove_file(path)));
        made.iter().for_each(|folder| drop(std::fs::remove_dir(folder)));
        return Err(error);
    }
    Ok(files.len())
}

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    let count = write_into(&args.folder, args.template.map_or_else(files, Template::files))?;
    super::print(&format!(
        "{} files in {}. Next:\n{}",
        count,
        args.folder.display(),
        next_steps(&args.folder, args.template)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// The next commands.
fn next_steps(folder: &Path, template: Option<Template>) -> String {
    let folder = folder.display();
    match template {
        None => format!(
            "  perirobot check {folder}/study.toml                   what it contains, and how long it takes\n\
             \x20 perirobot sweep {folder}/study.toml --out {folder}/out       score all poses\n\
             \x20 perirobot summary {folder}/out                        the tables behind the best\n\
             \x20 perirobot why {folder}/out                            what the best poses miss, and why\n\
             \x20 perirobot report {folder}/out                         all of it as one page, with a 3D view\n\
             Then change {folder}/study.toml and {folder}/cell.toml: comments explain each line.\n"
        ),
        Some(_) => format!(
            "  perirobot check {folder}/study.toml                   what it contains, and how long it takes\n\
             \x20 perirobot sweep {folder}/study.toml --out {folder}/planned   score the planned sensors\n\
             \x20 perirobot judge {folder}/planned                      which requirements they miss\n\
             \x20 perirobot choose {folder}/study.toml --out {folder}/out      the cheapest set that meets all\n\
             \x20 perirobot report {folder}/out                         all of it as one page, with a 3D view\n\
             Then change {folder}/study.toml and {folder}/cell.toml to your own cell.\n"
        ),
    }
}
