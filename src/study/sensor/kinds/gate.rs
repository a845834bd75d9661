//! A light curtain: its zone counts as occupied while something is in the gate.

use serde::Deserialize;

use super::shared::{Silence, prism};
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::keys::BoxFile;
use crate::sensor::prism::Prism;
use crate::sensor::{Claim, Extent, Kind, SWITCHES, Setting, Stance, Station, level, switch_planes};
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;

/// A light curtain.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct GateFile {
    /// Where it senses.
    r#box: BoxFile,
    /// What is occupied while something is in the box.
    zone: BoxFile,
    /// What an idle curtain says of the zone. Default "unknown".
    otherwise: Option<Silence>,
}

impl KindFile for GateFile {
    const NAME: &'static str = "gate";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "light curtain; without poses its box and zone are in the world",
        keys: "`box`, `zone` (both `{ min_m, max_m }`), `otherwise?` (unknown)",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "its zone, if the truth has an occupied voxel in its box",
            free: "else the zone, if `otherwise = \"free\"`",
        }],
    };

    fn check(self, at: &Place, _: &Context) -> Result<Checked> {
        Ok(Gate {
            gate: prism(at, "box", &self.r#box)?,
            zone: prism(at, "zone", &self.zone)?,
            // An uncrossed curtain does not show that nobody stepped over it.
            otherwise_free: self.otherwise == Some(Silence::Free),
        }
        .into())
    }
}

/// The gate's box and the zone behind it, both in the gate's frame.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Gate {
    /// Where it senses.
    pub(crate) gate: Prism,
    /// The zone that it labels.
    pub(crate) zone: Prism,
    /// Whether an uninterrupted curtain certifies that the zone is free.
    pub(crate) otherwise_free: bool,
}

impl Gate {
    /// What stands in the gate.
    fn intruders(&self, at: &Station) -> BitGrid {
        let mut inside = self.gate.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window());
        inside.keep(&at.truth.occupied);
        inside
    }
}

impl Kind for Gate {
    fn name(&self) -> &'static str {
        GateFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn stance(&self) -> Stance {
        Stance::Level
    }

    fn settings(&self) -> Vec<(String, Setting)> {
        // Its box and zone are then the world's, or its link's.
        vec![("here".into(), Setting::Fixed)]
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        SWITCHES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn prisms(&self) -> Vec<&Prism> {
        vec![&self.gate, &self.zone]
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        level(at)?;
        self.gate.check(&at.pose(), &at.truth.grid).map_err(|e| e.with_place("box"))?;
        self.zone.check(&at.pose(), &at.truth.grid).map_err(|e| e.with_place("zone"))
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        let mut fixed = self.intruders(at);
        fixed.remove(&at.truth.human);
        fixed.remove(&at.truth.robot);
        fixed
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let (pose, grid) = (at.pose(), &at.truth.grid);
        let mut inside = self.intruders(at);
        let on = !inside.is_empty();
        inside.keep(&at.truth.human);
        vec![switch_planes(at, self.zone.voxels(&pose, grid, at.window), on, self.otherwise_free, inside)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.gate.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window()))
    }

    fn reach(&self, at: &Station) -> Extent {
        Extent::Only(self.zone.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window()))
    }
}

/// A curtain one voxel thick before a zone of two.
#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::tests::{Says, block, empty, facing, put, says, station};
    use perirobot_scene::objects::Role;

    fn gate(otherwise_free: bool) -> Gate {
        let between = |low: [f64; 3], high: [f64; 3]| Prism::from_corners(low.into(), high.into());
        Gate {
            gate: between([0.0, 0.0, 0.0], [1.0, 4.0, 2.0]),
            zone: between([1.0, 0.0, 0.0], [3.0, 4.0, 2.0]),
            otherwise_free,
        }
    }

    #[test]
    fn whatever_is_in_the_box_switches_the_zone() {
        let zone = block([1, 0, 0], [2, 3, 1]);
        for (voxel, on) in
            [([0, 0, 0], true), ([0, 3, 1], true), ([1, 0, 0], false), ([0, 4, 0], false), ([0, 0, 2], false)]
        {
            let mut truth = empty([8, 8, 4], 1.0);
            put(&mut truth, Role::Environment, &[voxel], None);
            let here = station(&truth, Setting::Fixed);
            let [free, unknown] = [true, false].map(|free| says(&gate(free), 0, &here));
            if on {
                assert_eq!(
                    (free, unknown),
                    (Says::Occupied(zone.clone()), Says::Occupied(zone.clone())),
                    "{voxel:?}"
                );
            } else {
                assert_eq!((free, unknown), (Says::Free(zone.clone()), Says::Nothing), "{voxel:?}");
            }
        }
    }

    #[test]
    fn a_pose_carries_box_and_zone() {
        let mut truth = empty([8, 8, 4], 1.0);
        put(&mut truth, Role::Human, &[[7, 2, 1]], None);
        // Facing −x from (8, 6): the box is x 7…8, y 2…6, the zone x 5…7.
        let at = facing(&truth, [8.0, 6.0, 0.0], [-1.0, 0.0, 0.0]);
        let zone = block([5, 2, 0], [6, 5, 1]);
        assert_eq!(says(&gate(true), 0, &at), Says::Occupied(zone.clone()));
        let Extent::Only(reach) = gate(true).reach(&at) else { panic!("a gate casts no rays") };
        assert_eq!(reach.voxels().collect::<Vec<_>>(), zone);
        assert_eq!((gate(true).stance(), gate(true).log_odds(0)), (Stance::Level, [3511, -405]));
    }

    #[test]
    fn box_and_zone_hold_a_voxel_of_the_grid() {
        let truth = empty([8, 8, 4], 1.0);
        let check = |x| gate(true).check(&facing(&truth, [x, 0.0, 0.0], [1.0, 0.0, 0.0]));
        assert_eq!(check(6.0), Ok(()));
        assert!(check(7.0).unwrap_err().to_string().starts_with("zone: its volume holds no voxel"));
        assert!(check(8.0).unwrap_err().to_string().starts_with("box: its volume holds no voxel"));
        // Without a pose it is in the world's frame, and stretches no grid.
        assert_eq!(gate(true).settings(), [("here".to_string(), Setting::Fixed)]);
    }
}
