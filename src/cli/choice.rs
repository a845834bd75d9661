//! `--pose` and related flags: the choice of poses that a command looks at, and its scene.

use perirobot_decide::judge::{Alteration, LeaderScope};
use perirobot_decide::look::Look;
use perirobot_decide::view::{Choice, ChoiceSelector, find, find_scene, with_set};
use perirobot_march::Result;
use perirobot_study::input::Study;
use perirobot_study::world::World;

#[derive(clap::Args)]
#[command(next_help_heading = "Poses")]
pub(super) struct ChoiceArgs {
    /// The poses, as in the column `poses` of results.csv, or any poses of the study joined by ";"; for a sensor scored
    /// alone, the pose's name alone suffices
    #[arg(long, value_name = "POSES")]
    pose: String,
    #[command(flatten)]
    rest: RestArgs,
}

/// The choice of poses that a command judges, over all scenes.
#[derive(clap::Args)]
#[command(next_help_heading = "Poses")]
pub(super) struct SetArgs {
    /// The poses, as in the column `poses` of results.csv, or any poses of the study joined by ";"; for a sensor scored
    /// alone, the pose's name alone suffices
    #[arg(long, value_name = "POSES")]
    pose: Option<String>,
    /// The combination, or the set of `perirobot choose`, as in "best 2" [default: any; with --pose the only one that
    /// contains these poses]
    #[arg(long, visible_alias = "set", value_name = "NAME")]
    combination: Option<String>,
    /// The representation of the sensor data, as in results.csv [default: the first]
    #[arg(long, value_name = "NAME")]
    representation: Option<String>,
}

impl SetArgs {
    /// The study with the named set, if any, added by [`with_set`].
    pub(super) fn with_set(&self, study: Study) -> Study {
        match &self.pose {
            Some(poses) => with_set(study, poses, self.combination.as_deref()),
            None => study,
        }
    }

    /// The named choice, if any.
    pub(super) fn find_choice(&self, study: &Study, worlds: &[World]) -> Result<Option<Choice>> {
        let Some(poses) = self.pose.clone() else { return Ok(None) };
        let (combination, representation) = (self.combination.clone(), self.representation.clone());
        let names = ChoiceSelector { poses, combination, representation, ..ChoiceSelector::default() };
        Ok(Some(find(study, worlds, &names)?.1))
    }

    /// Whether no choice is named.
    pub(super) fn is_any(&self) -> bool {
        self.pose.is_none() && self.combination.is_none() && self.representation.is_none()
    }

    /// The choices among which the best are selected.
    pub(super) fn filter(&self) -> LeaderScope<'_> {
        LeaderScope {
            combination: self.combination.as_deref(),
            representation: self.representation.as_deref(),
        }
    }
}

/// All flags but the poses.
#[derive(clap::Args)]
#[command(next_help_heading = "Poses")]
pub(super) struct RestArgs {
    /// The combination, if several contain these poses
    #[arg(long, value_name = "NAME", requires = "pose")]
    combination: Option<String>,
    /// The representation of the sensor data, as in results.csv [default: the first]
    #[arg(long, value_name = "NAME", requires = "pose")]
    representation: Option<String>,
    /// The scene [default: the study's first]
    #[arg(long, value_name = "NAME")]
    scene: Option<String>,
    /// The moment of a moving scene
    #[arg(long, value_name = "N", default_value_t = 0)]
    snapshot: usize,
    /// The repeat, for sensors with noise
    #[arg(long, value_name = "N", default_value_t = 0, requires = "pose")]
    repeat: usize,
    #[command(flatten)]
    alteration: AlterationArgs,
}

/// How a choice of poses differs from the plan.
#[derive(clap::Args)]
#[command(next_help_heading = "Poses")]
pub(super) struct AlterationArgs {
    /// Without a sensor of the choice, as in camera:wall/1/0, as if it had failed; repeat it for more
    #[arg(long, value_name = "SENSOR:POSE", requires = "pose")]
    dead: Vec<String>,
    /// With the mounts of this draw of the study's [mounting_error], counted from 0
    #[arg(long, value_name = "N", requires = "pose", conflicts_with = "dead")]
    draw: Option<u32>,
    /// With this one of the study's [postures] instead of the scenes' people: person/spot, spots counted from 0, as in
    /// standing/0
    #[arg(long, value_name = "PERSON/SPOT", requires = "pose", conflicts_with_all = ["dead", "draw"])]
    posture: Option<String>,
}

impl AlterationArgs {
    pub(super) fn alteration(&self) -> Alteration {
        match (&self.posture, self.draw) {
            (Some(name), _) => Alteration::Posture(name.clone()),
            (None, Some(draw)) => Alteration::Draw(draw),
            (None, None) if self.dead.is_empty() => Alteration::None,
            (None, None) => Alteration::Dead(self.dead.clone()),
        }
    }
}

impl ChoiceArgs {
    /// The study with the named set, if any, added by [`with_set`].
    pub(super) fn with_set(&self, study: Study) -> Study {
        self.rest.with_set(study, &self.pose)
    }

    pub(super) fn look<'a>(&self, study: &'a Study, worlds: &'a [World]) -> Result<Look<'a>> {
        self.rest.look(&self.pose, study, worlds)
    }
}

impl RestArgs {
    /// The study with the named set, if any, added by [`with_set`].
    pub(super) fn with_set(&self, study: Study, poses: &str) -> Study {
        with_set(study, poses, self.combination.as_deref())
    }

    /// Finds a choice of poses in a study, and applies the alteration, if any.
    pub(super) fn look<'a>(&self, poses: &str, study: &'a Study, worlds: &'a [World]) -> Result<Look<'a>> {
        Look::new(study, worlds, &self.selector(poses), self.alteration.alteration())
    }

    /// Finds only the scene, by its index, and its snapshot.
    pub(super) fn find_scene(&self, study: &Study) -> Result<(usize, usize)> {
        Ok((find_scene(study, &self.selector(""))?, self.snapshot))
    }

    fn selector(&self, poses: &str) -> ChoiceSelector {
        ChoiceSelector {
            poses: poses.into(),
            combination: self.combination.clone(),
            representation: self.representation.clone(),
            scene: self.scene.clone(),
            snapshot: self.snapshot,
            repeat: self.repeat,
        }
    }
}
