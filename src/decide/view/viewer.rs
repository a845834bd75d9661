//! Computes views: the evidence of a choice's sensors, from the host and from a backend, and the labels.

use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, OnceLock};

use rayon::prelude::*;

use super::why::witness::Fan;
use super::{Choice, SensorView, View};
use perirobot_march::Result;
use perirobot_march::backend::cpu::BlockerSearch;
use perirobot_march::backend::{Backend, GridPose, Planes, Rays, Shot, Slot, fuse};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_scene::truth::Truth;
use perirobot_scene::truth::region::window_of;
use perirobot_study::input::Study;
use perirobot_study::sensor::{Claim, Station};
use perirobot_study::world::{World, ray_tables};
use perirobot_sweep::scoring::BatchSize;

/// Computes views of many choices on a backend; shared data of choices and worlds is prepared once.
pub struct Viewer<'a, 'b> {
    study: &'a Study,
    tables: Arc<Vec<Option<Rays>>>,
    backend: &'b mut dyn Backend,
    loaded: Option<LoadedWorld<'a>>,
}

/// A world that the backend has loaded with evidence over a window, and data shared by its views.
#[derive(Clone)]
struct LoadedWorld<'a> {
    study: &'a Study,
    tables: Arc<Vec<Option<Rays>>>,
    world: &'a World,
    window: Window,
    truth: Arc<Truth>,
    search: Arc<OnceLock<BlockerSearch>>,
    fans: Arc<OnceLock<BTreeMap<usize, Fan>>>,
}

/// A sensor at a candidate in a repeat, by their indices.
type Standpoint = [usize; 3];

impl<'a, 'b> Viewer<'a, 'b> {
    /// A viewer for the choices of a study. The backend unloads its previous scene.
    pub fn new(study: &'a Study, backend: &'b mut dyn Backend) -> Result<Viewer<'a, 'b>> {
        let tables = ray_tables(study);
        backend.tables(&tables.iter().flatten().cloned().collect::<Vec<_>>())?;
        Ok(Viewer { study, tables: tables.into(), backend, loaded: None })
    }

    /// The view of a choice over the whole grid. Consecutive views of the same world are faster.
    pub fn view(&mut self, world: &'a World, choice: Choice) -> Result<View<'a>> {
        let loaded = self.load(world, world.grid.window())?;
        let mut members = loaded.members(choice);
        for member in members.iter_mut().filter(|member| member.casts) {
            let cast = self.backend.read(self.table(member.sensor), &member.placement)?;
            member.says.add(&cast.planes);
            member.cast = Some(cast);
        }
        Ok(loaded.view(choice, members))
    }

    /// Views of choices in a world that cover only the voxels of regions: each sensor is cast once at each candidate,
    /// as in a sweep, and single rays are not stored.
    pub fn view_regions(&mut self, world: &'a World, choices: &[Choice]) -> Result<Vec<View<'a>>> {
        self.view_window(world, window_of(&world.regions), choices)
    }

    /// The same for all voxels of the grid.
    pub fn view_grid(&mut self, world: &'a World, choices: &[Choice]) -> Result<Vec<View<'a>>> {
        self.view_window(world, world.grid.window(), choices)
    }

    /// The view of a choice for one voxel: each sensor casts only the rays that affect it.
    pub fn view_voxel(&mut self, world: &'a World, voxel: [i32; 3], choice: Choice) -> Result<View<'a>> {
        let window = Window::from_corners(voxel, voxel);
        Ok(self.view_window(world, window, &[choice])?.swap_remove(0))
    }

    fn view_window(&mut self, world: &'a World, window: Window, choices: &[Choice]) -> Result<Vec<View<'a>>> {
        let loaded = self.load(world, window)?;
        let members: Vec<_> = choices.par_iter().map(|&choice| loaded.members(choice)).collect();
        let standpoint = |choice: &Choice, member: &SensorView| -> Standpoint {
            [member.sensor, member.candidate, choice.repeat]
        };
        let mut wanted = BTreeMap::new();
        for (choice, members) in choices.iter().zip(&members) {
            let casting = members.iter().filter(|member| member.casts);
            wanted.extend(casting.map(|member| (standpoint(choice, member), member.placement)));
        }
        let planes = self.cast(&wanted.into_iter().collect::<Vec<_>>())?;
        let view = |(choice, mut members): (&Choice, Vec<SensorView>)| {
            for member in members.iter_mut().filter(|member| member.casts) {
                member.says.add(&planes[&standpoint(choice, member)]);
            }
            loaded.view(*choice, members)
        };
        Ok(choices.par_iter().zip(members).map(view).collect())
    }

    /// The evidence of rays from some standpoints, sorted by sensor.
    fn cast(&mut self, wanted: &[(Standpoint, GridPose)]) -> Result<HashMap<Standpoint, Planes>> {
        let mut planes = HashMap::new();
        for of_sensor in wanted.chunk_by(|(a, _), (b, _)| a[0] == b[0]) {
            let [sensor, ..] = of_sensor[0].0;
            let rays = self.tables[sensor].as_ref().map_or(1, |table| table.dirs_q15.len().max(1));
            let most = (BatchSize::FULL.rays_on(self.backend) / rays).clamp(1, self.backend.slots().max(1));
            for some in of_sensor.chunks(most) {
                let slots: Vec<Slot> = (0..some.len() as Slot).collect();
                let shots =
                    slots.iter().zip(some).map(|(&slot, (_, placement))| Shot::once(slot, *placement));
                let table = self.table(sensor);
                self.backend.sense(table, &shots.collect::<Vec<_>>())?;
                planes.extend(some.iter().map(|(of, _)| *of).zip(self.backend.planes(&slots)?));
            }
        }
        Ok(planes)
    }

    /// Loads a world with evidence over a window, unless it is loaded.
    fn load(&mut self, world: &'a World, window: Window) -> Result<LoadedWorld<'a>> {
        let before = self.loaded.take().filter(|known| std::ptr::eq(known.world, world));
        if before.as_ref().is_none_or(|known| known.window != window) {
            let mut scene = world.scene(window);
            if window != window_of(&world.regions) || window == world.grid.window() {
                // Backends label only the voxels of regions.
                scene.regions = vec![BitGrid::full(window)];
            }
            self.backend.load(&scene)?;
        }
        let (study, tables) = (self.study, self.tables.clone());
        let loaded = match before {
            Some(known) => LoadedWorld { window, ..known },
            None => {
                let (search, fans) = (Arc::default(), Arc::default());
                LoadedWorld { study, tables, world, window, truth: world.truth(), search, fans }
            }
        };
        self.loaded = Some(loaded.clone());
        Ok(loaded)
    }

    /// The backend's index of a sensor's ray table.
    fn table(&self, sensor: usize) -> usize {
        self.tables[..sensor].iter().flatten().count()
    }
}

impl<'a> LoadedWorld<'a> {
    /// The sensors of a choice in the order of precedence, with all evidence but that of rays.
    fn members(&self, choice: Choice) -> Vec<SensorView> {
        let study = self.study;
        let combination = &study.combinations[choice.combination];
        let candidates = combination.choice(choice.choice);
        let representations = combination.representations(&study.sensors).swap_remove(choice.representation);
        let each = combination.members.iter().zip(candidates).zip(representations);
        let member = |((member, candidate), way): ((&perirobot_study::input::Member, usize), usize)| {
            let (sensor, kind) = (member.sensor, &study.sensors[member.sensor].kind);
            let rays = self.tables[sensor].as_ref();
            let station = Station {
                rays,
                ..self.world.station(study, &self.truth, [sensor, candidate, choice.repeat])
            };
            let Claim { cast, planes } = kind.claims(&station).swap_remove(way);
            let casts = cast && rays.is_some();
            // For a sensor without rays, the whole volume decides whether it has any label.
            let mut says = Planes::blank(if casts { self.window } else { station.window });
            planes.iter().for_each(|planes| says.add(planes));
            SensorView {
                sensor,
                candidate,
                placement: station.placement(&**kind),
                casts,
                cast: None,
                says,
                presence: kind.feels_presence(way),
            }
        };
        each.map(member).collect()
    }

    /// The view of a choice from the complete evidence of its sensors.
    fn view(&self, choice: Choice, members: Vec<SensorView>) -> View<'a> {
        let LoadedWorld { study, tables, world, window, truth, search, fans } = self.clone();
        let combination = &study.combinations[choice.combination];
        let representations = combination.representations(&study.sensors).swap_remove(choice.representation);
        let voice = |(member, way): (&SensorView, usize)| {
            (member.says.clone(), study.sensors[member.sensor].kind.log_odds(way))
        };
        let voices: Vec<_> = members.iter().zip(representations).map(voice).collect();
        let labels = fuse(window, combination.fusion, &voices);
        View { study, world, truth, choice, members, labels, tables, search, fans }
    }
}
