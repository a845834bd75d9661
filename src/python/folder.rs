//! Reads a folder of results of the command line, and writes a study that is in memory for it.

use std::path::{Component, Path, PathBuf};

use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::IN_MEMORY;
use perirobot_sweep::results::files::write_whole;
use perirobot_sweep::results::{Results, RowKey};
use perirobot_sweep::scoring::Row;

use crate::swept::Swept;
use crate::table::{Columns, columns};
use crate::watch::Listener;

/// The table of poses in a folder of results.
const POSES: &str = "poses.csv";

/// What a study that is saved is called.
const STUDY: &str = "study.toml";

/// The rows of a finished sweep: their columns, and the sweep.
pub(crate) fn results(folder: &Path, listener: &Listener) -> Result<(Columns, Swept)> {
    let (results, warnings) = Results::read(folder)?;
    warnings.into_iter().for_each(|warning| listener.warns_of_study(warning));
    let mut rows = Vec::new();
    for (scene, of_scene) in results.scenes.iter().enumerate() {
        for moment in of_scene.moments.clone() {
            listener.check_stop()?;
            for repeat in 0..results.repeats {
                for key in keys(&results) {
                    let RowKey { combination, choice, representation, region } = key;
                    rows.push(Row {
                        scene,
                        snapshot: moment - of_scene.moments.start,
                        repeat,
                        combination,
                        choice,
                        representation,
                        region,
                        counts: results.counts(moment, repeat, &key)?,
                    });
                }
            }
        }
    }
    let path = folder.join(POSES);
    let poses = std::fs::read(&path).map_err(|e| Error::io(&path, "cannot be read", e))?;
    Ok((columns((&results.subject).into(), &rows), Swept::new(results, poses)))
}

/// Which rows a moment has in each repeat, in their order.
fn keys(results: &Results) -> impl Iterator<Item = RowKey> + use<'_> {
    results.combinations.iter().enumerate().flat_map(|(combination, combined)| {
        let ways = combined.representations.len();
        let regions = results.regions.len();
        (0..combined.choices() * ways * regions).map(move |number| RowKey {
            combination,
            choice: number / (ways * regions),
            representation: number / regions % ways,
            region: number % regions,
        })
    })
}

/// Writes a study that is in memory, and what it reads from its own folder, into another one.
pub(crate) fn save(
    study: &perirobot_study::input::Study,
    files: &[(PathBuf, Vec<u8>)],
    out: &Path,
) -> Result<()> {
    let home = study.path.parent().unwrap_or(Path::new(""));
    let mut all: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    for (path, bytes) in files {
        let name = if *path == study.path { Path::new(STUDY) } else { relative_to_home(home, path)? };
        all.push((out.join(name), bytes.strip_prefix(IN_MEMORY.as_bytes()).unwrap_or(bytes).to_vec()));
    }
    for file in study.sources.read_files() {
        let path = home.join(&file.path);
        if files.iter().all(|(known, _)| *known != path) {
            let bytes = std::fs::read(&path).map_err(|e| Error::io(&path, "cannot be read", e))?;
            all.push((out.join(relative_to_home(home, &path)?), bytes));
        }
    }
    // Nothing is written unless all can be.
    for (target, bytes) in &all {
        if target.exists() && std::fs::read(target).ok().as_ref() != Some(bytes) {
            let what = Error::input(target, "is there already, and is another file");
            return Err(what.with_advice("name a new folder"));
        }
    }
    for (target, bytes) in &all {
        if let Some(folder) = target.parent() {
            std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "cannot be made", e))?;
        }
        write_whole(target, bytes)?;
    }
    Ok(())
}

/// A path from a folder above it.
fn relative_to_home<'a>(home: &Path, path: &'a Path) -> Result<&'a Path> {
    let inside = path.strip_prefix(home).ok();
    let is_below = |inside: &&Path| inside.components().all(|part| matches!(part, Component::Normal(_)));
    inside.filter(is_below).ok_or_else(|| {
        let cure = "name scenes and files so that they lie in the folder of the study or below";
        Error::from(Issue::says("lies outside of the study's folder").with_advice(cure).with_place(path))
    })
}
