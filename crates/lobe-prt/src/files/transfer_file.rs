//! Transfer as safetensors.

use std::path::Path;

use half::f16;
use lobe_io::{Dtype, Job, Numbers, Tensor, TensorFormat, read_file, write_tensors};

use crate::error::PrtError;
use crate::files::tensor_file::{Header, TransferFile, format, write_streamed};
use crate::recipe::Recipe;
use crate::transfer::half_transfer::HalfTransfer;
use crate::transfer::transfer::{Channels, Transfer};
use crate::transfer::transfer_rows::TransferRows;

pub(crate) const TRANSFER: TensorFormat = format("lobe-transfer");
const QUANTITY: &str = "transfer";
const TENSOR: &str = "transfer";

/// Writes transfer as a safetensors file: one tensor `transfer` of `[receivers, channels, n²]` floats.
///
/// The metadata's entry `lobe` is JSON: format `lobe-transfer`, version 1, quantity, order, channels, recipe.
/// The transfer is read a few receivers at a time; until all is written, nothing has the file's name.
///
/// # Errors
/// [`PrtError::Io`] if the system refuses, [`PrtError::Cancelled`] if the job was told to stop.
pub fn write_transfer(
    path: impl AsRef<Path>,
    transfer: &dyn TransferRows,
    recipe: &Recipe,
    job: Job<'_>,
) -> Result<(), PrtError> {
    let (receivers, channels, bands) =
        (transfer.receivers(), transfer.channels().count(), transfer.order() * transfer.order());
    let header = header(transfer.order(), transfer.channels(), recipe);
    let read_rows = |first: usize, rows: &mut [f32]| transfer.read_rows(first, rows);
    let tensor = (TENSOR, vec![receivers, channels, bands]);
    write_streamed(path.as_ref(), (TRANSFER, &header), tensor, &read_rows, job)
}

/// Writes transfer of 16 bits: the file of [`write_transfer`] with floats of 16 bits.
///
/// # Errors
/// [`PrtError::Io`] if the system refuses.
pub fn write_half_transfer(path: impl AsRef<Path>, transfer: &HalfTransfer, recipe: &Recipe) -> Result<(), PrtError> {
    let (channels, bands) = (transfer.channels().count(), transfer.order() * transfer.order());
    let header = header(transfer.order(), transfer.channels(), recipe);
    let numbers = Numbers::F16(transfer.coefficients());
    let tensor = Tensor::new(TENSOR, vec![transfer.receivers(), channels, bands], numbers);
    Ok(write_tensors(path.as_ref(), TRANSFER, &header, &[tensor])?)
}

fn header(order: usize, channels: Channels, recipe: &Recipe) -> Header {
    Header { quantity: Some(QUANTITY.to_owned()), ..Header::new(order, channels, recipe) }
}

/// Reads what [`write_transfer`] or [`write_half_transfer`] wrote: the transfer, in 32 bits, and its recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be read, [`PrtError::Unsupported`] if it is of another version,
/// [`PrtError::Invalid`] if it is none of ours or contradicts itself.
pub fn read_transfer(path: impl AsRef<Path>) -> Result<(Transfer, Recipe), PrtError> {
    let path = path.as_ref();
    read_transfer_bytes(&read_file(path)?, &path.display().to_string())
}

/// [`read_transfer`] from the bytes of a file, whose name stands in messages. Nothing is allocated that is larger than
/// twice as much.
///
/// # Errors
/// As [`read_transfer`].
pub fn read_transfer_bytes(bytes: &[u8], name: &str) -> Result<(Transfer, Recipe), PrtError> {
    transfer_of(&TransferFile::parse(bytes, name, &[TRANSFER])?)
}

/// The transfer and the recipe in a file of this format.
pub(crate) fn transfer_of(file: &TransferFile<'_>) -> Result<(Transfer, Recipe), PrtError> {
    let (order, channels) = checked(file)?;
    let shape = [None, Some(channels.count()), Some(order * order)];
    let coefficients = if is_half(file) {
        // From the bytes, so that the numbers of 16 bits are not in memory besides.
        file.bytes(TENSOR, Dtype::F16, &shape)?.as_chunks().0.iter().map(|b| f16::from_le_bytes(*b).to_f32()).collect()
    } else {
        file.f32(TENSOR, &shape)?
    };
    let transfer = Transfer::new(order, channels, coefficients).map_err(|error| error.within(file.name()))?;
    Ok((transfer, file.header.recipe.clone().understood(file.name())?))
}

/// Whether the numbers of a file of this format are floats of 16 bits.
pub(crate) fn is_half(file: &TransferFile<'_>) -> bool {
    file.view(TENSOR).is_ok_and(|(dtype, _)| dtype == Dtype::F16)
}

/// [`transfer_of`] where [`is_half`].
pub(crate) fn half_of(file: &TransferFile<'_>) -> Result<(HalfTransfer, Recipe), PrtError> {
    let (order, channels) = checked(file)?;
    let coefficients = file.f16(TENSOR, &[None, Some(channels.count()), Some(order * order)])?;
    let transfer = HalfTransfer::from_coefficients(order, channels, coefficients);
    let transfer = transfer.map_err(|error| error.within(file.name()))?;
    Ok((transfer, file.header.recipe.clone().understood(file.name())?))
}

/// The order and the channels, if the numbers are transfer.
fn checked(file: &TransferFile<'_>) -> Result<(usize, Channels), PrtError> {
    let (order, channels) = file.order_and_channels()?;
    let quantity = file.header.quantity.as_deref().unwrap_or_default();
    if quantity != QUANTITY {
        return Err(PrtError::invalid(file.name(), format!("expected the quantity {QUANTITY}, found {quantity:?}")));
    }
    Ok((order, channels))
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::ops::ControlFlow;

    use lobe_io::Progress;
    use serde_json::json;

    use super::*;

    fn file() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        let transfer = Transfer::new(2, Channels::Rgb, (0..24).map(|i| i as f32).collect()).unwrap();
        write_transfer(&path, &transfer, &Recipe::from(json!({"samples": 1024})), Job::default()).unwrap();
        fs::read(path).unwrap()
    }

    /// The file with a text of its header replaced, the header's length put right.
    fn changed(from: &str, to: &str) -> String {
        let bytes = file();
        let length = u64::from_le_bytes(bytes[..8].try_into().unwrap()) as usize;
        let header = String::from_utf8(bytes[8..8 + length].to_vec()).unwrap();
        assert!(header.contains(from), "{header} has {from}");
        let header = header.replace(from, to);
        let mut bad = (header.len() as u64).to_le_bytes().to_vec();
        bad.extend(header.as_bytes());
        bad.extend(&bytes[8 + length..]);
        read_transfer_bytes(&bad, "t").unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read() {
        let (transfer, recipe) = read_transfer_bytes(&file(), "t").unwrap();
        assert_eq!((transfer.order(), transfer.channels(), transfer.receivers()), (2, Channels::Rgb, 2), "shape");
        assert_eq!(transfer.coefficients(), (0..24).map(|i| i as f32).collect::<Vec<_>>(), "numbers");
        assert_eq!(recipe, Recipe::from(json!({"samples": 1024})), "recipe");
    }

    #[test]
    fn transfer_of_16_bits_is_read_in_32_and_as_itself() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("h.safetensors");
        let transfer = Transfer::new(2, Channels::Rgb, (0..24).map(|i| i as f32 / 3.0).collect()).unwrap();
        let (halves, _) = HalfTransfer::new(&transfer).unwrap();
        let recipe = Recipe::from(json!({"samples": 7}));
        write_half_transfer(&path, &halves, &recipe).unwrap();
        assert_eq!(read_transfer(&path).unwrap(), (halves.to_transfer(), recipe.clone()), "in 32 bits");
        let bytes = fs::read(&path).unwrap();
        let file = TransferFile::parse(&bytes, "h", &[TRANSFER]).unwrap();
        assert!(is_half(&file), "it says so");
        assert_eq!(half_of(&file).unwrap(), (halves, recipe), "as itself");
        // Infinity, in the place of the last number.
        let bad = [&bytes[..bytes.len() - 2], &[0x00, 0x7c]].concat();
        let message = read_transfer_bytes(&bad, "h").unwrap_err().to_string();
        assert!(message.starts_with("h: ") && message.contains("found inf at receiver 1"), "{message}");
        let cut = &bytes[..bytes.len() - 1];
        assert!(read_transfer_bytes(cut, "h").is_err(), "a file that was cut off");
    }

    #[test]
    fn hostile_headers_are_refused_in_one_line() {
        for (from, to, expected) in [
            (
                r#"\"version\":1"#,
                r#"\"version\":2"#,
                "t: expected version 1 of lobe-transfer, found 2; take a Lobe as new as the file",
            ),
            ("lobe-transfer", "lobe", "t: expected lobe-transfer, found lobe"),
            (r#"\"order\":2"#, r#"\"order\":9"#, "t: expected an order of 1 to 8, found 9"),
            (r#"\"order\":2"#, r#"\"order\":3"#, "t: expected a tensor transfer of shape [any, 3, 9], found [2, 3, 4]"),
            (r#"\"channels\":3"#, r#"\"channels\":2"#, "t: expected 1 or 3 channels, found 2"),
            (
                r#"\"quantity\":\"transfer\""#,
                r#"\"quantity\":\"light\""#,
                "t: expected the quantity transfer, found \"light\"",
            ),
            ("\"lobe\":", "\"else\":", "t: expected tensors of lobe-transfer, found none of Lobe's"),
            ("\"F32\"", "\"I32\"", "t: expected a tensor transfer of F32, found I32"),
            ("\"transfer\":{", "\"other\":{", "t: expected a tensor transfer, found none"),
        ] {
            assert_eq!(changed(from, to), expected, "{from} as {to}");
        }
        for (from, to) in [
            ("[0,96]", "[0,9999999999]"),
            ("[0,96]", "[96,0]"),
            ("[2,3,4]", "[18446744073709551615,3,4]"),
            ("{", "["),
            (r#"\"version\":1"#, r#"\"version\":-1"#),
            (r#"\"order\":2"#, r#"\"order\":\"\n\""#),
        ] {
            let message = changed(from, to);
            assert!(message.starts_with("t: ") && !message.contains('\n'), "{from} as {to}: {message}");
        }
        let mut endless = file();
        endless[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        let error = read_transfer_bytes(&endless, "t").unwrap_err().to_string();
        assert!(error.starts_with("t: expected safetensors, found "), "{error}");
        for length in 0..file().len() {
            assert!(read_transfer_bytes(&file()[..length], "t").is_err(), "cut off after {length} bytes");
        }
    }

    #[test]
    fn whoever_stops_while_rows_are_written_gets_no_file_and_nobody_else_loses_one() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        // Several times what is read at once.
        let transfer = Transfer::new(1, Channels::Gray, (0..3 << 20).map(|i| i as f32).collect()).unwrap();
        for stop_at in [1, 2, 3, 4, 5] {
            let mut calls = Vec::new();
            let watch = &mut |progress: &Progress| {
                calls.push(progress.done);
                if calls.len() == stop_at { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let written = write_transfer(&path, &transfer, &Recipe::default(), Job::default().watched_by(watch));
            let is_stopped = matches!(written, Err(PrtError::Cancelled));
            assert_eq!(is_stopped, stop_at < 4, "{written:?}, stopped at call {stop_at}");
            assert_eq!(calls, [0, 1 << 20, 2 << 20, 3 << 20][..stop_at.min(4)], "rows written at each call");
            assert_eq!(fs::read_dir(folder.path()).unwrap().count(), usize::from(!is_stopped), "files");
            let _ = fs::remove_file(&path);
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let mut bytes = file();
        let end = bytes.len();
        bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = read_transfer_bytes(&bytes, "t").unwrap_err().to_string();
        assert_eq!(error, "t: transfer: expected finite coefficients, found NaN at receiver 1", "NaN");
    }
}
