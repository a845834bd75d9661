use std::path::Path;

use super::*;
use perirobot_march::backend::cpu::Cpu;
use perirobot_study::input::{Overrides, Study};

/// The tiny study's cell.
fn tiny() -> (Study, World) {
    let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../..")).join("scenes/tiny.toml");
    let study = Study::load(&path, &Overrides::default()).unwrap();
    let world = World::prepare(&study, 0).unwrap().remove(0);
    (study, world)
}

fn wish() -> Wish {
    Wish {
        eye: Eye::Towards(DVec3::new(1.0, 0.7, 0.8)),
        look_at_m: None,
        fov_rad: 0.8,
        size_px: [160, 160],
        colour: Colour::Role,
        only_region: None,
        cut_above_m: None,
        open_m: 0.1,
        points: 100,
        ways: Vec::new(),
        case: String::new(),
    }
}

/// A curtain in the tiny study, muted or tripped by the table, says so in the legend; one that works does not.
#[test]
fn a_switch_that_detects_nothing_is_named() {
    let (study, _) = tiny();
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(&study.scenes[0].path, folder.path().join("cell.toml")).unwrap();
    for (keys, expected) in
        [("muted_at = [0]", vec!["curtain:here is muted: it detects nothing"]), ("", vec![])]
    {
        let text = format!(
            "[grid]\nvoxel_size_m = 0.1\n[[scene]]\nfile = \"cell.toml\"\n[[region]]\nname = \"low\"\n\
             box = {{ min_m = [-0.5, -0.5, 0.1], max_m = [0.5, 0.5, 1.1] }}\n[[sensor]]\nname = \"curtain\"\nkind = \"gate\"\n\
             box = {{ min_m = [-0.9, -0.6, 1.3], max_m = [-0.8, 0.6, 1.4] }}\n\
             zone = {{ min_m = [-1, -0.6, 0.2], max_m = [1, 0.6, 1.5] }}\n{keys}\n"
        );
        let path = folder.path().join("study.toml");
        std::fs::write(&path, text).unwrap();
        let study = Study::load(&path, &Overrides::default()).unwrap();
        let world = World::prepare(&study, 0).unwrap().remove(0);
        let choice =
            perirobot_decide::view::Choice { combination: 0, choice: 0, representation: 0, repeat: 0 };
        let mut cpu = Cpu::new(Some(1)).unwrap();
        let view = View::new(&study, &world, choice, &mut cpu).unwrap();
        assert_eq!(legend::stuck_sensors(&view), expected);
        // A line more than without.
        let wish = Wish { case: "without camera:wall/0/0".into(), ..wish() };
        draw(&world, Some(&view), &wish, &mut cpu).unwrap();
    }
}

#[test]
fn rays_end_in_the_first_voxel_on_their_way() {
    let (_, world) = tiny();
    let grid = &world.grid;
    let solid = Cut::new(&wish()).solid(&world, DVec3::new(9.0, 9.0, 9.0));
    // From outside the grid, on both sides of it, and from inside.
    for at in [[4.0, 3.0, 5.0], [-4.0, -3.0, -2.0], [0.3, 0.1, 1.2]] {
        let wish = Wish { eye: Eye::At(at.into()), ..wish() };
        let camera = PictureCamera::new(&wish, [64, 64], grid, &solid).unwrap();
        let hits = cast::cast(&solid, grid, &camera, &mut Cpu::new(Some(1)).unwrap()).unwrap();
        assert!(hits.iter().flatten().count() > 500, "{at:?}");
        for (i, hit) in hits.iter().enumerate() {
            let Some(hit) = hit else { continue };
            assert!(solid.get(hit.voxel), "{at:?}: ray {i}: {hit:?}");
            // The entry point of the ray is on the voxel's face, within the deviation of quantised directions.
            let dir = (camera.rotation * camera.direction([i as u32 % 64, i as u32 / 64])).normalize();
            let entry = camera.eye_m + dir * (f64::from(hit.distance_q16) / 65536.0 * grid.voxel_size_m);
            let low = grid.corner_m(hit.voxel);
            let off = (entry - low) / grid.voxel_size_m;
            let face = if hit.step > 0 { 0.0 } else { 1.0 };
            assert!((off[hit.axis] - face).abs() < 0.02, "{at:?}: ray {i}: {off}: {hit:?}");
            assert!(off.min_element() > -0.02 && off.max_element() < 1.02, "{at:?}: ray {i}: {off}");
            // Sampled points between the eye and the voxel are free.
            let before = (0..100).map(|n| camera.eye_m + (entry - camera.eye_m) * (f64::from(n) / 101.0));
            let near = |p: DVec3| perirobot_march::voxel::Grid::voxel_of(grid.position_q16(p));
            let hidden = before.map(near).filter(|voxel| solid.get(*voxel) && *voxel != hit.voxel).count();
            assert!(hidden <= 2, "{at:?}: ray {i}: {hidden} of 100 points lie in voxels");
        }
    }
}

#[test]
fn walls_between_the_eye_and_the_cell_are_taken_off() {
    let (_, world) = tiny();
    let truth = &world.truth();
    let cut = Cut::new(&wish());
    let bounds = truth.occupied.bounds();
    let left = cut.solid(&world, DVec3::new(9.0, 0.0, 9.0));
    // The ceiling and the wall at large x are removed, the opposite ones and those of y stay.
    let layer = |axis: usize, at: i32| {
        left.voxels()
            .filter(|voxel| voxel[axis] == at && !truth.human.get(*voxel) && !truth.robot.get(*voxel))
            .count()
    };
    for axis in [0, 2] {
        assert_eq!(layer(axis, bounds.end()[axis] - 1), 0);
        assert!(layer(axis, bounds.min[axis]) > 50);
    }
    assert!(layer(1, bounds.min[1]) > 50 && layer(1, bounds.end()[1] - 1) > 50);
    let count = |plane: &BitGrid, of: &BitGrid| {
        let mut both = plane.clone();
        both.keep(of);
        both.count()
    };
    assert_eq!(count(&left, &truth.human), truth.human.count(), "people stay");
    assert_eq!(cut.solid(&world, DVec3::ZERO), *truth.occupied, "from within nothing is cut");
    let shut = Cut { open_m: 0.0, ..Cut::new(&wish()) };
    assert_eq!(shut.solid(&world, DVec3::splat(9.0)), *truth.occupied);
    // Layers whose centres are above 0.5 m begin at 0.5 m.
    let low = Cut { above_m: Some(0.5), ..shut };
    let kept = low.solid(&world, DVec3::ZERO);
    let top = truth.grid.corner_m(kept.bounds().end()).z;
    assert!((top - 0.5).abs() < 1e-9, "{top}");
    let region = Cut { only_region: Some(0), above_m: None, open_m: 0.0 }.solid(&world, DVec3::ZERO);
    assert_eq!(region.count(), count(&truth.occupied, &world.regions[0].voxels));
}

#[test]
fn what_cannot_be_drawn_is_said() {
    let (_, world) = tiny();
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut error = |wish: Wish| draw(&world, None, &wish, &mut cpu).unwrap_err().to_string();
    let far = error(Wish { eye: Eye::At(DVec3::new(0.0, 150.0, 0.0)), ..wish() });
    assert!(far.starts_with("from: ") && far.contains("along y, at most 1023"), "{far}");
    let same = error(Wish { eye: Eye::At(DVec3::ONE), look_at_m: Some(DVec3::ONE), ..wish() });
    assert!(same.contains("look at"), "{same}");
    let nothing = error(Wish { cut_above_m: Some(-5.0), ..wish() });
    assert!(nothing.contains("cut above leave nothing"), "{nothing}");
    let unlabelled = error(Wish { colour: Colour::Label, ..wish() });
    assert!(unlabelled.contains("with pose only"), "{unlabelled}");
    let low = error(Wish { size_px: [100, 64], ..wish() });
    assert!(low.starts_with("size: the legend"), "{low}");
}

/// The rows of a picture whose first pixels are as dark as text: ticks at its left edge.
fn marks_at_the_left(canvas: &Canvas) -> usize {
    let bytes = canvas.png().unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
    let mut rgb = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut rgb).unwrap();
    let row = 3 * canvas.size_px()[0] as usize;
    rgb.chunks(row).filter(|row| row[..12].iter().all(|part| *part == legend::INK[0])).count()
}

#[test]
fn from_above_a_picture_lies_as_a_floor_plan_does_and_has_axes() {
    let (_, world) = tiny();
    let solid = Cut::new(&wish()).solid(&world, DVec3::splat(9.0));
    let above = Wish { eye: Eye::Towards(DVec3::Z), size_px: [640, 480], ..wish() };
    let camera = PictureCamera::new(&above, [64, 64], &world.grid, &solid).unwrap();
    let place = |x: f64, y: f64| camera.project(DVec3::new(x, y, 0.0)).unwrap().0;
    let ([left, bottom], [right, top]) = (place(0.0, 0.0), place(1.0, 1.0));
    assert!(right > left && top < bottom, "x is to the right and y up");
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let mut marks = |wish: &Wish| marks_at_the_left(&draw(&world, None, wish, &mut cpu).unwrap());
    assert!(marks(&above) >= 2, "an axis has several marks");
    let nearly = Wish { eye: Eye::Towards(DVec3::new(0.0, 1e-4, 1.0)), ..above.clone() };
    assert_eq!(marks(&nearly), 0, "seen from another side there are no axes");
}
