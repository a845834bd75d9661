//! A mounting sheet as a drawing: a sensor in plan and in elevation among the objects, with the measured distances to
//! the next surfaces, and the angles. Labels do not overlap.

pub(super) mod compass;
pub(super) mod things;

use std::fmt::Display;

use glam::DVec3;

use super::surroundings::{Around, LowerObject};
use crate::render::plan::labels::PlacedLabels;
use crate::render::svg::{Svg, tenth};
use perirobot_scene::pose::Pose;
use perirobot_study::sensor::Stance;
use perirobot_study::sensor::turned::Turned;
use things::{Patch, Thing};

/// Size of a drawing, and the margin around the cell.
const SIZE: [f64; 2] = [340.0, 250.0];
const EDGE: [f64; 2] = [30.0, 34.0];
/// The length of the line in the sensor's direction of view, and the radius of the disc with the sensor's letter.
const LOOK: f64 = 46.0;
const DISC: f64 = 8.0;
/// Letters of a name, their size, and the height of the lines of the title and the angles.
const LONGEST: usize = 24;
const LETTERS: f64 = 12.0;
const MARGIN: f64 = 22.0;
/// Most objects with names in a drawing; the others have tooltips.
const MOST_NAMED: usize = 6;

/// The contents of a sketch.
pub(super) struct Sketch<'a> {
    pub(super) letter: &'a str,
    pub(super) pose: &'a Pose,
    pub(super) stance: Stance,
    pub(super) room_m: [DVec3; 2],
    pub(super) around: &'a Around,
    /// In each of the first four directions what ends below the sensor and is nearer.
    pub(super) lower: &'a [Option<LowerObject>; 4],
    /// The names of the surroundings.
    pub(super) names: &'a [String],
    pub(super) things: &'a [Thing],
    /// What is too near to be measured: with the sensor, the convex hulls of these parts.
    pub(super) near_m: &'a [Vec<DVec3>],
}

/// A view of the cell along an axis: the axes to the right and up.
struct ViewSide {
    across: usize,
    up: usize,
    low: DVec3,
    high: DVec3,
    scale: f64,
    svg: Svg,
    labels: PlacedLabels,
}

impl ViewSide {
    fn new([across, up]: [usize; 2], [low, high]: [DVec3; 2]) -> ViewSide {
        let size = (high - low).max(DVec3::splat(1e-3));
        let room = |axis: usize, n: usize| (SIZE[n] - 2.0 * EDGE[n]) / size[axis];
        let scale = room(across, 0).min(room(up, 1));
        // The title and the angles have their own lines.
        let labels = PlacedLabels::new([2.0, MARGIN, SIZE[0] - 2.0, SIZE[1] - MARGIN]);
        ViewSide { across, up, low, high, scale, svg: Svg::default(), labels }
    }

    fn project(&self, metres: DVec3) -> [f64; 2] {
        self.project_flat([metres[self.across], metres[self.up]])
    }

    fn project_flat(&self, [across, up]: [f64; 2]) -> [f64; 2] {
        let beside =
            |axis: usize, n: usize| (SIZE[n] - (self.high[axis] - self.low[axis]) * self.scale) / 2.0;
        let x = beside(self.across, 0) + (across - self.low[self.across]) * self.scale;
        let y = SIZE[1] - beside(self.up, 1) - (up - self.low[self.up]) * self.scale;
        [tenth(x), tenth(y)]
    }

    fn words(&mut self, class: &str, [x, y]: [f64; 2], anchor: &str, words: &str) {
        let at: [(&str, &dyn Display); 4] =
            [("class", &class), ("x", &tenth(x)), ("y", &tenth(y)), ("text-anchor", &anchor)];
        self.svg.words(&at, words);
    }

    /// Words around their middle.
    fn write_at(&mut self, class: &str, [x, y]: [f64; 2], words: &str) {
        self.words(class, [x, y + LETTERS / 3.0], "middle", words);
    }

    /// The cell, and its objects.
    fn begin(&mut self, title: &str, things: &[Thing]) {
        let ([left, bottom], [right, top]) = (self.project(self.low), self.project(self.high));
        let room = format!("M{left} {top}H{right}V{bottom}H{left}Z");
        self.svg.element("path", &[("class", &"room"), ("d", &room)]);
        for y in [top, bottom] {
            self.labels.take([left, y - 1.0, right, y + 1.0]);
        }
        for x in [left, right] {
            self.labels.take([x - 1.0, top, x + 1.0, bottom]);
        }
        for thing in things {
            let mut path = String::new();
            for [from, to, low, high] in &thing.shadows[3 - self.across - self.up] {
                let ([left, bottom], [right, top]) =
                    (self.project_flat([*from, *low]), self.project_flat([*to, *high]));
                path += &format!("M{left} {bottom}H{right}V{top}H{left}Z");
            }
            if !path.is_empty() {
                let class = if thing.is_robot { "thing robot" } else { "thing" };
                self.svg.add_titled("path", &[("class", &class), ("d", &path)], &thing.name);
            }
        }
        self.words("name", [8.0, 16.0], "start", title);
    }

    /// What is too near to the sensor to be measured, if it is larger than its disc.
    fn draw_near(&mut self, at: DVec3, parts: &[Vec<DVec3>]) {
        let mut path = String::new();
        let apex = self.project(at);
        let mut reach = 0.0f64;
        for part in parts {
            let mut points: Vec<[f64; 2]> = part.iter().map(|place| self.project(*place)).collect();
            let far = points.iter().map(|[x, y]| libm::hypot(x - apex[0], y - apex[1]));
            reach = far.fold(reach, f64::max);
            points.push(apex);
            let corners = convex_hull(points).into_iter().map(|[x, y]| format!("{x} {y}"));
            path += &format!("M{}Z", corners.collect::<Vec<_>>().join("L"));
        }
        if reach > DISC {
            self.svg.add_titled(
                "path",
                &[("class", &"near"), ("d", &path)],
                "too near: a body here is not seen",
            );
        }
    }

    /// The sensor with its direction of view.
    fn draw_sensor(&mut self, pose: &Pose, letter: &str) {
        let [x, y] = self.project(pose.position_m);
        let ahead = pose.link().x_axis;
        let (dx, dy) = (tenth(ahead[self.across] * LOOK), tenth(-ahead[self.up] * LOOK));
        if dx.abs() + dy.abs() > 4.0 {
            self.svg.element("path", &[("class", &"look"), ("d", &format!("M{x} {y}l{dx} {dy}"))]);
            for part in 1..=8 {
                let [x, y] = [x + dx * f64::from(part) / 8.0, y + dy * f64::from(part) / 8.0];
                self.labels.take([x - 2.0, y - 2.0, x + 2.0, y + 2.0]);
            }
        }
        let disc: [(&str, &dyn Display); 4] = [("class", &"sensor"), ("cx", &x), ("cy", &y), ("r", &DISC)];
        self.svg.element("circle", &disc);
        self.write_at("own", [x, y], letter);
        self.labels.take([x - DISC, y - DISC, x + DISC, y + DISC]);
    }

    /// A distance from the sensor along an axis, if there is a surface.
    fn dimension(&mut self, from: DVec3, around: &Around, axis: usize, names: &[String]) {
        let Some((way, metres, object)) = nearer(around, axis) else { return };
        let words = format!("{metres:.3} m to {}", shorten(&names[object]));
        self.length("dimension", from, (axis, way, metres), &words);
    }

    /// A distance along a level axis to a lower object, at the height where that ends.
    fn dimension_lower(
        &mut self,
        from: DVec3,
        lower: &[Option<LowerObject>; 4],
        axis: usize,
        names: &[String],
    ) {
        let ways = [2 * axis, 2 * axis + 1].into_iter();
        let found = ways.filter_map(|way| lower.get(way).copied().flatten().map(|lower| (way, lower)));
        let Some((way, LowerObject { away_m, below_m, object })) =
            found.reduce(|a, b| if b.1.away_m < a.1.away_m { b } else { a })
        else {
            return;
        };
        let words = format!("{away_m:.3} m to {}, {below_m:.3} m lower", shorten(&names[object]));
        self.length("dimension lower", from - DVec3::Z * below_m, (axis, way, away_m), &words);
    }

    /// A line from a place along an axis, with its length.
    fn length(&mut self, class: &str, from: DVec3, (axis, way, metres): (usize, usize, f64), words: &str) {
        let mut to = from;
        to[axis] += if way % 2 == 0 { -metres } else { metres };
        let ([ax, ay], [bx, by]) = (self.project(from), self.project(to));
        let is_across = axis == self.across;
        let ticks = if is_across {
            format!("M{ax} {ay}H{bx}M{ax} {}v8M{bx} {}v8", ay - 4.0, by - 4.0)
        } else {
            format!("M{ax} {ay}V{by}M{} {ay}h8M{} {by}h8", ax - 4.0, bx - 4.0)
        };
        self.svg.element("path", &[("class", &class), ("d", &ticks)]);
        let half = words.chars().count() as f64 * 0.3 * LETTERS + 1.0;
        let [x, y] = [(ax + bx) / 2.0, (ay + by) / 2.0];
        // Next to the middle of the line, else farther and farther away from it; always inside the drawing.
        let inside = |x: f64| x.clamp(half + 3.0, SIZE[0] - half - 3.0);
        let steps = (0..9).map(|n| f64::from(n) * 14.0);
        let places = steps.flat_map(|far| match is_across {
            true => [[inside(x), y + 14.0 + far], [inside(x), y - 14.0 - far]].to_vec(),
            false => [far, -far]
                .into_iter()
                .flat_map(|far| [[x + half + 12.0, y + far], [x - half - 12.0, y + far]])
                .collect(),
        });
        let places = places.chain((0..12).map(|n| [SIZE[0] / 2.0, MARGIN + 10.0 + f64::from(n) * 15.0]));
        // A distance is always written.
        let beside = [inside(x), y];
        let at = self.labels.place_at(words, LETTERS, places).unwrap_or(beside);
        self.write_at("value", at, words);
    }

    /// The names of the largest objects, in or beside them, if there is room.
    fn name(&mut self, things: &[Thing]) {
        let axis = 3 - self.across - self.up;
        let mut named: Vec<(&Thing, Patch)> =
            things.iter().filter_map(|thing| Some((thing, thing.extent(axis)?))).collect();
        let size = |[from, to, low, high]: Patch| (to - from) + (high - low);
        named.sort_by(|a, b| size(b.1).total_cmp(&size(a.1)));
        for (thing, [from, to, low, high]) in named.into_iter().take(MOST_NAMED) {
            let ([left, bottom], [right, top]) =
                (self.project_flat([from, low]), self.project_flat([to, high]));
            let (name, [x, y]) = (shorten(&thing.name), [(left + right) / 2.0, (top + bottom) / 2.0]);
            let (half, apart) = (name.chars().count() as f64 * 0.3 * LETTERS + 4.0, 0.8 * LETTERS);
            let around = [[x, y], [x, top - apart], [x, bottom + apart], [right + half, y], [left - half, y]];
            if let Some(at) = self.labels.place_at(&name, LETTERS, around) {
                self.write_at("name", at, &name);
            }
        }
    }

    fn finish(mut self, angles: &str, label: &str) -> String {
        self.words("angle", [SIZE[0] - 8.0, SIZE[1] - 7.0], "end", angles);
        self.svg.finish("sketch", label, [0.0, 0.0, SIZE[0], SIZE[1]])
    }
}

/// The corners of the convex hull of some points, in order, all hulls the same way round.
fn convex_hull(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    let turns_left = |[ax, ay]: [f64; 2], [bx, by]: [f64; 2], [cx, cy]: [f64; 2]| {
        (bx - ax) * (cy - ay) - (by - ay) * (cx - ax) > 0.0
    };
    let half = |points: &mut dyn Iterator<Item = [f64; 2]>| {
        let mut chain: Vec<[f64; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && !turns_left(a, b, point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let lower = half(&mut points.iter().copied());
    let upper = half(&mut points.iter().rev().copied());
    [lower, upper].concat()
}

/// A name shortened for a drawing.
fn shorten(name: &str) -> String {
    match name.chars().count() > LONGEST {
        true => name.chars().take(LONGEST - 1).chain(['…']).collect(),
        false => name.into(),
    }
}

/// The nearer surface along an axis: its direction, distance and object.
fn nearer(around: &Around, axis: usize) -> Option<(usize, f64, usize)> {
    let ways = [2 * axis, 2 * axis + 1].into_iter();
    let found = ways.filter_map(|way| around[way].map(|(metres, object)| (way, metres, object)));
    found.reduce(|a, b| if b.1 < a.1 { b } else { a })
}

impl Sketch<'_> {
    /// Plan and elevation of a sensor mounted in the cell. The elevation looks along the axis that is farthest from the
    /// sensor's direction of view.
    pub(super) fn views(&self) -> [String; 2] {
        let ahead = self.pose.link().x_axis;
        let along = if ahead.x.abs() >= ahead.y.abs() { 0 } else { 1 };
        let turned = Turned::new(self.pose);
        let plan = self.view([0, 1], "plan: x to the right, y up", self.around);
        // From the floor, as measured on site, even if the ceiling is nearer.
        let mut from_floor = *self.around;
        if from_floor[4].is_some() {
            from_floor[5] = None;
        }
        let title = format!("elevation: {} to the right, z up", ["x", "y"][along]);
        let side = self.view([along, 2], &title, &from_floor);
        let angles = match self.stance {
            Stance::Level => String::new(),
            _ => format!("tilt {:.1}°, roll {:.1}°", turned.tilt_deg, turned.roll_deg),
        };
        [
            plan.finish(&format!("pan {:.1}°", turned.pan_deg), "Where it is mounted, seen from above"),
            side.finish(&angles, "Where it is mounted, seen from the side"),
        ]
    }

    fn view(&self, axes: [usize; 2], title: &str, around: &Around) -> ViewSide {
        let at = self.pose.position_m;
        let mut view = ViewSide::new(axes, [self.room_m[0].min(at), self.room_m[1].max(at)]);
        view.begin(title, self.things);
        view.draw_near(at, self.near_m);
        view.draw_sensor(self.pose, self.letter);
        axes.into_iter().for_each(|axis| view.dimension(at, around, axis, self.names));
        axes.into_iter().for_each(|axis| view.dimension_lower(at, self.lower, axis, self.names));
        view.name(self.things);
        view
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_hull_has_the_outer_corners_once() {
        let square = vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        assert_eq!(convex_hull(square), [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]]);
        assert_eq!(convex_hull(vec![[1.0, 0.0], [0.0, 0.0]]), [[0.0, 0.0], [1.0, 0.0]]);
    }

    #[test]
    fn distances_and_angles_are_written_inside() {
        let room = [DVec3::new(-3.0, -2.0, 0.0), DVec3::new(3.0, 2.0, 3.0)];
        let names = ["hall <1>", "table", "mesh"].map(String::from);
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
                let fence = Thing {
                    name: "fence".into(),
                    is_robot: false,
                    shadows: [
                        vec![[-1.0, 1.0, 0.0, 2.0]],
                        vec![[-2.0, -1.9, 0.0, 2.0]],
                        vec![[-2.0, -1.9, -1.0, 1.0]],
                    ],
                };
                let drawn = Sketch {
                    letter: "A",
                    pose: &pose,
                    stance: Stance::Facing,
                    room_m: room,
                    around: &around,
                    lower: &[
                        Some(LowerObject { away_m: (2.0 + x) / 2.0, below_m: 0.5, object: 2 }),
                        None,
                        None,
                        None,
                    ]
                    .map(|lower| lower.filter(|lower| lower.away_m > 0.0)),
                    names: &names,
                    things: &[fence],
                    near_m: &[vec![pose.position_m + DVec3::new(1.0, 1.0, -1.0), pose.position_m - DVec3::X]],
                }
                .views();
                let texts = drawn.each_ref().map(|svg| {
                    assert!(svg.contains("class=\"near\""), "{svg}");
                    assert!(svg.contains("class=\"thing\"") && svg.contains(">fence<"), "{svg}");
                    let document = roxmltree::Document::parse(svg).unwrap();
                    let mut boxes: Vec<[f64; 4]> = Vec::new();
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
                        let own = [left, number("y") - 9.0, left + long, number("y") + 2.0];
                        let meets =
                            |other: &[f64; 4]| (0..2).all(|r| own[r] < other[r + 2] && other[r] < own[r + 2]);
                        assert!(!boxes.iter().any(meets), "{text:?} covers another label at x {x}, y {y}");
                        boxes.push(own);
                        text
                    });
                    words.collect::<Vec<_>>()
                });
                let near = 3.0 - x.abs();
                assert!(texts[0].contains(&format!("{near:.3} m to hall <1>")), "{texts:?}");
                assert!(texts[0].contains(&"0.050 m to hall <1>".to_string()), "{texts:?}");
                assert!(
                    texts[1].contains(&"1.700 m to table".to_string()),
                    "the height, not the ceiling: {texts:?}"
                );
                if x > -2.0 {
                    let lower = format!("{:.3} m to mesh, 0.500 m lower", (2.0 + x) / 2.0);
                    assert!(texts[0].contains(&lower), "{texts:?}");
                    assert!(drawn[0].contains("class=\"dimension lower\""), "{}", drawn[0]);
                    // 0.5 m below the sensor, in the elevation along x.
                    assert_eq!(texts[1].contains(&lower), drawn[1].contains("elevation: x"), "{texts:?}");
                }
                assert!(texts[1].iter().any(|text| text.starts_with("tilt -28.6°")), "{texts:?}");
            }
        }
    }
}
