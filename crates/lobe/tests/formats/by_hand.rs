//! Readers of Lobe's files that were written from `docs/guide/src/formats.md`: with `serde_json`, without Lobe.

use std::collections::HashMap;
use std::f64::consts::PI;
use std::path::Path;

use serde_json::Value;

/// Tensors by name: shape and numbers.
pub(crate) type Table = HashMap<String, (Vec<usize>, Vec<f64>)>;

pub(crate) fn read_sh_json(path: &Path) -> (u64, String, Vec<[f64; 3]>) {
    let sh: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert_eq!((&sh["format"], &sh["version"]), (&"lobe-sh".into(), &1.into()), "format and version");
    let row = |row: &Value| [0, 1, 2].map(|c| row.get(c).unwrap_or(&row[0]).as_f64().unwrap());
    let rows: Vec<[f64; 3]> = sh["coefficients"].as_array().unwrap().iter().map(row).collect();
    let order = sh["order"].as_u64().unwrap();
    assert_eq!(rows.len() as u64, order * order, "n² rows");
    (order, sh["quantity"].as_str().unwrap().to_owned(), rows)
}

/// The bytes of a record of a checkpoint.
pub(crate) type Record = Vec<u8>;

/// The kind of a checkpoint and its records, without their checksums.
pub(crate) fn read_checkpoint(path: &Path) -> (String, Vec<Record>) {
    let bytes = std::fs::read(path).unwrap();
    let words = bytes.as_chunks::<8>().0;
    assert_eq!((&bytes[..4], &bytes[8..12]), (&b"LOBE"[..], &[3, 0, 0, 0][..]), "a checkpoint of layout 3");
    let [count, length, last] = [2, 3, 4].map(|k| u64::from_le_bytes(words[k]) as usize);
    assert_eq!([words[7], words[8]], [1_u64.to_le_bytes(); 2], "the only shard");
    assert_eq!(bytes.len(), 80 + (count - 1) * (length + 8) + last + 8, "header, {count} records and their checksums");
    let record = |k: usize| bytes[80 + k * (length + 8)..][..if k + 1 == count { last } else { length }].to_vec();
    (str::from_utf8(&bytes[4..8]).unwrap().to_owned(), (0..count).map(record).collect())
}

/// The number of half precision with these bits.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023) / 1024.0);
    let size =
        if exponent == 0 { fraction * 2.0_f64.powi(-14) } else { (1.0 + fraction) * 2.0_f64.powi(exponent - 15) };
    if bits >> 15 == 1 { -size } else { size }
}

/// Numbers of one type: `F32`, `F16`, `U16` or `U8`, fractions of their largest if they are whole and `normalized`.
fn numbers(kind: &str, normalized: bool, bytes: &[u8]) -> Vec<f64> {
    let fraction = |q: f64, largest: f64| if normalized { q / largest } else { q };
    match kind {
        "F32" => bytes.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect(),
        "F16" => bytes.as_chunks().0.iter().map(|b| half(u16::from_le_bytes(*b))).collect(),
        "U16" => bytes.as_chunks().0.iter().map(|b| fraction(u16::from_le_bytes(*b).into(), 65535.0)).collect(),
        _ => bytes.iter().map(|b| fraction((*b).into(), 255.0)).collect(),
    }
}

fn whole(value: &Value) -> usize {
    value.as_u64().unwrap() as usize
}

pub(crate) fn read_safetensors(path: &Path) -> (Value, Table) {
    let bytes = std::fs::read(path).unwrap();
    let start = 8 + u64::from_le_bytes(*bytes.first_chunk().unwrap()) as usize;
    let head: Value = serde_json::from_slice(&bytes[8..start]).unwrap();
    let about: Value = serde_json::from_str(head["__metadata__"]["lobe"].as_str().unwrap()).unwrap();
    let of_fields = ["lobe-occlusion-field", "lobe-lamp"].contains(&about["format"].as_str().unwrap());
    assert_eq!(about["version"], if of_fields { 2 } else { 1 }, "{about}");
    let tensor = |(name, tensor): (&String, &Value)| {
        let [first, end] = [0, 1].map(|k| start + whole(&tensor["data_offsets"][k]));
        let shape = tensor["shape"].as_array().unwrap().iter().map(whole).collect();
        let kind = tensor["dtype"].as_str().unwrap();
        (name.clone(), (shape, numbers(kind, name == "weights", &bytes[first..end])))
    };
    let tensors = head.as_object().unwrap().iter().filter(|(name, _)| *name != "__metadata__");
    let table = tensors.map(tensor).collect();
    (about, table)
}

/// `asset.extras.lobe`, with the members of `compression` beside the others, and the same tensors as of a safetensors file.
pub(crate) fn read_glb(path: &Path) -> (Value, Table) {
    let bytes = std::fs::read(path).unwrap();
    let length = u32::from_le_bytes(*bytes[12..].first_chunk().unwrap()) as usize;
    let gltf: Value = serde_json::from_slice(&bytes[20..20 + length]).unwrap();
    let data = &bytes[20 + length + 8..];
    let mut about = gltf["asset"]["extras"]["lobe"].clone();
    assert_eq!(about["version"], 1, "{about}");
    let (order, channels) = (whole(&about["order"]), whole(&about["channels"]));
    let mut table = Table::new();
    if about["compression"].is_null() {
        let (n2, q) = (order * order, (order * order).div_ceil(4));
        let padded = vertices(&gltf, data, "_TRANSFER_", channels * q);
        let row = |row: &Vec<f64>| (0..channels).flat_map(|c| row[4 * c * q..][..n2].to_vec()).collect::<Vec<_>>();
        table.insert("transfer".into(), (vec![], padded.iter().flat_map(row).collect()));
        return (about, table);
    }
    for member in ["clusters", "components"] {
        about[member] = about["compression"][member].clone();
    }
    let count = whole(&about["components"]);
    let shown = gltf["scene"].as_u64().unwrap_or(0) as usize;
    let bases = base64(gltf["scenes"][shown]["extras"]["lobe"]["bases"].as_str().unwrap());
    let weights = vertices(&gltf, data, "_WEIGHTS_", count.div_ceil(4));
    table.insert("bases".into(), (vec![], numbers("F32", false, &bases)));
    table.insert("weights".into(), (vec![], weights.iter().flat_map(|row| row[..count].to_vec()).collect()));
    let clusters = vertices(&gltf, data, "_CLUSTER", 0).iter().map(|row| row[0]).collect();
    table.insert("clusters".into(), (vec![], clusters));
    (about, table)
}

/// The bytes of a text in base64.
fn base64(text: &str) -> Vec<u8> {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let digit = |c: u8| digits.iter().position(|d| *d == c).unwrap() as u32;
    let whole = text.trim_end_matches('=').as_bytes();
    let bytes = |four: &[u8]| {
        let bits = four.iter().enumerate().map(|(k, c)| digit(*c) << (18 - 6 * k)).sum::<u32>();
        bits.to_be_bytes()[1..four.len()].to_vec()
    };
    whole.chunks(4).flat_map(bytes).collect()
}

/// The numbers of attributes `prefix` 0, 1, .. of every vertex of the scene one after the other; of `prefix` itself for a count
/// of 0.
fn vertices(gltf: &Value, data: &[u8], prefix: &str, count: usize) -> Vec<Vec<f64>> {
    let mut rows = Vec::new();
    let list = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let mut nodes = list(&gltf["scenes"][gltf["scene"].as_u64().unwrap_or(0) as usize]["nodes"]);
    nodes.reverse();
    while let Some(node) = nodes.pop() {
        let node = &gltf["nodes"][whole(&node)];
        nodes.extend(list(&node["children"]).into_iter().rev());
        let Some(mesh) = node["mesh"].as_u64() else { continue };
        for primitive in list(&gltf["meshes"][mesh as usize]["primitives"]) {
            let attributes = &primitive["attributes"];
            let position = &gltf["accessors"][whole(&attributes["POSITION"])];
            let mut own = vec![Vec::new(); whole(&position["count"])];
            let names = if count == 0 && prefix == "_CLUSTER" {
                vec![prefix.to_owned()]
            } else {
                (0..count).map(|k| format!("{prefix}{k}")).collect()
            };
            for name in names {
                for (row, values) in own.iter_mut().zip(column(gltf, data, whole(&attributes[&name]))) {
                    row.extend(values);
                }
            }
            rows.extend(own);
        }
    }
    rows
}

fn column(gltf: &Value, data: &[u8], accessor: usize) -> Vec<Vec<f64>> {
    let accessor = &gltf["accessors"][accessor];
    let view = &gltf["bufferViews"][whole(&accessor["bufferView"])];
    let (kind, bytes) = match whole(&accessor["componentType"]) {
        5126 => ("F32", 4),
        5123 => ("U16", 2),
        _ => ("U8", 1),
    };
    let length = bytes * if accessor["type"] == "VEC4" { 4 } else { 1 };
    let first = whole(&view["byteOffset"]) + accessor["byteOffset"].as_u64().unwrap_or(0) as usize;
    let step = view["byteStride"].as_u64().map_or(length, |step| step as usize);
    let value = |v: usize| numbers(kind, accessor["normalized"] == true, &data[first + v * step..][..length]);
    (0..whole(&accessor["count"])).map(value).collect()
}

/// The nine functions of order 3, from the page of conventions.
pub(crate) fn basis([x, y, z]: [f64; 3]) -> [f64; 9] {
    let k = |a: f64| (a / PI).sqrt();
    [
        0.5 * k(1.0),
        -0.5 * k(3.0) * y,
        0.5 * k(3.0) * z,
        -0.5 * k(3.0) * x,
        0.5 * k(15.0) * x * y,
        -0.5 * k(15.0) * y * z,
        0.25 * k(5.0) * (3.0 * z * z - 1.0),
        -0.5 * k(15.0) * x * z,
        0.25 * k(15.0) * (x * x - y * y),
    ]
}

/// The transfer of every receiver, channel by channel, in the order of the index; lobes of order 3.
pub(crate) fn transfer_of(about: &Value, table: &Table) -> Vec<Vec<f64>> {
    let (order, channels) = (whole(&about["order"]), whole(&about["channels"]));
    let (n2, width) = (order * order, channels * order * order);
    let flat = |name: &str| &table[name].1;
    if table.contains_key("transfer") {
        return flat("transfer").chunks(width).map(<[f64]>::to_vec).collect();
    }
    if table.contains_key("bases") {
        let (count, bases, weights) = (whole(&about["components"]), flat("bases"), flat("weights"));
        let row = |(r, k): (usize, &f64)| {
            let start = *k as usize * (1 + count) * width;
            let direction = |j: usize, i: usize| weights[r * count + j] * bases[start + (1 + j) * width + i];
            (0..width).map(|i| bases[start + i] + (0..count).map(|j| direction(j, i)).sum::<f64>()).collect()
        };
        return flat("clusters").iter().enumerate().map(row).collect();
    }
    let (lobes, axes, z) = (whole(&about["lobes"]), flat("axes"), flat("coefficients"));
    let row = |r: usize| {
        let mut row = vec![0.0; width];
        for k in r * lobes..(r + 1) * lobes {
            let y = basis([axes[3 * k], axes[3 * k + 1], axes[3 * k + 2]]);
            for (at, total) in row.iter_mut().enumerate() {
                let (c, i) = (at / n2, at % n2);
                let l = i.isqrt();
                *total += (4.0 * PI / (2 * l + 1) as f64).sqrt() * z[(k * channels + c) * order + l] * y[i];
            }
        }
        row
    };
    (0..axes.len() / (3 * lobes)).map(row).collect()
}

/// What a receiver sends back of light of the same order.
pub(crate) fn exit_radiance(about: &Value, row: &[f64], light: &[[f64; 3]]) -> [f64; 3] {
    let n2 = light.len();
    let start = if about["channels"] == 3 { [0, n2, 2 * n2] } else { [0; 3] };
    [0, 1, 2].map(|c| light.iter().zip(&row[start[c]..]).map(|(light, t)| light[c] * t).sum())
}
