//! The shipped studies.

use super::random::check_combination;
use super::*;

/// All TOML files below a folder.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        match path.is_dir() {
            true => all.extend(files(&path)),
            false if path.extension().is_some_and(|end| end == "toml") => all.push(path),
            false => {}
        }
    }
    all.sort();
    all
}

/// The shipped studies with their texts: files that have sensors.
fn studies() -> Vec<(PathBuf, String)> {
    let texts = files(&root().join("scenes")).into_iter().map(|path| {
        let text = std::fs::read_to_string(&path).unwrap();
        (path, text)
    });
    texts.filter(|(_, text)| text.contains("\n[[scene]]") && text.contains("[[sensor]]")).collect()
}

#[test]
fn a_file_goes_through_byte_for_byte() {
    let all = files(&root().join("scenes"));
    assert!(all.len() > 20, "{all:?}");
    for path in all {
        let text = std::fs::read_to_string(&path).unwrap();
        let mut document = Document::new(text.clone());
        assert_eq!(document.text(), text, "{}", path.display());
        // As it does through what finds its keys.
        assert_eq!(Source::new(text.clone()).unwrap().into_text(), text, "{}", path.display());
        let known = Known::default();
        document.apply(&Edit::SetText { text: "changed".into() }, None, &known).unwrap();
        document.undo();
        assert_eq!(document.text(), text, "{}", path.display());
    }
}

#[test]
fn edited_shipped_studies_load_with_their_plan() {
    let studies = studies();
    assert!(studies.len() > 10, "{}", studies.len());
    for (path, text) in studies {
        let study = load(&path, &text);
        let known = Known::new(&study);
        let mut document = Document::new(text.clone());
        let mut expected = document.plan(&known).unwrap();
        let before = expected.len();
        // A listed pose of each sensor, and a dragged one of each that can be dragged.
        for sensor in &known.sensors {
            let (pose, _) = sensor.poses.last().unwrap();
            let placed = PlacedName::new(&sensor.name, pose);
            if !expected.contains(&placed) {
                document.apply(&place(&sensor.name, pose), None, &known).unwrap();
                expected.push(placed);
            }
        }
        check_combination(&load(&path, document.text()), &document.plan(&known).unwrap());
        assert_eq!(document.plan(&known).unwrap().len(), expected.len(), "{}", path.display());
        for sensor in known.sensors.iter().filter(|sensor| sensor.is_posed) {
            let plan = document.plan(&known).unwrap();
            let index = plan.iter().position(|placed| placed.sensor == sensor.name).unwrap();
            let at = at([0.25, -0.125, 1.5], 33.0, 0.0);
            let changed = document.apply(&Edit::Move { index, at }, None, &known);
            let changed = changed.unwrap_or_else(|e| panic!("{}: {e}", path.display())).unwrap();
            let study = load(&path, document.text());
            let plan = document.plan(&known).unwrap();
            check_combination(&study, &plan);
            let own = Known::new(&study);
            let moved = own.sensors.iter().find(|other| other.name == sensor.name).unwrap();
            let (_, pose) = moved.poses.iter().find(|(name, _)| *name == plan[changed].pose).unwrap();
            assert_eq!(*pose, Some(rounded(&at, sensor.stance)), "{}: {}", path.display(), sensor.name);
            // All that could be placed before still can be, where it was.
            let kept =
                |(name, pose): &(String, _)| moved.poses.iter().any(|(own, at)| own == name && at == pose);
            assert!(sensor.poses.iter().all(kept), "{}: {}", path.display(), sensor.name);
        }
        assert!(keeps_comments(&text, document.text()), "{}\n{}", path.display(), document.text());
        // Taken away again, nothing of the plan is left.
        for _ in 0..expected.len() {
            document.apply(&Edit::Remove { index: 0 }, None, &known).unwrap();
        }
        assert!(before > 0 || !document.text().contains("\"planned"), "{}", document.text());
        load(&path, document.text());
    }
}

#[test]
fn each_device_of_the_catalogue_that_needs_no_more_keys_can_be_added() {
    let path = root().join("scenes/tutorial/study.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    let known = Known::new(&load(&path, &text));
    let mut refused = Vec::new();
    for model in &known.models {
        let mut document = Document::new(text.clone());
        let to = at([0.25, -0.5, 2.0], 120.0, if model.stance == Stance::Facing { -30.0 } else { 0.0 });
        let add = Edit::Add { device: Device::Model(model.name.clone()), at: to, cost: Some(100.0) };
        let index = document.apply(&add, None, &known).unwrap().unwrap();
        let sources = Sources::from_main(&path).with_file(&path, document.text().into());
        // Some devices need more keys, as the size of a mat.
        let study = match Study::read(&path, &Overrides::default(), sources) {
            Ok(study) => study,
            Err(e) => {
                refused.push(format!("{}: {e}", model.name));
                continue;
            }
        };
        let (placed, own) = (document.plan(&known).unwrap()[index].clone(), Known::new(&study));
        let sensor = own.sensors.iter().find(|sensor| sensor.name == placed.sensor).unwrap();
        assert_eq!(sensor.stance, model.stance, "{}", model.name);
        assert_eq!(
            sensor.poses,
            [("planned/0".to_string(), Some(rounded(&to, model.stance)))],
            "{}",
            model.name
        );
    }
    // Noise that is unknown stands beside no other, some devices need more keys, as a curtain its box, and a radar the
    // speed of people.
    let is_right = |words: &String| {
        let known = ["noise of sensor", "safety-mat: ", "light-curtain: ", "needs the speed of people"];
        known.iter().any(|part| words.contains(part))
    };
    assert!(refused.iter().all(is_right) && refused.len() < known.models.len() / 2, "{refused:#?}");
}
