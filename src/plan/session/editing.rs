//! Requests that change the study or its file.

use std::sync::{Arc, MutexGuard};

use serde::Deserialize;
use serde_json::json;

use super::{Answer, Desk, Refused, Session, locked, read};
use crate::document::{Document, Edit, EditRequest, Known};
use crate::server::{Request, Response};
use crate::study_file::Saved;

/// On which version of the study a change was made.
#[derive(Deserialize)]
struct MadeOn {
    #[serde(default)]
    version: Option<u64>,
}

/// The status of a change that was made on an older version.
const STALE: u16 = 412;
const CHANGED_ELSEWHERE: &str =
    "another window has changed the study: it is shown as it is now, make your change again";

#[derive(Deserialize)]
struct SaveQuestion {
    #[serde(default)]
    overwrite: bool,
}

impl Session<'_> {
    pub(super) fn edit(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let EditRequest { edit, gesture } = read(request)?;
        let is_typed = matches!(edit, Edit::SetText { .. });
        let mut desk = self.desk_for(request)?;
        if !is_typed && !desk.problems.is_empty() {
            return Err(Refused(400, "the study has errors: repair its text first".into()));
        }
        let (before, version) = (desk.document.clone(), desk.version);
        let known =
            desk.loaded.as_ref().map_or_else(|| Arc::new(Known::catalogue()), |one| one.known.clone());
        desk.changed_index = desk.document.apply(&edit, gesture, &known)?;
        let was_right = desk.problems.is_empty();
        self.load(&mut desk);
        if was_right && !is_typed && !desk.problems.is_empty() {
            let words = desk.problems[0].words.clone();
            desk.document = before;
            self.load(&mut desk);
            desk.version = version;
            return Err(Refused(400, words));
        }
        let state = self.state(&desk);
        desk.changed_index = None;
        Ok(state)
    }

    pub(super) fn step(&self, request: &Request, step: impl Fn(&mut Document) -> bool) -> Answer<'_> {
        self.may_write()?;
        let mut desk = self.desk_for(request)?;
        if step(&mut desk.document) {
            self.load(&mut desk);
        }
        Ok(self.state(&desk))
    }

    pub(super) fn save(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let SaveQuestion { overwrite } = read(request)?;
        let mut desk = self.desk_for(request)?;
        let Desk { file, document, .. } = &mut *desk;
        match file.save(document.text(), overwrite)? {
            Saved::ChangedOnDisk => {
                let words = "another program has changed the file since it was opened";
                Ok(Response::new(
                    409,
                    "application/json",
                    json!({ "error": words, "changed_on_disk": true }).to_string(),
                ))
            }
            Saved::Written => {
                document.saved();
                desk.was_saved = true;
                Ok(self.state(&desk))
            }
        }
    }

    /// Takes the file as another program has written it, in place of what was edited here.
    pub(super) fn reload(&self) -> Answer<'_> {
        self.may_write()?;
        let mut desk = locked(&self.desk);
        desk.file.reload()?;
        desk.document = Document::new(desk.file.text().to_string());
        self.load(&mut desk);
        Ok(self.state(&desk))
    }

    /// Locks the study for a change, unless another window has changed it since the change was made.
    fn desk_for(&self, request: &Request) -> Result<MutexGuard<'_, Desk>, Refused> {
        let MadeOn { version } = read(request)?;
        let desk = locked(&self.desk);
        match version {
            Some(version) if version != desk.version => Err(Refused(STALE, CHANGED_ELSEWHERE.into())),
            _ => Ok(desk),
        }
    }

    fn may_write(&self) -> Result<(), Refused> {
        match self.read_only {
            true => Err(Refused(403, "the study is open to be read only".into())),
            false => Ok(()),
        }
    }
}
