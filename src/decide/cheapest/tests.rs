//! Comparison with judging every set.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::AtomicUsize;
use std::sync::atomic::Ordering::Relaxed;

use super::passing::worth_of_squared;
use super::purchasing::MOST_TIES;
use super::remaining::combination;
use super::report::{AimReport, PurchasePoint, PurchasedSet};
use super::terms::Terms;
use super::verify::verify_points;
use super::{PurchaseClaims, PurchaseReport, PurchasedSensor, Purchasing};
use crate::choose::{PlainCamera, pose_name};
use crate::judge::judge_alone;
use crate::thorough::cases;
use crate::view::Choice;
use perirobot_cover::Worth;
use perirobot_cover::cheapest::{CheapestAnswer, FoundPurchase};
use perirobot_march::backend::factory::{BackendChoice, BackendKind, ChosenBackends};
use perirobot_march::march::pcg;
use perirobot_march::metrics::{Ratio, Score};
use perirobot_march::progress::{Progress, PurchaseState};
use perirobot_march::{Error, Result};
use perirobot_study::input::{
    Condition, Counted, Limit, Measure, Nearness, Overrides, Purchase, Requirement, Study, ThenScore, Wanted,
};
use perirobot_study::sensor::Cost;
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

/// A study of cameras and a pad around a robot, a shelf and a colleague, with random requirements.
fn made_up_study(random: &mut Random) -> String {
    // Sensors with noise, which others may outvote.
    let is_noisy = random.below(3) == 0;
    let fusion = ["occupied_wins", "octomap"][random.below(2) as usize];
    let (noise, begin) = match is_noisy {
        true => ("noise = { std_m = 0.15 }\n", format!("seed = 3\nrepeats = 2\nfusion = \"{fusion}\"\n")),
        false => ("", String::new()),
    };
    // Some emit light and disturb each other.
    let light = |number: u32| ["", "emits = \"tof\"\n", "emits = \"structured_light\"\n"][number as usize];
    let lights = [[0, 0], [1, 1], [1, 1], [1, 2]][random.below(4) as usize];
    let mut text = begin
        + "[grid]\nvoxel_size_m = 0.2\nbounds_m = { min = [-2, -1.5, 0], max = [2, 1.5, 2.2] }\n\
         [[scene]]\nfile = \"cell.toml\"\n\
         [[region]]\nname = \"robot\"\nsphere = { center_m = [-1, 0, 0.6], radius_m = 0.8 }\n\
         [[region]]\nname = \"shelf\"\nbox = { min_m = [-0.3, -0.6, 0], max_m = [0.9, 1, 2] }\n";
    for ((sensor, count), emits) in
        [("wide", 3 + random.below(2)), ("narrow", 2 + random.below(2))].into_iter().zip(lights.map(light))
    {
        let fov = if sensor == "wide" { "[110, 90]" } else { "[60, 45]" };
        let cost = [100, 100, 150, 250, 0][random.below(5) as usize];
        write!(
            text,
            "[[sensor]]\nname = \"{sensor}\"\nkind = \"rgbd\"\nfov_deg = {fov}\nresolution_px = [48, 36]\n\
             range_m = [0.1, 6.0]\n{noise}{emits}cost = {cost}\n[[sensor.poses]]\nname = \"wall\"\nlist = [\n"
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
    for number in 0..1 + random.below(4) {
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
    let then = [
        "",
        "",
        "",
        "then = \"f1\"\nregion = \"robot\"\n",
        "then = \"seen_twice\"\nregion = \"robot\"\n",
        "then = \"seen_twice\"\nregion = \"shelf\"\nover = \"mean\"\n",
        "then = \"nearest_unnoticed_m\"\n",
        "then = \"approach_margin_m\"\n",
    ][random.below(8) as usize];
    let disturb = match lights {
        [0, 0] => "",
        _ => [
            "disturb = {}\n",
            "disturb = { apart_deg = 40 }\n",
            "disturb = { apart_deg = 0, overlap = 0.2 }\n",
            "disturb = { apart_deg = 30, overlap = 0.4 }\n",
        ][random.below(4) as usize],
    };
    text + "[choose]\nobjective = \"cost\"\nat_most = 3\n" + budget + apart + disturb + then
}

fn open() -> Result<ChosenBackends> {
    let choice = BackendChoice { kind: BackendKind::Cpu, threads: Some(1), ..BackendChoice::default() };
    ChosenBackends::open(&choice).map(|(backends, _)| backends)
}

fn cost(study: &Study, items: &[[usize; 2]], set: &[usize]) -> u64 {
    set.iter().map(|&item| study.sensors[items[item][0]].terms.cost.unwrap().thousandths()).sum()
}

/// All allowed sets, by the numbers of their candidates.
fn allowed_sets(
    study: &Study,
    purchase: &Purchase,
    worlds: &[World],
    items: &[[usize; 2]],
) -> Vec<Vec<usize>> {
    let walls_m = PlainCamera::walls_m(&worlds[0].grid);
    let camera = |item: usize| {
        let sensor = &study.sensors[items[item][0]];
        let fov_deg = if sensor.name == "wide" { [110.0, 90.0] } else { [60.0, 45.0] };
        let pose = sensor.candidates[items[item][1]].setting.pose();
        (PlainCamera { pose, fov_deg, far_m: 6.0, is_depth: false, walls_m }, &sensor.emits)
    };
    let go_together = |a: usize, b: usize| {
        let ((one, light), (other, other_light)) = (camera(a), camera(b));
        let is_near = one.pose.position_m.distance(other.pose.position_m) < purchase.apart_m;
        let is_same_light = light.is_some() && light == other_light;
        !is_near && !purchase.disturb.is_some_and(|rule| is_same_light && one.disturbs(&other, &rule))
    };
    let together: Vec<Vec<bool>> =
        (0..items.len()).map(|a| (0..items.len()).map(|b| go_together(a, b)).collect()).collect();
    let is_allowed = |set: &Vec<usize>| {
        let is_affordable =
            purchase.budget.is_none_or(|budget| cost(study, items, set) <= budget.thousandths());
        let each = (0..set.len()).all(|b| (0..b).all(|a| together[set[a]][set[b]]));
        (1..=purchase.at_most).contains(&set.len()) && is_affordable && each
    };
    let subset = |bits: usize| (0..items.len()).filter(|item| bits >> item & 1 == 1).collect::<Vec<usize>>();
    (0..1 << items.len()).map(subset).filter(is_allowed).collect()
}

/// The requirements that a set misses, by name, and the score that decides among sets of the same cost, both from
/// judge; more is better.
fn judged(
    study: &Study,
    purchase: &Purchase,
    worlds: &[World],
    items: &[[usize; 2]],
    set: &[usize],
) -> (Vec<String>, Option<f64>) {
    let combination = combination(study, purchase, items, String::new(), set);
    let mut study = study.with_combinations(&purchase.representations, vec![combination]);
    if let Some(ThenScore::Nearness(score)) = purchase.then {
        study.requirements.push(Requirement {
            name: "then".into(),
            measure: Measure::Nearness(Nearness { score, body: None, entry: None }),
            limit: Limit::AtLeast(Ratio::from_f64(0.0)),
            under: vec![Condition::AsPlanned],
            safety_function: None,
        });
    }
    let choice = Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
    let judged = judge_alone(&study, worlds, &choice, &open, &|| None).unwrap();
    let planned = &judged.conditions.cases(Condition::AsPlanned)[0];
    let mut missed: Vec<String> =
        judged.judgements.iter().filter(|one| !one.is_met).map(|one| one.requirement.name.clone()).collect();
    missed.dedup();
    missed.retain(|name| name != "then");
    let then = match purchase.then {
        Some(ThenScore::Counted(Counted { score, region, over })) => {
            Worth::from_counts(score, over, &planned.counts[region]).map(Worth::value)
        }
        Some(ThenScore::Nearness(_)) => {
            let own = judged.judgements.iter().find(|one| one.requirement.name == "then").unwrap();
            own.value.as_ref().map(|value| value.number())
        }
        None => None,
    };
    (missed, then)
}

/// 0 without a score, 1 for F1, 2 for overlap, 3 for a distance.
fn kind_of(then: &Option<ThenScore>) -> usize {
    match then {
        None => 0,
        Some(ThenScore::Counted(counted)) if counted.score == Score::F1 => 1,
        Some(ThenScore::Counted(_)) => 2,
        Some(ThenScore::Nearness(_)) => 3,
    }
}

/// A set with its verdict.
struct JudgedSet {
    set: Vec<usize>,
    /// The missed requirements, by name.
    missed: Vec<String>,
    then: Option<f64>,
}

/// The numbers of the candidates of a set.
fn numbers_of(study: &Study, items: &[[usize; 2]], set: &PurchasedSet) -> Vec<usize> {
    let number = |one: &PurchasedSensor| {
        let name = format!("{}:{}", one.sensor, one.pose);
        items.iter().position(|&item| pose_name(study, item) == name).unwrap()
    };
    let mut numbers: Vec<usize> = set.sensors.iter().map(number).collect();
    numbers.sort_unstable();
    numbers
}

#[test]
fn the_cheapest_set_equals_that_of_judging_every_set() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    let (mut some, mut none, mut refused, mut cheaper, mut dear, mut bound) = (0, 0, 0, 0, 0, 0);
    let (mut ties, mut decided) = (0, [0; 4]);
    for case in 0..cases(60, 500) {
        // Runs until all kinds have occurred.
        if case >= cases(12, 500)
            && [some, none, cheaper, dear].into_iter().min() > Some(2)
            && refused.min(bound).min(ties) > 0
            && decided[1..].iter().all(|&one| one > 0)
        {
            break;
        }
        let text = made_up_study(&mut Random(case as u32 * 7919)) + "front = \"requirements\"\n";
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
        let cost_of = |set: &[usize]| cost(&study, purchasing.items(), set);
        let judged = |set: &Vec<usize>| judged(&study, purchase, &worlds, purchasing.items(), set);
        let allowed = |purchase: &Purchase| allowed_sets(&study, purchase, &worlds, purchasing.items());
        let all = allowed(&Purchase { disturb: None, ..purchase.clone() });
        let judged = all.into_iter().map(|set| (judged(&set), set));
        let mut judged: Vec<JudgedSet> =
            judged.map(|((missed, then), set)| JudgedSet { set, missed, then }).collect();
        let lowest = |judged: &[JudgedSet]| {
            judged.iter().filter(|one| one.missed.is_empty()).map(|one| cost_of(&one.set)).min()
        };
        let cost_if_disturbed = lowest(&judged);
        let allowed = allowed(purchase);
        judged.retain(|one| allowed.contains(&one.set));
        let cost = lowest(&judged);
        let passing = judged.iter().filter(|one| one.missed.is_empty());
        let passing: Vec<(Vec<usize>, Option<f64>)> =
            passing.map(|one| (one.set.clone(), one.then)).collect();
        if let Some(set) = &found.set {
            let items = numbers_of(&study, purchasing.items(), set);
            assert!(
                passing.iter().any(|(set, _)| *set == items),
                "case {case}: {items:?} does not pass\n{text}"
            );
            let of_cost = passing.iter().filter(|(set, _)| Some(cost_of(set)) == cost);
            let most = of_cost.clone().filter_map(|(_, then)| *then).max_by(f64::total_cmp);
            assert_eq!(set.score, most, "case {case}\n{text}");
            let others = of_cost.clone().count() - 1;
            let expected_ties = purchase.then.is_none().then_some(others.min(MOST_TIES));
            assert_eq!(found.ties, expected_ties, "case {case}\n{text}");
            ties += usize::from(purchase.then.is_none() && others > 0);
            let is_less = of_cost.clone().any(|(_, then)| *then < most);
            decided[kind_of(&purchase.then)] += usize::from(is_less);
        }
        let best = found.set.as_ref().map(|set| set.cost.thousandths());
        assert_eq!(best, cost, "case {case}: {passing:?}\n{text}");
        assert!(found.proven && found.best_of_cost, "case {case}");
        assert_eq!(found.reasons.is_empty(), cost.is_some(), "case {case}");
        let count = study.requirements.len();
        let mut numbers = (1..count).rev();
        for point in &report.points {
            let AimReport::Number(least) = point.aim else { continue };
            assert_eq!(Some(least), numbers.next(), "case {case}");
            let enough = || judged.iter().filter(|one| one.missed.len() <= count - least);
            let lowest = enough().map(|one| cost_of(&one.set)).min();
            let best = point.set.as_ref().map(|set| set.cost.thousandths());
            assert_eq!(best, lowest, "case {case}, {least} of {count}\n{text}");
            assert!(point.proven && point.best_of_cost, "case {case}");
            cheaper += usize::from(lowest.is_some() && lowest != cost);
            let Some(set) = &point.set else { continue };
            let items = numbers_of(&study, purchasing.items(), set);
            let own = enough().find(|one| one.set == items).unwrap();
            assert_eq!(own.missed, point.missed, "case {case}");
            let of_cost = enough().filter(|one| Some(cost_of(&one.set)) == lowest);
            let most = of_cost.clone().filter_map(|one| one.then).max_by(f64::total_cmp);
            decided[kind_of(&purchase.then)] += usize::from(of_cost.clone().any(|one| one.then < most));
            assert_eq!(set.score, most, "case {case}, {least} of {count}\n{text}");
        }
        assert_eq!(numbers.next(), None, "case {case}");
        let if_disturbed = report.points.iter().find(|point| point.aim == AimReport::Disturbed);
        assert_eq!(if_disturbed.is_some(), purchase.disturb.is_some(), "case {case}");
        if let Some(point) = if_disturbed {
            let found = point.set.as_ref().map(|set| set.cost.thousandths());
            assert_eq!(found, cost_if_disturbed, "case {case}\n{text}");
            let is_broken = point
                .set
                .as_ref()
                .is_some_and(|set| !allowed.contains(&numbers_of(&study, purchasing.items(), set)));
            assert_eq!(is_broken, !point.disturbed.is_empty(), "case {case}: {point:?}\n{text}");
            let has_cost_bound = cost_if_disturbed != cost;
            assert!(!has_cost_bound || report.bound_by_disturb() == Some(point), "case {case}\n{text}");
            bound += usize::from(report.bound_by_disturb().is_some());
        }
        // The verifier agrees, and refuses false claims.
        let is_worse = |&&(ref set, then): &&(Vec<usize>, Option<f64>)| {
            Some(cost_of(set)) == cost && then < found.set.as_ref().and_then(|set| set.score)
        };
        let worse = passing.iter().find(is_worse).map(|(set, _)| set.clone());
        let input = purchasing.proof_input(&evidence, &|| None);
        let verify = |report: PurchaseReport| {
            let claims = PurchaseClaims::new(Path::new(""), report, input)?;
            verify_points(&claims, input, &open)
        };
        let verified = verify(report.clone()).unwrap_or_else(|error| panic!("case {case}: {error}\n{text}"));
        // No set costs less than nothing.
        let is_searched = verified.proven > 0 || cost == Some(0);
        assert!(is_searched && verified.open == 0, "case {case}: {verified:?}");
        if let Some(point) = report.bound_by_disturb() {
            let mut wrong = report.clone();
            let set = point.set.clone().map(|set| PurchasedSet { name: "cheapest".into(), ..set });
            wrong.points.retain(|point| !matches!(point.aim, AimReport::Nearest(_)));
            wrong.points[0] =
                PurchasePoint { aim: AimReport::All, set, disturbed: Vec::new(), ..point.clone() };
            let error = verify(wrong).err().map_or("it holds".into(), |error| error.to_string());
            let [a, b] = &point.disturbed[0];
            let what = format!("points[0].set: has {a} and {b}, which disturb each other");
            let back = format!("points[0].set: has {b} and {a}, which disturb each other");
            assert!(error.contains(&what) || error.contains(&back), "case {case}: {error}");
            let mut wrong = report.clone();
            let at = wrong.points.iter().position(|point| point.aim == AimReport::Disturbed).unwrap();
            wrong.points[at].disturbed.pop();
            let error = verify(wrong).unwrap_err().to_string();
            assert!(error.contains("].disturbed: is ["), "case {case}: {error}");
        }
        if let Some(set) = worse {
            let cost = cost_of(&set);
            let worth = match purchase.then {
                Some(ThenScore::Nearness(_)) => {
                    let squared = ways.iter().flat_map(|ways| ways.nearest(&ways.watched_by(&set)));
                    squared.filter_map(|near| near.squared).min().map(worth_of_squared)
                }
                _ => judged.iter().find(|one| one.set == set).and_then(|one| one.then).map(Worth::Mean),
            };
            let best = Some(FoundPurchase { set, cost, worth });
            let answer = CheapestAnswer { best, no_set_below: Some(cost), ..CheapestAnswer::NONE };
            let mut wrong = report.clone();
            let terms = Terms::from_study(&study);
            wrong.points[0] = purchasing.point(AimReport::All, &terms, &answer, Vec::new());
            let error = verify(wrong).unwrap_err().to_string();
            let claim = "points[0].best_of_cost: this set passes, costs no more and is better";
            assert!(error.contains(claim), "case {case}: {error}\n{text}");
        }
        if let Some(ties) = found.ties {
            let mut wrong = report.clone();
            wrong.points[0].ties = Some(if ties == MOST_TIES { 0 } else { ties + 1 });
            let error = verify(wrong).unwrap_err().to_string();
            assert!(error.contains("points[0].ties: is "), "case {case}: {error}\n{text}");
        }
        let dearer = passing.iter().map(|(set, _)| set).find(|set| Some(cost_of(set)) > cost);
        if let Some(dearer) = dearer.filter(|_| purchase.then.is_none()) {
            let cost = cost_of(dearer);
            let best = Some(FoundPurchase { set: dearer.clone(), cost, worth: None });
            let answer = CheapestAnswer { best, no_set_below: Some(cost), ..CheapestAnswer::NONE };
            let mut wrong = report.clone();
            wrong.points[0] =
                purchasing.point(AimReport::All, &Terms::from_study(&study), &answer, Vec::new());
            let error = verify(wrong).unwrap_err().to_string();
            let claim = "points[0].no_set_below: this set passes";
            assert!(error.contains(claim), "case {case}: {error}: {:?}, {passing:?}\n{text}", report.main());
            refused += 1;
        }
        if cost.is_some() {
            some += 1
        } else {
            none += 1
        }
        // A more expensive set for a number of requirements is refused, and so is another list of missed ones.
        for (number, point) in report.points.iter().enumerate() {
            let (AimReport::Number(least), Some(set)) = (&point.aim, &point.set) else { continue };
            let refuse = |point: PurchasePoint, key: &str| {
                let mut wrong = report.clone();
                wrong.points[number] = point;
                let message = verify(wrong).err().map_or("it holds".into(), |error| error.to_string());
                let place = format!("points[{number}].{key}");
                assert!(
                    message.contains(&place),
                    "case {case}, {place}: {message}\n{:?}\n{text}",
                    report.points
                );
            };
            let missed = match point.missed.is_empty() {
                true => vec![study.requirements[0].name.clone()],
                false => Vec::new(),
            };
            refuse(PurchasePoint { missed, ..point.clone() }, "missed");
            let is_dearer = |one: &&JudgedSet| {
                one.missed.len() <= count - least && cost_of(&one.set) > set.cost.thousandths()
            };
            if let Some(dearer) = judged.iter().find(is_dearer).filter(|_| purchase.then.is_none()) {
                let cost = cost_of(&dearer.set);
                let best = Some(FoundPurchase { set: dearer.set.clone(), cost, worth: None });
                let answer = CheapestAnswer { best, no_set_below: Some(cost), ..CheapestAnswer::NONE };
                let terms = Terms::from_study(&study);
                let wrong = purchasing.point(point.aim.clone(), &terms, &answer, Vec::new());
                refuse(
                    PurchasePoint { missed: dearer.missed.clone(), ..wrong },
                    "no_set_below: this set passes",
                );
                dear += 1;
            }
        }
    }
    assert!(some > 2 && none > 2 && refused > 0, "{some} passed, {none} did not, {refused} were refused");
    assert!(
        cheaper > 2 && dear > 2,
        "{cheaper} cost less or are there by a number of requirements, {dear} were refused"
    );
    assert!(bound > 0 && ties > 0, "{bound} were bound by disturb, {ties} had others of the same cost");
    assert!(decided[1..].iter().all(|&one| one > 0), "{decided:?} were decided by F1, overlap, distance");
}

/// Stores progress reports; stops the search after a number of them.
#[derive(Default)]
struct Reports {
    all: Mutex<Vec<PurchaseState>>,
    most: Option<usize>,
}

impl Progress for Reports {
    fn stop_reason(&self) -> Option<String> {
        let most = self.most?;
        (self.all.lock().unwrap().len() >= most).then(|| "stopped".into())
    }

    fn show_purchase(&self, state: &PurchaseState) {
        self.all.lock().unwrap().push(state.clone());
    }
}

/// Asserts that the reports of each part lead to its point, and that none claims too much.
#[track_caller]
fn assert_reports(all: &[PurchaseState], answer: &PurchaseReport) {
    let mut parts: Vec<&[PurchaseState]> = all.chunk_by(|a, b| a.part == b.part).collect();
    assert!(parts.iter().enumerate().all(|(number, own)| own[0].part == number));
    // If leaving out some requirements is not enough, more are left out.
    parts.retain(|own| own[0].title != "nearest" || own.last().is_some_and(|last| last.best.is_some()));
    assert_eq!(parts.len(), answer.points.len());
    for (own, point) in parts.into_iter().zip(&answer.points) {
        let cost = point.set.as_ref().map(|set| set.cost.thousandths());
        let bound = point.no_set_below.map(Cost::thousandths);
        let last = own.last().unwrap();
        assert_eq!(last.title, point.aim.title());
        let found = last.best.as_ref().map(|best| (best.cost, best.score));
        assert_eq!(found, point.set.as_ref().map(|set| (set.cost.thousandths(), set.score)));
        assert_eq!((last.no_set_below, last.is_proven), (bound, point.proven), "{last:?}");
        assert!(last.tested >= point.tested, "{last:?}");
        for state in own {
            assert!(
                cost.is_none_or(|cost| state.no_set_below.is_some_and(|below| below <= cost)),
                "{state:?}"
            );
            if let Some(best) = &state.best {
                assert!(cost.is_some_and(|cost| best.cost >= cost), "{state:?}");
                let costs = best.sensors.iter().map(|one| answer.asked.sensors[&one.sensor].cost.unwrap());
                let sum: u64 = costs.map(Cost::thousandths).sum();
                assert_eq!(best.cost, sum, "{best:?}");
            }
        }
        for pair in own.windows(2) {
            let costs = [&pair[0], &pair[1]].map(|state| state.best.as_ref().map(|best| best.cost));
            assert!(costs[0].is_none() || costs[1].is_some() && costs[1] <= costs[0], "{pair:?}");
            assert!(pair[0].tested <= pair[1].tested, "{pair:?}");
            assert!(pair[1].no_set_below.is_none_or(|next| pair[0].no_set_below <= Some(next)), "{pair:?}");
        }
    }
}

/// Progress reports never exceed the result, and do not change it.
#[test]
fn reports_lead_to_the_answer() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    let (mut improved, mut raised, mut kept) = (0, 0, 0);
    for (case, front) in (0..16).zip(["speed", "requirements"].into_iter().cycle()) {
        let text = made_up_study(&mut Random(case * 7919));
        std::fs::write(&path, text + &format!("front = \"{front}\"\n")).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let Some(Wanted::Cheapest(purchase)) = &study.choose else { panic!("no question") };
        let worlds = World::prepare_all(&study).unwrap();
        let quiet = Purchasing::new(&study, purchase, &worlds, 1 << 30).unwrap();
        let casting = quiet.begin_casting(None, false).unwrap();
        let evidence = casting.finish(&mut open().unwrap(), 1, &|| None).unwrap().of_regions;
        let answer = quiet.search(&evidence, &quiet.look(&|| None).unwrap(), &open, &|| None).unwrap();
        let purchasing = Purchasing::new(&study, purchase, &worlds, 1 << 30).unwrap().with_all_reports();
        let ways = purchasing.look(&|| None).unwrap();
        let reports = Reports::default();
        assert_eq!(purchasing.search(&evidence, &ways, &open, &reports).unwrap(), answer);
        let all = reports.all.into_inner().unwrap();
        assert_reports(&all, &answer);
        let of_one = |a: &PurchaseState, b: &PurchaseState| a.part == b.part;
        for own in all.chunk_by(of_one) {
            let mut sets: Vec<_> = own.iter().filter_map(|state| state.best.as_ref()).collect();
            sets.dedup();
            improved += usize::from(sets.len() > 1);
            let bounds: BTreeSet<u64> = own.iter().filter_map(|state| state.no_set_below).collect();
            raised += usize::from(bounds.len() > 2);
        }
        // Wherever it is stopped, reported sets and bounds remain in the answer.
        for most in 1..all.len().min(30) {
            let reports = Reports { most: Some(most), ..Reports::default() };
            let cut = purchasing.search(&evidence, &ways, &open, &reports).unwrap();
            let all = reports.all.into_inner().unwrap();
            assert_reports(&all, &cut);
            kept += usize::from(cut.points.iter().any(|point| point.set.is_some() && !point.proven));
        }
    }
    assert!(improved > 2 && raised > 2 && kept > 2, "{improved} improved, {raised} raised, {kept} kept");
}

/// A stopped search reports that it is incomplete, or has found everything.
#[test]
fn a_stopped_search_is_marked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("study.toml");
    std::fs::write(folder.path().join("cell.toml"), SCENE).unwrap();
    let (mut cut, mut passing) = (0, 0);
    for (case, front) in (0..12).zip(["speed", "requirements"].into_iter().cycle()) {
        let text = made_up_study(&mut Random(case * 7919));
        std::fs::write(&path, text + &format!("front = \"{front}\"\n")).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let Some(Wanted::Cheapest(purchase)) = &study.choose else { panic!("no question") };
        let worlds = World::prepare_all(&study).unwrap();
        let purchasing = Purchasing::new(&study, purchase, &worlds, 1 << 30).unwrap();
        let casting = purchasing.begin_casting(None, false).unwrap();
        let evidence = casting.finish(&mut open().unwrap(), 1, &|| None).unwrap().of_regions;
        let ways = purchasing.look(&|| None).unwrap();
        let whole = purchasing.search(&evidence, &ways, &open, &|| None).unwrap();
        assert!(!whole.stopped && whole.points.len() > 1);
        passing += usize::from(whole.main().set.is_some());
        for most in [0, 1, 2, 3, 5, 8, 13, 21, 34, 55] {
            let calls = AtomicUsize::new(0);
            let stop = || (calls.fetch_add(1, Relaxed) >= most).then(|| "stopped".to_string());
            match purchasing.search(&evidence, &ways, &open, &stop) {
                Ok(report) if report.stopped => {
                    let input = purchasing.proof_input(&evidence, &|| None);
                    let verified = PurchaseClaims::new(Path::new(""), report, input)
                        .and_then(|claims| verify_points(&claims, input, &open));
                    assert!(verified.is_ok(), "{front}, stopped after {most}: {verified:?}");
                    cut += 1;
                }
                Ok(report) => assert_eq!(report.points, whole.points, "{front}, stopped after {most}"),
                // A stopped judgement is an error.
                Err(error) => assert!(matches!(error, Error::Stopped(_)), "{error}"),
            }
        }
    }
    assert!(cut > 20 && passing > 0 && passing < 12, "{cut} stopped, {passing} passing");
}
