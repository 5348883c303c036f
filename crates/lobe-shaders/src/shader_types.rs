//! Types of arguments and results, as WGSL writes them.

/// Numbers of a type: `f32`, `vec3f`, `mat4x4f` or an array of these.
pub(crate) fn numbers_of(ty: &str) -> usize {
    match array_of(ty) {
        Some((element, count)) => count * numbers_of(element),
        None => match ty {
            "vec2f" => 2,
            "vec3f" => 3,
            "vec4f" => 4,
            "mat4x4f" => 16,
            _ => 1,
        },
    }
}

/// The type and the number of the elements of an array.
pub(crate) fn array_of(ty: &str) -> Option<(&str, usize)> {
    let (element, count) = ty.strip_prefix("array<")?.strip_suffix('>')?.split_once(", ")?;
    Some((element, count.parse().ok()?))
}
