//! Diffuse transfer in any form that a file holds: plain, in 16 bits, as a lightmap, compressed or as zonal lobes.

use std::path::Path;

use lobe_image::FileFormat;
use lobe_io::read_file;
use lobe_sh::Rgb;

use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::compressed_file::{COMPRESSED, ZONAL, compressed_of, zonal_of};
use crate::files::lightmap_file::read_lightmap_bytes;
use crate::files::tensor_file::TransferFile;
use crate::files::transfer_file::{TRANSFER, half_of, is_half, transfer_of};
use crate::recipe::Recipe;
use crate::transfer::half_transfer::HalfTransfer;
use crate::transfer::transfer::Transfer;
use crate::zonal::zonal_transfer::ZonalTransfer;

/// Transfer vectors as they are, compressed, or as lobes; each is lit in its own form, without being expanded.
#[derive(Clone, Debug)]
pub enum AnyTransfer {
    /// All coefficients of each receiver.
    Plain(Transfer),
    /// All coefficients in 16 bits.
    Half(HalfTransfer),
    /// Clusters of receivers with components in common.
    Compressed(CompressedTransfer),
    /// Lobes of each receiver.
    Zonal(ZonalTransfer),
}

impl AnyTransfer {
    /// The number of bands.
    #[must_use]
    pub fn order(&self) -> usize {
        match self {
            Self::Plain(transfer) => transfer.order(),
            Self::Half(transfer) => transfer.order(),
            Self::Compressed(transfer) => transfer.order(),
            Self::Zonal(transfer) => transfer.order(),
        }
    }

    /// The number of receivers.
    #[must_use]
    pub fn receivers(&self) -> usize {
        match self {
            Self::Plain(transfer) => transfer.receivers(),
            Self::Half(transfer) => transfer.receivers(),
            Self::Compressed(transfer) => transfer.receivers(),
            Self::Zonal(transfer) => transfer.receivers(),
        }
    }

    /// The exit radiance of each receiver under the light with these coefficients: see [`Transfer::exit_radiance`].
    ///
    /// # Panics
    /// As that does.
    #[must_use]
    pub fn exit_radiance(&self, light: &[Rgb<f64>]) -> Vec<Rgb<f32>> {
        match self {
            Self::Plain(transfer) => transfer.exit_radiance(light),
            Self::Half(transfer) => transfer.exit_radiance(light),
            Self::Compressed(transfer) => transfer.exit_radiance(light),
            Self::Zonal(transfer) => transfer.exit_radiance(light),
        }
    }
}

impl From<Transfer> for AnyTransfer {
    fn from(transfer: Transfer) -> Self {
        Self::Plain(transfer)
    }
}

/// Reads what [`write_transfer`](crate::write_transfer), [`write_half_transfer`](crate::write_half_transfer), [`write_lightmap`](crate::write_lightmap),
/// [`write_compressed_transfer`](crate::write_compressed_transfer) or
/// [`write_zonal_transfer`](crate::write_zonal_transfer) wrote: the transfer and its recipe. The contents of the file decide
/// which of them it is, not its name.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be read, [`PrtError::Unsupported`] if it is of another version,
/// [`PrtError::Invalid`] if it is none of these or contradicts itself.
pub fn read_any_transfer(path: impl AsRef<Path>) -> Result<(AnyTransfer, Recipe), PrtError> {
    let path = path.as_ref();
    read_any_transfer_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_any_transfer`] from the bytes of a file, whose name stands in messages.
///
/// # Errors
/// As [`read_any_transfer`].
pub fn read_any_transfer_bytes(bytes: &[u8], name: &str) -> Result<(AnyTransfer, Recipe), PrtError> {
    if let Ok(FileFormat::OpenExr) = FileFormat::of_bytes(bytes, name) {
        return read_lightmap_bytes(bytes, name).map(|(transfer, recipe)| (transfer.into(), recipe));
    }
    let file = TransferFile::parse(bytes, name, &[TRANSFER, COMPRESSED, ZONAL])?;
    Ok(match file.format() {
        name if name == COMPRESSED.name => {
            compressed_of(&file).map(|(transfer, recipe)| (AnyTransfer::Compressed(transfer), recipe))?
        }
        name if name == ZONAL.name => {
            zonal_of(&file).map(|(transfer, recipe)| (AnyTransfer::Zonal(transfer), recipe))?
        }
        _ if is_half(&file) => half_of(&file).map(|(transfer, recipe)| (AnyTransfer::Half(transfer), recipe))?,
        _ => transfer_of(&file).map(|(transfer, recipe)| (transfer.into(), recipe))?,
    })
}

#[cfg(test)]
mod tests {
    use lobe_io::Job;
    use lobe_sh::Coefficient as _;
    use lobe_testkit::Random;
    use serde_json::json;

    use super::*;
    use crate::compression::compress::CompressOptions;
    use crate::files::compressed_file::{write_compressed_transfer, write_zonal_transfer};
    use crate::files::lightmap_file::write_lightmap;
    use crate::files::transfer_file::{write_half_transfer, write_transfer};
    use crate::transfer::transfer::Channels;
    use crate::zonal::zonal_fit::{ZonalFitOptions, fit_zonal};

    #[test]
    fn every_form_is_read_for_what_it_is_and_lit_as_itself() {
        let mut random = Random::new(5);
        let numbers = random.signed_vec(12 * 9).iter().map(|x| *x as f32).collect();
        let plain = Transfer::new(3, Channels::Gray, numbers).unwrap();
        let compressed = CompressedTransfer::new(&plain, &CompressOptions::default(), Job::default()).unwrap().0;
        let zonal = fit_zonal(&plain, &ZonalFitOptions::default(), Job::default()).unwrap().0;
        let light: Vec<Rgb<f64>> = random.signed_vec(9).into_iter().map(Rgb::splat).collect();
        let (folder, recipe) = (tempfile::tempdir().unwrap(), Recipe::from(json!({"samples": 7})));
        let path = |name: &str| folder.path().join(name);
        write_transfer(path("p"), &plain, &recipe, Job::default()).unwrap();
        let (halves, _) = HalfTransfer::new(&plain).unwrap();
        write_half_transfer(path("h"), &halves, &recipe).unwrap();
        write_compressed_transfer(path("c"), &compressed, &recipe).unwrap();
        write_zonal_transfer(path("z"), &zonal, &recipe).unwrap();
        let square = Transfer::new(3, Channels::Gray, plain.coefficients()[..9 * 9].to_vec()).unwrap();
        write_lightmap(path("l"), &square, &recipe, Job::default()).unwrap();
        let (lightmap, read) = read_any_transfer(path("l")).unwrap();
        assert_eq!((lightmap.receivers(), &read), (9, &recipe), "texels");
        assert!(lightmap.exit_radiance(&light) == square.exit_radiance(&light), "the light of a lightmap");
        let expected = [
            ("p", plain.exit_radiance(&light)),
            ("h", halves.exit_radiance(&light)),
            ("c", compressed.exit_radiance(&light)),
            ("z", zonal.exit_radiance(&light)),
        ];
        for (name, expected) in expected {
            let (found, read) = read_any_transfer(path(name)).unwrap();
            assert_eq!((found.order(), found.receivers(), &read), (3, 12, &recipe), "{name}: shape and recipe");
            assert!(found.exit_radiance(&light) == expected, "{name}: the light that is sent back");
        }
        std::fs::write(path("n"), b"no tensors").unwrap();
        let error = read_any_transfer(path("n")).unwrap_err().to_string();
        assert!(error.contains("expected safetensors"), "{error}");
    }
}
