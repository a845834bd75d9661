//! A scene as bodies move through it, without sensors: where they may be, where they enter, and the hazard. Every error
//! of the question is found here, before anything is cast.

use std::sync::Arc;

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::body::{self, Body, Sums};
use super::entries;
use super::surfaces;
use crate::view::watched::Watcher;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_march::{Error, Result};
use perirobot_scene::objects::Role;
use perirobot_scene::truth::Truth;
use perirobot_study::input::{BodySpec, EntryPlace, EntrySpec, Hazard, Study};
use perirobot_study::sensor::prism::Prism;
use perirobot_study::world::World;

/// Most voxels of all grids that are flooded at once: a flood takes twelve bytes for each.
const MOST_VOXELS: u64 = 1 << 28;

/// Who else is there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Company {
    /// Nobody.
    Absent,
    /// The people of the scene, who stand in the way and hide what is behind them.
    Cover,
}

impl Company {
    /// As in the column `people`.
    pub fn name(self) -> &'static str {
        match self {
            Company::Absent => "absent",
            Company::Cover => "cover",
        }
    }

    /// What is where at a moment.
    pub fn truth(self, world: &World) -> Arc<Truth> {
        match self {
            Company::Absent => Arc::new(world.truth_without_people()),
            Company::Cover => world.truth(),
        }
    }
}

/// The snapshots of one scene, checked.
#[derive(Debug)]
pub struct Ground<'a> {
    /// The study.
    pub study: &'a Study,
    /// The snapshots of the scene.
    pub worlds: &'a [World],
    /// The bodies in study order.
    pub bodies: Vec<Body>,
    /// For each body, its places in the grid.
    pub places: Vec<Window>,
    /// For each body and each entry, the places at which the body comes in.
    pub begins: Vec<Vec<BitGrid>>,
    /// Wherever the robot is at some moment.
    swept: BitGrid,
}

/// The voxels that nothing can enter.
pub(super) fn solid(truth: &Truth) -> BitGrid {
    let mut solid = BitGrid::clone(&truth.occupied);
    solid.add(&truth.ignored);
    solid.add(&truth.robot_volume);
    solid
}

/// How many floods of so many voxels have room in memory at once.
fn floods_at_once(voxels: u64) -> usize {
    (MOST_VOXELS / voxels.max(1)).max(1) as usize
}

impl<'a> Ground<'a> {
    /// Checks what a study asks of each of its scenes; `watchers` are the sensors that are looked at.
    pub fn from_scenes(
        study: &'a Study,
        worlds: &'a [World],
        watchers: &[Watcher],
    ) -> Result<Vec<Ground<'a>>> {
        let scenes = worlds.chunk_by(|one, next| one.scene == next.scene);
        scenes.map(|worlds| Ground::new(study, worlds, watchers)).collect()
    }

    /// Checks what a study asks of a scene; `watchers` are the sensors that are looked at.
    pub fn new(study: &'a Study, worlds: &'a [World], watchers: &[Watcher]) -> Result<Ground<'a>> {
        Ground::check(study, worlds, watchers, true)
    }

    /// The same of a scene in which there may be nothing that bodies must not come near to.
    pub(super) fn without_hazard(
        study: &'a Study,
        worlds: &'a [World],
        watchers: &[Watcher],
    ) -> Result<Ground<'a>> {
        Ground::check(study, worlds, watchers, false)
    }

    fn check(
        study: &'a Study,
        worlds: &'a [World],
        watchers: &[Watcher],
        has_hazard: bool,
    ) -> Result<Ground<'a>> {
        let here = |issue: Issue| Error::from(issue.with_place("approach").with_place(&study.path));
        let grid = worlds[0].grid;
        if grid.window().volume() > MOST_VOXELS {
            let what =
                format!("{} voxels are more than the {MOST_VOXELS} that are flooded", grid.window().volume());
            return Err(here(Issue::too_large(what).with_advice("take larger voxels, or set bounds_m")));
        }
        let mut swept = BitGrid::new(grid.window());
        worlds.iter().for_each(|world| swept.add(&world.truth().robot_volume));
        let mut ground =
            Ground { study, worlds, bodies: Vec::new(), places: Vec::new(), begins: Vec::new(), swept };
        for world in worlds.iter().filter(|_| has_hazard) {
            ground.hazard(world).map_err(here)?;
        }
        for spec in &study.approach.bodies {
            let in_body = |issue: Issue| here(issue.with_place(format!("body {:?}", spec.name)));
            // One that is larger than the grid would have more voxels than memory holds.
            let floor_m = study.approach.standing_m();
            let layers = spec.on_floor.then(|| body::standing(spec.shape, floor_m, &grid));
            ground.places.push(ground.places_of(spec, layers.as_ref(), &grid).map_err(in_body)?);
            let mut body = Body::new(spec, grid.voxel_size_m, layers.as_ref()).map_err(in_body)?;
            let step_m = study.approach.step_m.filter(|_| body.on_floor);
            body.climbs = step_m.map(|step_m| surfaces::layers_of_step(step_m, grid.voxel_size_m));
            ground.bodies.push(body);
        }
        for (body, places) in ground.bodies.iter().zip(&ground.places) {
            let begins = study.approach.entries.iter().map(|entry| {
                let in_entry = |issue: Issue| here(issue.with_place(format!("entry {:?}", entry.name)));
                ground.begin(body, entry, *places, watchers).map_err(in_entry)
            });
            let begins = begins.collect::<Result<Vec<_>>>()?;
            ground.begins.push(begins);
        }
        ground.refuse_walls().map_err(here)?;
        Ok(ground)
    }

    fn places_of(&self, body: &BodySpec, layers: Option<&Range<i32>>, grid: &Grid) -> Result<Window, Issue> {
        let floor_m = self.study.approach.standing_m();
        let walks = self.study.approach.step_m.is_some();
        let size = body::size(body.shape, grid.voxel_size_m, layers);
        let places = body::places(size, layers.filter(|_| !walks).map(|layers| layers.start), grid);
        if places.is_empty() {
            let [low, high] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
            let stands = match body.on_floor && !walks {
                true => format!(", on a floor at {floor_m} m"),
                false => String::new(),
            };
            return Err(Issue::says(format!(
                "is nowhere inside the grid{stands}: that goes from {:.2?} to {:.2?} m",
                low.to_array(),
                high.to_array()
            ))
            .with_advice("set bounds_m wider, or floor_m"));
        }
        Ok(places)
    }

    fn begin(
        &self,
        body: &Body,
        entry: &EntrySpec,
        places: Window,
        watchers: &[Watcher],
    ) -> Result<BitGrid, Issue> {
        let grid = &self.worlds[0].grid;
        match entry.place {
            EntryPlace::Box { min_m, max_m } => {
                entries::places_in_box(body, &Prism::from_corners(min_m, max_m), grid, places)
            }
            EntryPlace::Edges => Ok(entries::at_edges(body, grid, places)),
            EntryPlace::Gate(sensor) => {
                let gate = &self.study.sensors[sensor];
                let chosen = watchers.iter().find(|one| one.sensor == sensor).map(|one| one.candidate);
                let candidate = chosen.or((gate.candidates.len() == 1).then_some(0)).ok_or_else(|| {
                    Issue::says(format!("the poses that are looked at do not say where {:?} is", gate.name))
                        .with_advice("look at a combination with that sensor, or name the entry by a box")
                })?;
                let pose = self.worlds[0].settings[sensor][candidate].pose();
                entries::places_outside_gate(body, &*gate.kind, &pose, grid, places)
            }
        }
    }

    /// Whether some body walks on what carries it.
    pub(super) fn walks(&self) -> bool {
        self.bodies.iter().any(|body| body.climbs.is_some())
    }

    /// Refuses an entry at which a body is in something solid, at all places and in all snapshots.
    fn refuse_walls(&self) -> Result<(), Issue> {
        let truths = self.worlds.iter().map(|world| world.truth_without_people());
        let solids = truths.map(|truth| {
            let solid = solid(&truth);
            let surfaces = match self.walks() {
                true => surfaces::surfaces(&truth, &solid),
                false => BitGrid::nowhere(),
            };
            [solid, surfaces].map(|set| Sums::new(&set))
        });
        let solids: Vec<_> = solids.collect();
        for ((body, places), begins) in self.bodies.iter().zip(&self.places).zip(&self.begins) {
            let mut walled: Vec<bool> = vec![true; begins.len()];
            let mut has_room = vec![false; begins.len()];
            for [solid, surfaces] in &solids {
                let free = surfaces::room(body, solid, surfaces, *places);
                walled.iter_mut().zip(begins).for_each(|(walled, begin)| *walled &= !begin.intersects(&free));
                if body.climbs.is_some() {
                    let free = body.covers_at_most(0, solid, *places);
                    has_room.iter_mut().zip(begins).for_each(|(has, begin)| *has |= begin.intersects(&free));
                }
            }
            if let Some(number) = walled.iter().position(|&walled| walled) {
                let entry = &self.study.approach.entries[number];
                if has_room[number] {
                    let what = format!("has nothing that carries body {:?} at any place of it", body.name);
                    let cure = "add the floor to the scene, make the entry higher or lower, or write floor_m \
                                instead of floor = \"auto\"";
                    return Err(Issue::says(what)
                        .with_advice(cure)
                        .with_place(format!("entry {:?}", entry.name)));
                }
                let cure = match entry.place {
                    EntryPlace::Edges => {
                        "no opening of the grid's edge is free: add an [[approach.entry]] with a box"
                    }
                    _ => "move the entry to where the body has room",
                };
                let what =
                    format!("lies inside something solid: body {:?} is free at no place of it", body.name);
                return Err(Issue::says(what)
                    .with_advice(cure)
                    .with_place(format!("entry {:?}", entry.name)));
            }
        }
        Ok(())
    }

    /// The voxels that no body must come near to at a moment, at least one.
    pub(super) fn hazard(&self, world: &World) -> Result<BitGrid, Issue> {
        let mut hazard = BitGrid::new(world.grid.window());
        let missing = match self.study.approach.hazard {
            Hazard::Region(region) => {
                hazard.add(&world.regions[region].voxels);
                "the region has no voxel"
            }
            Hazard::Robot => {
                hazard.add(&world.truth().robot_volume);
                "no object of the scene is a robot in the grid"
            }
            Hazard::RobotSwept => {
                hazard.add(&self.swept);
                "no object of the scene is a robot in the grid"
            }
        };
        match hazard.is_empty() {
            true => Err(Issue::says(format!("no hazard: {missing}")).with_advice(
                "give an object role = \"robot\", or name a region of the study by [approach] region",
            )),
            false => Ok(hazard),
        }
    }

    /// How many bodies may be flooded at once.
    pub fn at_once(&self) -> usize {
        floods_at_once(self.worlds[0].grid.window().volume())
    }

    /// With whom the scene is asked: with nobody else, and where it has people, with them.
    pub fn companies(&self) -> Vec<Company> {
        let people = |world: &World| world.truth().objects.iter().any(|object| object.role == Role::Human);
        match self.worlds.iter().any(people) {
            true => vec![Company::Absent, Company::Cover],
            false => vec![Company::Absent],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floods_at_once_have_room_together() {
        for (voxels, expected) in [(1 << 10, 1 << 18), (1 << 26, 4), ((1 << 27) + 1, 1), (MOST_VOXELS, 1)] {
            assert_eq!(floods_at_once(voxels), expected, "{voxels} voxels");
        }
    }
}
