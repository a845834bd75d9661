//! The paths by which bodies get closest, in world metres, for pictures.

use glam::DVec3;

use super::body::Body;
use super::ground::{Company, Ground};
use super::moments::{ApproachAnswer, at_once};
use super::needed::root_m;
use crate::view::watched::Watchers;
use perirobot_march::Result;
use perirobot_march::voxel::{Grid, rounded_down};
use perirobot_study::input::BodyShape;
use perirobot_study::world::World;

/// Corners of a circle that is drawn.
const CORNERS: usize = 24;

/// How a body comes as near to the hazard as it can without being noticed.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// The body, by its name.
    pub body: String,
    /// The entry from which it comes, by its name.
    pub entry: String,
    /// Who else is there.
    pub company: Company,
    /// How far its nearest voxel is from the hazard at the end, between centres, in metres.
    pub nearest_m: f64,
    /// Where its middle goes, from the entry on, in world metres; at least one point.
    pub points_m: Vec<DVec3>,
    /// The body at the end: lines along its edges, each from point to point, in world metres.
    pub outline_m: Vec<Vec<DVec3>>,
}

impl Way {
    /// In words, with the distance rounded down to centimetres.
    pub fn words(&self) -> String {
        let people = if self.company == Company::Cover { ", people as cover" } else { "" };
        format!(
            "{} from {}{people} gets to {} m unnoticed",
            self.body,
            self.entry,
            rounded_down(self.nearest_m, 2)
        )
    }
}

/// Of each body of a scene the way by which it comes nearest unnoticed, from whichever entry and with or without its
/// people as cover, all its snapshots at once: the cautious answer. None of who is noticed wherever they come in.
/// `worlds` are the snapshots of the scene with the sensors as they are looked at.
///
/// # Errors
/// As [`super::answers`].
pub fn nearest_ways(ground: &Ground, worlds: &[World], watchers: &Watchers) -> Result<Vec<Way>> {
    let answers = at_once(ground, worlds, watchers)?;
    let of_body = |body: usize| {
        let own = answers.iter().filter(|answer| answer.body == body);
        let depth = |answer: &&ApproachAnswer| answer.found.deepest.as_ref().map(|deepest| deepest.squared);
        // The first of several that come as near.
        own.filter(|answer| depth(answer).is_some()).min_by_key(depth)
    };
    Ok((0..ground.bodies.len()).filter_map(of_body).filter_map(|answer| way(ground, answer)).collect())
}

fn way(ground: &Ground, answer: &ApproachAnswer) -> Option<Way> {
    let (grid, body) = (&ground.worlds[0].grid, &ground.bodies[answer.body]);
    let approach = &ground.study.approach;
    let deepest = answer.found.deepest.as_ref()?;
    let points_m: Vec<DVec3> = deepest.path.iter().map(|&place| body.middle_m(place, grid)).collect();
    Some(Way {
        body: body.name.clone(),
        entry: approach.entries[answer.entry].name.clone(),
        company: answer.company,
        nearest_m: root_m(deepest.squared, grid),
        outline_m: outline(approach.bodies[answer.body].shape, body, *points_m.last()?, grid),
        points_m,
    })
}

/// The edges of a body around its middle, as large as its voxels.
fn outline(shape: BodyShape, body: &Body, middle: DVec3, grid: &Grid) -> Vec<Vec<DVec3>> {
    let half = DVec3::from_array(body.size.map(|n| f64::from(n) / 2.0 * grid.voxel_size_m));
    let circle = |corner: &dyn Fn(f64, f64) -> DVec3| -> Vec<DVec3> {
        let angle = |number: usize| number as f64 * std::f64::consts::TAU / CORNERS as f64;
        (0..=CORNERS).map(|number| libm::sincos(angle(number))).map(|(sin, cos)| corner(cos, sin)).collect()
    };
    let lines: Vec<Vec<DVec3>> = match shape {
        BodyShape::Ball { .. } => vec![
            circle(&|a, b| DVec3::new(a, b, 0.0)),
            circle(&|a, b| DVec3::new(a, 0.0, b)),
            circle(&|a, b| DVec3::new(0.0, a, b)),
        ],
        BodyShape::Cylinder { .. } | BodyShape::Box { .. } => {
            let is_round = matches!(shape, BodyShape::Cylinder { .. });
            let square = [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0], [1.0, 1.0]];
            let rim = |z: f64| match is_round {
                true => circle(&|a, b| DVec3::new(a, b, z)),
                false => square.map(|[x, y]| DVec3::new(x, y, z)).to_vec(),
            };
            let (low, high) = (rim(-1.0), rim(1.0));
            let quarter = low.len() / 4;
            let uprights = (0..4).map(|number| vec![low[number * quarter], high[number * quarter]]);
            let uprights: Vec<_> = uprights.collect();
            [vec![low, high], uprights].concat()
        }
    };
    let at = |point: DVec3| middle + half * point;
    lines.into_iter().map(|line| line.into_iter().map(at).collect()).collect()
}
