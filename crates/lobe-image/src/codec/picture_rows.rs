//! Pictures whose rows are decoded as they are asked for.

use std::fs::{self, File};
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::codec::file_format::{FileFormat, SHOWN_BYTES};
use crate::codec::read::{PictureReadOptions, PictureReadReport, guarded, inspect};
use crate::codec::read_exr::ExrBlocks;
use crate::codec::read_hdr::HdrRows;
use crate::codec::read_pfm::PfmRows;
use crate::error::ImageError;
use crate::header::decoded::{PictureHead, RowStrip, invalid, io};
use crate::picture::primaries::Primaries;

/// Bytes that are asked of the system at once.
const BUFFER: usize = 1 << 18;

/// Rows of a Radiance picture that are decoded at a time have about this many texels, which stay in the second-level cache.
const TEXELS_TOGETHER: usize = if cfg!(fuzzing) { 1 << 5 } else { 1 << 16 };

/// A picture file whose rows are decoded as they are asked for: neither the file nor the picture is in memory as a whole.
///
/// These are Radiance `.hdr` that are stored upright, portable float maps, and OpenEXR of scan lines. Others have to be
/// read whole ([`read_picture`](crate::read_picture)). The texels, the report and the errors are those of
/// `read_picture`.
///
/// ```
/// use lobe_image::{Picture, PictureReadOptions, PictureRows, PictureWriteOptions, write_picture};
///
/// let path = std::env::temp_dir().join(format!("lobe-rows-{}.hdr", std::process::id()));
/// write_picture(&path, &Picture::filled(64, 32, [2.0; 3]), &PictureWriteOptions::default())?;
/// let mut rows = PictureRows::open(&path, &PictureReadOptions::default())?.expect("an .hdr has rows");
/// let mut sum = 0.0;
/// while let Some(strips) = rows.next_strips()? {
///     sum += strips.iter().flat_map(|strip| &strip.texels).map(|texel| texel[0]).sum::<f32>();
/// }
/// let report = rows.finish()?;
/// std::fs::remove_file(path).ok();
/// assert_eq!((report.height, sum), (32, 4096.0));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct PictureRows<R> {
    name: String,
    source: Source<R>,
    options: PictureReadOptions,
    report: PictureReadReport,
    /// The primaries from which texels are converted.
    to_convert: Option<Primaries>,
    /// Whether rows could not be read, behind which there are no others.
    has_failed: bool,
}

enum Source<R> {
    Radiance(HdrRows<R>),
    OpenExr(Box<ExrBlocks<R>>),
    Pfm(PfmRows<R>),
}

impl PictureRows<BufReader<File>> {
    /// Reads the header of a file; none if it is no file of its own, or of a kind that has to be read whole.
    ///
    /// # Errors
    /// As [`read_picture`](crate::read_picture), as far as the header tells.
    pub fn open(path: impl AsRef<Path>, options: &PictureReadOptions) -> Result<Option<Self>, ImageError> {
        let (path, name) = (path.as_ref(), path.as_ref().display().to_string());
        // What is no file, a pipe perhaps, has no length and cannot be begun anew.
        if !fs::metadata(path).map_err(|source| io(&name, source))?.is_file() {
            return Ok(None);
        }
        let file = File::open(path).map_err(|source| io(&name, source))?;
        Self::new(BufReader::with_capacity(BUFFER, file), &name, options)
    }
}

impl<R: Read + Seek + Send> PictureRows<R> {
    /// Reads the header of a picture from the start of `source`; none if it has to be read whole. `name` stands for the file in messages.
    ///
    /// # Errors
    /// As [`read_picture`](crate::read_picture), as far as the header tells.
    pub fn new(mut source: R, name: &str, options: &PictureReadOptions) -> Result<Option<Self>, ImageError> {
        let in_file = |error| io(name, error);
        let length = source.seek(SeekFrom::End(0)).map_err(in_file)?;
        source.rewind().map_err(in_file)?;
        let mut magic = Vec::new();
        source.by_ref().take(SHOWN_BYTES as u64).read_to_end(&mut magic).map_err(in_file)?;
        source.rewind().map_err(in_file)?;
        let format = FileFormat::of_bytes(&magic, name)?;
        let most = options.max_texels;
        type Opened<R> = Option<(Source<R>, PictureHead)>;
        let opened = guarded(format, name, || -> Result<Opened<R>, ImageError> {
            Ok(match format {
                FileFormat::Radiance => {
                    let (rows, head) = HdrRows::open(source, length, name, most)?;
                    rows.are_upright().then(|| (Source::Radiance(rows), head))
                }
                FileFormat::Pfm => {
                    let (rows, head) = PfmRows::open(source, length, name, most)?;
                    Some((Source::Pfm(rows), head))
                }
                FileFormat::OpenExr => {
                    let (blocks, head) = ExrBlocks::open(source, length, name, most)?;
                    blocks.are_rows().then(|| (Source::OpenExr(Box::new(blocks)), head))
                }
                _ => None,
            })
        })?;
        let Some((source, head)) = opened else { return Ok(None) };
        let (report, to_convert) = PictureReadReport::of_head(head, format, name, options)?;
        let (name, options) = (name.to_owned(), options.clone());
        Ok(Some(Self { name, source, options, report, to_convert, has_failed: false }))
    }

    /// What is known so far: all that the header says, and the texels that are no numbers or negative, of the rows that were read.
    #[must_use]
    pub fn report(&self) -> &PictureReadReport {
        &self.report
    }

    /// The next rows, in some strips; none at the end. Strips come as they lie in the file: of a portable float map from the bottom. A row comes
    /// once, or not at all if it is outside of the data window of an OpenEXR picture, where all is black.
    ///
    /// # Errors
    /// [`ImageError::Io`] if the file cannot be read, [`ImageError::Invalid`] if it is damaged or cut off; then no more rows are read.
    pub fn next_strips(&mut self) -> Result<Option<Vec<RowStrip>>, ImageError> {
        self.expect_no_failure()?;
        let Self { name, source, report, to_convert, has_failed, .. } = self;
        let width = report.width;
        let strips = guarded(report.format, name, || source.next_strips(width));
        *has_failed = strips.is_err();
        let mut strips = strips?;
        for strip in &mut strips {
            if let Some(primaries) = to_convert {
                primaries.convert(&mut strip.texels);
            }
            let before = report.first_nonfinite.take();
            inspect(&mut strip.texels, width, strip.first_row, report);
            report.first_nonfinite = before.into_iter().chain(report.first_nonfinite).min_by_key(|(x, y)| (*y, *x));
        }
        Ok(Some(strips).filter(|strips| !strips.is_empty()))
    }

    /// The report of the rows that were read.
    ///
    /// # Errors
    /// [`ImageError::Refused`] if there are texels that are no numbers, and the options do not allow them.
    pub fn finish(self) -> Result<PictureReadReport, ImageError> {
        self.expect_no_failure()?;
        self.report.judge(self.options.nonfinite, &self.name)?;
        Ok(self.report)
    }

    fn expect_no_failure(&self) -> Result<(), ImageError> {
        let message = || invalid(&self.name, "the rows before could not be read, and none are read behind them".into());
        if self.has_failed { Err(message()) } else { Ok(()) }
    }
}

impl<R: Read + Seek + Send> Source<R> {
    fn next_strips(&mut self, width: usize) -> Result<Vec<RowStrip>, ImageError> {
        match self {
            Self::Radiance(rows) => {
                let (first_row, mut texels) = (rows.next_row(), Vec::new());
                rows.next_rows_into((TEXELS_TOGETHER / width).max(1), &mut texels)?;
                Ok(Some(RowStrip { first_row, texels }).filter(|strip| !strip.texels.is_empty()).into_iter().collect())
            }
            Self::OpenExr(blocks) => blocks.next_strips(),
            Self::Pfm(rows) => Ok(rows.next_strip()?.into_iter().collect()),
        }
    }
}
