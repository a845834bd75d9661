//! Warns of sensors that look at glass, mirrors and retroreflectors: what they measure there is not modelled.

use glam::DVec3;
use rayon::prelude::*;

use super::near::lens_of;
use super::place::Places;
use super::warnings::first_of;
use super::{World, ray_table};
use crate::input::Study;
use crate::sensor::lens::Lens;
use crate::sensor::{Sensor, Setting, placement, quantise_q15};
use perirobot_march::backend::{GridPose, Rays};
use perirobot_march::march;
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::objects::Specular;
use perirobot_scene::truth::Truth;

/// Poses of a sensor, voxels of an object and rays of a pose that are looked at, spread evenly.
const MOST_POSES: usize = 500;
const MOST_VOXELS: usize = 100;
const MOST_RAYS: usize = 3000;

/// For each object of glass, mirror or retroreflector and each sensor that looks at it, how many of its poses do, and what to
/// do. People and what else moves are where they are in the first snapshot.
pub(super) fn warnings(study: &Study, world: &World) -> Vec<String> {
    let specular =
        study.scenes[world.scene].objects.iter().filter_map(|object| Some((object, object.specular?)));
    let specular: Vec<_> = specular.collect();
    if specular.is_empty() {
        return Vec::new();
    }
    let (truth, places) = (world.truth(), Places::new(study, world));
    let mut warnings = Vec::new();
    for (object, surface) in specular {
        let mut voxels = BitGrid::new(truth.grid.window());
        let parts = truth.objects.iter().filter(|part| part.is_part_of(&object.name));
        parts.for_each(|part| voxels.add(&part.voxels));
        let aims = aims(&truth, &voxels);
        for (number, sensor) in study.sensors.iter().enumerate() {
            let settings = &world.settings[number];
            let step = settings.len().div_ceil(MOST_POSES).max(1);
            let rays = ray_table(study, number);
            let sees = |candidate: &usize| {
                let setting = &settings[*candidate];
                let aimed = lens_of(sensor, setting).is_some_and(|lens| sees(&truth, &lens, &voxels, &aims));
                let is_hit = |rays: &Rays| hits(&truth, rays, &standpoint(sensor, setting, &truth), &voxels);
                aimed || matches!(setting, Setting::Pose(_)) && rays.as_ref().is_some_and(is_hit)
            };
            let asked: Vec<usize> = (0..settings.len()).step_by(step).collect();
            let seeing: Vec<usize> = asked.par_iter().copied().filter(sees).collect();
            if let Some(first) = first_of(study, &places, number, &seeing) {
                warnings.push(format!(
                    "sensor {:?}: {} of {} poses look at {:?} ({first}), surface = {:?}: {}",
                    sensor.name,
                    seeing.len(),
                    asked.len(),
                    object.name,
                    surface.name(),
                    advice(surface, sensor)
                ));
            }
        }
    }
    warnings
}

/// Middles of some voxels, in metres.
fn aims(truth: &Truth, voxels: &BitGrid) -> Vec<DVec3> {
    let step = (voxels.count() as usize).div_ceil(MOST_VOXELS).max(1);
    let middle = |voxel| truth.grid.corner_m(voxel) + truth.grid.voxel_size_m / 2.0;
    voxels.voxels().step_by(step).map(middle).collect()
}

/// Whether a line from a lens towards one of some points meets voxels before anything that stops rays.
fn sees(truth: &Truth, lens: &Lens, voxels: &BitGrid, aims: &[DVec3]) -> bool {
    let from = GridPose {
        origin_q16: truth.grid.position_q16(lens.position_m).map(|x| x as i32),
        axis_q15: [[1 << 15, 0, 0], [0, 1 << 15, 0], [0, 0, 1 << 15]],
        truly: None,
        draws: 0,
    };
    let own = Grid::voxel_of(from.origin_q16.map(i64::from));
    let meets = |aim: &&DVec3| {
        let Some(towards) = (**aim - lens.position_m).try_normalize() else { return false };
        let line = march::crossings(from.launch(towards.to_array().map(quantise_q15)));
        let inside =
            line.map(|crossing| crossing.voxel).take_while(|voxel| truth.grid.window().contains(*voxel));
        let mut stops = inside.filter(|voxel| voxels.get(*voxel) || truth.blockers.get(*voxel));
        stops.next().is_some_and(|voxel| voxels.get(voxel))
    };
    truth.grid.window().contains(own) && aims.iter().filter(|aim| lens.reaches(**aim)).any(|aim| meets(&aim))
}

/// Where a sensor is, as integers.
fn standpoint(sensor: &Sensor, setting: &Setting, truth: &Truth) -> GridPose {
    placement(&*sensor.kind, &setting.pose(), &truth.grid, 0)
}

/// Whether some of the rays of a table meet voxels before anything that stops them: those of a single plane pass beside the
/// middles of most voxels.
fn hits(truth: &Truth, rays: &Rays, from: &GridPose, voxels: &BitGrid) -> bool {
    let step = rays.dirs_q15.len().div_ceil(MOST_RAYS).max(1);
    let within = Grid::voxel_of(from.origin_q16.map(i64::from));
    truth.grid.window().contains(within)
        && rays.dirs_q15.iter().step_by(step).any(|dir_q15| {
            let farthest_q16 = rays.gates.ray_gates(dir_q15[2]).range_max_q16;
            let line = march::crossings(from.launch(*dir_q15)).take_while(|at| at.t_q16 <= farthest_q16);
            let inside = line.map(|at| at.voxel).take_while(|voxel| truth.grid.window().contains(*voxel));
            let mut stops = inside.filter(|voxel| voxels.get(*voxel) || truth.blockers.get(*voxel));
            stops.next().is_some_and(|voxel| voxels.get(voxel))
        })
}

/// What a surface does to a sensor, and what to do.
fn advice(surface: Specular, sensor: &Sensor) -> &'static str {
    let emits = sensor.emits.is_some() || sensor.kind.name() == "lidar";
    match surface {
        Specular::Glass if emits => {
            "its light passes glass or is reflected away, so it measures what is behind or nothing: cover the glass with \
             matt film, or write optical = \"see_through\" and require nothing of what is behind it"
        }
        Specular::Glass => {
            "a stereo camera measures what is behind glass or mirrored in it: cover the glass with matt film, or require \
             nothing of what is behind it"
        }
        Specular::Mirror => {
            "it measures the mirrored cell, with people where there are none and free space inside the mirror: cover the \
             mirror, or turn the sensor away"
        }
        Specular::Retroreflector if sensor.kind.name() == "lidar" => {
            "people near it or before it may be missed: remove it from the plane of the rays. Makers of safety scanners ask for \
             a longer field (SICK nanoScan3 and microScan3: 350 mm if it is within 6 m of the field), to be checked"
        }
        Specular::Retroreflector => {
            "its strong light saturates pixels and spreads to their neighbours: cover it, or turn the sensor away"
        }
    }
}

#[cfg(test)]
mod tests;
