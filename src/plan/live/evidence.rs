//! What the sensors of a plan say at a moment, in slots of the backend and read back from there. Of a sensor that did not
//! move since the last request nothing is cast again.

use std::sync::Arc;

use perirobot_march::Result;
use perirobot_march::backend::{Backend, GridPose, Planes, Rays, Reading, Shot, Slot, VoxelScene};
use perirobot_march::error::Issue;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::Study;
use perirobot_study::sensor::{Claim, Setting, Station};
use perirobot_study::world::{PlacementProblem, World, ray_tables_of};

use super::Resolution;
use super::frustum::Frustum;
use super::mid_air::placement_problem;

/// Sensors that are kept though the plan does not have them now.
const MOST_KEPT: usize = 64;

/// Which sensor, and how it stands: all that its evidence depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Standpoint {
    sensor: usize,
    setting: Setting,
    placement: GridPose,
}

/// What a sensor says.
#[derive(Clone)]
pub(super) struct Said {
    standpoint: Standpoint,
    slots: Vec<Slot>,
    /// What it adds to a fusion, if it says anything.
    pub(super) reading: Option<Reading>,
    /// All of its evidence, over the window of the regions.
    pub(super) planes: Arc<Planes>,
    pub(super) frustum: Option<Arc<Frustum>>,
    pub(super) problem: Option<PlacementProblem>,
}

/// What a backend holds of a moment.
pub(super) struct HeldEvidence {
    of: (Resolution, usize, usize),
    /// The sensors whose tables of rays are ready, and the tables.
    tables: Vec<(usize, Rays)>,
    said: Vec<Said>,
    vacant: Vec<Slot>,
}

impl HeldEvidence {
    /// Of a moment in one repeat, which the backend loads.
    pub(super) fn new(
        of: (Resolution, usize, usize),
        world: &World,
        backend: &mut dyn Backend,
    ) -> Result<HeldEvidence> {
        // One moment alone is cast against all blockers at once.
        let scene = VoxelScene { over_time: None, ..world.scene(window_of(&world.regions)) };
        backend.load(&scene)?;
        let vacant = (0..backend.slots() as Slot).rev().collect();
        Ok(HeldEvidence { of, tables: Vec::new(), said: Vec::new(), vacant })
    }

    /// Whether it is of this moment.
    pub(super) fn is_of(&self, of: (Resolution, usize, usize)) -> bool {
        self.of == of
    }

    /// What sensors at candidates say, cast if it is not known. `frustum` makes what is drawn of a sensor with rays.
    pub(super) fn say(
        &mut self,
        (study, world): (&Study, &World),
        members: &[[usize; 2]],
        frustum: &dyn Fn(usize, &Rays, &GridPose) -> Frustum,
        backend: &mut dyn Backend,
    ) -> Result<Vec<Said>> {
        self.make_tables(study, members, backend)?;
        let truth = world.truth();
        let repeat = self.of.2;
        let station = |&[sensor, candidate]: &[usize; 2]| {
            let rays = self.tables.iter().find(|(own, _)| *own == sensor).map(|(_, rays)| rays);
            let at = world.station(study, &truth, [sensor, candidate, repeat]);
            Station { window: window_of(&world.regions), rays, ..at }
        };
        let standpoint = |member: &[usize; 2], station: &Station| {
            let placement = station.placement(&*study.sensors[member[0]].kind);
            Standpoint { sensor: member[0], setting: station.setting, placement }
        };
        let wanted: Vec<Standpoint> = members.iter().map(|one| standpoint(one, &station(one))).collect();
        let missing: Vec<usize> = (0..members.len())
            .filter(|&place| self.said.iter().all(|said| said.standpoint != wanted[place]))
            .collect();
        let fresh: Vec<(usize, Claim, Option<Frustum>)> = missing
            .iter()
            .map(|&place| {
                let station = station(&members[place]);
                let [sensor, _] = members[place];
                let claim = study.sensors[sensor].kind.claims(&station).swap_remove(0);
                let drawn = station.rays.map(|rays| frustum(sensor, rays, &wanted[place].placement));
                (place, claim, drawn)
            })
            .collect();
        self.forget(&wanted, 2 * fresh.len())?;
        let mut uploads = Vec::new();
        let mut shots: Vec<Vec<Shot>> = vec![Vec::new(); self.tables.len()];
        let mut new = Vec::new();
        for (place, Claim { cast, planes }, drawn) in fresh {
            let (sensor, kind) = (members[place][0], &study.sensors[members[place][0]].kind);
            let mut slots = Vec::new();
            let mut take = |vacant: &mut Vec<Slot>| {
                let slot = vacant.pop().expect("room was made");
                slots.push(slot);
                slot
            };
            let table = self.tables.iter().position(|(own, _)| *own == sensor).filter(|_| cast);
            let cast = table.map(|table| (table, take(&mut self.vacant)));
            let placement = wanted[place].placement;
            cast.iter().for_each(|&(table, slot)| shots[table].push(Shot::once(slot, placement)));
            let added = planes.map(|planes| {
                let slot = take(&mut self.vacant);
                uploads.push((slot, planes));
                slot
            });
            let ([hit, miss], presence) = (kind.log_odds(0), kind.feels_presence(0));
            let reading = match (cast, added) {
                (Some((_, slot)), volume) => Some(Reading { slot, volume, hit, miss, presence }),
                (None, slot) => slot.map(|slot| Reading { slot, volume: None, hit, miss, presence }),
            };
            new.push((place, slots, reading, drawn));
        }
        for (table, shots) in shots.iter().enumerate().filter(|(_, shots)| !shots.is_empty()) {
            backend.sense(table, shots)?;
        }
        backend.upload(uploads)?;
        for (place, slots, reading, drawn) in new {
            let mut planes = Planes::blank(window_of(&world.regions));
            backend.planes(&slots)?.iter().for_each(|part| planes.add(part));
            let said = Said {
                standpoint: wanted[place],
                slots,
                reading,
                planes: planes.into(),
                frustum: drawn.map(Arc::new),
                problem: placement_problem(world, study, members[place]),
            };
            self.said.push(said);
        }
        let known = |wanted: &Standpoint| self.said.iter().find(|said| said.standpoint == *wanted).cloned();
        Ok(wanted.iter().map(|wanted| known(wanted).expect("it was just made")).collect())
    }

    /// Makes tables ready, of the sensors that have some and of these.
    fn make_tables(
        &mut self,
        study: &Study,
        members: &[[usize; 2]],
        backend: &mut dyn Backend,
    ) -> Result<()> {
        let has = |sensor: usize| self.tables.iter().any(|(own, _)| *own == sensor);
        let new =
            ray_tables_of(study, |sensor| !has(sensor) && members.iter().any(|member| member[0] == sensor));
        let new = new.into_iter().enumerate().filter_map(|(sensor, rays)| Some((sensor, rays?)));
        let new: Vec<(usize, Rays)> = new.collect();
        if !new.is_empty() {
            self.tables.extend(new);
            backend.tables(&self.tables.iter().map(|(_, rays)| rays.clone()).collect::<Vec<_>>())?;
        }
        Ok(())
    }

    /// Makes room for so many slots by forgetting what is not wanted, the oldest first.
    fn forget(&mut self, wanted: &[Standpoint], slots: usize) -> Result<()> {
        let is_wanted = |said: &Said| wanted.contains(&said.standpoint);
        while self.said.len() > MOST_KEPT || self.vacant.len() < slots {
            let Some(oldest) = self.said.iter().position(|said| !is_wanted(said)) else { break };
            self.vacant.extend(self.said.remove(oldest).slots);
        }
        match self.vacant.len() < slots {
            true => {
                Err(Issue::too_large("the evidence of the plan's sensors does not fit the backend at once")
                    .with_advice("take larger voxels, smaller regions, or the CPU")
                    .into())
            }
            false => Ok(()),
        }
    }
}
