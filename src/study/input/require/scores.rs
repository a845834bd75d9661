//! Scores that only requirements have: of bodies that come near, and of what a controller would measure.

/// How near bodies come unnoticed, and on how much floor they stand so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(test, derive(schemars::JsonSchema), serde(rename_all = "snake_case"))]
pub enum ApproachScore {
    /// How near any body comes unnoticed to what it must not come near to, in metres; more is better.
    NearestUnnoticedM,
    /// How much farther that is than people must be at the highest speed of `[stopping]`, in metres, below 0 where it
    /// is too near; more is better.
    ApproachMarginM,
    /// The floor on which a body stands unnoticed, whether or not a way leads there, in square metres; less is
    /// better.
    UnnoticedM2,
    /// The part of it that is joined to an entry; less is better.
    JoinedM2,
}

impl ApproachScore {
    /// All of them, in the order of the tables.
    pub const ALL: [ApproachScore; 4] = [
        ApproachScore::NearestUnnoticedM,
        ApproachScore::ApproachMarginM,
        ApproachScore::UnnoticedM2,
        ApproachScore::JoinedM2,
    ];

    /// As in a study.
    pub fn name(self) -> &'static str {
        match self {
            ApproachScore::NearestUnnoticedM => "nearest_unnoticed_m",
            ApproachScore::ApproachMarginM => "approach_margin_m",
            ApproachScore::UnnoticedM2 => "unnoticed_m2",
            ApproachScore::JoinedM2 => "joined_m2",
        }
    }

    /// Whether it is an area of floor, of which less is better; else it is a distance, of which more is.
    pub fn is_area(self) -> bool {
        matches!(self, ApproachScore::UnnoticedM2 | ApproachScore::JoinedM2)
    }
}

/// What a controller would measure of people, and do: from `[stopping]`, in all of the grid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(test, derive(schemars::JsonSchema), serde(rename_all = "snake_case"))]
pub enum ControllerScore {
    /// How much too far away the nearest person is measured, unknown voxels taken as free, in metres; less is better.
    MissedM,
    /// The share of moments at which it stops the robot at its highest speed though nobody is too near, unknown voxels
    /// taken as occupied; less is better.
    NeedlessStops,
}

impl ControllerScore {
    /// All of them, in the order of the tables.
    pub const ALL: [ControllerScore; 2] = [ControllerScore::MissedM, ControllerScore::NeedlessStops];

    /// As in a study.
    pub fn name(self) -> &'static str {
        match self {
            ControllerScore::MissedM => "missed_m",
            ControllerScore::NeedlessStops => "needless_stops",
        }
    }
}
