//! A mounting sheet as a drawing: where a sensor is in plan and in elevation, with the distances that are measured to
//! the next surfaces, and the angles.

use std::fmt::Display;

use glam::DVec3;

use super::surroundings::Around;
use crate::render::svg::{Svg, tenth};
use perirobot_scene::pose::Pose;
use perirobot_study::sensor::Stance;
use perirobot_study::sensor::turned::Turned;

/// Size of a drawing, and the room around the cell in it.
const SIZE: [f64; 2] = [340.0, 250.0];
const EDGE: [f64; 2] = [30.0, 34.0];
/// How long the arrow is that shows where the sensor looks.
const LOOK: f64 = 46.0;
/// Letters of a name.
const LONGEST: usize = 24;

/// A view of the cell along an axis: which axis goes to the right and which goes up.
struct ViewSide {
    across: usize,
    up: usize,
    low: DVec3,
    high: DVec3,
    scale: f64,
    svg: Svg,
}

impl ViewSide {
    fn new([across, up]: [usize; 2], [low, high]: [DVec3; 2]) -> ViewSide {
        let size = (high - low).max(DVec3::splat(1e-3));
        let room = |axis: usize, n: usize| (SIZE[n] - 2.0 * EDGE[n]) / size[axis];
        let scale = room(across, 0).min(room(up, 1));
        ViewSide { across, up, low, high, scale, svg: Svg::default() }
    }

    fn project(&self, metres: DVec3) -> [f64; 2] {
        let beside =
            |axis: usize, n: usize| (SIZE[n] - (self.high[axis] - self.low[axis]) * self.scale) / 2.0;
        let x = beside(self.across, 0) + (metres[self.across] - self.low[self.across]) * self.scale;
        let y = SIZE[1] - beside(self.up, 1) - (metres[self.up] - self.low[self.up]) * self.scale;
        [tenth(x), tenth(y)]
    }

    fn words(&mut self, class: &str, [x, y]: [f64; 2], anchor: &str, words: &str) {
        let at: [(&str, &dyn Display); 4] =
            [("class", &class), ("x", &tenth(x)), ("y", &tenth(y)), ("text-anchor", &anchor)];
        self.svg.words(&at, words);
    }

    /// The cell, the sensor, and where it looks.
    fn begin(&mut self, title: &str, pose: &Pose) {
        let ([left, bottom], [right, top]) = (self.project(self.low), self.project(self.high));
        let room = format!("M{left} {top}H{right}V{bottom}H{left}Z");
        self.svg.element("path", &[("class", &"room"), ("d", &room)]);
        self.words("name", [8.0, 16.0], "start", title);
        let [x, y] = self.project(pose.position_m);
        let ahead = pose.link().x_axis;
        let (dx, dy) = (tenth(ahead[self.across] * LOOK), tenth(-ahead[self.up] * LOOK));
        if dx.abs() + dy.abs() > 4.0 {
            self.svg.element("path", &[("class", &"look"), ("d", &format!("M{x} {y}l{dx} {dy}"))]);
        }
        let dot: [(&str, &dyn Display); 4] = [("class", &"sensor"), ("cx", &x), ("cy", &y), ("r", &5)];
        self.svg.element("circle", &dot);
    }

    /// A distance from the sensor along an axis, as far as there is something.
    fn dimension(&mut self, from: DVec3, around: &Around, axis: usize, names: &[String]) {
        let Some((way, metres, object)) = nearer(around, axis) else { return };
        let mut to = from;
        to[axis] += if way % 2 == 0 { -metres } else { metres };
        let ([ax, ay], [bx, by]) = (self.project(from), self.project(to));
        let is_across = axis == self.across;
        let ticks = if is_across {
            format!("M{ax} {ay}H{bx}M{ax} {}v8M{bx} {}v8", ay - 4.0, by - 4.0)
        } else {
            format!("M{ax} {ay}V{by}M{} {ay}h8M{} {by}h8", ax - 4.0, bx - 4.0)
        };
        self.svg.element("path", &[("class", &"dimension"), ("d", &ticks)]);
        let words = format!("{metres:.3} m to {}", shorten(&names[object]));
        let [x, y] = [(ax + bx) / 2.0, (ay + by) / 2.0];
        // Words stay inside of the drawing, below a level line and beside an upright one.
        let half = words.chars().count() as f64 * 3.3;
        match is_across {
            true => {
                let below = if y + 16.0 > SIZE[1] - 6.0 { y - 8.0 } else { y + 16.0 };
                self.words("value", [x.clamp(half + 4.0, SIZE[0] - half - 4.0), below], "middle", &words);
            }
            false if x + 2.0 * half + 14.0 < SIZE[0] => {
                self.words("value", [x + 8.0, y + 4.0], "start", &words)
            }
            false => self.words("value", [x - 8.0, y + 4.0], "end", &words),
        }
    }

    fn finish(self, label: &str) -> String {
        self.svg.finish("sketch", label, [0.0, 0.0, SIZE[0], SIZE[1]])
    }
}

/// A name that has room in a drawing.
fn shorten(name: &str) -> String {
    match name.chars().count() > LONGEST {
        true => name.chars().take(LONGEST - 1).chain(['…']).collect(),
        false => name.into(),
    }
}

/// The nearer surface along an axis: its way, how far it is, and the object.
fn nearer(around: &Around, axis: usize) -> Option<(usize, f64, usize)> {
    let ways = [2 * axis, 2 * axis + 1].into_iter();
    let found = ways.filter_map(|way| around[way].map(|(metres, object)| (way, metres, object)));
    found.reduce(|a, b| if b.1 < a.1 { b } else { a })
}

/// Plan and elevation of a sensor that is mounted in the cell. The elevation is seen along the axis that the sensor
/// looks along the least; `names` are those of the objects around it.
pub(super) fn sketches(
    pose: &Pose,
    stance: Stance,
    room_m: [DVec3; 2],
    around: &Around,
    names: &[String],
) -> [String; 2] {
    let at = pose.position_m;
    let room_m = [room_m[0].min(at), room_m[1].max(at)];
    let ahead = pose.link().x_axis;
    let along = if ahead.x.abs() >= ahead.y.abs() { 0 } else { 1 };
    let turned = Turned::new(pose);
    let mut plan = ViewSide::new([0, 1], room_m);
    plan.begin("plan: x to the right, y up", pose);
    plan.dimension(at, around, 0, names);
    plan.dimension(at, around, 1, names);
    plan.words("angle", [SIZE[0] - 8.0, SIZE[1] - 8.0], "end", &format!("pan {:.1}°", turned.pan_deg));
    let mut side = ViewSide::new([along, 2], room_m);
    side.begin(&format!("elevation: {} to the right, z up", ["x", "y"][along]), pose);
    side.dimension(at, around, along, names);
    // From the floor, as it is measured, even where the ceiling is nearer.
    let mut from_floor = *around;
    if from_floor[4].is_some() {
        from_floor[5] = None;
    }
    side.dimension(at, &from_floor, 2, names);
    if stance != Stance::Level {
        let angles = format!("tilt {:.1}°, roll {:.1}°", turned.tilt_deg, turned.roll_deg);
        side.words("angle", [SIZE[0] - 8.0, SIZE[1] - 8.0], "end", &angles);
    }
    [
        plan.finish("Where it is mounted, seen from above"),
        side.finish("Where it is mounted, seen from the side"),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_and_angles_are_written_inside() {
        let room = [DVec3::new(-3.0, -2.0, 0.0), DVec3::new(3.0, 2.0, 3.0)];
        let names = ["hall <1>".to_string(), "table".to_string()];
        assert_eq!(shorten(&"x".repeat(400)).chars().count(), LONGEST);
        for x in [-2.95, 0.0, 2.95] {
            for y in [-1.95, 1.95] {
                let pose = Pose::facing(DVec3::new(x, y, 2.5), DVec3::Y * -y, 0.3, -0.5);
                let around = [
                    Some((3.0 + x, 0)),
                    Some((3.0 - x, 0)),
                    Some((2.0 + y, 0)),
                    Some((2.0 - y, 0)),
                    Some((1.7, 1)),
                    Some((0.5, 0)),
                ];
                let drawn = sketches(&pose, Stance::Facing, room, &around, &names);
                let said = drawn.each_ref().map(|svg| {
                    let document = roxmltree::Document::parse(svg).unwrap();
                    let texts = document.descendants().filter(|node| node.has_tag_name("text"));
                    let words = texts.map(|node| {
                        let number = |name: &str| node.attribute(name).unwrap().parse::<f64>().unwrap();
                        let text = node.text().unwrap().to_string();
                        let long = text.chars().count() as f64 * 6.6;
                        let left = match node.attribute("text-anchor") {
                            Some("end") => number("x") - long,
                            Some("middle") => number("x") - long / 2.0,
                            _ => number("x"),
                        };
                        assert!(left >= 0.0 && left + long <= SIZE[0], "{text:?} from {left} at x {x}");
                        assert!((8.0..=SIZE[1]).contains(&number("y")), "{text:?}");
                        text
                    });
                    words.collect::<Vec<_>>()
                });
                let near = 3.0 - x.abs();
                assert!(said[0].contains(&format!("{near:.3} m to hall <1>")), "{said:?}");
                assert!(said[0].contains(&"0.050 m to hall <1>".to_string()), "{said:?}");
                assert!(
                    said[1].contains(&"1.700 m to table".to_string()),
                    "the height, not the ceiling: {said:?}"
                );
                assert!(said[1].iter().any(|text| text.starts_with("tilt -28.6°")), "{said:?}");
            }
        }
    }
}
