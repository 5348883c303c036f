//! `lobe export shader`.

use lobe::shaders::{ShaderFunction, ShaderLanguage, shader_text};

use crate::harness::Dir;

#[test]
fn without_a_function_all_are_listed_with_what_they_compute() {
    let list = Dir::new().lobe("export shader").stdout();
    assert_eq!(list.lines().count(), ShaderFunction::ALL.len(), "a line for each function:\n{list}");
    for (line, function) in list.lines().zip(ShaderFunction::ALL) {
        let is_whole = line.starts_with(function.name) && line.ends_with(function.summary);
        assert!(is_whole, "{line} for {function:?}");
    }
}

#[test]
fn a_function_in_one_language_goes_to_stdout_and_is_that_of_the_library() {
    let function = ShaderFunction::find("zh3_eval").unwrap();
    for language in ["wgsl", "glsl", "hlsl", "msl"] {
        let text = Dir::new().lobe(&format!("export shader zh3_eval zh3_eval --lang {language}")).stdout();
        let expected = shader_text(language.parse().unwrap(), &[function]).unwrap();
        assert_eq!(text, expected, "{language}");
    }
}

#[test]
fn several_languages_go_to_a_folder_and_all_functions_have_a_name() {
    let dir = Dir::new();
    dir.lobe("export shader ahd_eval gauss_window --lang wgsl,msl,spirv -o shaders").succeeds();
    for name in ["lobe.wgsl", "lobe.metal", "ahd_eval.spv", "gauss_window.spv"] {
        assert!(dir.path("shaders").join(name).is_file(), "{name}");
    }
    dir.lobe("export shader ahd_eval --lang spirv -o ahd.spv").succeeds();
    let module = ShaderFunction::find("ahd_eval").unwrap().spirv();
    assert!(dir.bytes("ahd.spv") == module && dir.bytes("shaders/ahd_eval.spv") == module, "one module");
    dir.lobe("export shader all --lang glsl -o all.glsl").succeeds();
    let all: Vec<&ShaderFunction> = ShaderFunction::ALL.iter().collect();
    let expected = shader_text(ShaderLanguage::Glsl, &all).unwrap();
    assert!(dir.bytes("all.glsl") == expected.as_bytes(), "all in one file");
}

#[test]
fn what_cannot_be_written_is_refused_in_one_line() {
    let dir = Dir::new();
    let said = |command: &str| dir.lobe(command).error();
    assert!(said("export shader zh4_eval --lang glsl").contains("ambient_cube_eval"), "the names that exist");
    assert!(said("export shader zh3_eval").contains("--lang"), "no language");
    assert!(said("export shader zh3_eval --lang cg").contains("possible values: wgsl, glsl"), "a language");
    assert!(said("export shader zh3_eval --lang spirv").contains("-o"), "SPIR-V is no text");
    dir.lobe("export shader zh3_eval --lang glsl -o file").succeeds();
    assert!(said("export shader zh3_eval --lang glsl,hlsl -o file").contains("name a folder"), "two into a file");
    // A map of that name, and the options of maps, are those of the other command.
    assert!(said("export ./shader --engine three -o out").starts_with("./shader: no such file"), "a map");
    assert!(said("export --engine three -o out").contains("<IN>"), "no map");
}
