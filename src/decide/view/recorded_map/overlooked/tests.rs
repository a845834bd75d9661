//! The missed voxels of a map, by hand in a corridor, and in random cells compared with a plain search from voxel to
//! voxel.

use super::*;
use crate::view::why::tests::proof::{CaseRandom, random_ring, random_scene, random_study};
use crate::view::why::tests::ready;
use perirobot_scene::recording::{Anchor, Recording};

const FREE: u8 = 0;
const OCCUPIED: u8 = 1;
const UNKNOWN: u8 = 255;

/// A corridor of 10 × 3 × 3 voxels of a metre, with walls two voxels thick at x = 3 and 4 and a box at 7.
const CORRIDOR: &str = "[grid]\nvoxel_size_m = 1\nbounds_m = { min = [0, 0, 0], max = [9.5, 2.5, 2.5] }\n\
    [[scene]]\nfile = \"cell.toml\"\n\
    [[region]]\nname = \"all\"\nbox = { min_m = [0, 0, 0], max_m = [10, 3, 3] }\n\
    [[region]]\nname = \"half\"\nbox = { min_m = [5, 0, 0], max_m = [10, 3, 3] }\n\
    [[sensor]]\nname = \"camera\"\nkind = \"rgbd\"\nfov_deg = [60, 60]\nresolution_px = [8, 8]\nrange_m = [0, 9]\n\
    [[sensor.poses]]\nname = \"p\"\nlist = [{ position_m = [0.5, 1.5, 1.5], facing = [1, 0, 0] }]\n";
const BOXES: &str = "interior = \"free\"\n\
    [[object]]\nname = \"wall\"\nbox = { size_m = [0.5, 0.5, 0.5] }\nposition_m = [3.5, 1.5, 1.5]\n\
    [[object]]\nname = \"wall, behind\"\nbox = { size_m = [0.5, 0.5, 0.5] }\nposition_m = [4.5, 1.5, 1.5]\n\
    [[object]]\nname = \"box\"\nbox = { size_m = [0.5, 0.5, 0.5] }\nposition_m = [7.5, 1.5, 1.5]\n";

/// The missed voxels in the corridor for these labels at x along its middle; `FREE` elsewhere.
fn overlooked_in_corridor(said: &[(i32, u8)], places: &[[f64; 3]]) -> Vec<(&'static str, String, Vec<i32>)> {
    let (study, worlds) = ready(CORRIDOR, BOXES, &[]);
    let label = |[x, y, z]: [usize; 3]| {
        let here = said.iter().find(|(at, _)| [*at, 1, 1] == [x as i32, y as i32, z as i32]);
        here.map_or(FREE, |(_, label)| *label)
    };
    let recording = Recording::from_labels([10, 3, 3], &label, DVec3::ZERO, 1.0).unwrap();
    let mut map = RecordedMap::new(&study, &worlds[0], recording, Anchor::new(DVec3::ZERO, 0.0)).unwrap();
    map.places_m = places.iter().map(|place| DVec3::from_array(*place)).collect();
    let view = map.view().unwrap();
    let name = |object: Option<usize>| object.map_or("", |index| &view.truth.objects[index].name).to_string();
    let missed_voxels =
        map.find_overlooked(&view).into_iter().map(|Overlooked { reason, object, voxels }| {
            (reason.name(), name(object), voxels.voxels().map(|[x, ..]| x).collect())
        });
    missed_voxels.collect()
}

#[test]
fn each_reason_in_a_corridor() {
    let found = |reason: &'static str, object: &str, at: &[i32]| (reason, object.to_string(), at.to_vec());
    let (nothing, all) =
        ([(3, UNKNOWN), (4, UNKNOWN), (7, UNKNOWN)], [(3, OCCUPIED), (4, OCCUPIED), (7, OCCUPIED)]);
    assert_eq!(overlooked_in_corridor(&all, &[]), []);
    assert_eq!(overlooked_in_corridor(&nothing, &[]), [found("not_measured", "", &[3, 4, 7])]);
    // From the near end, inside and outside the grid, the first voxel of the wall is in sight.
    for near in [[0.5, 1.5, 1.5], [-5.5, 1.5, 1.5], [3.5, 1.5, 1.5]] {
        let expected = match near[0] < 3.0 {
            true => vec![found("hidden", "wall", &[4, 7]), found("not_measured", "", &[3])],
            // From inside the wall, nothing is in front of the voxel behind.
            false => vec![found("hidden", "wall, behind", &[7]), found("not_measured", "", &[3, 4])],
        };
        assert_eq!(overlooked_in_corridor(&nothing, &[near]), expected, "{near:?}");
    }
    // From both ends only the middle is hidden from all; the first place determines the object.
    let ends = [[0.5, 1.5, 1.5], [9.5, 1.5, 1.5]];
    assert_eq!(
        overlooked_in_corridor(&nothing, &ends),
        [found("hidden", "wall", &[4]), found("not_measured", "", &[3, 7])]
    );
    let [near, far] = ends;
    assert_eq!(overlooked_in_corridor(&nothing, &[far, near])[0], found("hidden", "box", &[4]));
    // A voxel in front of the wall is labelled occupied: it counts as the wall's, even if the wall is hidden. A
    // correctly labelled voxel does not affect the unknown one behind it, but shows that the object of a free neighbour
    // is in the map.
    assert_eq!(
        overlooked_in_corridor(&[(2, OCCUPIED), (3, UNKNOWN), (4, OCCUPIED), (7, OCCUPIED)], &[near]),
        [found("beside", "", &[3])]
    );
    assert_eq!(
        overlooked_in_corridor(&[(3, OCCUPIED), (4, UNKNOWN), (7, FREE)], &[near]),
        [found("said_free", "", &[7]), found("hidden", "wall", &[4])]
    );
    assert_eq!(
        overlooked_in_corridor(&[(3, FREE), (4, OCCUPIED), (7, OCCUPIED)], &[near]),
        [found("beside", "", &[3])]
    );
}

/// Why a voxel is missed, by single steps; shares only the stepping of rays with the tested code.
fn plain(
    view: &View,
    label: &dyn Fn([i32; 3]) -> u8,
    places: &[[f64; 3]],
    [x, y, z]: [i32; 3],
) -> (Oversight, Option<usize>) {
    let truth = &view.truth;
    let is_free = label([x, y, z]) == FREE;
    let (mut marked, mut wrongly) = (false, false);
    for near in (0..27).map(|n| [x + n % 3 - 1, y + n / 3 % 3 - 1, z + n / 9 - 1]) {
        let is_occupied = label(near) == OCCUPIED;
        marked |= is_occupied;
        wrongly |= is_occupied && !truth.occupied.get(near);
    }
    if wrongly || is_free && marked {
        return (Oversight::Beside, None);
    }
    if is_free {
        return (Oversight::SaidFree, None);
    }
    let mut hider = None;
    for place in places {
        // Places are in voxels, of which 1/16 is exact.
        let way = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5 - DVec3::from_array(*place);
        let direction = way.normalize().to_array().map(|v| (v * 65536.0).round() as i32);
        let mut at = march::start(place.map(|p| (p * 65536.0) as i32), direction);
        let mut hit = None;
        while at.voxel != [x, y, z] && hit.is_none() {
            let axis = march::next_axis(at.next_q16);
            march::cross(&mut at, axis);
            hit = truth.blockers.get(at.voxel).then_some(at.voxel);
        }
        match hit.filter(|hit| *hit != [x, y, z]) {
            None => return (Oversight::NotMeasured, None),
            Some(hit) => hider = hider.or(Some(hit)),
        }
    }
    let Some(hider) = hider else { return (Oversight::NotMeasured, None) };
    let object = truth.objects.iter().position(|object| object.stops_rays && object.voxels.get(hider));
    (Oversight::Hidden, object)
}

#[test]
fn in_random_cells_reasons_are_those_of_a_plain_search() {
    let only_seed = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    let mut met = [0; 4];
    for seed in only_seed.map_or(0..24, |seed: u32| seed..seed + 1) {
        let random = &mut CaseRandom(seed);
        let (scene, ring) = (random_scene(random), random_ring(random));
        let (study, worlds) = ready(&random_study(random), &scene, &[("ring.csv", ring)]);
        let world = &worlds[0];
        let (truth, grid) = (world.truth(), world.grid);
        let size = grid.size.map(|n| n as i32);
        let [wide, deep, high] = size;
        // A mostly correct map with few labels.
        let share = 2 + random.number_below(20);
        let labels: Vec<u8> = (0..wide * deep * high)
            .map(|n| {
                let is_there = truth.occupied.get([n % wide, n / wide % deep, n / wide / deep]);
                match random.number_below(share) {
                    0 if random.number_below(8) == 0 => OCCUPIED,
                    0 => FREE,
                    1 if is_there => OCCUPIED,
                    _ => UNKNOWN,
                }
            })
            .collect();
        let label = |voxel: [i32; 3]| match (0..3).all(|r| (0..size[r]).contains(&voxel[r])) {
            true => labels[(voxel[0] + wide * (voxel[1] + deep * voxel[2])) as usize],
            false => UNKNOWN,
        };
        let places: Vec<[f64; 3]> = (0..random.number_below(4))
            .map(|_| size.map(|n| f64::from(random.number_below(16 * n as u32 - 1) + 1) / 16.0 + 1.0 / 64.0))
            .collect();
        let corner_m = grid.corner_m([0; 3]);
        let recording = Recording::from_labels(
            grid.size.map(|n| n as usize),
            &|voxel| label(voxel.map(|n| n as i32)),
            corner_m,
            grid.voxel_size_m,
        );
        let mut map =
            RecordedMap::new(&study, world, recording.unwrap(), Anchor::new(DVec3::ZERO, 0.0)).unwrap();
        map.places_m =
            places.iter().map(|place| corner_m + DVec3::from_array(*place) * grid.voxel_size_m).collect();
        let view = map.view().unwrap();
        let missed_voxels = map.find_overlooked(&view);
        let missed: u64 = (0..view.world.regions.len())
            .map(|region| {
                let counts = view.counts(region);
                let of_region =
                    missed_voxels.iter().map(|one| one.count(&[&view.world.regions[region].voxels]));
                assert_eq!(of_region.sum::<u64>(), counts.fn_ + counts.uo, "seed {seed}, region {region}");
                counts.fn_ + counts.uo
            })
            .sum();
        assert!(missed > 0);
        for Overlooked { reason, object, voxels } in &missed_voxels {
            for voxel in voxels.voxels() {
                let expected = plain(&view, &label, &places, voxel);
                assert_eq!(
                    (*reason, *object),
                    expected,
                    "voxel {voxel:?} from {places:?}; rerun: PERIROBOT_CASE={seed} cargo test --lib view::recorded"
                );
                met[*reason as usize] += 1;
            }
        }
    }
    assert!(only_seed.is_some() || met.iter().all(|&count| count > 100), "{met:?}");
}
