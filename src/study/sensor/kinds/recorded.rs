//! A sensor whose evidence was recorded: a map, or a point cloud, of one moment of a scene.

use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use serde::Deserialize;

use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::keys::{QuaternionKeys, exactly};
use crate::sensor::{Approached, Claim, Extent, Kind, MEASURES, Setting, Station};
use perirobot_march::Result;
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::pose::{Pose, RotationFrame};
use perirobot_scene::recording::{Anchor, FARTHEST_M, Recording, RecordingSelection, Said};

/// A map or a point cloud that a real sensor recorded.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RecordedFile {
    /// What was recorded, an entry for each moment.
    recording: Vec<RecordingFile>,
}

/// What was recorded at one moment.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct RecordingFile {
    /// An OctoMap (.bt, .ot), labels (.npz), a point cloud (.pcd, .ply) or a ROS 2 bag with such (.mcap).
    file: PathBuf,
    /// Of which scene. Default the study's only one.
    scene: Option<String>,
    /// Of which moment of it, counted from 0. Default the only one.
    snapshot: Option<usize>,
    /// Where the origin of its frame is in the world, in metres. Default the world's origin.
    #[serde(default, deserialize_with = "exactly")]
    position_m: [f64; 3],
    /// How far its frame is turned about the vertical, from x towards y. Default 0.
    yaw_deg: Option<f64>,
    /// Of a point cloud, in place of the yaw: how its frame is turned in the world.
    quaternion: Option<QuaternionKeys>,
    /// Of a point cloud: where the sensor was, in the recording's frame. Default what a .pcd says, else the
    /// frame's origin.
    sensor_m: Option<[f64; 3]>,
    /// Of a bag: the topic of the point clouds. Default the only one.
    topic: Option<String>,
    /// Of a bag: the number of a message of the topic, counted from 0. Default all of them together.
    message: Option<usize>,
}

impl KindFile for RecordedFile {
    const NAME: &'static str = "recorded";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "a recording of a real sensor at some moments of the scenes: a map (OctoMap `.bt`, `.ot`; labels \
        `.npz`), a point cloud (`.pcd`, `.ply`), or a ROS 2 bag (`.mcap`); see [recorded \
        maps][recorded]",
        keys: "`[[sensor.recording]]`: `file`, `scene?`, `snapshot?` (needed if there are several), `position_m?` \
        and `yaw_deg?` of its frame in the world (0), or `quaternion?` instead of the yaw for a tilted \
        cloud; `sensor_m?` of a cloud: the position of the sensor, in the recording's frame; `topic?` and \
        `message?` (a number) of a bag",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "voxels that contain a part of an occupied voxel of a map; those of a cloud's points",
            free: "voxels that free voxels of a map cover; those before a cloud's points",
        }],
    };

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        at.some("recording", &self.recording, "[[sensor.recording]] file = \"scan.bt\"")?;
        let mut moments: Vec<RecordedMoment> = Vec::new();
        for (number, entry) in self.recording.into_iter().enumerate() {
            let at = at.key(&format!("recording[{number}]"));
            let read = one(&at, entry, context)?;
            if moments.iter().any(|other| other.moment == read.moment) {
                return Err(at
                    .says("is of a moment that has a recording already")
                    .with_advice("give each scene and snapshot one, or a second sensor of this kind"));
            }
            moments.push(read);
        }
        let all: usize = context.scenes.iter().map(|scene| scene.snapshots).sum();
        let mut warnings = context.sources.take_remarks();
        if moments.len() < all {
            warnings.push(format!(
                "has recordings of {} of the study's {all} moments, and says nothing at the others",
                moments.len()
            ));
        }
        Ok(Checked { kind: Arc::new(Recorded { moments }), warnings })
    }
}

/// What was recorded at one moment.
fn one(at: &Place, entry: RecordingFile, context: &Context) -> Result<RecordedMoment> {
    let scene = scene(at, entry.scene.as_deref(), context.scenes)?;
    let snapshots = context.scenes[scene].snapshots;
    let snapshot = match entry.snapshot {
        Some(snapshot) if snapshot < snapshots => snapshot,
        Some(snapshot) => {
            return Err(at.wrong("snapshot", snapshot, &format!("must be from 0 to {}", snapshots - 1)));
        }
        None if snapshots == 1 => 0,
        None => {
            let rule = format!("write of which of the {snapshots} moments it is, counted from 0");
            return Err(at.says("snapshot is missing").with_advice(rule));
        }
    };
    let position_m = at.vector_within("position_m", entry.position_m, FARTHEST_M)?;
    let anchor = match (entry.yaw_deg, entry.quaternion) {
        (Some(_), Some(_)) => {
            return Err(at.says("both yaw_deg and quaternion").with_advice("give one of them"));
        }
        (None, Some(q)) => Pose::from_quaternion(position_m, [q.w, q.x, q.y, q.z], RotationFrame::Link)
            .map(Anchor::from_pose)
            .map_err(|rule| at.wrong("quaternion", q, &rule.to_string()))?,
        (yaw_deg, None) => {
            let rule = "an angle from -360 to 360 degrees";
            let yaw_deg = at.number("yaw_deg", yaw_deg.unwrap_or(0.0), -360.0..=360.0, rule)?;
            Anchor::new(position_m, yaw_deg.to_radians())
        }
    };
    let sensor_m = entry.sensor_m.map(|place| at.vector_within("sensor_m", place, FARTHEST_M)).transpose()?;
    let path = at.folder().join(entry.file);
    let asked = RecordingSelection { sensor_m, topic: entry.topic.as_deref(), message: entry.message };
    let recording =
        Recording::read(&path, asked, context.sources).map_err(|e| at.wrap(e.with_place("file")))?;
    if let (Recording::Map(_), Some(place)) = (&recording, entry.sensor_m) {
        let rule = "is asked of point clouds only, and the file is a map: leave it out";
        return Err(at.wrong("sensor_m", format!("{place:?}"), rule));
    }
    Ok(RecordedMoment::new([scene, snapshot], recording, anchor))
}

/// Index of the scene that is named, or of the only one.
fn scene(at: &Place, name: Option<&str>, scenes: &[SceneSpec]) -> Result<usize> {
    let known: Vec<&str> = scenes.iter().map(|scene| scene.name.as_str()).collect();
    match name {
        Some(name) => known.iter().position(|scene| *scene == name).ok_or_else(|| {
            at.wrong("scene", format!("{name:?}"), &format!("must be a scene of the study: {known:?}"))
        }),
        None if known.len() == 1 => Ok(0),
        None => {
            Err(at.says("scene is missing").with_advice(format!("write of which scene it is: {known:?}")))
        }
    }
}

/// What was recorded of some moments; of others it says nothing.
#[derive(Debug)]
pub struct Recorded {
    /// No two are of one moment.
    pub moments: Vec<RecordedMoment>,
}

/// What was recorded of one moment.
#[derive(Debug)]
pub struct RecordedMoment {
    /// Index of the scene, and which moment of it.
    pub moment: [usize; 2],
    /// What was recorded.
    pub recording: Recording,
    /// Where its frame stands.
    pub anchor: Anchor,
    /// What it says in the grid that was asked for last, as long as it is.
    said: Mutex<Option<(Grid, Arc<Said>)>>,
}

impl RecordedMoment {
    /// A recording of a moment (scene and snapshot), with its frame at a place in the world.
    pub fn new(moment: [usize; 2], recording: Recording, anchor: Anchor) -> RecordedMoment {
        RecordedMoment { moment, recording, anchor, said: Mutex::default() }
    }

    /// What it says in a grid.
    fn grid_evidence(&self, grid: &Grid) -> Arc<Said> {
        let mut kept = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        match &*kept {
            Some((of, said)) if of == grid => said.clone(),
            _ => {
                let said = Arc::new(self.recording.planes(&self.anchor, grid));
                *kept = Some((*grid, said.clone()));
                said
            }
        }
    }
}

impl Recorded {
    /// The recording of a station's moment, if there is one.
    fn moment(&self, at: &Station) -> Option<&RecordedMoment> {
        self.moments.iter().find(|one| one.moment == at.moment)
    }

    /// What was recorded at a station's moment: planes over its grid.
    fn planes(&self, at: &Station) -> Option<Planes> {
        let said = self.moment(at)?.grid_evidence(&at.truth.grid);
        let mut planes = said.planes.clone();
        if !said.knows_hits {
            // A map does not tell where a return in an occupied voxel came from: from there, if there is something.
            planes.hits = planes.occupied.clone();
            planes.hits.keep(&at.truth.occupied);
        }
        Some(planes)
    }
}

impl Kind for Recorded {
    fn name(&self) -> &'static str {
        RecordedFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["map"]
    }

    fn settings(&self) -> Vec<(String, Setting)> {
        vec![("recorded".into(), Setting::Fixed)]
    }

    fn takes_poses(&self) -> bool {
        false
    }

    fn approached(&self) -> Option<Approached> {
        None
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        let Some(moment) = self.moment(at) else { return Ok(()) };
        let grid = &at.truth.grid;
        if !moment.recording.fits(&moment.anchor) {
            return Err(Issue::says("is a map, which can be turned about the vertical only")
                .with_advice("give an upright pose; point clouds may be tilted"));
        }
        if moment.recording.is_too_fine(&moment.anchor, grid) {
            return Err(Issue::too_large(
                "its map has voxels below 1/64 of the study's, or too many inside the grid",
            )
            .with_advice("make it coarser, or set bounds_m of [grid]"));
        }
        let Planes { occupied, free, .. } = &moment.grid_evidence(grid).planes;
        if !occupied.is_empty() || !free.is_empty() {
            return Ok(());
        }
        let [from, to] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
        let [low, high] = moment.recording.bounds_m().map(|corner| moment.anchor.world(corner));
        Err(Issue::says(format!(
            "says nothing inside the grid ({from:.2} to {to:.2} m): the recording's corners are at {low:.2} and {high:.2} m"
        ))
        .with_advice("move it with position_m and yaw_deg"))
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let planes = self.planes(at).map(|planes| {
            let [occupied, free, hits] =
                [planes.occupied, planes.free, planes.hits].map(|plane| plane.to_window(at.window));
            Planes { occupied, free, hits }
        });
        vec![Claim { cast: false, planes }]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.planes(at).map_or_else(BitGrid::nowhere, |planes| planes.hits))
    }

    // It tells what was, and nobody who comes later.
    fn watches(&self, _: usize, _: &Station) -> Option<BitGrid> {
        Some(BitGrid::nowhere())
    }

    fn reach(&self, at: &Station) -> Extent {
        let known = self.planes(at).map(|planes| {
            let mut known = planes.occupied;
            known.add(&planes.free);
            known
        });
        Extent::Only(known.unwrap_or_else(BitGrid::nowhere))
    }
}
