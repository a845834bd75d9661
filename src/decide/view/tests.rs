use super::*;
use perirobot_march::backend::cpu::Cpu;
use perirobot_march::march::RETURN;
use perirobot_study::input::Overrides;
use perirobot_sweep::scoring::run;

/// A shipped study, with coarse voxels, and its worlds.
fn load_shipped(name: &str, voxel_size_m: f64) -> (Study, Vec<World>) {
    let path = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes").join(name);
    let study =
        Study::load(&path, &Overrides { voxel_size_m: Some(voxel_size_m), noiseless: false }).unwrap();
    let worlds = World::prepare_all(&study).unwrap();
    (study, worlds)
}

/// Views of every n-th row of a study have the counts of its sweep.
fn counts_are_those_of_the_sweep(name: &str, voxel_size_m: f64, every: usize) {
    let (study, worlds) = load_shipped(name, voxel_size_m);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let rows = run(&study, &worlds, &mut cpu).unwrap();
    for row in rows.iter().step_by(every) {
        let here = |world: &&World| (world.scene, world.snapshot) == (row.scene, row.snapshot);
        let world = worlds.iter().find(here).unwrap();
        let choice = Choice {
            combination: row.combination,
            choice: row.choice,
            representation: row.representation,
            repeat: row.repeat,
        };
        let view = View::new(&study, world, choice, &mut cpu).unwrap();
        assert_eq!(view.counts(row.region), row.counts, "{name}: {row:?}");
        let voxels = world.regions[row.region].voxels.voxels().step_by(97);
        voxels.for_each(|voxel| assert!(view.voxels(view.verdict(voxel)).get(voxel)));
    }
}

#[test]
fn a_view_counts_as_a_sweep_does() {
    counts_are_those_of_the_sweep("tiny.toml", 0.1, 7);
    // Pads, a cover and a camera on the robot, fused.
    counts_are_those_of_the_sweep("paper/exp2.toml", 0.1, 1999);
}

#[test]
fn returns_lie_where_they_are_read() {
    let (study, worlds) = load_shipped("tiny.toml", 0.1);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut found = 0;
    for combination in 0..study.combinations.len() {
        let choice = Choice { combination, choice: 0, representation: 0, repeat: 0 };
        let view = View::new(&study, &worlds[0], choice, &mut cpu).unwrap();
        for member in &view.members {
            let Some(cast) = &member.cast else { continue };
            let returns = view.returns(member);
            assert_eq!(returns.len(), cast.ends.iter().filter(|end| end.kind == RETURN).count());
            for ReturnPoint { at_m, voxel, .. } in &returns {
                assert!(cast.planes.occupied.get(*voxel));
                let grid = &worlds[0].grid;
                let centre = grid.corner_m(*voxel) + glam::DVec3::splat(grid.voxel_size_m / 2.0);
                let off = (*at_m - centre).abs().max_element() / grid.voxel_size_m;
                // Distances are rounded to 1/65536 voxels at each crossing.
                assert!(off < 0.502, "{at_m} is not inside {voxel:?}");
            }
            found += returns.len();
        }
    }
    assert!(found > 100);
}

#[test]
fn a_choice_is_found_by_its_names() {
    let (study, worlds) = load_shipped("tiny.toml", 0.1);
    let named = |poses: &str| ChoiceSelector { poses: poses.into(), ..Default::default() };
    for combination in 0..study.combinations.len() {
        let spec = &study.combinations[combination];
        for choice in 0..spec.choices() {
            let whole = perirobot_sweep::results::columns::pose_names(&study, spec, choice);
            let wanted = ChoiceSelector { combination: Some(spec.name.clone()), ..named(&whole) };
            let (world, found) = find(&study, &worlds, &wanted).unwrap();
            assert_eq!(
                (world.scene, found),
                (0, Choice { combination, choice, representation: 0, repeat: 0 })
            );
        }
    }
    let known = perirobot_sweep::results::columns::pose_names(&study, &study.combinations[0], 0);
    let refused = |wanted: ChoiceSelector, expected: &str| {
        let error = find(&study, &worlds, &wanted).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused(
        named("nowhere"),
        &format!(
            "pose nowhere: no such choice of poses: must be sensor:pose as `perirobot check` lists poses, or as in the \
             column `poses` of results.csv, as in {known}"
        ),
    );
    refused(
        ChoiceSelector { combination: Some("x".into()), ..named(&known) },
        "combination x: does not exist; there are ",
    );
    refused(
        ChoiceSelector { representation: Some("x".into()), ..named(&known) },
        "representation x: does not exist",
    );
    refused(ChoiceSelector { scene: Some("x".into()), ..named(&known) }, "scene x: does not exist");
    refused(ChoiceSelector { snapshot: 9, ..named(&known) }, "snapshot 9: must be from 0 to 0");
    refused(ChoiceSelector { repeat: 9, ..named(&known) }, "repeat 9: must be from 0 to 0");
}

#[test]
fn a_choice_is_found_as_the_study_spells_it_and_else_the_nearest_is_named() {
    let (study, worlds) = load_shipped("sensors.toml", 0.1);
    let look = |combination: &str, poses: &str| {
        let (poses, combination) = (poses.into(), Some(combination.into()));
        find(&study, &worlds, &ChoiceSelector { poses, combination, ..Default::default() })
    };
    let found = |combination, poses| look(combination, poses).unwrap().1.choice;
    assert_eq!(found("watch", "Corners /1/0"), found("watch", "watch:corners/1/0"));
    let exact = found("camera and cover", "camera:corners/1/1;cover:0.2");
    assert!(exact > 0);
    assert_eq!(found("camera and cover", "camera:CORNERS/1/1;cover:0.2"), exact);
    assert_eq!(found("camera and cover", "corners/1/1;0.2"), exact, "sensors are known by their order");
    let refused = |combination, poses, expected: &str| {
        let error = look(combination, poses).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    refused("watch", "watch:cornrs/1/0", "poses (did you mean watch:corners/1/0?): must be sensor:pose as ");
    refused(
        "camera and cover",
        "camera:corner/1/1;cover:0.2",
        "(did you mean camera:corners/1/1;cover:0.2?)",
    );
    // One sensor too few, and an unknown name.
    refused("camera and cover", "camera:corners/1/1", "no such choice of poses: must be");
    refused("watch", "watch:bench", "no such choice of poses: must be");
}

#[test]
fn views_of_many_choices_over_the_grid_are_those_made_one_by_one() {
    let (study, worlds) = load_shipped("sensors.toml", 0.1);
    let mut cpu = Cpu::new(Some(1)).unwrap();
    for (combination, spec) in study.combinations.iter().enumerate() {
        let ways = spec.representation_count(&study.sensors);
        let some = (0..spec.choices()).step_by(3).flat_map(|choice| {
            (0..ways).map(move |representation| Choice { combination, choice, representation, repeat: 0 })
        });
        let some: Vec<Choice> = some.collect();
        for world in &worlds {
            let all = Viewer::new(&study, &mut cpu).unwrap().view_grid(world, &some).unwrap();
            for (view, &choice) in all.iter().zip(&some) {
                let one = View::new(&study, world, choice, &mut cpu).unwrap();
                assert_eq!(view.labels, one.labels, "{}: {choice:?}", spec.name);
                let known = one.labels.occupied.count() + one.labels.free.count();
                let bytes = view.label_bytes();
                assert_eq!(bytes.iter().filter(|&&label| label != u8::MAX).count() as u64, known);
            }
        }
    }
}
