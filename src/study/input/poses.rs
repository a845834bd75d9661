//! Candidate poses: lattices, surfaces of objects, lists, tables and random draws become named poses in study order.

mod file;
mod surface;

use std::ops::Range;
use std::path::Path;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::slug;
use crate::diagnostics::{FARTHEST_M, Place};
use crate::keys::{AxisValues, MAX_NUMBERS, numbers};
use crate::sensor::spread::WAYS;
use crate::sensor::{Candidate, GroupSurface, MountLink, PoseSpread, Setting, Stance};
use perirobot_march::error::Issue;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::spec::SceneSpec;
use perirobot_scene::pose::{Pose, RotationFrame, from_rpy};
use perirobot_scene::source::{Sources, decimal_commas, refuse_other_separators, refuse_width, table_issue};

pub(super) use file::PosesFile;
use file::{PanTilt, PoseFile, RandomFile};
pub(super) use surface::Surfaces;

/// Most poses of a study, all its sensors together: about 1 GB. A larger number comes from a mistyped step.
pub(super) const MAX_POSES: usize = MAX_NUMBERS;

/// Numbers of a lattice that differ by less are the same.
const SAME: f64 = 1e-9;

/// The sensor whose poses are read, and the seed of random ones.
pub(super) struct PoseSource<'a> {
    pub(super) sensor: &'a str,
    pub(super) stance: Stance,
    pub(super) seed: u64,
    /// Different for each group of the study, so that none repeats another's draws.
    pub(super) stream: u64,
    /// Poses that the study may still have.
    pub(super) most: usize,
    /// The sources through which tables and surfaces are read.
    pub(super) files: &'a Sources,
    /// The link that carries the sensor, if one does.
    pub(super) on: Option<&'a MountLink>,
    /// The scenes that could be read, and whether those are all.
    pub(super) scenes: &'a [SceneSpec],
    pub(super) has_all_scenes: bool,
    /// Surfaces of their objects that were read before.
    pub(super) surfaces: &'a Surfaces,
}

/// Poses by their names, how each is turned from where they face (the first follows the last, again and again),
/// and stretches of them with how far they are from each other in each way, if others are possible between them.
struct Expanded {
    poses: Vec<(String, Pose)>,
    turns_deg: Vec<[f64; 2]>,
    stretches: Vec<(Range<usize>, [f64; WAYS])>,
}

impl Expanded {
    /// Poses that are listed one by one.
    fn from_list(poses: Vec<(String, Pose)>) -> Expanded {
        Expanded { poses, turns_deg: vec![[0.0; 2]], stretches: Vec::new() }
    }

    /// Poses in one stretch.
    fn from_stretch(poses: Vec<(String, Pose)>, turns_deg: Vec<[f64; 2]>, steps: [f64; WAYS]) -> Expanded {
        Expanded { stretches: vec![(0..poses.len(), steps)], poses, turns_deg }
    }
}

/// What is known of the poses of a group besides themselves.
#[derive(Default)]
pub(super) struct GroupExtras {
    /// Between which of them others are possible.
    pub(super) spreads: Vec<PoseSpread>,
    /// The object that they are on, if the study says so.
    pub(super) surface: Option<GroupSurface>,
}

/// Adds the poses of one `[[sensor.poses]]` entry.
pub(super) fn expand(
    at: &Place,
    entry: &PosesFile,
    source: &PoseSource,
    candidates: &mut Vec<Candidate>,
) -> Result<GroupExtras> {
    let at = &at.key(&format!("poses {:?}", entry.name));
    let group = slug(&entry.name);
    if group.is_empty() {
        return Err(at.says("the name needs a letter or a digit"));
    }
    let lattice = entry.x_m.as_ref().or(entry.y_m.as_ref()).or(entry.z_m.as_ref()).is_some();
    let on_surface = entry.surface.is_some();
    let given = [lattice, on_surface, entry.list.is_some(), entry.csv.is_some(), entry.random.is_some()];
    if given.iter().filter(|&&g| g).count() != 1 {
        return Err(at.says("give one of: x_m, y_m and z_m (a lattice); surface; list; csv; random"));
    }
    let takes = |key: &str, given: bool, belongs: bool| match given && !belongs {
        true => Err(at.says(format!("{key} does not belong here"))),
        false => Ok(()),
    };
    takes("facing", entry.facing.is_some(), lattice || on_surface || entry.random.is_some())?;
    takes("orientations_deg", entry.orientations_deg.is_some(), lattice || on_surface)?;
    takes("frame", entry.frame.is_some(), entry.csv.is_some())?;
    let most = source.most.saturating_sub(candidates.len());
    let mut object = None;
    let Expanded { poses: named, turns_deg, stretches } = if let Some(list) = &entry.list {
        at.some("list", list, "list = [{ position_m = [0, 0, 2], facing = [1, 0, 0] }]")?;
        let poses = list.iter().enumerate().map(|(i, pose)| {
            let name = pose.name.clone().unwrap_or_else(|| i.to_string());
            let at = at.key(&format!("list[{i}]"));
            if name.is_empty() {
                return Err(at.wrong("name", "\"\"", "must not be empty; leave it out to number the pose"));
            }
            Ok((name, read_listed(&at, pose, source.stance)?))
        });
        Expanded::from_list(poses.collect::<Result<_>>()?)
    } else if let Some(csv) = &entry.csv {
        let poses = table(&at.folder().join(csv), entry.frame.unwrap_or_default(), source);
        Expanded::from_list(poses.map_err(|e| at.wrap(e.with_place("csv")))?)
    } else if let Some(random) = &entry.random {
        draw_poses(at, random, entry.facing, source, most)?
    } else if let Some(file) = &entry.surface {
        let (expanded, name) = surface::surface_poses(at, entry, file, source, most)?;
        object = name;
        expanded
    } else {
        lattice_poses(at, entry, source.stance, most)?
    };
    if named.len() > most {
        return Err(at.wrap(too_many()));
    }
    let poses: Vec<&Pose> = named.iter().map(|(_, pose)| pose).collect();
    let possible = stretches.iter().filter(|(_, steps)| steps.iter().any(|&step| step > 0.0));
    let spreads = possible.map(|(own, steps)| {
        let first = candidates.len() + own.start;
        PoseSpread::new(first, &poses[own.clone()], turns_deg.clone(), *steps)
    });
    let spreads = spreads.collect();
    candidates.extend(named.into_iter().map(|(name, pose)| Candidate {
        name: format!("{group}/{name}"),
        group: group.clone(),
        setting: Setting::Pose(pose),
    }));
    Ok(GroupExtras { spreads, surface: object.map(|object| GroupSurface { group, object }) })
}

/// The numbers of one axis of a lattice.
fn axis(at: &Place, key: &str, axis: &Option<AxisValues>) -> Result<Vec<f64>> {
    match axis {
        None => Err(at.says(format!("{key} is missing")).with_advice("a lattice has x_m, y_m and z_m")),
        Some(axis) => numbers(at, key, axis),
    }
}

/// The error for more poses than a study may have.
pub(super) fn too_many() -> Issue {
    Issue::too_large(format!("with these, the study has more than {MAX_POSES} poses"))
        .with_advice("widen a step, or leave some out")
}

fn lattice_poses(at: &Place, entry: &PosesFile, stance: Stance, most: usize) -> Result<Expanded> {
    let [xs, ys, zs] =
        [axis(at, "x_m", &entry.x_m)?, axis(at, "y_m", &entry.y_m)?, axis(at, "z_m", &entry.z_m)?];
    let facing = facing(at, entry.facing, stance)?;
    let straight = [PanTilt::default()];
    let orientations = entry.orientations_deg.as_deref().unwrap_or(&straight);
    at.some("orientations_deg", orientations, "orientations_deg = [{ pan = 0, tilt = 0 }]")?;
    let count = [xs.len(), ys.len(), zs.len(), orientations.len()]
        .iter()
        .try_fold(1, |n: usize, &m| n.checked_mul(m));
    if count.is_none_or(|n| n > most) {
        return Err(at.wrap(too_many()));
    }
    let mut poses = Vec::new();
    let mut position = 0;
    for &x in &xs {
        for &y in &ys {
            for &z in &zs {
                for (o, turn) in orientations.iter().enumerate() {
                    let pose = turn_pose(
                        &at.key(&format!("orientations_deg[{o}]")),
                        stance,
                        DVec3::new(x, y, z),
                        facing,
                        [("pan", turn.pan), ("tilt", turn.tilt)],
                    )?;
                    poses.push((format!("{position}/{o}"), pose));
                }
                position += 1;
            }
        }
    }
    let turns_deg: Vec<[f64; 2]> = orientations.iter().map(|turn| [turn.pan, turn.tilt]).collect();
    let steps_deg = [0, 1].map(|turn| least_apart(turns_deg.iter().map(|turns| turns[turn]).collect()));
    let steps =
        [even(&xs, &entry.x_m), even(&ys, &entry.y_m), even(&zs, &entry.z_m), steps_deg[0], steps_deg[1]];
    Ok(Expanded::from_stretch(poses, turns_deg, steps))
}

/// The step of numbers that are evenly spaced: a lattice, or a list that could be one. Of two numbers in a list
/// nobody knows whether anything is between them.
fn even(numbers: &[f64], axis: &Option<AxisValues>) -> f64 {
    let is_lattice = matches!(axis, Some(AxisValues::Steps { .. })) || numbers.len() > 2;
    let gaps: Vec<f64> = numbers.windows(2).map(|pair| (pair[1] - pair[0]).abs()).collect();
    match gaps.first() {
        Some(&gap) if is_lattice && gaps.iter().all(|other| (other - gap).abs() < SAME) => gap,
        _ => 0.0,
    }
}

/// The least that different angles are apart; 0 where they are all the same.
fn least_apart(mut angles: Vec<f64>) -> f64 {
    angles.sort_by(f64::total_cmp);
    let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > SAME);
    gaps.reduce(f64::min).unwrap_or(0.0)
}

/// Where a sensor looks. One that stands level may leave it out, and then faces +x.
fn facing(at: &Place, facing: Option<[f64; 3]>, stance: Stance) -> Result<DVec3> {
    let usual = (stance == Stance::Level).then_some([1.0, 0.0, 0.0]);
    let value = facing.or(usual).ok_or_else(|| {
        at.says("facing is missing").with_advice("the way the sensor looks, as in facing = [0, 1, 0]")
    })?;
    let facing = at.vector("facing", value)?;
    if facing.length() < 1e-9 {
        return Err(at.wrong("facing", format!("{value:?}"), "must not be zero"));
    }
    Ok(facing)
}

/// Pan and tilt in degrees, with the keys they were given by.
type Turn<'a> = [(&'a str, f64); 2];

/// A facing pose, panned and tilted, for this kind of sensor.
fn turn_pose(at: &Place, stance: Stance, position: DVec3, facing: DVec3, turn: Turn) -> Result<Pose> {
    let [(pan_key, pan_deg), (tilt_key, tilt_deg)] = turn;
    at.number(pan_key, pan_deg, -360.0..=360.0, "an angle in degrees from -360 to 360")?;
    at.number(tilt_key, tilt_deg, -180.0..=180.0, "an angle in degrees from -180 to 180")?;
    let (pan, tilt) = (pan_deg.to_radians(), tilt_deg.to_radians());
    let rule = match stance {
        Stance::Facing => return Ok(Pose::facing(position, facing, pan, tilt)),
        Stance::Upright => {
            "an upright lidar spins about world z and does not tilt: \
             use mount = \"facing\", or give its rotation as rpy_deg or quaternion"
        }
        Stance::Level => "it stands level and does not tilt: turn it by facing or pan",
    };
    if tilt != 0.0 {
        return Err(at.wrong(tilt_key, tilt_deg, rule));
    }
    if facing.truncate().length() < 1e-9 * facing.length() {
        return Err(at.says("facing is straight up or down, which is no heading").with_advice(match stance {
            Stance::Level => "give one along the floor, and on a link one across the link's z",
            _ => "give one along the floor, and on a link one across the link's z, or use mount = \"facing\"",
        }));
    }
    Ok(Pose::upright(position, facing, pan))
}

fn read_listed(at: &Place, entry: &PoseFile, stance: Stance) -> Result<Pose> {
    let position = at.vector("position_m", entry.position_m)?;
    let frame = entry.frame.unwrap_or_default();
    let turns = entry.pan_deg.is_some() || entry.tilt_deg.is_some();
    match (entry.facing, entry.rpy_deg, entry.quaternion) {
        (_, None, None) if entry.frame.is_none() && (entry.facing.is_some() || stance == Stance::Level) => {
            let (pan, tilt) = (entry.pan_deg.unwrap_or(0.0), entry.tilt_deg.unwrap_or(0.0));
            turn_pose(
                at,
                stance,
                position,
                facing(at, entry.facing, stance)?,
                [("pan_deg", pan), ("tilt_deg", tilt)],
            )
        }
        (None, Some(rpy), None) if !turns => {
            let rpy = at.vector("rpy_deg", rpy)?.to_array().map(f64::to_radians);
            Ok(Pose::from_rotation(position, from_rpy(rpy), frame))
        }
        (None, None, Some(q)) if !turns => {
            let wxyz = [q.w, q.x, q.y, q.z];
            Pose::from_quaternion(position, wxyz, frame)
                .map_err(|rule| at.wrong("quaternion", q, &rule.to_string()))
        }
        _ => Err(at.says(
            "give one of: facing (with pan_deg and tilt_deg); rpy_deg; quaternion = { w, \
                x, y, z } (with frame)",
        )),
    }
}

#[derive(Deserialize)]
struct PoseRow {
    sensor: Option<String>,
    pose: Option<String>,
    x_m: Option<f64>,
    y_m: Option<f64>,
    z_m: Option<f64>,
    qw: Option<f64>,
    qx: Option<f64>,
    qy: Option<f64>,
    qz: Option<f64>,
}

/// Poses from a table with a header: x_m, y_m, z_m, qw, qx, qy, qz and, if wanted, pose (a name) and sensor
/// (only that sensor's rows are taken). Other columns are left alone, so the `poses.csv` of a sweep can be
/// read back.
fn table(path: &Path, frame: RotationFrame, source: &PoseSource) -> Result<Vec<(String, Pose)>> {
    let (sensor, text) = (source.sensor, source.files.table(path)?);
    refuse_other_separators(&text).map_err(|issue| issue.with_place(path))?;
    let mut reader = csv::ReaderBuilder::new()
        .comment(Some(b'#'))
        .flexible(true)
        .trim(csv::Trim::All)
        .from_reader(text.as_bytes());
    let mut poses = Vec::new();
    let columns = "the columns are x_m,y_m,z_m,qw,qx,qy,qz and, optional, sensor and pose";
    let unreadable = |e: csv::Error| Error::from(table_issue(&e).cure(columns).with_place(path));
    let header = reader.headers().map_err(unreadable)?.clone();
    if header.iter().next().is_some_and(|cell| cell.parse::<f64>().is_ok()) {
        return Err(Issue::says("has no header")
            .with_advice("write x_m,y_m,z_m,qw,qx,qy,qz as its first line")
            .with_place(path)
            .into());
    }
    for record in reader.records() {
        let record = record.map_err(unreadable)?;
        let line = record.position().map_or(0, |p| p.line() + passed_over(&text[p.byte() as usize..]));
        let unfit = |issue: Issue| Error::from(issue.with_place(format!("line {line}")).with_place(path));
        let wrong = |what: &str| unfit(Issue::says(what));
        refuse_width(record.iter(), header.len()).map_err(|issue| unfit(issue.cure(columns)))?;
        let row: PoseRow = record.deserialize(Some(&header)).map_err(|e| {
            match decimal_commas(record.iter(), header.len()) {
                Some(cause) => wrong(cause),
                // The parser does not count the lines that it passes over.
                None => unfit(Issue { sites: Vec::new(), ..table_issue(&e) }.cure(columns)),
            }
        })?;
        if row.sensor.is_some_and(|name| !name.is_empty() && name != sensor) {
            continue;
        }
        let numbers = [row.x_m, row.y_m, row.z_m, row.qw, row.qx, row.qy, row.qz];
        let [x_m, y_m, z_m, qw, qx, qy, qz] = match numbers.iter().all(Option::is_some) {
            true => numbers.map(Option::unwrap_or_default),
            false => return Err(wrong(&format!("a number is missing; {columns}"))),
        };
        let position = DVec3::new(x_m, y_m, z_m);
        if !position.to_array().iter().all(|v| v.abs() <= FARTHEST_M) {
            let rule = format!("must be three numbers from -{FARTHEST_M} to {FARTHEST_M}");
            return Err(wrong(&format!("x_m, y_m, z_m = {position}: {rule}")));
        }
        let pose = Pose::from_quaternion(position, [qw, qx, qy, qz], frame);
        let pose = pose.map_err(|rule| wrong(&format!("qw, qx, qy, qz {rule}")))?;
        let name = row.pose.filter(|name| !name.is_empty()).unwrap_or_else(|| poses.len().to_string());
        poses.push((name, pose));
    }
    if poses.is_empty() {
        return Err(Error::input(path, format!("holds no pose for sensor {sensor:?}")));
    }
    Ok(poses)
}

/// Comments and empty lines that the reader counts to the record after them.
fn passed_over(text: &str) -> u64 {
    text.lines().take_while(|line| line.is_empty() || line.starts_with('#')).count() as u64
}

/// Random poses. ChaCha8 is a named generator and each draw is one of its integers, so a seed means the same
/// poses with every version of every library.
fn draw_poses(
    at: &Place,
    random: &RandomFile,
    facing_file: Option<[f64; 3]>,
    source: &PoseSource,
    most: usize,
) -> Result<Expanded> {
    let facing = facing(at, facing_file, source.stance)?;
    let at = &at.key("random");
    if random.count == 0 || random.count as usize > MAX_POSES {
        return Err(at.wrong("count", random.count, &format!("must be from 1 to {MAX_POSES}")));
    }
    if random.count as usize > most {
        return Err(at.wrap(too_many()));
    }
    let (min, max) = (at.vector("min_m", random.min_m)?, at.vector("max_m", random.max_m)?);
    if !min.cmple(max).all() {
        return Err(at.wrong("max_m", format!("{:?}", random.max_m), "must not be below min_m"));
    }
    let (pan_deg, tilt_deg) = (random.pan_deg, random.tilt_deg);
    for (key, [from, to]) in [("pan_deg", pan_deg), ("tilt_deg", tilt_deg)] {
        if from > to {
            return Err(at.wrong(key, format!("[{from}, {to}]"), "must be [from, to], from not above to"));
        }
    }
    // Both ends are checked first, so that an error does not depend on the seed.
    for end in [0, 1] {
        let turn = [("pan_deg", pan_deg[end]), ("tilt_deg", tilt_deg[end])];
        turn_pose(at, source.stance, min, facing, turn)?;
    }
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&source.seed.to_le_bytes());
    let mut generator = ChaCha8Rng::from_seed(bytes);
    generator.set_stream(source.stream);
    let mut between =
        |from: f64, to: f64| from + (to - from) * (generator.next_u32() as f64 / 4_294_967_296.0);
    let mut turns_deg = Vec::new();
    let poses = (0..random.count).map(|i| {
        let position = DVec3::new(between(min.x, max.x), between(min.y, max.y), between(min.z, max.z));
        let pan = between(pan_deg[0], pan_deg[1]);
        let tilt = between(tilt_deg[0], tilt_deg[1]);
        turns_deg.push([pan, tilt]);
        Ok((
            i.to_string(),
            turn_pose(at, source.stance, position, facing, [("pan_deg", pan), ("tilt_deg", tilt)])?,
        ))
    });
    let poses = poses.collect::<Result<Vec<_>>>()?;
    // As far apart as so many poses of a lattice would be that fills the box.
    let box_m = (max - min).to_array();
    let sizes = [box_m[0], box_m[1], box_m[2], pan_deg[1] - pan_deg[0], tilt_deg[1] - tilt_deg[0]];
    let ways = sizes.iter().filter(|size| **size > 0.0).count().max(1);
    let along = libm::pow(f64::from(random.count), 1.0 / ways as f64);
    Ok(Expanded::from_stretch(poses, turns_deg, sizes.map(|size| size / along)))
}

#[cfg(test)]
mod tests;
