//! How large an object must be for a ray to hit it wherever it is in the field of view, by the distance between rays.
//!
//! Rays at right angles to each other form a grid. An upright rectangle that faces the sensor holds a ray if it is as wide and
//! as high as the gaps of the grid, and a disc if its diameter is the diagonal of a gap.

use perirobot_march::backend::Image;

/// The gaps between the rays of a sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RaySpacing {
    /// The width of a gap in metres for each metre of distance; 0 of a single column.
    across: f64,
    /// The height; `None` if all rays lie in one plane.
    up: Option<f64>,
}

impl RaySpacing {
    /// Of the pixels of an image. Distances are depths.
    pub(crate) fn from_image(image: &Image) -> RaySpacing {
        let [across, up] = image.focal_px.map(|focal| 1.0 / focal);
        RaySpacing { across, up: Some(up) }
    }

    /// Of rings of rays, by the largest steps between their angles.
    pub(crate) fn from_rings(azimuths_rad: &[f64], elevations_rad: &[f64]) -> RaySpacing {
        // The ring nearest to the level has the widest gaps.
        let level = elevations_rad.iter().map(|angle| libm::cos(*angle)).fold(0.0, f64::max);
        let gap = |angles: &[f64]| 2.0 * libm::tan(largest_step(angles) / 2.0);
        let up = (elevations_rad.len() > 1).then(|| gap(elevations_rad));
        RaySpacing { across: level * gap(azimuths_rad), up }
    }

    /// Width and height in metres of the smallest rectangle that surely holds a ray at a distance; no height if all rays lie
    /// in one plane, which the object must cross.
    pub fn rectangle_m(&self, distance_m: f64) -> (f64, Option<f64>) {
        (self.across * distance_m, self.up.map(|up| up * distance_m))
    }

    /// Up to which distance a rectangle surely holds a ray, in metres.
    pub fn reach_m(&self, [width_m, height_m]: [f64; 2]) -> f64 {
        (width_m / self.across).min(self.up.map_or(f64::INFINITY, |up| height_m / up))
    }

    /// Up to which distance a ball surely holds a ray, in metres.
    pub fn reach_of_ball_m(&self, diameter_m: f64) -> f64 {
        diameter_m / libm::hypot(self.across, self.up.unwrap_or(0.0))
    }

    /// The smallest objects at some distances, in whole millimetres, as people read them.
    pub fn describe(&self, distances_m: &[f64]) -> String {
        let millimetres = |metres: f64| (1e3 * metres - 1e-6).ceil().max(1.0);
        let at = |distance_m: &f64| {
            let (width_m, height_m) = self.rectangle_m(*distance_m);
            let width = millimetres(width_m);
            match height_m {
                Some(height_m) => format!("{width} × {} mm at {distance_m} m", millimetres(height_m)),
                None => format!("{width} mm at {distance_m} m"),
            }
        };
        let all: Vec<String> = distances_m.iter().map(at).collect();
        let plane = if self.up.is_none() { ", if it crosses their plane" } else { "" };
        format!("rays hit any object of {}{plane}", all.join(", "))
    }
}

/// The largest step between neighbours of some angles; 0 of a single one.
fn largest_step(angles: &[f64]) -> f64 {
    let mut angles = angles.to_vec();
    angles.sort_by(f64::total_cmp);
    angles.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether a rectangle around each of many places holds a point of a grid, tried plainly.
    fn always_holds(size: [f64; 2], gaps: [f64; 2]) -> bool {
        let place = |n: usize, gap: f64| gap * n as f64 / 40.0;
        let holds = |low: f64, size: f64, gap: f64| (low / gap).ceil() * gap <= low + size + 1e-12;
        let all = (0..40 * 40).map(|n| [n % 40, n / 40]);
        all.into_iter().all(|[x, y]| {
            holds(place(x, gaps[0]), size[0], gaps[0]) && holds(place(y, gaps[1]), size[1], gaps[1])
        })
    }

    /// 100 pixels of focal length: a gap of 1 cm a metre; half of that upwards.
    #[test]
    fn a_rectangle_as_large_as_a_gap_is_always_hit() {
        let spacing = RaySpacing::from_image(&Image { size_px: [320, 240], focal_px: [100.0, 200.0] });
        let (width, height) = spacing.rectangle_m(2.0);
        assert_eq!((width, height), (0.02, Some(0.01)));
        assert!(always_holds([0.02, 0.01], [width, 0.01]));
        assert!(!always_holds([0.0185, 0.01], [width, 0.01]) && !always_holds([0.02, 0.009], [width, 0.01]));
        assert_eq!([spacing.reach_m([0.02, 0.02]), spacing.reach_m([0.04, 0.01])], [2.0, 2.0]);
        assert!((spacing.reach_of_ball_m(0.05) - 0.05 / 0.000_125f64.sqrt()).abs() < 1e-9);
        assert_eq!(
            spacing.describe(&[1.0, 3.0]),
            "rays hit any object of 10 × 5 mm at 1 m, 30 × 15 mm at 3 m"
        );
    }

    #[test]
    fn rings_have_their_widest_gap_near_the_level() {
        let turn: Vec<f64> = (0..360).map(|n| f64::from(n).to_radians()).collect();
        let plane = RaySpacing::from_rings(&turn, &[0.0]);
        let gap = 2.0 * 0.5f64.to_radians().tan();
        assert!((plane.rectangle_m(10.0).0 - 10.0 * gap).abs() < 1e-12);
        assert_eq!(plane.rectangle_m(10.0).1, None);
        assert_eq!(plane.describe(&[2.0]), "rays hit any object of 35 mm at 2 m, if it crosses their plane");
        // Steps of 2° and 5°; at 60° up the circle is half as long.
        let rings = [60.0f64, 62.0, 67.0].map(f64::to_radians);
        let (width, height) = RaySpacing::from_rings(&turn, &rings).rectangle_m(1.0);
        assert!((width - gap / 2.0).abs() < 1e-12, "{width}");
        assert!((height.unwrap() - 2.0 * 2.5f64.to_radians().tan()).abs() < 1e-12);
    }
}
