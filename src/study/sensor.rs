//! Sensors of a study, checked: what rays they cast and how far they see.

use super::file::{NoReturn, SensorFile, SensorKind};
use super::{Place, poses};
use crate::sensor::{Camera, Kind, Lidar, Mount, Sensor, lidar};
use crate::{Error, Result};

/// Most rays a sensor may cast at one pose: their ends must fit one buffer of 128 MiB.
const MAX_RAYS: usize = 1 << 25;

/// Which keys each kind of sensor reads.
const CAMERA_KEYS: &str = "fov_deg = [horizontal, vertical] and resolution_px = [width, height]";
const LIDAR_KEYS: &str = "fov_deg and resolution_deg, with elevation_deg = [from, to] or rings_deg = [...]";

pub(super) fn check(at: &Place, entry: SensorFile, seed: u64, index: usize) -> Result<Sensor> {
    let at = at.key(&format!("sensor {:?}", entry.name));
    let kind = match entry.kind {
        SensorKind::Rgbd => Kind::Camera(camera(&at, &entry)?),
        SensorKind::Lidar => Kind::Lidar(lidar(&at, &entry)?),
    };
    let [near, far] = entry.range_m;
    if !(near >= 0.0 && near < far && far < 1e6) {
        let rule = "must be [nearest, farthest] in metres, 0 <= nearest < farthest < 1000000";
        return Err(at.wrong("range_m", format!("{:?}", entry.range_m), rule));
    }
    at.number("near_ignore_m", entry.near_ignore_m, 0.0..far, "a distance from 0 to the sensor's range")?;
    at.some("poses", &entry.poses, "[[sensor.poses]] name = \"wall\"")?;
    let mut candidates = Vec::new();
    for (i, group) in entry.poses.iter().enumerate() {
        let stream = (index as u64) << 32 | i as u64;
        let source = poses::Source { sensor: &entry.name, kind: &kind, seed, stream };
        poses::expand(&at, group, &source, &mut candidates)?;
    }
    at.unique("pose", candidates.iter().map(|c| c.name.as_str()))?;
    Ok(Sensor {
        name: entry.name,
        kind,
        range_m: entry.range_m,
        near_ignore_m: entry.near_ignore_m,
        no_return_is_free: entry.no_return == NoReturn::Free,
        candidates,
    })
}

fn refuse<T>(at: &Place, key: &str, value: &Option<T>, keys: &str) -> Result<()> {
    match value {
        Some(_) => Err(at.says(format!("{key} does not belong to this kind of sensor: it takes {keys}"))),
        None => Ok(()),
    }
}

fn camera(at: &Place, entry: &SensorFile) -> Result<Camera> {
    refuse(at, "resolution_deg", &entry.resolution_deg, CAMERA_KEYS)?;
    refuse(at, "elevation_deg", &entry.elevation_deg, CAMERA_KEYS)?;
    refuse(at, "rings_deg", &entry.rings_deg, CAMERA_KEYS)?;
    refuse(at, "mount", &entry.mount, CAMERA_KEYS)?;
    let missing = || at.says(format!("an rgbd sensor takes {CAMERA_KEYS}"));
    let fov = entry.fov_deg.ok_or_else(missing)?;
    let resolution_px = entry.resolution_px.ok_or_else(missing)?;
    let fov_deg = [fov.horizontal, fov.vertical.ok_or_else(missing)?];
    for angle in fov_deg {
        at.number("fov_deg", angle, f64::MIN_POSITIVE..180.0, "angles above 0 and below 180")?;
    }
    let pixels = resolution_px.iter().map(|&n| n as usize).product::<usize>();
    if pixels == 0 || pixels > MAX_RAYS {
        let rule = format!("must be at least 1 each and {MAX_RAYS} pixels together");
        return Err(at.wrong("resolution_px", format!("{resolution_px:?}"), &rule));
    }
    Ok(Camera { fov_rad: fov_deg.map(f64::to_radians), resolution_px })
}

fn lidar(at: &Place, entry: &SensorFile) -> Result<Lidar> {
    refuse(at, "resolution_px", &entry.resolution_px, LIDAR_KEYS)?;
    let missing = |key: &str| at.says(format!("{key} is missing: a lidar takes {LIDAR_KEYS}"));
    let step = entry.resolution_deg.ok_or_else(|| missing("resolution_deg"))?;
    let vertical_step = step.vertical.unwrap_or(step.horizontal);
    for angle in [step.horizontal, vertical_step] {
        at.number("resolution_deg", angle, 1e-3..=360.0, "angles from 0.001 to 360")?;
    }
    let span = entry.fov_deg.map_or(360.0, |fov| fov.horizontal);
    at.number("fov_deg", span, f64::MIN_POSITIVE..=360.0, "above 0 and at most 360 around the spin axis")?;
    let elevations = elevations(at, entry, vertical_step)?;
    let azimuths = lidar::angles(-span / 2.0, span, step.horizontal);
    let rays = azimuths.len().saturating_mul(elevations.len());
    if rays == 0 || rays > MAX_RAYS {
        return Err(at.wrong(
            "resolution_deg",
            step.horizontal,
            &format!("gives {rays} rays, from 1 to {MAX_RAYS} are possible"),
        ));
    }
    Ok(Lidar {
        azimuths_rad: azimuths.into_iter().map(f64::to_radians).collect(),
        elevations_rad: elevations.into_iter().map(f64::to_radians).collect(),
        mount: entry.mount.unwrap_or(Mount::Upright),
    })
}

/// Elevations above the ring plane in degrees, from whichever of three keys is given.
fn elevations(at: &Place, entry: &SensorFile, step: f64) -> Result<Vec<f64>> {
    let vertical = entry.fov_deg.and_then(|fov| fov.vertical);
    let within = |key: &str, angle: f64| at.number(key, angle, -90.0..=90.0, "between -90 and 90");
    match (&entry.rings_deg, entry.elevation_deg, vertical) {
        (Some(rings), None, None) => {
            at.some("rings_deg", rings, "rings_deg = [-15, -13, ...]")?;
            rings.iter().map(|&angle| within("rings_deg", angle)).collect()
        }
        (None, Some([from, to]), None) => {
            within("elevation_deg", from)?;
            within("elevation_deg", to)?;
            if from >= to {
                return Err(at.wrong("elevation_deg", format!("[{from}, {to}]"), "must rise"));
            }
            Ok(lidar::angles(from, to - from, step))
        }
        (None, None, Some(vertical)) => {
            at.number("fov_deg", vertical, f64::MIN_POSITIVE..=180.0, "above 0 and at most 180 vertically")?;
            Ok(lidar::angles(-vertical / 2.0, vertical, step))
        }
        (None, None, None) => Err(elevation_error(at, "no elevations")),
        _ => Err(elevation_error(at, "elevations given twice")),
    }
}

fn elevation_error(at: &Place, what: &str) -> Error {
    at.says(format!(
        "{what}: give one of fov_deg = [horizontal, vertical], elevation_deg = [from, to], rings_deg"
    ))
}
