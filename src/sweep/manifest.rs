//! `manifest.json`: what was run, on what, from which inputs. The hashes cover the integers that decide the counts,
//! so that two machines can prove that they worked on the same.

use serde_json::{Value, json};
use sha2::{Digest, Sha256};

use super::World;
use crate::backend::{Backend, Placement, Rays};
use crate::sensor::{self, Setting};
use crate::study::Study;
use crate::voxel::{BitGrid, Truth};

/// Wall-clock seconds of a sweep's stages.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Timings {
    /// Reading and voxelizing all scenes.
    pub prepare_s: f64,
    /// Casting and counting all poses.
    pub sweep_s: f64,
}

/// The manifest of a finished sweep.
pub fn manifest(study: &Study, worlds: &[World], backend: &dyn Backend, timings: Timings) -> Vec<u8> {
    let jobs = super::jobs(study);
    let manifest = json!({
        "perirobot": env!("CARGO_PKG_VERSION"),
        "semantics_version": crate::SEMANTICS_VERSION,
        "study": {
            "file": study.path.display().to_string(),
            "sha256": sha256([study.text.as_bytes()]),
            "text": study.text,
        },
        "seed": study.seed,
        "voxel_size_m": study.voxel_size_m,
        "backend": { "name": backend.name(), "device": backend.device() },
        "scenes": worlds.iter().map(|world| scene(study, world)).collect::<Vec<_>>(),
        "sensors": study.sensors.iter().zip(super::tables(study)).map(|(sensor, rays)| {
            json!({
                "name": sensor.name,
                "kind": sensor.kind.name(),
                "representations": sensor.kind.representations(),
                "poses": sensor.candidates.len(),
                "rays_per_pose": rays.as_ref().map_or(0, |rays| rays.dirs_q15.len()),
                "rays_sha256": rays.as_ref().map(rays_sha256),
            })
        }).collect::<Vec<_>>(),
        "combinations": study.combinations.iter().map(|combination| {
            let sensors = combination.members.iter().map(|member| study.sensors[member.sensor].name.as_str());
            json!({
                "name": combination.name,
                "sensors": sensors.collect::<Vec<_>>(),
                "fusion": combination.fusion,
                "choices": combination.choices(),
            })
        }).collect::<Vec<_>>(),
        "repeats": study.repeats,
        "noiseless": study.noiseless,
        "timings": timings,
        "poses_per_s": jobs as f64 / timings.sweep_s.max(1e-9),
    });
    let mut bytes = serde_json::to_vec_pretty(&manifest).expect("a JSON value is serialisable");
    bytes.push(b'\n');
    bytes
}

fn scene(study: &Study, world: &World) -> Value {
    let spec = &study.scenes[world.scene];
    let (truth, whole) = (&world.truth, world.truth.grid.window());
    let regions = world.regions.iter().zip(&world.baselines).map(|(region, baselines)| {
        json!({
            "name": region.name,
            "voxels": region.cells.count(),
            "cut_share": region.cut_share,
            "sha256": plane_sha256(&region.cells),
            "baselines": baselines,
        })
    });
    let placements = study.sensors.iter().enumerate().map(|(s, sensor)| {
        let poses = world.settings[s].iter().filter_map(|setting| match setting {
            Setting::Pose(pose) => Some(pose),
            _ => None,
        });
        let all = poses.map(|pose| sensor::placement(&*sensor.kind, pose, &truth.grid, 0));
        json!({ "sensor": sensor.name, "placements_sha256": placements_sha256(all) })
    });
    json!({
        "name": world.name,
        "snapshot": world.snapshot,
        "file": spec.path.display().to_string(),
        "sha256": sha256([spec.text.as_bytes()]),
        "grid": { "origin": truth.grid.origin, "size": truth.grid.size },
        "occupied_voxels": truth.occupied.count(),
        "occupied_sha256": plane_sha256(&truth.occupied),
        "blockers_sha256": plane_sha256(&truth.blockers),
        "human_sha256": plane_sha256(&truth.human.over(whole)),
        "robot_sha256": plane_sha256(&truth.robot.over(whole)),
        "robot_volume_sha256": plane_sha256(&truth.robot_volume.over(whole)),
        "keypoints_sha256": keypoints_sha256(truth),
        "regions": regions.collect::<Vec<_>>(),
        "placements": placements.collect::<Vec<_>>(),
        "warnings": world.warnings,
    })
}

/// Hash of a plane: its window (min and size, little-endian i32) and its words.
fn plane_sha256(plane: &BitGrid) -> String {
    let window = plane.window();
    let corner: Vec<u8> = window.min.iter().flat_map(|m| m.to_le_bytes()).collect();
    let size: Vec<u8> = window.size.iter().flat_map(|n| n.to_le_bytes()).collect();
    let words: Vec<u8> = plane.words().iter().flat_map(|w| w.to_le_bytes()).collect();
    sha256([corner.as_slice(), &size, &words])
}

/// Hash of where all joints of all people are, in the grid; an unknown one counts as no number at all.
fn keypoints_sha256(truth: &Truth) -> String {
    let people = truth.objects.iter().filter_map(|object| object.keypoints.as_ref());
    let joints = people.flat_map(|keypoints| keypoints.iter().enumerate());
    let numbers =
        joints.filter_map(|(number, joint)| Some((number as i64, truth.grid.position_q16((*joint)?))));
    let bytes: Vec<u8> =
        numbers.flat_map(|(number, [x, y, z])| [number, x, y, z]).flat_map(i64::to_le_bytes).collect();
    sha256([bytes.as_slice()])
}

fn rays_sha256(rays: &Rays) -> String {
    let gates = &rays.gates;
    let numbers = [gates.range_min_q16, gates.range_max_q16, gates.near_ignore_q16]
        .into_iter()
        .chain([gates.no_return_is_free as u32, gates.backdrop as u32]);
    let gates: Vec<u8> = numbers.flat_map(u32::to_le_bytes).collect();
    let noise: Vec<u8> = rays.noise_q16.iter().flat_map(|g| g.to_le_bytes()).collect();
    let dirs: Vec<u8> = rays.dirs_q15.iter().flatten().flat_map(|d| d.to_le_bytes()).collect();
    sha256([gates.as_slice(), &dirs, &noise])
}

fn placements_sha256(placements: impl Iterator<Item = Placement>) -> String {
    let numbers = placements.flat_map(|p| p.origin_q16.into_iter().chain(p.axis_q15.into_iter().flatten()));
    let bytes: Vec<u8> = numbers.flat_map(i32::to_le_bytes).collect();
    sha256([bytes.as_slice()])
}

fn sha256<const N: usize>(parts: [&[u8]; N]) -> String {
    let mut hash = Sha256::new();
    parts.iter().for_each(|part| hash.update(part));
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}
