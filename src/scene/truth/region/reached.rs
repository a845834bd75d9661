//! What a robot reaches within the limits of its joints, in voxels.

use std::sync::{Arc, Mutex, PoisonError};

use glam::{DAffine3, DVec3};

use super::near::expand;
use crate::objects::urdf::Envelope;
use crate::pose::Pose;
use perirobot_march::error::Issue;
use perirobot_march::voxel::flood::enclosed_voxels;
use perirobot_march::voxel::{BitGrid, Grid, Window};

/// Half the diagonal of a voxel, in voxels, rounded up.
const HALF_DIAGONAL: f64 = 0.8661;

/// Most voxels of the box around a robot's envelope.
const MOST_VOXELS: u64 = 1 << 28;

/// A robot's envelope, which is put into voxels once for a place of the robot.
#[derive(Debug)]
pub struct ReachedVoxels {
    envelope: Envelope,
    known: Mutex<Option<(Pose, Grid, Arc<BitGrid>)>>,
}

impl PartialEq for ReachedVoxels {
    fn eq(&self, other: &ReachedVoxels) -> bool {
        self.envelope == other.envelope
    }
}

impl ReachedVoxels {
    /// Of an envelope.
    pub fn new(envelope: Envelope) -> ReachedVoxels {
        ReachedVoxels { envelope, known: Mutex::new(None) }
    }

    /// Every voxel whose centre the robot reaches from where it stands, and what such voxels enclose; also outside of the grid.
    /// Others are included that are farther from what it reaches by at most twice the error of the envelope and the diagonal
    /// of a voxel.
    pub(super) fn voxels(&self, world_from_root: &Pose, grid: &Grid) -> Result<Arc<BitGrid>, Issue> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((pose, of_grid, voxels)) = &*known
            && (pose, of_grid) == (world_from_root, grid)
        {
            return Ok(voxels.clone());
        }
        let world = DAffine3::from_rotation_translation(world_from_root.rotation, world_from_root.position_m);
        let voxel = |at: DVec3| grid.position_q16(world.transform_point3(at)).map(|axis| (axis >> 16) as i32);
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        self.envelope.for_each(&mut |at| {
            for (axis, place) in voxel(at).into_iter().enumerate() {
                low[axis] = low[axis].min(place);
                high[axis] = high[axis].max(place);
            }
        });
        let window = Window::from_corners(low, high);
        if window.volume() > MOST_VOXELS {
            let what = format!("the robot reaches more than {MOST_VOXELS} voxels");
            return Err(Issue::too_large(what).with_advice("take larger voxels"));
        }
        let mut voxels = BitGrid::new(window);
        self.envelope.for_each(&mut |at| voxels.set(voxel(at)));
        let error_m = self.envelope.error_m() + HALF_DIAGONAL * grid.voxel_size_m;
        // Before that, surfaces may have gaps between their points.
        let mut voxels = expand(&voxels, error_m, grid)?;
        voxels.add(&enclosed_voxels(&voxels));
        let voxels = Arc::new(voxels);
        *known = Some((*world_from_root, *grid, voxels.clone()));
        Ok(voxels)
    }
}
