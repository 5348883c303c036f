//! Public values as JSON and back (feature `serde`).

#![cfg(feature = "serde")]
#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fmt::Debug;

use lobe::env::{
    CubeWriteOptions, DiscLight, ExportOptions, FisheyeOptions, MapReadOptions, Mapping, PrefilterOptions, Resample,
    SkyFitOptions, SpecularLobe, SphereLight, SunChoice, SunOptions, VectorIrradiance,
};
use lobe::image::{PictureReadOptions, PictureWriteOptions, TexelFormat, Tone};
use lobe::io::{Progress, Shard};
use lobe::motion::{MovingMethod, MovingOptions};
use lobe::prt::{AdaptiveOptions, BakeOptions, CompressOptions, ZonalFitOptions};
use lobe::render::{EnvironmentMapOptions, PathOptions, TruthOptions, ViewOptions};
use lobe::scene::{Material, SceneReadOptions};
use lobe::sh::exponential::ExpMethod;
use lobe::sh::{Dir, Rgb, Rotation, Window};
use lobe::shadow::ShadowOptions;
use serde_json::{Value, from_str, to_string};

fn keeps<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug>(value: &T) {
    let text = to_string(value).unwrap();
    assert_eq!(&from_str::<T>(&text).unwrap(), value, "{text}");
}

#[test]
fn options_come_back_from_json_as_they_went() {
    keeps(&BakeOptions::default().order(6).samples(300));
    keeps(&AdaptiveOptions::default().error(0.2));
    keeps(&CompressOptions::default());
    keeps(&ZonalFitOptions::default().lobes(3));
    keeps(&MapReadOptions::default().mapping(Mapping::Angular));
    keeps(&MapReadOptions::default().fisheye(FisheyeOptions::default().axis(-Dir::Z).circle([9.5, 8.0, 7.0])));
    keeps(&CubeWriteOptions::default().texels(TexelFormat::Rgb9e5));
    keeps(&ExportOptions::default().size(64).suns(SunChoice::Count(2)));
    keeps(&PrefilterOptions::default().size(64));
    keeps(&SunOptions::default());
    keeps(&SkyFitOptions::default());
    keeps(&Resample::to(Mapping::Cube, 8, 48).rotated(Rotation::from_axis_angle(Dir::Z, 0.5)));
    keeps(&PictureReadOptions::default());
    keeps(&PictureWriteOptions::default().half(true));
    keeps(&Tone::PHOTOGRAPH);
    keeps(&SceneReadOptions::default().allow_outside(true));
    keeps(&Material::WHITE);
    keeps(&ViewOptions::default());
    keeps(&EnvironmentMapOptions::default().mapping(Mapping::Sphere));
    keeps(&TruthOptions::default());
    keeps(&PathOptions::default());
    keeps(&ShadowOptions::default().method(ExpMethod::Hybrid { limit: 0.5 }).group(32));
    keeps(&MovingOptions::default().method(MovingMethod::Exponentials).bounce(true));
}

#[test]
fn values_come_back_from_json_as_they_went() {
    keeps(&SphereLight { center: [0.0, 1.0, 2.5], radius: 0.5 });
    keeps(&DiscLight { center: [0.0, 1.0, 2.5], normal: Dir::Z, radius: 0.5 });
    keeps(&SpecularLobe::BlinnPhong { exponent: 12.0 });
    keeps(&VectorIrradiance::<Rgb<f64>>::default());
    keeps(&Window::Hanning { width: 4.5 });
    keeps(&Shard::new(2, 7));
}

#[test]
fn a_shard_is_its_text_and_checked_as_that_is() {
    assert_eq!(to_string(&Shard::new(2, 7)).unwrap(), "\"2/7\"", "its text");
    let error = from_str::<Shard>("\"8/7\"").unwrap_err().to_string();
    assert!(error.contains("expected a shard such as 2/7"), "{error}");
}

#[test]
fn an_option_that_is_left_out_has_its_default() {
    let options: BakeOptions = from_str("{\"order\": 2}").unwrap();
    assert_eq!(options, BakeOptions::default().order(2), "by serde(default)");
    let error = from_str::<BakeOptions>("{\"order\": \"two\"}").unwrap_err().to_string();
    assert!(error.contains("expected usize"), "{error}");
}

#[test]
fn reports_are_objects_with_the_names_of_their_fields() {
    let sunset = lobe::env::bundled::sunset();
    let (_, report) = lobe::env::read_map_bytes(sunset.bytes, "sunset", &MapReadOptions::default()).unwrap();
    let Value::Object(members) = serde_json::to_value(&report).unwrap() else { panic!("{report:?}") };
    assert_eq!(members["picture"]["width"], 512, "{members:?}");
    let progress = serde_json::to_value(Progress { done: 3, total: 10, ..Progress::default() }).unwrap();
    assert_eq!((&progress["done"], &progress["total"]), (&3.into(), &10.into()), "{progress}");
}
