//! Options of storage, of all jobs that write fields.

use lobe_io::{Given, JobOptions, OptionError, OptionField, OptionKind, options};
use lobe_prt::CompressionOptions;
use serde::{Deserialize, Serialize};

use crate::field::field_storage::{FieldStorage, StorageReport};

/// The forms of [`FieldStorage`], without their options.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum StorageForm {
    /// [`FieldStorage::F32`].
    #[default]
    F32,
    /// [`FieldStorage::F16`].
    F16,
    /// [`FieldStorage::U8`].
    U8,
    /// [`FieldStorage::Clustered`].
    Clustered,
}

options! {
    /// How numbers of fields, lamps and visibility are stored.
    pub struct StorageOptions with packing: CompressionOptions {
        /// How numbers are stored
        storage: StorageForm = StorageForm::F32, OptionKind::Name(&[
            ("f32", "Four bytes each"),
            ("f16", "Two bytes each"),
            ("u8", "One byte each, in even steps over the range of each coefficient"),
            ("clustered", "Clustered principal components"),
        ]), "STORAGE", "";
    }
}

impl JobOptions for StorageOptions {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().chain(CompressionOptions::FIELDS).collect()
    }

    fn heading_of(_name: &str) -> Option<&'static str> {
        Some("Storage")
    }

    fn left_open_of(field: &OptionField) -> &'static str {
        match field.name {
            "clusters" => "128",
            "components" => "6",
            "weights" => "8",
            _ => field.left_open,
        }
    }

    fn check_together(&self, given: &Given<'_>) -> Result<(), OptionError> {
        match given.first_of(&CompressionOptions::NAMES) {
            Some(option) if self.storage != StorageForm::Clustered => {
                Err(OptionError::new(option, "only of @storage clustered; leave the option out"))
            }
            _ => Ok(()),
        }
    }
}

impl StorageOptions {
    /// The form that is asked for.
    #[must_use]
    pub fn form(&self) -> FieldStorage {
        match self.storage {
            StorageForm::F32 => FieldStorage::F32,
            StorageForm::F16 => FieldStorage::F16,
            StorageForm::U8 => FieldStorage::U8,
            StorageForm::Clustered => FieldStorage::Clustered(self.packing.over(FieldStorage::clustered())),
        }
    }

    /// What a user should know of a form that takes more bytes than single precision.
    #[must_use]
    pub fn remark(&self, report: &StorageReport) -> Option<String> {
        let (found, single) = (report.bytes, report.bytes_before);
        let text =
            || format!("takes {found} bytes, more than the {single} of f32: there are too few points for @storage");
        (found > single).then(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_words_for_what_is_left_open_are_the_defaults_of_fields() {
        let FieldStorage::Clustered(options) = StorageOptions::default().storage(StorageForm::Clustered).form() else {
            panic!("expected clusters");
        };
        let words = CompressionOptions::FIELDS.iter().map(StorageOptions::left_open_of).collect::<Vec<_>>();
        let bits = 8 * options.weights.bytes();
        assert_eq!(words, [options.clusters.to_string(), options.components.to_string(), bits.to_string()]);
    }
}
