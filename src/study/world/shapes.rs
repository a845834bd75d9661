//! The shapes of a study's regions: reads the meshes they name and puts in the regions they are made of.

use std::sync::Arc;

use crate::input::{RegionSpec, Study};
use perirobot_march::Result;
use perirobot_march::error::{Issue, Site};
use perirobot_scene::objects::carrier::read_envelope;
use perirobot_scene::objects::spec::{SceneSpec, SurfaceSpec};
use perirobot_scene::objects::urdf::AxisLimits;
use perirobot_scene::truth::RegionShape;
use perirobot_scene::truth::region::ReachedVoxels;

/// Most shapes that a region may be made of, counting those of the regions it names, and theirs: a chain of
/// regions can double at each step.
const MAX_PARTS: usize = 1000;

/// How many cells of a robot's envelope a voxel is long.
const CELLS: f64 = 5.0;

/// The shape of each region in a scene, in study order.
///
/// # Errors
/// When a mesh or a robot cannot be read, a limit is none of its joints', or a region is made of more than 1000 shapes.
pub(crate) fn shapes(study: &Study, scene: &SceneSpec) -> Result<Vec<RegionShape>> {
    let mut shapes: Vec<RegionShape> = Vec::new();
    for (name, spec) in &study.regions {
        let shape = shape(study, scene, spec, &shapes)
            .map_err(|e| e.with_place(Site::Table(format!("region {name:?}"))).with_place(&study.path))?;
        shapes.push(shape);
    }
    Ok(shapes)
}

fn shape(study: &Study, scene: &SceneSpec, spec: &RegionSpec, before: &[RegionShape]) -> Result<RegionShape> {
    let parts = |parts: &[usize]| -> Result<Vec<RegionShape>, Issue> {
        let named = || parts.iter().filter_map(|&i| before.get(i));
        match named().map(count).sum::<usize>() {
            ..=MAX_PARTS => Ok(named().cloned().collect()),
            many => {
                let what = format!("is made of {many} shapes, counting those of the regions it names");
                Err(Issue::too_large(what).with_advice(format!("at most {MAX_PARTS}")))
            }
        }
    };
    Ok(match spec {
        RegionSpec::RegionShape(shape) | RegionSpec::Separation { shape, .. } => shape.clone(),
        RegionSpec::JointLimits { shape, limits } => reach_within(study, scene, shape, limits)?,
        RegionSpec::Mesh { file, position_m, rotation } => {
            let mesh = file.load(&study.sources).map_err(|e| e.with_place(Site::Key("mesh".into())))?;
            RegionShape::Mesh(Arc::new(mesh.transform(*rotation, *position_m)))
        }
        RegionSpec::Union(names) => RegionShape::Union(parts(names)?),
        RegionSpec::Difference(names) => RegionShape::Difference(parts(names)?),
    })
}

/// The reach of a robot with what its links reach. Without a robot of that name the shape stays as it is: what is wrong is
/// told with the other regions.
fn reach_within(
    study: &Study,
    scene: &SceneSpec,
    shape: &RegionShape,
    limits: &AxisLimits,
) -> Result<RegionShape> {
    let RegionShape::RobotReach { object, tool_m, planes, .. } = shape else { return Ok(shape.clone()) };
    let robots = scene.objects.iter().filter(|one| object.as_ref().is_none_or(|name| one.name == *name));
    let mut robots = robots.filter_map(|one| match &one.surface {
        SurfaceSpec::Urdf(robot) => Some((&one.name, robot)),
        _ => None,
    });
    let Some((name, robot)) = robots.next() else { return Ok(shape.clone()) };
    let carried = scene.objects.iter().filter_map(|one| one.on.as_ref()).filter(|on| on.object == *name);
    let tool_links: Vec<&str> = carried.filter_map(|on| on.link.as_deref()).collect();
    let step_m = study.voxel_size_m / CELLS;
    let envelope = read_envelope(robot, limits, (*tool_m, &tool_links), step_m, &study.sources)
        .map_err(|e| e.with_place("robot_reach"))?;
    let within_limits = Some(Arc::new(ReachedVoxels::new(envelope)));
    Ok(RegionShape::RobotReach {
        object: object.clone(),
        tool_m: *tool_m,
        within_limits,
        planes: planes.clone(),
    })
}

/// How many simple shapes a shape is made of.
fn count(shape: &RegionShape) -> usize {
    match shape {
        RegionShape::Union(parts) | RegionShape::Difference(parts) => parts.iter().map(count).sum(),
        _ => 1,
    }
}
