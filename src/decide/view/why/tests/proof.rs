//! The list of reasons is complete and correct: random cells, and every kind of sensor, compared with a plain search of
//! every ray. `PERIROBOT_CASE=<seed>` runs one cell.

use glam::DVec3;

use super::*;
use crate::view::why::nearest::gap;
use perirobot_march::backend::{Fusion, Rays};
use perirobot_march::march::{self, NEVER, pcg};
use perirobot_scene::truth::ObjectVoxels;
use perirobot_study::sensor::{Extent, FieldOfView, MEASURES, quantise_q15};

/// The expected reason of a sensor for a voxel, and the object that ended its ray: searches all rays by single steps;
/// shares only directions, fields of view and gaps with the tested code.
fn plain(
    view: &View,
    (member, volume): (&SensorView, Option<&BitGrid>),
    voxel: [i32; 3],
) -> (Reason, Option<usize>) {
    let kind = &view.study.sensors[member.sensor].kind;
    let objects = &view.truth.objects;
    let is_radar = kind.name() == "radar";
    let stops = |object: &ObjectVoxels| if is_radar { object.stops_radar } else { object.stops_rays };
    let (reason, hit) = plain_end(view, (member, volume), voxel);
    let stands = |hit| objects.iter().position(|object| stops(object) && object.voxels.get(hit));
    (reason, hit.and_then(stands))
}

/// The same with the voxel that ended the ray.
fn plain_end(
    view: &View,
    (member, volume): (&SensorView, Option<&BitGrid>),
    voxel: [i32; 3],
) -> (Reason, Option<[i32; 3]>) {
    let (truth, kind) = (&view.truth, &view.study.sensors[member.sensor].kind);
    if member.says.occupied.get(voxel) || member.says.free.get(voxel) {
        return (Reason::Cancelled, None);
    }
    let inside = volume.is_some_and(|volume| volume.get(voxel));
    let fan = kind.fan(truth.grid.voxel_size_m).filter(|_| !inside);
    let (rays, blockers) = match (member.casts, &view.tables[member.sensor], &fan) {
        (true, Some(rays), _) => (rays, &truth.blockers),
        (_, _, Some(fan)) => (fan, &truth.radar.blockers),
        _ => return (reason_without_rays(view, member, voxel, inside), None),
    };
    let from = &member.placement;
    let way = [0, 1, 2].map(|r| f64::from(voxel[r]) + 0.5 - f64::from(from.origin_q16[r]) / 65_536.0);
    let axis = |a: usize| (0..3).map(|r| f64::from(from.axis_q15[r][a]) / 32_768.0 * way[r]).sum::<f64>();
    let direction = DVec3::new(axis(0), axis(1), axis(2));
    let (ray, off) = nearest_plain(rays, direction);
    let field = kind.field_of_view();
    let in_view = field.holds(direction).unwrap_or_else(|| off <= gap(&rays.dirs_q15) / 2);
    match kind.name() {
        "rays" => assert_eq!(field, FieldOfView::Spacing),
        "rgbd" | "lidar" => assert_ne!(field, FieldOfView::Spacing),
        _ => {}
    }

    let gates = rays.gates_of(ray);
    let mut entered = None;
    // The end of the ray, its place, and whether the ray had crossed the voxel by then.
    let mut end: Option<([i32; 3], u32, bool)> = None;
    let mut left = false;
    // The believed ray crosses the voxel; the true ray ends at an object.
    for (from, is_cast) in [(*from, from.truly.is_none()), (from.caster(), true)] {
        let mut at = from.launch(rays.dirs_q15[ray]);
        if from.origin_q16 == member.placement.origin_q16 && at.voxel == voxel {
            entered = entered.or(Some(0));
        }
        let is_believed = from.truly == member.placement.truly;
        loop {
            let axis = march::next_axis(at.next_q16);
            let t = at.next_q16[axis];
            if t > NEVER / 2 {
                break;
            }
            march::cross(&mut at, axis);
            if is_believed && at.voxel == voxel {
                entered = entered.or(Some(t));
            }
            if !blockers.window().contains(at.voxel) {
                left = is_cast && t <= gates.range_max_q16;
                break;
            }
            let stops = is_cast && t >= gates.near_ignore_q16 && blockers.get(at.voxel);
            if stops && end.is_none() && t <= gates.range_max_q16 {
                let crossed = entered.is_some_and(|entered| is_believed || entered <= t);
                end = Some((at.voxel, t, crossed));
            }
        }
        if is_cast {
            break;
        }
    }
    let is_too_dark = |hit: [i32; 3], t: u32| {
        let Some(shades) = &truth.shades else { return false };
        let number =
            shades.bits.iter().zip([1, 2, 4]).map(|(plane, bit)| if plane.get(hit) { bit } else { 0 });
        let number = number.sum::<usize>();
        number > 0 && t >= gates.range_min_q16 && t > gates.shade_ranges_q16[number - 1]
    };
    let Some(entered) = entered else {
        let far = way.iter().map(|x| x * x).sum::<f64>().sqrt() * 65_536.0 > f64::from(gates.range_max_q16);
        return match (in_view, far) {
            (false, _) => (Reason::OutOfView, None),
            (_, true) => (Reason::OutOfRange, None),
            _ => (Reason::BetweenRays, None),
        };
    };
    if fan.is_some() {
        let is_too_near = entered < gates.range_min_q16 || entered < gates.near_ignore_q16;
        return match end {
            _ if entered > gates.range_max_q16 || is_too_near => (Reason::OutOfRange, None),
            Some((hit, _, crossed)) if !crossed || hit == voxel => (Reason::Hidden, Some(hit)),
            _ => {
                assert_eq!(entered, 0, "it senses what its rays cross");
                (Reason::BetweenRays, None)
            }
        };
    }
    match end {
        _ if entered > gates.range_max_q16 => (Reason::OutOfRange, None),
        Some((hit, t, _)) if t < gates.range_min_q16 => (Reason::Blind, Some(hit)),
        Some((hit, t, _)) if is_too_dark(hit, t) => (Reason::TooDark, Some(hit)),
        Some(_) if pcg(pcg(from.draws ^ ray as u32)) < rays.noise.lost_below => (Reason::NoReturn, None),
        Some((hit, _, false)) => (Reason::Hidden, Some(hit)),
        Some(_) => {
            assert!(kind.is_noisy(), "without noise a ray knows what it passed");
            (Reason::Misread, None)
        }
        None => {
            let lost = pcg(pcg(from.draws ^ ray as u32)) < rays.noise.lost_below;
            let certifies = gates.no_return_is_free || (left && gates.backdrop && !lost);
            assert!(!certifies, "a ray that certifies knows what it passed");
            (Reason::NoReturn, None)
        }
    }
}

/// A sensor at its candidate, over the whole grid.
fn station<'a>(view: &'a View, member: &SensorView) -> perirobot_study::sensor::Station<'a> {
    let truth = &view.truth;
    perirobot_study::sensor::Station {
        moment: [0, 0],
        truth,
        window: truth.grid.window(),
        setting: view.world.settings[member.sensor][member.candidate],
        rays: None,
        truly: None,
        draws: 0,
    }
}

/// What a sensor may label without rays; none of one that casts.
fn volume(view: &View, member: &SensorView) -> Option<BitGrid> {
    if member.casts && view.tables[member.sensor].is_some() {
        return None;
    }
    let (truth, sensor) = (&view.truth, &view.study.sensors[member.sensor]);
    let mut all = BitGrid::new(truth.grid.window());
    match sensor.kind.reach(&station(view, member)) {
        Extent::Only(voxels) | Extent::RaysAnd(voxels) => all.add(&voxels),
        Extent::Rays => panic!("{} casts", sensor.name),
    }
    sensor.kind.wherever_it_stands(truth).iter().for_each(|voxels| all.add(voxels));
    Some(all)
}

fn reason_without_rays(view: &View, member: &SensorView, voxel: [i32; 3], inside: bool) -> Reason {
    let (truth, sensor) = (&view.truth, &view.study.sensors[member.sensor]);
    match inside {
        false => Reason::OutOfView,
        true if sensor.kind.log_odds(0) == MEASURES => {
            assert!(sensor.kind.is_noisy() && truth.occupied.get(voxel), "what measures knows what is near");
            Reason::Misread
        }
        true => {
            let whole = member.says.occupied.is_empty() && member.says.free.is_empty();
            assert!(whole, "a switch speaks of all of its volume or of none");
            match sensor.kind.is_muted(&station(view, member)) {
                true => Reason::Muted,
                false => Reason::Silent,
            }
        }
    }
}

/// The nearest ray, and its squared distance in Q30.
fn nearest_plain(rays: &Rays, direction: DVec3) -> (usize, i64) {
    if let Some(image) = &rays.image {
        let aside = |a: usize| match direction.z > 0.0 {
            true => image.focal_px[a] * direction[a] / direction.z,
            false if direction[a] == 0.0 => 0.0,
            false => 1e9 * direction[a].signum(),
        };
        let best = |a: usize| {
            let size = image.size_px[a];
            let off = |n: u32| (f64::from(n) + 0.5 - f64::from(size) / 2.0 - aside(a)).abs();
            // Of two pixels as near the second: a pixel begins at its edge.
            (0..size).rev().min_by(|&m, &n| off(m).total_cmp(&off(n))).unwrap()
        };
        return ((best(1) * image.size_px[0] + best(0)) as usize, 0);
    }
    let unit = direction.normalize_or_zero().to_array().map(quantise_q15);
    let off = |dir: &[i32; 3]| (0..3).map(|r| i64::from(dir[r] - unit[r]).pow(2)).sum::<i64>();
    let (off, ray) = rays.dirs_q15.iter().zip(0..).map(|(dir, ray)| (off(dir), ray)).min().unwrap();
    (ray, off)
}

/// Asserts that a view agrees with the plain search, and that its numbers add up; counts how often each reason
/// occurred.
fn check(view: &View, every: usize, met: &mut [u64; Reason::ALL.len()], rerun: &str) {
    let missed = view.why_in_regions();
    for region in 0..view.world.regions.len() {
        let (tallies, counts) = (view.tally(&missed, region), view.counts(region));
        let together = |of: fn(&CauseTally) -> u64| tallies.iter().map(of).sum::<u64>();
        let sums = [together(|t| t.occupied), together(|t| t.free), together(|t| t.human)];
        assert_eq!(sums, [counts.uo, counts.uf, counts.human.uo], "{:?}\n{rerun}", view.choice);
    }
    let volumes: Vec<_> = view.members.iter().map(|member| volume(view, member)).collect();
    for Missed { cause, voxels } in &missed {
        met[cause.reason as usize] += voxels.count();
        for voxel in voxels.voxels().step_by(every) {
            let members = view.members.iter().zip(volumes.iter().map(Option::as_ref));
            let expected_causes: Vec<_> = members.map(|member| plain(view, member, voxel)).collect();
            let reason = expected_causes.iter().map(|(reason, _)| *reason).max().unwrap();
            let object = expected_causes.iter().find(|one| one.0 == reason).and_then(|one| one.1);
            let expected = Cause { reason, object };
            assert_eq!(*cause, expected, "{voxel:?} of {:?}\n{rerun}", view.choice);
            assert_eq!(
                cause.object.is_some(),
                matches!(reason, Reason::Hidden | Reason::Blind | Reason::TooDark),
                "{rerun}"
            );
        }
    }
}

/// Asserts that a view of only the regions agrees with one of the whole grid.
fn same_in_regions(whole: &View, alone: View, rerun: &str) {
    let what = format!("{:?}\n{rerun}", whole.choice);
    for region in 0..whole.world.regions.len() {
        assert_eq!(alone.counts(region), whole.counts(region), "region {region} of {what}");
    }
    assert_eq!(alone.why_in_regions(), whole.why_in_regions(), "{what}");
}

/// Some choices of every combination, with both rules of fusion.
fn check_all(mut study: Study, worlds: &[World], every: [usize; 2], met: &mut [u64; 11], rerun: &str) {
    for fusion in [Fusion::OccupiedWins, Fusion::Octomap] {
        study.combinations.iter_mut().for_each(|combination| combination.fusion = fusion);
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let mut viewer = crate::view::Viewer::new(&study, &mut cpu).unwrap();
        for world in worlds {
            for (number, combination) in study.combinations.iter().enumerate() {
                for choice in (0..combination.choices()).step_by(every[0]) {
                    for representation in 0..combination.representation_count(&study.sensors) {
                        let repeat = study.repeats as usize - 1;
                        let choice = Choice { combination: number, choice, representation, repeat };
                        let view = viewer.view(world, choice).unwrap();
                        check(&view, every[1], met, rerun);
                        same_in_regions(
                            &view,
                            viewer.view_regions(world, &[choice]).unwrap().remove(0),
                            rerun,
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn every_kind_of_sensor_has_its_reasons() {
    let path =
        std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/sensors.toml");
    let mut met = [0; 11];
    for noiseless in [false, true] {
        let overrides = Overrides { voxel_size_m: Some(0.2), noiseless };
        let mut study = Study::load(&path, &overrides).unwrap();
        // All casting sensors, also by their rays alone.
        for (sensor, spec) in study.sensors.iter().enumerate() {
            let members = vec![perirobot_study::input::Member { sensor, candidates: vec![0] }];
            let name = spec.name.clone();
            study.combinations.push(perirobot_study::input::Combination {
                name,
                fusion: Fusion::Octomap,
                members,
            });
        }
        let worlds = World::prepare_all(&study).unwrap();
        check_all(study, &worlds[..1], [7, 17], &mut met, &format!("noiseless: {noiseless}"));
    }
    // The room is closed, and no object is close to a lens.
    for reason in [Reason::OutOfView, Reason::Silent, Reason::BetweenRays, Reason::Hidden, Reason::Misread] {
        assert!(met[reason as usize] > 0, "no voxel is {}: {met:?}", reason.name());
    }
}

/// Numbers from a seed.
pub(crate) struct CaseRandom(pub(crate) u32);

impl CaseRandom {
    pub(crate) fn number_below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        pcg(pcg(self.0)) % n
    }

    fn number_between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.number_below(1 << 20)) / f64::from(1 << 20)
    }

    fn pick<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.number_below(all.len() as u32) as usize]
    }

    fn place(&mut self) -> String {
        format!(
            "[{}, {}, {}]",
            self.number_between(-1.0, 1.0),
            self.number_between(-0.8, 0.8),
            self.number_between(0.1, 1.4)
        )
    }
}

/// Boxes anywhere, some of them in others, see-through or tags; a person and a robot.
pub(crate) fn random_scene(random: &mut CaseRandom) -> String {
    let mut scene = String::from("interior = \"free\"\n");
    for number in 0..2 + random.number_below(5) {
        let more =
            random.pick(&["", "", "interior = \"occupied\"", "optical = \"see_through\"", "tag_only = true"]);
        let [x, y, z] = [(); 3].map(|()| random.number_between(0.05, 0.7));
        scene += &format!(
            "[[object]]\nname = \"box {number}\"\nbox = {{ size_m = [{x}, {y}, {z}] }}\nposition_m = {}\n{more}\n{}\n{}\n",
            random.place(),
            random.pick(&["", "reflectance = 0.05", "reflectance = 0.5"]),
            random.pick(&[
                "",
                "radar = \"passes\"",
                "radar = \"passes\"\nspeed_m_s = 0.4",
                "speed_m_s = 0.02"
            ]),
        );
    }
    if random.number_below(3) > 0 {
        scene +=
            "[[object]]\nname = \"room\"\nroom = { size_m = [2.4, 2.0, 1.6] }\nposition_m = [0, 0, 0.8]\n";
    }
    for (role, shape) in
        [("human", "radius_m = 0.15, height_m = 1.2"), ("robot", "radius_m = 0.1, height_m = 0.7")]
    {
        scene += &format!(
            "[[object]]\nname = \"{role}\"\nrole = \"{role}\"\ncylinder = {{ {shape} }}\nposition_m = {}\nspeed_m_s = {}\n",
            random.place(),
            random.pick(&["0", "0.05", "1.6"]),
        );
    }
    scene
}

/// A camera, a LIDAR, a table of rays, a gate, a cover, the robot's pose and a radar, alone and together.
pub(crate) fn random_study(random: &mut CaseRandom) -> String {
    let mut study = format!(
        "seed = {}\n[grid]\nvoxel_size_m = {}\noutside = \"{}\"\n\
         bounds_m = {{ min = [-1.25, -1.05, -0.05], max = [1.25, 1.05, 1.65] }}\n[[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"all\"\nbox = {{ min_m = [-2, -2, -2], max_m = [2, 2, 2] }}\n\
         [[region]]\nname = \"human\"\nhuman_box = {{ margin_m = 0.3 }}\n",
        random.number_below(1000),
        random.pick(&["0.1", "0.13", "0.2"]),
        random.pick(&["nothing", "nothing", "backdrop"]),
    );
    for (name, keys) in [
        (
            "camera",
            format!(
                "kind = \"rgbd\"\nfov_deg = [{}, {}]\nresolution_px = [{}, {}]",
                random.number_between(20.0, 150.0),
                random.number_between(20.0, 150.0),
                1 + random.number_below(40),
                1 + random.number_below(30)
            ),
        ),
        (
            "lidar",
            format!(
                "kind = \"lidar\"\nfov_deg = {}\nresolution_deg = {}\nrings_deg = {}\nmount = \"{}\"",
                random.number_between(10.0, 360.0),
                random.number_between(2.0, 20.0),
                random.pick(&["[0]", "[-20, -5, 0, 3, 60]", "[45, 60, 75, 90]", "[-89, -30]"]),
                random.pick(&["facing", "upright"]),
            ),
        ),
        ("ring", "kind = \"rays\"\ndirections = \"ring.csv\"".into()),
    ] {
        let near = random.number_below(2) * random.number_below(6);
        study += &format!(
            "[[sensor]]\nname = \"{name}\"\n{keys}\nrange_m = [{}, {}]\nnear_ignore_m = {}\nnoise = {}\ndropout = {}\n{}\n{}\nno_return = \"{}\"\n\
             [[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = {}, rpy_deg = [{}, {}, {}] }}]\n",
            f64::from(near) * 0.1,
            f64::from(near) * 0.1 + random.number_between(0.6, 3.0),
            random.pick(&["0", "0", "0.25"]),
            random.pick(&[
                "{ std_m = 0 }",
                "{ std_m = 0.08 }",
                "{ std_m = 0.3, per_m = 0.05, per_m2 = 0.03 }"
            ]),
            random.pick(&["0", "0", "0.2"]),
            random.pick(&[
                "",
                "reflectance_ranges_m = [[0.1, 1.2]]",
                "reflectance_ranges_m = [[0.02, 0.5], [0.9, 4]]"
            ]),
            random.pick(&[
                "",
                "",
                "calibration = { position_m = 0.1, angle_deg = 3 }",
                "calibration = { angle_deg = 20 }"
            ]),
            random.pick(&["unknown", "unknown", "free"]),
            random.place(),
            random.number_between(-180.0, 180.0),
            random.number_between(-90.0, 90.0),
            random.number_between(-180.0, 180.0),
        );
    }
    study
        + &format!(
            "[[sensor]]\nname = \"gate\"\nkind = \"gate\"\nbox = {{ min_m = [0.6, -1, 0], max_m = [1, 1, 1] }}\n\
         zone = {{ min_m = [-0.6, -0.5, 0.2], max_m = [0.6, 1, 1.2] }}\notherwise = \"{}\"\n{}\n\
         [[sensor]]\nname = \"cover\"\nkind = \"cover\"\ninflation_m = [{}]\nnoise = {{ std_m = {} }}\n\
         [[sensor]]\nname = \"robot\"\nkind = \"known_robot\"\n\
         [[sensor]]\nname = \"radar\"\nkind = \"radar\"\nfov_deg = [{}, {}]\nrange_m = [{}, {}]\nmin_speed_m_s = {}\n\
         otherwise = \"{}\"\n[[sensor.poses]]\nname = \"p\"\nlist = [{{ position_m = {}, rpy_deg = [{}, {}, {}] }}]\n\
         [[combination]]\nsensors = [\"camera\"]\n[[combination]]\nsensors = [\"lidar\"]\n[[combination]]\nsensors = [\"ring\"]\n\
         [[combination]]\nsensors = [\"gate\", \"lidar\", \"camera\"]\n\
         [[combination]]\nsensors = [\"cover\", \"robot\"]\n\
         [[combination]]\nsensors = [\"ring\", \"camera\", \"cover\", \"robot\", \"lidar\"]\n\
         [[combination]]\nsensors = [\"radar\"]\n[[combination]]\nsensors = [\"radar\", \"ring\", \"gate\"]\n",
            random.pick(&["unknown", "free"]),
            random.pick(&["", "", "muted_at = [0]"]),
            random.number_between(0.1, 0.5),
            random.pick(&["0", "0.1"]),
            random.number_between(5.0, 180.0),
            random.number_between(5.0, 90.0),
            random.pick(&["0", "0", "0.3"]),
            random.number_between(0.6, 3.0),
            random.pick(&["0", "0.05", "0.5"]),
            random.pick(&["unknown", "free"]),
            random.place(),
            random.number_between(-180.0, 180.0),
            random.number_between(-90.0, 90.0),
            random.number_between(-180.0, 180.0),
        )
}

/// Directions in no order.
pub(crate) fn random_ring(random: &mut CaseRandom) -> String {
    let mut csv = String::from("x,y,z\n");
    for _ in 0..1 + random.number_below(60) {
        let [y, z] = [(); 2].map(|()| random.number_between(-1.0, 1.0));
        csv += &format!("{},{y},{z}\n", random.pick(&["0.5", "1", "0.001"]));
    }
    csv
}

#[test]
fn in_random_cells_reasons_are_complete_and_right() {
    let only_seed = std::env::var("PERIROBOT_CASE").ok().and_then(|seed| seed.parse().ok());
    let mut met = [0; 11];
    for seed in only_seed.map_or(0..32, |seed: u32| seed..seed + 1) {
        let random = &mut CaseRandom(seed);
        let (scene, ring) = (random_scene(random), random_ring(random));
        let study = random_study(random);
        let (study, worlds) = ready(&study, &scene, &[("ring.csv", ring)]);
        let rerun = format!("rerun: PERIROBOT_CASE={seed} cargo test --lib view::why::tests::proof");
        check_all(study, &worlds, [1, 7], &mut met, &rerun);
    }
    assert!(only_seed.is_some() || met[..10].iter().all(|&count| count > 0), "{met:?}");
}
