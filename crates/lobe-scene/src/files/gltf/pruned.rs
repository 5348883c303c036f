//! glTF document without what nothing names: accessors, buffer views and bytes.

use std::collections::BTreeSet;

use serde_json::{Map, Value, json};

use crate::files::gltf::document::GltfDocument;
use crate::files::gltf::files::items;

/// Extensions, by the beginnings of their names, that name neither accessors nor buffer views.
const WITHOUT_DATA: [&str; 7] =
    ["KHR_lights_", "KHR_materials_", "KHR_texture_", "KHR_node_", "EXT_materials_", "EXT_texture_", "VRM"];

/// Buffer views keep what their beginning leaves over when it is divided by this, which no format asks more of.
const ALIGNMENT: usize = 8;

impl GltfDocument {
    /// The document without accessors and buffer views that nothing names, and without bytes of no buffer view.
    ///
    /// What extensions and extras name cannot be known. Accessors and buffer views up to the largest index among
    /// their whole numbers stay where they are. If they have a member `buffer`, the document stays as it is.
    #[must_use]
    pub fn pruned(mut self) -> Self {
        let mut foreign = Foreign::default();
        foreign.look_through(&self.json);
        if foreign.has_bytes {
            return self;
        }
        retain(&mut self.json, "accessors", &foreign.numbers, visit_accessors);
        retain(&mut self.json, "bufferViews", &foreign.numbers, visit_views);
        self.pack();
        self
    }

    /// Moves the bytes of buffer views together.
    fn pack(&mut self) {
        let length = self.bytes.len();
        let found = items(&mut self.json, "bufferViews").map(|view| bytes_of(view).filter(|[_, end]| *end <= length));
        // Bytes that are not there are a fault, which readers tell.
        let Some(mut found) = found.collect::<Option<Vec<_>>>() else { return };
        found.sort_unstable();
        let (mut moved, mut old_end, mut end) = (Vec::<[usize; 2]>::new(), 0, 0);
        for [start, stop] in found {
            if moved.is_empty() || start > old_end {
                let aligned = end + (start % ALIGNMENT + ALIGNMENT - end % ALIGNMENT) % ALIGNMENT;
                self.bytes[end..aligned].fill(0);
                moved.push([start, aligned]);
                (old_end, end) = (start, aligned);
            }
            if stop > old_end {
                self.bytes.copy_within(old_end..stop, end);
                (old_end, end) = (stop, end + stop - old_end);
            }
        }
        self.bytes.truncate(end);
        for view in items(&mut self.json, "bufferViews") {
            let start = bytes_of(view).map_or(0, |[start, _]| start);
            let block = moved.partition_point(|[from, _]| *from <= start).checked_sub(1).map(|k| moved[k]);
            if let Some([from, to]) = block.filter(|[from, to]| from != to) {
                view["byteOffset"] = json!(start - from + to);
            }
        }
        self.declare_buffer();
        if self.bytes.is_empty()
            && let Value::Object(members) = &mut self.json
        {
            members.remove("buffers");
        }
    }
}

/// What extensions and extras hold that may name data.
#[derive(Default)]
struct Foreign {
    numbers: BTreeSet<u64>,
    /// Whether some name bytes of a buffer.
    has_bytes: bool,
}

impl Foreign {
    fn look_through(&mut self, json: &Value) {
        json.as_array().into_iter().flatten().for_each(|item| self.look_through(item));
        for (name, member) in json.as_object().into_iter().flatten() {
            match (name.as_str(), member) {
                ("extensions", Value::Object(extensions)) => self.look_through_extensions(extensions),
                ("extras", _) => self.take(member),
                _ => self.look_through(member),
            }
        }
    }

    fn look_through_extensions(&mut self, extensions: &Map<String, Value>) {
        for (name, extension) in extensions {
            let is_known = WITHOUT_DATA.iter().any(|known| name.starts_with(known));
            if is_known { self.look_through(extension) } else { self.take(extension) }
        }
    }

    fn take(&mut self, json: &Value) {
        self.numbers.extend(json.as_u64());
        json.as_array().into_iter().flatten().for_each(|item| self.take(item));
        for (name, member) in json.as_object().into_iter().flatten() {
            self.has_bytes |= name == "buffer";
            self.take(member);
        }
    }
}

/// Removes the items of an array that nothing names, and gives those that name others their new index.
fn retain(
    json: &mut Value,
    array: &str,
    foreign: &BTreeSet<u64>,
    visit: impl Fn(&mut Value, &mut dyn FnMut(&mut Value)),
) {
    let count = items(json, array).count() as u64;
    let fixed = foreign.range(..count).next_back().map_or(0, |largest| largest + 1);
    let mut used: BTreeSet<u64> = (0..fixed).collect();
    visit(json, &mut |index| used.extend(index.as_u64().filter(|index| *index < count)));
    let used: Vec<u64> = used.into_iter().collect();
    if used.len() as u64 == count {
        return;
    }
    visit(json, &mut |index| {
        if let Some(Ok(new)) = index.as_u64().map(|old| used.binary_search(&old)) {
            *index = json!(new);
        }
    });
    let Value::Object(members) = json else { return };
    if used.is_empty() {
        // An empty array is not valid.
        members.remove(array);
    } else if let Some(Value::Array(items)) = members.get_mut(array) {
        let mut index = 0..;
        items.retain(|_| index.next().is_some_and(|index| used.binary_search(&index).is_ok()));
    }
}

/// Everything by which glTF names an accessor.
fn visit_accessors(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for primitive in items(json, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        let attributes = primitive.get_mut("attributes").and_then(Value::as_object_mut);
        attributes.into_iter().flat_map(|set| set.values_mut()).for_each(&mut *visit);
        let targets = items(primitive, "targets").filter_map(Value::as_object_mut);
        targets.flat_map(|set| set.values_mut()).for_each(&mut *visit);
        primitive.get_mut("indices").into_iter().for_each(&mut *visit);
    }
    for sampler in items(json, "animations").flat_map(|animation| items(animation, "samplers")) {
        ["input", "output"].iter().for_each(|end| sampler.get_mut(end).into_iter().for_each(&mut *visit));
    }
    items(json, "skins").filter_map(|skin| skin.get_mut("inverseBindMatrices")).for_each(&mut *visit);
}

/// Everything by which glTF names a buffer view.
fn visit_views(json: &mut Value, visit: &mut dyn FnMut(&mut Value)) {
    for accessor in items(json, "accessors") {
        accessor.get_mut("bufferView").into_iter().for_each(&mut *visit);
        for part in ["/sparse/indices/bufferView", "/sparse/values/bufferView"] {
            accessor.pointer_mut(part).into_iter().for_each(&mut *visit);
        }
    }
    items(json, "images").filter_map(|image| image.get_mut("bufferView")).for_each(&mut *visit);
}

/// The first byte of a buffer view, and the one behind its last.
fn bytes_of(view: &Value) -> Option<[usize; 2]> {
    let number = |name: &str| view.get(name).map_or(Some(0), Value::as_u64).map(|n| n as usize);
    let start = number("byteOffset")?;
    Some([start, start.checked_add(number("byteLength")?)?])
}
