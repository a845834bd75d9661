//! The cheapest set that passes, found, judged, and checked again, as `perirobot choose` does it.

use std::path::Path;
use std::time::Instant;

use perirobot_decide::cheapest::{PurchaseOutcome, PurchaseReport, PurchaseVerified, Purchasing};
use perirobot_decide::choose::MEMORY_BYTES;
use perirobot_decide::judge::{Judging, SetVerdicts, Verdicts};
use perirobot_decide::view::Choice;
use perirobot_march::error::Issue;
use perirobot_march::progress::Progress;
use perirobot_march::{Error, Result};
use perirobot_page::report::purchased;
use perirobot_study::input::{Purchase, Study, Wanted};
use perirobot_study::world::World;
use perirobot_sweep::scoring::check::ONE_IN;

use crate::backends::{BackendWords, open};
use crate::watch::Listener;

/// Finds the cheapest sets, and writes what `perirobot choose` writes: the answer, a sweep of its sets, and the verdicts
/// on them.
pub(crate) fn search(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    out: &Path,
) -> Result<()> {
    let begin = Instant::now();
    let purchase = purchase_of(study)?;
    let purchasing = Purchasing::new(study, purchase, worlds, MEMORY_BYTES)?;
    let folder = PurchaseOutcome::folder(out, study)?;
    let casting = purchasing.begin_casting(None, false)?;
    let mut backends = open(words, listener)?;
    let prepare_s = begin.elapsed().as_secs_f64();
    listener.begins("poses", casting.total());
    let evidence = casting.finish(&mut backends, ONE_IN, listener)?.of_regions;
    if purchasing.looks() > 0 {
        listener.begins("looks", purchasing.looks());
    }
    let ways = purchasing.look(listener)?;
    listener.begins("sets", 0);
    let report = purchasing.search(&evidence, &ways, &|| open(words, listener), listener)?;
    // What Python stopped is not written.
    listener.check_stop()?;
    let outcome = PurchaseOutcome::new((study, purchase, worlds), report);
    if outcome.total() > 0 {
        listener.begins("sets", outcome.total());
    }
    let command = ["perirobot.Study.cheapest".to_string()];
    let results = outcome.write(folder, &mut backends, (ONE_IN, prepare_s), &command, listener)?;
    let Some(results) = results else { return Ok(()) };
    let choice = |combination| Choice { combination, choice: 0, representation: 0, repeat: 0 };
    let choices: Vec<Choice> = (0..outcome.sets.combinations.len()).map(choice).collect();
    let judging = Judging::new(&outcome.sets, worlds, &results, &choices)?;
    judging.warnings.iter().for_each(|warning| listener.warns_of_study(warning.clone()));
    if judging.total() > 0 {
        listener.begins("cases", judging.total());
    }
    let judged = judging.judge(&|| open(words, listener), listener)?;
    judged.caveats().into_iter().for_each(|caveat| listener.warns_of_study(caveat.into()));
    outcome.agrees(&judged.sets)?;
    judging.write(out, &judged).map(drop)
}

/// Checks what [`search`] wrote: how many sets were judged again, ways in followed again, claims searched again, and
/// how many claims are open.
pub(crate) fn check(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<[usize; 4]> {
    let purchasing = Purchasing::new(study, purchase_of(study)?, worlds, MEMORY_BYTES)?;
    let claims = purchasing.read_claims(folder)?;
    let casting = purchasing.begin_casting(None, false)?;
    let mut backends = open(words, listener)?;
    listener.begins("poses", casting.total());
    let evidence = casting.finish(&mut backends, ONE_IN, listener)?.of_regions;
    listener.begins("points", claims.points() as u64);
    let PurchaseVerified { sets, ways, proven, open: unproven, .. } =
        purchasing.verify(&claims, &evidence, &|| open(words, listener), listener)?;
    Ok([sets, ways, proven, unproven])
}

/// The answer in a folder in one sentence.
pub(crate) fn sentence(folder: &Path) -> Result<String> {
    let Some(report) = PurchaseReport::read(folder)? else {
        let cure = "name a folder that Study.cheapest or `perirobot choose` wrote";
        return Err(Issue::says("has no cheapest.json").with_advice(cure).with_place(folder).into());
    };
    let judged = Verdicts::read(folder)?.map_or(Vec::new(), |verdicts| verdicts.sets);
    let poses = report.recommended().map(|set| set.poses());
    let own = judged.iter().find(|set: &&SetVerdicts| Some(&set.poses) == poses.as_ref());
    Ok(purchased::sentence(&report, own))
}

/// What a study asks for, if that is the cheapest set.
fn purchase_of(study: &Study) -> Result<&Purchase> {
    match &study.choose {
        Some(Wanted::Cheapest(purchase)) => Ok(purchase),
        _ => Err(Error::from(
            Issue::says("[choose] asks for no cheapest set")
                .with_advice("say objective=\"cost\"")
                .with_place(&study.path),
        )),
    }
}
