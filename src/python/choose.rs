//! The best set of sensors, found, proven, and checked again, as `perirobot choose` does it.

use std::path::Path;
use std::time::Instant;

use perirobot::backend::factory::{BackendFactory, Fallback};
use perirobot::backend::oracle::Oracle;
use perirobot::choose::{
    CandidateEvidence, Casting, CastingWatch, Chosen, Claims, MEMORY_BYTES, Problem, RefineWatch,
    SearchWatch, Told, Verified, answer, examine, refine, verify, verify_refined,
};
use perirobot::error::Issue;
use perirobot::results::journal::Shard;
use perirobot::results::manifest::Fault;
use perirobot::results::table::TableFormat;
use perirobot::results::{Results, Subject, rows, scores};
use perirobot::study::Choose;
use perirobot::sweep::Watch;
use perirobot::sweep::session::Session;
use perirobot::world::World;
use perirobot::{Error, Result, Study};

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
    let mut backends = opened(words)?;
    let evidence = cast(study, choose, worlds, &mut backends, listener)?;
    let problem = Problem::new(study, choose, worlds, &evidence);
    let found = answer(&problem, listener)?;
    listener.go_on()?;
    let (mut told, mut with_poses) = (Told::of(study, worlds, &problem, &found), None);
    if choose.refine {
        let asked = (study, choose, worlds);
        let refined = refine(asked, (&problem, &found, &told), MEMORY_BYTES, &mut backends, listener)?;
        listener.go_on()?;
        (told.refined, with_poses) = (Some(refined.told), refined.with_poses);
    }
    let (of_sets, in_worlds) =
        with_poses.as_ref().map_or((study, worlds), |(study, worlds)| (study, worlds.as_slice()));
    let sets = told.study_of_sets(of_sets, choose);
    let chosen = Chosen::new(study, choose, worlds, told);
    chosen.write(out)?;
    let command = ["perirobot.Study.choose".to_string()];
    let mut session = Session::open(&sets, in_worlds, out, Shard::WHOLE, true, &command)?;
    session.run(&mut backends, CHECKED, begin.elapsed().as_secs_f64(), &mut &*listener)?;
    let results = Results::new(Subject::of_study(&sets, in_worlds), session.into_pages());
    chosen.told.agrees(choose, &results)?;
    rows::write(&results, out, TableFormat::Csv)?;
    scores::write(&results, out, TableFormat::Csv)
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
    let claims = Claims::read(folder, study, choose, worlds)?;
    let evidence = cast(study, choose, worlds, &mut opened(words)?, listener)?;
    let (mut oracle, stop) = (Oracle::default(), || listener.stop());
    let checked = verify(&claims, study, choose, worlds, &evidence, &mut oracle, &stop)?;
    let Verified { sets, proven, bounded, open, .. } = checked;
    let refined = verify_refined(folder, study, choose, &mut oracle)?;
    Ok([sets + refined, proven, bounded, open])
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
    casting.run_on(backends, &mut listener)?;
    let evidence = casting.evidence();
    if backends.needs_check() {
        let mut cpu = backends.open(Fallback::Cpu)?;
        evidence.check(study, choose, worlds, cpu.as_mut(), CHECKED)?;
    }
    Ok(evidence)
}

impl CastingWatch for &Listener {
    fn cast(&mut self, more: u64) {
        self.finished(more);
    }

    fn stop(&mut self) -> Option<String> {
        Listener::stop(self)
    }

    fn failed(&mut self, fault: &Fault) {
        Watch::failed(self, fault);
    }
}

impl SearchWatch for Listener {
    fn stops(&self) -> bool {
        self.stops_now_and_then()
    }
}

impl RefineWatch for Listener {
    fn failed(&self, fault: &Fault) {
        self.tell_of(fault);
    }
}
