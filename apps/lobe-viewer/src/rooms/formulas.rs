//! Formulas that the rooms show beside their controls: one table, in the symbols of the guide and with their sources.

use eframe::egui::{CollapsingHeader, Label, RichText, Ui};

/// A formula of the library, as the window shows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct Formula {
    /// Its name.
    pub title: &'static str,
    /// The formula in Unicode, in lines that fit beside a picture.
    pub text: &'static str,
    /// Who published it, as REFERENCES.bib lists it; empty where nobody need be named.
    pub source: &'static str,
    /// The chapter of the guide that has it.
    pub chapter: &'static str,
}

const fn formula(title: &'static str, text: &'static str, source: &'static str, chapter: &'static str) -> Formula {
    Formula { title, text, source, chapter }
}

/// Expansions, and what is done to them.
impl Formula {
    /// Coefficients of a function.
    pub const PROJECTION: Self =
        formula("Projection", "f_lm = ∫ f(s) y_lm(s) ds\nf(s) ≈ Σ_l<n Σ_m f_lm y_lm(s)", "[Green 2003]", "Expansions");
    /// A raised cosine.
    pub const HANNING: Self = formula(
        "Hanning window",
        "f_lm → w_l f_lm\nw_l = (1 + cos(π l/w))/2\nw_l = 0 for l ≥ w",
        "[Sloan 2008]",
        "Windows and ringing",
    );
    /// A power of sigma factors.
    pub const LANCZOS: Self = formula(
        "Lanczos window",
        "f_lm → w_l f_lm\nw_l = (sin(π l/w)/(π l/w))^p\nw_l = 0 for l ≥ w",
        "[Sloan 2008]",
        "Windows and ringing",
    );
    /// The fourth power of sigma factors.
    pub const SINC4: Self = formula(
        "Sinc4 window",
        "f_lm → w_l f_lm\nw_l = (sin(π l/w)/(π l/w))⁴\nw_l = 0 for l ≥ w",
        "[Sloan 2017]",
        "Windows and ringing",
    );
    /// The heat kernel.
    pub const GAUSS: Self =
        formula("Gauss window", "f_lm → w_l f_lm\nw_l = exp(-σ² l(l+1)/2)", "", "Windows and ringing");
    /// Least squares with a penalty on the squared Laplacian.
    pub const LAPLACIAN: Self = formula(
        "Squared Laplacian window",
        "f_lm → w_l f_lm\nw_l = 1/(1 + λ l² (l+1)²)",
        "[Sloan 2008]",
        "Windows and ringing",
    );
    /// The blur of a light from one direction.
    pub const PUNCTUAL: Self = formula(
        "Window of punctual lights",
        "f_lm → w_l f_lm\nw = 1, 0.92, 0.73, 0, ..",
        "[Sloan 2017]",
        "Windows and ringing",
    );
    /// The least change without negative values: this library's own. Sloan 2017 searches a table of windows instead, by a
    /// conservative bound.
    pub const DERING: Self = formula(
        "Dering by radiance",
        "f_lm → w_l f_lm, such that\nΣ_l E_l (1 - w_l)² is least with\nΣ_l w_l f_l(s) ≥ 0 for all s\nE_l = Σ_m f_lm²,   w_0 = 1",
        "",
        "Windows and ringing",
    );
    /// The same of the irradiance, by the factors `A_l` of [`Formula::IRRADIANCE`]: radiance may remain negative.
    pub const DERING_IRRADIANCE: Self = formula(
        "Dering by irradiance",
        "f_lm → w_l f_lm, such that\nΣ_l E_l (1 - w_l)² is least with\nΣ_l A_l w_l f_l(s) ≥ 0 for all s\nE_l = A_l² Σ_m f_lm²,  w_0 = 1\nA = π, 2π/3, π/4, 0, -π/24, ..",
        "",
        "Windows and ringing",
    );
    /// The coefficients of a function that is turned.
    pub const ROTATION: Self = formula(
        "Rotation",
        "g(s) = f(R⁻¹ s)\ng_lm = Σ_m' D^l_mm'(R) f_lm'\nΣ_m g_lm² = Σ_m f_lm²",
        "[Ivanic and Ruedenberg 1996]",
        "Rotation",
    );
    /// Coefficients of a product.
    pub const PRODUCT: Self =
        formula("Triple product", "(f g)_k = Σ_ij Γ_ijk f_i g_j\nΓ_ijk = ∫ y_i y_j y_k ds", "[Sloan 2008]", "Products");
    /// A disc of light.
    pub const CONE: Self = formula(
        "Cone of half angle a",
        "f_l0 = √(π/(2l+1)) ·\n     (P_l-1(cos a) - P_l+1(cos a))",
        "[Sloan 2008]",
        "Lights in and out",
    );
}

/// Light on surfaces.
impl Formula {
    /// Convolution with the clamped cosine.
    pub const IRRADIANCE: Self = formula(
        "Irradiance",
        "E(n) = ∫ L(s) max(n·s, 0) ds\nE_lm = A_l L_lm\nA = π, 2π/3, π/4, 0, -π/24, ..",
        "[Ramamoorthi and Hanrahan 2001]",
        "Irradiance and convolution",
    );
    /// Lights that stand for an expansion.
    pub const LIGHTS: Self = formula(
        "Lights in an expansion",
        "Σ_i (A_l/π)² (f_i - a √(4π) δ_i0\n   - Σ_k c_k N y_i(d_k))² is least\nd_k: maxima of f,  c_k ≥ 0, a ≥ 0",
        "[Sloan 2008]",
        "Lights in and out",
    );
    /// Mirrors that look a map up.
    pub const MIRROR: Self =
        formula("Mirror by a map", "L(v) = L_map(r)\nr = 2 (n·v) n - v", "[Blinn and Newell 1976]", "Environment maps");
    /// Mirrors whose normals are perturbed.
    pub const BUMPS: Self = formula(
        "Bumps of height F",
        "L(v) = L_map(r'),  r' about n'\nn' ∝ N + F_u (n × P_v)\n       - F_v (n × P_u)",
        "[Blinn 1978]",
        "Environment maps",
    );
    /// Rough metal by a filtered map.
    pub const SPLIT_SUM: Self = formula(
        "Split sum",
        "L(v) ≈ g(r) (F₀ scale + bias)\ng(r) = ∫ L(l) D(h) max(r·l, 0) dl\n     / ∫ D(h) max(r·l, 0) dl",
        "[Karis 2013]",
        "Prefiltering, and the sun",
    );
    /// A matte part and highlights, each by its map.
    pub const HIGHLIGHTS: Self = formula(
        "Highlight map",
        "L = k_d E(n)/π + k_s S(r)\nS(r) = ∫ L(l) (s+1)/(2π) ·\n         max(r·l, 0)^s dl",
        "[Miller and Hoffman 1984]",
        "Environment maps",
    );
    /// Six colors.
    pub const AMBIENT_CUBE: Self = formula(
        "Ambient cube",
        "E(n) = Σ_f c_f max(n·a_f, 0)²\na_f = +x, -x, +y, -y, +z, -z",
        "[McTaggart 2004]",
        "Shipping",
    );
    /// Four coefficients, and a fifth along the axis that they have.
    pub const ZH3: Self =
        formula("ZH3", "E(n) = Σ_i<4 E_i y_i(n) +\n  z √(5/16π) (3 (n·d)² - 1)", "[Roughton 2024]", "Shipping");
    /// A basis of the hemisphere.
    pub const H_BASIS: Self = formula("H-basis", "E(n) = Σ_j<N c_j H_j(R⁻¹ n)", "[Habel and Wimmer 2010]", "Shipping");
}

/// Precomputed transfer, and what it is compared with.
impl Formula {
    /// Light by normals alone.
    pub const UNSHADOWED: Self = formula(
        "Unshadowed light",
        "B = (ρ/π) Σ_lm A_l L_lm y_lm(n)",
        "[Ramamoorthi and Hanrahan 2001]",
        "Irradiance and convolution",
    );
    /// The dot product of light and transfer.
    pub const TRANSFER: Self =
        formula("Exit radiance by transfer", "B = Σ_i L_i T_i", "[Sloan, Kautz and Snyder 2002]", "Scenes and baking");
    /// Transfer with shadows.
    pub const SHADOWED: Self = formula(
        "Shadowed transfer",
        "T_i = (ρ/π) ∫ V max(n·s, 0) y_i ds\nV(s) = 1 where the sky is seen",
        "[Sloan, Kautz and Snyder 2002]",
        "Scenes and baking",
    );
    /// Transfer with interreflections.
    pub const INTERREFLECTED: Self = formula(
        "Interreflected transfer",
        "T_i = T_i,shadowed + (ρ/π) ·\n  ∫ (1 - V) max(n·s, 0) T_i' ds\nT': transfer of what s meets",
        "[Sloan, Kautz and Snyder 2002]",
        "Scenes and baking",
    );
    /// Interreflections alone.
    pub const BOUNCES: Self = formula(
        "Light that surfaces send each other",
        "T_i = T_i,interreflected\n    - T_i,shadowed",
        "[Sloan, Kautz and Snyder 2002]",
        "Scenes and baking",
    );
    /// Metals by transfer matrices.
    pub const GLOSSY: Self = formula(
        "Glossy transfer",
        "B(v) = Σ_lm α_l (M L)_lm y_lm(r)\nα_l = √(4π/(2l+1)) G_l\nr = 2 (n·v) n - v",
        "[Sloan, Kautz and Snyder 2002]",
        "Glossy surfaces",
    );
    /// Paths, with as many reflections as they are given.
    pub const TRUTH: Self = formula(
        "Truth by paths",
        "L_o(x, v) = ∫ f(x, v, l) L_i(x, l)\n              max(n·l, 0) dl",
        "",
        "Rendering and comparing",
    );
    /// The distance of two pictures.
    pub const RMS: Self = formula(
        "RMS difference",
        "√(mean (B - B_t)²) / mean B_t\nB_t: the truth, over all pixels",
        "",
        "Rendering and comparing",
    );
}

/// Shadows of what moves.
impl Formula {
    /// Light that is left by all parts.
    pub const MOVING: Self = formula(
        "Light past what moves",
        "B = Σ_i L_i (V T)_i\nV T: a triple product",
        "[Zhou et al. 2005]",
        "Things that move",
    );
    /// Products of visibility.
    pub const FIELDS: Self = formula(
        "Shadow fields",
        "V = V_still · Π_fields (1 - O)\neach factor a triple product",
        "[Zhou et al. 2005]",
        "Things that move",
    );
    /// Sums of logarithms.
    pub const EXPONENTIALS: Self = formula(
        "SH exponentials",
        "V = V_still · exp(Σ log V_sphere)\n(log V_sphere)_lm = F_l(θ) y_lm(d)\nsin θ = radius / distance",
        "[Ren et al. 2006]",
        "Exponentials",
    );
}

/// All of them.
impl Formula {
    /// Every formula of the window.
    pub const ALL: [Self; 32] = [
        Self::PROJECTION,
        Self::HANNING,
        Self::LANCZOS,
        Self::SINC4,
        Self::GAUSS,
        Self::LAPLACIAN,
        Self::PUNCTUAL,
        Self::DERING,
        Self::DERING_IRRADIANCE,
        Self::ROTATION,
        Self::PRODUCT,
        Self::CONE,
        Self::IRRADIANCE,
        Self::LIGHTS,
        Self::MIRROR,
        Self::BUMPS,
        Self::SPLIT_SUM,
        Self::HIGHLIGHTS,
        Self::AMBIENT_CUBE,
        Self::ZH3,
        Self::H_BASIS,
        Self::UNSHADOWED,
        Self::TRANSFER,
        Self::SHADOWED,
        Self::INTERREFLECTED,
        Self::BOUNCES,
        Self::GLOSSY,
        Self::TRUTH,
        Self::RMS,
        Self::MOVING,
        Self::FIELDS,
        Self::EXPONENTIALS,
    ];
}

/// Shows formulas under a heading that opens at a click.
pub(crate) fn formulas(ui: &mut Ui, shown: impl IntoIterator<Item = Formula>) {
    CollapsingHeader::new("Formulas").show(ui, |ui| {
        for Formula { title, text, source, chapter } in shown {
            let comma = if source.is_empty() { "" } else { ", " };
            ui.add(Label::new(RichText::new(title).strong()).wrap());
            ui.add(Label::new(RichText::new(text).monospace()).wrap());
            ui.add(Label::new(RichText::new(format!("{source}{comma}guide: {chapter}")).weak()).wrap());
        }
    });
}
