//! Candidate poses: lattices, lists, tables and random draws become named poses in study order.

use std::path::Path;

use glam::DVec3;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Deserialize;

use super::file::{PanTilt, PoseFile, PosesFile, RandomFile};
use super::value::Axis;
use super::{Place, slug};
use crate::sensor::pose::{Frame, from_rpy};
use crate::sensor::{Candidate, Kind, Mount, Pose};
use crate::{Error, Result};

/// Most poses in one study file's group; a larger number is a slip of a step.
const MAX_POSES: usize = 10_000_000;

/// Adds the poses of one `[[sensor.poses]]` entry.
pub(super) fn expand(
    at: &Place,
    entry: &PosesFile,
    kind: &Kind,
    seed: u64,
    stream: u64,
    candidates: &mut Vec<Candidate>,
) -> Result<()> {
    let at = &at.key(&format!("poses {:?}", entry.name));
    let group = slug(&entry.name);
    if group.is_empty() {
        return Err(at.says("the name needs a letter or a digit"));
    }
    let lattice = entry.x_m.as_ref().or(entry.y_m.as_ref()).or(entry.z_m.as_ref()).is_some();
    let given = [lattice, entry.list.is_some(), entry.csv.is_some(), entry.random.is_some()];
    if given.iter().filter(|&&g| g).count() != 1 {
        return Err(at.says("give one of: x_m, y_m and z_m (a lattice); list; csv; random"));
    }
    let takes = |key: &str, given: bool, belongs: bool| match given && !belongs {
        true => Err(at.says(format!("{key} does not belong here"))),
        false => Ok(()),
    };
    takes("facing", entry.facing.is_some(), lattice || entry.random.is_some())?;
    takes("orientations_deg", entry.orientations_deg.is_some(), lattice)?;
    takes("frame", entry.frame.is_some(), entry.csv.is_some())?;
    let named: Vec<(String, Pose)> = if let Some(list) = &entry.list {
        at.some("list", list, "list = [{ position_m = [0, 0, 2], facing = [1, 0, 0] }]")?;
        let poses = list.iter().enumerate().map(|(i, pose)| {
            let name = pose.name.clone().unwrap_or_else(|| i.to_string());
            Ok((name.clone(), listed(&at.key(&format!("list {name:?}")), pose, kind)?))
        });
        poses.collect::<Result<_>>()?
    } else if let Some(csv) = &entry.csv {
        let folder = at.file.parent().unwrap_or(Path::new(""));
        table(&folder.join(csv), entry.frame.unwrap_or_default())?
    } else if let Some(random) = &entry.random {
        drawn(at, random, entry.facing, kind, seed, stream)?
    } else {
        lattice_poses(at, entry, kind)?
    };
    candidates.extend(named.into_iter().map(|(name, pose)| Candidate {
        name: format!("{group}/{name}"),
        group: group.clone(),
        pose,
    }));
    Ok(())
}

/// The numbers of one axis of a lattice; ⌊(stop − start)/step + 1e-9⌋ + 1 of them, stop included.
fn axis(at: &Place, key: &str, axis: &Option<Axis>) -> Result<Vec<f64>> {
    let values = match axis {
        None => return Err(at.says(format!("{key} is missing: a lattice has x_m, y_m and z_m"))),
        Some(Axis::List(list)) => list.clone(),
        Some(Axis::Steps { start, stop, step }) => {
            let (start, stop, step) = (*start, *stop, *step);
            let steps = ((stop - start) / step + 1e-9).floor();
            if !(step > 0.0 && steps >= 0.0 && steps < MAX_POSES as f64) {
                let value = format!("{{ start = {start}, stop = {stop}, step = {step} }}");
                return Err(at.wrong(key, value, "step must be above 0 and stop not below start"));
            }
            (0..=steps as usize).map(|i| start + i as f64 * step).collect()
        }
    };
    if values.is_empty() || values.iter().any(|v| !v.is_finite()) {
        return Err(at.wrong(key, format!("{values:?}"), "must be at least one finite number"));
    }
    Ok(values)
}

fn lattice_poses(at: &Place, entry: &PosesFile, kind: &Kind) -> Result<Vec<(String, Pose)>> {
    let [xs, ys, zs] =
        [axis(at, "x_m", &entry.x_m)?, axis(at, "y_m", &entry.y_m)?, axis(at, "z_m", &entry.z_m)?];
    let facing = facing(at, entry.facing)?;
    let straight = [PanTilt::default()];
    let orientations = entry.orientations_deg.as_deref().unwrap_or(&straight);
    at.some("orientations_deg", orientations, "orientations_deg = [{ pan = 0, tilt = 0 }]")?;
    let count = [xs.len(), ys.len(), zs.len(), orientations.len()]
        .iter()
        .try_fold(1, |n: usize, &m| n.checked_mul(m));
    if count.is_none_or(|n| n > MAX_POSES) {
        return Err(at.says(format!("more than {MAX_POSES} poses: widen a step")));
    }
    let mut poses = Vec::new();
    let mut position = 0;
    for &x in &xs {
        for &y in &ys {
            for &z in &zs {
                for (o, turn) in orientations.iter().enumerate() {
                    let pose = turned(at, kind, DVec3::new(x, y, z), facing, turn.pan, turn.tilt)?;
                    poses.push((format!("{position}/{o}"), pose));
                }
                position += 1;
            }
        }
    }
    Ok(poses)
}

fn facing(at: &Place, facing: Option<[f64; 3]>) -> Result<DVec3> {
    let value = facing
        .ok_or_else(|| at.says("facing is missing: the way the sensor looks, as in facing = [0, 1, 0]"))?;
    let facing = at.vector("facing", value)?;
    if facing.length() < 1e-9 {
        return Err(at.wrong("facing", format!("{value:?}"), "must not be zero"));
    }
    Ok(facing)
}

/// A facing pose, panned and tilted, for this kind of sensor.
fn turned(
    at: &Place,
    kind: &Kind,
    position: DVec3,
    facing: DVec3,
    pan_deg: f64,
    tilt_deg: f64,
) -> Result<Pose> {
    at.number("pan", pan_deg, -360.0..=360.0, "an angle in degrees")?;
    at.number("tilt", tilt_deg, -180.0..=180.0, "an angle in degrees")?;
    let (pan, tilt) = (pan_deg.to_radians(), tilt_deg.to_radians());
    match kind {
        Kind::Lidar(lidar) if lidar.mount == Mount::Upright => {
            let rule = "an upright lidar spins about world z and does not tilt: \
                        use mount = \"facing\", or give its rotation as rpy_deg or quaternion";
            if tilt != 0.0 {
                Err(at.wrong("tilt", tilt_deg, rule))
            } else {
                Ok(Pose::upright(position, facing, pan))
            }
        }
        _ => Ok(Pose::facing(position, facing, pan, tilt)),
    }
}

fn listed(at: &Place, entry: &PoseFile, kind: &Kind) -> Result<Pose> {
    let position = at.vector("position_m", entry.position_m)?;
    let frame = entry.frame.unwrap_or_default();
    let turns = entry.pan_deg.is_some() || entry.tilt_deg.is_some();
    match (entry.facing, entry.rpy_deg, entry.quaternion) {
        (Some(_), None, None) if entry.frame.is_none() => {
            let (pan, tilt) = (entry.pan_deg.unwrap_or(0.0), entry.tilt_deg.unwrap_or(0.0));
            turned(at, kind, position, facing(at, entry.facing)?, pan, tilt)
        }
        (None, Some(rpy), None) if !turns => {
            let rpy = at.vector("rpy_deg", rpy)?.to_array().map(f64::to_radians);
            Ok(Pose::turned(position, from_rpy(rpy), frame))
        }
        (None, None, Some(q)) if !turns => {
            let wxyz = [q.w, q.x, q.y, q.z];
            Pose::from_quaternion(position, wxyz, frame).ok_or_else(|| {
                at.wrong("quaternion", format!("{wxyz:?}"), "must not be zero, and all four finite")
            })
        }
        _ => Err(at.says("give one of: facing (with pan_deg and tilt_deg); rpy_deg; quaternion = { w, x, y, z } (with frame)")),
    }
}

#[derive(Deserialize)]
struct Row {
    pose: Option<String>,
    x_m: f64,
    y_m: f64,
    z_m: f64,
    qw: f64,
    qx: f64,
    qy: f64,
    qz: f64,
}

/// Poses from a table with a header: x_m, y_m, z_m, qw, qx, qy, qz and, if wanted, pose (a name). Other columns are
/// left alone, so the `poses.csv` of a sweep can be read back.
fn table(path: &Path, frame: Frame) -> Result<Vec<(String, Pose)>> {
    let text = super::read_text(path)?;
    let mut reader =
        csv::ReaderBuilder::new().comment(Some(b'#')).trim(csv::Trim::All).from_reader(text.as_bytes());
    let mut poses = Vec::new();
    for (i, row) in reader.deserialize().enumerate() {
        let row: Row = row.map_err(|e| {
            Error::input(
                path.display(),
                format!("{e}; the columns are x_m,y_m,z_m,qw,qx,qy,qz and, optional, pose"),
            )
        })?;
        let wrong = |what: &str| Error::input(path.display(), format!("pose {i} (from 0): {what}"));
        let position = DVec3::new(row.x_m, row.y_m, row.z_m);
        if !position.is_finite() || position.abs().max_element() > 1e9 {
            return Err(wrong(&format!("position {position} is not in the world")));
        }
        let pose = Pose::from_quaternion(position, [row.qw, row.qx, row.qy, row.qz], frame)
            .ok_or_else(|| wrong("its quaternion is zero or not finite"))?;
        poses.push((row.pose.filter(|name| !name.is_empty()).unwrap_or_else(|| i.to_string()), pose));
    }
    if poses.is_empty() {
        return Err(Error::input(path.display(), "holds no pose"));
    }
    Ok(poses)
}

/// Random poses. ChaCha8 is a named generator and each draw is one of its integers, so a seed means the same poses
/// with every version of every library.
fn drawn(
    at: &Place,
    random: &RandomFile,
    facing_file: Option<[f64; 3]>,
    kind: &Kind,
    seed: u64,
    stream: u64,
) -> Result<Vec<(String, Pose)>> {
    let facing = facing(at, facing_file)?;
    let at = &at.key("random");
    if random.count == 0 || random.count as usize > MAX_POSES {
        return Err(at.wrong("count", random.count, &format!("must be from 1 to {MAX_POSES}")));
    }
    let (min, max) = (at.vector("min_m", random.min_m)?, at.vector("max_m", random.max_m)?);
    if !min.cmple(max).all() {
        return Err(at.wrong("max_m", format!("{:?}", random.max_m), "must not be below min_m"));
    }
    for (key, [from, to]) in [("pan_deg", random.pan_deg), ("tilt_deg", random.tilt_deg)] {
        if !(from <= to && from.abs() <= 360.0 && to.abs() <= 360.0) {
            return Err(at.wrong(
                key,
                format!("[{from}, {to}]"),
                "must be [from, to] in degrees, from not above to",
            ));
        }
    }
    let mut bytes = [0; 32];
    bytes[..8].copy_from_slice(&seed.to_le_bytes());
    let mut generator = ChaCha8Rng::from_seed(bytes);
    generator.set_stream(stream);
    let mut between =
        |from: f64, to: f64| from + (to - from) * (generator.next_u32() as f64 / 4_294_967_296.0);
    let poses = (0..random.count).map(|i| {
        let position = DVec3::new(between(min.x, max.x), between(min.y, max.y), between(min.z, max.z));
        let pan = between(random.pan_deg[0], random.pan_deg[1]);
        let tilt = between(random.tilt_deg[0], random.tilt_deg[1]);
        Ok((i.to_string(), turned(at, kind, position, facing, pan, tilt)?))
    });
    poses.collect()
}
