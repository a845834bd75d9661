//! The best set of sensors, found, proven, and checked again, as `perirobot choose` does it.

use std::path::Path;
use std::time::Instant;

use perirobot_cover::CandidateEvidence;
use perirobot_decide::choose::{
    Casting, Chosen, Claims, FrontReport, MEMORY_BYTES, Outcome, Verified, VerifyWatch, answer, examine,
    problem_of, refine, verify,
};
use perirobot_march::backend::factory::BackendFactory;
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_study::study::{Choose, Study};
use perirobot_study::world::World;

use crate::backends::{BackendWords, opened};
use crate::watch::Listener;

/// One in so many choices of poses that a GPU casts is cast again on the CPU.
const CHECKED: u64 = 500;

/// Finds the best sets, and writes what `perirobot choose` writes: the answer, and a sweep of its sets.
pub(crate) fn search(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    out: &Path,
) -> Result<()> {
    let (choose, begin) = (asked(study)?, Instant::now());
    examine(study, choose, worlds)?;
    let folder = Chosen::folder(out, study)?;
    let mut backends = opened(words, listener)?;
    let prepare_s = begin.elapsed().as_secs_f64();
    let evidence = cast(study, choose, worlds, &mut backends, listener)?;
    let problem = problem_of(study, choose, worlds, &evidence);
    listener.begins("sets", 0);
    let found = answer(&problem, listener)?;
    listener.go_on()?;
    let (mut told, mut with_poses) = (FrontReport::new(study, worlds, &problem, &found), None);
    if choose.refine {
        let asked = (study, choose, worlds);
        let refined = refine(asked, (&problem, &found, &told), MEMORY_BYTES, &mut backends, listener)?;
        listener.go_on()?;
        (told.refined, with_poses) = (Some(refined.told), refined.with_poses);
    }
    let outcome = Outcome::new((study, choose, worlds), told, with_poses);
    listener.begins("sets", outcome.total());
    let command = ["perirobot.Study.choose".to_string()];
    outcome.write(folder, &mut backends, (CHECKED, prepare_s), &command, &mut &*listener).map(drop)
}

/// Checks what [`search`] wrote: how many sets were counted again, and how many steps are proven again, bounded, open.
pub(crate) fn check(
    study: &Study,
    worlds: &[World],
    words: &BackendWords,
    listener: &Listener,
    folder: &Path,
) -> Result<[usize; 4]> {
    let choose = asked(study)?;
    examine(study, choose, worlds)?;
    let claims = Claims::read(folder, study, choose, worlds)?;
    let mut backends = opened(words, listener)?;
    let evidence = cast(study, choose, worlds, &mut backends, listener)?;
    let backends: (&mut dyn BackendFactory, u64) = (&mut backends, MEMORY_BYTES);
    let Verified { sets, proven, bounded, open, .. } =
        verify(&claims, (study, choose, worlds), &evidence, backends, (listener, listener))?;
    Ok([sets, proven, bounded, open])
}

fn asked(study: &Study) -> Result<&Choose> {
    study.choose.as_ref().ok_or_else(|| {
        let wanted = "say what is looked for, as in objective=\"f1\", region=\"robot\", at_most=3";
        Error::from(Issue::missing("choose").at(&study.path)).wanted(wanted)
    })
}

/// What every candidate says, in memory.
fn cast(
    study: &Study,
    choose: &Choose,
    worlds: &[World],
    backends: &mut dyn BackendFactory,
    mut listener: &Listener,
) -> Result<CandidateEvidence> {
    let mut casting = Casting::begin(study, choose, worlds, MEMORY_BYTES, None)?;
    listener.begins("poses", casting.total());
    casting.run_on(backends, &mut listener)?;
    Ok(casting.checked(choose, backends, CHECKED)?.0)
}

impl VerifyWatch for Listener {
    fn stop(&self) -> Option<String> {
        Listener::stop(self)
    }

    fn begins(&self, steps: usize) {
        Listener::begins(self, "steps", steps as u64);
    }

    fn checked(&self) {
        self.finished(1);
    }
}
