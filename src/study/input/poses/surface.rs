//! Poses on the surface of an object of the scenes: a wall, a post, a beam, a link of a robot. The sensor is a little in
//! front of the surface and looks straight away from it, unless it is turned.
//!
//! The object's files are read for it while the study is checked, once for all groups, and again when worlds are made.

mod carrier;
mod file;

use std::ops::Range;

use glam::DVec3;

use super::{Expanded, PanTilt, PoseSource, PosesFile, facing, least_apart, too_many, turn_pose};
use crate::diagnostics::Place;
use crate::sensor::Stance;
use crate::sensor::spread::WAYS;
pub(in crate::input) use carrier::Surfaces;
use carrier::{Carrier, find_carrier};
use file::SideWay;
pub(super) use file::SurfaceFile;
use perirobot_march::Result;
use perirobot_march::error::Issue;
use perirobot_scene::objects::sides::{Enclosed, NARROWEST_M, SideGrid};

/// The distance of a sensor from its surface that is usual.
const OFF_M: f64 = 0.05;
/// Positions are whole numbers of micrometres, so that triangles of a round body leave no trace in them.
const PER_M: f64 = 1e6;
/// Parts of a direction that differ by less are the same.
const TRACE: f64 = 1e-9;

/// The ways by their numbers, as poses are named.
const WAYS_OF_SIDES: [(SideWay, &str); 6] = [
    (SideWay::MinusX, "-x"),
    (SideWay::PlusX, "+x"),
    (SideWay::MinusY, "-y"),
    (SideWay::PlusY, "+y"),
    (SideWay::MinusZ, "-z"),
    (SideWay::PlusZ, "+z"),
];

/// The checked numbers of an entry.
struct Checked {
    grid: SideGrid,
    off_m: f64,
    towards_m: Option<DVec3>,
    facing: Option<DVec3>,
}

/// A pose without its turns: where it is, which way it faces, and which way its side does.
struct Spot {
    at_m: DVec3,
    ahead: DVec3,
    way: usize,
}

/// A stretch of spots between which others are possible along these axes of the world.
struct Row {
    spots: Vec<Spot>,
    steps_m: [f64; 3],
}

/// The poses of an entry, and the object that they are on; none where its scene could not be read.
pub(super) fn surface_poses(
    at: &Place,
    entry: &PosesFile,
    file: &SurfaceFile,
    source: &PoseSource,
    most: usize,
) -> Result<(Expanded, Option<String>)> {
    let straight = [PanTilt::default()];
    let turns = entry.orientations_deg.as_deref().unwrap_or(&straight);
    at.some("orientations_deg", turns, "orientations_deg = [{ pan = 0, tilt = 0 }]")?;
    let given = entry.facing.map(|way| facing(at, Some(way), source.stance)).transpose()?;
    let of_surface = &at.key("surface");
    let checked = check(of_surface, file, given, most / turns.len())?;
    let Some(carrier) = find_carrier(of_surface, file, source)? else {
        return Ok((Expanded::from_list(Vec::new()), None));
    };
    let rows = rows(of_surface, file, &checked, &carrier, source.stance)?;
    let turns_deg: Vec<[f64; 2]> = turns.iter().map(|turn| [turn.pan, turn.tilt]).collect();
    let steps_deg = [0, 1].map(|turn| least_apart(turns_deg.iter().map(|turns| turns[turn]).collect()));
    let (mut poses, mut stretches, mut numbers) = (Vec::new(), Vec::new(), [0; 6]);
    for Row { spots, steps_m } in rows {
        let first = poses.len();
        for Spot { at_m, ahead, way } in spots {
            for (o, turn) in turns.iter().enumerate() {
                let at = at.key(&format!("orientations_deg[{o}]"));
                let turn = [("pan", turn.pan), ("tilt", turn.tilt)];
                let pose = turn_pose(&at, source.stance, at_m, ahead, turn)?;
                poses.push((format!("{}/{}/{o}", WAYS_OF_SIDES[way].1, numbers[way]), pose));
            }
            numbers[way] += 1;
        }
        let [x, y, z] = steps_m;
        stretches
            .push((first..poses.len(), [x, y, z, steps_deg[0], steps_deg[1]]) as (Range<usize>, [f64; WAYS]));
    }
    if poses.len() > most {
        return Err(at.wrap(too_many()));
    }
    Ok((Expanded { poses, turns_deg, stretches }, Some(carrier.name.into())))
}

fn check(at: &Place, file: &SurfaceFile, facing: Option<DVec3>, most: usize) -> Result<Checked> {
    let spacing_m =
        at.number("spacing_m", file.spacing_m, 0.001..=1000.0, "a length in metres from 0.001 to 1000")?;
    let length = |key: &str, value: f64| at.number(key, value, 0.0..=10.0, "a length in metres from 0 to 10");
    let off_m = length("off_m", file.off_m.unwrap_or(OFF_M))?;
    let margin_m = file.margin_m.map(|margin| length("margin_m", margin)).transpose()?;
    if let Some(sides) = &file.sides {
        at.some("sides", sides, "sides = [\"-z\"]")?;
    }
    let towards_m = file.sides_towards_m.map(|place| at.vector("sides_towards_m", place)).transpose()?;
    Ok(Checked { grid: SideGrid { spacing_m, margin_m, most }, off_m, towards_m, facing })
}

/// The poses on each side that is wanted, without those that have no room.
fn rows(
    at: &Place,
    file: &SurfaceFile,
    checked: &Checked,
    carrier: &Carrier,
    stance: Stance,
) -> Result<Vec<Row>> {
    let Checked { grid, off_m, towards_m, facing } = checked;
    let Carrier { name, mesh, frame, others } = carrier;
    let sides = mesh.sides(grid).map_err(|issue| at.wrap(issue.with_place(format!("object {name:?}"))))?;
    let enclosed = Enclosed::new(mesh);
    let mut rows: Vec<(usize, Row)> = Vec::new();
    let (mut on_sides, mut wanted) = (0, 0);
    for side in sides {
        on_sides += side.places.len();
        let own_axis = |axis: usize| frame.rotation * DVec3::AXES[axis];
        let sign = if side.way % 2 == 1 { 1.0 } else { -1.0 };
        let way = way_of(sign * own_axis(side.way / 2));
        if file.sides.as_ref().is_some_and(|sides| !sides.contains(&WAYS_OF_SIDES[way].0)) {
            continue;
        }
        let mut spots = Vec::new();
        let places = side.places.len();
        for place in side.places {
            let surface_m = frame.position_m + frame.rotation * place.at_m;
            let normal = (frame.rotation * place.normal).to_array().map(|part| rounded(part, 1.0 / TRACE));
            let normal = DVec3::from_array(normal);
            let at_m = surface_m + *off_m * normal;
            let at_m = DVec3::from_array(at_m.to_array().map(|metres| rounded(metres, PER_M)));
            let faces = |towards_m: &DVec3| normal.dot(*towards_m - surface_m) > 0.0;
            let looks_in = |facing: &DVec3| normal.dot(*facing) < -TRACE && stance == Stance::Facing;
            if !towards_m.as_ref().is_none_or(faces) || facing.as_ref().is_some_and(looks_in) {
                continue;
            }
            wanted += 1;
            let own = place.at_m + *off_m * place.normal;
            if enclosed.contains(own) || others.iter().any(|other| other.is_in_the_way(surface_m, at_m)) {
                continue;
            }
            // What stands upright has a heading, and a floor gives none.
            let heading = if stance != Stance::Facing && way / 2 == 2 { DVec3::X } else { normal };
            spots.push(Spot { at_m, ahead: facing.unwrap_or(heading), way });
        }
        let steps_m = match side.is_flat && spots.len() == places {
            true => steps(&spots, side.way / 2, own_axis, grid.spacing_m),
            false => [0.0; 3],
        };
        rows.push((way, Row { spots, steps_m }));
    }
    rows.sort_by_key(|(way, _)| *way);
    let rows: Vec<Row> = rows.into_iter().map(|(_, row)| row).filter(|row| !row.spots.is_empty()).collect();
    match rows.is_empty() {
        false => Ok(rows),
        true => Err(at.wrap(nothing_fits([on_sides, wanted]).with_place(format!("object {name:?}")))),
    }
}

/// Why no place of an object is left: so many are on its sides, and so many of them on those that are wanted.
fn nothing_fits([on_sides, wanted]: [usize; 2]) -> Issue {
    match (on_sides, wanted) {
        (0, _) => Issue::says("has no side that carries a sensor").with_advice(format!(
            "sides must be {NARROWEST_M} m wide and have material in the middle of each spacing_m: take a smaller one"
        )),
        (_, 0) => Issue::says("has no side that faces the wanted way")
            .with_advice("change sides, sides_towards_m or facing"),
        _ => {
            let which = if wanted == 1 { "its one place is".into() } else { format!("all of its {wanted} places are") };
            Issue::says(format!("{which} inside of it or of another object, or behind a wall"))
                .with_advice("change off_m, or take another object")
        }
    }
}

/// The distances between neighbouring places of a flat side along the axes of the world; 0 where it is not along them.
fn steps(spots: &[Spot], across: usize, own_axis: impl Fn(usize) -> DVec3, spacing_m: f64) -> [f64; 3] {
    let mut steps_m = [0.0; 3];
    for own in (0..3).filter(|own| *own != across) {
        let axis = own_axis(own).abs();
        let Some(world) = (0..3).find(|world| axis[*world] > 1.0 - TRACE) else { return [0.0; 3] };
        let first = spots.first().map_or(0.0, |spot| spot.at_m[world]);
        if spots.iter().any(|spot| (spot.at_m[world] - first).abs() > spacing_m / 2.0) {
            steps_m[world] = spacing_m;
        }
    }
    steps_m
}

/// The way that a direction faces most, the first axis of several.
fn way_of(direction: DVec3) -> usize {
    let size = direction.abs();
    let axis = (0..3).find(|&axis| size[axis] >= size.max_element() - TRACE).unwrap_or(0);
    2 * axis + usize::from(direction[axis] > 0.0)
}

/// A number with so many decimals as a power of ten has zeros.
fn rounded(number: f64, power: f64) -> f64 {
    (number * power).round() / power + 0.0
}

#[cfg(test)]
mod tests;
