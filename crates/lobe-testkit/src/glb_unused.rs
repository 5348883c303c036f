//! Data of .glb files that nothing names.

use std::collections::BTreeSet;

use serde_json::Value;

use crate::glb_faults::chunks;

/// Buffer views begin at multiples of four or eight, so that up to seven bytes before one may belong to none.
const PADDING: u64 = 7;

/// What a .glb file holds that nothing in it names, a line each: accessors, buffer views, and bytes of the buffer that
/// lie in no buffer view. Members that name them have the names of glTF, wherever they stand: extensions and extras
/// count.
#[must_use]
pub fn glb_unused(bytes: &[u8]) -> Vec<String> {
    let (json, buffer) = match chunks(bytes) {
        Ok(chunks) => chunks,
        Err(fault) => return vec![fault],
    };
    let Ok(json) = serde_json::from_slice::<Value>(json) else { return vec!["the JSON is none".to_owned()] };
    let mut named = [BTreeSet::new(), BTreeSet::new()];
    collect(&json, "", &mut named);
    let mut unused = Vec::new();
    for (array, named) in ["accessors", "bufferViews"].into_iter().zip(named) {
        let count = json[array].as_array().map_or(0, Vec::len) as u64;
        unused.extend((0..count).filter(|i| !named.contains(i)).map(|i| format!("{array}[{i}] is named by nothing")));
    }
    let number = |view: &Value, member: &str| view[member].as_u64().unwrap_or(0);
    let views = json["bufferViews"].as_array().into_iter().flatten();
    let mut ranges: Vec<[u64; 2]> =
        views.map(|view| [number(view, "byteOffset"), number(view, "byteLength")]).collect();
    ranges.push([buffer.len() as u64, 0]);
    ranges.sort_unstable();
    let mut end = 0;
    for [start, length] in ranges {
        if start > end + PADDING {
            unused.push(format!("bytes {end} to {start} lie in no buffer view"));
        }
        end = end.max(start + length);
    }
    unused
}

/// The indices of accessors and of buffer views below a member of this name.
fn collect(json: &Value, name: &str, named: &mut [BTreeSet<u64>; 2]) {
    match name {
        "attributes" | "targets" | "indices" | "input" | "output" | "inverseBindMatrices" => {
            named[0].extend(json.as_u64());
        }
        "bufferView" | "bufferViews" => named[1].extend(json.as_u64()),
        _ => {}
    }
    // Below attributes and targets members are named for what they hold.
    let is_set = matches!(name, "attributes" | "targets");
    json.as_array().into_iter().flatten().for_each(|item| collect(item, name, named));
    for (member, value) in json.as_object().into_iter().flatten() {
        collect(value, if is_set { name } else { member }, named);
    }
}
