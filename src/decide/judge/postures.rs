//! Studies in which a person of `[postures]` stands at a spot, instead of all people of the scenes.

use std::collections::BTreeMap;

use glam::DVec3;

use crate::approach::spot_height_m;
use perirobot_march::error::{Argument, Issue, Site};
use perirobot_march::voxel::Grid;
use perirobot_march::{Error, Result};
use perirobot_scene::objects::build::build;
use perirobot_scene::objects::loaded::read_person;
use perirobot_scene::objects::spec::{MotionSpec, ObjectSpec, SceneSpec, SurfaceSpec};
use perirobot_scene::objects::{Optical, Role};
use perirobot_scene::truth::{RegionShape, voxelize, voxelize_all};
use perirobot_study::input::{Posture, RegionSpec, Study};
use perirobot_study::world::{World, cut_warnings};

/// Free height above the surface that carries a person at a spot, in metres.
const ROOM_M: f64 = 1.8;

/// A study in which one person replaces the people of its scenes, and its worlds.
#[derive(Debug)]
pub(super) struct PostureStudy {
    pub(super) study: Study,
    pub(super) worlds: Vec<World>,
    /// Warnings about the person's place, scene by scene: inside an object, or in the air.
    pub(super) warnings: Vec<String>,
}

impl PostureStudy {
    /// `worlds` are those of the study; only their scenes are made, each on its present grid, so that regions have the
    /// same voxels for every posture.
    ///
    /// # Errors
    /// If the spot is outside the grid, or the grid contains no part of the person; if the person cannot be read; if
    /// the scene cannot be made with the person.
    pub(super) fn new(study: &Study, worlds: &[World], posture: &Posture) -> Result<PostureStudy> {
        let placed = scenes(worlds).map(|scene| Ok((scene[0].scene, place(study, &scene[0], posture)?)));
        let placed: BTreeMap<usize, Posture> = placed.collect::<Result<_>>()?;
        let in_scene = |scene: usize| placed.get(&scene).unwrap_or(posture);
        let mut posture_study =
            PostureStudy { study: with_posture(study, &in_scene), worlds: Vec::new(), warnings: Vec::new() };
        for scene in scenes(worlds) {
            cut_off(study, &scene[0], in_scene(scene[0].scene))?;
            let bounds_m = Some(bounds_m(&scene[0].grid));
            let made = World::prepare(&Study { bounds_m, ..posture_study.study.clone() }, scene[0].scene)?;
            let name = &scene[0].name;
            let own = made[0].warnings.iter().filter(|said| is_about(posture, said));
            posture_study.warnings.extend(own.map(|warning| format!("{name}: {warning}")));
            // Regions around people have moved: a warning if they are cut off on another side.
            let is_new = |region: &usize| {
                let (own, planned) = (cut_at(&made, *region), cut_at(scene, *region));
                own.iter().zip(planned).any(|(own, planned)| *own && !planned)
            };
            let regions: Vec<usize> = (0..study.regions.len()).filter(is_new).collect();
            let cut = cut_warnings(study, &made, &regions).into_iter();
            posture_study
                .warnings
                .extend(cut.map(|warning| format!("{name}: posture {:?}: {warning}", posture.name)));
            posture_study.worlds.extend(made);
        }
        Ok(posture_study)
    }
}

/// Whether a warning of a scene is about its person: the place, and for a person from a file also the mesh. Shipped
/// persons need no warnings, even lying along y.
fn is_about(posture: &Posture, said: &str) -> bool {
    let is_of_file = matches!(posture.person, SurfaceSpec::Mannequin(_));
    let of_object = is_of_file && said.starts_with(&format!("object {:?} ", posture.name));
    of_object || said.starts_with(&format!("person {:?} ", posture.name))
}

/// The sides on which the grid cuts off a region at any moment: the low and the high end of each axis.
fn cut_at(worlds: &[World], region: usize) -> Vec<bool> {
    let each = worlds.iter().map(|world| world.regions[region].cut_at);
    let both = |all: Vec<bool>, one: [[bool; 2]; 3]| {
        all.into_iter().zip(one.into_iter().flatten()).map(|(before, now)| before || now).collect()
    };
    each.fold(vec![false; 6], both)
}

/// Worlds, scene by scene.
fn scenes(worlds: &[World]) -> impl Iterator<Item = &[World]> {
    worlds.chunk_by(|one, next| one.scene == next.scene)
}

/// Bounds that yield the same grid: the centres of its first and last voxels.
fn bounds_m(grid: &Grid) -> [DVec3; 2] {
    let last = grid.window().end().map(|end| end - 1);
    [[0; 3], last].map(|voxel| grid.corner_m(voxel) + grid.voxel_size_m / 2.0)
}

/// The posture of this name.
///
/// # Errors
/// If the study has none of this name.
pub(super) fn find_posture<'s>(study: &'s Study, name: &str) -> Result<&'s Posture> {
    let place = || Site::Argument(Argument("posture"), name.into());
    if study.postures.is_empty() {
        let what = Issue::says(format!("{} has no [postures]", study.path.display()));
        let example = "[postures] people = [\"standing\"], spots = [[1.0, 0.5, 90]]";
        return Err(what
            .with_advice(format!("add them to the study, as in {example}"))
            .with_place(place())
            .into());
    }
    let known: Vec<&str> = study.postures.iter().map(|posture| posture.name.as_str()).collect();
    let found = study.postures.iter().find(|posture| posture.name == name);
    found.ok_or_else(|| Issue::unknown(&known).with_place(place()).into())
}

/// The people of `[postures]` that the grid of each scene cuts off, as warnings. Nothing is cast.
///
/// # Errors
/// If a person cannot be read, has a spot outside the grid of a scene, or would not be in it at all.
pub fn check_postures<'w>(study: &Study, worlds: &'w [World]) -> Result<Vec<(&'w str, Vec<String>)>> {
    for posture in &study.postures {
        // Each person once.
        if let (SurfaceSpec::Mannequin(file), 0) = (&posture.person, posture.spot) {
            read_person(file, &study.sources)
                .map_err(|e| e.with_place("postures.people").with_place(&study.path))?;
        }
    }
    let of_scene = |scene: &'w [World]| {
        let each = study.postures.iter().map(|posture| {
            let posture = place(study, &scene[0], posture)?;
            cut_off(study, &scene[0], &posture)
        });
        let cut: Vec<Option<String>> = each.collect::<Result<_>>()?;
        Ok((scene[0].name.as_str(), cut.into_iter().flatten().collect()))
    };
    scenes(worlds).map(of_scene).collect()
}

/// A posture at the height of what carries it in a scene, if the floor has several heights.
///
/// # Errors
/// When nothing carries a person at the spot.
fn place(study: &Study, world: &World, posture: &Posture) -> Result<Posture> {
    let [x, y, _] = Grid::voxel_of(world.grid.position_q16(posture.position_m));
    if study.approach.step_m.is_none() || !world.grid.window().contains([x, y, 0]) {
        return Ok(posture.clone());
    }
    let at = posture.position_m;
    let z = spot_height_m(world, at, ROOM_M).ok_or_else(|| {
        let rule = format!(
            "must be where a surface carries a person in scene {:?}, with {ROOM_M} m of room above: move the spot, or write \
             floor_m instead of floor in [approach]",
            world.name
        );
        let spot = Issue::value(format!("spots[{}]", posture.spot), format!("[{}, {}]", at.x, at.y), rule);
        Error::from(spot.with_place(Site::Table("postures".into())).with_place(&study.path))
    })?;
    Ok(Posture { position_m: DVec3::new(at.x, at.y, z), ..posture.clone() })
}

/// The part of a person that the grid of a scene cuts off, if any.
///
/// # Errors
/// If the spot is outside the grid, or the grid contains no part of the person.
fn cut_off(study: &Study, world: &World, posture: &Posture) -> Result<Option<String>> {
    let grid = &world.grid;
    let [low, high] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
    let at = posture.position_m;
    let refused = |place: String, rule: String| {
        let spot = Issue::value(format!("spots[{}]", posture.spot), place, rule);
        Err(Error::from(spot.with_place(Site::Table("postures".into())).with_place(&study.path)))
    };
    if (0..2).any(|axis| !(low[axis]..high[axis]).contains(&at[axis])) {
        let rule = format!(
            "must be in the grid, which in scene {:?} goes from x {:.2}, y {:.2} to x {:.2}, y {:.2} m",
            world.name, low.x, low.y, high.x, high.y
        );
        return refused(format!("[{}, {}]", at.x, at.y), rule);
    }
    let scene = &study.scenes[world.scene];
    let alone =
        SceneSpec { objects: vec![person(scene, posture, 0)], snapshots: 1, dwell_s: None, ..scene.clone() };
    let alone = build(&alone, &study.sources, study.voxel_size_m)?;
    // Voxels of the person and of the grid, counted from the world's origin.
    let whole = voxelize::scene_extent(&alone, study.voxel_size_m)?;
    let inside = grid.window().shift(grid.origin).intersection(&whole);
    if inside == whole {
        return Ok(None);
    }
    let own = voxelize::grid_over(&whole, study.voxel_size_m)
        .map_err(|e| e.with_place(format!("person {:?}", posture.name)).with_place(&study.path))?;
    let truth = voxelize_all(&alone, own)?.swap_remove(0);
    let all = truth.human.count();
    let kept = truth.human.to_window(inside.shift(own.origin.map(|key| -key))).count();
    if kept == 0 {
        let rule = format!(
            "must place person {:?} in the grid, which in scene {:?} goes from z {:.2} to {:.2} m and contains no part \
             of that person: widen bounds_m of [grid], or correct floor_m of [approach]",
            posture.name, world.name, low.z, high.z
        );
        return refused(format!("[{}, {}] on a floor at {} m", at.x, at.y, at.z), rule);
    }
    Ok((kept < all).then(|| {
        let percent = 100.0 * (all - kept) as f64 / all as f64;
        format!(
            "person {:?} is cut off by the grid: {percent:.1} % of the body is outside and ignored: widen \
             bounds_m of [grid], or move the spot",
            posture.name
        )
    }))
}

/// A study with a person in place of the people of its scenes; `in_scene` is the posture in a scene by its number.
fn with_posture<'p>(study: &Study, in_scene: &dyn Fn(usize) -> &'p Posture) -> Study {
    let (mut study, person_shade) = (study.clone(), study.person_shade());
    for (number, scene) in study.scenes.iter_mut().enumerate() {
        scene.objects.retain_mut(leave_people_out);
        scene.objects.push(person(scene, in_scene(number), person_shade));
    }
    for (_, region) in &mut study.regions {
        if let RegionSpec::RegionShape(RegionShape::HumanBox { object, .. }) = region {
            // The only person.
            *object = None;
        }
    }
    study
}

/// Removes the people from an object; returns whether anything is left of it. A person is removed with everything from
/// the same file.
fn leave_people_out(object: &mut ObjectSpec) -> bool {
    let people = object.nodes.iter_mut().filter(|rule| rule.role == Some(Role::Human));
    people.for_each(|rule| rule.ignore = true);
    object.role != Role::Human
}

fn person(scene: &SceneSpec, posture: &Posture, person_shade: u8) -> ObjectSpec {
    ObjectSpec {
        name: posture.name.clone(),
        role: Role::Human,
        interior: scene.interior,
        optical: Optical::Opaque,
        radar: Default::default(),
        speed_m_s: Some(posture.speed_m_s),
        reflectance: None,
        specular: None,
        shade: person_shade,
        person_shade,
        tag_only: false,
        on: None,
        position_m: posture.position_m,
        rotation: posture.rotation,
        surface: posture.person.clone(),
        keypoints: None,
        nodes: Vec::new(),
        animated: None,
        motion: MotionSpec::default(),
    }
}
