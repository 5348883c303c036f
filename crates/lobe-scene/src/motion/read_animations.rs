//! Animations of glTF files.

use std::collections::HashSet;

use serde::Deserialize;
use serde_json::Value;

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::read_options::ScenePose;
use crate::files::source::Source;
use crate::motion::animation::{Animation, Channel, Property};
use crate::motion::numbers::{Numbers, member};
use crate::motion::read_samplers::{GltfSampler, Samplers};
use crate::motion::rig::Rig;
use crate::scene::transform::Local;

#[derive(Deserialize)]
struct GltfAnimation {
    name: Option<String>,
    #[serde(default)]
    channels: Vec<GltfChannel>,
    #[serde(default)]
    samplers: Vec<GltfSampler>,
}

#[derive(Deserialize)]
struct GltfChannel {
    sampler: usize,
    target: GltfTarget,
}

#[derive(Deserialize)]
struct GltfTarget {
    node: Option<usize>,
    path: String,
}

/// The animations that are read; of the others only names are known.
pub(crate) enum Wanted<'a> {
    All,
    /// The one of a pose.
    Of(&'a ScenePose),
}

impl Wanted<'_> {
    /// Whether the animation of a number is read, by the same rule as
    /// [`AnimatedScene::animation`](crate::AnimatedScene::animation).
    fn has(&self, number: usize, names: &[Option<&str>]) -> bool {
        match self {
            Self::All => true,
            Self::Of(ScenePose::Start | ScenePose::At { animation: None, .. }) => number == 0,
            Self::Of(ScenePose::At { animation: Some(asked), .. }) => {
                let by_name = names.iter().position(|name| *name == Some(asked));
                by_name.or_else(|| asked.parse().ok()) == Some(number)
            }
            Self::Of(ScenePose::Unposed) => false,
        }
    }

    /// Whether a fault is noted, as nobody has asked for the animation.
    fn is_assumed(&self) -> bool {
        matches!(self, Self::Of(ScenePose::Start))
    }
}

/// The animations of a file, without channels where they are not wanted. What Lobe has nothing for, such as animated
/// materials, is noted.
pub(crate) fn read(
    (file, wanted): (&GltfFile, &Wanted<'_>),
    rig: &Rig,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Vec<Animation>, SceneError> {
    let items = file.json["animations"].as_array().map_or(&[][..], Vec::as_slice);
    let names: Vec<Option<&str>> = items.iter().map(|item| item["name"].as_str()).collect();
    let mut samplers = Samplers::new(file, numbers);
    let mut animations = Vec::with_capacity(items.len());
    for (index, item) in items.iter().enumerate() {
        let channels = if wanted.has(index, &names) {
            match channels_of((index, item), rig, &mut samplers, source) {
                Err(SceneError::Invalid { message, .. } | SceneError::Unsupported { message, .. })
                    if wanted.is_assumed() =>
                {
                    source.note(format!("{message}; nothing is animated"));
                    Vec::new()
                }
                channels => channels?,
            }
        } else {
            Vec::new()
        };
        animations.push(Animation { name: names[index].map(str::to_owned), channels });
    }
    Ok(animations)
}

fn channels_of(
    (index, item): (usize, &Value),
    rig: &Rig,
    samplers: &mut Samplers<'_>,
    source: &mut Source<'_>,
) -> Result<Vec<Channel>, SceneError> {
    let json: GltfAnimation = member(("animations", index), item, source)?;
    let place = match &json.name {
        Some(name) => format!("animation `{name}`"),
        None => format!("animation {index}"),
    };
    let (mut channels, mut animated) = (Vec::new(), HashSet::new());
    for channel in &json.channels {
        let Some((node, property)) = target(channel, rig, &place, source)? else { continue };
        if !animated.insert((node, property)) {
            let message = format!("{place}: two channels animate the {} of node {node}", channel.target.path);
            return Err(source.invalid(message));
        }
        let Some(sampler) = json.samplers.get(channel.sampler) else {
            let (sampler, count) = (channel.sampler, json.samplers.len());
            return Err(source.invalid(format!("{place}: uses sampler {sampler}, but there are {count}")));
        };
        let place = format!("{place}, sampler {}", channel.sampler);
        let width = match property {
            Property::Rotation => 4,
            Property::Weights => rig.rest.weights[node].len(),
            _ => 3,
        };
        let sampler = samplers.of(sampler, (property, width), &place, source)?;
        channels.push(Channel { node, property, sampler });
    }
    Ok(channels)
}

/// The node and what is animated of it; `None` if that changes nothing that Lobe shows.
fn target(
    channel: &GltfChannel,
    rig: &Rig,
    place: &str,
    source: &mut Source<'_>,
) -> Result<Option<(usize, Property)>, SceneError> {
    let GltfTarget { node, path } = &channel.target;
    let property = match path.as_str() {
        "translation" => Property::Translation,
        "rotation" => Property::Rotation,
        "scale" => Property::Scale,
        "weights" => Property::Weights,
        other => {
            source.note(format!("{place} animates a {other}, which is not used"));
            return Ok(None);
        }
    };
    let Some(node) = *node else {
        source.note(format!("{place} animates a {path} of no node, which is not used"));
        return Ok(None);
    };
    let count = rig.rest.locals.len();
    match rig.rest.locals.get(node) {
        None => Err(source.invalid(format!("{place}: animates node {node}, but there are {count}"))),
        Some(_) if property == Property::Weights && rig.rest.weights[node].is_empty() => {
            source.note(format!("{place} animates weights of node {node}, which has no morph targets"));
            Ok(None)
        }
        Some(Local::Matrix(_)) if property != Property::Weights => {
            let message = format!("{place}: animates the {path} of node {node}, which has a matrix instead");
            Err(source.invalid(message))
        }
        Some(_) => Ok(Some((node, property))),
    }
}
