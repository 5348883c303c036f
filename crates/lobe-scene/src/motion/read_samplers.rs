//! Samplers of glTF animations.

use std::collections::{HashMap, HashSet};

use gltf_json::{Accessor, Index};
use serde::Deserialize;

use crate::error::SceneError;
use crate::files::gltf::files::GltfFile;
use crate::files::source::Source;
use crate::motion::animation::Property;
use crate::motion::numbers::Numbers;
use crate::motion::sampler::{Interpolation, Sampler, check_count, check_times, check_values, is_constant};

#[derive(Deserialize)]
pub(crate) struct GltfSampler {
    // That of a channel which is not used need not be right.
    input: Option<Index<Accessor>>,
    output: Option<Index<Accessor>>,
    interpolation: Option<String>,
}

/// The samplers of a file. The numbers of an accessor are checked once, so that many samplers of the same long one take no
/// longer than their JSON.
pub(crate) struct Samplers<'a> {
    file: &'a GltfFile,
    numbers: &'a mut Numbers,
    /// Accessors of times in their order, and of finite values.
    ordered: HashSet<usize>,
    finite: HashSet<usize>,
    /// Whether accessors of values are constant, for each way to read them.
    constant: HashMap<(usize, Interpolation, usize), bool>,
}

impl<'a> Samplers<'a> {
    pub(crate) fn new(file: &'a GltfFile, numbers: &'a mut Numbers) -> Self {
        Self { file, numbers, ordered: HashSet::new(), finite: HashSet::new(), constant: HashMap::new() }
    }

    /// A sampler of a property of `width` components, at a place for messages.
    pub(crate) fn of(
        &mut self,
        GltfSampler { input, output, interpolation }: &GltfSampler,
        (property, width): (Property, usize),
        place: &str,
        source: &mut Source<'_>,
    ) -> Result<Sampler, SceneError> {
        let interpolation = match interpolation.as_deref() {
            None | Some("LINEAR") => Interpolation::Linear,
            Some("STEP") => Interpolation::Step,
            Some("CUBICSPLINE") => Interpolation::CubicSpline,
            Some(other) => {
                let message =
                    format!("{place}: expected LINEAR, STEP or CUBICSPLINE as interpolation, found `{other}`");
                return Err(source.invalid(message));
            }
        };
        let (Some(input), Some(output)) = (input, output) else {
            return Err(source.invalid(format!("{place}: expected an input and an output, found only one or none")));
        };
        let (times, to) = (self.numbers.of::<1>(("TIME", place), (self.file, *input), source)?, (self.file, *output));
        let values = match property {
            Property::Rotation => self.numbers.of::<4>(("ROTATION", place), to, source)?,
            Property::Weights => self.numbers.of::<1>(("WEIGHTS", place), to, source)?,
            Property::Translation => self.numbers.of::<3>(("TRANSLATION", place), to, source)?,
            Property::Scale => self.numbers.of::<3>(("SCALE", place), to, source)?,
        };
        let is_constant = self.check((input.value(), &times), (output.value(), &values), interpolation, width);
        match is_constant {
            Ok(is_constant) => Ok(Sampler::of_checked(times, values, interpolation, width, is_constant)),
            Err(message) => Err(source.invalid(format!("{place}: {message}"))),
        }
    }

    /// Checks times and values of accessors, as [`Sampler::new`] does; returns whether the values are constant.
    fn check(
        &mut self,
        (input, times): (usize, &[f32]),
        (output, values): (usize, &[f32]),
        interpolation: Interpolation,
        width: usize,
    ) -> Result<bool, String> {
        if !self.ordered.contains(&input) {
            check_times(times)?;
            self.ordered.insert(input);
        }
        let per_key = check_count(times.len(), values.len(), interpolation, width)?;
        if !self.finite.contains(&output) {
            check_values(values, per_key)?;
            self.finite.insert(output);
        }
        let key = (output, interpolation, width);
        Ok(*self.constant.entry(key).or_insert_with(|| is_constant(values, interpolation, width)))
    }
}
