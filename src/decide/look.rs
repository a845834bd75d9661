//! The subject of a command: one choice of poses in one scene, as planned or altered.

use crate::approach::{Ground, Way, nearest_ways};
use crate::judge::{Alteration, alter};
use crate::view::watched::Watchers;
use crate::view::{Choice, ChoiceSelector, find};
use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::World;

/// A choice of a study, in one of its worlds.
pub struct Look<'a> {
    planned: (&'a Study, &'a [World], Choice),
    alteration: Alteration,
    /// The study of the altered choice.
    pub study: Study,
    worlds: Vec<World>,
    world: usize,
    /// The choice, altered if that was requested.
    pub choice: Choice,
}

impl<'a> Look<'a> {
    /// Finds a choice of poses in a study ([`crate::view::with_set`] adds unlisted sets), and alters it.
    ///
    /// # Errors
    /// An unknown name, and those of [`alter`].
    pub fn new(
        study: &'a Study,
        worlds: &'a [World],
        wanted: &ChoiceSelector,
        alteration: Alteration,
    ) -> Result<Look<'a>> {
        let (world, choice) = find(study, worlds, wanted)?;
        let world = worlds.iter().position(|one| std::ptr::eq(one, world)).unwrap_or_default();
        let planned = (study, worlds, choice);
        let (study, worlds, choice) = alter(study, worlds, &choice, &alteration)?;
        Ok(Look { planned, alteration, study, worlds, world, choice })
    }

    /// What of the choice is not as planned, in words; empty if all is.
    pub fn case(&self) -> String {
        self.alteration.words()
    }

    /// The given worlds of the study.
    pub fn worlds(&self) -> &[World] {
        &self.worlds
    }

    /// The scene at the chosen moment.
    pub fn world(&self) -> &World {
        &self.worlds[self.world]
    }

    /// The ways by which the bodies of the study's approach come nearest unnoticed, in the scene.
    ///
    /// # Errors
    /// If they cannot be computed for the scene.
    pub fn ways(&self) -> Result<Vec<Way>> {
        let altered = (&self.study, self.worlds(), self.choice);
        let (study, worlds, choice) = self.alteration.where_bodies_come_in(self.planned, altered);
        let ground = Ground::new(study, self.scene_worlds(worlds), Watchers::new(study, choice).each())?;
        nearest_ways(&ground, self.scene_worlds(&self.worlds), &Watchers::new(&self.study, self.choice))
    }

    /// The worlds of the scene.
    fn scene_worlds<'w>(&self, worlds: &'w [World]) -> &'w [World] {
        let scene = self.world().scene;
        worlds.chunk_by(|one, next| one.scene == next.scene).find(|all| all[0].scene == scene).unwrap_or(&[])
    }
}
