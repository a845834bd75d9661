//! The nearest unnoticed ways of bodies to the robot for the recommended choice, scene by scene, for the floor plans
//! and the 3D view, if the study has a table `[approach]`.

use glam::DVec3;
use serde::Serialize;

use super::ReportedSweep;
use perirobot_decide::approach::{Ground, Way, nearest_ways};
use perirobot_decide::view::Choice;
use perirobot_decide::view::watched::Watchers;
use perirobot_march::Result;

/// The ways of bodies in each scene; empty if the study has no table `[approach]`.
///
/// # Errors
/// If they cannot be computed in this cell.
pub(super) fn ways(sweep: &ReportedSweep, looked: Choice) -> Result<Vec<Vec<Way>>> {
    let study: toml::Table = toml::from_str(&sweep.study.text).unwrap_or_default();
    if !study.contains_key("approach") {
        return Ok(Vec::new());
    }
    let watchers = Watchers::new(sweep.study, looked);
    let grounds = Ground::from_scenes(sweep.study, sweep.worlds, watchers.each())?;
    grounds.iter().map(|ground| nearest_ways(ground, ground.worlds, &watchers)).collect()
}

/// A way in the 3D view.
#[derive(Debug, Serialize)]
pub(super) struct WayData {
    scene: usize,
    words: String,
    /// The path of the body's centre, then the lines of the body at the end: each from point to point, in world metres.
    lines: Vec<Vec<[f64; 3]>>,
}

/// The ways of all scenes.
pub(super) fn way_data(ways: &[Vec<Way>]) -> Vec<WayData> {
    let line = |points: &Vec<DVec3>| -> Vec<[f64; 3]> {
        points.iter().map(|point| point.to_array().map(|x| (x * 1e3).round() / 1e3)).collect()
    };
    let data = |scene: usize, way: &Way| WayData {
        scene,
        words: way.words(),
        lines: [&way.points_m].into_iter().chain(&way.outline_m).map(line).collect(),
    };
    ways.iter().enumerate().flat_map(|(scene, ways)| ways.iter().map(move |way| data(scene, way))).collect()
}
