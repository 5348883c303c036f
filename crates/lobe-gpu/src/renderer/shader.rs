//! Shaders, put together from the WGSL modules of this crate.

use std::fmt::Write as _;

/// A WGSL module of this crate: its name, that of the module on the processor it is the counterpart of, and its text.
macro_rules! modules {
    ($($name:literal => $file:literal),+ $(,)?) => {
        &[$(($name, include_str!(concat!("../wgsl/", $file)))),+]
    };
}

const MODULES: &[(&str, &str)] = modules! {
    "accumulate" => "accumulate.wgsl",
    "backdrop" => "backdrop.wgsl",
    "basis" => "generated/basis.wgsl",
    "camera" => "camera.wgsl",
    "clustered" => "clustered.wgsl",
    "clustered_sum" => "clustered_sum.wgsl",
    "copy" => "copy.wgsl",
    "dfg" => "dfg.wgsl",
    "dispatch" => "dispatch.wgsl",
    "display" => "display.wgsl",
    "draw_gltf_transfer" => "draw_gltf_transfer.wgsl",
    "draw_masked_sun_shadow" => "draw_masked_sun_shadow.wgsl",
    "draw_sun_shadow" => "draw_sun_shadow.wgsl",
    "draw_sunlit_transfer" => "draw_sunlit_transfer.wgsl",
    "draw_sunlit_vertices" => "draw_sunlit_vertices.wgsl",
    "draw_surface" => "draw_surface.wgsl",
    "draw_transfer" => "draw_transfer.wgsl",
    "draw_vertices" => "draw_vertices.wgsl",
    "elementary" => "elementary.wgsl",
    "environment" => "environment.wgsl",
    "expansion" => "generated/expansion.wgsl",
    "field_stencil" => "field_stencil.wgsl",
    "facing" => "facing.wgsl",
    "finish" => "finish.wgsl",
    "glossy" => "glossy.wgsl",
    "lobe_table" => "lobe_table.wgsl",
    "gltf" => "gltf.wgsl",
    "gltf_suns" => "gltf_suns.wgsl",
    "hemisphere" => "hemisphere.wgsl",
    "irradiance_encoding" => "irradiance_encoding.wgsl",
    "look_up_fields" => "look_up_fields.wgsl",
    "octahedral" => "octahedral.wgsl",
    "openness" => "openness.wgsl",
    "packed_irradiance" => "packed_irradiance.wgsl",
    "product" => "generated/product.wgsl",
    "resolve" => "resolve.wgsl",
    "rotation" => "rotation.wgsl",
    "shade_gltf" => "shade_gltf.wgsl",
    "shade_glossy" => "shade_glossy.wgsl",
    "shade_irradiance" => "shade_irradiance.wgsl",
    "shade_lightmap" => "shade_lightmap.wgsl",
    "shade_specular" => "shade_specular.wgsl",
    "shade_demodulated" => "shade_demodulated.wgsl",
    "shade_vertices" => "shade_vertices.wgsl",
    "shadow_fields" => "shadow_fields.wgsl",
    "shadow_receiver" => "shadow_receiver.wgsl",
    "sky_light" => "sky_light.wgsl",
    "specular" => "specular.wgsl",
    "still_visibility" => "still_visibility.wgsl",
    "stored_numbers" => "stored_numbers.wgsl",
    "sun_light" => "sun_light.wgsl",
    "sun_shadow" => "sun_shadow.wgsl",
    "sunlit_gltf" => "sunlit_gltf.wgsl",
    "sunlit_matte" => "sunlit_matte.wgsl",
    "sunlit_surface" => "sunlit_surface.wgsl",
    "sunlit_vertices" => "sunlit_vertices.wgsl",
    "surface" => "surface.wgsl",
    "tone" => "tone.wgsl",
    "transfer" => "transfer.wgsl",
    "transfer_texture" => "transfer_texture.wgsl",
    "window" => "window.wgsl",
};

/// The source of a shader.
///
/// Modules whose arrays have the length of an order need [`Shader::order`]; `accumulate` and `sky_light` also what
/// `straight_line` writes for each order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shader {
    constants: String,
    modules: Vec<&'static str>,
    text: String,
}

impl Shader {
    /// A shader of these modules, each after those it uses.
    pub(crate) fn new(modules: &[&str]) -> Self {
        let mut shader = Self::default();
        for name in modules {
            shader.add(name);
        }
        shader
    }

    fn add(&mut self, name: &str) {
        let Some(&(name, text)) = MODULES.iter().find(|(known, _)| *known == name) else {
            unreachable!("{name} is no module of this crate");
        };
        if self.modules.contains(&name) {
            return;
        }
        for used in uses(text) {
            self.add(used);
        }
        self.modules.push(name);
        self.text.push_str(text);
    }

    /// With one more module.
    pub(crate) fn module(mut self, name: &str) -> Self {
        self.add(name);
        self
    }

    /// With a constant that its modules expect.
    pub(crate) fn constant(mut self, name: &str, value: usize) -> Self {
        let _ = writeln!(self.constants, "const {name} = {value}u;");
        self
    }

    /// With a constant of single precision.
    pub(crate) fn number(mut self, name: &str, value: f64) -> Self {
        let _ = writeln!(self.constants, "const {name} = {:?};", value as f32);
        self
    }

    /// With the basis of one order as `basis`.
    pub(crate) fn order(self, order: usize) -> Self {
        let mut shader = self.constant("ORDER", order).constant("COEFFICIENTS", order * order);
        shader.add("basis");
        let count = order * order;
        let _ = writeln!(
            shader.text,
            "\nfn basis(s: vec3f) -> array<f32, {count}> {{\n    return order_{order}_basis(s);\n}}"
        );
        shader
    }

    /// With the product of two expansions of one order, cut off at that order, as `product`.
    pub(crate) fn product(mut self, order: usize) -> Self {
        self.add("product");
        let array = format!("array<f32, {}>", order * order);
        let _ = writeln!(
            self.text,
            "\nfn product(a: {array}, b: {array}) -> {array} {{\n    return order_{order}_product(a, b);\n}}"
        );
        self
    }

    /// With text after the modules.
    pub(crate) fn with(mut self, text: &str) -> Self {
        self.text.push_str(text);
        self
    }

    pub(crate) fn source(&self) -> String {
        format!("{}\n{}", self.constants, self.text)
    }
}

/// The modules that the first line of a module names.
fn uses(text: &str) -> impl Iterator<Item = &str> {
    let first = text.lines().next().unwrap_or_default();
    first.strip_prefix("// uses: ").into_iter().flat_map(|list| list.split(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_module_names_what_it_needs_and_is_named_once() {
        for (number, (name, text)) in MODULES.iter().enumerate() {
            assert!(text.starts_with("//"), "{name} begins with {:?}", text.lines().next());
            let other = MODULES[..number].iter().any(|(before, _)| before == name);
            assert!(!other, "{name} is there twice");
            for used in uses(text) {
                assert!(MODULES.iter().any(|(known, _)| *known == used), "{name} uses {used}");
            }
        }
    }
}
