//! A picture in memory: receives samples, letters and patches, and is written as PNG.

use std::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Size};
use embedded_graphics::pixelcolor::{Rgb888, RgbColor};

use perirobot_march::{Error, Result};

/// Pixels, row by row from the top left.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    size: [u32; 2],
    rgb: Vec<u8>,
}

impl Canvas {
    /// A picture of these pixels, three bytes each.
    ///
    /// # Panics
    /// If their number does not match the size.
    pub fn from_rgb(size: [u32; 2], rgb: Vec<u8>) -> Canvas {
        assert_eq!(rgb.len(), 3 * size[0] as usize * size[1] as usize, "three bytes a pixel");
        Canvas { size, rgb }
    }

    pub(super) fn white(size: [u32; 2]) -> Canvas {
        Canvas { size, rgb: vec![255; 3 * size[0] as usize * size[1] as usize] }
    }

    /// Width and height in pixels.
    pub fn size_px(&self) -> [u32; 2] {
        self.size
    }

    /// Writes a finer picture of the same width into the upper part: each pixel is the mean of `fine` × `fine` samples.
    pub(super) fn paste(&mut self, samples: &[[u8; 3]], [width, height]: [u32; 2], fine: u32) {
        let (fine, width) = (fine as usize, width as usize);
        for y in 0..height as usize / fine {
            for x in 0..width / fine {
                let mut sum = [0u32; 3];
                for row in fine * y..fine * (y + 1) {
                    for sample in &samples[row * width + fine * x..][..fine] {
                        (0..3).for_each(|c| sum[c] += u32::from(sample[c]));
                    }
                }
                let at = 3 * (y * self.size[0] as usize + x);
                (0..3).for_each(|c| self.rgb[at + c] = (sum[c] / (fine * fine) as u32) as u8);
            }
        }
    }

    /// The bytes of a PNG file.
    pub fn png(&self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.size[0], self.size[1]);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_compression(png::Compression::High);
        let written = encoder.write_header().and_then(|mut writer| {
            writer.write_image_data(&self.rgb)?;
            writer.finish()
        });
        written.map_err(|e| Error::device(format!("cannot pack the picture: {e}")))?;
        Ok(bytes)
    }
}

impl OriginDimensions for Canvas {
    fn size(&self) -> Size {
        Size::new(self.size[0], self.size[1])
    }
}

impl DrawTarget for Canvas {
    type Color = Rgb888;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<Rgb888>>>(&mut self, pixels: I) -> Result<(), Infallible> {
        for Pixel(at, colour) in pixels {
            let (Ok(x), Ok(y)) = (u32::try_from(at.x), u32::try_from(at.y)) else { continue };
            if x < self.size[0] && y < self.size[1] {
                let start = 3 * (y as usize * self.size[0] as usize + x as usize);
                self.rgb[start..start + 3].copy_from_slice(&[colour.r(), colour.g(), colour.b()]);
            }
        }
        Ok(())
    }
}
