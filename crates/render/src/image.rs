//! Pictures: pixels, text, PNG.

use crate::RenderError;
use noto_sans_mono_bitmap::{FontWeight, RasterHeight, get_raster, get_raster_width};

/// A colour as it is displayed (sRGB).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Colour(pub [u8; 3]);

impl Colour {
    /// The background.
    pub const BACKGROUND: Self = Self([0xf6, 0xf7, 0xf9]);
    /// Text.
    pub const INK: Self = Self([0x22, 0x26, 0x2e]);
    /// Text of less weight.
    pub const GREY: Self = Self([0x6b, 0x72, 0x80]);
    /// Failures.
    pub const ALARM: Self = Self([0xb4, 0x23, 0x18]);
    /// Stripes behind a failure.
    pub const STRIPE: Self = Self([0xf1, 0xd9, 0xd6]);
}

/// Fonts, by the height of their text.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Font {
    /// 16 pixels.
    Small,
    /// 20 pixels.
    Medium,
    /// 24 pixels, bold.
    Heading,
}

impl Font {
    fn raster(self) -> (FontWeight, RasterHeight) {
        match self {
            Self::Small => (FontWeight::Regular, RasterHeight::Size16),
            Self::Medium => (FontWeight::Regular, RasterHeight::Size20),
            Self::Heading => (FontWeight::Bold, RasterHeight::Size24),
        }
    }

    /// Width of a text, pixels.
    pub fn width(self, text: &str) -> u32 {
        let (weight, height) = self.raster();
        (text.chars().count() * get_raster_width(weight, height)) as u32
    }

    /// Height of a line, pixels.
    pub fn height(self) -> u32 {
        self.raster().1.val() as u32
    }
}

/// A picture of opaque pixels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    width: u32,
    height: u32,
    /// Three bytes for each pixel, row by row.
    rgb: Vec<u8>,
}

impl Image {
    /// A picture in the colour of the background; sizes in pixels.
    pub fn new(width: u32, height: u32) -> Self {
        let rgb = Colour::BACKGROUND.0.repeat(width as usize * height as usize);
        Self { width, height, rgb }
    }

    /// A picture in place of a missing one, with stripes and the reason; sizes in pixels.
    pub fn failure([width, height]: [u32; 2], reason: &str) -> Self {
        let mut image = Self::new(width, height);
        image.stripe([0, 0], [width, height]);
        let font = if Font::Medium.width(reason) <= width { Font::Medium } else { Font::Small };
        let left = width.saturating_sub(font.width(reason)) / 2;
        image.write(reason, left, height.saturating_sub(font.height()) / 2, font, Colour::ALARM);
        image
    }

    /// A picture each of whose pixels is the mean of `samples` × `samples` samples.
    pub(crate) fn averaged(
        [width, height]: [u32; 2],
        samples: u32,
        sample: impl Fn(u32, u32) -> [u8; 3],
    ) -> Self {
        let mut rgb = Vec::with_capacity(3 * width as usize * height as usize);
        let count = samples * samples;
        for y in 0..height {
            for x in 0..width {
                let mut sum = [0_u32; 3];
                for n in 0..count {
                    let found = sample(x * samples + n % samples, y * samples + n / samples);
                    sum = [0, 1, 2].map(|c| sum[c] + u32::from(found[c]));
                }
                rgb.extend(sum.map(|c| ((c + count / 2) / count) as u8));
            }
        }
        Self { width, height, rgb }
    }

    /// Width, pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height, pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The colour of a pixel; `None` outside the picture.
    pub fn pixel(&self, x: u32, y: u32) -> Option<Colour> {
        let place = self.place(x, y)?;
        Some(Colour([self.rgb[place], self.rgb[place + 1], self.rgb[place + 2]]))
    }

    fn place(&self, x: u32, y: u32) -> Option<usize> {
        (x < self.width && y < self.height)
            .then(|| 3 * (y as usize * self.width as usize + x as usize))
    }

    /// Mixes a colour into a pixel, with `weight` out of 255. Does nothing outside the picture.
    fn mix(&mut self, x: u32, y: u32, colour: Colour, weight: u8) {
        let Some(place) = self.place(x, y) else { return };
        let weight = u32::from(weight);
        for (c, new) in colour.0.iter().enumerate() {
            let old = u32::from(self.rgb[place + c]);
            self.rgb[place + c] =
                ((old * (255 - weight) + u32::from(*new) * weight + 127) / 255) as u8;
        }
    }

    /// Copies another picture to a place in this one, in pixels. Cuts off pixels beyond this
    /// picture.
    pub fn paste(&mut self, other: &Self, left: u32, top: u32) {
        for y in 0..other.height {
            for x in 0..other.width {
                if let Some(colour) = other.pixel(x, y) {
                    self.mix(left + x, top + y, colour, 255);
                }
            }
        }
    }

    /// Writes a line of text at a place in pixels. Characters that the font lacks become question
    /// marks.
    pub fn write(&mut self, text: &str, left: u32, top: u32, font: Font, colour: Colour) {
        let (weight, height) = font.raster();
        let width = get_raster_width(weight, height) as u32;
        for (n, letter) in (0..).zip(text.chars()) {
            let raster =
                get_raster(letter, weight, height).or_else(|| get_raster('?', weight, height));
            let Some(raster) = raster else { continue };
            for (y, row) in (0..).zip(raster.rows()) {
                for (x, &weight) in (0..).zip(row.iter()) {
                    self.mix(left + n * width + x, top + y, colour, weight);
                }
            }
        }
    }

    /// Covers a rectangle with diagonal stripes; place and size in pixels.
    pub fn stripe(&mut self, [left, top]: [u32; 2], [width, height]: [u32; 2]) {
        for y in 0..height {
            for x in 0..width {
                if (x + y) % 16 < 5 {
                    self.mix(left + x, top + y, Colour::STRIPE, 255);
                }
            }
        }
    }

    /// The bytes of a PNG file. The same picture gives the same bytes.
    ///
    /// # Errors
    /// [`RenderError::Png`] when a side is 0 or too long for the format.
    pub fn png(&self) -> Result<Vec<u8>, RenderError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width, self.height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&self.rgb)?;
        writer.finish()?;
        Ok(bytes)
    }
}
