//! Requests that change the study or its file.

use std::sync::{Arc, MutexGuard};

use perirobot_study::sensor::MountLink;
use serde::Deserialize;
use serde_json::json;

use super::plan::own_place;
use super::{Answer, Desk, Loaded, Refused, Session, locked, read};
use crate::document::{Device, Document, Edit, EditRequest, Known};
use crate::server::{Request, Response};

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

/// Places of an edit as the study says them, if a link carries the sensor.
fn put_on_link(loaded: &Loaded, edit: &mut Edit, moment: Option<usize>) -> Result<(), Refused> {
    let placed = |index: usize| loaded.placed.get(index).map(|&[sensor, _]| sensor);
    let named = |name: &str| loaded.study.sensors.iter().position(|sensor| sensor.name == name);
    let (sensor, at) = match edit {
        Edit::Move { index, at } | Edit::Copy { index, at } => (placed(*index), at),
        Edit::Add { device: Device::Sensor(name), at, .. } => (named(name), at),
        Edit::SetSensor { index, device, .. } => return check_same_link(loaded, placed(*index), device),
        _ => return Ok(()),
    };
    if let Some(sensor) = sensor {
        *at = own_place(loaded, sensor, at, moment)?;
    }
    Ok(())
}

/// Refuses to put a sensor of a link where one stood that is in the world, or the other way round: the pose would be in
/// another frame.
fn check_same_link(loaded: &Loaded, placed: Option<usize>, device: &Device) -> Result<(), Refused> {
    let sensors = &loaded.study.sensors;
    let Some(now) = placed.map(|sensor| &sensors[sensor]) else { return Ok(()) };
    let (name, on) = match device {
        Device::Model(name) => (name, None),
        Device::Sensor(name) => match sensors.iter().find(|sensor| sensor.name == *name) {
            Some(sensor) => (name, sensor.on.as_ref()),
            None => return Ok(()),
        },
    };
    if now.on.as_ref() == on {
        return Ok(());
    }
    let place = |on: Option<&MountLink>| {
        on.map_or("in the world".into(), |MountLink { object, link }| format!("on {object}/{link}"))
    };
    let (old, new) = (place(now.on.as_ref()), place(on));
    let words = format!("{:?} is {old} and {name:?} {new}: delete the one and add the other", now.name);
    Err(Refused(400, words))
}

impl Desk {
    /// The names of the files that another program has changed.
    pub(super) fn changed_on_disk(&self) -> Vec<String> {
        let study = self.file.is_changed_on_disk().then(|| self.file.name());
        study.into_iter().chain(self.scenes.changed_on_disk(&self.document)).collect()
    }

    /// Takes what other programs have written into scene files that were not changed here. Whether there was any.
    fn follow_scenes(&mut self) -> bool {
        self.scenes.follow(&mut self.document)
    }
}

impl Session<'_> {
    pub(super) fn edit(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let EditRequest { mut edit, gesture, moment } = read(request)?;
        let is_typed = matches!(edit, Edit::SetText { .. });
        let mut desk = self.desk_for(request)?;
        if desk.follow_scenes() {
            self.load(&mut desk);
        }
        if !is_typed && !desk.problems.is_empty() {
            let words = format!("the study has errors, repair them first: {}", desk.problems[0].words);
            return Err(Refused(400, words));
        }
        if let Some(loaded) = &desk.loaded {
            put_on_link(loaded, &mut edit, moment)?;
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
        if desk.follow_scenes() | step(&mut desk.document) {
            self.load(&mut desk);
        }
        Ok(self.state(&desk))
    }

    pub(super) fn save(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let SaveQuestion { overwrite } = read(request)?;
        let mut desk = self.desk_for(request)?;
        if desk.follow_scenes() {
            self.load(&mut desk);
        }
        let changed = desk.changed_on_disk();
        if !overwrite && !changed.is_empty() {
            let names = changed.join(" and ");
            let words = format!("another program has changed {names} since the study was opened");
            let answer = json!({ "error": words, "changed_on_disk": true });
            return Ok(Response::new(409, "application/json", answer.to_string()));
        }
        desk.scenes.check_places().map_err(|words| Refused(400, words))?;
        let Desk { file, scenes, document, .. } = &mut *desk;
        let mut texts = document.texts();
        file.write_if_changed(texts.next().unwrap_or_default())?;
        for (file, text) in scenes.files_mut().zip(texts) {
            file.write_if_changed(text)?;
        }
        document.saved();
        desk.was_saved = true;
        Ok(self.state(&desk))
    }

    /// Takes the files as other programs have written them, in place of what was edited here.
    pub(super) fn reload(&self, request: &Request) -> Answer<'_> {
        self.may_write()?;
        let mut desk = self.desk_for(request)?;
        let Desk { file, scenes, document, .. } = &mut *desk;
        // All or none: what was not read must not be overwritten.
        let (study, others) = (file.read()?, scenes.read()?);
        file.set_known(study);
        *document = Document::new(file.text().to_string());
        scenes.set_known(others, document);
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
