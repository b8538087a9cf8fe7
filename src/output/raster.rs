//! The raster of a map as an image for SVG.
//!
//! Owns pixel order and encoding; every point of the map is one pixel here.

use image::{ImageFormat, Rgba, RgbaImage};

use super::figure::FigureError;
use super::plot::{Cell, Plot};

/// The map as the data URI of a PNG image, values rising to the right and upwards; points that are not computed are
/// transparent.
pub fn encode(plot: &Plot) -> Result<String, FigureError> {
    let (columns, rows) = (plot.x.count(), plot.y.count());
    let (across, up) = (plot.x.rising(), plot.y.rising());
    let image = RgbaImage::from_fn(columns as u32, rows as u32, |x, y| {
        let (column, row) = (across[x as usize], up[rows - 1 - y as usize]);
        let colour = match plot.cells[row * columns + column] {
            Cell::NotComputed => return Rgba([0, 0, 0, 0]),
            Cell::Kind(kind) => plot.kinds[kind].colour,
            Cell::Value(value) => plot.bar.as_ref().map_or([0, 0, 0], |bar| (bar.colour)(value)),
        };
        Rgba([colour[0], colour[1], colour[2], 255])
    });
    data_uri(&image)
}

/// An image as the data URI of a PNG.
pub fn data_uri(image: &RgbaImage) -> Result<String, FigureError> {
    let mut png = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut png, ImageFormat::Png)
        .map_err(|error| FigureError::Drawing(error.to_string()))?;
    Ok(format!("data:image/png;base64,{}", base64(png.get_ref())))
}

fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for group in bytes.chunks(3) {
        let bits = (0..3).fold(0, |bits, index| {
            bits << 8 | u32::from(group.get(index).copied().unwrap_or(0))
        });
        for digit in 0..4 {
            let value = bits >> (18 - 6 * digit) & 63;
            text.push(if digit <= group.len() {
                DIGITS[value as usize].into()
            } else {
                '='
            });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_as_in_rfc_4648() {
        for (bytes, text) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        assert_eq!(base64(&[0xff, 0xef, 0xbe]), "/+++");
    }
}
