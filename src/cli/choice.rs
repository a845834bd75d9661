//! `--pose` and what goes with it: which choice of poses a command looks at, in which scene.

use perirobot::Result;
use perirobot::study::Study;
use perirobot::sweep::World;
use perirobot::view::{Choice, Wanted, find};

#[derive(clap::Args)]
pub(super) struct ChoiceArgs {
    /// Which poses, as in the column `poses` of results.csv; of a sensor scored alone, the pose's own name will do
    #[arg(long, value_name = "POSES")]
    pose: String,
    #[command(flatten)]
    which: WhichArgs,
}

/// What goes with `--pose`, for commands that can do without it.
#[derive(clap::Args)]
pub(super) struct WhichArgs {
    /// The combination, where several have such a choice of poses
    #[arg(long, value_name = "NAME", requires = "pose")]
    combination: Option<String>,
    /// What the sensors are taken to say, as in results.csv [default: the first]
    #[arg(long, value_name = "NAME", requires = "pose")]
    representation: Option<String>,
    /// The scene [default: the study's first]
    #[arg(long, value_name = "NAME", requires = "pose")]
    scene: Option<String>,
    /// Which moment of a moving scene
    #[arg(long, value_name = "N", default_value_t = 0, requires = "pose")]
    snapshot: usize,
    /// Which repeat, for sensors with noise
    #[arg(long, value_name = "N", default_value_t = 0, requires = "pose")]
    repeat: usize,
}

impl ChoiceArgs {
    /// Finds it in a study.
    pub(super) fn find<'w>(&self, study: &Study, worlds: &'w [World]) -> Result<(&'w World, Choice)> {
        self.which.find(&self.pose, study, worlds)
    }
}

impl WhichArgs {
    /// Finds a choice of poses in a study.
    pub(super) fn find<'w>(
        &self,
        poses: &str,
        study: &Study,
        worlds: &'w [World],
    ) -> Result<(&'w World, Choice)> {
        let wanted = Wanted {
            poses: poses.into(),
            combination: self.combination.clone(),
            representation: self.representation.clone(),
            scene: self.scene.clone(),
            snapshot: self.snapshot,
            repeat: self.repeat,
        };
        find(study, worlds, &wanted)
    }
}
