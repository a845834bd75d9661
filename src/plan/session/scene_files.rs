//! The scene files of a study: those in its own folder can be edited with it.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use perirobot_study::input::Study;

use crate::document::{Document, candidate_objects};
use crate::state::{SceneFileAccess, SceneFileState};
use crate::study_file::StudyFile;

/// The scene files that a study has named so far.
#[derive(Default)]
pub(super) struct SceneFiles {
    /// Those that can be edited, as the document has them.
    open: Vec<OpenFile>,
    /// Why others cannot be, by the paths that the study gives.
    refused: BTreeMap<PathBuf, String>,
}

/// A scene file that can be edited.
struct OpenFile {
    file: StudyFile,
    /// As the page and the difference call it: from the folder of the study.
    name: String,
    /// Where it is on the disk.
    whole: PathBuf,
    /// The paths by which the study names it.
    paths: Vec<PathBuf>,
}

impl SceneFiles {
    /// The texts as they are edited, by the paths that the study gives.
    pub(super) fn texts(&self, document: &Document) -> Vec<(PathBuf, String)> {
        let each = self.open.iter().zip(document.texts().skip(1));
        each.flat_map(|(open, text)| open.paths.iter().map(|path| (path.clone(), text.to_string()))).collect()
    }

    /// The same of those that differ from the disk, by their paths from the folder of the study.
    pub(super) fn changed_texts(&self, study: &Path, document: &Document) -> BTreeMap<String, String> {
        let each = self.open.iter().zip(document.texts().skip(1));
        let changed = each.filter(|(open, text)| open.file.text() != *text);
        let named =
            |path: &Path| path.strip_prefix(study.parent()?).ok().map(|path| path.display().to_string());
        let by_paths = |(open, text): (&OpenFile, &str)| {
            let pair = |path: &PathBuf| Some((named(path)?, text.to_string()));
            open.paths.iter().filter_map(pair).collect::<Vec<_>>()
        };
        changed.flat_map(by_paths).collect()
    }

    /// Opens the scene files of a study that are new.
    pub(super) fn meet(&mut self, path: &Path, study: &Study, document: &mut Document, read_only: bool) {
        for scene in &study.scenes {
            let is_known = self.open.iter().any(|open| open.paths.contains(&scene.path));
            if is_known || self.refused.contains_key(&scene.path) {
                continue;
            }
            match self.open(path, &scene.path, document, read_only) {
                Ok(()) => {}
                Err(reason) => drop(self.refused.insert(scene.path.clone(), reason)),
            }
        }
    }

    /// Opens a file, or says why it cannot be edited.
    fn open(
        &mut self,
        study: &Path,
        path: &Path,
        document: &mut Document,
        read_only: bool,
    ) -> Result<(), String> {
        if read_only {
            return Err("the study is open to be read only".into());
        }
        let unreadable = |e: std::io::Error| format!("{} cannot be read: {e}", path.display());
        let whole = fs::canonicalize(path).map_err(unreadable)?;
        let folder = study.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = fs::canonicalize(folder).map_err(unreadable)?;
        let Ok(inside) = whole.strip_prefix(&folder) else {
            return Err(format!(
                "{} is outside the folder of the study, which is all that the planner writes to",
                path.display()
            ));
        };
        if let Some(open) = self.open.iter_mut().find(|open| open.whole == whole) {
            open.paths.push(path.into());
            return Ok(());
        }
        let file = StudyFile::open_unlocked(path).map_err(|e| e.to_string())?;
        let name = inside.to_string_lossy().replace('\\', "/");
        document.add_scene(&name, file.text());
        self.open.push(OpenFile { file, name, whole, paths: vec![path.into()] });
        Ok(())
    }

    /// Takes what other programs have written into files that were not changed here. Whether there was any.
    pub(super) fn follow(&mut self, document: &mut Document) -> bool {
        let mut is_new = false;
        for (number, open) in
            self.open.iter_mut().enumerate().filter(|(_, open)| open.file.is_changed_on_disk())
        {
            if let Some(text) = open.followed(number + 1, document) {
                document.follow_scene(number + 1, &text);
                open.file.set_known(text);
                is_new = true;
            }
        }
        is_new
    }

    /// What the page is told of the files of a study, and for each scene the number of its file.
    pub(super) fn states(&self, study: &Study, document: &Document) -> (Vec<SceneFileState>, Vec<usize>) {
        let candidates = candidate_objects(document.text());
        SceneFileState::all(study, &candidates, &|path| {
            let open = self.open.iter().find(|open| open.paths.iter().any(|one| one == path));
            match (open, self.refused.get(path)) {
                (Some(open), _) => SceneFileAccess { name: open.name.clone(), reason: None },
                (None, reason) => {
                    SceneFileAccess { name: path.display().to_string(), reason: reason.cloned() }
                }
            }
        })
    }

    /// The files that can be edited, in the order of the document.
    pub(super) fn files_mut(&mut self) -> impl Iterator<Item = &mut StudyFile> {
        self.open.iter_mut().map(|open| &mut open.file)
    }

    /// The names of those that another program has changed and that cannot be followed.
    pub(super) fn changed_on_disk(&self, document: &Document) -> Vec<String> {
        let is_lost = |(number, open): &(usize, &OpenFile)| {
            open.file.is_changed_on_disk() && open.followed(number + 1, document).is_none()
        };
        self.open.iter().enumerate().filter(is_lost).map(|(_, open)| open.name.clone()).collect()
    }

    /// Refuses a file that a link leads to now: it may be outside of the folder of the study.
    pub(super) fn check_places(&self) -> Result<(), String> {
        for OpenFile { whole, paths, name, .. } in &self.open {
            if paths.iter().any(|path| fs::canonicalize(path).is_ok_and(|now| now != *whole)) {
                return Err(format!(
                    "{name} is another file now than when the study was opened: open it again"
                ));
            }
        }
        Ok(())
    }

    /// Reads what is on the disk now, of all that are there.
    pub(super) fn read(&self) -> perirobot_march::Result<Vec<Option<String>>> {
        let read = |open: &OpenFile| match open.whole.exists() {
            true => open.file.read().map(Some),
            false => Ok(None),
        };
        self.open.iter().map(read).collect()
    }

    /// Takes what was read, into a new document; those that are gone are forgotten.
    pub(super) fn set_known(&mut self, texts: Vec<Option<String>>, document: &mut Document) {
        self.refused.clear();
        let both = std::mem::take(&mut self.open).into_iter().zip(texts);
        for (mut open, text) in both.filter_map(|(open, text)| Some((open, text?))) {
            document.add_scene(&open.name, &text);
            open.file.set_known(text);
            self.open.push(open);
        }
    }
}

impl OpenFile {
    /// What another program has written, if that can be taken without a question: it was not changed here, not even in a step
    /// that can be undone.
    fn followed(&self, number: usize, document: &Document) -> Option<String> {
        (!document.is_touched(number)).then(|| self.file.read().ok()).flatten()
    }
}
