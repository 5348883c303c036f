//! Compressed and zonal transfer in files.

use std::path::Path;

use lobe_io::{Dtype, Numbers, Tensor, TensorFormat, read_file, write_tensors};

use crate::compression::compressed_table::{CompressedTable, TableWeights};
use crate::compression::compressed_transfer::CompressedTransfer;
use crate::error::PrtError;
use crate::files::tensor_file::{Header, TransferFile, format};
use crate::recipe::Recipe;
use crate::zonal::zonal_transfer::ZonalTransfer;

pub(crate) const COMPRESSED: TensorFormat = format("lobe-compressed-transfer");
pub(crate) const ZONAL: TensorFormat = format("lobe-zonal-transfer");

/// Writes compressed transfer as safetensors.
///
/// ```text
///   clusters  U16             [receivers]
///   weights   U8, U16 or F32  [receivers, components]                        q/255, q/65535, or as they are
///   bases     F32             [clusters, 1 + components, channels, order²]   the mean, then the directions
/// ```
///
/// The metadata's entry `lobe` is JSON: format `lobe-compressed-transfer`, version 1, order, channels, clusters,
/// components, recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be written.
pub fn write_compressed_transfer(
    path: impl AsRef<Path>,
    transfer: &CompressedTransfer,
    recipe: &Recipe,
) -> Result<(), PrtError> {
    let table = transfer.table();
    let (order, channels) = (transfer.order(), transfer.channels());
    let (clusters, components) = (table.cluster_count(), table.components());
    let header =
        Header { clusters: Some(clusters), components: Some(components), ..Header::new(order, channels, recipe) };
    let vectors = [clusters, 1 + components, channels.count(), order * order];
    let tensors = [
        Tensor::new("bases", vectors, Numbers::F32(table.bases())),
        Tensor::new("clusters", [table.rows()], Numbers::U16(table.clusters())),
        Tensor::new("weights", [table.rows(), components], table.weights().into()),
    ];
    Ok(write_tensors(path.as_ref(), COMPRESSED, &header, &tensors)?)
}

/// Reads what [`write_compressed_transfer`] wrote, checked completely: the transfer and its recipe.
///
/// # Errors
/// [`PrtError::Io`], [`PrtError::Invalid`] and [`PrtError::Unsupported`] for files that cannot be read, are broken or
/// not of this kind, or of a later version.
pub fn read_compressed_transfer(path: impl AsRef<Path>) -> Result<(CompressedTransfer, Recipe), PrtError> {
    let path = path.as_ref();
    read_compressed_transfer_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_compressed_transfer`] from the bytes of a file, whose name stands in messages. Nothing is allocated that is
/// larger than they are.
///
/// # Errors
/// As [`read_compressed_transfer`].
pub fn read_compressed_transfer_bytes(bytes: &[u8], name: &str) -> Result<(CompressedTransfer, Recipe), PrtError> {
    compressed_of(&TransferFile::parse(bytes, name, &[COMPRESSED])?)
}

/// The transfer and the recipe in a file of this format.
pub(crate) fn compressed_of(file: &TransferFile<'_>) -> Result<(CompressedTransfer, Recipe), PrtError> {
    let (order, channels) = file.order_and_channels()?;
    let clusters = file.member("clusters", file.header.clusters)?;
    let components = file.member("components", file.header.components)?;
    let n = order * order;
    let vectors = components.saturating_add(1);
    let bases = file.f32("bases", &[Some(clusters), Some(vectors), Some(channels.count()), Some(n)])?;
    let of_receiver = file.u16("clusters", &[None])?;
    let shape = [Some(of_receiver.len()), Some(components)];
    let weights = match file.view("weights")?.0 {
        Dtype::U8 => TableWeights::U8(file.bytes("weights", Dtype::U8, &shape)?.to_vec()),
        Dtype::U16 => TableWeights::U16(file.u16("weights", &shape)?),
        _ => TableWeights::F32(file.f32("weights", &shape)?),
    };
    let table = CompressedTable::new(n * channels.count(), components, of_receiver, weights, bases);
    let transfer = table.and_then(|table| CompressedTransfer::from_table(order, channels, table));
    let transfer = transfer.map_err(|e| PrtError::invalid(file.name(), e.to_string()))?;
    let recipe = file.header.recipe.clone().understood(file.name())?;
    Ok((transfer, recipe))
}

/// Writes zonal transfer as safetensors.
///
/// ```text
///   axes          F32  [receivers, lobes, 3]
///   coefficients  F32  [receivers, lobes, channels, order]
/// ```
///
/// The metadata's entry `lobe` is JSON: format `lobe-zonal-transfer`, version 1, order, channels, lobes, recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be written.
pub fn write_zonal_transfer(path: impl AsRef<Path>, transfer: &ZonalTransfer, recipe: &Recipe) -> Result<(), PrtError> {
    let (order, channels, lobes) = (transfer.order(), transfer.channels(), transfer.lobes());
    let header = Header { lobes: Some(lobes), ..Header::new(order, channels, recipe) };
    let channels = channels.count();
    let receivers = transfer.receivers();
    let tensors = [
        Tensor::new("axes", [receivers, lobes, 3], Numbers::F32(transfer.axes().as_flattened())),
        Tensor::new("coefficients", [receivers, lobes, channels, order], Numbers::F32(transfer.coefficients())),
    ];
    Ok(write_tensors(path.as_ref(), ZONAL, &header, &tensors)?)
}

/// Reads what [`write_zonal_transfer`] wrote, checked completely: the transfer and its recipe.
///
/// # Errors
/// As for [`read_compressed_transfer`].
pub fn read_zonal_transfer(path: impl AsRef<Path>) -> Result<(ZonalTransfer, Recipe), PrtError> {
    let path = path.as_ref();
    read_zonal_transfer_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_zonal_transfer`] from the bytes of a file, whose name stands in messages. Nothing is allocated that is larger
/// than they are.
///
/// # Errors
/// As [`read_zonal_transfer`].
pub fn read_zonal_transfer_bytes(bytes: &[u8], name: &str) -> Result<(ZonalTransfer, Recipe), PrtError> {
    zonal_of(&TransferFile::parse(bytes, name, &[ZONAL])?)
}

/// The transfer and the recipe in a file of this format.
pub(crate) fn zonal_of(file: &TransferFile<'_>) -> Result<(ZonalTransfer, Recipe), PrtError> {
    let (order, channels) = file.order_and_channels()?;
    let lobes = file.member("lobes", file.header.lobes)?;
    let axes = file.f32("axes", &[None, Some(lobes), Some(3)])?;
    let axes = axes.as_chunks::<3>().0.to_vec();
    let coefficients = file.f32("coefficients", &[None, Some(lobes), Some(channels.count()), Some(order)])?;
    let transfer = ZonalTransfer::new(order, channels, lobes, axes, coefficients)
        .map_err(|e| PrtError::invalid(file.name(), e.to_string()))?;
    let recipe = file.header.recipe.clone().understood(file.name())?;
    Ok((transfer, recipe))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use lobe_io::Job;

    use super::*;
    use crate::compression::compress::CompressOptions;
    use crate::compression::compressed_table::WeightBits;
    use crate::transfer::transfer::{Channels, Transfer};
    use crate::zonal::zonal_fit::{ZonalFitOptions, fit_zonal};
    use lobe_testkit::Random;
    use serde_json::json;

    fn transfer(channels: Channels) -> Transfer {
        let numbers = Random::new(1).signed_vec(20 * 9 * channels.count());
        Transfer::new(3, channels, numbers.iter().map(|x| *x as f32).collect()).unwrap()
    }

    #[test]
    fn compressed_transfer_comes_back_bit_by_bit() {
        let folder = tempfile::tempdir().unwrap();
        let [path, again] = ["a.safetensors", "b.safetensors"].map(|name| folder.path().join(name));
        for channels in [Channels::Gray, Channels::Rgb] {
            for (weights, components) in
                [(WeightBits::F32, 2), (WeightBits::U16, 3), (WeightBits::U8, 1), (WeightBits::U8, 0)]
            {
                let options = CompressOptions { clusters: 3, components, weights, ..CompressOptions::default() };
                let (written, _) = CompressedTransfer::new(&transfer(channels), &options, Job::default()).unwrap();
                let recipe = Recipe::from(json!({"samples": 1024, "clusters": 3}));
                write_compressed_transfer(&path, &written, &recipe).unwrap();
                write_compressed_transfer(&again, &written, &recipe).unwrap();
                assert_eq!(read_compressed_transfer(&path).unwrap(), (written, recipe), "{channels:?}, {weights:?}");
                assert_eq!(fs::read(&path).unwrap(), fs::read(&again).unwrap(), "the same bytes every time");
            }
        }
    }

    #[test]
    fn zonal_transfer_comes_back_bit_by_bit() {
        let path = tempfile::tempdir().unwrap().keep().join("z.safetensors");
        for lobes in [1, 3] {
            let (written, _) =
                fit_zonal(&transfer(Channels::Rgb), &ZonalFitOptions::default().lobes(lobes), Job::default()).unwrap();
            let recipe = Recipe::from(json!({"samples": 1024, "lobes": lobes}));
            write_zonal_transfer(&path, &written, &recipe).unwrap();
            assert_eq!(read_zonal_transfer(&path).unwrap(), (written, recipe), "{lobes} lobes");
        }
        fs::remove_dir_all(path.parent().unwrap()).unwrap();
    }

    #[test]
    fn broken_and_foreign_files_are_refused_in_one_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.safetensors");
        let (written, _) =
            CompressedTransfer::new(&transfer(Channels::Gray), &CompressOptions::default(), Job::default()).unwrap();
        write_compressed_transfer(&path, &written, &Recipe::default()).unwrap();
        let bytes = fs::read(&path).unwrap();
        let refusal = |bytes: &[u8]| read_compressed_transfer_bytes(bytes, "c").unwrap_err().to_string();
        for end in 0..bytes.len() {
            let message = refusal(&bytes[..end]);
            assert!(message.starts_with("c: ") && !message.contains('\n'), "cut at {end}: {message}");
        }
        let replaced = |old: &str, new: &str| {
            assert_eq!(old.len(), new.len(), "the header keeps its length");
            let at = bytes.windows(old.len()).position(|w| w == old.as_bytes()).unwrap();
            let mut changed = bytes.clone();
            changed[at..at + old.len()].copy_from_slice(new.as_bytes());
            refusal(&changed)
        };
        let newer = "expected version 1 of lobe-compressed-transfer, found 7; take a Lobe as new as the file";
        assert_eq!(replaced(r#"version\":1"#, r#"version\":7"#), format!("c: {newer}"), "newer");
        let order = "c: expected an order of 1 to 8, found 9";
        assert_eq!(replaced(r#"order\":3"#, r#"order\":9"#), order, "order");
        assert!(replaced(r#"order\":3"#, r#"order\":4"#).contains("expected a tensor bases of shape"), "shape");
        assert_eq!(replaced(r#""weights""#, r#""weighty""#), "c: expected a tensor weights, found none", "missing");
        let foreign = read_zonal_transfer_bytes(&bytes, "c").unwrap_err().to_string();
        assert_eq!(foreign, "c: expected lobe-zonal-transfer, found lobe-compressed-transfer", "another kind");
        let missing = read_zonal_transfer(folder.path().join("none")).unwrap_err();
        assert!(matches!(missing, PrtError::Io(_)), "{missing}");
    }
}
