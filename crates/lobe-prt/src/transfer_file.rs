//! Transfer as safetensors.

use std::collections::HashMap;
use std::fs;
use std::path::Path;

use safetensors::{Dtype, SafeTensors};
use serde_json::{Value, json};

use crate::tensor_file::{Streamed, write_streamed};
use crate::{Channels, PrtError, Transfer, TransferRows};

/// The version of the header. Files with a higher one are refused.
const VERSION: u64 = 1;
const FORMAT: &str = "lobe-transfer";
const TENSOR: &str = "transfer";

/// Writes transfer as a safetensors file: one tensor `transfer` of `[receivers, channels, n²]` floats.
///
/// The metadata's entry `lobe` is JSON: format `lobe-transfer`, version 1, quantity, order, channels, recipe.
/// The transfer is read a few receivers at a time; until all is written, nothing has the file's name.
///
/// # Errors
/// [`PrtError::Io`] if the system refuses.
pub fn write_transfer(path: impl AsRef<Path>, transfer: &dyn TransferRows, recipe: &Value) -> Result<(), PrtError> {
    let (receivers, channels, bands) =
        (transfer.receivers(), transfer.channels().count(), transfer.order() * transfer.order());
    let header = json!({
        "format": FORMAT,
        "version": VERSION,
        "quantity": "transfer",
        "order": transfer.order(),
        "channels": channels,
        "recipe": recipe,
    });
    let read_rows = |first: usize, rows: &mut [f32]| transfer.read_rows(first, rows);
    write_streamed(
        path.as_ref(),
        &header,
        &Streamed { name: TENSOR, shape: vec![receivers, channels, bands], read_rows: &read_rows },
    )
}

/// Reads what [`write_transfer`] wrote: the transfer and its recipe.
///
/// # Errors
/// [`PrtError::Io`] if the file cannot be read, [`PrtError::Unsupported`] if it is of a newer version, [`PrtError::Invalid`] if it
/// is none of ours or contradicts itself.
pub fn read_transfer(path: impl AsRef<Path>) -> Result<(Transfer, Value), PrtError> {
    let path = path.as_ref();
    let name = path.display().to_string();
    let bytes = fs::read(path).map_err(|source| PrtError::Io { file: name.clone(), source })?;
    transfer_of_bytes(&bytes, &name)
}

/// The transfer in the bytes of a file. Nothing is allocated that is larger than they are.
fn transfer_of_bytes(bytes: &[u8], name: &str) -> Result<(Transfer, Value), PrtError> {
    let invalid = |message: String| PrtError::invalid(name, message.replace(['\n', '\r'], " "));
    let broken = |error| invalid(format!("expected safetensors, found an error: {error}"));
    let (_, metadata) = SafeTensors::read_metadata(bytes).map_err(broken)?;
    let (order, channels, recipe) = read_header(metadata.metadata().as_ref(), name)?;
    let tensors = SafeTensors::deserialize(bytes).map_err(broken)?;
    let tensor = tensors.tensor(TENSOR).map_err(broken)?;
    let row = [channels.count(), order * order];
    if tensor.dtype() != Dtype::F32 || tensor.shape().len() != 3 || tensor.shape()[1..] != row {
        let (kind, shape) = (tensor.dtype(), tensor.shape());
        return Err(invalid(format!(
            "expected F32 of [receivers, {}, {}], found {kind:?} of {shape:?}",
            row[0], row[1]
        )));
    }
    let coefficients = tensor.data().as_chunks().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
    let transfer = Transfer::new(order, channels, coefficients).map_err(|error| error.within(name))?;
    Ok((transfer, recipe))
}

/// Order, channels and recipe, from the metadata.
fn read_header(metadata: Option<&HashMap<String, String>>, name: &str) -> Result<(usize, Channels, Value), PrtError> {
    let lobe: Value = metadata
        .and_then(|metadata| serde_json::from_str(metadata.get("lobe")?).ok())
        .ok_or_else(|| PrtError::invalid(name, "expected JSON as the entry lobe of the metadata"))?;
    let expected = |what: &str, member: &str| {
        PrtError::invalid(name, format!("expected {what} as {member} in the metadata, found {}", lobe[member]))
    };
    if lobe["format"] != FORMAT {
        return Err(expected(FORMAT, "format"));
    }
    match lobe["version"].as_u64() {
        Some(VERSION) => {}
        Some(version) if version > VERSION => {
            let message = format!("written by a newer Lobe: expected version {VERSION}, found {version}: update Lobe");
            return Err(PrtError::Unsupported { place: name.to_string(), message });
        }
        _ => return Err(expected("version 1", "version")),
    }
    if lobe["quantity"] != "transfer" {
        return Err(expected("transfer", "quantity"));
    }
    let order = match lobe["order"].as_u64() {
        Some(order @ 1..=8) => order as usize,
        _ => return Err(expected("1 to 8", "order")),
    };
    let channels = match lobe["channels"].as_u64() {
        Some(1) => Channels::Grey,
        Some(3) => Channels::Rgb,
        _ => return Err(expected("1 or 3", "channels")),
    };
    Ok((order, channels, lobe["recipe"].clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file() -> Vec<u8> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.safetensors");
        let transfer = Transfer::new(2, Channels::Rgb, (0..24).map(|i| i as f32).collect()).unwrap();
        write_transfer(&path, &transfer, &json!({"samples": 1024})).unwrap();
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
        transfer_of_bytes(&bad, "t").unwrap_err().to_string()
    }

    #[test]
    fn what_is_written_is_read() {
        let (transfer, recipe) = transfer_of_bytes(&file(), "t").unwrap();
        assert_eq!((transfer.order(), transfer.channels(), transfer.receivers()), (2, Channels::Rgb, 2), "shape");
        assert_eq!(transfer.coefficients(), (0..24).map(|i| i as f32).collect::<Vec<_>>(), "numbers");
        assert_eq!(recipe, json!({"samples": 1024}), "recipe");
    }

    #[test]
    fn hostile_headers_are_refused_in_one_line() {
        for (from, to, expected) in [
            (
                r#"\"version\":1"#,
                r#"\"version\":2"#,
                "t: written by a newer Lobe: expected version 1, found 2: update Lobe",
            ),
            (r#"\"version\":1"#, r#"\"version\":-1"#, "t: expected version 1 as version in the metadata, found -1"),
            ("lobe-transfer", "lobe", "t: expected lobe-transfer as format in the metadata, found \"lobe\""),
            (r#"\"order\":2"#, r#"\"order\":9"#, "t: expected 1 to 8 as order in the metadata, found 9"),
            (r#"\"order\":2"#, r#"\"order\":3"#, "t: expected F32 of [receivers, 3, 9], found F32 of [2, 3, 4]"),
            (r#"\"channels\":3"#, r#"\"channels\":2"#, "t: expected 1 or 3 as channels in the metadata, found 2"),
            ("\"lobe\":", "\"else\":", "t: expected JSON as the entry lobe of the metadata"),
            ("\"F32\"", "\"I32\"", "t: expected F32 of [receivers, 3, 4], found I32 of [2, 3, 4]"),
        ] {
            assert_eq!(changed(from, to), expected, "{from} as {to}");
        }
        for (from, to) in [
            ("[0,96]", "[0,9999999999]"),
            ("[0,96]", "[96,0]"),
            ("[2,3,4]", "[18446744073709551615,3,4]"),
            ("{", "["),
            ("\"transfer\":{", "\"other\":{"),
        ] {
            let message = changed(from, to);
            assert!(message.starts_with("t: expected ") && !message.contains('\n'), "{from} as {to}: {message}");
        }
        let mut endless = file();
        endless[..8].copy_from_slice(&u64::MAX.to_le_bytes());
        let error = transfer_of_bytes(&endless, "t").unwrap_err().to_string();
        assert!(error.starts_with("t: expected safetensors, found an error: "), "{error}");
        for length in 0..file().len() {
            assert!(transfer_of_bytes(&file()[..length], "t").is_err(), "cut off after {length} bytes");
        }
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        let mut bytes = file();
        let end = bytes.len();
        bytes[end - 4..].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = transfer_of_bytes(&bytes, "t").unwrap_err().to_string();
        assert_eq!(error, "t: transfer: expected finite coefficients, found NaN at receiver 1", "NaN");
    }
}
