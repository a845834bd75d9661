//! Against judging every set.

use std::fmt::Write;

use super::remaining::combination;
use super::{PurchasedSensor, Purchasing};
use crate::judge::judge_alone;
use crate::thorough::cases;
use crate::view::Choice;
use perirobot_march::Result;
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot_march::march::pcg;
use perirobot_study::study::{Overrides, Purchase, Study, Wanted};
use perirobot_study::world::World;

/// Numbers that look random.
struct Random(u32);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        pcg(self.0) % n
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * f64::from(self.below(1000)) / 1000.0
    }
}

const SCENE: &str = include_str!("../../../scenes/approach/cell.toml");

/// A study of some cameras and a pad around a robot, a shelf and a colleague, with some requirements.
fn made_up_study(random: &mut Random) -> String {
    let mut text = String::from(
        "[grid]\nvoxel_size_m = 0.2\nbounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"robot\"\nsphere = { center_m = [-1, 0, 0.6], radius_m = 0.8 }\n\
         [[region]]\nname = \"shelf\"\nbox = { min_m = [-0.3, -0.6, 0], max_m = [0.9, 1, 2] }\n",
    );
    for (sensor, count) in [("wide", 3 + random.below(2)), ("narrow", 2 + random.below(2))] {
        let fov = if sensor == "wide" { "[110, 90]" } else { "[60, 45]" };
        let cost = [100, 100, 150, 250, 0][random.below(5) as usize];
        write!(
            text,
            "[[sensor]]\nname = \"{sensor}\"\nkind = \"rgbd\"\nfov_deg = {fov}\nresolution_px = [48, 36]\n\
             range_m = [0.1, 6.0]\ncost = {cost}\n[[sensor.poses]]\nname = \"wall\"\nlist = [\n"
        )
        .unwrap();
        for number in 0..count {
            let [x, y, z] = [random.between(-1.9, 1.9), random.between(-1.4, 1.4), random.between(1.2, 2.1)];
            let [a, b] = [-x + random.between(-0.8, 0.8), -y + random.between(-0.8, 0.8)];
            writeln!(
                text,
                "{{ name = \"{number}\", position_m = [{x:.2}, {y:.2}, {z:.2}], facing = [{a:.2}, {b:.2}, 0], tilt_deg = -25 }},"
            )
            .unwrap();
        }
        text += "]\n";
    }
    let conditions = ["as_planned", "one_sensor_dead", "two_sensors_dead", "mounting_error", "postures"];
    let scores: [(&str, &str, [f64; 2]); 9] = [
        ("unknown", "at_most", [0.5, 1.0]),
        ("human_seen", "at_least", [0.0, 0.5]),
        ("parts_detected", "at_least", [0.0, 1.0]),
        ("people_detected", "at_least", [0.5, 1.0]),
        ("f1", "at_least", [0.0, 0.6]),
        ("seen_twice", "at_least", [0.0, 0.5]),
        ("nearest_unnoticed_m", "at_least", [0.2, 1.6]),
        ("approach_margin_m", "at_least", [0.0, 0.4]),
        ("unnoticed_m2", "at_most", [1.0, 8.0]),
    ];
    for number in 0..1 + random.below(3) {
        let (score, side, [low, high]) = scores[random.below(9) as usize];
        let is_near = score.contains("_m");
        let limit = random.between(low, high);
        let region = if is_near {
            ""
        } else {
            ["region = \"robot\"\n", "region = \"shelf\"\n"][random.below(2) as usize]
        };
        let over = if is_near {
            ""
        } else {
            ["", "over = \"mean\"\n", "over = \"pooled\"\n"][random.below(3) as usize]
        };
        // Draws and postures take longer.
        let most = if random.below(4) > 0 {
            2
        } else if is_near {
            4
        } else {
            5
        };
        let under = conditions[random.below(most) as usize];
        write!(
            text,
            "[[require]]\nname = \"r{number}\"\nscore = \"{score}\"\n{region}{over}{side} = {limit:.3}\nunder = [\"as_planned\"{}]\n",
            if under == "as_planned" { String::new() } else { format!(", {under:?}") }
        )
        .unwrap();
    }
    text += "[mounting_error]\ndraws = 2\nposition_m = 0.1\nangle_deg = 5.0\n\
             [postures]\npeople = [\"kneeling\"]\nspots = [[0.6, -0.9, 90]]\n\
             [stopping]\nformula = \"speed_and_separation\"\nrobot_speeds_m_s = [0.25, 0.5]\nsensor_reaction_s = 0.05\n\
             control_reaction_s = 0.05\nrobot_deceleration_m_s2 = 4.0\nintrusion_m = 0.1\nperson_uncertainty_m = 0.05\n\
             robot_uncertainty_m = 0.01\n\
             [approach]\nhazard = \"robot\"\nmin_voxels = 2\n[[approach.body]]\nname = \"standing\"\n\
             [[approach.entry]]\nname = \"door\"\nbox = { min_m = [1.2, -1.2, 0], max_m = [2, 1.2, 2] }\n";
    let budget = if random.below(3) == 0 { "budget = 400\n" } else { "" };
    let apart = if random.below(3) == 0 { "apart_m = 0.8\n" } else { "" };
    let then = if random.below(2) == 0 { "then = \"f1\"\nregion = \"robot\"\n" } else { "" };
    text + "[choose]\nobjective = \"cost\"\nat_most = 3\n" + budget + apart + then
}

fn open() -> Result<ChosenBackends> {
    let choice = BackendChoice { kind: BackendKind::Cpu, threads: Some(1), ..BackendChoice::default() };
    ChosenBackends::open(&choice).map(|(backends, _)| backends)
}

/// All allowed sets, by the numbers of their candidates.
fn allowed_sets(purchasing: &Purchasing) -> Vec<Vec<usize>> {
    let (rules, limits) = (purchasing.rules(), purchasing.limits());
    let mut all = vec![Vec::new()];
    let mut last = all.clone();
    for _ in 0..limits.at_most {
        let more = |set: &Vec<usize>| {
            let first = set.last().map_or(0, |last| last + 1);
            let fits = |item: &usize| {
                limits.afford(rules.cost_of(set) + rules.cost[*item]) && rules.may_join(set, *item)
            };
            (first..rules.cost.len())
                .filter(fits)
                .map(|item| [&set[..], &[item]].concat())
                .collect::<Vec<_>>()
        };
        last = last.iter().flat_map(more).collect();
        all.extend(last.clone());
    }
    all.remove(0);
    all
}

fn judged(study: &Study, purchase: &Purchase, worlds: &[World], items: &[[usize; 2]], set: &[usize]) -> bool {
    let combination = combination(study, purchase, items, String::new(), set);
    let study = study.with_combinations(&purchase.representations, vec![combination]);
    let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
    judge_alone(&study, worlds, &choice, &open, &|| None).unwrap().meets_all()
}

#[test]
fn the_cheapest_set_is_that_of_judging_every_set() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    let (mut some, mut none) = (0, 0);
    for case in 0..cases(12, 500) {
        let text = made_up_study(&mut Random(case as u32 * 7919));
        std::fs::write(&path, &text).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let Some(Wanted::Cheapest(purchase)) = &study.choose else { panic!("{text}") };
        let worlds = World::prepare_all(&study).unwrap();
        let purchasing = Purchasing::new(&study, purchase, &worlds, 1 << 30).unwrap();
        let casting = purchasing.begin_casting(None, false).unwrap();
        let evidence = casting.finish(&mut open().unwrap(), 1, &|| None).unwrap().of_regions;
        let ways = purchasing.look(&|| None).unwrap();
        let report = purchasing.search(&evidence, &ways, &open, &|| None).unwrap();
        let found = report.main();
        let item = |one: &PurchasedSensor| {
            let name = |&[sensor, candidate]: &[usize; 2]| {
                let sensor = &study.sensors[sensor];
                sensor.name == one.sensor && sensor.candidates[candidate].name == one.pose
            };
            purchasing.items().iter().position(name).unwrap()
        };
        let rules = purchasing.rules();
        let mut passing = allowed_sets(&purchasing);
        passing.retain(|set| judged(&study, purchase, &worlds, purchasing.items(), set));
        let cost = passing.iter().map(|set| rules.cost_of(set)).min();
        if let Some(set) = &found.set {
            let mut items: Vec<usize> = set.sensors.iter().map(item).collect();
            items.sort_unstable();
            assert!(passing.contains(&items), "case {case}: {items:?} does not pass\n{text}");
        }
        let best = found.set.as_ref().map(|set| set.cost.thousandths());
        assert_eq!(best, cost, "case {case}: {passing:?}\n{text}");
        assert!(found.proven && found.best_of_cost, "case {case}");
        assert_eq!(found.reasons.is_empty(), cost.is_some(), "case {case}");
        if cost.is_some() { some += 1 } else { none += 1 }
    }
    assert!(some > 2 && none > 2, "{some} passed, {none} did not");
}
