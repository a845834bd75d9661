//! The positions of a sensor on paper: walls unfolded around the ceiling as seen from above, other groups of positions
//! each on its own map.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

/// Largest distance of a position that hangs on a wall.
const NEAR_M: f64 = 0.5;

/// Positions with larger distances form no lattice.
const WIDEST_M: f64 = 2.0;

/// A position of a sensor.
#[derive(Clone, Copy, Debug)]
pub(super) struct Position<'a> {
    /// Index of its candidate.
    pub(super) candidate: usize,
    pub(super) group: &'a str,
    pub(super) at: DVec3,
}

/// A map to be drawn.
#[derive(Clone, Debug)]
pub(super) struct Map {
    /// Its title.
    pub(super) title: String,
    /// The axes to the right and up; `None` for unfolded walls.
    pub(super) axes: Option<[usize; 2]>,
    /// The corners of the drawing.
    pub(super) ends: [DVec2; 2],
    /// The corners of the part seen from above: the ceiling with the walls around it, or all.
    pub(super) flat: [DVec2; 2],
    /// Its parts, side by side.
    pub(super) parts: Vec<MapPart>,
}

/// Positions in one plane.
#[derive(Clone, Debug)]
pub(super) struct MapPart {
    pub(super) label: Option<Label>,
    pub(super) face: Face,
    pub(super) spots: Vec<PaperSpot>,
    /// Width and height of a spot in a lattice.
    pub(super) size: Option<DVec2>,
}

/// The name of a wall or of the ceiling.
#[derive(Clone, Debug)]
pub(super) struct Label {
    pub(super) text: String,
    /// Its place, at the outer edge.
    pub(super) at: DVec2,
    pub(super) is_turned: bool,
}

/// Candidates at the same place on paper.
#[derive(Clone, Debug)]
pub(super) struct PaperSpot {
    pub(super) at: DVec2,
    pub(super) candidates: Vec<usize>,
}

/// A projection from the room to paper.
#[derive(Clone, Copy, Debug)]
pub(super) enum Face {
    /// A side of a room between two corners, which is folded out.
    Folded(RoomSide, [DVec3; 2]),
    /// A plane along two axes.
    Plane([usize; 2]),
}

impl Face {
    /// Whether it is seen from straight above.
    pub(super) fn is_plan(&self) -> bool {
        matches!(self, Face::Folded(RoomSide(2, _), _) | Face::Plane([0, 1]))
    }

    /// The projection of a place.
    fn lay(&self, at: DVec3) -> DVec2 {
        match *self {
            Face::Folded(side, room) => side.lay(at, room),
            Face::Plane([u, v]) => DVec2::new(at[u], at[v]),
        }
    }

    /// The corners of a box's projection.
    pub(super) fn shadow(&self, [low, high]: [DVec3; 2]) -> [DVec2; 2] {
        let [a, b] = [self.lay(low), self.lay(high)];
        [a.min(b), a.max(b)]
    }
}

/// A side of a room: the axis across it, and whether it is the upper one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RoomSide(usize, bool);

const SIDES: [RoomSide; 5] =
    [RoomSide(2, true), RoomSide(0, false), RoomSide(0, true), RoomSide(1, false), RoomSide(1, true)];

impl RoomSide {
    /// The distance of the farthest of some positions from it.
    fn farthest_m(self, all: &[Position], room: [DVec3; 2]) -> f64 {
        let away = |one: &Position| (one.at[self.0] - room[usize::from(self.1)][self.0]).abs();
        all.iter().map(away).fold(0.0, f64::max)
    }

    /// The place of a point on it: the ceiling as in the room, a wall as it is folded out.
    fn lay(self, at: DVec3, [low, high]: [DVec3; 2]) -> DVec2 {
        let down = high.z - at.z;
        match self {
            RoomSide(0, false) => DVec2::new(low.x - down, at.y),
            RoomSide(0, true) => DVec2::new(high.x + down, at.y),
            RoomSide(1, false) => DVec2::new(at.x, low.y - down),
            RoomSide(1, true) => DVec2::new(at.x, high.y + down),
            _ => at.truncate(),
        }
    }

    /// Its name at its outer edge: that of a wall at its foot.
    fn label(self, text: String, [low, high]: [DVec3; 2]) -> Label {
        let mut edge = (low + high) / 2.0;
        match self.0 {
            2 => edge.y = high.y,
            _ => edge.z = low.z,
        }
        Label { text, at: self.lay(edge, [low, high]), is_turned: self.0 == 0 }
    }
}

/// The maps of some positions in a room; without one, as for positions on a link, no wall is unfolded.
pub(super) fn maps(positions: &[Position], room: Option<[DVec3; 2]>) -> Vec<Map> {
    let mut groups: Vec<(&str, Vec<Position>)> = Vec::new();
    for position in positions {
        match groups.iter_mut().find(|(name, _)| *name == position.group) {
            Some((_, all)) => all.push(*position),
            None => groups.push((position.group, vec![*position])),
        }
    }
    let sides = SIDES.into_iter().filter(|_| room.is_some());
    let mut sides: Vec<(RoomSide, Vec<&str>, Vec<Position>)> =
        sides.map(|side| (side, Vec::new(), Vec::new())).collect();
    let far =
        |side: &RoomSide, all: &[Position]| room.map_or(f64::INFINITY, |room| side.farthest_m(all, room));
    let mut own: Vec<(String, Vec<Position>)> = Vec::new();
    for (name, all) in groups {
        // A row high on a wall is also near the ceiling: the nearest side counts.
        let nearest = sides.iter_mut().min_by(|(a, ..), (b, ..)| far(a, &all).total_cmp(&far(b, &all)));
        match nearest.filter(|(side, ..)| far(side, &all) <= NEAR_M) {
            Some((_, names, found)) => {
                names.push(name);
                found.extend(all);
            }
            None => own.push((name.replace('-', " "), all)),
        }
    }
    sides.retain(|(.., found)| !found.is_empty());
    let words = |names: &[&str]| names.join(", ").replace('-', " ");
    let mut maps = Vec::new();
    if let [(_, names, found)] = &mut sides[..] {
        own.insert(0, (words(names), std::mem::take(found)));
    } else if let Some(room) = room.filter(|_| !sides.is_empty()) {
        let parts = sides.iter().map(|(side, names, found)| {
            MapPart::new(found, Face::Folded(*side, room), Some(side.label(words(names), room)))
        });
        let [low, high] = room.map(DVec3::truncate);
        let height = DVec2::splat(room[1].z - room[0].z);
        let title = "walls unfolded around the ceiling, seen from above".into();
        let ends = [low - height, high + height];
        maps.push(Map { title, axes: None, ends, flat: [low, high], parts: parts.collect() });
    }
    maps.extend(own.into_iter().map(|(title, all)| {
        let axes = plane(&all);
        let part = MapPart::new(&all, Face::Plane(axes), None);
        let more = part.size.unwrap_or(DVec2::splat(0.4)) / 2.0 + 0.1;
        let nothing = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        let around = part.spots.iter().fold(nothing, |[a, b], spot| [a.min(spot.at), b.max(spot.at)]);
        let ends = [around[0] - more, around[1] + more];
        Map { title, axes: Some(axes), ends, flat: ends, parts: vec![part] }
    }));
    maps
}

/// The two axes with the largest spread of positions.
fn plane(all: &[Position]) -> [usize; 2] {
    let [low, high] =
        all.iter().fold([DVec3::INFINITY, DVec3::NEG_INFINITY], |[a, b], one| [a.min(one.at), b.max(one.at)]);
    let spread = high - low;
    // The upper axes first, so that level positions are seen from above.
    let normal = [2, 1, 0]
        .into_iter()
        .fold(2, |least, axis| if spread[axis] < spread[least] - 1e-9 { axis } else { least });
    match normal {
        0 => [1, 2],
        1 => [0, 2],
        _ => [0, 1],
    }
}

impl MapPart {
    fn new(all: &[Position], face: Face, label: Option<Label>) -> MapPart {
        let mut spots: BTreeMap<[i64; 2], PaperSpot> = BTreeMap::new();
        for one in all {
            let at = face.lay(one.at);
            let key = at.to_array().map(|metres| (metres * 1e6).round() as i64);
            spots
                .entry(key)
                .or_insert(PaperSpot { at, candidates: Vec::new() })
                .candidates
                .push(one.candidate);
        }
        let keys: Vec<[i64; 2]> = spots.keys().copied().collect();
        MapPart { label, face, size: lattice(&keys), spots: spots.into_values().collect() }
    }
}

/// The steps of the lattice of some places in millionths of a metre, if they form a dense one.
fn lattice(places: &[[i64; 2]]) -> Option<DVec2> {
    let axis = |n: usize| {
        let mut all: Vec<i64> = places.iter().map(|place| place[n]).collect();
        all.sort_unstable();
        all.dedup();
        all
    };
    let (across, up) = (axis(0), axis(1));
    let step = |all: &[i64]| {
        let first = all.get(1)? - all[0];
        let is_even = all.windows(2).all(|pair| (pair[1] - pair[0] - first).abs() <= 10);
        let metres = first as f64 / 1e6;
        (is_even && metres <= WIDEST_M).then_some(metres)
    };
    let is_full = places.len() * 10 >= across.len() * up.len() * 6;
    Some(DVec2::new(step(&across)?, step(&up)?)).filter(|_| is_full)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROOM: [DVec3; 2] = [DVec3::new(-3.0, -2.0, 0.0), DVec3::new(3.0, 2.0, 3.0)];

    fn position_at(candidate: usize, group: &str, x: f64, y: f64, z: f64) -> Position<'_> {
        Position { candidate, group, at: DVec3::new(x, y, z) }
    }

    #[test]
    fn walls_fold_out_around_the_ceiling() {
        let positions = [
            position_at(0, "left-wall", 1.0, 1.9, 2.5),
            position_at(1, "left-wall", 1.0, 1.9, 2.5),
            position_at(2, "back-wall", -2.9, 0.5, 1.0),
            position_at(3, "ceiling", 0.0, 1.0, 2.9),
        ];
        let maps = maps(&positions, Some(ROOM));
        let [map] = &maps[..] else { panic!("{maps:?}") };
        let found: Vec<(&str, [f64; 2], usize)> = map
            .parts
            .iter()
            .map(|part| {
                (
                    part.label.as_ref().unwrap().text.as_str(),
                    part.spots[0].at.to_array(),
                    part.spots[0].candidates.len(),
                )
            })
            .collect();
        // 0.5 m below the ceiling is as far beyond its edge; 2 m at the back.
        let expected =
            [("ceiling", [0.0, 1.0], 1), ("back wall", [-5.0, 0.5], 1), ("left wall", [1.0, 2.5], 2)];
        assert_eq!(found, expected);
        assert_eq!(map.ends, [DVec2::new(-6.0, -5.0), DVec2::new(6.0, 5.0)]);
        assert_eq!(map.parts[1].label.as_ref().unwrap().at, DVec2::new(-6.0, 0.0));
        assert_eq!(map.parts[0].label.as_ref().unwrap().at, DVec2::new(0.0, 2.0));
        // An object on the floor 1 m from the back wall, 0.5 m high, covers the lowest half metre of it.
        let table = [DVec3::new(-2.0, -1.0, 0.0), DVec3::new(0.0, 1.0, 0.5)];
        let covered = [DVec2::new(-6.0, -1.0), DVec2::new(-5.5, 1.0)];
        assert_eq!(map.parts[1].face.shadow(table), covered);
        assert_eq!(map.parts[0].face.shadow(table), table.map(DVec3::truncate));
    }

    #[test]
    fn what_hangs_on_no_wall_has_a_map_of_its_own() {
        let floor: Vec<Position> = (0..6)
            .map(|n| position_at(n, "floor", (n % 3) as f64 * 0.5, (n / 3) as f64 * 0.25, 0.0))
            .collect();
        let all = maps(&floor, Some(ROOM));
        let [map] = &all[..] else { panic!("{all:?}") };
        assert_eq!(
            (map.axes, map.parts[0].face.is_plan(), map.parts[0].spots.len()),
            (Some([0, 1]), true, 6)
        );
        assert_eq!(map.parts[0].size, Some(DVec2::new(0.5, 0.25)));
        // A single wall is drawn as seen from the front, in its own axes.
        let wall = [position_at(0, "wall", 0.0, 1.9, 1.0), position_at(1, "wall", 1.0, 1.9, 2.0)];
        assert_eq!(maps(&wall, Some(ROOM))[0].axes, Some([0, 2]));
        // On a link nothing is unfolded.
        assert_eq!(maps(&wall, None)[0].title, "wall");
        assert_eq!(lattice(&[[0, 0], [1_000_000, 0], [2_100_000, 0]]), None);
    }
}
