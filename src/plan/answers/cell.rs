//! A moment to be drawn: its voxels and its surfaces.

use perirobot_march::voxel::BitGrid;
use perirobot_study::world::World;
use serde::Serialize;

use super::runs;
use crate::live::Scenery;
use crate::state::role_name;

/// `GET /cell`: a moment in voxels, x the fastest.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct CellAnswer {
    voxel_size_m: f64,
    /// World key of the first voxel.
    origin: [i32; 3],
    size: [u32; 3],
    /// Classes: 0 free, 1 environment, 2 robot, 3 human, 4 of no region.
    truth: String,
    /// For each region, 1 where a voxel belongs to it.
    regions: Vec<String>,
}

impl CellAnswer {
    /// Of a world.
    pub(crate) fn new(world: &World) -> CellAnswer {
        let (truth, grid) = (world.truth(), world.grid);
        let voxels = || BitGrid::full(grid.window());
        let role = |voxel| match () {
            () if truth.ignored.get(voxel) => 4,
            () if !truth.occupied.get(voxel) => 0,
            () if truth.human.get(voxel) => 3,
            () if truth.robot.get(voxel) => 2,
            () => 1,
        };
        let region = |region: &perirobot_scene::truth::Region| {
            runs(voxels().voxels().map(|voxel| region.voxels.get(voxel).into()), 2)
        };
        CellAnswer {
            voxel_size_m: grid.voxel_size_m,
            origin: grid.origin,
            size: grid.size,
            truth: runs(voxels().voxels().map(role), 5),
            regions: world.regions.iter().map(region).collect(),
        }
    }
}

/// `GET /scenery`: the surfaces of a moment.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SceneryReply {
    things: Vec<ThingReply>,
}

#[derive(Clone, Debug, Serialize)]
struct ThingReply {
    name: String,
    role: &'static str,
    /// Corners in metres, one after the other.
    at: Vec<f32>,
    /// Three corners of each triangle.
    faces: Vec<u32>,
    /// Two corners of each sharp edge.
    edges: Vec<u32>,
}

impl SceneryReply {
    /// Of surfaces.
    pub(crate) fn new(scenery: &Scenery) -> SceneryReply {
        let metres = |x: f32| (x * 1e4).round() / 1e4;
        let thing = |one: &crate::live::Thing| ThingReply {
            name: one.name.clone(),
            role: role_name(one.role),
            at: one.corners_m.iter().flatten().map(|&x| metres(x)).collect(),
            faces: one.faces.iter().flatten().copied().collect(),
            edges: one.edges.iter().flatten().copied().collect(),
        };
        SceneryReply { things: scenery.things.iter().map(thing).collect() }
    }
}
