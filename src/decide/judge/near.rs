//! Approaches in each case: what each sensor watches is computed once for each snapshot, and combined for each case. All
//! bodies are included, named by a requirement or not, because conditions.csv has all of them. Everything is computed on
//! the host in integers.

use std::sync::Arc;

use rayon::prelude::*;

use super::alteration::Alteration;
use super::cases::{Case, Conditions, Passage};
use super::draws::Draws;
use super::scope::approach_conditions;
use super::what_if::WhatIf;
use crate::approach::{ApproachMoment, Body, Company, Ground, NearestApproach};
use crate::view::Choice;
use crate::view::watched::{WatchScene, Watcher, Watchers};
use perirobot_march::Result;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::truth::Truth;
use perirobot_study::input::{EntryPlace, EntrySpec, Study};
use perirobot_study::world::World;

/// Most cases that are put together at once.
const MOST_AT_ONCE: usize = 256;

/// Choices, by their numbers, whose bodies come near to the same by the same ways, in each scene.
pub(super) struct SharedGround<'a> {
    choices: Vec<usize>,
    grounds: Vec<Ground<'a>>,
}

impl<'a> SharedGround<'a> {
    /// What bodies come near to, and who of some choices has that in common: all, unless bodies come in through a sensor.
    /// None where the study does not ask how near.
    ///
    /// # Errors
    /// When that cannot be asked of a scene.
    pub(super) fn of_choices(what_ifs: &[WhatIf<'a>]) -> Result<Vec<SharedGround<'a>>> {
        let Some(WhatIf { study, worlds, .. }) = what_ifs.first() else { return Ok(Vec::new()) };
        if approach_conditions(study).is_empty() {
            return Ok(Vec::new());
        }
        let all: Vec<usize> = (0..what_ifs.len()).collect();
        let is_gate = |entry: &EntrySpec| matches!(entry.place, EntryPlace::Gate(_));
        let each: Vec<Vec<usize>> = match study.approach.entries.iter().any(is_gate) {
            true => all.into_iter().map(|choice| vec![choice]).collect(),
            false => vec![all],
        };
        let shared = |choices: Vec<usize>| {
            let grounds = Ground::from_scenes(study, worlds, &watchers(what_ifs, &choices))?;
            Ok(SharedGround { choices, grounds })
        };
        each.into_iter().map(shared).collect()
    }

    /// The scenes of a choice, if it is one of these.
    pub(super) fn of_choice(&self, choice: usize) -> Option<&[Ground<'a>]> {
        self.choices.contains(&choice).then_some(&self.grounds)
    }

    /// How many cases [`SharedGround::come_near`] looks at, in each scene and repeat for itself.
    pub(super) fn total(&self, what_ifs: &[WhatIf]) -> u64 {
        let companies: usize = self.grounds.iter().map(|ground| ground.companies().len()).sum();
        let of_choice = |&choice: &usize| {
            let WhatIf { study, .. } = &what_ifs[choice];
            what_ifs[choice].cases_under(&approach_conditions(study)) * u64::from(study.repeats)
        };
        self.choices.iter().map(of_choice).sum::<u64>() * companies as u64
    }

    /// Adds to the cases of each condition that asks for it how near bodies come. `conditions` are those of all choices.
    ///
    /// # Errors
    /// `Error::Stopped`.
    pub(super) fn come_near(
        &self,
        what_ifs: &[WhatIf],
        conditions: &mut [Conditions],
        draws: Option<&Draws>,
        progress: &dyn Progress,
    ) -> Result<()> {
        let study = what_ifs[self.choices[0]].study;
        let asked = approach_conditions(study);
        for ground in &self.grounds {
            for company in ground.companies() {
                let truths: Vec<Arc<Truth>> =
                    ground.worlds.iter().map(|world| company.truth(world)).collect();
                let moment = ApproachMoment::new(ground, company, ground.worlds, &truths)?;
                for repeat in 0..study.repeats as usize {
                    let scene =
                        CompanyScene::new(ground, watchers(what_ifs, &self.choices), draws, &truths, repeat);
                    let own = conditions.iter_mut().enumerate();
                    let own = own.filter(|(choice, _)| self.choices.contains(choice));
                    let mut cases: Vec<(&WhatIf, &mut Case)> = Vec::new();
                    for (choice, Conditions { passages: known, cases: all, .. }) in own {
                        known.extend(passages(ground, company, repeat));
                        let of_asked = all.iter_mut().filter(|(condition, _)| asked.contains(condition));
                        cases.extend(
                            of_asked.flat_map(|(_, cases)| cases).map(|case| (&what_ifs[choice], case)),
                        );
                    }
                    for some in cases.chunks_mut(ground.at_once().min(MOST_AT_ONCE)) {
                        progress.check_stop()?;
                        let watched = scene.watched_voxels(some);
                        let nearest = watched.par_iter().map(|watched| moment.nearest(watched));
                        let nearest: Vec<Vec<NearestApproach>> = nearest.collect();
                        some.iter_mut()
                            .zip(nearest)
                            .for_each(|((_, case), nearest)| case.near.extend(nearest));
                        progress.advance(some.len() as u64);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The sensors of some choices, each once.
fn watchers(what_ifs: &[WhatIf], choices: &[usize]) -> Vec<Watcher> {
    let mut members: Vec<[usize; 3]> =
        choices.iter().flat_map(|&choice| what_ifs[choice].members.clone()).collect();
    members.sort_unstable();
    members.dedup();
    members.iter().map(watcher).collect()
}

/// How near each body comes by each way in, of a choice as planned in the first repeat, whether or not the study requires
/// anything of that.
///
/// # Errors
/// When that cannot be asked of a scene, such as of one without a robot; `Error::Stopped`.
pub fn nearest_approaches(
    study: &Study,
    worlds: &[World],
    choice: &Choice,
    progress: &dyn Progress,
) -> Result<Vec<(Passage, NearestApproach)>> {
    let what_if = WhatIf::new(study, worlds, choice);
    let watchers: Vec<Watcher> = what_if.members.iter().map(watcher).collect();
    let mut all = Vec::new();
    for ground in &Ground::from_scenes(study, worlds, &watchers)? {
        for company in ground.companies() {
            progress.check_stop()?;
            let truths: Vec<Arc<Truth>> = ground.worlds.iter().map(|world| company.truth(world)).collect();
            let moment = ApproachMoment::new(ground, company, ground.worlds, &truths)?;
            let scene = CompanyScene::new(ground, watchers.clone(), None, &truths, choice.repeat);
            let watched = scene.watched_voxels(&[(&what_if, &mut Case::default())]).swap_remove(0);
            all.extend(passages(ground, company, choice.repeat).into_iter().zip(moment.nearest(&watched)));
        }
    }
    Ok(all)
}

fn watcher(&[sensor, candidate, representation]: &[usize; 3]) -> Watcher {
    Watcher { sensor, candidate, representation }
}

/// The ways in of a scene, body by body, as [`ApproachMoment::nearest`] has them.
pub(crate) fn passages(ground: &Ground, company: Company, repeat: usize) -> Vec<Passage> {
    let scene = ground.worlds[0].scene;
    let of = |body: &Body| {
        let entry = |entry: &EntrySpec| Passage {
            scene,
            company,
            repeat,
            body: body.name.clone(),
            on_floor: body.on_floor,
            entry: entry.name.clone(),
        };
        ground.study.approach.entries.iter().map(entry).collect::<Vec<_>>()
    };
    ground.bodies.iter().flat_map(of).collect()
}

/// A scene in some company and repeat, in which cases are looked at.
struct CompanyScene<'s> {
    ground: &'s Ground<'s>,
    truths: &'s [Arc<Truth>],
    planned: Watchers<'s>,
    drawn: Option<Drawn<'s>>,
}

/// The mounts as they were drawn.
struct Drawn<'s> {
    draws: &'s Draws,
    /// The snapshots of the scene.
    worlds: Vec<&'s World>,
    watchers: Watchers<'s>,
}

/// Sensors, each with what it watches.
type Watched = Vec<(Watcher, BitGrid)>;

impl<'s> CompanyScene<'s> {
    fn new(
        ground: &'s Ground<'s>,
        watchers: Vec<Watcher>,
        draws: Option<&'s Draws>,
        truths: &'s [Arc<Truth>],
        repeat: usize,
    ) -> CompanyScene<'s> {
        let scene = ground.worlds[0].scene;
        let drawn = draws.map(|draws| Drawn {
            draws,
            worlds: draws.worlds.iter().filter(|world| world.scene == scene).collect(),
            watchers: Watchers::from_watchers(&draws.study, watchers.clone(), repeat),
        });
        let planned = Watchers::from_watchers(ground.study, watchers, repeat);
        CompanyScene { ground, truths, planned, drawn }
    }

    /// What is watched in all snapshots in each case. Each sensor is looked at once for all cases with the same mounts.
    fn watched_voxels(&self, cases: &[(&WhatIf, &mut Case)]) -> Vec<BitGrid> {
        let drawn_in = |case: &Case| match case.alteration {
            Alteration::Draw(draw) => Some(draw),
            _ => None,
        };
        let mut mounts: Vec<Option<u32>> = cases.iter().map(|(_, case)| drawn_in(case)).collect();
        mounts.sort_unstable();
        mounts.dedup();
        let window = self.ground.worlds[0].grid.window();
        let mut all = vec![BitGrid::full(window); cases.len()];
        for (snapshot, truth) in self.truths.iter().enumerate() {
            let scene = WatchScene::new(&self.ground.worlds[snapshot], truth.clone(), window);
            for &draw in &mounts {
                let members = |what_if: &WhatIf, case: &Case| self.members(what_if, case, draw);
                let of_draw = cases.iter().filter(|(_, case)| drawn_in(case) == draw);
                let mut alive: Vec<[usize; 3]> =
                    of_draw.flat_map(|(what_if, case)| members(what_if, case)).collect();
                alive.sort_unstable();
                alive.dedup();
                let own = match (draw, &self.drawn) {
                    (Some(_), Some(drawn)) => {
                        look(&alive, &drawn.watchers, &scene.with_sensors_of(drawn.worlds[snapshot]))
                    }
                    _ => look(&alive, &self.planned, &scene),
                };
                let of_draw = all.par_iter_mut().zip(cases.par_iter());
                let of_draw = of_draw.filter(|(_, (_, case))| drawn_in(case) == draw);
                of_draw.for_each(|(plane, (what_if, case))| {
                    let members: Vec<Watcher> = members(what_if, case).iter().map(watcher).collect();
                    let watched = own.iter().filter(|(one, _)| members.contains(one));
                    plane.keep(&union(window, watched.map(|(_, watched)| watched)));
                });
            }
        }
        all
    }

    /// The members that watch in a case, as they are mounted there.
    fn members(&self, what_if: &WhatIf, case: &Case, draw: Option<u32>) -> Vec<[usize; 3]> {
        match (&case.alteration, draw, &self.drawn) {
            (_, Some(draw), Some(drawn)) => what_if.draw(drawn.draws, draw),
            (Alteration::Dead(dead), ..) => {
                let is_alive = |member: &&[usize; 3]| !dead.contains(&what_if.name(**member));
                what_if.members.iter().filter(is_alive).copied().collect()
            }
            _ => what_if.members.clone(),
        }
    }
}

/// What some sensors watch in a scene.
fn look(members: &[[usize; 3]], watchers: &Watchers, scene: &WatchScene) -> Watched {
    let one = |member| (watcher(member), watchers.watched_voxels(&watcher(member), scene));
    members.par_iter().map(one).collect()
}

fn union<'g>(window: Window, each: impl Iterator<Item = &'g BitGrid>) -> BitGrid {
    let mut all = BitGrid::new(window);
    each.for_each(|one| all.add(one));
    all
}
