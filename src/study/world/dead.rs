//! Finds poses from which a sensor can measure nothing: walled in, too near to what stands before them, or
//! with nothing in range. Casts a few rays of each pose on the host, and floods the spaces that the poses
//! stand in.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DQuat;
use rayon::prelude::*;

use super::World;
use crate::input::Study;
use crate::sensor::range::Range;
use crate::sensor::{Candidate, FieldOfView, Kind, Sensor, Setting, Stance, quantise_q15};
use crate::world::place;
use perirobot_march::backend::GridPose;
use perirobot_march::march::{self, Gates};
use perirobot_march::voxel::flood::{flood, with_neighbours};
use perirobot_march::voxel::{BitGrid, Grid, Window};
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// Lines about dead poses; the others are counted.
const MOST_TOLD: usize = 10;
/// Rays that are cast from a pose where there are few poses, and where there are many.
const RAYS: [usize; 2] = [24, 96];
/// Rays that are cast in all, where that leaves each pose the fewest.
const RAYS_IN_ALL: usize = 1 << 22;
/// Most enclosed spaces that are distinguished in a scene; poses beyond count as not walled in.
const MOST_PLACES: usize = 32;
/// A space is closed if it has no larger share of all free voxels than this, and neither people nor robots in
/// it or beside it, or if it is inside a person.
pub(super) const SMALL: f64 = 0.1;
/// A pose is dead where a larger share of its rays is blind. People do not count, since they go away.
const BLIND: f64 = 0.75;
/// A pose faces its own wall where a larger share of its rays than `FACES_WALL` ends within this part of the
/// sensor's longest range and within so many metres.
const FACES_WALL: f64 = 0.9;
const NEAR_SHARE: f64 = 0.05;
const NEAR_M: f64 = 0.3;
/// A pose is dead where a smaller share of its rays returns, if a ray without return says nothing.
const RETURNS: f64 = 0.02;

/// One line for each dead pose, or for several of a group that are dead for one reason; up to ten lines, then the number
/// of the other poses. What is `explained` is left out.
pub(super) fn warnings(
    study: &Study,
    worlds: &[World],
    explained: &(dyn Fn(usize, usize) -> bool + Sync),
) -> Vec<String> {
    let looks = |sensor: &Sensor| sensor.kind.range().is_some() && sensor.kind.stance() != Stance::Level;
    let looking: Vec<usize> = (0..study.sensors.len()).filter(|&s| looks(&study.sensors[s])).collect();
    let poses: usize = looking.iter().map(|&s| study.sensors[s].candidates.len()).sum();
    let rays = (RAYS_IN_ALL / (poses * study.scenes.len()).max(1)).clamp(RAYS[0], RAYS[1]);
    let all = |sensor: usize| (0..study.sensors[sensor].candidates.len()).collect::<Vec<_>>();
    let few: Vec<SampledRays> = looking.iter().map(|&sensor| SampledRays::new(study, sensor, rays)).collect();
    let mut hollows = WorldHollows::new(&worlds[0]);
    let found: Vec<Vec<(usize, Why)>> =
        few.iter().map(|few| few.dead(&worlds[0], &mut hollows, &all(few.sensor))).collect();
    // An object that moves may free a pose: only poses that are dead in every snapshot count.
    let mut left: Vec<Vec<usize>> =
        found.iter().map(|of| of.iter().map(|(candidate, _)| *candidate).collect()).collect();
    for world in &worlds[1..] {
        if left.iter().all(Vec::is_empty) {
            break;
        }
        let mut hollows = WorldHollows::new(world);
        for (few, left) in few.iter().zip(&mut left) {
            *left = few.dead(world, &mut hollows, left).into_iter().map(|(candidate, _)| candidate).collect();
        }
    }
    // Those of a group that are dead for one reason, in the order of the first of them.
    let mut dead: Vec<DeadPoses> = Vec::new();
    let mut places: HashMap<(usize, &str, DeadCause), usize> = HashMap::new();
    for ((few, found), left) in few.iter().zip(found).zip(&left) {
        let of = &study.sensors[few.sensor];
        let is_told =
            |candidate: &usize| left.binary_search(candidate).is_ok() && !explained(few.sensor, *candidate);
        for (candidate, why) in found.into_iter().filter(|(candidate, _)| is_told(candidate)) {
            let group = of.candidates[candidate].group.as_str();
            let place = *places.entry((few.sensor, group, why.cause)).or_insert_with(|| {
                dead.push(DeadPoses { sensor: few.sensor, group, first: candidate, why, count: 0 });
                dead.len() - 1
            });
            dead[place].count += 1;
        }
    }
    let places = place::Places::new(study, &worlds[0]);
    let mut lines: Vec<String> = dead.iter().take(MOST_TOLD).map(|dead| dead.line(study, &places)).collect();
    let count = |some: &[DeadPoses]| some.iter().map(|dead| dead.count).sum::<usize>();
    if dead.len() > MOST_TOLD {
        let (more, all) = (count(&dead[MOST_TOLD..]), count(&dead));
        lines.push(format!("{more} more poses are dead, {all} of {poses} in all"));
    }
    lines
}

/// Why a sensor that looks out sees nothing from a candidate at a moment, with what to do, by a few of its rays. Walls around
/// it are not looked for.
pub(super) fn blindness(study: &Study, world: &World, [sensor, candidate]: [usize; 2]) -> Option<String> {
    let (spec, setting) = (&study.sensors[sensor], world.settings[sensor][candidate]);
    let looks = spec.kind.range().is_some() && spec.kind.stance() != Stance::Level;
    if !looks || !matches!(setting, Setting::Pose(_)) {
        return None;
    }
    let rays = SampledRays::new(study, sensor, RAYS[1]);
    let Why { what, cure, .. } = rays.blindness(&world.truth(), candidate, &setting)?;
    Some(format!("{what}: {cure}"))
}

/// Poses of one group that are dead for one reason.
struct DeadPoses<'a> {
    sensor: usize,
    group: &'a str,
    first: usize,
    /// Why the first is.
    why: Why,
    count: usize,
}

impl DeadPoses<'_> {
    fn line(&self, study: &Study, places: &place::Places) -> String {
        let (of, place) = (&study.sensors[self.sensor], places.words(self.sensor, self.first));
        let (pose, Why { cause, what, cure, .. }) = (&of.candidates[self.first].name, &self.why);
        let (sensor, group, count) = (&of.name, self.group.replace('-', " "), self.count);
        let all = of.candidates.iter().filter(|candidate| candidate.group == self.group).count();
        match (count, cause) {
            (1, _) => format!("sensor {sensor:?}: pose {pose} ({place}) is dead: {what}: {cure}"),
            (_, DeadCause::OwnWall) => format!(
                "sensor {sensor:?}: group {group:?} faces its own wall: {count} of its {all} poses are dead (first {pose}: \
                 {place}): {what}: turn it"
            ),
            _ => format!(
                "sensor {sensor:?}: {count} of the {all} poses of group {group:?} are dead (first {pose}: {place}): {what}: {cure}"
            ),
        }
    }
}

/// Why a pose is dead: of what kind that is, in words, and what to do.
struct Why {
    cause: DeadCause,
    /// The object at which most of its rays end.
    before: Option<usize>,
    what: String,
    cure: String,
}

/// The kinds of reasons that poses are dead for.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum DeadCause {
    WalledIn,
    TooNear,
    /// It faces what it is mounted on, and would not be dead if it were turned round.
    OwnWall,
    Nothing,
}

/// A few of the rays of a sensor, spread over its field of view.
struct SampledRays<'a> {
    sensor: usize,
    candidates: &'a [Candidate],
    kind: &'a dyn Kind,
    range: &'a Range,
    gates: Gates,
    dirs_q15: Vec<[i32; 3]>,
}

/// How a ray ended.
enum RayEnd {
    /// At this voxel and distance.
    Blocker([i32; 3], u32),
    /// Outside the grid, where everything counts as a surface.
    Backdrop,
    Nothing,
}

impl SampledRays<'_> {
    /// `sensor` must have a range.
    fn new(study: &Study, sensor: usize, most: usize) -> SampledRays<'_> {
        let kind = &*study.sensors[sensor].kind;
        let range = kind.range().expect("asked before");
        let scale = study.ray_scale();
        let dirs_q15 = match kind.field_of_view() {
            FieldOfView::Spacing => {
                let rays = super::ray_table(study, sensor);
                let all = rays.iter().flat_map(|rays| rays.dirs_q15.iter().copied());
                let step = rays.as_ref().map_or(0, |rays| rays.dirs_q15.len()).div_ceil(most).max(1);
                all.step_by(step).collect()
            }
            field => field.some(most).into_iter().map(|dir| dir.to_array().map(quantise_q15)).collect(),
        };
        let candidates = &study.sensors[sensor].candidates;
        SampledRays { sensor, candidates, kind, range, gates: range.gates(&scale), dirs_q15 }
    }

    /// Which of these candidates are dead in a world, and why.
    fn dead(&self, world: &World, hollows: &mut WorldHollows, candidates: &[usize]) -> Vec<(usize, Why)> {
        let truth = &*hollows.truth.clone();
        let hollows = hollows.of(self.kind);
        let posed: Vec<(usize, Setting)> =
            candidates.iter().map(|&c| (c, world.settings[self.sensor][c])).collect();
        let posed: Vec<_> =
            posed.into_iter().filter(|(_, setting)| matches!(setting, Setting::Pose(_))).collect();
        let walls = || posed.iter().map(|(_, setting)| hollows.walls(self, setting)).collect();
        let by_rays = |(candidate, setting): &(usize, Setting)| self.blindness(truth, *candidate, setting);
        let by_rays = || posed.par_iter().map(by_rays).collect();
        let (walled, by_rays): (Vec<Option<String>>, Vec<Option<Why>>) = rayon::join(walls, by_rays);
        let walled = walled.into_iter().map(|what| {
            what.map(|what| Why {
                cause: DeadCause::WalledIn,
                before: None,
                what,
                cure: "move it out".into(),
            })
        });
        let why = walled.zip(by_rays).map(|(walled, by_rays)| walled.or(by_rays));
        posed.iter().zip(why).filter_map(|((candidate, _), why)| Some((*candidate, why?))).collect()
    }

    /// Why the rays of a candidate tell nothing, if so.
    fn blindness(&self, truth: &Truth, candidate: usize, setting: &Setting) -> Option<Why> {
        let verdict =
            |pose: &Pose| self.verdict(truth, &crate::sensor::placement(self.kind, pose, &truth.grid, 0));
        let pose = setting.pose();
        // Half a turn about its own z.
        let round = Pose { rotation: pose.rotation * DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0), ..pose };
        match verdict(&pose)? {
            why if why.cause == DeadCause::TooNear && verdict(&round).is_none() => {
                let group = &self.candidates[candidate].group;
                let is_wall = |object| place::is_own_wall(truth, group, pose.position_m, object);
                let cause =
                    if why.before.is_some_and(is_wall) { DeadCause::OwnWall } else { DeadCause::TooNear };
                Some(Why { cause, cure: "turn it round, or move it away".into(), ..why })
            }
            why => Some(why),
        }
    }

    /// Why rays from here tell nothing. Casts no more of them than it takes to know that they tell something.
    fn verdict(&self, truth: &Truth, from: &GridPose) -> Option<Why> {
        let all = self.dirs_q15.len();
        if all == 0 {
            return None;
        }
        let share = |some: usize| some as f64 / all as f64;
        let metres = |q16: u32| f64::from(q16) / 65_536.0 * truth.grid.voxel_size_m;
        let [nearest_m, farthest_m] = self.range.range_m;
        let near_m = NEAR_M.min(NEAR_SHARE * farthest_m);
        let (mut standing, mut blind, mut near, mut returns) = (Vec::new(), 0, 0, 0);
        let mut someone = false;
        for (left, &dir_q15) in (0..all).rev().zip(&self.dirs_q15) {
            match self.cast(self.kind.blockers(truth), from, dir_q15) {
                RayEnd::Blocker(voxel, t_q16) => {
                    let nearest_q16 = self.gates.ray_gates(dir_q15[2]).range_min_q16;
                    let (is_person, is_blind) = (truth.human.get(voxel), t_q16 < nearest_q16);
                    returns += usize::from(!is_blind);
                    someone |= is_person;
                    if !is_person {
                        standing.push(voxel);
                        blind += usize::from(is_blind);
                        near += usize::from(metres(t_q16) <= near_m);
                    }
                }
                RayEnd::Backdrop => returns += 1,
                RayEnd::Nothing => {}
            }
            // The rays that are left cannot take away what these tell; at worst they are all blind, or near.
            let tells = share(returns) >= RETURNS || someone || self.gates.no_return_is_free;
            if tells && share(blind + left) <= BLIND && share(near + left) <= FACES_WALL {
                return None;
            }
        }
        let percent = |some: usize| 100.0 * share(some);
        let before = self.mostly(truth, &standing);
        let at = before.map_or(String::new(), |object| format!(" at {:?}", truth.objects[object].name));
        if share(blind) > BLIND {
            return Some(Why {
                cause: DeadCause::TooNear,
                before,
                what: format!(
                    "{:.0} % of its rays end{at} nearer than the {nearest_m} m from which it measures",
                    percent(blind)
                ),
                cure: "move it away, or, if that is its own housing, write near_ignore_m".into(),
            });
        }
        if share(near) > FACES_WALL {
            return Some(Why {
                cause: DeadCause::TooNear,
                before,
                what: format!("{:.0} % of its rays end{at} within {near_m:.2} m", percent(near)),
                cure: "turn it round, or move it away".into(),
            });
        }
        // Too few of them return.
        Some(Why {
            cause: DeadCause::Nothing,
            before: None,
            what: format!("its rays meet nothing from {nearest_m} to {farthest_m} m"),
            cure: "turn it towards the cell, move it nearer, or take a sensor with a longer range".into(),
        })
    }

    /// The object that has most of these voxels; none if no object has any.
    fn mostly(&self, truth: &Truth, voxels: &[[i32; 3]]) -> Option<usize> {
        let mut counts = vec![0; truth.objects.len()];
        for &voxel in voxels {
            let has =
                |object: &Arc<ObjectVoxels>| self.kind.is_stopped_by(object) && object.voxels.get(voxel);
            let owner = truth.objects.iter().position(has);
            owner.into_iter().for_each(|owner| counts[owner] += 1);
        }
        let all = counts.iter().enumerate().filter(|(_, count)| **count > 0);
        let most = all.max_by_key(|(index, count)| (**count, std::cmp::Reverse(*index)));
        most.map(|(index, _)| index)
    }

    fn cast(&self, blockers: &BitGrid, from: &GridPose, dir_q15: [i32; 3]) -> RayEnd {
        let gates = self.gates.ray_gates(dir_q15[2]);
        let within = march::crossings(from.launch(dir_q15))
            .take_while(|crossing| crossing.t_q16 <= gates.range_max_q16);
        for march::Crossing { t_q16, voxel, .. } in within {
            if !blockers.window().contains(voxel) {
                return if self.gates.backdrop { RayEnd::Backdrop } else { RayEnd::Nothing };
            }
            if t_q16 >= self.gates.near_ignore_q16 && blockers.get(voxel) {
                return RayEnd::Blocker(voxel, t_q16);
            }
        }
        RayEnd::Nothing
    }
}

/// The spaces of a scene, for sensors that see and for those that are radars.
struct WorldHollows {
    truth: Arc<Truth>,
    each: [Option<Hollows>; 2],
}

impl WorldHollows {
    fn new(world: &World) -> WorldHollows {
        WorldHollows { truth: world.truth(), each: [None, None] }
    }

    /// Those between what stops the rays of a kind.
    fn of(&mut self, kind: &dyn Kind) -> &mut Hollows {
        let blockers = kind.blockers(&self.truth);
        let number = usize::from(!std::ptr::eq(blockers, &*self.truth.blockers));
        self.each[number].get_or_insert_with(|| Hollows::new(&self.truth, blockers))
    }
}

/// The spaces of a scene that walls separate, of those in which poses stand.
struct Hollows {
    truth: Arc<Truth>,
    open: BitGrid,
    volume: u64,
    /// Each with a sentence about what closes it, if it is closed.
    known: Vec<(BitGrid, Option<String>)>,
}

impl Hollows {
    fn new(truth: &Arc<Truth>, blockers: &BitGrid) -> Hollows {
        let mut open = BitGrid::full(truth.grid.window());
        open.remove(blockers);
        Hollows { truth: truth.clone(), volume: open.count(), open, known: Vec::new() }
    }

    /// Why no ray gets away from here, in words; `None` where one may.
    fn walls(&mut self, rays: &SampledRays, setting: &Setting) -> Option<String> {
        let truth = &*self.truth.clone();
        let position = truth.grid.position_q16(setting.pose().position_m);
        let own = Grid::voxel_of(position);
        // Blockers nearer than that let rays pass.
        let passes = |voxel: [i32; 3]| {
            let apart = |r: usize| {
                let low = i64::from(voxel[r]) << 16;
                (low - position[r]).max(position[r] - low - (1 << 16)).max(0) as f64
            };
            let apart_q16 = (0..3).map(apart).map(|gap| gap * gap).sum::<f64>().sqrt();
            voxel == own || apart_q16 < f64::from(rays.gates.near_ignore_q16)
        };
        let reach = 1 + (rays.gates.near_ignore_q16 >> 16) as i32;
        if reach > 8 {
            return None;
        }
        let around: Vec<[i32; 3]> = BitGrid::full(Window::from_corners(own, own).grown(reach))
            .voxels()
            .filter(|voxel| passes(*voxel))
            .collect();
        let beside = around.iter().flat_map(|voxel| {
            let towards = move |(axis, by): (usize, i32)| {
                let mut next = *voxel;
                next[axis] += by;
                next
            };
            [(0, -1), (0, 1), (1, -1), (1, 1), (2, -1), (2, 1)].map(towards)
        });
        let mut walls = None;
        for voxel in around.iter().copied().chain(beside) {
            if self.open.get(voxel) {
                walls = Some(self.place(rays.kind, voxel)?);
            }
        }
        walls.or_else(|| {
            let has = |object: &&Arc<ObjectVoxels>| rays.kind.is_stopped_by(object) && object.voxels.get(own);
            let body = truth.objects.iter().find(has);
            let name = body.map_or("a body".into(), |object| format!("{:?}", object.name));
            Some(format!("it stands inside {name}, where no ray goes"))
        })
    }

    /// Why no ray leaves the space around an open voxel, in words.
    fn place(&mut self, kind: &dyn Kind, voxel: [i32; 3]) -> Option<String> {
        if let Some((_, walls)) = self.known.iter().find(|(place, _)| place.get(voxel)) {
            return walls.clone();
        }
        if self.known.len() == MOST_PLACES {
            return None;
        }
        let mut seed = BitGrid::new(self.open.window());
        seed.set(voxel);
        let place = flood(&self.open, &seed);
        let with_walls = with_neighbours(&place);
        let is_small = place.count() as f64 <= SMALL * self.volume as f64;
        // People go away, but not from around what they have inside.
        let is_in_person = || {
            let mut walls = with_walls.clone();
            walls.remove(&place);
            walls.remove(&self.truth.human);
            let around = place.bounds().grown(1);
            walls.is_empty() && around.intersection(&place.window()) == around
        };
        let is_closed = is_small
            && (is_in_person()
                || !with_walls.intersects(&self.truth.human) && !with_walls.intersects(&self.truth.robot));
        let walls = is_closed.then(|| {
            let share = |object: &&std::sync::Arc<perirobot_scene::truth::ObjectVoxels>| {
                let mut shared = object.voxels.clone();
                shared.keep(&with_walls.to_window(shared.window()));
                shared.count()
            };
            let bodies = self.truth.objects.iter().filter(|object| kind.is_stopped_by(object));
            let body = bodies.max_by_key(share);
            let name = body.map_or("walls".into(), |object| format!("{:?}", object.name));
            let litres = place.count() as f64 * self.truth.grid.voxel_size_m.powi(3) * 1e3;
            format!("it stands inside {name}, in a hollow of {litres:.0} l that no ray leaves")
        });
        self.known.push((place, walls.clone()));
        walls
    }
}
