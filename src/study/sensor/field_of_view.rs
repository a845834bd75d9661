//! Where a sensor looks, before anything blocks its view.

use std::f64::consts::TAU;

use glam::DVec3;

use perirobot_march::backend::Image;

/// The directions that a sensor looks in, in the frame of its rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FieldOfView {
    /// Whatever lies in front and in an image, to the outer edges of its pixels.
    Image(Image),
    /// Whatever lies between two azimuths (from x towards y) and two elevations (from the plane of x and y
    /// towards z), in radians; all around where the azimuths are a full turn apart.
    Turn {
        /// The first azimuth and the last, which is not below it.
        azimuth_rad: [f64; 2],
        /// The lowest elevation and the highest.
        elevation_rad: [f64; 2],
    },
    /// Directions close enough to one of its rays: only the spacing of the rays is known.
    Spacing,
}

impl FieldOfView {
    /// The field of rings of rays: from half a step before the first angle to half a step behind the last, on
    /// both axes. An axis with one angle only is as wide as the step of the other axis.
    pub(crate) fn from_rings(azimuths_rad: &[f64], elevations_rad: &[f64]) -> FieldOfView {
        let [azimuths, elevations] = [azimuths_rad, elevations_rad].map(|angles| {
            let mut angles = angles.to_vec();
            angles.sort_by(f64::total_cmp);
            angles.dedup();
            angles
        });
        let steps = |angles: &[f64]| match angles {
            [first, second, ..] => {
                let [before, last] = [angles[angles.len() - 2], angles[angles.len() - 1]];
                Some([second - first, last - before])
            }
            _ => None,
        };
        let (across, up) = (steps(&azimuths), steps(&elevations));
        let grown = |angles: &[f64], own: Option<[f64; 2]>, other: Option<[f64; 2]>| {
            let [low, high] = own.or(other.map(|[step, _]| [step; 2])).unwrap_or([0.0; 2]);
            match angles {
                [first, .., last] => [first - low / 2.0, last + high / 2.0],
                [only] => [only - low / 2.0, only + high / 2.0],
                [] => [0.0; 2],
            }
        };
        FieldOfView::Turn {
            azimuth_rad: grown(&azimuths, across, up),
            elevation_rad: grown(&elevations, up, across),
        }
    }

    /// At most so many unit directions in it (one at least), evenly spread; none where only the spacing of
    /// the rays is known.
    pub fn some(&self, most: usize) -> Vec<DVec3> {
        let grid = |columns: usize, rows: usize, towards: &dyn Fn(f64, f64) -> DVec3| {
            let middle = |i: usize, of: usize| (i as f64 + 0.5) / of as f64;
            let each =
                (0..rows).flat_map(|r| (0..columns).map(move |c| (middle(c, columns), middle(r, rows))));
            each.map(|(x, y)| towards(x, y).normalize()).collect()
        };
        match self {
            FieldOfView::Image(Image { size_px, focal_px }) => {
                let rows = ((most as f64 / 1.5).sqrt() as usize).max(1);
                let half = |a: usize| f64::from(size_px[a]) / 2.0 / focal_px[a];
                grid((most / rows).max(1), rows, &|x, y| {
                    DVec3::new(half(0) * (2.0 * x - 1.0), half(1) * (2.0 * y - 1.0), 1.0)
                })
            }
            FieldOfView::Turn { azimuth_rad: [first, last], elevation_rad: [low, high] } => {
                // As many rows as make the steps about alike on both axes.
                let rows = (most as f64 * (high - low) / (last - first).max(1e-9)).sqrt() as usize;
                let rows = rows.clamp(1, most);
                grid((most / rows).max(1), rows, &|x, y| {
                    let (azimuth, elevation) = (first + x * (last - first), low + y * (high - low));
                    let flat = libm::cos(elevation);
                    DVec3::new(flat * libm::cos(azimuth), flat * libm::sin(azimuth), libm::sin(elevation))
                })
            }
            FieldOfView::Spacing => Vec::new(),
        }
    }

    /// Unit directions from edge to edge in so many steps on each axis, row by row; none where only the spacing of the rays
    /// is known.
    pub(crate) fn lattice(&self, steps: usize) -> Vec<Vec<DVec3>> {
        let share = |step: usize| step as f64 / steps as f64;
        let rows = |towards: &dyn Fn(f64, f64) -> DVec3| {
            let row = |y: usize| (0..=steps).map(|x| towards(share(x), share(y)).normalize()).collect();
            (0..=steps).map(row).collect()
        };
        match self {
            FieldOfView::Image(Image { size_px, focal_px }) => {
                let half = |a: usize| f64::from(size_px[a]) / 2.0 / focal_px[a];
                rows(&|x, y| DVec3::new(half(0) * (2.0 * x - 1.0), half(1) * (2.0 * y - 1.0), 1.0))
            }
            FieldOfView::Turn { azimuth_rad: [first, last], elevation_rad: [low, high] } => rows(&|x, y| {
                let (azimuth, elevation) = (first + x * (last - first), low + y * (high - low));
                let flat = libm::cos(elevation);
                DVec3::new(flat * libm::cos(azimuth), flat * libm::sin(azimuth), libm::sin(elevation))
            }),
            FieldOfView::Spacing => Vec::new(),
        }
    }

    /// Whether a direction of any length lies in it; `None` where only the spacing of the rays can tell.
    pub fn holds(&self, direction: DVec3) -> Option<bool> {
        match self {
            FieldOfView::Image(image) => Some(
                direction.z > 0.0 && {
                    let inside = |a: usize| {
                        let size = f64::from(image.size_px[a]);
                        (0.0..size).contains(&(image.focal_px[a] * direction[a] / direction.z + size / 2.0))
                    };
                    inside(0) && inside(1)
                },
            ),
            FieldOfView::Turn { azimuth_rad: [first, last], elevation_rad: [low, high] } => {
                let DVec3 { x, y, z } = direction;
                let (azimuth, elevation) = (libm::atan2(y, x), libm::atan2(z, libm::sqrt(x * x + y * y)));
                let turned = [azimuth - TAU, azimuth, azimuth + TAU];
                let around =
                    last - first >= TAU - 1e-9 || turned.iter().any(|a| (*first..=*last).contains(a));
                Some(around && (*low..=*high).contains(&elevation))
            }
            FieldOfView::Spacing => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn direction(azimuth_deg: f64, elevation_deg: f64) -> DVec3 {
        let (a, e) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
        7.0 * DVec3::new(a.cos() * e.cos(), a.sin() * e.cos(), e.sin())
    }

    fn rings(azimuths_deg: &[f64], elevations_deg: &[f64]) -> FieldOfView {
        let radians = |angles: &[f64]| angles.iter().map(|angle| angle.to_radians()).collect::<Vec<_>>();
        FieldOfView::from_rings(&radians(azimuths_deg), &radians(elevations_deg))
    }

    #[track_caller]
    fn check(field: FieldOfView, inside: &[[f64; 2]], outside: &[[f64; 2]]) {
        for (directions, expected) in [(inside, true), (outside, false)] {
            for &[a, e] in directions {
                assert_eq!(field.holds(direction(a, e)), Some(expected), "{a}° around, {e}° up, {field:?}");
            }
        }
    }

    #[test]
    fn rings_look_half_a_step_beyond_their_ends() {
        // Steps of 10° around; of 1° below and 4° above, in no order.
        let field = rings(&[-20.0, -10.0, 0.0, 10.0], &[5.0, 0.0, 1.0]);
        check(
            field,
            &[[-24.9, 0.0], [14.9, 0.0], [0.0, -0.4], [0.0, 6.9], [0.0, 3.0]],
            &[[-25.1, 0.0], [15.1, 0.0], [0.0, -0.6], [0.0, 7.1], [180.0, 0.0]],
        );
    }

    #[test]
    fn a_single_ring_is_as_thick_as_its_columns_are_wide() {
        let all: Vec<f64> = (0..180).map(|i| -180.0 + 2.0 * f64::from(i)).collect();
        check(
            rings(&all, &[0.0]),
            &[[179.9, 0.9], [-179.9, -0.9], [90.0, 0.0]],
            &[[0.0, 1.1], [90.0, -1.1], [0.0, 90.0]],
        );
        // A column without azimuths beside it, and one ray alone.
        check(rings(&[0.0], &[-30.0, 0.0, 30.0]), &[[14.0, 0.0], [0.0, 44.0]], &[[16.0, 0.0], [180.0, 0.0]]);
        check(rings(&[0.0], &[0.0]), &[[0.0, 0.0]], &[[0.1, 0.0], [0.0, 0.1]]);
    }

    #[test]
    fn some_directions_lie_in_the_field_and_reach_its_ends() {
        let all_around: Vec<f64> = (0..180).map(|i| -180.0 + 2.0 * f64::from(i)).collect();
        for (field, most) in [
            (FieldOfView::Image(Image { size_px: [1280, 720], focal_px: [640.0, 640.0] }), 24),
            (rings(&all_around, &[0.0]), 24),
            (rings(&all_around, &[-15.0, 0.0, 15.0]), 96),
            (rings(&[0.0], &[0.0]), 5),
            (FieldOfView::Image(Image { size_px: [2, 2], focal_px: [1.0, 1.0] }), 1),
        ] {
            let some = field.some(most);
            assert!(
                !some.is_empty() && some.len() <= most && 2 * some.len() > most,
                "{field:?}: {}",
                some.len()
            );
            // What has no width at all holds only what rounding leaves there.
            let thin = matches!(field, FieldOfView::Turn { azimuth_rad: [a, b], .. } if a == b);
            assert!(thin || some.iter().all(|&dir| field.holds(dir) == Some(true)), "{field:?}");
            let x = some.iter().map(|dir| dir.x).fold(f64::INFINITY, f64::min);
            assert!(x < 0.0 || some.len() < 6, "{field:?}: the left or the back is looked at, too");
        }
        assert_eq!(FieldOfView::Spacing.some(9), []);
    }

    #[test]
    fn a_field_goes_on_across_the_back() {
        // From −185° to 165°: what lies at 176° is inside, as −184°.
        let azimuths: Vec<f64> = (0..35).map(|i| -180.0 + 10.0 * f64::from(i)).collect();
        check(rings(&azimuths, &[0.0, 10.0]), &[[176.0, 0.0], [-180.0, 0.0]], &[[166.0, 0.0], [174.0, 0.0]]);
    }

    #[test]
    fn an_image_ends_at_the_edges_of_its_pixels() {
        // Half the image is as wide as the focal length is long.
        let field = FieldOfView::Image(Image { size_px: [4, 2], focal_px: [2.0, 2.0] });
        let holds = |x, y, z| field.holds(DVec3::new(x, y, z)).unwrap();
        assert!(holds(0.999, 0.0, 1.0) && holds(-3.0, 1.499, 3.0));
        assert!(!holds(1.001, 0.0, 1.0) && !holds(0.0, 0.501, 1.0));
        assert!(!holds(0.0, 0.0, -1.0) && !holds(0.0, 0.0, 0.0), "behind, and inside");
    }
}
