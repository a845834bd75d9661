//! One page that holds a whole sweep: first what is recommended, with its numbers and a floor plan, then a section for
//! each question: what instead, where exactly, what stays blind and why, whether it is good enough, what more money
//! buys, how all places compare, what was run and assumed. It needs no other file and no network.
//!
//! # Practice
//! Text, tables and charts are written by `sections`; `scripts/*.js` show the charts of the selected score and mark what
//! is selected. They draw maps as SVG, whose size and colours follow the screen and the selection, and the cell with
//! WebGL and the viewer that the planner has, too, from names, numbers and unfolded walls that the page holds compressed. Text from the user's files reaches the page only escaped,
//! by `sections` and by what draws, or as JSON.

mod approaches;
mod cells;
mod data;
mod device;
mod document;
mod judged;
mod leaders;
mod measure;
mod missed;
mod mount;
mod packed;
mod plain_table;
mod question;
mod ranking;
mod recommended;
mod score_chart;
mod scores;
mod sections;
mod sheets;
mod sketch;
mod surroundings;
mod verdicts;

use base64::{Engine, prelude::BASE64_STANDARD as STANDARD};
use sha2::{Digest, Sha256};
use std::path::Path;

use crate::render::{Colour, Wish, draw, plan};
use crate::report::colours::variables;
use crate::viewer;
use cells::{Cells, Views};
use data::Data;
use document::Document;
use judged::JudgedChoice;
use packed::{NumberTable, pack};
use perirobot_decide::approach::Way;
use perirobot_decide::cheapest::PurchaseReport;
use perirobot_decide::choose::Chosen;
use perirobot_decide::view::View;
use perirobot_march::backend::Backend;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::manifest::Manifest;
use ranking::Ranking;
use recommended::Recommended;
use scores::Scores;
use sections::Sections;
pub use sheets::mounting_sheets;
use surroundings::Surroundings;

/// The name of the file in a sweep's folder.
pub const REPORT: &str = "report.html";

/// Default number of choices of poses of each region and representation that are shown voxel by voxel.
pub const LOOKED_AT: usize = 20;

/// Width and height of the picture for browsers without WebGL.
const PICTURE_PX: [u32; 2] = [640, 460];

/// A finished sweep with its sources.
#[derive(Clone, Copy, Debug)]
pub struct ReportedSweep<'a> {
    /// The results.
    pub results: &'a Results,
    /// The manifest: what was swept, by which runs on which devices.
    pub manifest: &'a Manifest,
    /// The study that was swept.
    pub study: &'a Study,
    /// Its scenes at their moments.
    pub worlds: &'a [World],
    /// The folder, possibly with files of `judge` and `approach`.
    pub folder: &'a Path,
    /// The folder in printed commands.
    pub folder_in_commands: &'a Path,
    /// The question and answer of a search for the best sets.
    pub chosen: Option<&'a Chosen>,
    /// The question and answer of a search for the cheapest set.
    pub purchase: Option<&'a PurchaseReport>,
    /// Arguments of the command line, besides the study, that are needed to read the same files.
    pub words: &'a [String],
    /// The note at the top of the page.
    pub note: Option<&'a str>,
}

impl ReportedSweep<'_> {
    /// Whether each set of sensors has one choice of poses, as on a front: then there are no places to compare.
    fn has_fixed_poses(&self) -> bool {
        self.results.combinations.iter().all(|combination| combination.choices() == 1)
    }
}

/// The page of a sweep, with its detailed choices of poses.
#[derive(Debug)]
pub struct ReportPage<'a> {
    sweep: ReportedSweep<'a>,
    rankings: Vec<Ranking>,
    judged: Vec<JudgedChoice>,
    recommended: Option<Recommended>,
    views: Views,
}

impl<'a> ReportPage<'a> {
    /// The page that shows the best `looked_at` choices of poses of each region and representation voxel by voxel.
    ///
    /// # Errors
    /// Those of a journal that cannot be read.
    pub fn new(sweep: ReportedSweep<'a>, looked_at: usize) -> Result<ReportPage<'a>> {
        let rankings = ranking::rankings(sweep.results)?;
        let judged = judged::judged_choices(&sweep)?;
        let recommended = recommended::recommend(&sweep, &rankings, &judged)?;
        let views = Views::new(sweep.results, &rankings, recommended.as_ref(), looked_at)?;
        Ok(ReportPage { sweep, rankings, judged, recommended, views })
    }

    /// The number of views in [`ReportPage::html`].
    pub fn total(&self) -> u64 {
        self.views.total()
    }

    /// The page as HTML. A backend computes its views; `progress` advances by each.
    ///
    /// # Errors
    /// Those of the backend, and of a journal that cannot be read; `Error::Stopped`.
    pub fn html(&self, backend: &mut dyn Backend, progress: &dyn Progress) -> Result<String> {
        let ReportPage { sweep, rankings, judged, recommended, views } = self;
        let ReportedSweep { results, study, worlds, .. } = *sweep;
        let recommended = recommended.as_ref();
        let cells = views.look((study, worlds), (results, rankings), backend, progress)?;
        let picture = recommended.map(|one| picture(sweep, rankings, one, backend)).transpose()?;
        let surroundings = Surroundings::new(study, &worlds[0])?;
        // A cell without computable ways still gets its report.
        let (ways, refused) = match recommended.map(|one| approaches::ways(sweep, one.choice(rankings))) {
            Some(Err(refused)) => (Vec::new(), Some(refused.to_string())),
            Some(Ok(ways)) => (ways, None),
            None => (Vec::new(), None),
        };
        let mut numbers = NumberTable::default();
        let scores = scores::scores(results, rankings, &mut numbers)?;
        let findings = Findings {
            sweep: *sweep,
            rankings,
            scores: &scores,
            recommended,
            judged,
            cells: &cells,
            surroundings: &surroundings,
            ways: &ways,
            refused,
        };
        let data = serde_json::to_vec(&Data::new(&findings))
            .map_err(|e| Error::input(REPORT, format!("cannot be made: {e}")))?;
        let script = script();
        let sections = Sections::new(&findings, picture)?;
        let document = Document {
            title: question::title(sweep),
            note: sweep.note,
            study: study.path.file_stem().unwrap_or_default().to_string_lossy().into(),
            day: now("%Y-%m-%d"),
            charts: pack(sections.other_charts().into_string().as_bytes()),
            sections,
            policy: policy(&script),
            style: [
                &variables(),
                plan::STYLE,
                viewer::STYLE,
                include_str!("../charts/chart.css"),
                include_str!("style.css"),
            ]
            .concat(),
            patterns: plan::PATTERNS,
            script,
            data: pack(&data),
            numbers: numbers.pack(),
            cells: pack(&cells.bytes),
        };
        Ok(document.text())
    }
}

/// The inputs of the page.
struct Findings<'a> {
    sweep: ReportedSweep<'a>,
    rankings: &'a [Ranking],
    /// The scores of each ranking.
    scores: &'a [Scores],
    /// The recommended choice; `None` if no choice has a score.
    recommended: Option<&'a Recommended>,
    judged: &'a [JudgedChoice],
    cells: &'a Cells,
    surroundings: &'a Surroundings,
    /// The ways of bodies for the recommended choice, scene by scene.
    ways: &'a [Vec<Way>],
    /// Why they cannot be computed.
    refused: Option<String>,
}

/// The local time of the machine.
fn now(format: &str) -> String {
    chrono::DateTime::<chrono::Utc>::from(std::time::SystemTime::now()).format(format).to_string()
}

/// Draws the recommended choice at its worst moment, by `render`.
fn picture(
    sweep: &ReportedSweep,
    rankings: &[Ranking],
    recommended: &Recommended,
    backend: &mut dyn Backend,
) -> Result<String> {
    let choice = recommended.choice(rankings);
    let world = &sweep.worlds[recommended.moments[recommended.scene]];
    let view = View::new(sweep.study, world, choice, backend)?;
    let wish = Wish { size_px: PICTURE_PX, colour: Colour::Label, ..Wish::default() };
    let png = draw(world, Some(&view), &wish, backend)?.png()?;
    Ok(format!("data:image/png;base64,{}", STANDARD.encode(png)))
}

/// The message of a browser that cannot run the script, usually an old one.
const FAILED: &str = r#"function failed(error) {
  const failure = document.getElementById("failure");
  failure.hidden = false;
  failure.textContent = `The plots cannot be drawn: ${error.message}. The tables are complete without.`;
  throw error;
}"#;

/// The parts of the script, in order.
fn script() -> String {
    let own = [
        include_str!("scripts/read.js"),
        include_str!("scripts/choice.js"),
        include_str!("scripts/svg.js"),
        include_str!("scripts/plots.js"),
        include_str!("scripts/maps.js"),
        include_str!("scripts/cell.js"),
        include_str!("scripts/causes.js"),
        include_str!("scripts/table.js"),
        include_str!("scripts/page.js"),
    ];
    let parts = [&viewer::SCRIPTS[..], &own].concat().join("\n");
    format!("{FAILED}\n(async () => {{\n\"use strict\";\n{parts}}})().catch(failed);\n")
}

/// The content security policy, effective against any untrusted text in the page: run only this script, and fetch
/// nothing.
fn policy(script: &str) -> String {
    let script = STANDARD.encode(Sha256::digest(script.as_bytes()));
    format!(
        "default-src 'none'; script-src 'sha256-{script}'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; \
         form-action 'none'"
    )
}
