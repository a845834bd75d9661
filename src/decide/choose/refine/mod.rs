//! Finer positions and angles around the poses of the best sets.
//!
//! # Theory
//! A lattice of poses represents a part of a wall and all orientations there. Poses half a step away in each direction
//! are cast around each sensor of a set, and the best set of all of these is searched, and again around that one, until
//! there is no gain; then poses a quarter of a step away, and so on. The result has no proof.
//!
//! # Practice
//! `around` has the poses around a set, this file casts and searches them, and `counted` counts the result again, like
//! a sweep of a study with these poses.

mod around;
mod counted;

use std::collections::BTreeMap;

use self::around::{Around, LEVELS, RefineSpot};
use super::evidence::Casting;
use super::report::{FrontReport, RefinedReport};
use crate::choose::{problem_of, wanted_counts};
use perirobot_cover::{FrontAnswer, Problem, SetLimits, Worth, best_within, overlaps, polish};
use perirobot_march::backend::factory::{BackendFactory, Fallback, KeptBackends};
use perirobot_march::progress::{Fault, Progress, SearchState};
use perirobot_march::{Error, Result};
use perirobot_study::input::{Choose, Study};
use perirobot_study::world::World;
use perirobot_sweep::scoring::Failover;

/// Of sets of so many sensors the best of all around is searched; of larger ones what changes of one or two lead to.
const SEARCHED: usize = 4;
/// Most rounds around one set: noise is drawn anew in each, so that something might be gained again and again.
const MOST_ROUNDS: usize = 200;

/// What refining found.
pub struct Refinement {
    /// The sets around which something was looked for, and what was gained.
    pub told: Vec<RefinedReport>,
    /// The study with the poses that were found, and its worlds; `None` where nothing was gained.
    pub with_poses: Option<(Study, Vec<World>)>,
    /// Whether it ended by itself.
    pub complete: bool,
}

/// Where the sensors of a set are now, after how much work.
struct Refined {
    limits: SetLimits,
    /// The set of listed poses that it began with.
    listed: Vec<RefineSpot>,
    spots: Vec<RefineSpot>,
    /// What they are worth by what was cast, if anything was gained.
    worth: Option<Worth>,
    rounds: usize,
    cast: usize,
}

/// Refines the best set of each size: the best two are seldom two of the best three, and whoever reads the front wants
/// to know of each size what finer poses are worth.
///
/// # Errors
/// When a backend fails, or counts otherwise than what was cast; when the evidence of the poses around a set does not
/// fit so many bytes.
pub fn refine(
    (study, choose, worlds): (&Study, &Choose, &[World]),
    (problem, answer, told): (&Problem, &FrontAnswer, &FrontReport),
    memory_bytes: u64,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Refinement> {
    let (mut kept, quiet) = (KeptBackends::new(&mut *backends), Quiet(progress));
    let (failover, around) = (Failover::new(&mut kept, &quiet), Around::new(study, worlds));
    let mut refining = Refining { choose, around, memory_bytes, failover, progress };
    let mut all: Vec<Refined> = Vec::new();
    // Of the steps of a size the first has the whole budget.
    for steps in answer.steps.chunk_by(|a, b| a.limits.at_most == b.limits.at_most) {
        let Some(best) = &steps[0].best else { continue };
        let listed: Vec<RefineSpot> =
            best.set.iter().map(|&item| RefineSpot::from_candidate(problem.evidence.items[item])).collect();
        if all.iter().all(|earlier| earlier.listed != listed) && !progress.stops() {
            all.push(refining.refine(steps[0].limits, listed)?);
        }
    }
    let mut cpu = backends.open(Fallback::Cpu)?;
    let counted = counted::count_refined((study, choose, worlds), told, &all, cpu.as_mut())?;
    Ok(Refinement { complete: !progress.stops(), ..counted })
}

struct Refining<'a> {
    choose: &'a Choose,
    around: Around<'a>,
    memory_bytes: u64,
    failover: Failover<'a>,
    progress: &'a dyn Progress,
}

impl Refining<'_> {
    /// The best that was found around a set.
    fn refine(&mut self, limits: SetLimits, listed: Vec<RefineSpot>) -> Result<Refined> {
        let mut refined = Refined { limits, spots: listed.clone(), listed, worth: None, rounds: 0, cast: 0 };
        let mut level = 1;
        while level <= LEVELS && refined.rounds < MOST_ROUNDS && !self.progress.stops() {
            if !self.gains(&mut refined, level)? {
                level += 1;
            }
        }
        Ok(refined)
    }

    /// Casts what is around a set, and moves to a better one if there is any.
    fn gains(&mut self, refined: &mut Refined, level: u32) -> Result<bool> {
        let fixed = &self.choose.always;
        let spots = self.around.all(&refined.spots, |spot| !spot.is_listed(fixed), level);
        if spots.len() == refined.spots.len() {
            return Ok(false);
        }
        let study = self.around.study_of(&spots);
        let worlds = self.around.worlds_of(&spots);
        let place = |spot: RefineSpot| spots.iter().position(|other| *other == spot);
        let item = |spot| place(spot).expect("a set is among what is around it");
        let numbers: Vec<usize> = around::numbers(&spots);
        let always = fixed.iter().map(|&listed| {
            let spot = item(RefineSpot::from_candidate(listed));
            [spots[spot].sensor, numbers[spot]]
        });
        let choose =
            Choose { always: always.collect(), at_most: refined.limits.at_most, ..self.choose.clone() };
        let (regions, ways) = ([wanted_counts(&choose)], &choose.representations);
        let mut casting = Casting::begin(&study, &regions, ways, &worlds, self.memory_bytes, None)
            .map_err(|error| error.with_place("choose.refine"))?;
        match casting.run_on(&mut self.failover) {
            Err(Error::Stopped(_)) => return Ok(false),
            other => other?,
        }
        (refined.rounds, refined.cast) = (refined.rounds + 1, refined.cast + spots.len());
        let evidence = casting.evidence().pop().expect("one region was asked for");
        let problem = problem_of(&study, &choose, &worlds, &evidence);
        let centre: Vec<usize> = refined.spots.iter().map(|&spot| item(spot)).collect();
        // With noise of another draw it may fail what is required.
        let Some(centre) = problem.evaluate(&centre) else { return Ok(false) };
        let (stop, stops) = (|| self.progress.stop_reason(), || self.progress.stops());
        let better = match refined.limits.at_most <= SEARCHED || !problem.is_searchable() {
            true => {
                let mut known = BTreeMap::from([(centre.set.clone(), centre.worth)]);
                let kept = overlaps(&problem);
                best_within(&problem, refined.limits, kept.as_ref(), &mut known, &stop).best
            }
            false => Some(polish(&problem, refined.limits, None, centre.clone(), &stops)),
        };
        let Some(better) = better.filter(|better| better.worth > centre.worth) else { return Ok(false) };
        let state = refined.limits.state(Some(&better));
        // Its candidates are those around the set, not the study's.
        self.progress.show_search(&SearchState { set: Vec::new(), ..state });
        refined.spots = better.set.iter().map(|&item| spots[item]).collect();
        refined.worth = Some(better.worth);
        Ok(true)
    }
}

/// Shows nothing but failures of devices, since how many poses are cast around a set is unknown.
struct Quiet<'a>(&'a dyn Progress);

impl Progress for Quiet<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.0.stop_reason()
    }

    fn show_fault(&self, fault: &Fault) {
        self.0.show_fault(fault);
    }
}
