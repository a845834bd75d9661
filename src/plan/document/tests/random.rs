//! Random sequences of edits, undo and redo.

use super::*;

/// Small numbers that look random, the same each time.
struct Draws(u64);

impl Draws {
    fn below(&mut self, most: usize) -> usize {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % most.max(1)
    }

    fn pick<'a, T>(&mut self, all: &'a [T]) -> Option<&'a T> {
        all.get(self.below(all.len()))
    }

    fn pose(&mut self) -> Pose6 {
        let mut metres = || self.below(9000) as f64 / 1234.5 - 3.0;
        let position_m = [metres(), metres(), metres()];
        let (pan_deg, tilt_deg) = (self.below(3600) as f64 / 7.0 - 250.0, self.below(180) as f64 - 90.0);
        Pose6 { position_m, pan_deg, tilt_deg, roll_deg: [0.0, 0.0, 12.34][self.below(3)] }
    }

    /// An edit of a plan of some length, most of which fit.
    fn edit(&mut self, known: &Known, length: usize) -> Edit {
        let posed: Vec<&KnownSensor> = known.sensors.iter().filter(|sensor| sensor.is_posed).collect();
        let sensor = self.pick(&posed).expect("a study has sensors");
        let pose = self.pick(&sensor.poses).map_or(String::new(), |(name, _)| name.clone());
        let name = sensor.name.clone();
        let index = self.below(length + 1).min(length.saturating_sub(self.below(4).min(1)));
        match self.below(12) {
            0 | 1 => Edit::Place { sensor: name, pose },
            2 => Edit::Add { device: Device::Sensor(name), at: self.pose(), cost: None },
            3 => Edit::Add {
                device: Device::Model("realsense-d455".into()),
                at: self.pose(),
                cost: Some(700.0),
            },
            4 | 5 => Edit::Move { index, at: self.pose() },
            6 => Edit::Snap { index, pose },
            7 => Edit::Copy { index, at: self.pose() },
            8 | 9 => Edit::Remove { index },
            10 => Edit::SetSensor { index, device: Device::Sensor(name), cost: None },
            _ => Edit::SetCost { sensor: name, cost: self.below(9000) as f64 },
        }
    }
}

/// What is known of a text: of the study that it is.
fn known_of(path: &Path, text: &str) -> Known {
    Known::new(&load(path, text))
}

#[test]
fn undo_and_redo_leave_what_plain_edits_leave() {
    let mut all_fit = 0;
    for number in 0..100 {
        // The longest takes longest.
        let name = match number % 20 {
            0 => "scenes/palletiser/study.toml",
            1..8 => "scenes/quick.toml",
            _ => "scenes/tutorial/study.toml",
        };
        let path = root().join(name);
        let original = std::fs::read_to_string(&path).unwrap();
        let known = known_of(&path, &original);
        let (mut draws, mut document) = (Draws(number as u64), Document::new(original.clone()));
        // Steps of one or more edits, and how many of them are not undone.
        let (mut steps, mut done) = (Vec::<(Option<u64>, Vec<Edit>)>::new(), 0usize);
        let mut goes_on = false;
        for _ in 0..20 {
            match draws.below(6) {
                0 => {
                    assert_eq!(document.undo(), done > 0);
                    done = done.saturating_sub(1);
                    goes_on = false;
                }
                1 => {
                    assert_eq!(document.redo(), done < steps.len());
                    done = (done + 1).min(steps.len());
                    goes_on = false;
                }
                _ => {
                    let length = document.plan(&known).unwrap().len();
                    let (edit, gesture) =
                        (draws.edit(&known, length), [None, Some(1), Some(2)][draws.below(3)]);
                    let before = document.text().to_string();
                    match document.apply(&edit, gesture, &known) {
                        Err(_) => assert_eq!(document.text(), before),
                        // A step without a change is none, but it ends or begins a gesture.
                        Ok(_) => {
                            let joins = goes_on
                                && gesture.is_some()
                                && steps[..done].last().is_some_and(|(g, _)| *g == gesture);
                            if document.text() != before {
                                all_fit += 1;
                                steps.truncate(done);
                                match joins {
                                    true => steps[done - 1].1.push(edit),
                                    false => steps.push((gesture, vec![edit])),
                                }
                                done = steps.len();
                                goes_on = true;
                            } else if !joins {
                                goes_on = false;
                            }
                        }
                    }
                }
            }
            assert!(keeps_comments(&original, document.text()), "sequence {number}: {}", document.text());
            assert_eq!(
                (document.can_undo(), document.can_redo()),
                (done > 0, done < steps.len()),
                "{number}"
            );
        }
        let plain: Vec<Edit> = steps[..done].iter().flat_map(|(_, edits)| edits.clone()).collect();
        assert_eq!(edited(&original, &known, &plain), document.text(), "sequence {number}: {plain:?}");
        assert_eq!(document.is_changed(), document.text() != original);
        while document.undo() {}
        assert_eq!(document.text(), original);
        assert!(!document.is_changed() && document.difference("study.toml").is_empty());
    }
    assert!(all_fit > 600, "only {all_fit} edits fitted");
}

/// After each edit the study loads, and its plan is what an independent list of sensors and places says.
#[test]
fn every_edited_study_has_the_plan_of_a_plain_list() {
    for (number, name) in [
        "scenes/tutorial/study.toml",
        "scenes/quick.toml",
        "scenes/cheapest.toml",
        "scenes/palletiser/study.toml",
    ]
    .iter()
    .cycle()
    .take(12)
    .enumerate()
    {
        let path = root().join(name);
        let original = std::fs::read_to_string(&path).unwrap();
        let (mut draws, mut document) = (Draws(1000 + number as u64), Document::new(original));
        let mut known = known_of(&path, document.text());
        // Of each placed sensor its name and where it is; of a model the name that the study gives it.
        let mut plan: Vec<(String, perirobot_scene::pose::Pose)> = Vec::new();
        for placed in document.plan(&known).unwrap() {
            plan.push((placed.sensor.clone(), pose_of(&known, &placed)));
        }
        for _ in 0..10 {
            let edit = draws.edit(&known, plan.len());
            let names: Vec<String> = known.sensors.iter().map(|sensor| sensor.name.clone()).collect();
            let Ok(changed) = document.apply(&edit, None, &known) else { continue };
            let study = load(&path, document.text());
            known = Known::new(&study);
            let stance = |name: &str| known.sensors.iter().find(|sensor| sensor.name == name).unwrap().stance;
            match &edit {
                Edit::Place { sensor, pose } => {
                    plan.push((sensor.clone(), pose_of(&known, &PlacedName::new(sensor, pose))));
                }
                Edit::Add { device: Device::Sensor(sensor), at, .. } => {
                    plan.push((sensor.clone(), rounded(at, stance(sensor))));
                }
                Edit::Add { at, .. } => {
                    let new = known.sensors.iter().find(|sensor| !names.contains(&sensor.name)).unwrap();
                    plan.push((new.name.clone(), rounded(at, new.stance)));
                }
                Edit::Move { index, at } => plan[*index].1 = rounded(at, stance(&plan[*index].0)),
                Edit::Snap { index, pose } => {
                    plan[*index].1 = pose_of(&known, &PlacedName::new(&plan[*index].0, pose));
                }
                Edit::Copy { index, at } => {
                    let sensor = plan[*index].0.clone();
                    plan.push((sensor.clone(), rounded(at, stance(&sensor))));
                }
                Edit::Remove { index } => drop(plan.remove(*index)),
                Edit::SetSensor { index, device: Device::Sensor(sensor), .. }
                    if plan[*index].0 != *sensor =>
                {
                    let pose = pose_of(&known, &document.plan(&known).unwrap()[changed.unwrap()]);
                    let (was, is) = (Pose6::new(&plan[*index].1).rounded(), Pose6::new(&pose).rounded());
                    assert_eq!(was.position_m, is.position_m);
                    plan[*index] = (sensor.clone(), pose);
                }
                _ => {}
            }
            // The file lists sensors by their names, each in the order in which it joined.
            let mut order: Vec<String> = Vec::new();
            plan.iter().for_each(|(name, _)| {
                if !order.contains(name) {
                    order.push(name.clone())
                }
            });
            plan.sort_by_key(|(name, _)| order.iter().position(|other| other == name));
            let placed = document.plan(&known).unwrap();
            let found: Vec<_> = placed.iter().map(|one| (one.sensor.clone(), pose_of(&known, one))).collect();
            assert_eq!(found, plan, "{name}: {edit:?}\n{}", document.text());
            check_combination(&study, &placed);
        }
    }
}

/// Where a placed sensor is, as the study that was read has it.
fn pose_of(known: &Known, placed: &PlacedName) -> perirobot_scene::pose::Pose {
    let sensor = known.sensors.iter().find(|sensor| sensor.name == placed.sensor).unwrap();
    sensor.poses.iter().find(|(name, _)| *name == placed.pose).unwrap().1.unwrap()
}

/// The study's own combination has one choice, of the placed poses.
#[track_caller]
pub(super) fn check_combination(study: &Study, placed: &[PlacedName]) {
    let combination = study.combinations.iter().find(|combination| combination.name == PLANNED);
    let Some(combination) = combination else {
        assert!(placed.is_empty(), "{placed:?}");
        return;
    };
    assert_eq!(combination.choices(), 1);
    let choice = combination.choice(0).into_iter().zip(&combination.members);
    let found = choice.map(|(candidate, member)| {
        let sensor = &study.sensors[member.sensor];
        (sensor.name.clone(), sensor.candidates[candidate].name.clone())
    });
    let mut found: Vec<(String, String)> = found.collect();
    let mut placed: Vec<_> = placed.iter().map(|one| (one.sensor.clone(), one.pose.clone())).collect();
    found.sort();
    placed.sort();
    assert_eq!(found, placed);
}
