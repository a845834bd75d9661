//! An ideal pinhole camera: one ray through each pixel's centre.

use glam::DVec3;

use super::{FieldOfView, quantise_q15};
use perirobot_march::backend::Image;

/// Field of view and resolution; x is horizontal, y vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Full angles of view in radians, each below π.
    pub fov_rad: [f64; 2],
    /// Pixels across and down.
    pub resolution_px: [u32; 2],
}

impl Camera {
    /// The image that its rays form, for backends.
    pub fn image(&self) -> Image {
        Image { size_px: self.resolution_px, focal_px: self.focal_px() }
    }

    /// Focal lengths in pixels.
    fn focal_px(&self) -> [f64; 2] {
        std::array::from_fn(|a| f64::from(self.resolution_px[a]) / 2.0 / libm::tan(self.fov_rad[a] / 2.0))
    }

    /// Whether a point in the optical frame is in front of the camera and in its image.
    pub(crate) fn sees(&self, point: DVec3) -> bool {
        FieldOfView::Image(self.image()).holds(point) == Some(true)
    }

    /// How many pixels it has.
    pub(crate) fn pixels(&self) -> u32 {
        self.resolution_px.iter().product()
    }

    /// Directions in the optical frame (z forward, x right, y down), row by row from the top left.
    pub fn dirs_q15(&self) -> Vec<[i32; 3]> {
        let [width, height] = self.resolution_px.map(f64::from);
        let [focal_x, focal_y] = self.focal_px();
        let mut dirs = Vec::with_capacity(self.pixels() as usize);
        for v in 0..self.resolution_px[1] {
            let y = (v as f64 + 0.5 - height / 2.0) / focal_y;
            for u in 0..self.resolution_px[0] {
                let x = (u as f64 + 0.5 - width / 2.0) / focal_x;
                dirs.push(DVec3::new(x, y, 1.0).normalize().to_array().map(quantise_q15));
            }
        }
        dirs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_row_by_row_through_pixel_centres() {
        let camera = Camera { fov_rad: [std::f64::consts::FRAC_PI_2; 2], resolution_px: [2, 1] };
        // Half the image is one focal length wide: x = ∓½, y = 0, z = 1.
        let (x, z) = (14_654, 29_309); // 2¹⁵ · (½, 1) / |(½, 1)|, worked by hand
        assert_eq!(camera.dirs_q15(), [[-x, 0, z], [x, 0, z]]);
    }

    #[test]
    fn an_image_ends_where_its_pixels_do() {
        let camera = Camera { fov_rad: [std::f64::consts::FRAC_PI_2; 2], resolution_px: [4, 4] };
        assert!(camera.sees(DVec3::new(0.999, -0.999, 1.0)), "just inside");
        assert!(!camera.sees(DVec3::new(1.001, 0.0, 1.0)), "just outside");
        assert!(!camera.sees(DVec3::new(0.0, 0.0, -1.0)) && !camera.sees(DVec3::ZERO), "behind, and inside");
    }

    #[test]
    fn the_centre_pixel_looks_straight_ahead() {
        let camera = Camera { fov_rad: [1.5, 1.0], resolution_px: [3, 3] };
        assert_eq!(camera.dirs_q15()[4], [0, 0, 32_768]);
        let [left, _, _, _, _, right] = [0, 1, 2, 3, 4, 5].map(|i| camera.dirs_q15()[i][0]);
        assert_eq!(left, -camera.dirs_q15()[2][0]);
        assert!(right > 0);
    }
}
