//! A radar in cells small enough to count by hand, and against a plain computation in random ones.

use std::collections::HashSet;

use super::*;
use crate::sensor::noise::Deviation;
use crate::sensor::range::{Along, ReflectanceRanges};
use crate::sensor::tests::{Says, block, empty, facing, put, says};
use perirobot_march::backend::Planes;
use perirobot_march::march::pcg;
use perirobot_scene::truth::RadarTruth;

fn radar(fov_deg: [f64; 2], range_m: [f64; 2]) -> Radar {
    Radar {
        fov_rad: fov_deg.map(f64::to_radians),
        range: Range {
            range_m,
            along: Along::Ray,
            near_ignore_m: 0.0,
            no_return_is_free: true,
            noise: Deviation::NONE,
            dropout: 0.0,
            calibration: None,
            reflectance: ReflectanceRanges::NONE,
        },
        min_speed_mm_s: 100,
        otherwise_free: true,
    }
}

/// A tube of one voxel across: a narrow fan from the middle of voxel (0, 1, 1) along x, to the end of voxel 6.
fn tube() -> Radar {
    radar([1.0, 1.0], [0.0, 6.4])
}

fn tube_cell() -> Truth {
    empty([9, 3, 3], 1.0)
}

/// What it says, and what it feels.
fn reads(radar: &Radar, truth: &Truth) -> (Says, Vec<[i32; 3]>) {
    let at = facing(truth, [0.5, 1.5, 1.5], [1.0, 0.0, 0.0]);
    let planes = radar.claims(&at).remove(0).planes;
    let felt = planes.map_or(Vec::new(), |planes| planes.hits.voxels().collect());
    (says(radar, 0, &at), felt)
}

fn along(from: i32, to: i32) -> Vec<[i32; 3]> {
    block([from, 1, 1], [to, 1, 1])
}

fn put_moving(truth: &mut Truth, role: Role, x: i32, speed_mm_s: Option<u32>) {
    put(truth, role, &[[x, 1, 1]], None);
    truth.radar.speeds_mm_s.resize(truth.objects.len() - 1, None);
    truth.radar.speeds_mm_s.push(speed_mm_s);
}

#[test]
fn whoever_moves_fast_enough_switches_the_field() {
    let field = along(1, 6);
    for (role, speed, felt) in [
        (Role::Human, Some(100), Some(vec![[4, 1, 1]])),
        (Role::Human, Some(1600), Some(vec![[4, 1, 1]])),
        (Role::Human, Some(99), None),
        (Role::Human, Some(0), None),
        (Role::Human, None, None),
        (Role::Robot, Some(250), Some(vec![])),
        (Role::Environment, Some(250), Some(vec![])),
    ] {
        let mut truth = tube_cell();
        put_moving(&mut truth, role, 4, speed);
        let expected = match felt {
            // What stands behind hides nothing that is before it: the field ends with what stops it.
            Some(felt) => (Says::Occupied(along(1, 4)), felt),
            None => (Says::Free(along(1, 4)), Vec::new()),
        };
        assert_eq!(reads(&tube(), &truth), expected, "{role:?} {speed:?}");
    }
    assert_eq!(reads(&tube(), &tube_cell()), (Says::Free(field), Vec::new()));
    assert_eq!(reads(&Radar { otherwise_free: false, ..tube() }, &tube_cell()).0, Says::Nothing);
}

#[test]
fn what_stands_still_ends_the_field_and_is_none_of_it() {
    for role in [Role::Environment, Role::Robot] {
        let mut truth = tube_cell();
        put_moving(&mut truth, role, 3, None);
        put_moving(&mut truth, Role::Human, 5, Some(1000));
        assert_eq!(reads(&tube(), &truth), (Says::Free(along(1, 2)), Vec::new()), "{role:?}");
    }
    // A person who stands still hides one who walks, and is part of the field.
    let mut truth = tube_cell();
    put_moving(&mut truth, Role::Human, 3, Some(0));
    put_moving(&mut truth, Role::Human, 5, Some(1000));
    assert_eq!(reads(&tube(), &truth), (Says::Free(along(1, 3)), Vec::new()));
    let still_too = Radar { min_speed_mm_s: 0, ..tube() };
    assert_eq!(reads(&still_too, &truth), (Says::Occupied(along(1, 3)), vec![[3, 1, 1]]));
}

/// With 0 it detects people who stand still, and no things that do.
#[test]
fn walls_never_move() {
    let still_too = Radar { min_speed_mm_s: 0, ..tube() };
    for speed in [None, Some(0)] {
        let mut truth = tube_cell();
        put_moving(&mut truth, Role::Environment, 3, speed);
        assert_eq!(reads(&still_too, &truth), (Says::Free(along(1, 2)), Vec::new()));
    }
}

#[test]
fn it_looks_through_what_radar_passes_and_light_does_not() {
    let mut truth = tube_cell();
    put_moving(&mut truth, Role::Environment, 3, None);
    put_moving(&mut truth, Role::Human, 5, Some(1000));
    let curtain = truth.objects[0].voxels.clone();
    let mut blockers = BitGrid::clone(&truth.radar.blockers);
    blockers.remove(&curtain);
    let truth = Truth { radar: RadarTruth { blockers: blockers.into(), ..truth.radar }, ..truth };
    assert_eq!(reads(&tube(), &truth), (Says::Occupied(along(1, 5)), vec![[5, 1, 1]]));
    assert!(truth.blockers.get([3, 1, 1]));
}

#[test]
fn the_field_begins_at_the_shortest_range() {
    // Voxel 3 is entered at 2.5 m, voxel 2 at 1.5 m.
    let mut truth = tube_cell();
    let far = radar([1.0, 1.0], [2.0, 6.4]);
    put_moving(&mut truth, Role::Human, 2, Some(1000));
    let at = facing(&truth, [0.5, 1.5, 1.5], [1.0, 0.0, 0.0]);
    assert!(far.sensed(&at).is_empty(), "hidden by someone too near");
    let mut truth = tube_cell();
    put_moving(&mut truth, Role::Human, 3, Some(1000));
    assert_eq!(reads(&far, &truth), (Says::Occupied(along(3, 3)), vec![[3, 1, 1]]));
}

#[test]
fn things_that_move_by_themselves_trip_it_and_robots_and_people_do_not() {
    for (role, speed, by) in [
        (Role::Environment, Some(100), vec![[4, 1, 1]]),
        (Role::Environment, Some(99), vec![]),
        (Role::Environment, None, vec![]),
        (Role::Robot, Some(1000), vec![]),
        (Role::Human, Some(1000), vec![]),
    ] {
        let mut truth = tube_cell();
        put_moving(&mut truth, role, 4, speed);
        let at = facing(&truth, [0.5, 1.5, 1.5], [1.0, 0.0, 0.0]);
        assert_eq!(tube().stuck_by(&at).voxels().collect::<Vec<_>>(), by, "{role:?} {speed:?}");
    }
}

/// Of 90° by 90°, a quarter of the grid at each distance; tilted up it sees the layers above.
#[test]
fn the_field_is_a_fan_in_front_that_tilts() {
    let truth = empty([9, 9, 9], 1.0);
    let wide = radar([90.0, 20.0], [0.0, 4.0]);
    let at = facing(&truth, [0.5, 4.5, 4.5], [1.0, 0.0, 0.0]);
    let field = wide.sensed(&at);
    for (voxel, inside) in [
        ([1, 4, 4], true),
        ([3, 2, 4], true),
        ([3, 6, 4], true),
        ([1, 7, 4], false),
        ([3, 0, 4], false),
        ([4, 4, 4], true),
        ([5, 4, 4], false),
        ([3, 4, 6], false),
        ([0, 4, 4], false),
    ] {
        assert_eq!(field.get(voxel), inside, "{voxel:?}");
    }
    let up = Pose::facing([0.5, 4.5, 4.5].into(), [1.0, 0.0, 1.0].into(), 0.0, 0.0);
    let up = crate::sensor::tests::station(&truth, crate::sensor::Setting::Pose(up));
    assert!(wide.sensed(&up).get([2, 4, 6]) && !wide.sensed(&up).get([3, 4, 4]));
    assert_eq!(wide.stance(), crate::sensor::Stance::Facing);
}

/// Numbers from a seed.
struct CaseRandom(u32);

impl CaseRandom {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        pcg(pcg(self.0)) % n
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(1 << 20)) / f64::from(1 << 20)
    }
}

/// The voxels that rays enter by the rules, written out: of each direction crossings of three axes, by distance, x before y
/// before z.
fn plain_sensed(radar: &Radar, truth: &Truth, pose: &Pose) -> HashSet<[i32; 3]> {
    let size_m = truth.grid.voxel_size_m;
    let q16 = |metres: f64| (metres / size_m * 65_536.0).round() as i64;
    let [near, far] = radar.range.range_m.map(q16);
    let counts = radar.fov_rad.map(|span| (span * (far as f64 / 65_536.0) * 1.5).ceil() as usize + 1);
    let origin = [0, 1, 2].map(|r| q16(pose.position_m[r]) - (i64::from(truth.grid.origin[r]) << 16));
    let own = origin.map(|x| (x >> 16) as i32);
    let rows_q15 = [0, 1, 2].map(|r| [0, 1, 2].map(|a| (pose.link().col(a)[r] * 32_768.0).round() as i64));
    let mut sensed = HashSet::new();
    for column in 0..counts[0] {
        for row in 0..counts[1] {
            let at = |span: f64, i: usize, n: usize| span * (i as f64 / (n - 1) as f64 - 0.5);
            let (azimuth, elevation) =
                (at(radar.fov_rad[0], column, counts[0]), at(radar.fov_rad[1], row, counts[1]));
            let unit = [
                libm::cos(elevation) * libm::cos(azimuth),
                libm::cos(elevation) * libm::sin(azimuth),
                libm::sin(elevation),
            ];
            let unit_q15 = unit.map(|x| (x * 32_768.0).round() as i64);
            let d = rows_q15.map(|row| ((0..3).map(|a| row[a] * unit_q15[a]).sum::<i64>() + (1 << 13)) >> 14);
            let never = i64::from(i32::MAX);
            let period = d.map(|d| if d == 0 { never } else { never.min((1 << 32) / d.abs()) });
            let mut next = [0, 1, 2].map(|r| {
                let within = origin[r] & 65_535;
                let ahead = if d[r] > 0 { 65_536 - within } else { within };
                if d[r] == 0 { never } else { (ahead * period[r]) >> 16 }
            });
            let mut voxel = own;
            loop {
                let axis = (0..3).min_by_key(|&r| next[r]).unwrap();
                let t = next[axis];
                voxel[axis] += d[axis].signum() as i32;
                next[axis] += period[axis];
                if t > far || !truth.grid.window().contains(voxel) {
                    break;
                }
                if t >= near {
                    sensed.insert(voxel);
                }
                if truth.radar.blockers.get(voxel) {
                    break;
                }
            }
        }
    }
    sensed
}

#[test]
fn in_random_cells_it_reports_what_a_plain_computation_does() {
    let [mut on, mut off, mut hidden, mut passed] = [0; 4];
    for seed in 0..60 {
        let random = &mut CaseRandom(seed);
        let mut truth = empty([16, 14, 10], random.between(0.1, 0.3));
        let (size_m, size) = (truth.grid.voxel_size_m, truth.grid.size);
        let mut passing = BitGrid::new(truth.grid.window());
        let mut speeds = Vec::new();
        for _ in 0..2 + random.below(5) {
            let role = [Role::Environment, Role::Human, Role::Robot][random.below(3) as usize];
            let low: [i32; 3] = std::array::from_fn(|r| random.below(size[r]) as i32);
            let high: [i32; 3] =
                std::array::from_fn(|r| (low[r] + random.below(5) as i32).min(size[r] as i32 - 1));
            put(&mut truth, role, &block(low, high), None);
            speeds.push([None, Some(0), Some(50), Some(100), Some(1600)][random.below(5) as usize]);
            if role == Role::Environment && random.below(2) == 0 {
                passing.add(&truth.objects.last().unwrap().voxels);
                passed += 1;
            }
        }
        // Whatever another object has stops radar all the same.
        for object in &truth.objects {
            let passes = object.role == Role::Environment && passing.intersects(&object.voxels);
            if !passes {
                passing.remove(&object.voxels);
            }
        }
        let mut blockers = BitGrid::clone(&truth.radar.blockers);
        blockers.remove(&passing);
        truth.radar = RadarTruth { blockers: blockers.into(), speeds_mm_s: speeds.clone() };
        let near = if random.below(3) == 0 { random.between(0.1, 0.6) } else { 0.0 };
        let kind = Radar {
            min_speed_mm_s: [0, 100, 1000][random.below(3) as usize],
            otherwise_free: true,
            ..radar(
                [random.between(1.0, 180.0), random.between(1.0, 100.0)],
                [near, near + random.between(0.5, 3.0)],
            )
        };
        let place = [0, 1, 2].map(|r| random.between(0.0, f64::from(size[r]) * size_m * 0.999));
        let towards = [(); 3].map(|()| random.between(-1.0, 1.0));
        let at = facing(&truth, place, towards);
        let sensed = plain_sensed(&kind, &truth, &at.pose());
        let owners = |voxel: [i32; 3]| {
            let all = truth.objects.iter().zip(&speeds).filter(move |(object, _)| object.voxels.get(voxel));
            all.map(|(object, speed)| (object.role, speed.unwrap_or(0))).collect::<Vec<_>>()
        };
        let slowest = kind.min_speed_mm_s;
        let is_fast = |(role, speed): &(Role, u32)| *speed >= slowest && (*speed > 0 || *role == Role::Human);
        let has_person = |voxel| owners(voxel).iter().any(|(role, _)| *role == Role::Human);
        // Of a voxel of several people the slow ones are taken out first.
        let moves = |voxel| owners(voxel).iter().any(is_fast);
        let expected_on = sensed.iter().any(|&voxel| moves(voxel));
        let mut field: Vec<[i32; 3]> = sensed
            .iter()
            .copied()
            .filter(|&voxel| !truth.radar.blockers.get(voxel) || has_person(voxel) || moves(voxel))
            .collect();
        field.sort_unstable_by_key(|v| [v[2], v[1], v[0]]);
        let mut felt: Vec<[i32; 3]> =
            sensed.iter().copied().filter(|&voxel| moves(voxel) && has_person(voxel)).collect();
        felt.sort_unstable_by_key(|v| [v[2], v[1], v[0]]);
        let Planes { occupied, free, hits } = kind.claims(&at).remove(0).planes.unwrap();
        let list = |plane: &BitGrid| plane.voxels().collect::<Vec<_>>();
        let expected = if expected_on { (field, vec![], felt) } else { (vec![], field, vec![]) };
        assert_eq!((list(&occupied), list(&free), list(&hits)), expected, "seed {seed}");
        if expected_on {
            on += 1
        } else {
            off += 1
        }
        hidden += usize::from(sensed.iter().any(|voxel| truth.radar.blockers.get(*voxel)));
    }
    assert!(on > 10 && off > 10 && hidden > 10 && passed > 10, "{on} {off} {hidden} {passed}");
}
