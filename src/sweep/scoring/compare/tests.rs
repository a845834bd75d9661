//! A backend with one false value must be found, and the place named.

use super::*;
use perirobot_march::backend::{Planes, Slot, cpu::Cpu};
use perirobot_march::march::{End, NOTHING};
use perirobot_study::input::Overrides;

/// One false value per pose.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Lie {
    None,
    Occupied([i32; 3]),
    Free([i32; 3]),
    Hits([i32; 3]),
    Count,
    Detection,
    Overlap,
    End(usize),
    FewerEnds,
    FewerRegions,
    FewerPoses,
}

/// The CPU, except for the false value.
pub(crate) struct Liar(pub(crate) Cpu, pub(in crate::scoring) Lie);

impl Backend for Liar {
    fn name(&self) -> &'static str {
        "liar"
    }
    fn device(&self) -> String {
        self.0.device()
    }
    fn tables(&mut self, tables: &[Rays]) -> Result<()> {
        self.0.tables(tables)
    }
    fn load(&mut self, scene: &VoxelScene) -> Result<()> {
        self.0.load(scene)
    }
    fn slots(&self) -> usize {
        2
    }
    fn sense(&mut self, table: usize, shots: &[Shot]) -> Result<()> {
        self.0.sense(table, shots)
    }
    fn upload(&mut self, evidence: Vec<(Slot, Planes)>) -> Result<()> {
        self.0.upload(evidence)
    }
    fn first_hit_slots(&self) -> usize {
        0
    }
    fn submit(&mut self, fusion: Fusion, jobs: &[Vec<Reading>]) -> Result<()> {
        self.0.submit(fusion, jobs)
    }
    fn receive(&mut self) -> Result<Vec<Vec<Confusion>>> {
        let mut counts = self.0.receive()?;
        match self.1 {
            Lie::Count => counts[0][1].human.uo += 1,
            Lie::Detection => counts[0][1].detection.parts_detected += 1,
            Lie::Overlap => counts[0][1].overlap.twice += 1,
            Lie::FewerRegions => counts.iter_mut().for_each(|regions| regions.truncate(1)),
            Lie::FewerPoses => counts.truncate(1),
            _ => {}
        }
        Ok(counts)
    }
    fn planes(&mut self, slots: &[Slot]) -> Result<Vec<Planes>> {
        self.0.planes(slots)
    }
    fn read(&mut self, table: usize, placement: &GridPose) -> Result<Evidence> {
        let mut evidence = self.0.read(table, placement)?;
        let flip = |plane: &mut BitGrid, voxel| {
            let bit = plane.bit_index(voxel).unwrap();
            plane.words_mut()[bit >> 5] ^= 1 << (bit & 31);
        };
        match self.1 {
            Lie::Occupied(voxel) => flip(&mut evidence.planes.occupied, voxel),
            Lie::Free(voxel) => flip(&mut evidence.planes.free, voxel),
            Lie::Hits(voxel) => flip(&mut evidence.planes.hits, voxel),
            Lie::End(ray) => evidence.ends[ray] = End { kind: NOTHING, crossings: 77 },
            Lie::FewerEnds => evidence.ends.truncate(5),
            _ => {}
        }
        Ok(evidence)
    }
}

pub(crate) fn tiny() -> (Study, World) {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let world = World::prepare(&study, 0).unwrap().remove(0);
    (study, world)
}

/// Compares four poses of the tiny study's camera with the liar.
fn caught(lie: Lie) -> Result<Comparison> {
    let (study, world) = tiny();
    let mut report = Comparison::default();
    let mut backends: Vec<Box<dyn Backend>> = vec![Box::new(Liar(Cpu::new(Some(1))?, lie))];
    compare(&study, &world, 0, &PoseSelection::Spread { number: 4, turn: 0 }, &mut backends, &mut report)?;
    Ok(report)
}

#[track_caller]
fn check(lie: Lie, differences: u64, expected: &[&str]) {
    let report = caught(lie).unwrap();
    assert_eq!(report.lines.iter().map(|line| line.backend).collect::<Vec<_>>(), ["oracle", "liar"]);
    assert_eq!(report.lines[1].differences, differences, "{lie:?}");
    let first = report.first_difference.unwrap_or_default();
    assert_eq!(first.is_empty(), expected.is_empty(), "{first}");
    for fragment in expected {
        assert!(first.contains(fragment), "{lie:?}: no {fragment:?} in {first}");
    }
}

#[test]
fn each_kind_of_lie_is_found_and_named() {
    let place = "scene tiny, pose camera:wall/0/0, liar against the oracle: ";
    // A voxel in front of the first pose that its rays free, and one outside all rays.
    let (study, world) = tiny();
    let mut oracle = Oracle::default();
    oracle.tables(&[perirobot_study::world::ray_tables(&study)[0].clone().unwrap()]).unwrap();
    oracle.load(&world.scene(world.grid.window())).unwrap();
    let placement = world.placement(&study, 0, 0, 0);
    let evidence = oracle.read(0, &placement).unwrap().planes;
    let freed = evidence.free.voxels().next().unwrap();
    let mut seen = evidence.free.clone();
    seen.add(&evidence.occupied);
    let unseen = (0..).map(|x| [x, 0, 0]).find(|&voxel| !seen.get(voxel)).unwrap();

    check(Lie::None, 0, &[]);
    check(
        Lie::Free(freed),
        4,
        &[place, &format!("voxel {freed:?} is missing from the free plane; ray "), "first that marks"],
    );
    let extra =
        format!("voxel {unseen:?} should not be in the occupied plane; the oracle's rays do not mark it");
    check(Lie::Occupied(unseen), 4, &[place, &extra]);
    let extra = format!("voxel {unseen:?} should not be in the hits plane; the oracle's rays do not mark it");
    check(Lie::Hits(unseen), 4, &[place, &extra]);
    // One count in each batch of two poses.
    check(Lie::Count, 2, &[place, "all rays and planes agree, the counts of region 1 (from 0) do not"]);
    check(Lie::Detection, 2, &[place, "all rays and planes agree, the counts of region 1 (from 0) do not"]);
    check(Lie::Overlap, 2, &[place, "all rays and planes agree, the counts of region 1 (from 0) do not"]);
    check(Lie::End(3), 4, &[place, "ray 3 (direction [", "after 77 crossings, expected blind in voxel "]);
    let rays = 64 * 36;
    check(Lie::FewerEnds, 4 * (rays - 5), &[place, "5 rays ended, expected 2304"]);
    check(Lie::FewerRegions, 4 * 30, &[place, "the counts of region 1 (from 0) do not"]);
    assert!(
        caught(Lie::FewerPoses).unwrap_err().to_string().contains("backend liar: answered for 2 of 4 poses")
    );
}

#[test]
fn a_sweep_refuses_a_backend_that_answers_too_little() {
    let (study, world) = tiny();
    for (lie, expected) in [(Lie::FewerPoses, "backend liar"), (Lie::FewerRegions, "backend liar")] {
        let mut liar = Liar(Cpu::new(Some(1)).unwrap(), lie);
        let error = crate::scoring::run(&study, std::slice::from_ref(&world), &mut liar).unwrap_err();
        assert!(error.to_string().contains(expected), "{error}");
    }
}

#[test]
fn poses_are_chosen_evenly_or_by_name() {
    let (study, _) = tiny();
    let camera = &study.sensors[0];
    assert_eq!(camera.candidates.len(), 10);
    let spread = |number, turn| select(&PoseSelection::Spread { number, turn }, camera);
    assert_eq!(spread(4, 0), [0, 2, 5, 7]);
    assert_eq!(spread(4, 4), [1, 4, 6, 9]);
    assert_eq!(spread(99, 7), (0..10).collect::<Vec<_>>());
    assert_eq!(select(&PoseSelection::All, camera), (0..10).collect::<Vec<_>>());
    assert_eq!(select(&PoseSelection::Named("wall/1/1".into()), camera), [3]);
    assert_eq!(select(&PoseSelection::Named("wall/9/9".into()), camera), [0; 0]);
}
