//! The voxels that a choice of poses watches at one moment of a scene, with or without its people, and the objects
//! in front of the others. [`perirobot_study::sensor::watch`] defines *watched*.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::Choice;
use super::why::sight::Sight;
use perirobot_march::backend::cpu::{BlockerSearch, SightRays, SightScene};
use perirobot_march::backend::{GridPose, Rays};
use perirobot_march::march::leap;
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::truth::Truth;
use perirobot_study::input::Study;
use perirobot_study::sensor::Station;
use perirobot_study::sensor::look::RayDirection;
use perirobot_study::sensor::watch::{self, ReadySight};
use perirobot_study::world::{World, ray_tables_of};

/// A sensor of a choice: its index, its candidate and its representation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Watcher {
    /// Index of the sensor.
    pub sensor: usize,
    /// Index of its candidate.
    pub candidate: usize,
    /// Index of its representation.
    pub representation: usize,
}

/// The sensors of a choice, and their rays.
#[derive(Debug)]
pub struct Watchers<'a> {
    study: &'a Study,
    repeat: usize,
    each: Vec<Watcher>,
    /// For each casting sensor of the choice, its rays, and the same prepared for searches.
    tables: Vec<Option<Rays>>,
    ready: Vec<Option<SightRays>>,
}

/// A prepared moment of a scene, to be watched from many poses.
#[derive(Debug)]
pub struct WatchScene<'w> {
    world: &'w World,
    truth: Arc<Truth>,
    sight: Arc<SightScene>,
}

/// The watched voxels of a moment.
#[derive(Debug)]
pub struct WatchedVoxels {
    /// The contents of the grid; without people if they are left out.
    pub truth: Arc<Truth>,
    /// The voxels in which a body would be noticed, over the grid.
    pub voxels: BitGrid,
    /// For each latching sensor, its index and the voxels in which people are detected on their way.
    pub latched: Vec<(usize, BitGrid)>,
    /// For each casting sensor, its index and its pose.
    placements: Vec<(usize, GridPose)>,
}

impl<'w> WatchScene<'w> {
    /// A moment of a world, of which a part is examined; `truth` is that of this world, with its people or without.
    pub fn new(world: &'w World, truth: Arc<Truth>, within: Window) -> WatchScene<'w> {
        WatchScene { world, sight: SightScene::new(&truth.blockers, within).into(), truth }
    }

    /// The same for the same moment of another world with other sensor poses.
    pub fn with_sensors_of<'o>(&self, world: &'o World) -> WatchScene<'o> {
        WatchScene { world, truth: self.truth.clone(), sight: self.sight.clone() }
    }
}

impl<'a> Watchers<'a> {
    /// The sensors of a choice.
    pub fn new(study: &'a Study, choice: Choice) -> Watchers<'a> {
        let combination = &study.combinations[choice.combination];
        let candidates = combination.choice(choice.choice);
        let representations = combination.representations(&study.sensors).swap_remove(choice.representation);
        let members = combination.members.iter().zip(candidates).zip(representations);
        let each: Vec<_> = members
            .map(|((member, candidate), representation)| Watcher {
                sensor: member.sensor,
                candidate,
                representation,
            })
            .collect();
        Watchers::from_watchers(study, each, choice.repeat)
    }

    /// Some sensors in a repeat.
    pub fn from_watchers(study: &'a Study, each: Vec<Watcher>, repeat: usize) -> Watchers<'a> {
        let tables = ray_tables_of(study, |sensor| each.iter().any(|one| one.sensor == sensor));
        let ready = tables.iter().map(|rays| rays.as_ref().map(SightRays::new)).collect();
        Watchers { study, repeat, each, tables, ready }
    }

    /// The sensors.
    pub fn each(&self) -> &[Watcher] {
        &self.each
    }

    /// The name of a sensor.
    pub fn name(&self, sensor: usize) -> &str {
        &self.study.sensors[sensor].name
    }

    /// The voxels that they watch in a scene; `truth` is that of this world, with its people or without.
    pub fn watch(&self, world: &World, truth: Arc<Truth>) -> WatchedVoxels {
        let mut voxels = BitGrid::new(world.grid.window());
        let (mut placements, mut latched) = (Vec::new(), Vec::new());
        let scene = WatchScene::new(world, truth.clone(), world.grid.window());
        for one in &self.each {
            voxels.add(&self.watched_voxels(one, &scene));
            let station = self.station(one, world, &truth);
            let zone = self.study.sensors[one.sensor].kind.latched(&station);
            if !zone.is_empty() {
                latched.push((one.sensor, zone));
            }
            if self.tables[one.sensor].is_some() {
                placements.push((one.sensor, station.placement(&*self.study.sensors[one.sensor].kind)));
            }
        }
        WatchedVoxels { truth, voxels, latched, placements }
    }

    /// The voxels in which one of them would notice a body, over the grid or a part of it.
    pub fn watched_voxels(&self, one: &Watcher, scene: &WatchScene) -> BitGrid {
        let kind = &*self.study.sensors[one.sensor].kind;
        let sight = self.ready[one.sensor].as_ref().map(|rays| ReadySight { rays, scene: &scene.sight });
        watch::watched_voxels(kind, one.representation, &self.station(one, scene.world, &scene.truth), sight)
    }

    /// The same with each ray followed step by step, for proofs.
    pub fn watched_step_by_step(&self, one: &Watcher, world: &World, truth: &Truth) -> BitGrid {
        let kind = &*self.study.sensors[one.sensor].kind;
        watch::watched_voxels(kind, one.representation, &self.station(one, world, truth), None)
    }

    fn station<'t>(&'t self, one: &Watcher, world: &World, truth: &'t Truth) -> Station<'t> {
        let at = world.station(self.study, truth, [one.sensor, one.candidate, self.repeat]);
        Station { rays: self.tables[one.sensor].as_ref(), ..at }
    }

    /// The numbers of those that latch.
    pub(crate) fn latching(&self) -> BTreeSet<usize> {
        let sensors = self.each.iter().map(|one| one.sensor);
        sensors.filter(|&sensor| self.study.sensors[sensor].kind.latches()).collect()
    }

    /// The objects in front of unwatched voxels: for each index in [`Truth::objects`], how often the sensor ray nearest
    /// to a voxel ends in it before the voxel, within its range.
    pub fn blocking_objects(
        &self,
        watch: &WatchedVoxels,
        voxels: impl Iterator<Item = [i32; 3]>,
    ) -> BTreeMap<usize, u64> {
        let (search, objects) = (BlockerSearch::new(&watch.truth.blockers), &watch.truth.objects);
        let sights = watch.placements.iter().filter_map(|(sensor, from)| {
            let rays = self.tables[*sensor].as_ref()?;
            let field = self.study.sensors[*sensor].kind.field_of_view();
            let begin = search.rays_from(from.caster().origin_q16);
            Some((rays, from, begin, Sight::new(rays, from, field)))
        });
        let sights: Vec<_> = sights.collect();
        let mut found = BTreeMap::new();
        for voxel in voxels.filter(|&voxel| !watch.voxels.get(voxel)) {
            for (rays, from, begin, sight) in &sights {
                let Some(ray) = sight.look(voxel).ray else { continue };
                let Some(entered_q16) = leap::entry_q16(&sight.start(ray), voxel) else { continue };
                let way = RayDirection::new(from, rays.dirs_q15[ray as usize]);
                let gates = rays.gates_of(ray as usize);
                let Some(hit) = search.first(begin, way.truly_q16, &gates) else { continue };
                let is_before = hit.t_q16 < entered_q16 && entered_q16 <= gates.range_max_q16;
                let stops =
                    |object: usize| objects[object].stops_rays && objects[object].voxels.get(hit.voxel);
                if let Some(object) = (0..objects.len()).find(|&object| is_before && stops(object)) {
                    *found.entry(object).or_default() += 1;
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests;
