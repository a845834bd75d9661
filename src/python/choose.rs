//! The best set of sensors, found, proven, and checked again, as `perirobot choose` does it.

use std::path::Path;
use std::time::Instant;

use perirobot_decide::cheapest::PurchaseReport;
use perirobot_decide::choose::{Choosing, Found, MEMORY_BYTES, SearchEnding, Verified};
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_study::input::Study;
use perirobot_study::world::World;
use perirobot_sweep::scoring::check::ONE_IN;

use crate::backends::{BackendWords, open};
use crate::watch::Listener;

/// Finds the best sets, and writes what `perirobot choose` writes: the answer, and a sweep of its sets.
pub(crate) fn search(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    out: &Path,
) -> Result<()> {
    let begin = Instant::now();
    let choosing = Choosing::new(study, worlds, MEMORY_BYTES)?;
    PurchaseReport::forget(out)?;
    let folder = choosing.open(out)?;
    let casting = choosing.begin_casting(None, false)?;
    let mut backends = open(words, listener)?;
    let prepare_s = begin.elapsed().as_secs_f64();
    listener.begins("poses", casting.total());
    let evidence = casting.finish(&mut backends, ONE_IN, listener)?.of_regions.remove(0);
    listener.begins("sets", 0);
    let found = choosing.search(&evidence, &mut backends, listener)?;
    // What Python stopped is not written.
    listener.check_stop()?;
    let Some(Found { outcome, ending }) = found else { return Ok(()) };
    if let SearchEnding::Failed(error) = ending {
        return Err(error);
    }
    listener.begins("sets", outcome.total());
    let command = ["perirobot.Study.choose".to_string()];
    outcome.write(folder, &mut backends, (ONE_IN, prepare_s), &command, listener).map(drop)
}

/// Checks what [`search`] wrote: how many sets were counted again, and how many steps are proven again, bounded, open.
pub(crate) fn check(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<[usize; 4]> {
    let choosing = Choosing::new(study, worlds, MEMORY_BYTES)?;
    let claims = choosing.read_claims(folder)?;
    let casting = choosing.begin_casting(None, false)?;
    let mut backends = open(words, listener)?;
    listener.begins("poses", casting.total());
    let evidence = casting.finish(&mut backends, ONE_IN, listener)?.of_regions.remove(0);
    listener.begins("steps", claims.steps() as u64);
    let Verified { sets, proven, bounded, open, .. } =
        choosing.verify(&claims, &evidence, &mut backends, listener)?;
    Ok([sets, proven, bounded, open])
}
