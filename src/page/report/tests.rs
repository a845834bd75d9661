//! Every aggregate of the example, compared with values worked out by hand.

use super::ReportSelection;
use super::maximum::{Maximum, maxima, most_sensors};
use super::series::{Series, worst_snapshot};
use super::terminal::{best, distribution, groups, maxima, moving_scenes, reasons};
use perirobot_march::Error;
use perirobot_march::metrics::{Detection, Score};
use perirobot_sweep::results::example::{NO_SCORE, counts, example, results, results_in, worked_counts};
use perirobot_sweep::results::{Results, RowKey};

fn key(combination: usize, choice: usize, representation: usize) -> RowKey {
    RowKey { combination, choice, representation, region: 0 }
}

fn all(results: &Results, scores: &[Score]) -> ReportSelection {
    ReportSelection::resolve(results, None, None, scores).unwrap()
}

#[test]
fn counts_are_found_by_name() {
    // Each count encodes its own place.
    let results = results(2, |moment, repeat, key| {
        let digits = [moment, repeat, key.combination, key.choice, key.representation];
        counts(digits.iter().fold(0, |n, digit| n * 10 + *digit as u64))
    });
    assert_eq!(results.counts(2, 1, &key(1, 1, 0)).unwrap().uf, 21110);
    assert_eq!(results.counts(0, 0, &key(0, 2, 0)).unwrap().uf, 20);
    assert_eq!(results.counts(1, 0, &key(1, 0, 1)).unwrap().uf, 10101);
    // Both repeats of moments 1 and 2: unknown 10, 1010 + 10000, 20000, 21000 and one found voxel each.
    let over = results.summarize(1..3, key(0, 0, 0), Score::F1).unwrap().unwrap();
    let pooled = 8.0 / (8.0 + (10000 + 11000 + 20000 + 21000) as f64);
    assert_eq!((over.pooled, over.values), (Some(pooled), 4));
    assert_eq!(over.worst, 2.0 / 21002.0);
}

#[test]
fn scores_over_scenes_and_snapshots() {
    let results = example();
    let over = results.summarize(0..3, key(0, 0, 0), Score::F1).unwrap().unwrap();
    // (1 + 1/4 + 1/2) / 3; 3 found, 8 unknown.
    assert_eq!((over.mean, over.worst, over.pooled), (1.75 / 3.0, 0.25, Some(6.0 / 14.0)));
    let some = results.summarize(0..3, key(0, 2, 0), Score::F1).unwrap().unwrap();
    assert_eq!((some.mean, some.values, some.of), (2.0 / 3.0, 1, 3));
    assert_eq!(results.summarize(0..1, key(0, 2, 0), Score::F1).unwrap(), None);
    let baselines = results.baselines_over(1..3, 0, Score::F1).map(|(_, over)| over.map(|o| o.mean));
    assert_eq!(baselines, [Some(1.0), Some(0.2), Some(0.1), None]);
}

#[test]
fn maxima_per_scene_and_their_mean() {
    let results = example();
    let camera = maxima(&results, 0, 0, Score::F1).unwrap();
    let at = |value, choice, representation| Some(Maximum { value, choice, representation });
    // Still: 1 beats 1/2. Moving: 3/8, 1/2 and 2/3, which only one snapshot has.
    assert_eq!(camera.scenes, [at(1.0, 0, 0), at(2.0 / 3.0, 2, 0)]);
    assert_eq!(camera.mean, Some((1.0 + 2.0 / 3.0) / 2.0));
    let pair = maxima(&results, 1, 0, Score::F1).unwrap();
    // The first of equal ones is named.
    assert_eq!(pair.scenes, [at(1.0, 1, 1), at(0.5, 0, 0)]);
    assert_eq!((pair.mean, most_sensors(&results)), (Some(0.75), Some(1)));
    let text = maxima::render(&results, &all(&results, &[Score::F1])).unwrap();
    // (5/6) / (3/4) = 10/9.
    for line in [
        "  camera                 1.000   0.667  0.833     1.111\n",
        "  pair                   1.000   0.500  0.750     1.000\n",
        "  baseline all occupied  0.200   0.200  0.200\n",
        "  camera       still   left/0                                       wall, x 0.0 m, 3.0 m high\n",
        "               moving  right/0                                      wall, x 2.0 m, 3.0 m high\n",
        "  pair         still   camera:left/0;pads:floor/1 as box;volume     camera: wall, x 0.0 m, 3.0 m high; pads: wall, x 1.0 m, 3.0 m high\n",
        "as a part of that mean of pair.",
        "F1 in region robot",
    ] {
        assert!(text.contains(line), "no {line:?} in {text}");
    }
}

#[test]
fn nothing_is_relative_without_one_largest_combination() {
    let mut results = example();
    results.subject.combinations[1].members.pop();
    assert_eq!(most_sensors(&results), None);
    let text = maxima::render(&results, &all(&results, &[Score::F1])).unwrap();
    assert!(!text.contains("as a part of") && text.contains("0.833         –"), "{text}");
    results.subject.combinations.truncate(1);
    assert_eq!(maxima::render(&results, &all(&results, &[Score::F1])).unwrap(), "");
}

#[test]
fn the_best_of_each_wall() {
    let results = example();
    let found = groups::groups(&results, [0, 0, 0], &(1..3), Score::F1).unwrap();
    let plain: Vec<_> = found.iter().map(|g| (g.group.as_str(), g.best, g.overall)).collect();
    // In the moving scene the second pose is the better of the left wall: 1/2 against 3/8.
    assert_eq!(plain, [("left", Some((1, 0.5)), false), ("right", Some((2, 2.0 / 3.0)), true)]);
    let still = groups::groups(&results, [0, 0, 0], &(0..1), Score::F1).unwrap();
    let plain: Vec<_> = still.iter().map(|g| (g.best, g.overall)).collect();
    assert_eq!(plain, [(Some((0, 1.0)), true), (None, false)]);
    let text = groups::render(&results, &all(&results, &[Score::F1])).unwrap();
    assert!(
        text.contains(
            "moving  camera · points               left                   0.500     left/1   wall, x 1.0 m, 3.0 m high\n"
        ),
        "{text}"
    );
    assert!(text.contains("right                  0.667  *  right/0  wall, x 2.0 m, 3.0 m high\n"), "{text}");
    assert!(text.contains("baseline all occupied  0.200\n"), "{text}");
    assert!(!text.contains("pair"), "two posed sensors are at no wall: {text}");
}

#[test]
fn the_best_over_snapshots_by_mean_and_by_worst() {
    // The first pose now has 1/4 and 1: the better mean, the worse worst.
    let better = |moment, key: &RowKey| match (moment, key.combination, key.choice) {
        (2, 0, 0) => counts(0),
        _ => worked_counts(moment, key),
    };
    let results = results(1, |moment, _, key| better(moment, key));
    let moving = results.scenes[1].clone();
    assert_eq!(worst_snapshot(&results, &moving, key(0, 0, 0), Score::F1).unwrap(), Some(0));
    assert_eq!(worst_snapshot(&results, &moving, key(0, 2, 0), Score::F1).unwrap(), Some(1));
    let results =
        perirobot_sweep::results::example::results(1, |moment, _, key| match (key.combination, key.choice) {
            (0, 2) => NO_SCORE,
            _ => better(moment, key),
        });
    assert_eq!(worst_snapshot(&results, &moving, key(0, 2, 0), Score::F1).unwrap(), None);
    let text = moving_scenes::render(&results, &all(&results, &[Score::F1])).unwrap();
    for line in [
        // Pooled: 2 found, 6 unknown.
        "  moving  camera · points               mean     0.625  0.250   0   0.400  left/0                      wall, x 0.0 m, 3.0 m high\n",
        "  moving  camera · points               worst    0.500  0.500   0   0.500  left/1                      wall, x 1.0 m, 3.0 m high\n",
    ] {
        assert!(text.contains(line), "no {line:?} in {text}");
    }
    assert!(!text.contains("still"), "{text}");
    let mut results = example();
    results.subject.scenes.remove(1);
    assert_eq!(moving_scenes::render(&results, &all(&results, &[Score::F1])).unwrap(), "");
}

#[test]
fn distributions_stand_beside_their_baselines() {
    let results = example();
    let text = distribution::render(&results, &all(&results, &[Score::F1])).unwrap();
    for line in [
        // 3/8, 1/2 and 2/3: quartiles halfway, 7/16 and 7/12.
        "  moving  camera · points               3  0.375    0.438   0.500    0.583  0.667  |  1.000    0.200     0.100        –",
        "  still   camera · points               2  0.500    0.625   0.750    0.875  1.000  |",
    ] {
        assert!(text.contains(line), "no {line:?} in {text}");
    }
    let of_one =
        ReportSelection::resolve(&results, Some("robot"), Some("pair"), &[Score::HumanSeen]).unwrap();
    let text = distribution::render(&results, &of_one).unwrap();
    assert!(text.contains("pair · box;volume") && !text.contains("camera ·"), "{text}");
    assert!(text.contains("0    –        –       –        –    –  |"), "nobody is in the region: {text}");
}

/// Counts that cannot be read are never zeros in a table.
#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_fails_fails_every_table() {
    use perirobot_sweep::results::{example::unreadable, rows, scores, table::TableFormat};
    let (results, folder) = (unreadable(), tempfile::tempdir().unwrap());
    let (selection, moving) = (all(&results, &[Score::F1]), &results.scenes[1]);
    for (what, made) in [
        ("best", best::render(&results).map(drop)),
        ("distribution", distribution::render(&results, &selection).map(drop)),
        ("maxima", maxima::render(&results, &selection).map(drop)),
        ("groups", groups::render(&results, &selection).map(drop)),
        ("snapshots", moving_scenes::render(&results, &selection).map(drop)),
        ("worst", worst_snapshot(&results, moving, key(0, 0, 0), Score::F1).map(drop)),
        ("leaders", reasons::leaders(&results, 1, &[Score::F1]).map(drop)),
        ("leader", reasons::leader(&results, 0, Score::F1).map(drop)),
        ("results", rows::write(&results, folder.path(), TableFormat::Csv)),
        ("scores", scores::write(&results, folder.path(), TableFormat::Csv)),
    ] {
        assert!(
            matches!(&made, Err(Error::Storage(text)) if text.to_string().contains("cannot be read")),
            "{what}: {made:?}"
        );
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "no half of a table is left");
}

fn scores_csv(results: &Results) -> String {
    let folder = tempfile::tempdir().unwrap();
    perirobot_sweep::results::scores::write(
        results,
        folder.path(),
        perirobot_sweep::results::table::TableFormat::Csv,
    )
    .unwrap();
    std::fs::read_to_string(folder.path().join("scores.csv")).unwrap()
}

#[test]
fn the_table_for_pandas() {
    let two_repeats = results(2, |moment, repeat, key| match key.choice {
        0 => counts([0, 2][repeat]),
        _ if moment == 0 => NO_SCORE,
        _ => counts(2),
    });
    let text = scores_csv(&two_repeats);
    let mut lines = text.lines();
    let of_score =
        |s: &Score| ["mean", "std", "worst", "pooled", "n"].map(|of| format!("{}_{of}", s.name())).join(",");
    let of_scores = |scores: &[Score]| scores.iter().map(of_score).collect::<Vec<_>>().join(",");
    assert_eq!(
        lines.next().unwrap(),
        "scene,combination,poses,representation,region,".to_string()
            + &of_scores(&Score::ALL[..8])
            + ",worst_part,worst_part_missed,"
            + &of_scores(&Score::ALL[8..])
    );
    let lines: Vec<&str> = lines.collect();
    assert_eq!(lines.len(), 3 * (3 + 2 * 2), "two scenes and all");
    // Repeats 1 and 1/2: the root of 2/16; pooled 4/6. κ: one found alone agrees by chance (no value), one of
    // three is (3·1 − 1·1 − 0·2) / (9 − 1); pooled (4·2 − 2·2) / (16 − 4).
    let std = 0.125f64.sqrt();
    let nobody = ",,,,,0".repeat(4);
    let unknown: f64 = 2.0 / 3.0 / 2.0;
    assert_eq!(
        lines[0],
        format!(
            "still,camera,camera:left/0,points,robot,0.75,{std},0.5,{},2,0.25,,0.25,{},1{nobody},{},{},{},0.5,2,,,,,0,,0,0,0,0,0,2",
            4.0 / 6.0,
            4.0 / 12.0,
            unknown,
            (unknown * unknown + (2.0 / 3.0 - unknown) * (2.0 / 3.0 - unknown)).sqrt(),
            2.0 / 3.0,
        )
    );
    assert_eq!(
        lines[1],
        format!("still,camera,camera:left/1,points,robot,,,,,0,,,,,0{nobody},,,,,0,,,,,0,,0,,,,,0")
    );
    let begin = "moving,camera,camera:left/1,points,robot,0.5,0,0.5,0.5,4,0.25,0,0.25,0.25,4";
    assert!(lines[8].starts_with(&format!("{begin}{nobody},")), "{}", lines[8]);
    assert!(lines[15].starts_with("*,camera,camera:left/1,points,robot,0.5,0,0.5,0.5,4,"), "{}", lines[15]);
    let one = scores_csv(&example());
    assert!(
        one.contains("\nstill,camera,camera:left/1,points,robot,0.5,,0.5,0.5,1,"),
        "no spread of one repeat: {one}"
    );
}

/// Missed in one row of three, in two, and in none.
#[test]
fn the_part_that_is_missed_most_is_named() {
    let missed = |moment: usize, choice: usize| match (choice, moment) {
        (0, 0) => 0b11,
        (0, _) => 0b10,
        _ => 0,
    };
    let results = results(1, |moment, _, key| {
        counts(1).with_detection(Detection::from_counts([2, 1, 1, 4, 3], missed(moment, key.choice)))
    });
    let text = scores_csv(&results);
    let end =
        |line: usize| text.lines().nth(line).unwrap().rsplitn(8, ',').skip(5).take(2).collect::<Vec<_>>();
    assert_eq!(end(1), ["1", "head"], "in the still scene head and torso are missed once: {text}");
    assert_eq!(end(15), ["3", "torso"], "{text}");
    assert_eq!(end(16), ["0", ""], "{text}");
    let score = |score| results.summarize(0..3, key(0, 0, 0), score).unwrap().unwrap().mean;
    assert_eq!((score(Score::PartsDetected), score(Score::PeopleDetected)), (0.75, 1.0));
}

#[test]
fn several_sensors_in_one_representation_need_not_name_it() {
    let mut results = example();
    let title = |results: &Results, combination| Series { combination, representation: 0 }.title(results);
    assert_eq!([0, 1].map(|c| title(&results, c)), ["camera · points", "pair · points;volume"]);
    results.subject.combinations[1].representations.pop();
    assert_eq!(title(&results, 1), "pair");
}

#[test]
fn few_combinations_get_a_block_and_many_a_line() {
    let results = example();
    let text = best::render(&results).unwrap();
    for line in [
        "camera · points · region robot: 3 choices of poses, 2 scenes, 3 snapshots\n",
        // κ of one found and n unknown: n / ((n + 1)² − 1), so 1/8 and 1/4, none for n = 0.
        "  best F1              right/0                [1] 0.667  0.667   0.667    [1] 0.333  0.333   0.333",
        // Pooled 3 found, 8 unknown: 6/14 and (11·3 − 3·3) / (11² − 3·3).
        "                       left/0                     0.583  0.250   0.429    [2] 0.188  0.125   0.214",
        "  best human_seen      no choice has a value          –      –       –",
        "  baseline             upper bound ",
        "\n\n  pose     place\n  left/0   wall, x 0.0 m, 3.0 m high\n  left/1   wall, x 1.0 m, 3.0 m high\n  right/0  wall, x 2.0 m",
        "\nOnly the near side of a body can be hit",
    ] {
        assert!(text.contains(line), "no {line:?} in {text}");
    }
    assert!(text.starts_with("\n[n] before a mean: only n of the values"), "before what it explains: {text}");
    assert!(text.lines().all(|line| line.chars().count() <= 160), "{text}");
    let many = results_in(&["robot", "human"], 1, |moment, _, key| worked_counts(moment, key));
    let text = best::render(&many).unwrap();
    for line in [
        "Region human: the best choice of poses, 2 scenes, 3 snapshots\n",
        "  camera · points       [1] 0.667      –  0.667   0.667  right/0                     wall, x 2.0 m, 3.0 m high\n",
        "  pair · box;volume         0.667      –  0.500   0.600  camera:left/0;pads:floor/1  camera: wall, x 0.0 m, 3.0 m high; pads: wall, x 1.0 m, 3.0 m high\n",
        "  baselines: upper bound 1.000, all occupied 0.200, all free 0.100, nothing seen –\n",
        "perirobot summary DIR",
    ] {
        assert!(text.contains(line), "no {line:?} in {text}");
    }
}

#[test]
fn unknown_names_are_refused_with_the_known_ones() {
    let results = example();
    for (region, combination, expected) in [
        (Some("robots"), None, "region robots: must be one of those of the sweep: [\"robot\"]"),
        (None, Some("x"), "combination x: must be one of those of the sweep: [\"camera\", \"pair\"]"),
    ] {
        let error = ReportSelection::resolve(&results, region, combination, &[]).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
}
