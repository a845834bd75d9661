//! The floor plan of a scene, seen from above, as SVG: walls and furniture with names, the robot and its reach, people,
//! entries, regions, the fields of view of a choice's sensors, and the unwatched floor.
//!
//! Colours are those of roles in pictures, as variables that follow a dark scheme. A plan is a file of its own, or a
//! part of a page, where several share their style and their patterns.

mod field;
mod ground;
pub(crate) mod labels;
mod legend;
mod names;
mod paper;
mod ways;

use std::fmt::Display;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::svg::{Svg, tenth};
use crate::letters::letter;
use ground::Storey;
use labels::PlacedLabels;
pub use legend::{PATTERNS, STYLE, swatch};
pub(super) use names::named_things;
pub use names::short_name;
use paper::Paper;
use perirobot_decide::approach::walked_surfaces;
use perirobot_decide::view::Choice;
use perirobot_decide::view::watched::Watchers;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;
use perirobot_scene::pose::Pose;
use perirobot_scene::truth::{ObjectVoxels, Region, Truth};
use perirobot_study::input::{EntryPlace, Study};
use perirobot_study::sensor::Setting;
use perirobot_study::world::place::room_m;
use perirobot_study::world::{World, ray_table};

/// A floor plan.
#[derive(Clone, Debug)]
pub struct FloorPlan {
    /// The signs used, with their meaning.
    pub legend: Vec<(&'static str, String)>,
    /// The letter of each sensor of the choice, and its name; no letter without a pose.
    pub sensors: Vec<(Option<String>, String)>,
    /// The area of the floor, of its unwatched part and of its hardly watched part, in square metres.
    pub floor_m2: [f64; 3],
    title: String,
    drawing: Svg,
    paper: Paper,
}

/// The inputs of a plan.
struct Drawing<'a> {
    study: &'a Study,
    /// The snapshots of the scene, and the drawn one.
    worlds: &'a [World],
    world: &'a World,
    truth: Arc<Truth>,
    room_m: [DVec3; 2],
    storey: Storey,
    paper: Paper,
    svg: Svg,
    labels: PlacedLabels,
    legend: Vec<(&'static str, String)>,
    /// The seen or guarded area of each sensor, as words and the corners in the drawing.
    watched: Vec<(String, Vec<[f64; 2]>)>,
    /// The one region to outline; `None` for all.
    region: Option<usize>,
}

/// Draws the plan of a scene at one of its snapshots. The letters A, B and so on stand for the sensors of a choice of
/// poses, in their order.
pub fn floor_plan(study: &Study, worlds: &[World], snapshot: usize, choice: Option<Choice>) -> FloorPlan {
    draw((study, worlds), snapshot, choice, None)
}

/// The same with the outline of one region only, by its index.
pub fn region_plan(
    of_scene: (&Study, &[World]),
    snapshot: usize,
    choice: Option<Choice>,
    region: usize,
) -> FloorPlan {
    draw(of_scene, snapshot, choice, Some(region))
}

fn draw(
    (study, worlds): (&Study, &[World]),
    snapshot: usize,
    choice: Option<Choice>,
    region: Option<usize>,
) -> FloorPlan {
    let world = &worlds[snapshot];
    let truth = world.truth();
    let room_m = room_m(&truth);
    let storey = Storey::new(&truth, room_m, world.floor.z_m);
    let paper = Paper::new(extent(study, world, choice));
    let labels = PlacedLabels::new(paper.view());
    let (svg, legend) = (Svg::default(), Vec::new());
    let watched = Vec::new();
    let mut drawing =
        Drawing { study, worlds, world, truth, room_m, storey, paper, svg, labels, legend, watched, region };
    drawing.floor();
    drawing.furniture();
    let floor_m2 = choice.map_or([0.0; 3], |choice| drawing.watched_floor(choice));
    let sensors = choice.map_or(Vec::new(), |choice| drawing.fields(choice));
    drawing.robots_and_people();
    drawing.walls();
    drawing.entries();
    drawing.regions();
    if let Some(choice) = choice {
        drawing.badges(choice, &sensors);
    }
    drawing.names();
    drawing.names_of_regions();
    drawing.names_of_watched();
    drawing.names_of_walls();
    let Drawing { paper, mut svg, mut legend, .. } = drawing;
    paper.draw_axes(&mut svg);
    legend.sort_by_key(|(class, _)| ORDER.iter().position(|known| known == class));
    let title = format!("Floor plan of {}", world.title(study));
    FloorPlan { legend, sensors, floor_m2, title, drawing: svg, paper }
}

/// The order of the legend.
const ORDER: [&str; 12] = [
    "badge",
    "field",
    "plane",
    "pad",
    "blind",
    "hardly",
    "region",
    "robot",
    "robot other",
    "reach",
    "person",
    "entry",
];

/// The extent of the paper: the grid, and the ground that sensors guard.
fn extent(study: &Study, world: &World, choice: Option<Choice>) -> [DVec2; 2] {
    let grid = &world.grid;
    let mut corners = [[0; 3], grid.window().end()].map(|voxel| grid.corner_m(voxel)).to_vec();
    for (sensor, candidate) in choice.iter().flat_map(|choice| members(study, *choice)) {
        if let Setting::Pose(pose) = world.settings[sensor][candidate] {
            corners.extend(grounds(study, world, [sensor, candidate], &pose).into_iter().flatten());
        }
    }
    let flat = corners.iter().map(|corner| corner.truncate());
    let nowhere = [DVec2::INFINITY, DVec2::NEG_INFINITY];
    flat.fold(nowhere, |[low, high], corner| [low.min(corner), high.max(corner)])
}

/// The ground that a sensor feels, or guards with its rays, as corners.
fn grounds(study: &Study, world: &World, [sensor, candidate]: [usize; 2], pose: &Pose) -> Vec<Vec<DVec3>> {
    let kind = &study.sensors[sensor].kind;
    let prisms = kind.prisms().into_iter().map(|prism| prism.footprint_m(pose));
    let guarded = kind.guarded_now_m(&world.station(study, &world.truth(), [sensor, candidate, 0]));
    prisms.chain([guarded]).filter(|ground| !ground.is_empty()).collect()
}

/// The sensors of a choice with their candidates, in the order of the letters.
fn members(study: &Study, choice: Choice) -> Vec<(usize, usize)> {
    let combination = &study.combinations[choice.combination];
    let candidates = combination.choice(choice.choice);
    combination.members.iter().zip(candidates).map(|(member, one)| (member.sensor, one)).collect()
}

impl<'a> Drawing<'a> {
    /// The regions to outline.
    fn outlined_regions(&self) -> Vec<&'a Region> {
        match self.region {
            Some(region) => vec![&self.world.regions[region]],
            None => self.world.regions.iter().collect(),
        }
    }
}

impl Drawing<'_> {
    fn floor(&mut self) {
        let [left, top, right, bottom] = self.paper.edges();
        let path = format!("M{left} {top}H{right}V{bottom}H{left}Z");
        self.path("floor", &path);
    }

    fn path(&mut self, class: &str, path: &str) {
        if !path.is_empty() {
            self.svg.element("path", &[("class", &class), ("d", &path)]);
        }
    }

    /// A path with a tooltip.
    fn named_path(&mut self, class: &str, path: &str, name: &str) {
        if !path.is_empty() {
            self.svg.add_titled("path", &[("class", &class), ("d", &path)], name);
        }
    }

    fn explain(&mut self, class: &'static str, meaning: impl Into<String>) {
        if !self.legend.iter().any(|(known, _)| *known == class) {
            self.legend.push((class, meaning.into()));
        }
    }

    fn objects(&self, role: Role) -> Vec<Arc<ObjectVoxels>> {
        self.truth.objects.iter().filter(|object| object.role == role).cloned().collect()
    }

    /// Objects lower than a person, except walls.
    fn furniture(&mut self) {
        for object in self.objects(Role::Environment) {
            let mut flat = self.storey.footprint(&object.voxels);
            flat.remove(&self.storey.section(&object.voxels));
            let path = self.storey.outline(&flat, &self.paper);
            self.named_path("low", &path, &object.name);
        }
    }

    /// Objects at breast height: walls and everything as high, with their insides.
    fn walls(&mut self) {
        let path = self.storey.outline(&self.storey.voids, &self.paper);
        self.path("void", &path);
        for object in self.objects(Role::Environment) {
            let flat = self.storey.section(&object.voxels);
            let path = self.storey.outline(&flat, &self.paper);
            self.named_path(if object.stops_rays { "wall" } else { "mesh" }, &path, &object.name);
        }
    }

    /// The unwatched floor of the empty cell.
    fn watched_floor(&mut self, choice: Choice) -> [f64; 3] {
        let truth = Arc::new(self.world.truth_without_people());
        let watchers = Watchers::new(self.study, choice);
        let watch = watchers.watch(self.world, truth.clone());
        // An error of [approach] is reported by the commands that ask for approaches.
        let surfaces = walked_surfaces(self.study, self.worlds, watchers.each()).ok().flatten();
        let floor = match surfaces {
            Some(surfaces) => self.storey.walked_floor(&truth, &watch, &surfaces),
            None => self.storey.floor(&truth, &watch),
        };
        for (class, flat, meaning) in [
            ("blind", &floor.blind, "blind: nothing above this floor is watched, up to 1.8 m"),
            ("hardly", &floor.hardly, "less than half is watched"),
        ] {
            if !flat.is_empty() {
                let path = self.storey.outline(flat, &self.paper);
                self.path(class, &path);
                self.explain(class, meaning);
            }
        }
        [floor.columns, floor.blind.count(), floor.hardly.count()].map(|n| self.storey.area_m2(n))
    }

    /// The fields of view, or the ground that sensors feel.
    fn fields(&mut self, choice: Choice) -> Vec<(Option<String>, String)> {
        let mut named = Vec::new();
        for (number, (sensor, candidate)) in members(self.study, choice).into_iter().enumerate() {
            let kind = self.study.sensors[sensor].kind.clone();
            let setting = self.world.settings[sensor][candidate];
            let letter = matches!(setting, Setting::Pose(_)).then(|| letter(number));
            let spec = &self.study.sensors[sensor];
            named.push((letter.clone(), format!("{}:{}", spec.name, spec.candidates[candidate].name)));
            match setting {
                Setting::Pose(pose) => {
                    let short = letter.unwrap_or_default();
                    for ground in grounds(self.study, self.world, [sensor, candidate], &pose) {
                        let ground: Vec<DVec2> = ground.into_iter().map(DVec3::truncate).collect();
                        self.area("pad", &ground, format!("guarded by {short}"));
                        self.explain("pad", "ground that a sensor guards");
                    }
                    if let Some(rays) = ray_table(self.study, sensor).filter(|rays| !rays.dirs_q15.is_empty())
                    {
                        let field = field::field(&*kind, &rays, &pose, self.room_m, self.study.voxel_size_m);
                        if field::is_level(&*kind, &rays, &pose) {
                            self.area("plane", &field, format!("plane of {short}"));
                            self.explain(
                                "plane",
                                "the level plane that a scanner sees, whatever stands in its way",
                            );
                        } else {
                            self.area("field", &field, format!("view of {short}"));
                            self.explain("field", "where a sensor looks, whatever stands in its way");
                        }
                    }
                }
                Setting::Inflation(metres) => {
                    let width = tenth(2.0 * metres * self.paper.scale);
                    let path = self.storey.outline(&self.storey.shadow(&self.truth.robot), &self.paper);
                    let cover: [(&str, &dyn Display); 3] =
                        [("class", &"cover"), ("d", &path), ("stroke-width", &width)];
                    self.svg.element("path", &cover);
                }
                Setting::Fixed => {}
            }
        }
        named
    }

    /// The area of a sensor, to be named.
    fn area(&mut self, class: &str, corners: &[DVec2], words: String) {
        let ring = self.paper.ring(corners);
        self.path(class, &ring);
        self.watched.push((words, corners.iter().map(|&corner| self.paper.project(corner)).collect()));
    }

    /// The outlines of the regions, at any height.
    fn regions(&mut self) {
        for region in self.outlined_regions() {
            let path = self.storey.outline(&self.storey.shadow(&region.voxels), &self.paper);
            self.named_path("region", &path, &region.name);
            self.explain("region", "region in which is counted");
        }
    }

    /// Robots and people, also at other snapshots, and the reach of robots.
    fn robots_and_people(&mut self) {
        let roles = [
            (Role::Robot, "robot", "robot other", "robot", "robot at other moments"),
            (Role::Human, "person", "person other", "person", "person at other moments"),
        ];
        for (role, class, other, name, at_others) in roles {
            let areas = |truth: &Truth| {
                let own = truth.objects.iter().filter(|object| object.role == role);
                let mut all = BitGrid::new(self.world.grid.window());
                own.for_each(|object| all.add(&object.voxels));
                self.storey.shadow(&all)
            };
            let here = areas(&self.truth);
            let mut elsewhere = BitGrid::new(here.window());
            let others = self.worlds.iter().filter(|world| world.snapshot != self.world.snapshot);
            others.for_each(|world| elsewhere.add(&areas(&world.truth())));
            elsewhere.remove(&here);
            let path = self.storey.outline(&elsewhere, &self.paper);
            self.path(other, &path);
            let path = self.storey.outline(&here, &self.paper);
            self.path(class, &path);
            if !here.is_empty() || !elsewhere.is_empty() {
                let moves =
                    if elsewhere.is_empty() { String::new() } else { format!("; paler: {at_others}") };
                self.explain(class, format!("{name}{moves}"));
            }
        }
        for object in self.objects(Role::Robot) {
            let Some(reach) = object.reach else { continue };
            let [x, y] = self.paper.project_down(reach.base_m);
            self.clipped_circle(x, y, tenth(reach.radius_m * self.paper.scale));
            self.explain("reach", "how far the robot reaches");
        }
    }

    /// The part of a circle inside the cell.
    fn clipped_circle(&mut self, x: f64, y: f64, r: f64) {
        let [left, top, right, bottom] = self.paper.edges();
        // Points of the circle, in runs inside the cell.
        let mut path = String::new();
        let mut is_down = false;
        for step in 0..=180 {
            let (sin, cos) = libm::sincos(f64::from(step) * std::f64::consts::TAU / 180.0);
            let at = [tenth(x + r * cos), tenth(y + r * sin)];
            let is_in = (left..=right).contains(&at[0]) && (top..=bottom).contains(&at[1]);
            if is_in {
                path += &format!("{}{} {}", if is_down { "L" } else { "M" }, at[0], at[1]);
            }
            is_down = is_in;
        }
        self.path("reach", &path);
    }

    /// The entries of bodies.
    fn entries(&mut self) {
        for entry in &self.study.approach.entries {
            let EntryPlace::Box { min_m, max_m } = entry.place else { continue };
            let [low, high] = self.room_m.map(DVec3::truncate);
            let (a, b) = (min_m.truncate().max(low), max_m.truncate().min(high));
            if a.cmpge(b).any() {
                continue;
            }
            let ring = self.paper.ring(&[a, DVec2::new(b.x, a.y), b, DVec2::new(a.x, b.y)]);
            self.named_path("entry", &ring, &entry.name);
            self.explain("entry", "entry");
        }
    }
}

#[cfg(test)]
mod tests;
