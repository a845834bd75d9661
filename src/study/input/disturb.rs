//! `disturb` of `[choose]`, checked: when sensors that emit one kind of light disturb each other.

use serde::{Deserialize, Serialize};

use crate::diagnostics::{Place, Problems};
use crate::sensor::Sensor;
use perirobot_march::Error;

/// Which sensors that emit one kind of light a set may not have together. `{}` keeps them out of each other's field of view, and
/// `{ apart_deg = 30, overlap = 0.2 }` allows lenses that look past each other, and little common view.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Disturb {
    /// Two sensors look into each other's lens if each is in the other's field of view, and less than so many degrees off
    /// its direction of view. Default: anywhere in the field of view. 0: they may look into each other's lens.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub apart_deg: Option<f64>,
    /// The largest share of what one of two sensors sees that the other may see as well, walls or not. Default: any share.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub overlap: Option<f64>,
}

pub(super) fn check(at: &Place, disturb: Disturb, sensors: &[Sensor]) -> Result<Disturb, Vec<Error>> {
    let (at_disturb, mut problems) = (at.key("disturb"), Problems::default());
    let Disturb { apart_deg, overlap } = disturb;
    let angle = apart_deg
        .map(|angle| at_disturb.number("apart_deg", angle, 0.0..=180.0, "an angle from 0 to 180 degrees"));
    problems.keep(angle.transpose());
    let share = overlap.map(|share| at_disturb.number("overlap", share, 0.0..=1.0, "a share from 0 to 1"));
    problems.keep(share.transpose());
    if apart_deg == Some(0.0) && overlap.is_none() {
        let rule = "forbids nothing: ask for more than 0, or add overlap = 0.2";
        problems.keep::<()>(Err(at_disturb.wrong("apart_deg", 0, rule)));
    }
    if sensors.iter().all(|sensor| sensor.emits.is_none()) {
        let rule = "is about sensors that emit light, and no sensor does: add emits = \"tof\", or what it emits, to a sensor";
        problems.keep::<()>(Err(at.says(format!("disturb {rule}"))));
    }
    problems.none().map(|()| disturb)
}
