//! A small camera for the tests of what a camera sees.

use crate::backend::{Image, Noise, Rays};
use crate::march::{FULL_RANGE, Gates};

/// Its image: whole tiles and parts of some.
pub(super) const SIZE_PX: [u32; 2] = [83, 61];

/// Its rays, without noise and without a return that is too near.
pub(super) fn camera(focal_px: [f64; 2]) -> Rays {
    camera_of(SIZE_PX, focal_px)
}

/// The same with an image of another size.
pub(super) fn camera_of(size_px: [u32; 2], focal_px: [f64; 2]) -> Rays {
    let dir = |i: u32| {
        let pixel = [i % size_px[0], i / size_px[0]];
        let at = |a: usize| (f64::from(pixel[a]) + 0.5 - f64::from(size_px[a]) / 2.0) / focal_px[a];
        let dir = glam::DVec3::new(at(0), at(1), 1.0).normalize();
        (dir * 32_768.0).round().to_array().map(|x| x as i32)
    };
    let gates = Gates {
        range_min_q16: 0,
        range_max_q16: 200 << 16,
        shade_ranges_q16: FULL_RANGE,
        along_axis: false,
        near_ignore_q16: 0,
        no_return_is_free: false,
        backdrop: false,
    };
    let dirs_q15 = (0..size_px[0] * size_px[1]).map(dir).collect::<Vec<_>>().into();
    Rays { dirs_q15, image: Some(Image { size_px, focal_px }), gates, noise: Noise::default() }
}
