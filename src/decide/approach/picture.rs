//! The paths as a point cloud with edges (PLY), and the floor plan of a body (SVG): where it is unnoticed,
//! and its path to the deepest place.

use std::fmt::Write;

use super::ground::{Company, Ground};
use super::moments::{ApproachAnswer, BodyPlan};
use perirobot_march::voxel::{BitGrid, Window};
use perirobot_study::input::slug;

/// The name of the file of paths.
pub const PATHS: &str = "paths.ply";

impl BodyPlan {
    /// Its scene, body and people, as in the columns of the table.
    pub fn names<'a>(&self, ground: &'a Ground) -> [&'a str; 3] {
        [&ground.worlds[0].name, &ground.bodies[self.body].name, self.company.name()]
    }
}

/// The names of the files of floor plans of some scenes, bodies and people, in their order: numbered where they are
/// the same but for spelling.
pub fn plan_names<'a>(plans: impl Iterator<Item = [&'a str; 3]>) -> Vec<String> {
    let mut names = Vec::new();
    for [scene, body, people] in plans {
        let with = if people == Company::Cover.name() { "-people-as-cover" } else { "" };
        let (scene, body) = (slug(scene), slug(body));
        let mut name = format!("floor-{scene}-{body}{with}.svg");
        let mut number = 2;
        while names.contains(&name) {
            name = format!("floor-{scene}-{body}{with}-{number}.svg");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// Whether a file has a name that a floor plan may have.
pub fn is_named_as_plan(name: &str) -> bool {
    name.starts_with("floor-") && name.ends_with(".svg")
}

/// All paths of a table, for CloudCompare, MeshLab and Blender: a vertex for each place, where the middle of the
/// body is in world metres, with the number of its row in `approach.csv`, counted from 0.
pub fn paths_ply(asked: &[(Ground, Vec<ApproachAnswer>)]) -> Vec<u8> {
    let (mut vertices, mut edges) = (String::new(), String::new());
    let (mut vertex, mut steps) = (0, 0);
    let rows = asked.iter().flat_map(|(ground, answers)| answers.iter().map(move |answer| (ground, answer)));
    for (row, (ground, answer)) in rows.enumerate() {
        let Some(deepest) = &answer.found.deepest else { continue };
        for (number, &place) in deepest.path.iter().enumerate() {
            let at = ground.bodies[answer.body].middle_m(place, &ground.worlds[0].grid);
            let _ = writeln!(vertices, "{:.5} {:.5} {:.5} {row}", at.x, at.y, at.z);
            if number > 0 {
                let _ = writeln!(edges, "{} {vertex}", vertex - 1);
                steps += 1;
            }
            vertex += 1;
        }
    }
    let header = format!(
        "ply\nformat ascii 1.0\ncomment centres of bodies along their paths, in metres; row: of approach.csv, from 0\n\
         element vertex {vertex}\nproperty float x\nproperty float y\nproperty float z\nproperty uint row\n\
         element edge {steps}\nproperty int vertex1\nproperty int vertex2\nend_header\n"
    );
    (header + &vertices + &edges).into_bytes()
}

/// What a voxel of the floor is in a plan.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FloorCell {
    Solid,
    Narrow,
    Noticed,
    Apart,
    Joined,
}

impl FloorCell {
    /// All of them, with the colour and what it means; colours that colour-blind people tell apart.
    const ALL: [(FloorCell, &'static str, &'static str); 5] = [
        (FloorCell::Joined, "#d55e00", "unnoticed, reached from an entry"),
        (FloorCell::Apart, "#f0c48a", "unnoticed, not reached from any entry"),
        (FloorCell::Noticed, "#cfe8dd", "noticed"),
        (FloorCell::Narrow, "#e4e4e4", "no room"),
        (FloorCell::Solid, "#777777", "solid"),
    ];
}

/// The colour of the hazard's outline, and of paths.
const HAZARD: &str = "#0072b2";
const PATH: &str = "#000000";
/// Least width of the picture, and the height of a line of text, in pixels.
const LEAST_WIDTH: u32 = 520;
const LINE: u32 = 18;

/// The floor plan of a body, seen from above, y up; `answers` are those of its scene. A voxel is coloured by
/// what happens to the body when its middle is there.
pub fn floor_plan(ground: &Ground, answers: &[ApproachAnswer], plan: &BodyPlan) -> Vec<u8> {
    let (grid, body) = (&ground.worlds[0].grid, &ground.bodies[plan.body]);
    let last = if ground.worlds.len() > 1 { None } else { Some(ground.worlds[0].snapshot) };
    let of_plan = |answer: &&ApproachAnswer| {
        (answer.company, answer.body, answer.snapshot) == (plan.company, plan.body, last)
    };
    let answers: Vec<&ApproachAnswer> = answers.iter().filter(of_plan).collect();
    let mut joined = BitGrid::new(plan.open.window());
    answers.iter().for_each(|answer| joined.add(&answer.found.reached));
    // A walking body may have places over each other in one column: all their layers are drawn.
    let layers = match body.climbs {
        Some(_) => plan.free.bounds(),
        None => ground.places[plan.body],
    };
    let layers = layers.min[2]..layers.end()[2];
    let filled = layers.start..layers.end + body.size[2] as i32 - 1;
    let [width, depth, _] = grid.size;
    let floor = |x: i32, y: i32| {
        let [own_x, own_y] = [x - body.size[0] as i32 / 2, y - body.size[1] as i32 / 2];
        let any = |set: &BitGrid| layers.clone().any(|z| set.get([own_x, own_y, z]));
        match () {
            () if any(&joined) => FloorCell::Joined,
            () if any(&plan.open) => FloorCell::Apart,
            () if any(&plan.free) => FloorCell::Noticed,
            () if filled.clone().any(|z| plan.solid.get([x, y, z])) => FloorCell::Solid,
            () => FloorCell::Narrow,
        }
    };
    let scale = (900 / width.max(depth)).clamp(1, 16);
    let (across, up) = ((width * scale).max(LEAST_WIDTH), depth * scale);
    let lines = 2 + FloorCell::ALL.len() as u32 + 2;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{across}\" height=\"{}\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n",
        up + lines * LINE
    );
    // Runs of equal floor, row by row from the top.
    for y in (0..depth as i32).rev() {
        let top = (depth as i32 - 1 - y) as u32 * scale;
        let mut begin = 0;
        for x in 1..=width as i32 {
            let kind = floor(begin, y);
            if x < width as i32 && floor(x, y) == kind {
                continue;
            }
            let colour =
                FloorCell::ALL.iter().find(|(other, _, _)| *other == kind).map_or("none", |(_, c, _)| c);
            let (left, wide) = (begin as u32 * scale, (x - begin) as u32 * scale);
            let _ = writeln!(
                svg,
                "<rect x=\"{left}\" y=\"{top}\" width=\"{wide}\" height=\"{scale}\" fill=\"{colour}\"/>"
            );
            begin = x;
        }
    }
    outline(&mut svg, &plan.hazard, [depth, scale]);
    // A path in pixels, at the middles of the body.
    let pixel = |place: [i32; 3]| {
        let at = |r: usize| (f64::from(place[r]) + f64::from(body.size[r]) / 2.0) * f64::from(scale);
        [at(0), f64::from(up) - at(1)]
    };
    for deepest in answers.iter().filter_map(|answer| answer.found.deepest.as_ref()) {
        let points: Vec<String> = deepest
            .path
            .iter()
            .map(|&place| {
                let [x, y] = pixel(place);
                format!("{x},{y}")
            })
            .collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{PATH}\" stroke-width=\"2\"/>",
            points.join(" ")
        );
        if let Some(&place) = deepest.path.last() {
            let ([x, y], r) = (pixel(place), f64::from(body.size[0] * scale) / 2.0);
            let _ = writeln!(
                svg,
                "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"none\" stroke=\"{PATH}\" stroke-width=\"2\"/>"
            );
        }
    }
    let area = |set: &BitGrid| set.count() as f64 * grid.voxel_size_m * grid.voxel_size_m;
    let people = match plan.company {
        Company::Absent => "nobody else there",
        Company::Cover => "the people of the scene as cover",
    };
    let at_once = if last.is_none() { ", all snapshots at once" } else { "" };
    let heading = format!("{}: {}, {people}{at_once}", ground.worlds[0].name, body.name);
    let areas = format!(
        "unnoticed on {:.2} m² (its centre), {:.2} m² of it on paths from entries",
        area(&plan.open),
        area(&joined)
    );
    let mut below = (1..=lines).map(|line| up + line * LINE - 4);
    let mut next = || below.next().unwrap_or(up);
    for text in [heading, areas] {
        let _ = writeln!(svg, "<text x=\"6\" y=\"{}\">{}</text>", next(), escape(&text));
    }
    for (_, colour, meaning) in FloorCell::ALL {
        let at = next();
        let _ = writeln!(
            svg,
            "<rect x=\"6\" y=\"{}\" width=\"12\" height=\"12\" fill=\"{colour}\"/><text x=\"24\" y=\"{at}\">{meaning}</text>",
            at - 11
        );
    }
    for (colour, meaning) in
        [(HAZARD, "what bodies must not come near to"), (PATH, "path to the nearest place")]
    {
        let at = next();
        let _ = writeln!(
            svg,
            "<line x1=\"6\" x2=\"18\" y1=\"{0}\" y2=\"{0}\" stroke=\"{colour}\" stroke-width=\"2\"/>\
             <text x=\"24\" y=\"{at}\">{meaning}</text>",
            at - 5
        );
    }
    svg += "</svg>\n";
    svg.into_bytes()
}

/// The outline of a set, seen from above, in a picture of so many voxels up at some scale.
fn outline(svg: &mut String, set: &BitGrid, [depth, scale]: [u32; 2]) {
    let around = set.bounds();
    let [columns, rows] = [around.min[0]..around.end()[0], around.min[1]..around.end()[1]];
    let mut flat = BitGrid::new(Window { min: around.min, size: [around.size[0], around.size[1], 1] });
    set.voxels().for_each(|[x, y, _]| flat.set([x, y, around.min[2]]));
    let is_in = |x: i32, y: i32| flat.get([x, y, around.min[2]]);
    let mut lines = String::new();
    let pixel = |x: i32, y: i32| format!("{} {}", x * scale as i32, (depth as i32 - y) * scale as i32);
    for y in rows {
        for x in columns.clone().filter(|&x| is_in(x, y)) {
            let sides = [
                (is_in(x - 1, y), [x, y], [x, y + 1]),
                (is_in(x + 1, y), [x + 1, y], [x + 1, y + 1]),
                (is_in(x, y - 1), [x, y], [x + 1, y]),
                (is_in(x, y + 1), [x, y + 1], [x + 1, y + 1]),
            ];
            for (_, [ax, ay], [bx, by]) in sides.into_iter().filter(|(inside, _, _)| !inside) {
                let _ = write!(lines, "M{} L{} ", pixel(ax, ay), pixel(bx, by));
            }
        }
    }
    let _ = writeln!(
        svg,
        "<path d=\"{}\" fill=\"none\" stroke=\"{HAZARD}\" stroke-width=\"2\"/>",
        lines.trim_end()
    );
}

/// A user's words in XML.
fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
