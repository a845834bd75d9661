//! The ways in of an answer, followed again step by step. Only the study (bodies, places of entries) and the watched
//! voxels of one sensor in one snapshot are shared with the search; free space, distances of a body and the sensors
//! that notice it together are found here by trying all voxels.

use std::collections::{BTreeMap, HashSet};
use std::sync::Arc;

use rayon::prelude::*;

use super::ProofInput;
use crate::approach::{Body, Company, Ground, NearestApproach};
use crate::cheapest::report::ProvenWay;
use crate::cheapest::terms::{Terms, dead_in};
use crate::choose::pose_name;
use crate::judge::{Conditions, Passage, approach_value};
use crate::view::watched::{Watcher, Watchers};
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Distances};
use perirobot_march::{Error, Result};
use perirobot_scene::truth::Truth;
use perirobot_study::input::{Hazard, Measure, Nearness, Requirement};

/// A way in that was followed.
pub(super) struct FollowedWay {
    pub(super) passage: Passage,
    /// Its closest distance, squared in voxels.
    pub(super) squared: u32,
    /// For each candidate whether it is one of those of which at least one notices the body.
    pub(super) noticed_by: Vec<bool>,
    /// Scene and company, body, and its place at the end.
    cell: usize,
    body: usize,
    end: [i32; 3],
}

/// The distance of a body at an entry, independent of sensors.
pub(super) struct AtEntry {
    pub(super) passage: Passage,
    /// Squared, in voxels.
    pub(super) squared: u32,
}

/// Facts about approaching bodies.
pub(super) struct NearFacts<'g> {
    cells: Vec<Cell<'g>>,
    pub(super) ways: Vec<FollowedWay>,
    pub(super) entries: Vec<AtEntry>,
}

/// A scene in some company, all its snapshots at once.
struct Cell<'g> {
    ground: &'g Ground<'g>,
    company: Company,
    truths: Vec<Arc<Truth>>,
    /// The voxels that are solid in all snapshots.
    solid: BitGrid,
    /// What is of neither a robot nor a person and has nothing solid right above, in some snapshot.
    surfaces: BitGrid,
    /// The voxels right below each walking body, from its place; `None` for other bodies.
    below: Vec<Option<Vec<[i32; 3]>>>,
    hazard: BitGrid,
    /// The surface voxels of the hazard: one of them is the nearest.
    surface: Vec<[i32; 3]>,
}

impl<'g> NearFacts<'g> {
    /// Follows all ways in, in the order of the file.
    ///
    /// # Errors
    /// `Error::Input` that names the way and its wrong claim; `Error::Stopped`.
    pub(super) fn new(input: ProofInput<'g>, ways: &[ProvenWay]) -> Result<NearFacts<'g>> {
        let mut cells = Vec::new();
        for ground in input.grounds {
            cells.extend(ground.companies().into_iter().map(|company| Cell::new(ground, company)));
        }
        let entries = cells.par_iter().flat_map(Cell::at_entries).collect();
        let mut followed: Vec<Option<FollowedWay>> = ways.iter().map(|_| None).collect();
        for (number, way) in ways.iter().enumerate() {
            let is_there = cells.iter().any(|cell| cell.is_of(input, way));
            if !is_there || way.repeat >= input.study.repeats as usize {
                return Err(Issue::says("is in no scene, company and repeat of the study")
                    .with_place(format!("ways_in[{number}]"))
                    .into());
            }
        }
        for (place, cell) in cells.iter().enumerate() {
            for repeat in 0..input.study.repeats as usize {
                let own: Vec<usize> = (0..ways.len())
                    .filter(|&i| cell.is_of(input, &ways[i]) && ways[i].repeat == repeat)
                    .collect();
                if own.is_empty() {
                    continue;
                }
                let watched = cell.watched(input, repeat)?;
                let follow = |&number: &usize| {
                    let way = cell.follow(input, (&format!("ways_in[{number}]"), &ways[number]), &watched);
                    way.map(|way| FollowedWay { cell: place, ..way }).map_err(Error::from)
                };
                let found: Vec<Result<FollowedWay>> = own.par_iter().map(follow).collect();
                // The first wrong way is reported, whichever thread was faster.
                let found: Vec<FollowedWay> = found.into_iter().collect::<Result<_>>()?;
                own.into_iter().zip(found).for_each(|(number, way)| followed[number] = Some(way));
            }
        }
        Ok(NearFacts { cells, ways: followed.into_iter().flatten().collect(), entries })
    }

    /// The number of noticing candidates that a passing set needs: one more than may be dead; `None` if the way does
    /// not lead too near.
    pub(super) fn needed(&self, input: ProofInput, terms: &Terms, way: &FollowedWay) -> Option<usize> {
        let near = missed_requirements(input, terms, &way.passage, way.squared);
        let dead = near.flat_map(|one| one.under.iter().filter_map(|&condition| dead_in(condition)).max());
        dead.max().map(|dead| dead + 1)
    }

    /// The body's centre at the end of a way, in world metres, and the object in front of it for most candidates at all
    /// moments of the scene.
    pub(super) fn end_of(&self, input: ProofInput, way: &FollowedWay) -> ([f64; 3], Option<String>) {
        let Cell { ground, truths, .. } = &self.cells[way.cell];
        let body = &ground.bodies[way.body];
        let watchers = input.watchers(way.passage.repeat);
        let mut before: BTreeMap<&str, u64> = BTreeMap::new();
        for (world, truth) in ground.worlds.iter().zip(truths) {
            let watch = watchers.watch(world, truth.clone());
            for (object, often) in watchers.blocking_objects(&watch, body.voxels(way.end)) {
                *before.entry(&truth.objects[object].name).or_default() += often;
            }
        }
        let mut named: Vec<(&str, u64)> = before.into_iter().collect();
        named.sort_by(|a, b| b.1.cmp(&a.1).then(a.0.cmp(b.0)));
        let end_m = body.middle_m(way.end, &ground.worlds[0].grid).to_array();
        (end_m, named.first().map(|(name, _)| (*name).to_string()))
    }

    /// The first entry at which a body is already too near, and the missed requirement.
    pub(super) fn too_near_at_entry<'t>(
        &self,
        input: ProofInput,
        terms: &'t Terms,
    ) -> Option<(&AtEntry, &'t Requirement)> {
        let fails = |entry: &AtEntry| missed_requirements(input, terms, &entry.passage, entry.squared).next();
        self.entries.iter().find_map(|entry| Some((entry, fails(entry)?)))
    }
}

/// The requirements that a body at this distance misses, if dead sensors are the only alteration.
fn missed_requirements<'t>(
    input: ProofInput,
    terms: &'t Terms,
    passage: &Passage,
    squared: u32,
) -> impl Iterator<Item = &'t Requirement> {
    let needed = terms.stopping.as_ref().map(|stopping| *stopping.fastest());
    let scale = Conditions { voxel_size_m: input.study.voxel_size_m, needed, ..Conditions::default() };
    let near = NearestApproach { squared: Some(squared), unnoticed: 0, joined: 0 };
    let is_asked = |nearness: &Nearness| !nearness.score.is_area() && passage.is_asked(nearness);
    let misses = |one: &&Requirement| match &one.measure {
        Measure::Nearness(nearness) if is_asked(nearness) => {
            let is_counted = one.under.iter().any(|&condition| dead_in(condition).is_some());
            let value = approach_value(nearness.score, &near, &scale);
            is_counted && !value.is_some_and(|value| value.meets(&one.limit))
        }
        _ => false,
    };
    terms.requirements.iter().filter(misses).collect::<Vec<_>>().into_iter()
}

impl<'a> ProofInput<'a> {
    /// All candidates.
    fn watchers(self, repeat: usize) -> Watchers<'a> {
        let watcher = |&[sensor, candidate]: &[usize; 2]| Watcher {
            sensor,
            candidate,
            representation: self.purchase.representations[sensor],
        };
        Watchers::from_watchers(self.study, self.items.iter().map(watcher).collect(), repeat)
    }
}

impl<'g> Cell<'g> {
    fn new(ground: &'g Ground<'g>, company: Company) -> Cell<'g> {
        let window = ground.worlds[0].grid.window();
        let truths: Vec<Arc<Truth>> = ground.worlds.iter().map(|world| company.truth(world)).collect();
        let (mut solid, mut hazard) = (BitGrid::full(window), BitGrid::new(window));
        let mut surfaces = BitGrid::new(window);
        for (world, truth) in ground.worlds.iter().zip(&truths) {
            let mut here = BitGrid::new(window);
            here.add(&truth.occupied);
            here.add(&truth.ignored);
            here.add(&truth.robot_volume);
            let carries = |voxel| !truth.robot.get(voxel) && !truth.human.get(voxel);
            let top = |[x, y, z]: [i32; 3]| !here.get([x, y, z + 1]);
            let own = truth.occupied.voxels().filter(|&voxel| carries(voxel) && top(voxel));
            own.for_each(|voxel| surfaces.set(voxel));
            solid.keep(&here);
            match ground.study.approach.hazard {
                Hazard::Region(region) => hazard.add(&world.regions[region].voxels),
                Hazard::Robot | Hazard::RobotSwept => hazard.add(&world.truth().robot_volume),
            }
        }
        let is_inside = |voxel: &[i32; 3]| {
            let near = |axis: usize, by: i32| {
                let mut other = *voxel;
                other[axis] += by;
                hazard.get(other)
            };
            (0..3).all(|axis| near(axis, -1) && near(axis, 1))
        };
        let surface = hazard.voxels().filter(|voxel| !is_inside(voxel)).collect();
        let below = ground.bodies.iter().map(|body| {
            let own: HashSet<[i32; 3]> = body.voxels([0; 3]).collect();
            let below = own.iter().map(|&[x, y, z]| [x, y, z - 1]).filter(|voxel| !own.contains(voxel));
            body.climbs.map(|_| below.collect())
        });
        let below = below.collect();
        Cell { ground, company, truths, solid, surfaces, below, hazard, surface }
    }

    fn is_of(&self, input: ProofInput, way: &ProvenWay) -> bool {
        let scene = &input.study.scenes[self.ground.worlds[0].scene].name;
        (scene, self.company.name()) == (&way.scene, &*way.people)
    }

    fn passage(&self, body: &Body, entry: usize, repeat: usize) -> Passage {
        Passage {
            scene: self.ground.worlds[0].scene,
            company: self.company,
            repeat,
            body: body.name.clone(),
            on_floor: body.on_floor,
            entry: self.ground.study.approach.entries[entry].name.clone(),
        }
    }

    /// Whether nothing solid is in a body, by its number, and a surface is right below it if it walks.
    fn has_room(&self, body: usize, place: [i32; 3]) -> bool {
        let is_carried = |below: &Vec<[i32; 3]>| {
            below.iter().any(|by| self.surfaces.get(std::array::from_fn(|r| place[r] + by[r])))
        };
        let mut own = self.ground.bodies[body].voxels(place);
        own.all(|voxel| !self.solid.get(voxel)) && self.below[body].as_ref().is_none_or(is_carried)
    }

    /// The distance of a body at a place from the hazard, squared in voxels.
    fn squared_distance(&self, body: &Body, place: [i32; 3]) -> u32 {
        let to_surface = |voxel: [i32; 3]| {
            let squared = |other: &[i32; 3]| (0..3).map(|r| voxel[r].abs_diff(other[r]).pow(2)).sum::<u32>();
            let is_in = self.hazard.get(voxel);
            if is_in { 0 } else { self.surface.iter().map(squared).min().unwrap_or(u32::MAX) }
        };
        body.voxels(place).map(to_surface).min().unwrap_or(u32::MAX)
    }

    /// The distance of each body at each entry; `None` if it does not fit. The table of all distances gives the nearest
    /// place; the distance there is found by trying all voxels.
    fn at_entries(&self) -> Vec<AtEntry> {
        let distances = Distances::from_set(&self.hazard);
        let mut all = Vec::new();
        let bodies = self.ground.bodies.iter().zip(&self.ground.begins).enumerate();
        for (number, (body, begins)) in bodies {
            for (entry, begin) in begins.iter().enumerate() {
                let free = begin.voxels().filter(|&place| self.has_room(number, place));
                let near = |&place: &[i32; 3]| {
                    body.voxels(place).map(|voxel| distances.squared_distance(voxel)).min()
                };
                let Some(nearest) = free.min_by_key(near) else { continue };
                let (passage, squared) = (self.passage(body, entry, 0), self.squared_distance(body, nearest));
                all.push(AtEntry { passage, squared });
            }
        }
        all
    }

    /// The voxels that each candidate watches in each snapshot.
    fn watched(&self, input: ProofInput, repeat: usize) -> Result<Vec<Vec<BitGrid>>> {
        let watchers = input.watchers(repeat);
        let look = |one: &Watcher| {
            input.progress.check_stop()?;
            let snapshots = self.ground.worlds.iter().zip(&self.truths);
            Ok(snapshots
                .map(|(world, truth)| watchers.watched_step_by_step(one, world, truth).trim())
                .collect())
        };
        watchers.each().par_iter().map(look).collect()
    }

    fn follow(
        &self,
        input: ProofInput,
        (at, way): (&str, &ProvenWay),
        watched: &[Vec<BitGrid>],
    ) -> Result<FollowedWay, Issue> {
        let wrong = |key: &str, what: String| Err(Issue::says(what).with_place(format!("{at}.{key}")));
        let Ground { study, bodies, places: rooms, begins, .. } = self.ground;
        let Some(number) = bodies.iter().position(|body| body.name == way.body) else {
            return wrong("body", format!("{:?} is not a body of the study", way.body));
        };
        let Some(entry) = study.approach.entries.iter().position(|entry| entry.name == way.entry) else {
            return wrong("entry", format!("{:?} is not an entry of the study", way.entry));
        };
        let (body, begin) = (&bodies[number], &begins[number][entry]);
        let (Some(&first), Some(&end)) = (way.places.first(), way.places.last()) else {
            return wrong("places", "is empty".into());
        };
        if !begin.get(first) {
            return wrong("places[0]", format!("{first:?} is not a place of entry {:?}", way.entry));
        }
        let is_step = |[from, to]: [[i32; 3]; 2]| {
            let apart = [0, 1, 2].map(|r| from[r].abs_diff(to[r]));
            match body.climbs {
                Some(layers) => apart[..2].iter().max() == Some(&1) && apart[2] <= layers,
                None => apart.iter().max() == Some(&1),
            }
        };
        for (step, &place) in way.places.iter().enumerate() {
            let key = format!("places[{step}]");
            if step > 0 && !is_step([way.places[step - 1], place]) {
                return wrong(&key, format!("{place:?} is not adjacent to the previous place"));
            }
            if !rooms[number].contains(place) || !self.has_room(number, place) {
                return wrong(&key, format!("body {:?} does not fit at {place:?}", way.body));
            }
        }
        let squared = self.squared_distance(body, end);
        let nearest_m = f64::from(squared).sqrt() * study.voxel_size_m;
        if nearest_m != way.nearest_m {
            return wrong("nearest_m", format!("is {}, but measured again it is {nearest_m}", way.nearest_m));
        }
        let noticed_by = self.who_notices(input, (at, way), body, watched)?;
        let passage = self.passage(body, entry, way.repeat);
        Ok(FollowedWay { passage, squared, noticed_by, cell: 0, body: number, end })
    }

    /// Checks that all candidates outside the list together do not notice a body, and that they do with any one of the
    /// list.
    fn who_notices(
        &self,
        input: ProofInput,
        (at, way): (&str, &ProvenWay),
        body: &Body,
        watched: &[Vec<BitGrid>],
    ) -> Result<Vec<bool>, Issue> {
        let in_file = |number: usize| format!("{at}.noticed_by[{number}]");
        let mut named = Vec::new();
        for (number, name) in way.noticed_by.iter().enumerate() {
            match input.items.iter().position(|&item| pose_name(input.study, item) == *name) {
                Some(item) if named.last().is_none_or(|last| *last < item) => named.push(item),
                Some(_) => {
                    return Err(Issue::says(format!("{name:?} is out of order")).with_place(in_file(number)));
                }
                None => {
                    let what = format!("{name:?} is not a pose of the study");
                    return Err(Issue::says(what).with_place(in_file(number)));
                }
            }
        }
        let others: Vec<usize> = (0..watched.len()).filter(|item| !named.contains(item)).collect();
        let mut voxels: Vec<[i32; 3]> = way.places.iter().flat_map(|&place| body.voxels(place)).collect();
        voxels.sort_unstable();
        voxels.dedup();
        let number = |voxel: [i32; 3]| voxels.binary_search(&voxel).ok();
        let bodies: Vec<Vec<usize>> =
            way.places.iter().map(|&place| body.voxels(place).filter_map(number).collect()).collect();
        let sees = |item: usize, snapshot: usize, voxel: usize| watched[item][snapshot].get(voxels[voxel]);
        let snapshots = 0..self.truths.len();
        let by_others = |snapshot: usize| -> Vec<bool> {
            let is_seen = |voxel| others.iter().any(|&item| sees(item, snapshot, voxel));
            (0..voxels.len()).map(is_seen).collect()
        };
        let by_others: Vec<Vec<bool>> = snapshots.clone().map(by_others).collect();
        // The first place at which enough voxels are watched in all snapshots.
        let noticed_at = |more: Option<usize>| {
            let is_seen = |&voxel: &usize| {
                let by_more = |snapshot| more.is_some_and(|item| sees(item, snapshot, voxel));
                snapshots.clone().all(|snapshot| by_others[snapshot][voxel] || by_more(snapshot))
            };
            let count = |body: &Vec<usize>| body.iter().filter(|voxel| is_seen(voxel)).count();
            bodies.iter().position(|voxels| count(voxels) >= body.min_voxels as usize)
        };
        if let Some(step) = noticed_at(None) {
            let what = "candidates that are not in noticed_by notice the body here";
            return Err(Issue::says(what).with_place(format!("{at}.places[{step}]")));
        }
        for (number, &item) in named.iter().enumerate() {
            if noticed_at(Some(item)).is_none() {
                let what = format!("{:?} does not notice the body on this way", way.noticed_by[number]);
                return Err(Issue::says(what).with_place(in_file(number)));
            }
        }
        Ok((0..watched.len()).map(|item| named.contains(&item)).collect())
    }
}
