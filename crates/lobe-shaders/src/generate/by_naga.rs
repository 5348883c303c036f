//! WGSL in other languages, by naga.

use std::collections::{BTreeMap, BTreeSet};

use naga::back::{glsl as to_glsl, hlsl as to_hlsl, msl as to_msl, spv as to_spirv};
use naga::valid::{Capabilities, ModuleInfo, ValidationFlags, Validator};
use naga::{Handle, Module, ScalarKind, ShaderStage, Type, TypeInner};

use crate::items::{Item, code, items, words};

/// An entry point that calls nothing: some writers want one.
const ENTRY: &str = "\n@fragment\nfn entry_point() -> @location(0) vec4f {\n    return vec4f(0.0);\n}\n";

fn parsed(wgsl: &str) -> (Module, ModuleInfo) {
    let mut module =
        naga::front::wgsl::parse_str(wgsl).unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
    name_arrays(&mut module);
    let info = Validator::new(ValidationFlags::all(), Capabilities::empty()).validate(&module).unwrap();
    (module, info)
}

/// Gives arrays names of their own, under which MSL has them.
fn name_arrays(module: &mut Module) {
    let arrays: Vec<(Handle<Type>, String)> =
        module.types.iter().filter_map(|(handle, ty)| Some((handle, array_name(module, &ty.inner)?))).collect();
    for (handle, name) in arrays {
        let inner = module.types[handle].inner.clone();
        module.types.replace(handle, Type { name: Some(name), inner });
    }
}

fn array_name(module: &Module, inner: &TypeInner) -> Option<String> {
    let TypeInner::Array { base, size: naga::ArraySize::Constant(count), .. } = inner else { return None };
    let of = match &module.types[*base].inner {
        TypeInner::Scalar(scalar) if scalar.kind == ScalarKind::Float => "floats",
        TypeInner::Vector { size: naga::VectorSize::Tri, .. } => "colors",
        TypeInner::Vector { .. } => "vectors",
        _ => return None,
    };
    Some(format!("array_of_{count}_{of}"))
}

/// The declarations of a text that naga wrote, each with the comment that it has in WGSL; without the entry point and
/// what belongs to it.
fn with_comments(text: &str, wgsl: &str, is_left_out: impl Fn(&str, &str) -> bool) -> String {
    let commented = items(wgsl);
    let all = items(text);
    let mut out = Vec::new();
    for item in &all {
        if is_left_out(item.name, code(item.text)) {
            continue;
        }
        let known = commented.iter().find(|known| known.name == item.name);
        let comment = known.map_or("", |known| &known.text[..known.text.len() - code(known.text).len()]);
        out.push(format!("{comment}{}\n", with_own_names(code(item.text), &all, text)));
    }
    out.join("\n")
}

/// A declaration whose variables have the names that they have in WGSL: naga numbers names that other declarations
/// have, too, and adds `_` to those that end in a digit. A name stays where its own is taken here, by another
/// declaration, or by a word of the language.
fn with_own_names(code: &str, all: &[Item<'_>], text: &str) -> String {
    let in_code: BTreeSet<&str> = words(code).collect();
    let is_free = |own: &str| {
        let is_reserved =
            !own.ends_with(|c: char| c.is_ascii_digit()) && words(text).any(|word| word == format!("{own}_"));
        !in_code.contains(own) && !is_reserved && all.iter().all(|item| item.name != own)
    };
    let mut own_names = BTreeMap::new();
    for word in &in_code {
        let own = own_name(word).filter(|own| is_free(own));
        let is_one = |own: &&str| in_code.iter().filter(|other| own_name(other) == Some(own)).count() == 1;
        let is_declared = all.iter().any(|item| item.name == *word);
        if let Some(own) = own.filter(is_one).filter(|_| !is_declared) {
            own_names.insert(*word, own);
        }
    }
    let mut out = String::new();
    let mut rest = code;
    while let Some(word) = words(rest).next() {
        let at = rest.find(word).unwrap();
        out.push_str(&rest[..at]);
        out.push_str(own_names.get(word).unwrap_or(&word));
        rest = &rest[at + word.len()..];
    }
    out + rest
}

/// The name in WGSL of `name_3` and of `name_0_`.
fn own_name(word: &str) -> Option<&str> {
    if let Some(own) = word.strip_suffix('_') {
        return own.ends_with(|c: char| c.is_ascii_digit()).then_some(own);
    }
    let own = word.trim_end_matches(|c: char| c.is_ascii_digit());
    own.strip_suffix('_').filter(|name| own.len() < word.len() && !name.is_empty())
}

/// GLSL for every version from ES 300 and 330 on.
pub(super) fn glsl(wgsl: &str) -> String {
    let source = format!("{wgsl}{ENTRY}");
    let (module, info) = parsed(&source);
    let options = to_glsl::Options {
        version: to_glsl::Version::Embedded { version: 300, is_webgl: true },
        writer_flags: to_glsl::WriterFlags::empty(),
        ..to_glsl::Options::default()
    };
    let pipeline = to_glsl::PipelineOptions {
        shader_stage: ShaderStage::Fragment,
        entry_point: "entry_point".into(),
        multiview: None,
    };
    let mut text = String::new();
    let policies = naga::proc::BoundsCheckPolicies::default();
    to_glsl::Writer::new(&mut text, &module, &info, &options, &pipeline, policies).unwrap().write().unwrap();
    with_comments(&text, wgsl, |name, code| {
        name == "main" || ["precision ", "layout", "out "].iter().any(|start| code.starts_with(start))
    })
}

/// HLSL for shader model 5 and 6.
pub(super) fn hlsl(wgsl: &str) -> String {
    let (module, info) = parsed(wgsl);
    let options = to_hlsl::Options {
        shader_model: to_hlsl::ShaderModel::V5_0,
        force_loop_bounding: false,
        restrict_indexing: false,
        ..to_hlsl::Options::default()
    };
    let mut text = String::new();
    let pipeline = to_hlsl::PipelineOptions::default();
    to_hlsl::Writer::new(&mut text, &options, &pipeline).write(&module, &info, None).unwrap();
    with_comments(&text, wgsl, |_, _| false)
}

/// MSL 2.0.
pub(super) fn msl(wgsl: &str) -> String {
    let (module, info) = parsed(wgsl);
    let options = to_msl::Options { lang_version: (2, 0), force_loop_bounding: false, ..to_msl::Options::default() };
    let pipeline = to_msl::PipelineOptions::default();
    let (text, _) = to_msl::write_string(&module, &info, &options, &pipeline).unwrap();
    with_comments(&text, wgsl, |_, code| code.starts_with("using "))
}

/// A SPIR-V module, version 1.3, with the names of functions.
pub(super) fn spirv(wgsl: &str) -> Vec<u8> {
    let (module, info) = parsed(wgsl);
    let options = to_spirv::Options {
        lang_version: (1, 3),
        flags: to_spirv::WriterFlags::DEBUG,
        force_loop_bounding: false,
        ..to_spirv::Options::default()
    };
    let words = to_spirv::write_vec(&module, &info, &options, None).unwrap();
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}
