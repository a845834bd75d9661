//! Cells to begin with, as a page of their own: a person chooses one and a folder, its files are written, and the same
//! address then shows the planner of its study.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, OnceLock};

use perirobot_decide::view::Choice;
use perirobot_march::Result;
use perirobot_page::render::plan::floor_plan;
use perirobot_study::input::{PLANNED, Study};
use perirobot_study::world::World;
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::page;
use crate::server::{Method, Request, Response};
use crate::session::{Session, locked};

/// A cell to begin with, in words.
#[derive(Clone, Debug, Serialize)]
pub struct TemplateCard {
    /// Its name, one word.
    pub name: String,
    /// What it is, in a sentence.
    pub about: String,
    /// What its plan misses.
    pub to_improve: String,
}

/// The cells to begin with, and their files.
pub trait Templates: Sync {
    /// All of them.
    fn cards(&self) -> Vec<TemplateCard>;

    /// The study of one, read from memory.
    ///
    /// # Errors
    /// If there is none of this name.
    fn study(&self, name: &str) -> Result<Study>;

    /// Writes the files of one into a folder, and returns the path of its study.
    ///
    /// # Errors
    /// If there is none of this name, or a file is in the way: then nothing is written.
    fn write(&self, name: &str, folder: &Path) -> Result<PathBuf>;

    /// Opens a study that was written.
    ///
    /// # Errors
    /// As [`Session::open`].
    fn open(&self, study: &Path) -> Result<Session<'_>>;
}

/// The page of all templates, and later the planner of the chosen one.
pub struct Gallery<'a> {
    templates: &'a dyn Templates,
    session: OnceLock<Session<'a>>,
    /// One study is opened at a time.
    opening: Mutex<()>,
    html: String,
    policy: String,
}

/// What a person chose.
#[derive(Deserialize)]
struct Chosen {
    template: String,
    folder: PathBuf,
}

const OPENED_ELSEWHERE: &str = "another window has opened a study: reload the page";

/// A folder with `~` for the person's own, as shells write it.
fn with_home(folder: PathBuf) -> PathBuf {
    match (folder.strip_prefix("~"), std::env::home_dir()) {
        (Ok(rest), Some(home)) => home.join(rest),
        _ => folder,
    }
}

impl<'a> Gallery<'a> {
    /// Of some templates.
    pub fn new(templates: &'a dyn Templates) -> Gallery<'a> {
        let (html, policy) = page::gallery();
        Gallery { templates, session: OnceLock::new(), opening: Mutex::new(()), html, policy }
    }

    /// The Content-Security-Policy of this page and of the planner's.
    pub fn policy(&self) -> &str {
        &self.policy
    }

    /// The study that was chosen.
    pub fn session(&self) -> Option<&Session<'a>> {
        self.session.get()
    }

    /// Answers a request that was let in; once a study is open, as its session.
    pub fn answer(&self, request: &Request) -> Response<'_> {
        if let Some(session) = self.session.get() {
            return match (request.method, request.path.as_str()) {
                (Method::Post, "/open") | (Method::Get, "/sketch" | "/templates") => {
                    Response::error(409, OPENED_ELSEWHERE)
                }
                _ => session.answer(request),
            };
        }
        let answer = match (request.method, request.path.as_str()) {
            (Method::Get, "/") => {
                return Response::new(200, "text/html; charset=utf-8", self.html.clone());
            }
            (Method::Get, "/templates") => Ok(self.cards()),
            (Method::Get, "/sketch") => self.sketch(request.value("template").unwrap_or_default()),
            (Method::Post, "/open") => self.open(request),
            _ => return Response::error(404, "no study is open yet: choose a template first"),
        };
        answer.unwrap_or_else(|error| Response::error(400, &error.to_string()))
    }

    fn cards(&self) -> Response<'a> {
        // Relative folders begin where the program was started.
        let here = std::env::current_dir().unwrap_or_default();
        Response::json(json!({ "here": here, "templates": self.templates.cards() }).to_string())
    }

    /// The floor plan of a template, with its plan and the floor that it does not watch.
    fn sketch(&self, name: &str) -> Result<Response<'a>> {
        let study = self.templates.study(name)?;
        let worlds = World::prepare_all(&study)?;
        let planned = study.combinations.iter().position(|one| one.name == PLANNED);
        let choice =
            planned.map(|combination| Choice { combination, choice: 0, representation: 0, repeat: 0 });
        Ok(Response::new(200, "image/svg+xml", floor_plan(&study, &worlds, 0, choice).inline()))
    }

    fn open(&self, request: &Request) -> Result<Response<'a>> {
        let chosen: Chosen = match serde_json::from_slice(&request.body) {
            Ok(chosen) => chosen,
            Err(e) => return Ok(Response::error(400, &format!("the request is not understood: {e}"))),
        };
        let _alone = locked(&self.opening);
        if self.session.get().is_some() {
            return Ok(Response::error(409, OPENED_ELSEWHERE));
        }
        if chosen.folder.as_os_str().is_empty() {
            return Ok(Response::error(400, "name a folder for the files"));
        }
        let study = self.templates.write(&chosen.template, &with_home(chosen.folder))?;
        let session = self.templates.open(&study)?;
        let _ = self.session.set(session);
        Ok(Response::json(json!({ "study": study }).to_string()))
    }
}
