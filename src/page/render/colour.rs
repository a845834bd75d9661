//! Colours of voxels and their lighting. Labels and roles have the colours of Okabe and Ito ("Color Universal Design",
//! 2008), which people with any kind of colour vision can distinguish; heights are drawn from dark to light.

use super::cast::Hit;
use perirobot_decide::view::{Verdict, View};
use perirobot_march::Result;
use perirobot_march::error::{Argument, Issue, Site, Words};
use perirobot_march::voxel::BitGrid;
use perirobot_study::world::World;

/// The meaning of voxel colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Colour {
    /// The label of each occupied voxel, with other colours for people and the robot; and free space labelled occupied.
    Label,
    /// Height.
    Height,
    /// Position along x.
    X,
    /// Whether it belongs to a person, the robot, or neither.
    Role,
}

/// The background.
pub(super) const SKY: [u8; 3] = [255; 3];
/// A return inside an occupied voxel, and one outside.
pub(super) const POINTS: [[u8; 3]; 2] = [[0, 0, 0], [230, 97, 0]];
/// A sensor.
pub(super) const SENSOR: [u8; 3] = [0, 0, 0];
/// The way of an unnoticed body.
pub(super) const WAY: [u8; 3] = [163, 0, 92];
/// Free space labelled occupied: a translucent veil over the background.
const VEIL: [u8; 3] = [230, 159, 0];
/// Opacity of the veil, of 256.
const VEIL_SHARE: u32 = 110;

/// The kinds of voxels: name in the legend, and colour.
const KINDS: [(&str, [u8; 3]); 10] = [
    ("called occupied", [86, 180, 233]),
    ("robot, called occupied", [0, 114, 178]),
    ("person, called occupied", [0, 158, 115]),
    ("unknown", [176, 176, 180]),
    ("robot, unknown", [104, 104, 112]),
    ("person, unknown", [213, 94, 0]),
    ("called free", [204, 121, 167]),
    ("environment", [176, 176, 180]),
    ("robot", [0, 114, 178]),
    ("person", [230, 159, 0]),
];
const LABELS: usize = 0;
const CALLED_FREE: usize = 6;
const ROLES: usize = 7;

/// From low to high: five colours of Matplotlib's viridis.
const RAMP: [[u8; 3]; 5] = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

/// A line of the legend.
pub(super) enum Entry {
    /// A colour.
    Patch([u8; 3], String),
    /// Colours from low to high, with the values at both ends.
    Ramp(String, String),
    /// The dots of returns.
    Dot([u8; 3], String),
    /// The figures of sensors.
    Sensor(String),
    /// Words alone.
    Note(String),
}

/// Assigns a colour to each voxel.
pub(crate) struct Palette<'a> {
    world: &'a World,
    view: Option<&'a View<'a>>,
    colour: Colour,
}

impl<'a> Palette<'a> {
    pub(crate) fn new(world: &'a World, view: Option<&'a View<'a>>, colour: Colour) -> Result<Self> {
        if colour == Colour::Label && view.is_none() {
            let only = Words::from("there are labels with ") + Argument("pose") + " only";
            let place = Site::Argument(Argument("colour"), "label".into());
            return Err(Issue::says(only).with_place(place).into());
        }
        Ok(Palette { world, view, colour })
    }

    /// The colour of a voxel, as if it were occupied.
    pub(crate) fn colour(&self, voxel: [i32; 3]) -> [u8; 3] {
        match self.ramp() {
            Some(axis) => {
                let last = self.world.grid.size[axis].max(2) - 1;
                ramp(voxel[axis].max(0) as u32 * 1024 / last)
            }
            None => KINDS[self.kind(voxel)].1,
        }
    }

    /// The axis of the ramp.
    fn ramp(&self) -> Option<usize> {
        match self.colour {
            Colour::Height => Some(2),
            Colour::X => Some(0),
            Colour::Label | Colour::Role => None,
        }
    }

    fn kind(&self, voxel: [i32; 3]) -> usize {
        let truth = &self.world.truth();
        let role = match (truth.human.get(voxel), truth.robot.get(voxel)) {
            (true, _) => 2,
            (_, true) => 1,
            _ => 0,
        };
        match self.view.filter(|_| self.colour == Colour::Label).map(|view| view.verdict(voxel)) {
            None => ROLES + role,
            Some(Verdict::Tp | Verdict::Fp) => LABELS + role,
            Some(Verdict::Fn | Verdict::Tn) => CALLED_FREE,
            Some(Verdict::Uo | Verdict::Uf) => LABELS + 3 + role,
        }
    }

    /// The lines of a legend: for the drawn voxels of `solid`, a veil, and a view with its returns.
    pub(super) fn entries(&self, solid: &BitGrid, veil: bool, points: Option<&View>) -> Vec<Entry> {
        let mut entries = Vec::new();
        match self.ramp() {
            Some(axis) => {
                let grid = &self.world.grid;
                let at = |voxel: u32| grid.corner_m([voxel as i32; 3])[axis];
                let name = ["x", "y", "z"][axis];
                let [low, high] = [at(0), at(grid.size[axis])];
                entries.push(Entry::Ramp(format!("{name} = {low:.1} m"), format!("{high:.1} m")));
            }
            None => {
                let mut held = [false; KINDS.len()];
                solid.voxels().for_each(|voxel| held[self.kind(voxel)] = true);
                let kinds = KINDS.iter().zip(held).filter(|(_, held)| *held);
                entries.extend(kinds.map(|((name, colour), _)| Entry::Patch(*colour, name.to_string())));
            }
        }
        if veil {
            entries.push(Entry::Patch(mix([255; 3], VEIL, VEIL_SHARE), "free, called occupied".into()));
        }
        let kinds = points.map_or([false; 2], |view| {
            let casts = view.members.iter().filter_map(|member| member.cast.as_ref());
            casts.fold([false; 2], |[right, wrong], cast| {
                let read = &cast.planes.occupied;
                let mut beside = read.clone();
                beside.remove(&self.world.truth().occupied);
                [right || !read.is_empty(), wrong || !beside.is_empty()]
            })
        });
        for ((name, colour), _) in
            ["return", "return read beside it"].iter().zip(POINTS).zip(kinds).filter(|(_, is)| *is)
        {
            entries.push(Entry::Dot(colour, name.to_string()));
        }
        let is_drawn = |view: &View| {
            let mut members = view.members.iter();
            members.any(|member| view.outline(member).is_some() || !view.grounds(member).is_empty())
        };
        if self.view.is_some_and(is_drawn) {
            entries.push(Entry::Sensor("sensor".into()));
        }
        entries
    }
}

/// The colour at a place between the lowest (0) and the highest (1024).
pub(crate) fn ramp(place: u32) -> [u8; 3] {
    let place = place.min(1024);
    let step = (place / 256).min(3) as usize;
    mix(RAMP[step], RAMP[step + 1], place - 256 * step as u32)
}

/// A lit colour: the shade depends on the face's direction, and corners are darker.
pub(super) fn shade(colour: [u8; 3], hit: &Hit, solid: &BitGrid) -> [u8; 3] {
    let light = match (hit.axis, hit.step) {
        (2, -1) => 256,
        (2, _) => 160,
        (0, _) => 208,
        _ => 232,
    };
    // Voxels beside the one in front of the face shade it.
    let mut before = hit.voxel;
    before[hit.axis] -= hit.step;
    let (u, v) = ((hit.axis + 1) % 3, (hit.axis + 2) % 3);
    let beside = [-1, 0, 1].into_iter().flat_map(|a| [-1, 0, 1].map(|b| [a, b]));
    let near = beside.filter(|[a, b]| {
        let mut voxel = before;
        voxel[u] += a;
        voxel[v] += b;
        solid.get(voxel)
    });
    let light = light * (256 - 14 * near.count() as u32) / 256;
    colour.map(|c| (u32::from(c) * light / 256) as u8)
}

/// A colour behind the veil.
pub(super) fn veil(colour: [u8; 3], veil: &Hit, haze: &BitGrid) -> [u8; 3] {
    mix(colour, shade(VEIL, veil, haze), VEIL_SHARE)
}

/// Mixes in this share of 256 of another colour.
fn mix(one: [u8; 3], other: [u8; 3], share: u32) -> [u8; 3] {
    std::array::from_fn(|c| ((u32::from(one[c]) * (256 - share) + u32::from(other[c]) * share) / 256) as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use perirobot_march::voxel::Window;

    #[test]
    fn ramps_end_where_they_should() {
        assert_eq!([ramp(0), ramp(256), ramp(1024), ramp(9999)], [RAMP[0], RAMP[1], RAMP[4], RAMP[4]]);
        assert_eq!(ramp(128), [63, 41, 111], "halfway from the first to the second");
    }

    #[test]
    fn faces_differ_and_corners_are_dark() {
        let mut solid = BitGrid::new(Window::from_corners([0; 3], [4; 3]));
        solid.set([2, 2, 1]);
        let seen = |axis, step| Hit { voxel: [2, 2, 1], axis, step, distance_q16: 0 };
        let white = |hit: Hit, solid: &BitGrid| shade([255; 3], &hit, solid)[0];
        let lights = [seen(2, -1), seen(2, 1), seen(0, 1), seen(1, -1)].map(|hit| white(hit, &solid));
        assert_eq!(lights, [255, 159, 207, 231]);
        solid.set([3, 2, 2]);
        assert_eq!(white(seen(2, -1), &solid), 241, "a voxel stands beside the upper face");
        assert_eq!(white(seen(0, 1), &solid), 207, "and behind the one that looks back");
    }
}
