//! The letters of sensors and the names in a floor plan: of furniture, robots, people, entries, walls and regions, and
//! of the areas of sensors. Names do not overlap.

use std::fmt::Display;

use glam::{DVec2, DVec3};

use super::ground::Storey;
use super::labels::Area;
use super::{Drawing, members};
use crate::render::svg::tenth;
use perirobot_decide::view::Choice;
use perirobot_scene::objects::Role;
use perirobot_scene::truth::Truth;
use perirobot_study::input::EntryPlace;
use perirobot_study::world::World;
use perirobot_study::world::place::{is_room, names_of_walls, room_m};

/// Font size for the layout, as large as on a phone.
const LETTERS: f64 = 23.0;
/// Half the height of a lower-case letter.
const HALF: f64 = 5.0;
/// The circle with a sensor's letter.
const BADGE: f64 = 12.0;
/// The length of the line in a sensor's direction of view.
const LOOK: f64 = 26.0;
/// From the cell to the middle of the name of a wall: at its side, and below it under the numbers of the axis.
const BESIDE_WALL: f64 = 16.0;
const BELOW_WALL: f64 = 34.0;
/// Tried places for a name across an area.
const PLACES: usize = 16;

impl Drawing<'_> {
    /// The letters of the sensors, with a line in their direction of view.
    pub(super) fn badges(&mut self, choice: Choice, sensors: &[(Option<String>, String)]) {
        let mut taken: Vec<[f64; 2]> = Vec::new();
        for ((sensor, candidate), (letter, name)) in members(self.study, choice).into_iter().zip(sensors) {
            let Some(letter) = letter else { continue };
            let pose = self.world.settings[sensor][candidate].pose();
            let [x, y] = self.paper.project_down(pose.position_m);
            let ahead = pose.link().x_axis.truncate();
            let is_level = ahead.length() > 0.05 && self.study.sensors[sensor].kind.prisms().is_empty();
            if is_level {
                let [dx, dy] = [ahead.x, -ahead.y].map(|part| tenth(part / ahead.length() * LOOK));
                self.path("look", &format!("M{x} {y}l{dx} {dy}"));
            }
            let mut at = [x, y];
            let is_near = |a: &[f64; 2], b: &[f64; 2]| {
                (a[0] - b[0]).abs() < 2.0 * BADGE && (a[1] - b[1]).abs() < 2.0 * BADGE
            };
            while taken.iter().any(|other| is_near(other, &at)) {
                at[0] = tenth(at[0] + 2.0 * BADGE + 2.0);
            }
            // The last of a row at the right edge moves to the left.
            at[0] = at[0].min(self.paper.view()[2] - BADGE - 1.0);
            taken.push(at);
            let [x, y] = at;
            let circle: [(&str, &dyn Display); 4] =
                [("class", &"badge"), ("cx", &x), ("cy", &y), ("r", &BADGE)];
            self.svg.add_titled("circle", &circle, name);
            let baseline = tenth(y + HALF);
            let text: [(&str, &dyn Display); 4] =
                [("class", &"letter"), ("x", &x), ("y", &baseline), ("text-anchor", &"middle")];
            self.svg.words(&text, &letter.to_string());
            self.labels.take([x - BADGE, y - BADGE, x + BADGE, y + BADGE]);
            self.explain("badge", "sensor");
        }
    }

    /// The names of furniture, robots, people and entries, if there is room.
    pub(super) fn names(&mut self) {
        let class = |role: Role| match role {
            Role::Robot => "of-robot",
            Role::Human => "of-person",
            Role::Environment => "of-thing",
        };
        let things = things(&self.truth, &self.storey, self.room_m).into_iter();
        let mut names: Vec<(&str, String, [DVec2; 2])> = things
            .map(|thing| (class(thing.role), thing.name, [thing.low_m, thing.high_m].map(DVec3::truncate)))
            .collect();
        for entry in &self.study.approach.entries {
            if let EntryPlace::Box { min_m, max_m } = entry.place {
                let [low, high] = self.room_m.map(DVec3::truncate);
                let area = [min_m, max_m].map(|corner| corner.truncate().clamp(low, high));
                names.push(("of-entry", entry.name.clone(), area));
            }
        }
        for (class, name, extent) in names {
            let area = self.on_paper(extent);
            if let Some(at) = self.labels.place(&name, LETTERS, area) {
                self.word(class, &name, at);
            }
        }
    }

    /// The names of regions, each on its outline.
    pub(super) fn names_of_regions(&mut self) {
        for region in self.outlined_regions() {
            let [left, top, right, bottom] =
                self.on_paper(self.storey.extent(&self.storey.shadow(&region.voxels)));
            let along = |n: usize| [0.5, 0.3, 0.7, 0.15, 0.85][n];
            let across = |n: usize| left + (right - left) * along(n);
            let down = |n: usize| top + (bottom - top) * along(n);
            let places = (0..5)
                .flat_map(|n| [[across(n), top], [across(n), bottom], [right, down(n)], [left, down(n)]]);
            self.name_at("of-region", &format!("region {}", region.name), places);
        }
    }

    /// The names of the sensors' areas, at the places with the fewest other areas.
    pub(super) fn names_of_watched(&mut self) {
        let watched = std::mem::take(&mut self.watched);
        let [left, top, right, bottom] = self.paper.edges();
        for (words, corners) in &watched {
            let share = |n: usize| (n as f64 + 0.5) / PLACES as f64;
            let grid = (0..PLACES * PLACES).map(|n| {
                [left + (right - left) * share(n % PLACES), top + (bottom - top) * share(n / PLACES)]
            });
            let mut places: Vec<[f64; 2]> = grid.filter(|&place| is_inside(corners, place)).collect();
            let middle =
                [0, 1].map(|r| places.iter().map(|place| place[r]).sum::<f64>() / places.len().max(1) as f64);
            let merit = |place: &[f64; 2]| {
                let others = watched.iter().filter(|(_, others)| is_inside(others, *place)).count();
                (others, (0..2).map(|r| (place[r] - middle[r]).powi(2)).sum::<f64>())
            };
            places.sort_by(|a, b| {
                let (a, b) = (merit(a), merit(b));
                a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
            });
            self.name_at("of-field", words, places);
        }
    }

    /// The names of walls, along the edges of the cell.
    pub(super) fn names_of_walls(&mut self) {
        let [left, top, right, bottom] = self.paper.edges();
        let [x, y] = [(left + right) / 2.0, (top + bottom) / 2.0];
        let places = [
            ([left - self.paper.number_margin(), y], -90),
            ([right + BESIDE_WALL, y], 90),
            ([x, bottom + BELOW_WALL], 0),
            ([x, top - BESIDE_WALL], 0),
        ];
        for (names, ([x, y], turn)) in names_of_walls(self.study, &self.truth).iter().zip(places) {
            if names.is_empty() {
                continue;
            }
            let place = format!("translate({} {}) rotate({turn})", tenth(x), tenth(y));
            let text: [(&str, &dyn Display); 4] =
                [("class", &"of-wall"), ("transform", &place), ("y", &HALF), ("text-anchor", &"middle")];
            self.svg.words(&text, &names.join(", "));
        }
    }

    /// A box of the world in the drawing.
    fn on_paper(&self, [low, high]: [DVec2; 2]) -> Area {
        let ([left, bottom], [right, top]) = (self.paper.project(low), self.paper.project(high));
        [left, top, right, bottom]
    }

    /// Writes a name at the first place with room.
    fn name_at(&mut self, class: &str, name: &str, places: impl IntoIterator<Item = [f64; 2]>) {
        if let Some(at) = self.labels.place_at(name, LETTERS, places) {
            self.word(class, name, at);
        }
    }

    /// Writes a name with its middle at a place.
    fn word(&mut self, class: &str, name: &str, [x, y]: [f64; 2]) {
        let (x, y) = (tenth(x), tenth(y + HALF));
        let text: [(&str, &dyn Display); 4] =
            [("class", &class), ("x", &x), ("y", &y), ("text-anchor", &"middle")];
        self.svg.words(&text, name);
    }
}

/// A named object in a picture from above, and the box of its largest part.
pub(crate) struct Thing {
    role: Role,
    pub(crate) name: String,
    pub(crate) low_m: DVec3,
    pub(crate) high_m: DVec3,
}

/// Robots, people and furniture of a cell, in the order of their labels.
pub(crate) fn named_things(world: &World) -> Vec<Thing> {
    let truth = world.truth();
    let room_m = room_m(&truth);
    let storey = Storey::new(&truth, room_m, world.floor.z_m);
    things(&truth, &storey, room_m)
}

fn things(truth: &Truth, storey: &Storey, room_m: [DVec3; 2]) -> Vec<Thing> {
    let mut things = Vec::new();
    for role in [Role::Robot, Role::Human, Role::Environment] {
        for object in truth.objects.iter().filter(|object| object.role == role && !is_room(object, room_m)) {
            let flat = match role {
                Role::Environment => storey.footprint(&object.voxels),
                _ => storey.shadow(&object.voxels),
            };
            if flat.is_empty() {
                continue;
            }
            let [low, high] = storey.extent_of_largest(&flat);
            things.push(Thing {
                role,
                name: short_name(&object.name).into(),
                low_m: low.extend(object.bounds_m[0].z),
                high_m: high.extend(object.bounds_m[1].z),
            });
        }
    }
    things
}

/// The name of an object without its file and the wildcard: `plant/Fence*` becomes Fence. A number alone is not a name:
/// `bent/0` stays.
pub fn short_name(name: &str) -> &str {
    let own = name.rsplit('/').find(|part| !part.is_empty()).unwrap_or(name).trim_end_matches('*');
    if own.contains(char::is_alphabetic) { own } else { name }
}

/// Whether a place is within a ring of corners.
fn is_inside(corners: &[[f64; 2]], [x, y]: [f64; 2]) -> bool {
    let edges = (0..corners.len()).map(|n| [corners[n], corners[(n + 1) % corners.len()]]);
    let crossed = edges
        .filter(|[a, b]| (a[1] > y) != (b[1] > y) && x < a[0] + (y - a[1]) * (b[0] - a[0]) / (b[1] - a[1]));
    crossed.count() % 2 == 1
}
