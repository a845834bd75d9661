//! Explains a difference: the ray that ended elsewhere, or the marked voxel and its ray.

use super::EvidenceAndCounts;
use perirobot_march::Result;
use perirobot_march::backend::oracle::Oracle;
use perirobot_march::backend::{Backend, Evidence, GridPose, Rays, VoxelScene};
use perirobot_march::march::{self, End};
use perirobot_march::metrics::Confusion;

/// Names the ray and the voxel of the first difference of a pose.
pub(super) fn explain(
    scene: &VoxelScene,
    rays: &Rays,
    placement: &GridPose,
    (expected, counts): EvidenceAndCounts,
    (got, found): EvidenceAndCounts,
) -> Result<String> {
    let differs = |(_, (a, b)): &(usize, (&End, &End))| a != b;
    if let Some((ray, (a, b))) = expected.ends.iter().zip(&got.ends).enumerate().find(differs) {
        let dir = rays.dirs_q15[ray];
        let describe = |end: &End| {
            let kind = match end.kind {
                march::RETURN => "a return",
                march::BLIND => "blind",
                march::LEFT => "a return outside",
                march::NOTHING => "nothing",
                _ => "no known end",
            };
            format!(
                "{kind} in voxel {:?} after {} crossings",
                voxel_after(placement, dir, end.crossings),
                end.crossings
            )
        };
        return Ok(format!(
            "ray {ray} (direction {dir:?}) ended as {}, expected {}",
            describe(b),
            describe(a)
        ));
    }
    if expected.ends.len() != got.ends.len() {
        return Ok(format!("{} rays ended, expected {}", got.ends.len(), expected.ends.len()));
    }
    let planes = expected.planes.planes_with_names().into_iter().zip(got.planes.planes_with_names());
    for (number, ((plane, a), (_, b))) in planes.enumerate() {
        let (mut only_a, mut only_b) = (a.clone(), b.clone());
        only_a.remove(b);
        only_b.remove(a);
        let lost = only_a.voxels().next().map(|v| (v, "is missing from"));
        if let Some((voxel, what)) = lost.or(only_b.voxels().next().map(|v| (v, "should not be in"))) {
            let ray =
                marking_ray(scene, rays, placement, |e| e.planes.planes_with_names()[number].1.get(voxel))?;
            let ray = ray.map_or("the oracle's rays do not mark it".into(), |r| {
                format!("ray {r} is the first that marks it")
            });
            return Ok(format!("voxel {voxel:?} {what} the {plane} plane; {ray}"));
        }
    }
    let unequal = counts.iter().zip(found).position(|(a, b)| a != b);
    let region = unequal.unwrap_or(counts.len().min(found.len()));
    let numbers = |all: &[Confusion]| all.get(region).map(Confusion::numbers).unwrap_or_default();
    Ok(format!(
        "all rays and planes agree, the counts of region {region} (from 0) do not: {:?}, expected {:?} (tp fp fn tn uo uf, \
         then tp fn uo of people and of the robot, then hits of people, people, people detected, parts, parts detected, each part missed, then voxels labelled twice and hits of people twice)",
        numbers(found),
        numbers(counts)
    ))
}

/// The voxel of a ray after this many crossings.
fn voxel_after(placement: &GridPose, dir_q15: [i32; 3], crossings: u32) -> [i32; 3] {
    march::voxel_after(placement.launch(dir_q15), crossings)
}

/// The first ray with which the oracle's evidence has a mark. Marks only grow with the rays, so bisection finds it.
fn marking_ray(
    scene: &VoxelScene,
    rays: &Rays,
    placement: &GridPose,
    marked: impl Fn(&Evidence) -> bool,
) -> Result<Option<usize>> {
    let mut oracle = Oracle::default();
    let mut marked_by = |first: usize| -> Result<bool> {
        oracle.tables(&[Rays { dirs_q15: rays.dirs_q15[..first].to_vec().into(), ..rays.clone() }])?;
        oracle.load(scene)?;
        Ok(marked(&oracle.read(0, placement)?))
    };
    let (mut without, mut with) = (0, rays.dirs_q15.len());
    if !marked_by(with)? {
        return Ok(None);
    }
    while with - without > 1 {
        let middle = (without + with) / 2;
        if marked_by(middle)? { with = middle } else { without = middle }
    }
    Ok(Some(without))
}
