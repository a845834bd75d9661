//! `perirobot score`: a recorded map against the truth.

use std::path::PathBuf;
use std::process::ExitCode;

use glam::DVec3;
use perirobot_decide::view::{ChoiceSelector, RecordedMap, find_scene};
use perirobot_march::Result;
use perirobot_page::report::terminal::scored_map;
use perirobot_scene::recording::{Anchor, FARTHEST_M, Recording, RecordingSelection};
use perirobot_scene::source::Sources;
use perirobot_study::world::World;
use perirobot_sweep::results::rows::RowsFile;
use perirobot_sweep::results::table::TableFormat;

use super::study::StudyArgs;

/// Score a map that real sensors recorded against a scene
///
/// Reads an OctoMap (.bt, .ot), labels (.npz, as `perirobot export` writes them), a point cloud (.pcd, .ply) or those
/// of a ROS 2 bag (.mcap) into the study's grid, and compares it with the truth of one scene at one moment in the same
/// way as a sweep compares a sensor. The study's own sensors are not cast. A voxel of the study is occupied if it
/// overlaps an occupied voxel of the map, free if free ones cover it, else unknown. The points of a cloud mark their
/// voxels and free those between them and the sensor. Missed objects are reported by reason.
///
/// To fuse a recorded map with other sensors, use a sensor with kind = "recorded" in the study.
#[derive(clap::Args)]
#[command(after_help = AFTER_HELP)]
pub(super) struct Args {
    /// The map or cloud
    #[arg(value_name = "MAP")]
    map: PathBuf,
    #[command(flatten)]
    study: StudyArgs,
    /// The recorded scene [default: the study's first]
    #[arg(long, value_name = "NAME", help_heading = "Recording")]
    scene: Option<String>,
    /// The moment of that scene, counted from 0
    #[arg(long, value_name = "N", default_value_t = 0, help_heading = "Recording")]
    snapshot: usize,
    /// The map's frame in the world: its origin in metres, and its rotation about the vertical in degrees, from x
    /// towards y; a cloud may be tilted, by QW,QX,QY,QZ instead of YAW [default: 0,0,0,0]
    #[arg(long, value_name = "X,Y,Z,YAW", allow_hyphen_values = true, value_parser = anchor, help_heading = "Recording")]
    at: Option<Anchor>,
    /// The sensor's position in the recording's frame, in metres: a point cloud is carved from there; for a map it
    /// decides what was hidden [default: the viewpoint of a .pcd, else the frame's origin]
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true, value_parser = place, help_heading = "Recording")]
    sensor: Option<DVec3>,
    /// For a .mcap: the topic of the point clouds [default: the only one]
    #[arg(long, value_name = "NAME", help_heading = "Recording")]
    topic: Option<String>,
    /// For a .mcap: one message of the topic, counted from 0 [default: all messages together]
    #[arg(long, value_name = "N", help_heading = "Recording")]
    message: Option<usize>,
    /// A table with the columns of results.csv, one row per region: FILE.csv or FILE.parquet
    #[arg(long, value_name = "FILE", help_heading = "Recording")]
    out: Option<PathBuf>,
}

const AFTER_HELP: &str = "\
Examples:
  perirobot sweep scenes/quick.toml --out out/quick
  perirobot export out/quick --pose camera:right-wall/8/1 --out out/map
  perirobot score out/map/labels.bt scenes/quick.toml
      scores as the sweep did
  perirobot score out/map/labels.bt scenes/quick.toml --at 0.1,0,0,2
      as if it had been recorded 10 cm and 2 degrees off
  perirobot score out/map/points-camera.pcd scenes/quick.toml
      a cloud, carved from where its sensor was
  perirobot score out/map/points-camera.ply scenes/quick.toml \\
    --sensor 2,-1.9,1.5
      the same; a .ply has no viewpoint

Reasons for missed voxels; a voxel has the first that applies:
  beside        the map has an occupied voxel next to it
  said free     the map labels it free
  hidden        an object is in front of it, from every position of a sensor
  not measured  it was in sight, or the sensor's position is unknown";

pub(super) fn run(args: &Args) -> Result<ExitCode> {
    super::stop::end_tidily()?;
    super::backend::start_threads(None)?;
    let format = args.out.as_deref().map(TableFormat::from_path).transpose()?;
    let sources = Sources::from_main(&args.map).allow_outside();
    let asked =
        RecordingSelection { sensor_m: args.sensor, topic: args.topic.as_deref(), message: args.message };
    let recording = Recording::read(&args.map, asked, &sources)?;
    sources.take_remarks().iter().for_each(|remark| say!("warning: {remark}"));
    let study = args.study.read()?;
    let names =
        ChoiceSelector { scene: args.scene.clone(), snapshot: args.snapshot, ..ChoiceSelector::default() };
    let worlds = World::prepare(&study, find_scene(&study, &names)?)?;
    let world = &worlds[args.snapshot];
    super::warn([(world.name.as_str(), worlds[0].warnings.as_slice())].into_iter(), super::MOST_WARNINGS);
    let about = recording.describe();
    let anchor = args.at.unwrap_or(Anchor::new(DVec3::ZERO, 0.0));
    let map = RecordedMap::new(&study, world, recording, anchor)?;
    let (study, view) = (&map.study, map.view()?);
    super::print(&format!("{}: {about}\nscene {}\n", args.map.display(), world.title(study)))?;
    super::print(&scored_map::render(&map, &view))?;
    if let (Some(out), Some(format)) = (&args.out, format) {
        let mut rows = RowsFile::create(out, format)?;
        let poses = perirobot_sweep::results::columns::pose_names(study, &study.combinations[0], 0);
        for ((region, _), counts) in study.regions.iter().zip(scored_map::counts(&view)) {
            let names = [study.combinations[0].name.as_str(), &poses, "map", region];
            rows.row(&world.name, [args.snapshot, 0], names, &counts)?;
        }
        rows.finish()?;
        super::print(&format!("\nresults in {}\n", out.display()))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// Parses `X,Y,Z,YAW` or `X,Y,Z,QW,QX,QY,QZ`.
fn anchor(text: &str) -> std::result::Result<Anchor, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    numbers.and_then(|numbers| Anchor::from_numbers(&numbers)).ok_or_else(|| {
        format!(
            "must be x,y,z in metres and a yaw in degrees, as in 0.1,0,0,90, or x,y,z and a quaternion of length 1 \
             (qw,qx,qy,qz), each from \
             -{FARTHEST_M} to {FARTHEST_M}"
        )
    })
}

/// Parses `X,Y,Z`.
fn place(text: &str) -> std::result::Result<DVec3, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|word| word.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.abs() <= FARTHEST_M) => Ok(DVec3::new(x, y, z)),
        _ => Err(format!(
            "must be three numbers in metres, as in 2.8,1.8,2.7, each from -{FARTHEST_M} to {FARTHEST_M}"
        )),
    }
}
