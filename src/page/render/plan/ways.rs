//! Unnoticed ways of bodies on a floor plan, and the bodies at their ends.

use std::fmt::Display;

use super::FloorPlan;
use super::paper::Paper;
use perirobot_decide::approach::Way;

/// A polyline of the world, as a path.
fn path(paper: &Paper, points: &[glam::DVec3]) -> String {
    let at = points.iter().map(|&point| paper.project_down(point)).map(|[x, y]| format!("{x} {y}"));
    format!("M{}", at.collect::<Vec<_>>().join("L"))
}

impl FloorPlan {
    /// The same plan with ways drawn over it.
    pub fn with_ways(mut self, ways: &[Way]) -> FloorPlan {
        for way in ways {
            let lines = way.outline_m.iter().map(|line| path(&self.paper, line)).collect::<String>();
            let drawn: [(&str, &dyn Display); 2] =
                [("class", &"way"), ("d", &(path(&self.paper, &way.points_m) + &lines))];
            self.drawing.add_titled("path", &drawn, &way.words());
            self.legend.push(("way", way.words()));
        }
        self
    }
}
