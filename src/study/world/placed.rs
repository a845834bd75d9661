//! What is wrong with one sensor where somebody has placed it, in the words of the warnings about whole studies.

use super::{World, dead, stuck};
use crate::input::Study;
use crate::sensor::{Setting, Stance};
use perirobot_march::voxel::Grid;

/// What is wrong with a sensor where it is placed.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PlacementProblem {
    /// In words, with what to do.
    pub words: String,
    /// Whether it cannot be counted there at all.
    pub is_impossible: bool,
}

impl World {
    /// Why a sensor at a candidate cannot be counted at this moment, in words: it is outside of the grid, or not where its
    /// kind can work.
    pub fn impossible_placement(&self, study: &Study, [sensor, candidate]: [usize; 2]) -> Option<String> {
        let setting = self.settings[sensor][candidate];
        let (mount, checked) = self.examine_setting(study, &self.truth(), [sensor, candidate], setting);
        checked.err().map(|issue| match mount.is_empty() {
            true => issue.to_string(),
            false => format!("{issue} ({})", mount.trim_start()),
        })
    }

    /// What a switch at a candidate says at this moment whoever is there: that it is muted, or always on. `None` of one that
    /// detects, and of other sensors.
    pub fn stuck_at(&self, study: &Study, [sensor, candidate]: [usize; 2]) -> Option<&'static str> {
        let truth = self.truth();
        let station = stuck::exact_station(self, &truth, [sensor, candidate]);
        let kind = &study.sensors[sensor].kind;
        match kind.is_muted(&station) {
            true => Some("muted: it detects nothing"),
            false => (!kind.stuck_by(&station).is_empty()).then_some("always on: the environment trips it"),
        }
    }

    /// What is wrong with a sensor at a candidate at this moment; the first of: outside of the grid, not where its kind can
    /// work, inside of an object, always on, blind. Of a sensor that is walled in nothing is said.
    pub fn placement_problem(
        &self,
        study: &Study,
        [sensor, candidate]: [usize; 2],
    ) -> Option<PlacementProblem> {
        if let Some(words) = self.impossible_placement(study, [sensor, candidate]) {
            return Some(PlacementProblem { words, is_impossible: true });
        }
        let (truth, setting) = (self.truth(), self.settings[sensor][candidate]);
        let kind = &*study.sensors[sensor].kind;
        let is_inside = |setting: Setting| match setting {
            Setting::Pose(pose) => {
                kind.blockers(&truth).get(Grid::voxel_of(self.grid.position_q16(pose.position_m)))
            }
            _ => false,
        };
        let looks_out = kind.stance() != Stance::Level;
        let words = if looks_out && is_inside(setting) {
            let words = "stands in an occupied voxel (move it out of it): its rays start behind its surface";
            Some(words.to_string())
        } else if let Some(what) = stuck::tripped_by(study, self, [sensor, candidate]) {
            Some(format!(
                "the environment alone trips it, so that it is always on ({what}): {}",
                kind.stuck_advice()
            ))
        } else {
            dead::blindness(study, self, [sensor, candidate])
        };
        words.map(|words| PlacementProblem { words, is_impossible: false })
    }
}
