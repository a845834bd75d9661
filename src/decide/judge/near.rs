//! How near bodies come unnoticed in each case: each sensor is looked at once in each snapshot, and what they watch
//! is put together anew for each case. All bodies are asked, also those that no requirement names, since conditions.csv
//! tells of all. All of it is whole numbers, and computed on the host.

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
use perirobot_study::input::{EntrySpec, Study};
use perirobot_study::world::World;

/// Most cases that are put together at once.
const MOST_AT_ONCE: usize = 256;

impl<'a> WhatIf<'a> {
    /// What bodies come near to and by which ways, in each scene; none where the study does not ask how near.
    ///
    /// # Errors
    /// When that cannot be asked of a scene.
    pub fn grounds(&self) -> Result<Vec<Ground<'a>>> {
        match approach_conditions(self.study).is_empty() {
            true => Ok(Vec::new()),
            false => Ground::from_scenes(self.study, self.worlds, &self.watchers()),
        }
    }

    /// How many cases [`WhatIf::come_near`] looks at, in each scene and repeat for itself.
    pub fn total_near(&self, grounds: &[Ground]) -> u64 {
        let companies: usize = grounds.iter().map(|ground| ground.companies().len()).sum();
        let cases = self.cases_under(&approach_conditions(self.study));
        cases * companies as u64 * u64::from(self.study.repeats)
    }

    /// Adds to the cases of each condition that asks for it how near bodies come.
    ///
    /// # Errors
    /// `Error::Stopped`.
    pub fn come_near(
        &self,
        grounds: &[Ground],
        conditions: &mut Conditions,
        draws: Option<&Draws>,
        progress: &dyn Progress,
    ) -> Result<()> {
        let asked = approach_conditions(self.study);
        let of_asked = conditions.cases.iter_mut().filter(|(condition, _)| asked.contains(condition));
        let mut cases: Vec<&mut Case> = of_asked.flat_map(|(_, cases)| cases).collect();
        for ground in grounds {
            for company in ground.companies() {
                let truths: Vec<Arc<Truth>> =
                    ground.worlds.iter().map(|world| company.truth(world)).collect();
                let moment = ApproachMoment::new(ground, company, ground.worlds, &truths)?;
                for repeat in 0..self.study.repeats as usize {
                    let scene = CompanyScene::new(self, ground, draws, &truths, repeat);
                    conditions.passages.extend(passages(ground, company, repeat));
                    for some in cases.chunks_mut(ground.at_once().min(MOST_AT_ONCE)) {
                        progress.check_stop()?;
                        let watched = scene.watched_voxels(some);
                        let nearest = watched.par_iter().map(|watched| moment.nearest(watched));
                        let nearest: Vec<Vec<NearestApproach>> = nearest.collect();
                        some.iter_mut().zip(nearest).for_each(|(case, nearest)| case.near.extend(nearest));
                        progress.advance(some.len() as u64);
                    }
                }
            }
        }
        Ok(())
    }

    fn watchers(&self) -> Vec<Watcher> {
        self.members.iter().map(watcher).collect()
    }
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
    let mut all = Vec::new();
    for ground in &Ground::from_scenes(study, worlds, &what_if.watchers())? {
        for company in ground.companies() {
            progress.check_stop()?;
            let truths: Vec<Arc<Truth>> = ground.worlds.iter().map(|world| company.truth(world)).collect();
            let moment = ApproachMoment::new(ground, company, ground.worlds, &truths)?;
            let scene = CompanyScene::new(&what_if, ground, None, &truths, choice.repeat);
            let watched = scene.watched_voxels(&[&mut Case::default()]).swap_remove(0);
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
    what_if: &'s WhatIf<'s>,
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

impl<'s> CompanyScene<'s> {
    fn new(
        what_if: &'s WhatIf<'s>,
        ground: &'s Ground<'s>,
        draws: Option<&'s Draws>,
        truths: &'s [Arc<Truth>],
        repeat: usize,
    ) -> CompanyScene<'s> {
        let scene = ground.worlds[0].scene;
        let planned = Watchers::from_watchers(what_if.study, what_if.watchers(), repeat);
        let drawn = draws.map(|draws| Drawn {
            draws,
            worlds: draws.worlds.iter().filter(|world| world.scene == scene).collect(),
            watchers: Watchers::from_watchers(&draws.study, what_if.watchers(), repeat),
        });
        CompanyScene { what_if, ground, truths, planned, drawn }
    }

    /// What is watched in all snapshots in each case.
    fn watched_voxels(&self, cases: &[&mut Case]) -> Vec<BitGrid> {
        let names = self.what_if.names();
        let is_drawn = |case: &Case| matches!(case.alteration, Alteration::Draw(_));
        let some_planned = cases.iter().any(|case| !is_drawn(case));
        let window = self.ground.worlds[0].grid.window();
        let mut all = vec![BitGrid::full(window); cases.len()];
        for (snapshot, truth) in self.truths.iter().enumerate() {
            let scene = WatchScene::new(&self.ground.worlds[snapshot], truth.clone());
            // Each sensor as planned once for all cases in which it lives.
            let watched = |one| self.planned.watched_voxels(one, &scene);
            let each = if some_planned { self.planned.each() } else { &[] };
            let own: Vec<BitGrid> = each.par_iter().map(watched).collect();
            let alive = |dead: &[String]| {
                let each = names.iter().zip(&own).filter(|(name, _)| !dead.contains(name));
                union(window, each.map(|(_, watched)| watched.clone()))
            };
            all.par_iter_mut().zip(cases.par_iter()).for_each(|(plane, case)| {
                plane.keep(&match (&case.alteration, &self.drawn) {
                    (Alteration::Dead(dead), _) => alive(dead),
                    (Alteration::Draw(draw), Some(drawn)) => {
                        let each =
                            self.what_if.draw(drawn.draws, *draw).iter().map(watcher).collect::<Vec<_>>();
                        let scene = scene.with_sensors_of(drawn.worlds[snapshot]);
                        union(window, each.iter().map(|one| drawn.watchers.watched_voxels(one, &scene)))
                    }
                    _ => alive(&[]),
                });
            });
        }
        all
    }
}

fn union(window: Window, each: impl Iterator<Item = BitGrid>) -> BitGrid {
    let mut all = BitGrid::new(window);
    each.for_each(|one| all.add(&one));
    all
}
