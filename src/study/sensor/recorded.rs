//! A sensor whose evidence was recorded: a map, or a point cloud, of one moment of a scene.

use std::sync::{Arc, Mutex, PoisonError};

use super::{Claim, Extent, Kind, MEASURES, Setting, Station};
use perirobot_march::backend::Planes;
use perirobot_march::error::Issue;
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::recording::{Anchor, Recording, Said};

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
    fn said(&self, grid: &Grid) -> Arc<Said> {
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
        let said = self.moment(at)?.said(&at.truth.grid);
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
        "recorded"
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

    fn log_odds(&self, _: usize) -> [i32; 2] {
        MEASURES
    }

    fn check(&self, at: &Station) -> Result<(), Issue> {
        let Some(moment) = self.moment(at) else { return Ok(()) };
        let grid = &at.truth.grid;
        if !moment.recording.fits(&moment.anchor) {
            return Err(Issue::says("is a map, which can be turned about the vertical only")
                .wanted("give an upright pose; point clouds may be tilted"));
        }
        if moment.recording.is_too_fine(&moment.anchor, grid) {
            return Err(Issue::too_large(
                "its map has voxels below 1/64 of the study's, or too many inside the grid",
            )
            .wanted("make it coarser, or set bounds_m of [grid]"));
        }
        let Planes { occupied, free, .. } = &moment.said(grid).planes;
        if !occupied.is_empty() || !free.is_empty() {
            return Ok(());
        }
        let [from, to] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
        let [low, high] = moment.recording.bounds_m().map(|corner| moment.anchor.world(corner));
        Err(Issue::says(format!(
            "says nothing inside the grid ({from:.2} to {to:.2} m): the recording's corners are at {low:.2} and {high:.2} m"
        ))
        .wanted("move it with position_m and yaw_deg"))
    }

    fn claims(&self, at: &Station) -> Vec<Claim> {
        let planes = self.planes(at).map(|planes| {
            let [occupied, free, hits] =
                [planes.occupied, planes.free, planes.hits].map(|plane| plane.over(at.window));
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
