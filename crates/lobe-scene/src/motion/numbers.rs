//! Numbers of glTF accessors, each read once and counted before.

use std::collections::HashMap;
use std::sync::Arc;

use gltf_json::{Accessor, Index};

use crate::error::{SceneError, SceneReadOption};
use crate::files::gltf::accessor::Accessors;
use crate::files::gltf::files::GltfFile;
use crate::files::source::Source;

/// The numbers read so far. Whatever names an accessor again shares them, so that a small file cannot ask for the same
/// bytes a thousand times.
#[derive(Default)]
pub(crate) struct Numbers {
    /// By accessor and by what it is read as, which decides about its types.
    read: HashMap<(usize, &'static str), Arc<[f32]>>,
    count: usize,
}

impl Numbers {
    /// All numbers of an accessor of `N` components, which is the number for `what`: that decides which types it may have.
    /// Whole numbers are fractions of their largest value where they are normalized.
    pub(crate) fn of<const N: usize>(
        &mut self,
        (what, place): (&'static str, &str),
        (file, index): (&GltfFile, Index<Accessor>),
        source: &mut Source<'_>,
    ) -> Result<Arc<[f32]>, SceneError> {
        let key = (index.value(), what);
        if let Some(there) = self.read.get(&key) {
            return Ok(Arc::clone(there));
        }
        let accessors = Accessors { file, place: place.to_owned() };
        let found = accessors.count(index, source)?.saturating_mul(N);
        self.add(found, source)?;
        // Held twice for a moment.
        source.check_bytes(4 * found as u64)?;
        let numbers: Arc<[f32]> = accessors.vectors::<N>(what, index, source)?.as_flattened().into();
        self.read.insert(key, Arc::clone(&numbers));
        Ok(numbers)
    }

    /// Counts numbers of four bytes against the limits. Call it before they are allocated.
    pub(crate) fn add(&mut self, count: usize, source: &mut Source<'_>) -> Result<(), SceneError> {
        self.count = self.count.saturating_add(count);
        // Sixteen for each vertex of the largest scene: four joints with weights, and a morph target or two.
        let most = source.limit().saturating_mul(16);
        if self.count > most {
            let message =
                format!("expected at most {most} numbers of animations and skins, found {} or more", self.count);
            return Err(source.refused(message, SceneReadOption::MaxTriangles));
        }
        source.count_bytes(4 * count as u64)
    }
}

/// The members of an array of the file, each an object of this shape.
pub(crate) fn members<T: serde::de::DeserializeOwned>(
    file: &GltfFile,
    array: &str,
    source: &Source<'_>,
) -> Result<Vec<T>, SceneError> {
    let items = file.json[array].as_array().into_iter().flatten().enumerate();
    items.map(|(index, item)| member((array, index), item, source)).collect()
}

/// The item at an index of an array of the file.
pub(crate) fn member<T: serde::de::DeserializeOwned>(
    (array, index): (&str, usize),
    item: &serde_json::Value,
    source: &Source<'_>,
) -> Result<T, SceneError> {
    if !item.is_object() {
        return Err(source.invalid(format!("expected glTF, found an error at {array}[{index}]: expected an object")));
    }
    serde_path_to_error::deserialize(item).map_err(|error| {
        let (place, error) = (error.path().to_string(), error.into_inner());
        source.invalid(format!("expected glTF, found an error at {array}[{index}].{place}: {error}"))
    })
}
