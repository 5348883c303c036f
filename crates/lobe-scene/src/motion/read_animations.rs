//! Animations of glTF files.

use std::collections::HashSet;

use serde::Deserialize;

use crate::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::source::Source;
use crate::motion::animation::{Animation, Channel, Property};
use crate::motion::numbers::{Numbers, members};
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

/// All animations of a file. What Lobe has nothing for, such as animated materials, is noted.
pub(crate) fn read(
    file: &GltfFile,
    rig: &Rig,
    numbers: &mut Numbers,
    source: &mut Source<'_>,
) -> Result<Vec<Animation>, SceneError> {
    let (mut animations, mut samplers) = (Vec::new(), Samplers::new(file, numbers));
    for (index, json) in members::<GltfAnimation>(file, "animations", source)?.into_iter().enumerate() {
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
        animations.push(Animation { name: json.name, channels });
    }
    Ok(animations)
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
