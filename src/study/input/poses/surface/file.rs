//! Poses on a surface as the user writes them.

use serde::Deserialize;

use crate::keys::exactly_if_given;

/// Poses on an object's surface, a grid of them on each of its sides. Each faces away from the surface, or as `facing`
/// says.
#[derive(Clone, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(crate) struct SurfaceFile {
    /// The object, by its name in the scenes, or a part of it, as "cell/beam*". Default the robot of `on`, of whose link the
    /// surface is.
    pub(super) object: Option<String>,
    /// The distance between neighbouring poses in metres.
    pub(super) spacing_m: f64,
    /// The distance of the sensor from the surface in metres. Default 0.05.
    pub(super) off_m: Option<f64>,
    /// The least distance of poses to the ends of a side in metres. Default half of spacing_m.
    pub(super) margin_m: Option<f64>,
    /// Only sides that face these ways; the wall of a room at -x faces +x. Default all.
    pub(super) sides: Option<Vec<SideWay>>,
    /// Only sides that face this place, [x, y, z] in metres, as the insides of walls and fences do.
    #[serde(default, deserialize_with = "exactly_if_given")]
    pub(super) sides_towards_m: Option<[f64; 3]>,
}

/// A way that a side faces most.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(crate) enum SideWay {
    #[serde(rename = "-x")]
    MinusX,
    #[serde(rename = "+x")]
    PlusX,
    #[serde(rename = "-y")]
    MinusY,
    #[serde(rename = "+y")]
    PlusY,
    #[serde(rename = "-z")]
    MinusZ,
    #[serde(rename = "+z")]
    PlusZ,
}
