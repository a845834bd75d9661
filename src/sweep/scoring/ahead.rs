//! The next scene is made while the backend works on this one.

use perirobot_march::backend::{MadeScene, SceneMaker, VoxelScene};
use perirobot_march::voxel::Window;
use perirobot_study::world::World;

/// The scene of the world that comes next, and what the backend's maker made of it.
#[derive(Default)]
pub(super) struct Ahead<'a>(Option<(&'a World, VoxelScene, Option<MadeScene>)>);

impl<'a> Ahead<'a> {
    /// The scene of a world over a window; from now on none is there.
    pub(super) fn take(&mut self, world: &World, window: Window) -> (VoxelScene, Option<MadeScene>) {
        let known = self.0.take().filter(|(of, scene, _)| std::ptr::eq(*of, world) && scene.window == window);
        known.map_or_else(|| (world.scene(window), None), |(_, scene, made)| (scene, made))
    }

    /// Makes the next scene on a thread of its own while other work is done.
    pub(super) fn make_while<T>(
        &mut self,
        next: Option<(&'a World, Window, Option<SceneMaker>)>,
        work: impl FnOnce() -> T,
    ) -> T {
        // A program that may have one thread does one thing after the other.
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
