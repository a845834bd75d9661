//! What a person takes along: papers of the present plan, made in the background and kept in memory, each under an address
//! that cannot be guessed, so that a tab can show it without the token.

use std::io::Write;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use serde::Deserialize;

use super::{Answer, LINES, Refused, Session, locked, read};
use crate::report::{Paper, PaperEvent, paper};
use crate::server::{PAPERS, Request, Response, is_equal, new_token};

/// How many papers are kept.
const MOST_PAPERS: usize = 4;

/// What pages of papers may do: they bring a policy of their own, and reach nothing.
const PAPER_POLICY: &str = "connect-src 'none'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'";

/// A paper and its secret name.
pub(super) struct KeptPaper {
    name: String,
    html: String,
}

#[derive(Deserialize)]
struct PaperQuestion {
    kind: Paper,
}

impl Session<'_> {
    /// Makes a paper; its progress is sent a line each, and at last where it is.
    pub(super) fn make_paper(&self, request: &Request) -> Answer<'_> {
        let PaperQuestion { kind } = read(request)?;
        let (loaded, note) = {
            let desk = locked(&self.desk);
            if !desk.problems.is_empty() {
                return Err(Refused(400, "the study has errors: repair them first".into()));
            }
            let name = desk.file.path().file_name().unwrap_or_default().to_string_lossy().into_owned();
            let changed: Vec<&str> = desk.document.changed_names(&name).collect();
            let note =
                format!("Made in the planner, with changes that are not saved in {}.", changed.join(" and "));
            (desk.loaded.clone(), desk.document.is_changed().then_some(note))
        };
        let loaded = loaded.filter(|one| !one.placed.is_empty());
        let loaded = loaded.ok_or_else(|| Refused(400, "no sensor is placed: place one first".into()))?;
        let stream = move |out: &mut dyn Write| {
            let stop = AtomicBool::new(false);
            let (sender, events) = mpsc::channel();
            std::thread::scope(|scope| {
                scope.spawn(|| {
                    let sender = sender;
                    let emit = |event: PaperEvent| drop(sender.send(event));
                    let study = (&*loaded.study, loaded.worlds.as_slice());
                    let made = paper(study, kind, &self.backend, note.as_deref(), (&stop, &emit))
                        .and_then(|html| self.keep_paper(html));
                    emit(made.map_or_else(|error| PaperEvent::Error(error.to_string()), PaperEvent::Ready));
                });
                for event in events {
                    let line = serde_json::to_string(&event).expect("an event is JSON") + "\n";
                    if out.write_all(line.as_bytes()).is_err() || self.is_ending.load(Ordering::Relaxed) {
                        stop.store(true, Ordering::Relaxed);
                    }
                }
            });
            Ok(())
        };
        Ok(Response::stream(LINES, stream))
    }

    fn keep_paper(&self, html: String) -> perirobot_march::Result<String> {
        let name = new_token()?;
        let address = format!("{PAPERS}{name}");
        let mut papers = locked(&self.papers);
        if papers.len() == MOST_PAPERS {
            papers.remove(0);
        }
        papers.push(KeptPaper { name, html });
        Ok(address)
    }

    /// The paper of a name.
    pub(super) fn show_paper(&self, name: &str) -> Answer<'_> {
        let papers = locked(&self.papers);
        let found = papers.iter().find(|paper| is_equal(paper.name.as_bytes(), name.as_bytes()));
        let found =
            found.ok_or_else(|| Refused(404, "this paper is not kept any more: make it anew".into()))?;
        let response = Response::new(200, "text/html; charset=utf-8", found.html.clone());
        Ok(response.with_policy(PAPER_POLICY))
    }
}
