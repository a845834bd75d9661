//! Prepares the next scene while the backend works on the current one.

use perirobot_march::backend::{MadeScene, SceneMaker, VoxelScene};
use perirobot_march::voxel::Window;
use perirobot_study::world::World;

/// The prepared scene of the next world.
#[derive(Default)]
pub(super) struct Ahead<'a>(Option<(&'a World, VoxelScene, Option<MadeScene>)>);

impl<'a> Ahead<'a> {
    /// Takes the prepared scene of a world over a window, and clears it.
    pub(super) fn take(&mut self, world: &World, window: Window) -> (VoxelScene, Option<MadeScene>) {
        let known = self.0.take().filter(|(of, scene, _)| std::ptr::eq(*of, world) && scene.window == window);
        known.map_or_else(|| (world.scene(window), None), |(_, scene, made)| (scene, made))
    }

    /// Prepares the next scene on its own thread while `work` runs.
    pub(super) fn make_while<T>(
        &mut self,
        next: Option<(&'a World, Window, Option<SceneMaker>)>,
        work: impl FnOnce() -> T,
    ) -> T {
        // With a single thread, one follows the other.
        let next = next.filter(|_| rayon::current_num_threads() > 1);
        let Some((world, window, maker)) = next else { return work() };
        let make = || {
            let scene = world.scene(window);
            let made = maker.and_then(|maker| maker(&scene));
            (world, scene, made)
        };
        std::thread::scope(|threads| {
            let making = threads.spawn(make);
            let done = work();
            self.0 = Some(making.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)));
            done
        })
    }
}
