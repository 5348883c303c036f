//! Public values as JSON and back (feature `serde`).

use std::fmt::Debug;

use lobe_gpu::{AdapterChoice, ContextOptions, SceneViewOptions, Storage, TurntableOptions, ViewOutput};
use serde_json::{from_str, to_string};

fn keeps<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = to_string(value).unwrap();
    assert_eq!(&from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back_from_json_as_they_went() {
    let options = ContextOptions::default().adapter(AdapterChoice::Software);
    keeps(&options.max_storage_binding(1 << 20));
    keeps(&SceneViewOptions::default().width(31).output(ViewOutput::Display));
    keeps(&TurntableOptions::default().frames(7));
    keeps(&Storage::F16);
}

#[test]
fn an_option_that_is_left_out_has_its_default() {
    let options: ContextOptions = from_str("{\"adapter\": \"software\"}").unwrap();
    assert_eq!(options, ContextOptions::default().adapter(AdapterChoice::Software), "by serde(default)");
}
