//! A radar: its field counts as occupied while something in it moves fast enough.

use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::Deserialize;
use toml::Table;

use super::shared::Silence;
use super::shared::range::RangeKeys;
use super::{Checked, Context, KindFile};
#[cfg(test)]
use super::{EvidenceWords, Page};
use crate::diagnostics::Place;
use crate::keys::exactly;
use crate::sensor::range::Range;
use crate::sensor::watch::ray_watch;
use crate::sensor::{
    Claim, Extent, FieldOfView, Kind, MAX_RAYS, RayScale, SWITCHES, Station, placement, quantise_q15,
    switch_planes,
};
use perirobot_march::Result;
use perirobot_march::backend::Rays;
use perirobot_march::error::Issue;
use perirobot_march::voxel::BitGrid;
use perirobot_scene::objects::Role;
use perirobot_scene::objects::spec::{ObjectSpec, SceneSpec};
use perirobot_scene::objects::speed::{is_known, to_mm_s};
use perirobot_scene::pose::Pose;
use perirobot_scene::source::Sources;
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// How fast a person walks, in metres a second (ISO 13855): who walks must be detected.
const WALKING_M_S: f64 = 1.6;
/// Rays at the farthest distance, for each voxel.
const RAYS_PER_VOXEL: f64 = 1.5;

/// A radar.
#[derive(Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct RadarFile {
    /// Horizontal and vertical angle of its field, up to 180.
    #[serde(deserialize_with = "exactly")]
    fov_deg: [f64; 2],
    /// Where its field begins and ends, in metres.
    #[serde(deserialize_with = "exactly")]
    range_m: [f64; 2],
    /// The slowest that it detects, in metres a second; 0 for one that detects people who stand still, too.
    min_speed_m_s: f64,
    /// What is nearer than this is its own housing, in metres. Default 0.
    near_ignore_m: Option<f64>,
    /// What it reports of its field while nothing moves there. Default "free".
    otherwise: Option<Silence>,
}

impl KindFile for RadarFile {
    const NAME: &'static str = "radar";
    #[cfg(test)]
    const PAGE: Page = Page {
        what: "radar; it detects what moves, through objects with `radar = \"passes\"`",
        keys: "`fov_deg` (horizontal, vertical), `range_m`, `min_speed_m_s`, `near_ignore_m?` (0), `otherwise?` (free)",
        evidence: &[EvidenceWords {
            says: "",
            occupied: "its field, if something in it moves at `min_speed_m_s` or faster",
            free: "else the field, unless `otherwise = \"unknown\"`",
        }],
    };

    fn prepare(at: &Place, keys: &mut Table, _: &Sources) -> Result<Vec<String>> {
        let light = ["reflectance_ranges_m", "reflectance"];
        if let Some(key) = light.into_iter().find(|key| keys.contains_key(*key)) {
            return Err(at.says(format!("{key} does not belong to a radar")).with_advice(
                "reflectance is of light; a radar passes objects of a scene with radar = \"passes\"",
            ));
        }
        if keys.contains_key("calibration") || keys.contains_key("noise") || keys.contains_key("dropout") {
            return Err(at.says("noise, dropout and calibration do not belong to a radar").with_advice(
                "it is modelled without errors; take them away, and choose range_m and fov_deg smaller",
            ));
        }
        Ok(Vec::new())
    }

    fn check(self, at: &Place, context: &Context) -> Result<Checked> {
        for degrees in self.fov_deg {
            at.number(
                "fov_deg",
                degrees,
                1.0..=180.0,
                "[horizontal, vertical] in degrees, each from 1 to 180",
            )?;
        }
        let range = RangeKeys {
            range_m: self.range_m,
            along: None,
            near_ignore_m: self.near_ignore_m,
            // Empty space is nothing wrong.
            no_return: Some(Silence::Free),
            noise: None,
            dropout: None,
            calibration: None,
            reflectance_ranges_m: None,
        };
        let slowest = self.min_speed_m_s;
        if !(slowest == 0.0 || (0.001..=WALKING_M_S).contains(&slowest)) {
            let rule = format!(
                "must be from 0.001 to {WALKING_M_S} m/s, the speed of people who walk (ISO 13855), or 0 if it detects people \
                 who stand still, too"
            );
            return Err(at.wrong("min_speed_m_s", slowest, &rule));
        }
        let radar = Radar {
            fov_rad: self.fov_deg.map(f64::to_radians),
            range: range.check(at, context.noiseless)?,
            min_speed_mm_s: to_mm_s(slowest),
            otherwise_free: self.otherwise != Some(Silence::Unknown),
        };
        let warnings = if slowest > 0.0 { check_speeds(at, slowest, context)? } else { Vec::new() };
        Ok(Checked { kind: Arc::new(radar), warnings })
    }
}

/// Refuses people of whom no speed is known, and warns where all are too slow.
fn check_speeds(at: &Place, slowest_m_s: f64, context: &Context) -> Result<Vec<String>> {
    // Of scenes that could not be read nothing is known.
    if !context.has_all_scenes {
        return Ok(Vec::new());
    }
    for scene in context.scenes {
        if let Some(person) = people(scene).find(|person| !is_known(person, &scene.objects)) {
            let rule = format!(
                "needs the speed of people, and object {:?} of scene {:?} has none: write speed_m_s = {WALKING_M_S} in that \
                 object (0 if it stands still), a list snapshots.speed_m_s, or snapshots.walk",
                person.name, scene.name
            );
            return Err(at.wrong("min_speed_m_s", slowest_m_s, &rule));
        }
    }
    // Speeds by times of animations are known later.
    let written: Option<Vec<f64>> = context.scenes.iter().flat_map(people).map(written_m_s).collect();
    let fastest = written.filter(|all| !all.is_empty()).map(|all| all.into_iter().fold(0.0, f64::max));
    let warning = |fastest: f64| {
        format!(
            "min_speed_m_s = {slowest_m_s} is faster than all people of the scenes (at most {fastest} m/s), so that it \
             detects none of them: correct speed_m_s of the people, or min_speed_m_s"
        )
    };
    Ok(fastest.filter(|fastest| to_mm_s(*fastest) < to_mm_s(slowest_m_s)).map(warning).into_iter().collect())
}

/// Objects with people in them.
fn people(scene: &SceneSpec) -> impl Iterator<Item = &ObjectSpec> {
    let has_people = |object: &&ObjectSpec| {
        let is_human = |role: Option<Role>| role.unwrap_or(object.role) == Role::Human;
        object.role == Role::Human || object.nodes.iter().any(|node| !node.ignore && is_human(node.role))
    };
    scene.objects.iter().filter(has_people)
}

/// The highest speed that the file of an object contains.
fn written_m_s(object: &ObjectSpec) -> Option<f64> {
    let listed = object.motion.speed_m_s.iter().copied().reduce(f64::max);
    listed.or(object.speed_m_s)
}

/// A field of view, how far it reaches, and what it detects.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Radar {
    /// Horizontal and vertical angle.
    pub(crate) fov_rad: [f64; 2],
    /// Where the field begins and ends. It measures no distance, so it has no noise.
    pub(crate) range: Range,
    /// The slowest that it detects, in millimetres a second.
    pub(crate) min_speed_mm_s: u32,
    /// Whether a field in which nothing moves is certified to be free.
    pub(crate) otherwise_free: bool,
}

impl Radar {
    /// How many rays lie side by side and one above the other: so many that neighbours are at most two thirds of a voxel
    /// apart where they end.
    fn ray_counts(&self, voxel_size_m: f64) -> [usize; 2] {
        let gates = self.range.gates(&RayScale::new(voxel_size_m, false));
        let farthest = f64::from(gates.range_max_q16) / 65_536.0;
        self.fov_rad.map(|span_rad| (span_rad * farthest * RAYS_PER_VOXEL).ceil() as usize + 1)
    }

    /// Rays all over its field of view, by azimuth, then by elevation, from the lowest on.
    fn all_rays(&self, voxel_size_m: f64) -> Rays {
        let [columns, rows] = self.ray_counts(voxel_size_m);
        let angle = |span_rad: f64, number: usize, count: usize| {
            libm::sincos(span_rad * (number as f64 / (count - 1) as f64 - 0.5))
        };
        let elevations: Vec<(f64, f64)> = (0..rows).map(|row| angle(self.fov_rad[1], row, rows)).collect();
        let column = |column: usize| {
            let (sin_azimuth, cos_azimuth) = angle(self.fov_rad[0], column, columns);
            let ray = move |&(sin, cos): &(f64, f64)| {
                DVec3::new(cos * cos_azimuth, cos * sin_azimuth, sin).to_array().map(quantise_q15)
            };
            elevations.iter().map(ray)
        };
        let dirs_q15 = (0..columns).flat_map(column).collect();
        self.range.rays(dirs_q15, &RayScale::new(voxel_size_m, false))
    }

    /// Where it detects what moves: all that its rays enter within its range, up to what stops them and with it.
    fn sensed(&self, at: &Station) -> BitGrid {
        let grid = &at.truth.grid;
        let from = placement(self, &at.pose(), grid, 0);
        ray_watch(&self.all_rays(grid.voxel_size_m), &from, &at.truth.radar.blockers, None)
    }

    /// What it labels of where it senses: not what stands still and stops it, except people.
    fn field(&self, at: &Station, sensed: &BitGrid) -> BitGrid {
        let mut fixed = sensed.clone();
        fixed.keep(&at.truth.radar.blockers);
        fixed.remove(&at.truth.human);
        fixed.remove(&self.moving(at.truth));
        let mut field = sensed.clone();
        field.remove(&fixed);
        field
    }

    /// The voxels of all that moves fast enough: of people but those who are slow, and of things that are known to move.
    fn moving(&self, truth: &Truth) -> BitGrid {
        let speed = |number: usize| truth.radar.speeds_mm_s.get(number).copied().flatten().unwrap_or(0);
        let mut moving = truth.human.to_window(truth.grid.window());
        let of = |is_wanted: &dyn Fn(Role, u32) -> bool| {
            let all = truth.objects.iter().enumerate();
            let wanted = all.filter(|(number, object)| is_wanted(object.role, speed(*number)));
            wanted.map(|(_, object)| object).collect::<Vec<_>>()
        };
        let is_slow = |role, speed| role == Role::Human && speed < self.min_speed_mm_s;
        of(&is_slow).into_iter().for_each(|object| moving.remove(&object.voxels));
        let is_fast = |_, speed| speed > 0 && speed >= self.min_speed_mm_s;
        of(&is_fast).into_iter().for_each(|object| moving.add(&object.voxels));
        moving.keep(&truth.occupied);
        moving
    }
}

impl Kind for Radar {
    fn name(&self) -> &'static str {
        RadarFile::NAME
    }

    fn representations(&self) -> Vec<&'static str> {
        vec!["volume"]
    }

    fn fan(&self, voxel_size_m: f64) -> Option<Rays> {
        Some(self.all_rays(voxel_size_m))
    }

    fn field_of_view(&self) -> FieldOfView {
        let [azimuth_rad, elevation_rad] = self.fov_rad.map(|span| [-span / 2.0, span / 2.0]);
        FieldOfView::Turn { azimuth_rad, elevation_rad }
    }

    fn range(&self) -> Option<&Range> {
        Some(&self.range)
    }

    fn frame(&self, pose: &Pose) -> DMat3 {
        pose.link()
    }

    fn blockers<'t>(&self, truth: &'t Truth) -> &'t BitGrid {
        &truth.radar.blockers
    }

    fn is_stopped_by(&self, object: &ObjectVoxels) -> bool {
        object.stops_radar
    }

    fn log_odds(&self, _: usize) -> [i32; 2] {
        SWITCHES
    }

    fn feels_presence(&self, _: usize) -> bool {
        true
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        let [columns, rows] = self.ray_counts(at.truth.grid.voxel_size_m);
        match columns.saturating_mul(rows) {
            rays if rays > MAX_RAYS => Err(Issue::too_large(format!("has a field of {rays} rays"))
                .with_advice(format!("at most {MAX_RAYS} can be: take larger voxels, or a shorter range_m"))),
            _ => Ok(()),
        }
    }

    fn stuck_by(&self, at: &Station) -> BitGrid {
        let mut things = self.moving(at.truth);
        things.remove(&at.truth.human);
        things.remove(&at.truth.robot);
        if things.is_empty() {
            return things;
        }
        things.keep(&self.sensed(at));
        things
    }

    fn stuck_advice(&self) -> &'static str {
        "turn it away from what moves there, or shorten range_m"
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let sensed = self.sensed(at);
        let mut felt = self.moving(at.truth);
        felt.keep(&sensed);
        let on = !felt.is_empty();
        felt.keep(&at.truth.human);
        let field = self.field(at, &sensed);
        let window = field.window().intersection(&at.window);
        vec![switch_planes(at, field.to_window(window), on, self.otherwise_free, felt)]
    }

    fn feels(&self, at: &Station) -> Extent {
        Extent::Only(self.sensed(at))
    }

    fn reach(&self, at: &Station) -> Extent {
        let sensed = self.sensed(at);
        Extent::Only(self.field(at, &sensed))
    }
}

#[cfg(test)]
mod tests;
