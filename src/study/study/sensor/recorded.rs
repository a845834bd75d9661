//! The keys of a sensor whose evidence was recorded.

use std::path::PathBuf;

use serde::Deserialize;

use super::Context;
use crate::diagnostics::Place;
use crate::keys::{Quaternion, exactly};
use crate::sensor::recorded::{Recorded, RecordedMoment};
use perirobot_march::Result;
use perirobot_scene::pose::{Frame, Pose};
use perirobot_scene::recording::{Anchor, Asked, FARTHEST_M, Recording};
use perirobot_scene::scene::spec::SceneSpec;

/// A map or a point cloud that a real sensor recorded.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RecordedFile {
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
    quaternion: Option<Quaternion>,
    /// Of a point cloud: where the sensor was, in the recording's frame. Default what a .pcd says, else the
    /// frame's origin.
    sensor_m: Option<[f64; 3]>,
    /// Of a bag: the topic of the point clouds. Default the only one.
    topic: Option<String>,
    /// Of a bag: the number of a message of the topic, counted from 0. Default all of them together.
    message: Option<usize>,
}

/// The sensor, and what its user may not expect.
pub(super) fn check(at: &Place, file: RecordedFile, context: &Context) -> Result<(Recorded, Vec<String>)> {
    at.some("recording", &file.recording, "[[sensor.recording]] file = \"scan.bt\"")?;
    let mut moments: Vec<RecordedMoment> = Vec::new();
    for (number, entry) in file.recording.into_iter().enumerate() {
        let at = at.key(&format!("recording[{number}]"));
        let read = one(&at, entry, context)?;
        if moments.iter().any(|other| other.moment == read.moment) {
            return Err(at
                .says("is of a moment that has a recording already")
                .wanted("give each scene and snapshot one, or a second sensor of this kind"));
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
    Ok((Recorded { moments }, warnings))
}

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
            return Err(at.says("snapshot is missing").wanted(rule));
        }
    };
    let position_m = at.vector_within("position_m", entry.position_m, FARTHEST_M)?;
    let anchor = match (entry.yaw_deg, entry.quaternion) {
        (Some(_), Some(_)) => return Err(at.says("both yaw_deg and quaternion").wanted("give one of them")),
        (None, Some(q)) => Pose::from_quaternion(position_m, [q.w, q.x, q.y, q.z], Frame::Link)
            .map(Anchor::of_pose)
            .map_err(|rule| at.wrong("quaternion", q, &rule.to_string()))?,
        (yaw_deg, None) => {
            let rule = "an angle from -360 to 360 degrees";
            let yaw_deg = at.number("yaw_deg", yaw_deg.unwrap_or(0.0), -360.0..=360.0, rule)?;
            Anchor::new(position_m, yaw_deg.to_radians())
        }
    };
    let sensor_m = entry.sensor_m.map(|place| at.vector_within("sensor_m", place, FARTHEST_M)).transpose()?;
    let path = at.folder().join(entry.file);
    let asked = Asked { sensor_m, topic: entry.topic.as_deref(), message: entry.message };
    let recording = Recording::read(&path, asked, context.sources).map_err(|e| at.around(e.at("file")))?;
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
        None => Err(at.says("scene is missing").wanted(format!("write of which scene it is: {known:?}"))),
    }
}
