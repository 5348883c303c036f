//! Reference values computed to 40 digits or by exact quadrature, stored in `golden/goldens.json`.

use std::sync::OnceLock;

use serde_json::Value;

/// The golden value under a JSON pointer such as `/product/6/c`.
///
/// # Panics
/// If there is no such entry: a missing golden value is a failure.
#[must_use]
pub fn golden(pointer: &str) -> &'static Value {
    static STORE: OnceLock<Value> = OnceLock::new();
    let store = STORE.get_or_init(|| {
        serde_json::from_str(include_str!("../golden/goldens.json")).expect("goldens.json is valid JSON")
    });
    store.pointer(pointer).unwrap_or_else(|| panic!("no golden value at {pointer}"))
}

/// The golden numbers under a JSON pointer, nested arrays flattened.
///
/// # Panics
/// If there is no such entry or it holds anything but numbers.
#[must_use]
pub fn golden_f64s(pointer: &str) -> Vec<f64> {
    fn flatten(value: &Value, pointer: &str, out: &mut Vec<f64>) {
        match value {
            Value::Array(items) => items.iter().for_each(|item| flatten(item, pointer, out)),
            other => out.push(other.as_f64().unwrap_or_else(|| panic!("not a number at {pointer}: {other}"))),
        }
    }
    let mut out = Vec::new();
    flatten(golden(pointer), pointer, &mut out);
    out
}
