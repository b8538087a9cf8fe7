//! PNG files of pages, with the experiment inside.
//!
//! Owns the text chunks that make a picture reproducible; draws nothing.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use ::png::text_metadata::ITXtChunk;
use ::png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Encoder, SrgbRenderingIntent};

use super::error::PictureError;
use super::page::Page;
use crate::output::PROGRAM;
use crate::output::whole::{WriteError, write_whole};

/// Keyword of the text chunk that holds the experiment as TOML.
pub const EXPERIMENT_KEYWORD: &str = "tribochaos-experiment";

/// Renders a page into a PNG file with the experiment's TOML, the program's name, and further texts, each with its
/// keyword (Latin letters, at most 79).
///
/// # Errors
/// [`PngError::Picture`] if it cannot be drawn, [`PngError::Write`] if it cannot be written.
pub fn write_png(path: &Path, page: &Page, experiment: &str, texts: &[(&str, &str)]) -> Result<(), PngError> {
    let pixels = page.render()?;
    // Pages are opaque.
    let rgb: Vec<u8> = pixels
        .data()
        .chunks_exact(4)
        .flat_map(|pixel| [pixel[0], pixel[1], pixel[2]])
        .collect();
    write_whole(path, |file| {
        let mut encoder = Encoder::new(file, page.width, page.height);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        for &(keyword, text) in [("Software", PROGRAM), (EXPERIMENT_KEYWORD, experiment)]
            .iter()
            .chain(texts)
        {
            encoder.add_itxt_chunk(keyword.to_owned(), text.to_owned())?;
        }
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&rgb)?;
        writer.finish()?;
        Ok(())
    })?;
    Ok(())
}

/// Reads the experiment's TOML from a PNG file, after checking that the whole file is sound.
///
/// # Errors
/// [`PngError::Read`], [`PngError::NoPng`], [`PngError::Damaged`] or [`PngError::NoExperiment`].
pub fn read_experiment(path: &Path) -> Result<String, PngError> {
    read_text(path)?.ok_or_else(|| PngError::NoExperiment { path: path.to_owned() })
}

fn read_text(path: &Path) -> Result<Option<String>, PngError> {
    let file = File::open(path).map_err(|source| PngError::Read {
        path: path.to_owned(),
        source,
    })?;
    let mut start = [0; 8];
    let is_png = io::Read::read_exact(&mut &file, &mut start).is_ok() && start == *b"\x89PNG\r\n\x1a\n";
    if !is_png {
        return Err(PngError::NoPng { path: path.to_owned() });
    }
    let damaged = |source| PngError::Damaged {
        path: path.to_owned(),
        source,
    };
    io::Seek::rewind(&mut &file).map_err(|source| PngError::Read {
        path: path.to_owned(),
        source,
    })?;
    let mut options = DecodeOptions::default();
    // By default a text chunk with a wrong checksum is passed over, as if it were not there.
    options.set_skip_ancillary_crc_failures(false);
    let mut reader = Decoder::new_with_options(BufReader::new(file), options)
        .read_info()
        .map_err(damaged)?;
    while reader.next_row().map_err(damaged)?.is_some() {}
    reader.finish().map_err(damaged)?;
    let chunks = &reader.info().utf8_text;
    let chunk = chunks.iter().find(|chunk| chunk.keyword == EXPERIMENT_KEYWORD);
    chunk.map(ITXtChunk::get_text).transpose().map_err(damaged)
}

/// Why a picture cannot be written or read.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages tell what each is")]
pub enum PngError {
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("{} cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("{} is no PNG file: give a picture that `tribochaos` wrote", path.display())]
    NoPng { path: PathBuf },
    #[error("{} is damaged: {source}; restore it from a copy", path.display())]
    Damaged { path: PathBuf, source: DecodingError },
    #[error(
        "{} holds no experiment: give a picture as `tribochaos` wrote it (editors and web sites often remove what is \
         not pixels)",
        path.display()
    )]
    NoExperiment { path: PathBuf },
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn page() -> Page {
        Page::new(40, 30, "<rect width=\"40\" height=\"30\" fill=\"#ff8000\"/>")
    }

    #[test]
    fn the_experiment_comes_back_and_the_pixels_are_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/a.png");
        let toml = "# ζₖ\nkey = \"value\"\n";
        write_png(&path, &page(), toml, &[("Description", "a λ₁ map")]).unwrap();
        assert_eq!(read_experiment(&path).unwrap(), toml);
        let mut reader = Decoder::new(BufReader::new(File::open(&path).unwrap()))
            .read_info()
            .unwrap();
        assert_eq!(reader.info().size(), (40, 30));
        assert!(
            reader
                .info()
                .utf8_text
                .iter()
                .any(|chunk| chunk.keyword == "Description")
        );
        assert_eq!(&reader.next_row().unwrap().unwrap().data()[..3], [0xff, 0x80, 0]);
        assert_eq!(
            fs::read_dir(path.parent().unwrap()).unwrap().count(),
            1,
            "no temporary file is left"
        );
    }

    #[test]
    fn damage_is_told_from_absence() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let reason = || read_experiment(&path).unwrap_err().to_string();
        assert!(reason().contains("cannot be read"));
        fs::write(&path, "no picture").unwrap();
        assert!(reason().contains("is no PNG"));

        write_png(&path, &page(), "a = 1", &[]).unwrap();
        let whole = fs::read(&path).unwrap();
        for length in 8..whole.len() {
            fs::write(&path, &whole[..length]).unwrap();
            assert!(
                reason().contains("is damaged"),
                "{length} of {} bytes: {}",
                whole.len(),
                reason()
            );
        }
        let text = whole.windows(5).position(|window| window == b"a = 1").unwrap();
        let mut changed = whole.clone();
        changed[text] = b'b';
        fs::write(&path, &changed).unwrap();
        assert!(reason().contains("is damaged"), "{}", reason());

        let mut plain = Vec::new();
        let mut encoder = Encoder::new(&mut plain, 1, 1);
        encoder.set_color(ColorType::Rgb);
        encoder.write_header().unwrap().write_image_data(&[0, 0, 0]).unwrap();
        fs::write(&path, &plain).unwrap();
        assert!(reason().contains("holds no experiment"), "{}", reason());
    }

    #[test]
    fn a_picture_that_cannot_be_written_is_named() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        let error = write_png(&folder.path().join("file/a.png"), &page(), "", &[])
            .unwrap_err()
            .to_string();
        assert!(error.contains("a.png cannot be written"), "{error}");
    }
}
