//! The viewpoint of a picture: a point, or a side from which the whole cell is in view. It also projects points into
//! the picture.

use glam::{DMat3, DVec3};

use super::Wish;
use perirobot_march::Result;
use perirobot_march::error::{Argument, Issue, Words};
use perirobot_march::voxel::{BitGrid, Grid};
use perirobot_scene::pose::Pose;

/// The viewpoint of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// A point in world metres.
    At(DVec3),
    /// In this direction from the middle, at a distance that shows everything; of any length but zero.
    Towards(DVec3),
}

impl Eye {
    /// From a corner, above.
    pub const ISO: Eye = Eye::Towards(ISO);

    /// Whether it looks straight down: then x points right and y up, as in a floor plan.
    pub(super) fn is_above(&self) -> bool {
        matches!(self, Eye::Towards(way) if way.x == 0.0 && way.y == 0.0 && way.z > 0.0)
    }
}

const ISO: DVec3 = DVec3::new(0.75, 0.55, 0.5);

/// Named directions, for an observer at the world's origin who looks along x.
const NAMED: [(&str, DVec3); 7] = [
    ("iso", ISO),
    ("top", DVec3::Z),
    ("front", DVec3::X),
    ("back", DVec3::NEG_X),
    ("left", DVec3::Y),
    ("right", DVec3::NEG_Y),
    ("bottom", DVec3::NEG_Z),
];

impl std::str::FromStr for Eye {
    type Err = Issue;

    fn from_str(text: &str) -> Result<Self, Issue> {
        if let Some((_, direction)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(Eye::Towards(*direction));
        }
        let names = NAMED.map(|(name, _)| name).join(", ");
        point(text).map(Eye::At).map_err(|_| Issue::says(format!("{RULE}, or one of {names}")))
    }
}

/// The format of a point.
const RULE: &str = "must be three numbers in metres, as in 2.8,1.8,2.7";

/// Parses a point: `2.8,1.8,2.7`.
pub fn point(text: &str) -> Result<DVec3, Issue> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|v| v.abs() <= 1e4) => Ok(DVec3::new(x, y, z)),
        _ => Err(Issue::says(RULE)),
    }
}

/// The camera of a picture.
#[derive(Clone, Debug)]
pub(super) struct PictureCamera {
    pub(super) eye_m: DVec3,
    /// Columns: right, down, forward in the world.
    pub(super) rotation: DMat3,
    /// Rays across and down.
    pub(super) size: [u32; 2],
    /// Focal length in rays.
    focal: f64,
    voxel_size_m: f64,
}

impl PictureCamera {
    /// The camera of a wish; `whole` must be in view.
    pub(super) fn new(wish: &Wish, size: [u32; 2], grid: &Grid, whole: &BitGrid) -> Result<PictureCamera> {
        let bounds = whole.bounds();
        let corners = [grid.corner_m(bounds.min), grid.corner_m(bounds.end())];
        let target = wish.look_at_m.unwrap_or((corners[0] + corners[1]) / 2.0);
        let tan = libm::tan(wish.fov_rad / 2.0);
        let [width, height] = size.map(f64::from);
        let (eye_m, ahead) = match wish.eye {
            Eye::At(at) if at.distance(target) < 1e-6 => {
                let both = Words::from(Argument("from")) + " equals " + Argument("look at");
                return Err(Issue::says(both).with_advice("move one of them").into());
            }
            Eye::At(at) => (at, target - at),
            Eye::Towards(direction) => {
                let middle = wish.look_at_m;
                let rotation = rotation(-direction, wish.eye.is_above());
                (overlooking(rotation, corners, [tan, tan * height / width], middle), -direction)
            }
        };
        let rotation = rotation(ahead, wish.eye.is_above());
        Ok(PictureCamera { eye_m, rotation, size, focal: width / 2.0 / tan, voxel_size_m: grid.voxel_size_m })
    }

    /// The direction of a ray in the camera's frame; not normalised.
    pub(super) fn direction(&self, [u, v]: [u32; 2]) -> DVec3 {
        let middle = self.size.map(|n| f64::from(n) / 2.0);
        DVec3::new(f64::from(u) + 0.5 - middle[0], f64::from(v) + 0.5 - middle[1], self.focal)
    }

    /// The place of a point in rays from the upper left, and its distance in 1/65536 voxels; `None` behind the eye.
    pub(super) fn project(&self, at_m: DVec3) -> Option<([f64; 2], f64)> {
        let ahead = at_m - self.eye_m;
        let seen = self.rotation.transpose() * ahead;
        if seen.z <= 0.01 {
            return None;
        }
        let middle = self.size.map(|n| f64::from(n) / 2.0);
        let at = [seen.x, seen.y].map(|side| side / seen.z * self.focal);
        Some(([at[0] + middle[0], at[1] + middle[1]], ahead.length() / self.voxel_size_m * 65536.0))
    }
}

/// The rotation of an eye that looks in a direction: right, down, forward in the world. From straight above as in a
/// floor plan.
fn rotation(ahead: DVec3, is_above: bool) -> DMat3 {
    match is_above {
        true => DMat3::from_cols(DVec3::X, DVec3::NEG_Y, DVec3::NEG_Z),
        false => Pose::facing(DVec3::ZERO, ahead, 0.0, 0.0).optical(),
    }
}

/// The nearest point from which a box is in view for an eye with this rotation, with a little margin: the box's middle,
/// or a point of it, is in the middle of the picture. `tans` are those of half the angles of view.
fn overlooking(rotation: DMat3, [low, high]: [DVec3; 2], tans: [f64; 2], middle: Option<DVec3>) -> DVec3 {
    let corner =
        |i: usize| DVec3::from_array(std::array::from_fn(|r| if i >> r & 1 == 0 { low[r] } else { high[r] }));
    let corners: [DVec3; 8] = std::array::from_fn(|i| rotation.transpose() * corner(i));
    let middle = middle.map(|at| rotation.transpose() * at);
    let (mut eye, mut back) = (DVec3::ZERO, f64::INFINITY);
    for side in 0..2 {
        // A corner is in view if its offset is at most this multiple of its depth.
        let most = |sign: f64| {
            corners.iter().map(|c| sign * c[side] - tans[side] * c.z).fold(f64::NEG_INFINITY, f64::max)
        };
        let (right, left) = (most(1.0), most(-1.0));
        eye[side] = middle.map_or((right - left) / 2.0, |middle| middle[side]);
        let reach = (right - eye[side]).max(left + eye[side]);
        back = back.min(-reach / tans[side]);
    }
    let nearest = corners.iter().map(|c| c.z).fold(f64::INFINITY, f64::min);
    let farthest = corners.iter().map(|c| c.z).fold(f64::NEG_INFINITY, f64::max);
    eye.z = back - 0.03 * (farthest - back).max(nearest - back);
    rotation * eye
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn eyes_as_people_write_them() {
        assert_eq!("-1,2.5, 3".parse(), Ok(Eye::At(DVec3::new(-1.0, 2.5, 3.0))));
        assert_eq!("top".parse(), Ok(Eye::Towards(DVec3::Z)));
        for text in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,NaN", "1,2,1e9", "above"] {
            let error = text.parse::<Eye>().unwrap_err();
            assert!(
                error.to_string().contains("2.8,1.8,2.7") && error.to_string().contains("iso, top"),
                "{text:?}: {error}"
            );
        }
    }

    #[test]
    fn a_box_fills_the_picture_from_every_side() {
        let corners = [DVec3::new(-3.0, -2.0, -1.0), DVec3::new(3.0, 2.0, 1.0)];
        // From above, y up in the picture: 3 m half across, 2 m half up, seen at 45° over the lid at z = 1.
        let [down, back] = [rotation(-DVec3::Z, true), rotation(-DVec3::X, false)];
        let above = overlooking(down, corners, [1.0, 1.0], None);
        assert!((above - DVec3::new(0.0, 0.0, 4.0 + 0.03 * 5.0)).length() < 1e-12, "{above}");
        // From the front a picture is as wide as y, and half as high as it is wide.
        let front = overlooking(back, corners, [1.0, 0.25], None);
        assert!((front - DVec3::new(7.0 + 0.03 * 10.0, 0.0, 0.0)).length() < 1e-12, "{front}");
        // A corner in the middle of the picture needs twice the distance.
        let aside = overlooking(down, corners, [1.0, 1.0], Some(corners[1]));
        assert!((aside - DVec3::new(3.0, 2.0, 7.0 + 0.03 * 8.0)).length() < 1e-12, "{aside}");
    }
}
