//! Warns of objects and positions that look as if their unit were another one.

use perirobot_march::lengths::describe_length;
use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use perirobot_scene::objects::spec::{SceneSpec, SurfaceSpec};
use perirobot_scene::truth::ObjectVoxels;
use perirobot_scene::truth::voxelize::{HUGE_M, LARGE_M, speck_question, unit_question};

/// What became of a mesh in millimetres is tiny if it is no longer than this, and so small beside the cell.
const TINY_M: f64 = 0.3;
const TINY_SHARE: f64 = 1.0 / 20.0;
/// Floors and walls are long, and thinner than this, in metres.
const THIN_M: f64 = 1.0;
/// Units that numbers may be in, the likelier first: how many are a metre.
const UNITS: [(&str, &str, f64); 2] = [("centimetres", "cm", 100.0), ("millimetres", "mm", 1000.0)];

/// What a scene's objects are made of, by their names.
pub(super) struct Surfaces<'a>(HashMap<&'a str, &'a SurfaceSpec>);

impl<'a> Surfaces<'a> {
    pub(super) fn new(scene: &'a SceneSpec) -> Surfaces<'a> {
        Surfaces(scene.objects.iter().map(|spec| (spec.name.as_str(), &spec.surface)).collect())
    }

    /// That of an object, or of what the object is a part of.
    pub(super) fn get(&self, object: &str) -> Option<&'a SurfaceSpec> {
        let wholes = object.match_indices('/').map(|(slash, _)| &object[..slash]);
        [object].into_iter().chain(wholes).find_map(|name| self.0.get(name).copied())
    }
}

/// The lengths of all objects, the two longest known.
pub(super) struct Lengths {
    all_m: Vec<f64>,
    longest: usize,
    next_m: Option<f64>,
}

impl Lengths {
    pub(super) fn new(objects: &[Arc<ObjectVoxels>]) -> Lengths {
        let length_m = |object: &Arc<ObjectVoxels>| (object.bounds_m[1] - object.bounds_m[0]).max_element();
        let all_m: Vec<f64> = objects.iter().map(length_m).collect();
        let longer =
            |longest: usize, other: usize| if all_m[other] > all_m[longest] { other } else { longest };
        let longest = (0..all_m.len()).fold(0, longer);
        let others = all_m.iter().enumerate().filter(|(index, _)| *index != longest);
        let next_m = others.map(|(_, length_m)| *length_m).reduce(f64::max);
        Lengths { all_m, longest, next_m }
    }

    /// The longest of the others, if there are any.
    fn longest_other_m(&self, index: usize) -> Option<f64> {
        if index == self.longest { self.next_m } else { Some(self.all_m[self.longest]) }
    }

    /// A wrong unit makes an object smaller than a voxel, a mesh or a body much larger than all others, or a mesh with a
    /// unit a trifle.
    pub(super) fn warning(
        &self,
        object: &ObjectVoxels,
        index: usize,
        voxel_size_m: f64,
        surfaces: &Surfaces,
    ) -> Option<String> {
        let (name, own_m) = (&object.name, self.all_m[index]);
        let is_map = object.watertight.is_none();
        let surface = surfaces.get(name);
        let file = surface.and_then(SurfaceSpec::mesh_file);
        let longest_m = self.longest_other_m(index);
        let beside_m = longest_m.filter(|longest_m| own_m <= TINY_M.min(TINY_SHARE * longest_m));
        if let (Some(file), Some(beside_m)) = (file.filter(|file| file.scale < 1.0), beside_m) {
            let unit = UNITS.iter().find(|(_, _, per_m)| (file.scale * per_m - 1.0).abs() < 1e-9);
            let unit = unit.map_or("its unit".into(), |(_, unit, _)| format!("unit = {unit:?}"));
            let ten = 10.0 * own_m;
            let long = if own_m < 0.1 { format!("{:.1} mm", own_m * 1e3) } else { format!("{own_m:.2} m") };
            let other = match file.scale < 0.005 {
                true => format!("is its file in centimetres (unit = \"cm\": {ten:.2} m)?"),
                false => "is its file in metres (without unit)?".into(),
            };
            return Some(format!(
                "object {name:?} is {long} long by {unit}, in a cell of {beside_m:.1} m: {other}"
            ));
        }
        if let Some(question) = speck_question(own_m, voxel_size_m).filter(|_| !is_map) {
            return Some(format!("object {name:?} {question}"));
        }
        let longest_m = longest_m?;
        // Longer objects are told of when they are voxelized.
        let is_odd = own_m > LARGE_M && own_m <= HUGE_M && own_m >= 5.0 * longest_m;
        let is_thin = (object.bounds_m[1] - object.bounds_m[0]).min_element() < THIN_M;
        let is_body = surface.is_some_and(SurfaceSpec::is_body) && !is_thin;
        (is_odd && (file.is_some() || is_body)).then(|| {
            format!(
                "object {name:?} is {own_m:.1} m long, and no other is longer than {longest_m:.1} m: {}",
                unit_question(own_m, surface.is_some_and(SurfaceSpec::takes_unit))
            )
        })
    }
}

/// In which unit the coordinates of a point are that is far outside a box, if in that unit it is inside: what the
/// coordinates are, and what they would be in metres.
pub(super) fn guess_unit(at: DVec3, [low, high]: [DVec3; 2]) -> Option<String> {
    let size_m = (high - low).max_element();
    let is_far = |axis: usize| at[axis] < low[axis] - size_m || at[axis] > high[axis] + size_m;
    let far: Vec<usize> = (0..3).filter(|&axis| is_far(axis)).collect();
    let (units, unit, per_m) = UNITS.into_iter().find(|(_, _, per_m)| {
        let metres = |axis: usize| if is_far(axis) { at[axis] / per_m } else { at[axis] };
        !far.is_empty() && (0..3).all(|axis| (low[axis]..=high[axis]).contains(&metres(axis)))
    })?;
    let each = far.iter().map(|&axis| {
        let (name, value) = (["x", "y", "z"][axis], at[axis]);
        format!("{name} {value} {unit} are {}", describe_length(value / per_m))
    });
    let each: Vec<String> = each.collect();
    Some(format!("looks like {units}, and metres are wanted: {}, which is inside the cell", each.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_far_outside_is_in_another_unit_if_that_puts_it_inside() {
        let cell = [DVec3::new(-3.0, -3.0, 0.0), DVec3::new(3.0, 3.0, 3.0)];
        for (at, expected) in [
            (
                [2.0, 1.0, 250.0],
                Some("looks like centimetres, and metres are wanted: z 250 cm are 2.5 m, which is"),
            ),
            ([-280.0, 100.0, 250.0], Some("x -280 cm are -2.8 m, y 100 cm are 1 m, z 250 cm are 2.5 m")),
            ([2.0, 1.0, 2500.0], Some("looks like millimetres, and metres are wanted: z 2500 mm are 2.5 m")),
            ([2.0, 1.0, 2.5], None),
            ([2.0, 1.0, 4.0], None),
            ([2.0, 1.0, -250.0], None),
            ([2.0, 4.0, 250.0], None),
        ] {
            let found = guess_unit(DVec3::from_array(at), cell);
            match expected {
                Some(expected) => assert!(found.as_ref().is_some_and(|f| f.contains(expected)), "{found:?}"),
                None => assert_eq!(found, None, "{at:?}"),
            }
        }
    }
}
