//! Safetensors files of transfer: one header for all of their formats.

use std::cell::RefCell;
use std::io;
use std::ops::Deref;
use std::path::Path;

use lobe_io::{Job, Numbers, Tensor, TensorFile, TensorFormat, write_tensors};
use serde::{Deserialize, Serialize};

use crate::error::PrtError;
use crate::job::meter::Meter;
use crate::recipe::Recipe;
use crate::transfer::transfer::Channels;
use crate::transfer::transfer::check_order;

/// The corners of the box of a grid, and its points along x, y and z.
pub(crate) type GridMember = ([f64; 3], [f64; 3], [usize; 3]);

/// The first version of a format.
pub(crate) const fn format(name: &'static str) -> TensorFormat {
    TensorFormat { name, version: 1, if_older: "bake the transfer anew" }
}

/// The header of every format, without the members that it does not have.
#[derive(Serialize, Deserialize)]
pub(crate) struct Header {
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) quantity: Option<String>,
    pub(crate) order: usize,
    pub(crate) channels: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) clusters: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) components: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) lobes: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) grid: Option<GridMember>,
    #[serde(default)]
    pub(crate) recipe: Recipe,
}

impl Header {
    pub(crate) fn new(order: usize, channels: Channels, recipe: &Recipe) -> Self {
        Self {
            quantity: None,
            order,
            channels: channels.count(),
            clusters: None,
            components: None,
            lobes: None,
            grid: None,
            recipe: recipe.clone(),
        }
    }
}

/// Writes a file of one tensor whose rows need not be in memory; until all is written, nothing has its name.
///
/// # Errors
/// [`PrtError::Io`] if it cannot be written, or the rows cannot be read; [`PrtError::Cancelled`] if the job was told to
/// stop.
pub(crate) fn write_streamed(
    path: &Path,
    (format, header): (TensorFormat, &Header),
    (name, shape): (&'static str, Vec<usize>),
    read_rows: &dyn Fn(usize, &mut [f32]) -> io::Result<()>,
    job: Job<'_>,
) -> Result<(), PrtError> {
    let rows = shape[0];
    let meter = RefCell::new(Meter::new(rows, job)?);
    let read_watched = |first: usize, numbers: &mut [f32]| {
        if first > 0 {
            meter.borrow_mut().reach(first);
        }
        meter.borrow().go_on_writing()?;
        read_rows(first, numbers)
    };
    let written = write_tensors(path, format, header, &[Tensor::new(name, shape, Numbers::Rows(&read_watched))]);
    let mut meter = meter.into_inner();
    if written.is_ok() {
        meter.reach(rows);
    }
    meter.written(written)
}

/// A file that has been read, its header understood.
pub(crate) struct TransferFile<'a> {
    tensors: TensorFile<'a>,
    pub(crate) header: Header,
}

impl<'a> TransferFile<'a> {
    /// # Errors
    /// [`PrtError::Invalid`] if these are no safetensors or of none of the formats; [`PrtError::Unsupported`] if another
    /// version wrote them.
    pub(crate) fn parse(bytes: &'a [u8], name: &'a str, formats: &[TensorFormat]) -> Result<Self, PrtError> {
        let tensors = TensorFile::parse(bytes, name, formats)?;
        let header = tensors.header()?;
        Ok(Self { tensors, header })
    }

    /// The order and the channels of the header, if transfer can have them.
    pub(crate) fn order_and_channels(&self) -> Result<(usize, Channels), PrtError> {
        let Header { order, channels, .. } = self.header;
        check_order(order).map_err(|error| PrtError::invalid(self.name(), error.to_string()))?;
        let message = match channels {
            1 => return Ok((order, Channels::Gray)),
            3 => return Ok((order, Channels::Rgb)),
            found => format!("expected 1 or 3 channels, found {found}"),
        };
        Err(PrtError::invalid(self.name(), message))
    }

    /// A member of the header that the format has.
    pub(crate) fn member<T>(&self, name: &str, member: Option<T>) -> Result<T, PrtError> {
        member.ok_or_else(|| PrtError::invalid(self.name(), format!("expected {name} in its header, found none")))
    }
}

impl<'a> Deref for TransferFile<'a> {
    type Target = TensorFile<'a>;

    fn deref(&self) -> &TensorFile<'a> {
        &self.tensors
    }
}
