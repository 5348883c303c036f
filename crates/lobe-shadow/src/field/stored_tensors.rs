//! Encoded rows as the tensors of a file.

use half::f16;
use lobe_io::{Dtype, IoError, Numbers, Tensor, TensorFile};
use lobe_prt::{CompressedTable, PrtError, TableWeights};

use crate::field::field_storage::StoredRows;

impl StoredRows {
    /// The name of the form in headers.
    pub(crate) fn name(&self) -> &'static str {
        match self {
            Self::F32 => "f32",
            Self::F16(_) => "f16",
            Self::U8 { .. } => "u8",
            Self::Clustered(_) => "clustered",
        }
    }

    /// The tensors of rows that were encoded; those of the rows themselves have this name and shape.
    pub(crate) fn tensors<'a>(&'a self, name: &'static str, shape: &[usize], rows: &'a [f32]) -> Vec<Tensor<'a>> {
        let whole = |numbers| Tensor::new(name, shape, numbers);
        match self {
            Self::F32 => vec![whole(Numbers::F32(rows))],
            Self::F16(x) => vec![whole(Numbers::F16(x))],
            Self::U8 { ranges, steps } => {
                vec![Tensor::new("ranges", [2, ranges.len() / 2], Numbers::F32(ranges)), whole(Numbers::U8(steps))]
            }
            Self::Clustered(table) => {
                let (rows, components) = (table.rows(), table.components());
                let bases = [table.cluster_count(), components + 1, table.width()];
                vec![
                    Tensor::new("bases", bases, Numbers::F32(table.bases())),
                    Tensor::new("clusters", [rows], Numbers::U16(table.clusters())),
                    Tensor::new("weights", [rows, components], table.weights().into()),
                ]
            }
        }
    }

    /// Reads rows of `width` numbers from tensors of a form of storage.
    pub(crate) fn read(
        file: &TensorFile<'_>,
        storage: &str,
        name: &str,
        shape: &[usize],
        width: usize,
    ) -> Result<Vec<f32>, IoError> {
        let rows = shape.iter().product::<usize>() / width.max(1);
        let shape: Vec<Option<usize>> = shape.iter().copied().map(Some).collect();
        match storage {
            "f32" => file.f32(name, &shape),
            "f16" => Ok(file.f16(name, &shape)?.into_iter().map(f16::to_f32).collect()),
            "u8" => {
                let ranges = file.f32("ranges", &[Some(2), Some(width)])?;
                Ok(Self::steps_to_numbers(&ranges, file.bytes(name, Dtype::U8, &shape)?))
            }
            "clustered" => Ok(clustered(file, rows, width)?.decode()),
            other => Err(file.invalid(format!("expected storage f32, f16, u8 or clustered, found {other:?}"))),
        }
    }
}

fn clustered(file: &TensorFile<'_>, rows: usize, width: usize) -> Result<CompressedTable, IoError> {
    let (_, shape) = file.view("bases")?;
    // Without a component few bytes would stand for many numbers.
    let &[clusters, vectors, _] = &*shape else {
        return Err(file.invalid(format!("expected a tensor bases of three numbers, found {shape:?}")));
    };
    if vectors < 2 {
        let message =
            format!("expected a tensor bases of clusters, 2 vectors or more, and {width} numbers, found {shape:?}");
        return Err(file.invalid(message));
    }
    let components = vectors - 1;
    let bases = file.f32("bases", &[Some(clusters), Some(vectors), Some(width)])?;
    let shape = [Some(rows), Some(components)];
    let weights = match file.view("weights")?.0 {
        Dtype::U8 => TableWeights::U8(file.bytes("weights", Dtype::U8, &shape)?.to_vec()),
        Dtype::U16 => TableWeights::U16(file.u16("weights", &shape)?),
        _ => TableWeights::F32(file.f32("weights", &shape)?),
    };
    let of_row = file.u16("clusters", &[Some(rows)])?;
    CompressedTable::new(width, components, of_row, weights, bases).map_err(|error| match error {
        // The table says where it is in words of transfer.
        PrtError::Invalid { message, .. } => file.invalid(format!("clusters and weights: {message}")),
        other => file.invalid(other.to_string()),
    })
}
