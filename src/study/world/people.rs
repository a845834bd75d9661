//! Warns of people where nobody can be: cut by a floor or a table top, partly inside a body, with a limb
//! through a surface, shut up in a closed space, or in the air. Touching is allowed: people who stand, sit or
//! lean share voxels with what they touch, so shared voxels of surfaces alone prove nothing.

use std::collections::{BTreeMap, HashSet};

use glam::DVec3;

use super::dead::SMALL;
use super::{World, bodies};
use crate::input::Study;
use perirobot_march::voxel::BitGrid;
use perirobot_march::voxel::flood::{enclosed_voxels, flood, with_neighbours};
use perirobot_scene::objects::keypoints::Keypoints;
use perirobot_scene::objects::{Interior, Object, Role, Scene, Surface};
use perirobot_scene::truth::{ObjectVoxels, Truth};

/// A layer of a body that has at least so large a share of a person's columns cuts the person.
const CUTS: f64 = 0.9;
/// The part that is cut off, or the gap below a floating person, is at least so long, in metres and in
/// voxels.
const APPARENT_M: f64 = 0.1;
const APPARENT_VOXELS: i32 = 2;
/// Feet may be so far from the ground, in metres.
const STEP_M: f64 = 0.2;
/// A larger share of a person's voxels inside a body is more than a touch.
const INSIDE: f64 = 0.1;

/// Limbs and the sides of the trunk, as pairs of COCO's joints. The face is left out: it is all within the
/// head.
const LIMBS: [(&str, [usize; 2]); 12] = [
    ("left upper arm", [5, 7]),
    ("left forearm", [7, 9]),
    ("right upper arm", [6, 8]),
    ("right forearm", [8, 10]),
    ("left thigh", [11, 13]),
    ("left shank", [13, 15]),
    ("right thigh", [12, 14]),
    ("right shank", [14, 16]),
    ("shoulders", [5, 6]),
    ("hips", [11, 12]),
    ("left side", [5, 11]),
    ("right side", [6, 12]),
];

/// What is wrong with each person, each fault once however many snapshots have it.
pub(super) fn warnings(study: &Study, scenes: &[Scene], worlds: &[World]) -> Vec<String> {
    let whole: HashSet<&str> =
        study.scenes[worlds[0].scene].objects.iter().map(|spec| spec.name.as_str()).collect();
    let mut faults: BTreeMap<(usize, String), (usize, usize, String)> = BTreeMap::new();
    for (snapshot, (scene, world)) in scenes.iter().zip(worlds).enumerate() {
        let truth = world.truth();
        for (index, person) in scene.objects.iter().enumerate() {
            if person.role != Role::Human || person.tag_only || truth.objects[index].voxels.is_empty() {
                continue;
            }
            let joints = person.keypoints.as_ref();
            let floor_m = world.floor.z_m;
            let is_whole = whole.contains(person.name.as_str());
            let mirrored = joints.is_some_and(bodies::is_mirrored).then(|| {
                "has its nose where its back is: left and right are exchanged in its joints, or one axis is mirrored".into()
            });
            let all = match bodies::fault(joints, &truth.objects[index], is_whole, floor_m) {
                Some(what) => vec![(String::new(), what)],
                None => faults_of(scene, &truth, index),
            };
            for (with, what) in mirrored.map(|what| ("/mirrored".into(), what)).into_iter().chain(all) {
                let seen = faults.entry((index, with)).or_insert((snapshot, 0, what));
                seen.1 += 1;
            }
        }
    }
    let line = |((index, _), (first, count, what)): (&(usize, String), &(usize, usize, String))| {
        let when = match worlds.len() {
            1 => String::new(),
            all if *count == 1 => format!(" (in snapshot {first} of {all})"),
            all => format!(" (in {count} of {all} snapshots, first {first})"),
        };
        format!("person {:?} {what}{when}", scenes[0].objects[*index].name)
    };
    faults.iter().map(line).collect()
}

/// The faults of a person at one moment: the other object of each, and a sentence.
fn faults_of(scene: &Scene, truth: &Truth, index: usize) -> Vec<(String, String)> {
    let person = &truth.objects[index];
    let mut faults: Vec<(String, String)> = Vec::new();
    for (object, voxels) in scene.objects.iter().zip(&truth.objects) {
        let bounds = [&person.bounds_m, &voxels.bounds_m];
        let apart = (0..3).any(|r| bounds[0][1][r] < bounds[1][0][r] || bounds[1][1][r] < bounds[0][0][r]);
        if object.role == Role::Human || object.tag_only || apart {
            continue;
        }
        let with = &object.name;
        let limbs = || scene.objects[index].keypoints.as_ref().map(|joints| limbs_through(joints, object));
        let what = cut(truth, person, voxels).map(|[below_m, above_m]| {
            format!(
                "is cut by {with:?}: {below_m:.2} m of the body is below and {above_m:.2} m above: mend position_m of one of them"
            )
        });
        let what = what.or_else(|| {
            // The hull of a cell is free inside, and so is every body whose interior is declared free.
            let share = if object.interior == Interior::Free { 0.0 } else { hollow_share(person, voxels) };
            (share > INSIDE && share < 1.0).then(|| {
                format!("is inside {with:?} with {:.0} % of the body: move one of them", 100.0 * share)
            })
        });
        let what = what.or_else(|| {
            let limbs = limbs().filter(|limbs| !limbs.is_empty())?;
            let (verb, more) = match limbs.len() {
                1 => ("goes", String::new()),
                2 => ("go", String::new()),
                all => ("go", format!(" and {} more", all - 2)),
            };
            let first = limbs.iter().take(2).copied().collect::<Vec<_>>().join(", ");
            Some(format!("is in {with:?}: {first}{more} {verb} through its surface: move one of them, or mend the joints"))
        });
        faults.extend(what.map(|what| (with.clone(), what)));
    }
    if faults.is_empty() {
        // Once for a scene, since it looks at all of it.
        let shut_in = (scene.snapshot == 0).then(|| shut_in(truth, person)).flatten();
        let what = shut_in.or_else(|| floats(truth, person));
        faults.extend(what.map(|what| (String::new(), what)));
    }
    faults
}

/// How much of a person is below and above the layer of a body that cuts through.
fn cut(truth: &Truth, person: &ObjectVoxels, body: &ObjectVoxels) -> Option<[f64; 2]> {
    let voxel_m = truth.grid.voxel_size_m;
    let columns: HashSet<[i32; 2]> = person.voxels.voxels().map(|[x, y, _]| [x, y]).collect();
    let bounds = person.voxels.bounds();
    let least = APPARENT_VOXELS.max((APPARENT_M / voxel_m).ceil() as i32);
    let (low, end) = (bounds.min[2], bounds.end()[2]);
    let covers = |z: &i32| {
        let covered = columns.iter().filter(|[x, y]| body.voxels.get([*x, *y, *z])).count();
        covered as f64 >= CUTS * columns.len() as f64
    };
    let at = (low + least..end - least).find(covers)?;
    Some([f64::from(at - low) * voxel_m, f64::from(end - 1 - at) * voxel_m])
}

/// The share of a person's voxels in the hollow of a body, whose surface does not count.
fn hollow_share(person: &ObjectVoxels, body: &ObjectVoxels) -> f64 {
    let mut shared = enclosed_voxels(&body.voxels).to_window(person.voxels.window());
    shared.keep(&person.voxels);
    shared.count() as f64 / person.voxels.count() as f64
}

/// The limbs whose middle line goes through a surface.
fn limbs_through(joints: &Keypoints, body: &Object) -> Vec<&'static str> {
    let Surface::Mesh(mesh) = &body.surface else { return Vec::new() };
    let lines: Vec<(&str, [DVec3; 2])> =
        LIMBS.iter().filter_map(|(name, [a, b])| Some((*name, [joints[*a]?, joints[*b]?]))).collect();
    let ends = || lines.iter().flat_map(|(_, line)| *line);
    let (low, high) = (ends().reduce(DVec3::min), ends().reduce(DVec3::max));
    let (Some(low), Some(high)) = (low, high) else { return Vec::new() };
    let mut through = vec![false; lines.len()];
    for triangle in &mesh.triangles {
        let corners = triangle.map(|i| mesh.vertices[i as usize]);
        let (least, most) =
            (corners[0].min(corners[1]).min(corners[2]), corners[0].max(corners[1]).max(corners[2]));
        if !(least.cmple(high) & most.cmpge(low)).all() {
            continue;
        }
        for (met, (_, line)) in through.iter_mut().zip(&lines) {
            *met |= goes_through(*line, corners);
        }
    }
    lines.iter().zip(through).filter(|(_, met)| *met).map(|((name, _), _)| *name).collect()
}

/// Whether a line between two points goes through a triangle (Möller and Trumbore, 1997).
fn goes_through([from, to]: [DVec3; 2], [a, b, c]: [DVec3; 3]) -> bool {
    let (along, ab, ac) = (to - from, b - a, c - a);
    let across = along.cross(ac);
    let volume = ab.dot(across);
    if volume.abs() < 1e-15 {
        return false;
    }
    let u = (from - a).dot(across) / volume;
    let turned = (from - a).cross(ab);
    let v = along.dot(turned) / volume;
    let t = ac.dot(turned) / volume;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

/// Whether the place around a person is closed: a small one, with no robot in it.
fn shut_in(truth: &Truth, person: &ObjectVoxels) -> Option<String> {
    let mut own = BitGrid::new(truth.grid.window());
    own.add(&person.voxels);
    let mut open = BitGrid::full(truth.grid.window());
    open.remove(&truth.blockers);
    let all = open.count();
    let place = flood(&open, &with_neighbours(&own));
    let is_closed =
        place.count() as f64 <= SMALL * all as f64 && !with_neighbours(&place).intersects(&truth.robot);
    is_closed.then(|| "is shut up in a closed body: move one of them".into())
}

/// How far a person is above whatever is below, or above the grid's floor.
fn floats(truth: &Truth, person: &ObjectVoxels) -> Option<String> {
    let mut lowest: BTreeMap<[i32; 2], i32> = BTreeMap::new();
    for [x, y, z] in person.voxels.voxels() {
        let low = lowest.entry([x, y]).or_insert(z);
        *low = z.min(*low);
    }
    let others = || truth.objects.iter().map(AsRef::as_ref).filter(|other| !std::ptr::eq(*other, person));
    let soles = person.voxels.bounds().min[2];
    // What ends on a border of voxels shares the layer of the soles.
    let touches = |[x, y]: [i32; 2]| others().any(|other| other.voxels.get([x, y, soles]));
    let gap = |([x, y], low): (&[i32; 2], &i32)| {
        if *low == soles && touches([*x, *y]) {
            return 0;
        }
        (0..*low).rev().take_while(|z| !truth.occupied.get([*x, *y, *z])).count() as i32
    };
    let gap = lowest.iter().map(gap).min()?;
    let gap_m = f64::from(gap) * truth.grid.voxel_size_m;
    (gap >= APPARENT_VOXELS && gap_m > STEP_M).then(|| {
        format!(
            "floats {gap_m:.2} m above all that is below: lower its position_m, or model what it stands on"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_goes_through_a_triangle_or_beside_it() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let line =
            |x: f64, y: f64, low: f64, high: f64| [DVec3::new(x, y, low), DVec3::new(x + 0.1, y, high)];
        assert!(goes_through(line(0.2, 0.2, -1.0, 1.0), triangle));
        assert!(goes_through(line(0.2, 0.2, 1.0, -1.0), triangle), "from the other side");
        assert!(!goes_through(line(0.2, 0.2, 0.1, 1.0), triangle), "ends before it");
        assert!(!goes_through(line(0.9, 0.9, -1.0, 1.0), triangle), "beside it");
        assert!(!goes_through([DVec3::X, DVec3::Y], triangle), "along its edge");
    }
}
