//! Studies in which somebody of `[postures]` stands at a spot, in the place of all people of the scenes.

use crate::error::{Argument, Issue, Site};
use crate::scene::mannequin::read_person;
use crate::scene::spec::{MotionSpec, ObjectSpec, SceneSpec, SurfaceSpec};
use crate::scene::{Optical, Role};
use crate::study::{Posture, RegionSpec, Study};
use crate::voxel::RegionShape;
use crate::world::World;
use crate::{Error, Result};

/// A study in which somebody stands in the place of the people of its scenes, and its worlds.
#[derive(Debug)]
pub(super) struct Stood {
    pub(super) study: Study,
    pub(super) worlds: Vec<World>,
    /// What is wrong with where the person is, scene by scene: inside of something, or in the air.
    pub(super) warnings: Vec<String>,
}

impl Stood {
    /// `worlds` are those of the study that are looked at; only their scenes are made.
    ///
    /// # Errors
    /// When the spot is beside the grid; when the person cannot be read; when the scene cannot be made with it.
    pub(super) fn new(study: &Study, worlds: &[World], posture: &Posture) -> Result<Stood> {
        refuse_outside(study, worlds, posture)?;
        let study = with_posture(study, posture);
        let mut stood = Stood { study, worlds: Vec::new(), warnings: Vec::new() };
        for scene in worlds.chunk_by(|one, next| one.scene == next.scene) {
            let made = World::prepare(&stood.study, scene[0].scene)?;
            let own = format!("person {:?} ", posture.name);
            let of_person = made[0].warnings.iter().filter(|warning| warning.starts_with(&own));
            stood.warnings.extend(of_person.map(|warning| format!("{}: {warning}", made[0].name)));
            stood.worlds.extend(made);
        }
        Ok(stood)
    }
}

/// The posture of a name.
///
/// # Errors
/// When the study has none of that name.
pub(super) fn named<'s>(study: &'s Study, name: &str) -> Result<&'s Posture> {
    let place = || Site::Argument(Argument::Posture, name.into());
    if study.postures.is_empty() {
        let what = Issue::says(format!("{} has no [postures]", study.path.display()));
        let example = "[postures] people = [\"standing\"], spots = [[1.0, 0.5, 90]]";
        return Err(what.wanted(format!("add them to the study, as in {example}")).at(place()).into());
    }
    let known: Vec<&str> = study.postures.iter().map(|posture| posture.name.as_str()).collect();
    let found = study.postures.iter().find(|posture| posture.name == name);
    found.ok_or_else(|| Issue::unknown(&known).at(place()).into())
}

/// Fails where somebody of `[postures]` cannot be read, or has a spot beside the grid of a scene. Nothing is cast.
pub fn check_postures(study: &Study, worlds: &[World]) -> Result<()> {
    for posture in &study.postures {
        // Each person once.
        if let (SurfaceSpec::Mannequin(file), 0) = (&posture.person, posture.spot) {
            read_person(file, &study.sources).map_err(|e| e.at("postures.people").at(&study.path))?;
        }
        refuse_outside(study, worlds, posture)?;
    }
    Ok(())
}

/// Fails where a spot is beside the grid of a scene, in which nobody would be found there.
fn refuse_outside(study: &Study, worlds: &[World], posture: &Posture) -> Result<()> {
    for scene in worlds.chunk_by(|one, next| one.scene == next.scene) {
        let (grid, name) = (&scene[0].grid, &scene[0].name);
        let [low, high] = [grid.corner_m([0; 3]), grid.corner_m(grid.window().end())];
        let at = posture.position_m;
        if (0..2).any(|axis| !(low[axis]..high[axis]).contains(&at[axis])) {
            let rule = format!(
                "must lie in the grid, which in scene {name:?} goes from x {:.2}, y {:.2} to x {:.2}, y {:.2} m",
                low.x, low.y, high.x, high.y
            );
            let spot =
                Issue::value(format!("spots[{}]", posture.spot), format!("[{}, {}]", at.x, at.y), rule);
            return Err(Error::from(spot.at(Site::Table("postures".into())).at(&study.path)));
        }
    }
    Ok(())
}

fn with_posture(study: &Study, posture: &Posture) -> Study {
    let mut study = study.clone();
    for scene in &mut study.scenes {
        scene.objects.retain_mut(leave_people_out);
        scene.objects.push(person(scene, posture));
    }
    for (_, region) in &mut study.regions {
        if let RegionSpec::RegionShape(RegionShape::HumanBox { object, .. }) = region {
            // The only person there is.
            *object = None;
        }
    }
    study
}

/// Takes the people out of an object; whether anything may be left of it. A person goes with all that the same file
/// has.
fn leave_people_out(object: &mut ObjectSpec) -> bool {
    let people = object.nodes.iter_mut().filter(|rule| rule.role == Some(Role::Human));
    people.for_each(|rule| rule.ignore = true);
    object.role != Role::Human
}

fn person(scene: &SceneSpec, posture: &Posture) -> ObjectSpec {
    ObjectSpec {
        name: posture.name.clone(),
        role: Role::Human,
        interior: scene.interior,
        optical: Optical::Opaque,
        tag_only: false,
        position_m: posture.position_m,
        rotation: posture.rotation,
        surface: posture.person.clone(),
        keypoints: None,
        nodes: Vec::new(),
        animated: None,
        motion: MotionSpec::default(),
    }
}
