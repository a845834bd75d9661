//! The shapes of a study's regions: reads the meshes they name and puts in the regions they are made of.

use std::sync::Arc;

use crate::input::{RegionSpec, Study};
use perirobot_march::Result;
use perirobot_march::error::{Issue, Site};
use perirobot_scene::source::Sources;
use perirobot_scene::truth::RegionShape;

/// Most shapes that a region may be made of, counting those of the regions it names, and theirs: a chain of
/// regions can double at each step.
const MAX_PARTS: usize = 1000;

/// The shape of each region, in study order.
///
/// # Errors
/// When a mesh cannot be read, or a region is made of more than 1000 shapes.
pub(crate) fn shapes(study: &Study) -> Result<Vec<RegionShape>> {
    let mut shapes: Vec<RegionShape> = Vec::new();
    for (name, spec) in &study.regions {
        let shape = shape(spec, &shapes, &study.sources)
            .map_err(|e| e.with_place(Site::Table(format!("region {name:?}"))).with_place(&study.path))?;
        shapes.push(shape);
    }
    Ok(shapes)
}

fn shape(spec: &RegionSpec, before: &[RegionShape], sources: &Sources) -> Result<RegionShape> {
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
        RegionSpec::Mesh { file, position_m, rotation } => {
            let mesh = file.load(sources).map_err(|e| e.with_place(Site::Key("mesh".into())))?;
            RegionShape::Mesh(Arc::new(mesh.transform(*rotation, *position_m)))
        }
        RegionSpec::Union(names) => RegionShape::Union(parts(names)?),
        RegionSpec::Difference(names) => RegionShape::Difference(parts(names)?),
    })
}

/// How many simple shapes a shape is made of.
fn count(shape: &RegionShape) -> usize {
    match shape {
        RegionShape::Union(parts) | RegionShape::Difference(parts) => parts.iter().map(count).sum(),
        _ => 1,
    }
}
