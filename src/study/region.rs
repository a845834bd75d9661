//! Regions of a study, checked.

use super::file::{HumanBoxFile, RegionFile};
use super::{Place, only_one};
use crate::Result;
use crate::voxel::Shape;
use glam::DVec3;

pub(super) fn check(at: &Place, entry: RegionFile) -> Result<(String, Shape)> {
    let at = at.key(&format!("region {:?}", entry.name));
    let sphere = entry.sphere.map(|s| {
        let at = at.key("sphere");
        let radius_m =
            at.number("radius_m", s.radius_m, f64::MIN_POSITIVE..1e6, "a length above 0 and below 1000000")?;
        Ok(Shape::Sphere { center_m: at.vector("center_m", s.center_m)?, radius_m })
    });
    let cuboid = entry.r#box.map(|b| {
        let at = at.key("box");
        let (min_m, max_m) = (at.vector("min_m", b.min_m)?, at.vector("max_m", b.max_m)?);
        if !min_m.cmplt(max_m).all() {
            return Err(at.wrong("max_m", format!("{:?}", b.max_m), "must be above min_m on every axis"));
        }
        Ok(Shape::Box { min_m, max_m })
    });
    let human = entry.human_box.map(|h| human_box(&at.key("human_box"), h));
    let shape = only_one(&at, "shape", vec![("sphere", sphere), ("box", cuboid), ("human_box", human)])??;
    Ok((entry.name, shape))
}

fn human_box(at: &Place, entry: HumanBoxFile) -> Result<Shape> {
    if entry.margin_m.is_some() && (entry.margin_min_m.is_some() || entry.margin_max_m.is_some()) {
        return Err(at.says("margin_m is for all sides: give either it or margin_min_m and margin_max_m"));
    }
    let all = at.number(
        "margin_m",
        entry.margin_m.unwrap_or(0.0),
        -1e3..=1e3,
        "a length in metres from -1000 to 1000",
    )?;
    let side = |key, value: Option<[f64; 3]>| match value {
        Some(value) => at.vector(key, value),
        None => Ok(DVec3::splat(all)),
    };
    Ok(Shape::HumanBox {
        margin_min_m: side("margin_min_m", entry.margin_min_m)?,
        margin_max_m: side("margin_max_m", entry.margin_max_m)?,
        object: entry.object,
    })
}
