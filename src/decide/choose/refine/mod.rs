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

/// Up to this size, the best of all sets around one is searched; above, only changes of one or two sensors.
const SEARCHED: usize = 4;
/// Most rounds around one set: noise is drawn anew in each, so gains might never end.
const MOST_ROUNDS: usize = 200;

/// The result of refining.
pub struct Refinement {
    /// The refined sets, and their gains.
    pub told: Vec<RefinedReport>,
    /// The study with the found poses, and its worlds; `None` without gain.
    pub with_poses: Option<(Study, Vec<World>)>,
    /// Whether it was complete.
    pub complete: bool,
}

/// The current spots of a set, and the work done.
struct Refined {
    limits: SetLimits,
    /// The original set of listed poses.
    listed: Vec<RefineSpot>,
    spots: Vec<RefineSpot>,
    /// Their worth in the search, if there was a gain.
    worth: Option<Worth>,
    rounds: usize,
    cast: usize,
}

/// Refines the best set of each size: the best two are seldom two of the best three, and a reader of the front wants to
/// know the gain of finer poses for each size.
///
/// # Errors
/// If a backend fails or disagrees with the evidence; if the evidence of the poses around a set exceeds the memory
/// limit.
pub fn refine(
    (study, choose, worlds): (&Study, &Choose, &[World]),
    (problem, answer, front): (&Problem, &FrontAnswer, &FrontReport),
    memory_bytes: u64,
    backends: &mut dyn BackendFactory,
    progress: &dyn Progress,
) -> Result<Refinement> {
    let (mut kept, quiet) = (KeptBackends::new(&mut *backends), Quiet(progress));
    let (failover, around) = (Failover::new(&mut kept, &quiet), Around::new(study, worlds));
    let mut refining = Refining { choose, around, memory_bytes, failover, progress };
    let mut all: Vec<Refined> = Vec::new();
    // The first step of a size has the whole budget.
    for steps in answer.steps.chunk_by(|a, b| a.limits.at_most == b.limits.at_most) {
        let Some(best) = &steps[0].best else { continue };
        let listed: Vec<RefineSpot> =
            best.set.iter().map(|&item| RefineSpot::from_candidate(problem.evidence.items[item])).collect();
        if all.iter().all(|earlier| earlier.listed != listed) && !progress.stops() {
            all.push(refining.refine(steps[0].limits, listed)?);
        }
    }
    let mut cpu = backends.open(Fallback::Cpu)?;
    let counted = counted::count_refined((study, choose, worlds), front, &all, cpu.as_mut())?;
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
    /// The best set found around a set.
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

    /// Casts the poses around a set, and moves to a better one, if any.
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
        // With noise of another draw it may miss the requirements.
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

/// Shows only failures of devices, since the number of poses cast around a set is unknown.
struct Quiet<'a>(&'a dyn Progress);

impl Progress for Quiet<'_> {
    fn stop_reason(&self) -> Option<String> {
        self.0.stop_reason()
    }

    fn show_fault(&self, fault: &Fault) {
        self.0.show_fault(fault);
    }
}
