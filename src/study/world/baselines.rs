//! The baselines that poses are compared with: what trivial answers would score, and an upper bound for every
//! sensor at the study's positions.

use std::sync::Arc;

use super::true_poses;
use crate::input::Study;
use crate::sensor::{Extent, Setting, Station};
use perirobot_march::error::Issue;
use perirobot_march::march::MAX_RANGE_VOXELS;
use perirobot_march::metrics::{Confusion, Overlap};
use perirobot_march::voxel::{BitGrid, People};
use perirobot_scene::truth::{Region, Truth, voxelize};

/// Counts to compare a pose with: by some scores a sensor that is stuck at one answer beats many poses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Baselines {
    /// Everything labelled occupied.
    pub all_occupied: Confusion,
    /// Everything labelled free.
    pub all_free: Confusion,
    /// Everything unknown.
    pub nothing_seen: Confusion,
    /// Everything right that a ray from any of the study's positions could reach; the rest unknown.
    pub ceiling: Confusion,
}

/// What is wrong with a candidate: index of the sensor, of the candidate, and why.
pub(super) type Wrong = (usize, usize, Issue);

/// What any sensor of a study could do from any of its candidates.
pub(super) struct Reachable {
    /// The voxels that it could label.
    pub(super) spoken_of: BitGrid,
    /// The voxels that it could hit or feel.
    pub(super) hit: BitGrid,
}

/// What any sensor of the study could do from any of its candidates, every candidate checked.
pub(super) fn reachable(
    study: &Study,
    moment: [usize; 2],
    truth: &Truth,
    settings: &[Arc<Vec<Setting>>],
) -> Result<Reachable, Wrong> {
    let blank = BitGrid::new(truth.grid.window());
    let (mut begins, mut spoken_of) = (Vec::new(), blank.clone());
    let (mut hits_begin, mut hit) = (Vec::new(), blank);
    for (s, sensor) in study.sensors.iter().enumerate() {
        if let Some(voxels) = sensor.kind.wherever_it_stands(truth) {
            spoken_of.add(&voxels);
        }
        let housing = (sensor.kind.housing_m() / study.voxel_size_m).ceil();
        let housing = housing.min(f64::from(MAX_RANGE_VOXELS)) as u32;
        for (c, &setting) in settings[s].iter().enumerate() {
            let station = Station {
                moment,
                truth,
                window: truth.grid.window(),
                setting,
                rays: None,
                truly: None,
                draws: 0,
            };
            sensor.kind.check(&station).map_err(|e| (s, c, e))?;
            let truly = true_poses(study, setting, [s, c]).map(|pose| pose.position_m);
            let from = [station.pose().position_m].into_iter().chain(truly);
            let here: Vec<_> = from.map(|at| (truth.grid.position_q16(at), housing)).collect();
            match sensor.kind.feels(&station) {
                Extent::Only(voxels) => hit.add(&voxels),
                Extent::Rays | Extent::RaysAnd(_) => hits_begin.extend_from_slice(&here),
            }
            match sensor.kind.reach(&station) {
                Extent::Rays => begins.extend(here),
                Extent::Only(voxels) => spoken_of.add(&voxels),
                Extent::RaysAnd(voxels) => {
                    spoken_of.add(&voxels);
                    begins.extend(here);
                }
            }
        }
    }
    let same = begins == hits_begin;
    let by_rays = |begins: Vec<_>| (!begins.is_empty()).then(|| voxelize::reachable(truth, begins));
    let reached = by_rays(begins);
    let may_hit = if same { reached.clone() } else { by_rays(hits_begin) };
    reached.iter().for_each(|voxels| spoken_of.add(voxels));
    may_hit.iter().for_each(|voxels| hit.add(voxels));
    Ok(Reachable { spoken_of, hit })
}

pub(super) fn baselines(truth: &Truth, region: &Region, people: &People, reachable: &Reachable) -> Baselines {
    let Reachable { spoken_of: reachable, hit } = reachable;
    let count = |planes: &[&BitGrid]| {
        let mut voxels = BitGrid::clone(&region.voxels);
        planes.iter().for_each(|plane| voxels.keep(plane));
        voxels.count()
    };
    let (s, t) = (region.voxels.count(), count(&[&truth.occupied]));
    let (h, r) = (count(&[&truth.occupied, &truth.human]), count(&[&truth.occupied, &truth.robot]));
    let (reached, t_reached) = (count(&[reachable]), count(&[reachable, &truth.occupied]));
    let h_reached = count(&[reachable, &truth.occupied, &truth.human]);
    let r_reached = count(&[reachable, &truth.occupied, &truth.robot]);
    let f = s - t;
    // Any sensor that reaches a voxel of a person may be a presence sensor.
    let may_hit = people.detection(&region.voxels, |voxel| hit.get(voxel), |voxel| hit.get(voxel));
    let no_hit = people.detection(&region.voxels, |_| false, |_| false);
    let from = |counts| Confusion::from_counts(counts).with_detection(no_hit);
    Baselines {
        all_occupied: from([t, f, 0, 0, 0, 0, h, 0, 0, r, 0, 0]),
        all_free: from([0, 0, t, f, 0, 0, 0, h, 0, 0, r, 0]),
        nothing_seen: from([0, 0, 0, 0, t, f, 0, 0, h, 0, 0, r]),
        ceiling: from([
            t_reached,
            0,
            0,
            reached - t_reached,
            t - t_reached,
            f - (reached - t_reached),
            h_reached,
            0,
            h - h_reached,
            r_reached,
            0,
            r - r_reached,
        ])
        .with_detection(may_hit)
        .with_overlap(Overlap { twice: reached, hit_human_twice: may_hit.hit_human }),
    }
}
