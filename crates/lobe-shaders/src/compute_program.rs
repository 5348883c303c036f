//! A compute program around a function: rows of numbers in, rows of numbers out.

use std::fmt::Write as _;

use crate::shader_function::ShaderFunction;
use crate::shader_language::ShaderLanguage;
use crate::shader_text::shader_text;
use crate::shader_types::{array_of, numbers_of};

impl ShaderFunction {
    /// A compute program in WGSL that calls the function for every row of a buffer.
    ///
    /// ```text
    ///   binding 0, read     rows of argument_numbers() f32: the numbers of all arguments, one after the other
    ///   binding 1, write    rows of result_numbers() f32
    ///   entry point main    a workgroup of 64 rows along x
    /// ```
    ///
    /// Both bindings are of group 0, and rows are packed: a vector of three has three numbers, a matrix has its
    /// columns. As many rows as the results have are computed.
    #[must_use]
    pub fn compute_program(&self) -> String {
        let library = shader_text(ShaderLanguage::Wgsl, &[self]).unwrap_or_default();
        compute_program(&library, self.name, self.arguments, self.result)
    }
}

/// The program, after the text of the function and what it needs.
pub(crate) fn compute_program(library: &str, name: &str, arguments: &[(&str, &str)], result: &str) -> String {
    let row: usize = arguments.iter().map(|(_, ty)| numbers_of(ty)).sum();
    let results = numbers_of(result);
    let mut text = format!(
        "{library}
@group(0) @binding(0) var<storage, read> argument_numbers: array<f32>;
@group(0) @binding(1) var<storage, read_write> result_numbers: array<f32>;

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3u) {{
    if (id.x + 1u) * {results}u > arrayLength(&result_numbers) {{
        return;
    }}
    let row = id.x * {row}u;
"
    );
    let mut first = 0;
    for (argument, ty) in arguments {
        read(&mut text, argument, ty, first);
        first += numbers_of(ty);
    }
    let values: Vec<String> = arguments.iter().map(|(argument, _)| format!("value_{argument}")).collect();
    let _ = writeln!(text, "    let found = {name}({});\n    let out = id.x * {results}u;", values.join(", "));
    write(&mut text, result);
    text + "}\n"
}

/// Reads an argument from number `first` of its row on, as `value_NAME`.
fn read(text: &mut String, name: &str, ty: &str, first: usize) {
    let made = |ty: &str, at: &str| {
        let numbers: Vec<String> = (0..numbers_of(ty)).map(|k| format!("argument_numbers[{at} + {k}u]")).collect();
        if numbers.len() == 1 { numbers.concat() } else { format!("{ty}({})", numbers.join(", ")) }
    };
    let _ = match array_of(ty) {
        Some((element, count)) => {
            let value = made(element, &format!("row + {first}u + {}u * k", numbers_of(element)));
            writeln!(
                text,
                "    var value_{name}: {ty};\n    for (var k = 0u; k < {count}u; k++) {{\n        value_{name}[k] = {value};\n    }}"
            )
        }
        None => writeln!(text, "    let value_{name} = {};", made(ty, &format!("row + {first}u"))),
    };
}

/// Writes what was found.
fn write(text: &mut String, ty: &str) {
    let (element, count) = array_of(ty).unwrap_or((ty, 1));
    let numbers = numbers_of(element);
    let is_array = element != ty;
    let indent = if is_array { "        " } else { "    " };
    if is_array {
        let _ = writeln!(text, "    for (var k = 0u; k < {count}u; k++) {{");
    }
    for c in 0..numbers {
        let part = if numbers == 1 { String::new() } else { format!("[{c}]") };
        let (value, at) = match is_array {
            true => (format!("found[k]{part}"), format!("out + {numbers}u * k + {c}u")),
            false => (format!("found{part}"), format!("out + {c}u")),
        };
        let _ = writeln!(text, "{indent}result_numbers[{at}] = {value};");
    }
    if is_array {
        text.push_str("    }\n");
    }
}
