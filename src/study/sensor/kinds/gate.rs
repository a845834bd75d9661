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
use perirobot_scene::objects::Role;

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
    /// Whether it stays on until it is reset: then all people in the zone have come in through it. Default false.
    #[serde(default)]
    latch: bool,
    /// Names of objects during whose passage it says nothing: while one of them is in the box.
    #[serde(default)]
    muted_by: Vec<String>,
    /// Moments at which it says nothing: numbers of snapshots, counted from 0.
    #[serde(default)]
    muted_at: Vec<usize>,
}

impl KindFile for GateFile {
    const NAME: &'static str = "gate";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "light curtain; without poses its box and zone are in the world",
        keys: "`box`, `zone` (both `{ min_m, max_m }`), `otherwise?` (unknown), `latch?`, `muted_by?`, `muted_at?`",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "its zone, if the truth has an occupied voxel in its box, or with `latch` a person's voxel in its zone",
            free: "else the zone, if `otherwise = \"free\"`; nothing while it is muted",
        }],
    };

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        check_muting(at, &self, context)?;
        let gate = Gate {
            gate: prism(at, "box", &self.r#box)?,
            zone: prism(at, "zone", &self.zone)?,
            // An uncrossed curtain does not show that nobody stepped over it.
            otherwise_free: self.otherwise == Some(Silence::Free),
            latches: self.latch,
            muted_by: self.muted_by,
            muted_at: self.muted_at,
        };
        Ok(gate.into())
    }
}

/// Refuses muting by people, by objects or at moments that no scene has, and of a curtain that latches.
fn check_muting(at: &Place, file: &GateFile, context: &Context) -> Result<()> {
    let is_muted = !file.muted_by.is_empty() || !file.muted_at.is_empty();
    if file.latch && is_muted {
        return Err(at.says("both latch and muting").with_advice(
            "people who come in while it is muted are not detected by a latch: take latch away, and detect people in the \
             zone with another sensor",
        ));
    }
    // Of scenes that could not be read nothing is known.
    if !context.has_all_scenes {
        return Ok(());
    }
    let objects = || context.scenes.iter().flat_map(|scene| &scene.objects);
    for name in &file.muted_by {
        let wrong = |rule: &str| Err(at.wrong("muted_by", format!("[{name:?}]"), rule));
        match objects().find(|object| object.has_part(name)) {
            Some(object) if object.role == Role::Human => {
                return wrong("must not be a person: a curtain that people mute detects nobody");
            }
            Some(_) => {}
            None => {
                let mut names: Vec<&str> = objects().map(|object| object.name.as_str()).collect();
                names.sort_unstable();
                names.dedup();
                return wrong(&format!("must be objects of a scene: {names:?}"));
            }
        }
    }
    let most = context.scenes.iter().map(|scene| scene.snapshots).max().unwrap_or(0);
    if let Some(snapshot) = file.muted_at.iter().find(|&&snapshot| snapshot >= most) {
        let rule = format!("must be snapshots of a scene, from 0 to {}", most.saturating_sub(1));
        return Err(at.wrong("muted_at", format!("[{snapshot}]"), &rule));
    }
    Ok(())
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
    /// Whether it stays on until it is reset.
    pub(crate) latches: bool,
    /// Objects that mute it while they are in the box.
    pub(crate) muted_by: Vec<String>,
    /// Snapshots in which it is muted.
    pub(crate) muted_at: Vec<usize>,
}

impl Gate {
    /// Where it senses.
    fn gate(&self, at: &Station) -> BitGrid {
        self.gate.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window())
    }

    /// Where it senses people: with a latch, whoever is in the zone has come in through the gate.
    fn felt(&self, at: &Station) -> BitGrid {
        let gate = self.gate(at);
        if !self.latches {
            return gate;
        }
        let zone = self.zone.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window());
        let mut both = gate.to_window(gate.window().union(&zone.window()));
        both.add(&zone);
        both
    }

    /// What stands in the gate.
    fn intruders(&self, at: &Station) -> BitGrid {
        let mut inside = self.gate(at);
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

    fn latches(&self) -> bool {
        self.latches
    }

    fn is_muted(&self, at: &Station) -> bool {
        if self.muted_by.is_empty() {
            return self.muted_at.contains(&at.moment[1]);
        }
        let gate = self.gate(at);
        let mutes = |name: &String| {
            let mut parts = at.truth.objects.iter().filter(|object| object.is_part_of(name));
            parts.any(|object| gate.intersects(&object.voxels))
        };
        self.muted_at.contains(&at.moment[1]) || self.muted_by.iter().any(mutes)
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        if self.is_muted(at) {
            return BitGrid::nowhere();
        }
        let mut fixed = self.intruders(at);
        fixed.remove(&at.truth.human);
        fixed.remove(&at.truth.robot);
        fixed
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        if self.is_muted(at) {
            return vec![Claim::default()];
        }
        let mut people = self.felt(at);
        people.keep(&at.truth.occupied);
        people.keep(&at.truth.human);
        let on = !people.is_empty() || !self.intruders(at).is_empty();
        let zone = self.zone.voxels(&at.pose(), &at.truth.grid, at.window);
        vec![switch_planes(at, zone, on, self.otherwise_free, people)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.felt(at))
    }

    fn watches(&self, _: usize, at: &Station) -> Option<BitGrid> {
        Some(match self.is_muted(at) {
            true => BitGrid::nowhere(),
            // Nobody is noticed in the zone who was not noticed on the way in.
            false => self.gate(at),
        })
    }

    fn latched(&self, at: &Station) -> BitGrid {
        match self.latches {
            true => self.zone.voxels(&at.pose(), &at.truth.grid, at.truth.grid.window()),
            false => BitGrid::nowhere(),
        }
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
            latches: false,
            muted_by: Vec::new(),
            muted_at: Vec::new(),
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

    /// Who is in the zone came in through the gate; things in it did not.
    #[test]
    fn a_latch_stays_on_for_people_in_the_zone() {
        let zone = block([1, 0, 0], [2, 3, 1]);
        let latch = Gate { latches: true, ..gate(true) };
        let with = |role: Role, voxel: [i32; 3], gate: &Gate| {
            let mut truth = empty([8, 8, 4], 1.0);
            put(&mut truth, role, &[voxel], None);
            let here = station(&truth, Setting::Fixed);
            let hits =
                gate.claims(&here).remove(0).planes.map(|planes| planes.hits.voxels().collect::<Vec<_>>());
            (says(gate, 0, &here), hits.unwrap())
        };
        let (human, thing, robot) = (Role::Human, Role::Environment, Role::Robot);
        let on = |felt: &[[i32; 3]]| (Says::Occupied(zone.clone()), felt.to_vec());
        let off = || (Says::Free(zone.clone()), Vec::new());
        assert_eq!(with(human, [2, 1, 0], &latch), on(&[[2, 1, 0]]));
        assert_eq!(with(human, [0, 1, 0], &latch), on(&[[0, 1, 0]]));
        assert_eq!(with(human, [3, 1, 0], &latch), off(), "beyond the zone");
        assert_eq!(with(thing, [2, 1, 0], &latch), off());
        assert_eq!(with(robot, [2, 1, 0], &latch), off());
        assert_eq!(with(thing, [0, 1, 0], &latch), on(&[]));
        assert_eq!(with(human, [2, 1, 0], &gate(true)), off(), "without a latch");
        // Nobody is noticed in the zone who was not noticed on the way in.
        let truth = empty([8, 8, 4], 1.0);
        let here = station(&truth, Setting::Fixed);
        let watched = latch.watches(0, &here).unwrap().voxels().collect::<Vec<_>>();
        assert_eq!(watched, block([0, 0, 0], [0, 3, 1]));
        assert_eq!(latch.latched(&here).voxels().collect::<Vec<_>>(), zone);
        assert!(gate(true).latched(&here).is_empty());
    }

    #[test]
    fn a_muted_gate_says_nothing() {
        let mut truth = empty([8, 8, 4], 1.0);
        put(&mut truth, Role::Environment, &[[0, 0, 0], [5, 0, 0]], None);
        put(&mut truth, Role::Human, &[[0, 2, 0]], None);
        let muted = |by: &str, at: &[usize]| Gate {
            muted_by: if by.is_empty() { Vec::new() } else { vec![by.into()] },
            muted_at: at.to_vec(),
            ..gate(true)
        };
        let at = |snapshot: usize| Station { moment: [0, snapshot], ..station(&truth, Setting::Fixed) };
        let on = Says::Occupied(block([1, 0, 0], [2, 3, 1]));
        assert_eq!(says(&muted("object 0", &[]), 0, &at(0)), Says::Nothing);
        assert_eq!(says(&muted("object", &[]), 0, &at(0)), on, "is no part of it");
        assert_eq!(says(&muted("", &[1, 3]), 0, &at(3)), Says::Nothing);
        assert_eq!(says(&muted("", &[1, 3]), 0, &at(2)), on);
        assert_eq!(muted("", &[3]).watches(0, &at(3)), Some(BitGrid::nowhere()));
        // A thing that mutes it does not trip it for ever; another does.
        assert!(muted("object 0", &[]).stuck_by(&at(0)).is_empty());
        assert!(!muted("", &[2]).stuck_by(&at(0)).is_empty());
        // The thing has left.
        let mut later = empty([8, 8, 4], 1.0);
        put(&mut later, Role::Environment, &[[5, 0, 0]], None);
        put(&mut later, Role::Human, &[[0, 2, 0]], None);
        assert_eq!(says(&muted("object 0", &[]), 0, &station(&later, Setting::Fixed)), on);
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
