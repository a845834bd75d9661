//! A scene in voxels over all of its snapshots. What each object became is kept; the truth of a snapshot is
//! put together from that when it is asked for, so that a thousand snapshots take little more memory than
//! what moves in them.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use rayon::prelude::*;

use super::objects::{RadarTruth, Truth};
use super::voxelize::{VoxelizedObject, body, bounds_m, distinct_objects};
use crate::objects::{Object, Role, Scene};
use perirobot_march::Result;
use perirobot_march::backend::Shades;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::march::SHADES;
use perirobot_march::progress::Progress;
use perirobot_march::voxel::{BitGrid, Grid};

/// Most memory that the voxels of a scene take. A short scene file can ask for any amount, and a system that
/// runs out of memory kills the program without a message.
const MOST_GIB: u64 = 64;

/// The snapshots of a scene on one grid.
#[derive(Debug)]
pub struct Snapshots {
    grid: Grid,
    bodies: Vec<VoxelizedObject>,
    /// For each snapshot, the body of each of its objects.
    placed: Vec<Vec<usize>>,
    /// For each snapshot, how fast each of its objects moves, in millimetres a second.
    speeds_mm_s: Vec<Vec<Option<u32>>>,
    /// How many truths are kept: those that were asked for last.
    most_kept: usize,
    kept: Mutex<VecDeque<(usize, Arc<Truth>)>>,
    /// What robots and people fill at some moment, once it was asked for.
    swept: [OnceLock<Arc<BitGrid>>; 2],
}

impl Snapshots {
    /// Voxelizes each object once, however many snapshots share it; objects and triangles in parallel. Of the
    /// truths that are asked for, as many are kept as fit so many bytes, and at least one.
    ///
    /// # Errors
    /// `Error::Stopped` before an object; a scene whose voxels would take more than 64 GiB, or than there
    /// is; a surface too far away to count.
    pub fn new(scenes: &[Scene], grid: Grid, kept_bytes: u64, progress: &dyn Progress) -> Result<Snapshots> {
        let objects = distinct_objects(scenes);
        let most_kept = (kept_bytes / bytes_of_truth(&grid)).clamp(1, scenes.len().max(1) as u64) as usize;
        refuse_excess(&objects, most_kept, &grid, free_bytes())?;
        let bodies =
            objects.par_iter().map(|object| progress.check_stop().and_then(|()| body(object, &grid)));
        let bodies: Vec<VoxelizedObject> = bodies.collect::<Result<_>>()?;
        let numbers: HashMap<_, _> = objects.into_iter().map(Arc::as_ptr).zip(0..).collect();
        let placed =
            |scene: &Scene| scene.objects.iter().map(|object| numbers[&Arc::as_ptr(object)]).collect();
        let placed = scenes.iter().map(placed).collect();
        let speeds_mm_s = scenes.iter().map(|scene| scene.speeds_mm_s.clone()).collect();
        let (kept, swept) = Default::default();
        Ok(Snapshots { grid, bodies, placed, speeds_mm_s, most_kept, kept, swept })
    }

    /// How many there are.
    pub(crate) fn count(&self) -> usize {
        self.placed.len()
    }

    /// The truth of one of them.
    pub fn truth(&self, snapshot: usize) -> Arc<Truth> {
        let kept = || self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let known = |kept: &VecDeque<(usize, Arc<Truth>)>| {
            kept.iter().find(|(number, _)| *number == snapshot).map(|(_, truth)| truth.clone())
        };
        if let Some(truth) = known(&kept()) {
            return truth;
        }
        let truth = Arc::new(combine(&self.moving_bodies(snapshot).collect::<Vec<_>>(), self.grid));
        let mut kept = kept();
        // Another thread may have been asked for the same.
        if let Some(truth) = known(&kept) {
            return truth;
        }
        if kept.len() == self.most_kept {
            kept.pop_front();
        }
        kept.push_back((snapshot, truth.clone()));
        truth
    }

    /// All that the objects of a role fill at some moment, robots with the inside of their bodies.
    pub fn swept(&self, role: Role) -> Arc<BitGrid> {
        let fill = || {
            let mut all = BitGrid::new(self.grid.window());
            for body in self.bodies.iter().filter(|body| body.voxels.role == role) {
                all.add(&body.voxels.voxels);
                all.add(&body.inside);
            }
            Arc::new(all.trim())
        };
        self.swept[usize::from(role == Role::Human)].get_or_init(fill).clone()
    }

    /// The truth of one of them if there were no objects of a role.
    pub fn truth_without(&self, snapshot: usize, role: Role) -> Truth {
        let bodies = self.moving_bodies(snapshot).filter(|(body, _)| body.voxels.role != role);
        combine(&bodies.collect::<Vec<_>>(), self.grid)
    }

    /// The bodies of a snapshot, and how fast each moves.
    fn moving_bodies(&self, snapshot: usize) -> impl Iterator<Item = (&VoxelizedObject, Option<u32>)> {
        let speeds = self.speeds_mm_s[snapshot].iter().copied().chain(std::iter::repeat(None));
        self.placed[snapshot].iter().map(|&number| &self.bodies[number]).zip(speeds)
    }
}

/// The truth of each snapshot of a scene on one grid: [`Snapshots`], all of them at once.
///
/// # Errors
/// As those.
pub fn voxelize_all(snapshots: &[Scene], grid: Grid) -> Result<Vec<Truth>> {
    let all = Snapshots::new(snapshots, grid, 0, &|| None)?;
    Ok((0..all.count()).map(|snapshot| Truth::clone(&all.truth(snapshot))).collect())
}

/// Two planes over the whole grid; what else a truth has is small.
fn bytes_of_truth(grid: &Grid) -> u64 {
    (grid.window().volume() / 4).max(1)
}

/// Counts a bit for each voxel in the box around an object, and what so many truths take. `free` is how much
/// memory there is.
fn refuse_excess(objects: &[&Arc<Object>], truths: usize, grid: &Grid, free: Option<u64>) -> Result<()> {
    let around = |object: &&Arc<Object>| -> f64 {
        let [low, high] = bounds_m(object);
        let size = ((high - low) / grid.voxel_size_m + 1.0).to_array();
        (0..3).map(|axis| size[axis].clamp(0.0, f64::from(grid.size[axis]))).product()
    };
    let bytes = truths as f64 * bytes_of_truth(grid) as f64 + objects.iter().map(around).sum::<f64>() / 8.0;
    let gib = |bytes: f64| bytes / (1u64 << 30) as f64;
    let (taken, free) = (gib(bytes), free.map(|bytes| gib(bytes as f64)));
    let than = match free {
        _ if taken > MOST_GIB as f64 => format!("than {MOST_GIB}"),
        Some(free) if taken > free => format!("than the {free:.1} that are free"),
        _ => return Ok(()),
    };
    let what = format!(
        "the voxels of {} objects, each counted again where it has moved, take {taken:.1} GiB, more {than}",
        objects.len()
    );
    let cure = Words::from("take larger voxels (")
        + Argument("voxel size")
        + "), set bounds_m around the part that matters, or split the scene";
    Err(Issue::too_large(what).with_advice(cure).into())
}

/// The memory that there is for this program, where the system tells: what is free, and what its control
/// group may have.
fn free_bytes() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let number = |text: &str| text.trim().parse::<u64>().ok();
    let machine = read("/proc/meminfo").and_then(|all| {
        let line = all.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        Some(number(line.trim().trim_end_matches("kB"))? << 10)
    });
    let group = read("/sys/fs/cgroup/memory.max").and_then(|text| number(&text));
    machine.into_iter().chain(group).min()
}

/// The truth of what these bodies are together, each with its speed.
fn combine(moving: &[(&VoxelizedObject, Option<u32>)], grid: Grid) -> Truth {
    let bodies: Vec<&VoxelizedObject> = moving.iter().map(|(body, _)| *body).collect();
    let blank = || BitGrid::new(grid.window());
    let (mut occupied, mut blockers, mut ignored) = (blank(), blank(), blank());
    let (mut human, mut robot, mut robot_volume) = (blank(), blank(), blank());
    for VoxelizedObject { voxels, ignored: hidden, inside, is_there, .. } in &bodies {
        if *is_there {
            occupied.add(&voxels.voxels);
            if voxels.stops_rays {
                blockers.add(&voxels.voxels);
            }
            ignored.add(hidden);
        }
        match voxels.role {
            Role::Environment => {}
            Role::Robot => {
                robot.add(&voxels.voxels);
                robot_volume.add(&voxels.voxels);
                robot_volume.add(inside);
            }
            Role::Human => human.add(&voxels.voxels),
        }
    }
    ignored.remove(&occupied);
    let objects = bodies.iter().map(|body| body.voxels.clone()).collect();
    let [ignored, human, robot, robot_volume] =
        [ignored, human, robot, robot_volume].map(|plane| plane.trim());
    let all_block = blockers == occupied;
    let occupied = Arc::new(occupied);
    let blockers = if all_block { occupied.clone() } else { Arc::new(blockers) };
    let shades = shades(&bodies, &grid).map(Arc::new);
    let speeds_mm_s = moving.iter().map(|(_, speed)| *speed).collect();
    let radar = RadarTruth { blockers: radar_blockers(&bodies, &occupied), speeds_mm_s };
    Truth { grid, occupied, blockers, radar, shades, ignored, human, robot, robot_volume, objects }
}

/// What stops radar.
fn radar_blockers(bodies: &[&VoxelizedObject], occupied: &Arc<BitGrid>) -> Arc<BitGrid> {
    let there = || bodies.iter().filter(|body| body.is_there);
    if there().all(|body| body.voxels.stops_radar) {
        return occupied.clone();
    }
    let mut blockers = BitGrid::new(occupied.window());
    there().filter(|body| body.voxels.stops_radar).for_each(|body| blockers.add(&body.voxels.voxels));
    Arc::new(blockers)
}

/// How dark the voxels of these bodies are, if any is: where several share one, as the darkest of them.
fn shades(bodies: &[&VoxelizedObject], grid: &Grid) -> Option<Shades> {
    // A tag darkens what is there.
    let is_dark = |body: &&&VoxelizedObject| body.shade > 0 && (body.voxels.stops_rays || !body.is_there);
    bodies.iter().find(is_dark)?;
    let mut bits = std::array::from_fn(|_| BitGrid::new(grid.window()));
    // From the brightest to the darkest, each in place of what was there.
    for shade in (1..=SHADES).rev() {
        for body in bodies.iter().filter(is_dark).filter(|body| usize::from(body.shade) == shade) {
            for (place, plane) in bits.iter_mut().enumerate() {
                match shade >> place & 1 != 0 {
                    true => plane.add(&body.voxels.voxels),
                    false => plane.remove(&body.voxels.voxels),
                }
            }
        }
    }
    Some(Shades { bits })
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::objects::{Interior, Optical, Surface, primitive};
    use perirobot_march::Error;

    fn object(name: &str, at: DVec3) -> Arc<Object> {
        let mut mesh = primitive::cuboid(DVec3::splat(0.3));
        mesh.vertices.iter_mut().for_each(|vertex| *vertex += at);
        Arc::new(Object {
            name: name.into(),
            role: Role::Robot,
            interior: Interior::Ignored,
            optical: Optical::Opaque,
            radar: Default::default(),
            shade: 0,
            tag_only: false,
            takes_unit: false,
            surface: Surface::Mesh(mesh),
            frame: crate::pose::Pose::ORIGIN,
            keypoints: None,
            linkage: None,
            warnings: Vec::new(),
        })
    }

    /// A cube that stands and one that walks along x, a voxel a snapshot.
    fn walk(snapshots: usize) -> (Vec<Scene>, Grid) {
        let stands = object("stands", DVec3::splat(0.5));
        let scene = |snapshot| Scene {
            name: "walk".into(),
            snapshot,
            objects: vec![stands.clone(), object("walks", DVec3::new(0.1 * snapshot as f64, 1.5, 0.5))],
            speeds_mm_s: vec![None, Some(snapshot as u32)],
        };
        let grid = Grid { voxel_size_m: 0.1, origin: [-2; 3], size: [64; 3] };
        ((0..snapshots).map(scene).collect(), grid)
    }

    #[test]
    fn a_truth_that_was_dropped_is_put_together_again_the_same() {
        let (scenes, grid) = walk(5);
        let of = |bytes| Snapshots::new(&scenes, grid, bytes, &|| None).unwrap();
        let (few, all) = (of(2 * bytes_of_truth(&grid)), of(u64::MAX));
        assert_eq!((few.most_kept, all.most_kept, few.count()), (2, 5, 5));
        let first = few.truth(0);
        for snapshot in [0, 1, 2, 3, 4, 0, 4] {
            let (ours, theirs) = (few.truth(snapshot), all.truth(snapshot));
            assert_eq!((&ours.occupied, &ours.robot_volume), (&theirs.occupied, &theirs.robot_volume));
            assert!(few.kept.lock().unwrap().len() <= 2);
            assert!(Arc::ptr_eq(&few.truth(snapshot), &ours), "what was asked for last is kept");
        }
        assert!(!Arc::ptr_eq(&first, &few.truth(0)) && Arc::ptr_eq(&all.truth(2), &all.truth(2)));
    }

    #[test]
    fn more_voxels_than_any_memory_holds_are_refused_before_they_are_made() {
        let mesh = primitive::cuboid(DVec3::splat(10.0));
        let cube =
            Arc::new(Object { surface: Surface::Mesh(mesh), ..(*object("cube", DVec3::ZERO)).clone() });
        // 2³⁰ voxels, a quarter of a GiB a truth, and a box of 101³ around the cube.
        let grid = Grid { voxel_size_m: 0.1, origin: [0; 3], size: [1024; 3] };
        refuse_excess(&[&cube], 255, &grid, None).unwrap();
        let what = refuse_excess(&[&cube], 256, &grid, None).unwrap_err().to_string();
        assert!(what.contains("of 1 objects") && what.contains("64.0 GiB, more than 64:"), "{what}");
        // Nor more than there is.
        refuse_excess(&[&cube], 7, &grid, Some(2 << 30)).unwrap();
        let what = refuse_excess(&[&cube], 8, &grid, Some(2 << 30)).unwrap_err().to_string();
        assert!(what.contains("take 2.0 GiB, more than the 2.0 that are free: take larger voxels"), "{what}");
        // Whatever sticks out of the grid takes nothing.
        let fine = Grid { voxel_size_m: 0.001, ..grid };
        refuse_excess(&[&cube; 511], 0, &fine, None).unwrap();
        let what = refuse_excess(&[&cube; 513], 0, &fine, None).unwrap_err().to_string();
        assert!(what.contains("of 513 objects"), "{what}");
        // However many snapshots there are, few truths are kept.
        let (scenes, grid) = walk(2000);
        let few = Snapshots::new(&scenes, grid, 3 * bytes_of_truth(&grid), &|| None).unwrap();
        (0..2000).for_each(|snapshot| drop(few.truth(snapshot)));
        assert_eq!(few.kept.lock().unwrap().len(), 3);
    }

    /// Nothing is begun of a scene that does not fit, nor an object once there is a reason to stop.
    #[test]
    fn before_each_object_it_is_asked_whether_to_go_on() {
        use std::sync::atomic::{AtomicUsize, Ordering};
        let (scenes, grid) = walk(5);
        let until = |last: usize| {
            let asked = AtomicUsize::new(0);
            let stop = || (asked.fetch_add(1, Ordering::Relaxed) >= last).then(|| "enough".into());
            Snapshots::new(&scenes, grid, 0, &stop).map(|all| all.count())
        };
        for last in 0..6 {
            assert!(
                matches!(until(last), Err(Error::Stopped(_))),
                "one that stands and five that walk: {last}"
            );
        }
        assert!(matches!(until(6), Ok(5)));
        let (scenes, _) = walk(300);
        let large = Grid { size: [1024; 3], ..grid };
        let begun = Snapshots::new(&scenes, large, u64::MAX, &|| Some("begun".into()));
        assert!(
            matches!(&begun, Err(Error::Input(what)) if what.to_string().contains("GiB, more than")),
            "{begun:?}"
        );
    }
}
