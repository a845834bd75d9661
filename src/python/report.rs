//! The page of a folder of results, as `perirobot report` writes it.

use std::io::Write;
use std::path::Path;

use perirobot_decide::cheapest::PurchaseReport;
use perirobot_decide::choose::{Chosen, as_swept};
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendFactory, Fallback};
use perirobot_page::report::page::{LOOKED_AT, ReportPage, ReportedSweep};
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::results::Results;
use perirobot_sweep::results::files::{WholeFile, cannot_write};
use perirobot_sweep::results::manifest::Manifest;

use crate::backends::{BackendWords, open};
use crate::watch::Listener;

/// Writes the page of a folder. `best` is how many of the best choices it shows voxel by voxel.
pub(crate) fn report(
    (study, worlds): (&Study, &[World]),
    folder: &Path,
    (out, best): (&Path, Option<usize>),
    backend: &BackendWords,
    listener: &Listener,
) -> Result<()> {
    let (results, warnings) = Results::read(folder)?;
    warnings.into_iter().for_each(|warning| listener.warns_of_study(warning));
    // Checked first, so that nothing is computed in vain.
    let mut file = WholeFile::create(out)?;
    let manifest = Manifest::read(folder)?;
    let chosen = Chosen::read(folder)?.filter(|chosen| chosen.is_of(&results));
    let purchase = PurchaseReport::read(folder)?.filter(|purchase| purchase.is_of(&results));
    let (study, worlds) = as_swept(folder, study.clone(), worlds.to_vec())?;
    let sweep = ReportedSweep {
        results: &results,
        manifest: &manifest,
        study: &study,
        worlds: &worlds,
        folder,
        folder_in_commands: folder,
        chosen: chosen.as_ref(),
        purchase: purchase.as_ref(),
        words: &[],
        note: None,
    };
    let page = ReportPage::new(sweep, best.unwrap_or(LOOKED_AT))?;
    listener.begins("views", page.total());
    let mut backend = open(backend, listener)?.open(Fallback::None)?;
    let html = page.html(&mut *backend, listener)?;
    file.write_all(html.as_bytes()).map_err(|e| cannot_write(out, e))?;
    file.commit()
}
