//! `perirobot report`: a sweep as one page to read, click through, mail and print.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use perirobot_decide::cheapest::{PurchaseReport, ReasonReport};
use perirobot_decide::choose::Chosen;
use perirobot_march::{Error, Result};
use perirobot_page::report::page::{self, ReportPage};
use perirobot_page::report::purchased;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::{WholeFile, cannot_write};
use perirobot_sweep::results::manifest::Manifest;

use super::backend::BackendArgs;
use super::onlooker::{Onlooker, Shown};
use super::progress::ProgressArgs;
use super::swept::SweptArgs;

/// Write the results of a sweep as one HTML page
///
/// The page is self-contained and works offline: the assumptions, the best placements with a mounting sheet for each
/// sensor, distributions of the scores, maps of walls and ceiling, a table of the poses, and a 3D view of the cell with
/// the correct, wrong and unknown voxels of the selected pose. For chosen sets of sensors it shows their front: cost
/// against score, with the upper bound; or the answer in one sentence and the cheapest set that passes, at each speed
/// or without each requirement. It opens from a mail attachment and prints to PDF.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    #[command(flatten)]
    swept: SweptArgs,
    /// The page [default: report.html in DIR]
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// How many of the best choices of poses of each region and representation the 3D view shows voxel by voxel; for
    /// all others it shows the cell and the frustum
    #[arg(long, value_name = "N", default_value_t = page::LOOKED_AT)]
    best: usize,
    #[command(flatten)]
    backend: BackendArgs,
    #[command(flatten)]
    progress: ProgressArgs,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot report out/quick                     writes out/quick/report.html
  perirobot report out/quick --best 3            faster, and a smaller file";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    args.backend.start_threads()?;
    let folder = args.swept.folder();
    let out = args.out.clone().unwrap_or_else(|| folder.join(page::REPORT));
    if out.is_dir() {
        return Err(Error::input(format!("--out {}", out.display()), "is a folder: name a file"));
    }
    let purchase = PurchaseReport::read(folder)?;
    let (results, warnings) = match (Results::read(folder), &purchase) {
        (Err(_), Some(purchase)) if purchase.sets().is_empty() => return Err(without_set(folder, purchase)),
        (read, _) => read?,
    };
    for warning in warnings {
        say!("warning: {warning}");
    }
    // Opened first, so that a wrong path fails before the computation.
    let mut file = WholeFile::create(&out)?;
    let manifest = Manifest::read(folder)?;
    let chosen = Chosen::read(folder)?.filter(|chosen| chosen.is_of(&results));
    let purchase = purchase.filter(|purchase| purchase.is_of(&results));
    let (study, worlds) = args.swept.load()?;
    let mut backend = args.backend.open()?;
    let words = args.swept.words();
    let sweep = page::ReportedSweep {
        results: &results,
        manifest: &manifest,
        study: &study,
        worlds: &worlds,
        folder,
        folder_in_commands: folder,
        chosen: chosen.as_ref(),
        purchase: purchase.as_ref(),
        words: &words,
        note: None,
    };
    let page = ReportPage::new(sweep, args.best)?;
    let shown = match page.total() {
        0 => Shown::Nothing,
        total => Shown::Job(args.progress.start("views", 0, total)),
    };
    let onlooker = Onlooker::new(shown, None, false);
    let html = page.html(&mut *backend, &onlooker)?;
    onlooker.finish();
    file.write_all(html.as_bytes()).map_err(|e| cannot_write(&out, e))?;
    file.commit()?;
    super::print(&format!("{} ({:.1} MB)\n", out.display(), html.len() as f64 / 1e6))?;
    Ok(ExitCode::SUCCESS)
}

/// The error for an answer without a set.
fn without_set(folder: &Path, purchase: &PurchaseReport) -> Error {
    let mut what = format!("no set to show: {}", purchased::sentence(purchase, None));
    for ReasonReport { requirement, why } in &purchase.main().reasons {
        what += &format!("; {requirement:?}: {why}");
    }
    Error::input(folder, what)
}
