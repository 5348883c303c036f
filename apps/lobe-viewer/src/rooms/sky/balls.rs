//! Balls beside each other: by each technique, and by each encoding of irradiance.

use std::f64::consts::FRAC_1_PI;

use eframe::egui::{Align, Color32, Label, Layout, Response, Rgba, RichText, TextStyle, Ui, Vec2};
use lobe::env::DfgTable;
use lobe::figures::{Ball, Exhibit, Shading, SurfacePoint};
use lobe::image::Tone;
use lobe::render::{Camera, View};
use lobe::sh::encoding::{IrradianceEncoding, encoding_error};
use lobe::sh::sphere::even_directions;
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb, ShVec, Zonal};

use crate::rooms::sky::findings::Findings;
use crate::rooms::sky::surfaces::{Surface, Turned, mean_error, values};
use crate::rooms::sky::techniques::{ALPHA, EXPONENT, K_D, K_S, METAL, Technique};
use crate::widgets::orbit::Orbit;
use crate::widgets::picture::PictureView;
use crate::widgets::tone::shown_as;

/// Sides of a ball, in points.
const SIDE: f32 = 132.0;

/// Pixels along the side of a ball, of one whose points are sums over many lights, and of one that moves.
const PIXELS: usize = 128;
const SLOW_PIXELS: usize = 72;
const COARSE_PIXELS: usize = 48;

/// Half the angle of view of a ball, and the distance of the eye in radii.
const HALF_ANGLE: f64 = 0.3;
const DISTANCE: f64 = 4.0;

/// Directions at which the errors of encodings are measured.
const DIRECTIONS: usize = 256;

/// Sides of the table of directional albedos.
const TABLE: usize = 32;

/// All balls of the room.
#[derive(Default)]
pub(crate) struct Balls {
    techniques: Vec<PictureView>,
    expansions: [PictureView; Surface::ALL.len()],
    encodings: Vec<PictureView>,
    reference: PictureView,
    errors: Option<Errors>,
    table: Option<DfgTable>,
}

/// The errors of all encodings under a light.
struct Errors {
    version: u64,
    found: Vec<f64>,
}

/// What all balls share.
pub(crate) struct BallView<'a> {
    pub(crate) found: &'a Findings,
    pub(crate) orbit: &'a Orbit,
    pub(crate) tone: Tone,
    /// The numbers on which all of them depend.
    pub(crate) key: &'a [u64],
}

impl Balls {
    /// A glossy ball by the expansion of the room.
    pub(crate) fn glossy(&mut self, found: &Findings) -> ByExpansion<'_> {
        let table = self.table.get_or_insert_with(|| DfgTable::new(TABLE));
        ByExpansion::new(Surface::Glossy, (&found.light, &found.irradiance), table)
    }

    /// Mirrors, glossy and matte balls by each technique that is ready, and by the expansion of the room.
    pub(crate) fn techniques(&mut self, ui: &mut Ui, view: &BallView<'_>, ready: &[Technique]) -> Vec<Response> {
        let mut responses = Vec::new();
        // Errors are those under the sky at rest, where the truth need not be summed again.
        let [light, irradiance] = [&view.found.light, &view.found.irradiance].map(|f| f.rotated(&view.found.back()));
        self.techniques.resize_with(ready.len().max(self.techniques.len()), PictureView::default);
        for (number, surface) in Surface::ALL.into_iter().enumerate() {
            ui.strong(surface.title());
            ui.horizontal_wrapped(|ui| {
                let all = ready.iter().zip(&mut self.techniques);
                for (technique, picture) in all.filter(|(technique, _)| technique.surface == surface) {
                    let (shading, relief) = (&*technique.shading, technique.relief);
                    let shading = Turned { shading, relief, back: view.found.back() };
                    let known = technique.error.map_or_else(String::new, percent);
                    let name = format!("{}, {}", surface.title(), technique.name);
                    let pixels = if technique.is_slow { SLOW_PIXELS } else { PIXELS };
                    let title = (technique.name, &known[..], &name[..]);
                    responses.push(before_the_sky(ui, picture, title, (view, pixels), (surface, &shading)));
                }
                let table = self.table.get_or_insert_with(|| DfgTable::new(TABLE));
                let expansion = ByExpansion::new(surface, (&view.found.light, &view.found.irradiance), table);
                let title = format!("expansion, order {}", view.found.light.order());
                let truth = ready.iter().find(|technique| technique.surface == surface);
                let error = truth.map(|truth| {
                    let expansion = ByExpansion::new(surface, (&light, &irradiance), table);
                    expansion_error(&expansion, truth)
                });
                let known = error.map_or_else(String::new, percent);
                let name = format!("{}, by the expansion", surface.title());
                let picture = &mut self.expansions[number];
                let title = (&title[..], &known[..], &name[..]);
                let shading = Turned::at_rest(&expansion, surface.relief());
                responses.push(before_the_sky(ui, picture, title, (view, PIXELS), (surface, &shading)));
            });
        }
        ui.weak(
            "Errors are sums of differences over the sum of the first of a row, over the shape as it is seen along +x.",
        );
        responses
    }

    /// Matte balls by each encoding of the irradiance, with its numbers and its error.
    pub(crate) fn encodings(&mut self, ui: &mut Ui, view: &BallView<'_>, light: &ShVec<Rgb<f64>>) -> Vec<Response> {
        let version = view.found.version;
        let irradiance = light.convolved(&Zonal::clamped_cosine(light.order()));
        if self.errors.as_ref().is_none_or(|errors| errors.version != version) {
            let truth: Vec<_> = even_directions(DIRECTIONS).map(|n| (n, irradiance.eval(n))).collect();
            let error = |encoding| encoding_error(encoding, &irradiance, &truth).rms;
            self.errors = Some(Errors { version, found: IrradianceEncoding::ALL.map(error).to_vec() });
        }
        self.encodings.resize_with(IrradianceEncoding::ALL.len(), PictureView::default);
        let mut responses = Vec::new();
        // Encodings of a hemisphere are those of the side that the eye sees.
        let frame = lobe::sh::rotation::tangent_frame(view.orbit.towards_eye());
        ui.horizontal_wrapped(|ui| {
            let (title, known) = (format!("order {}", light.order()), numbers(3 * light.coefficients().len()));
            let shown = (&title[..], &known[..], "The irradiance that is encoded");
            responses.push(matte(ui, &mut self.reference, shown, view, &|n| irradiance.eval(n)));
            let errors = self.errors.iter().flat_map(|errors| &errors.found);
            for ((encoding, error), picture) in IrradianceEncoding::ALL.into_iter().zip(errors).zip(&mut self.encodings)
            {
                let encoded = encoding.encode(&irradiance, frame);
                let known = format!("{}, {}", numbers(encoding.floats(3)), percent(*error));
                let name = format!("{}: {known}", encoding.name());
                responses.push(matte(ui, picture, (encoding.name(), &known, &name), view, &|n| encoded.eval(n)));
            }
        });
        ui.weak("RMS errors over all normals in units of the mean irradiance; of the encodings of a hemisphere over 32 surfaces, shown is the side towards the eye.");
        responses
    }
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

fn numbers(count: usize) -> String {
    format!("{count} numbers")
}

/// A ball under its name, of up to two lines, and what is known of it.
fn titled(ui: &mut Ui, name: &str, known: &str, show: impl FnOnce(&mut Ui) -> Response) -> Response {
    let content = |ui: &mut Ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        let response = show(ui);
        ui.add(Label::new(RichText::new(name).strong()).wrap());
        ui.add(Label::new(RichText::new(known).weak()).wrap());
        response
    };
    let lines = ui.text_style_height(&TextStyle::Body) + 2.0;
    let size = Vec2::new(SIDE, SIDE + 3.0 * lines + 6.0);
    ui.allocate_ui_with_layout(size, Layout::top_down(Align::Min), content).inner
}

type Light = ShVec<Rgb<f64>>;

/// A ball by the expansion of the room.
pub(crate) struct ByExpansion<'a> {
    surface: Surface,
    /// What is looked up: by the reflected direction, or by the normal of a matte ball.
    light: ShVec<Rgb<f64>>,
    /// The matte part below highlights, by the normal.
    below: Option<ShVec<Rgb<f64>>>,
    table: &'a DfgTable,
}

impl<'a> ByExpansion<'a> {
    /// By an expansion and its irradiance.
    fn new(surface: Surface, (light, irradiance): (&Light, &Light), table: &'a DfgTable) -> Self {
        let order = light.order();
        let matte = |albedo: f64| irradiance.map(|c| c.scale(albedo * FRAC_1_PI));
        let light = match surface {
            Surface::Mirror | Surface::Bumpy | Surface::Ring => light.clone(),
            Surface::Glossy => light.convolved(&Zonal::ggx(order, ALPHA)),
            Surface::Highlights => light.convolved(&Zonal::phong(order, EXPONENT)).map(|c| c.scale(K_S)),
            Surface::Matte => matte(1.0),
        };
        let below = (surface == Surface::Highlights).then(|| matte(K_D));
        Self { surface, light, below, table }
    }
}

impl Shading for ByExpansion<'_> {
    fn radiance(&self, at: &SurfacePoint) -> Rgb<f32> {
        Rgb::narrow(match self.surface {
            Surface::Mirror | Surface::Bumpy | Surface::Ring => self.light.eval(at.reflected()),
            Surface::Highlights => {
                let below = self.below.as_ref().map_or(Rgb::ZERO, |below| below.eval(at.normal));
                below + self.light.eval(at.reflected())
            }
            Surface::Glossy => {
                let reflectance = self.table.lookup(at.cos_view(), ALPHA.sqrt()).reflectance(Rgb::splat(METAL));
                self.light.eval(at.reflected()) * reflectance
            }
            Surface::Matte => self.light.eval(at.normal),
        })
    }
}

/// How far the expansion is from the truth, as the other techniques are measured.
fn expansion_error(expansion: &ByExpansion<'_>, truth: &Technique) -> f64 {
    let surface = truth.surface;
    mean_error(&values(surface, &Turned::at_rest(expansion, surface.relief())), &truth.values)
}

/// A ball before the sky, which the camera of the room circles.
fn before_the_sky(
    ui: &mut Ui,
    picture: &mut PictureView,
    (title, known, name): (&str, &str, &str),
    (view, pixels): (&BallView<'_>, usize),
    (surface, shading): (Surface, &dyn Shading),
) -> Response {
    let is_moving = ui.input(|input| input.pointer.is_decidedly_dragging());
    let pixels = if is_moving { COARSE_PIXELS.min(pixels) } else { pixels };
    let mut key = view.key.to_vec();
    key.extend([pixels as u64, view.found.version]);
    key.extend([view.orbit.azimuth, view.orbit.height].map(f64::to_bits));
    let size = Vec2::splat(SIDE);
    let shown = titled(ui, title, known, |ui| {
        picture.show(ui, name, size, key, || {
            let camera = Camera::perspective(View::from_eye(view.orbit.towards_eye()), DISTANCE, HALF_ANGLE);
            let exhibit = Exhibit { solid: surface.solid(), camera, samples: 1 };
            let background = |s: Dir| Rgb::narrow(view.found.radiance(s));
            (exhibit.picture(pixels, pixels, background, shading), view.tone)
        })
    });
    shown.on_hover_text(name)
}

/// A matte ball before the panel.
fn matte(
    ui: &mut Ui,
    picture: &mut PictureView,
    (title, known, name): (&str, &str, &str),
    view: &BallView<'_>,
    irradiance: &(dyn Fn(Dir) -> Rgb<f64> + Sync),
) -> Response {
    let background = background(ui.visuals().panel_fill, &view.tone);
    let is_moving = ui.input(|input| input.pointer.is_decidedly_dragging());
    let pixels = if is_moving { COARSE_PIXELS } else { PIXELS };
    let mut key = view.key.to_vec();
    key.extend([pixels as u64, view.found.version]);
    key.extend([view.orbit.azimuth, view.orbit.height].map(f64::to_bits));
    key.extend(<[f32; 3]>::from(background).map(|c| u64::from(c.to_bits())));
    let size = Vec2::splat(SIDE);
    let shown = titled(ui, title, known, |ui| {
        picture.show(ui, name, size, key, || {
            let ball = Ball::new(pixels).seen(View::from_eye(view.orbit.towards_eye()));
            (ball.lit(background, irradiance), view.tone)
        })
    });
    shown.on_hover_text(name)
}

/// The light behind the balls that the tone mapping shows as the color of the panel.
fn background(panel: Color32, tone: &Tone) -> Rgb<f32> {
    let shown = Rgba::from(panel);
    let light = shown_as(tone, Rgb::new(shown.r(), shown.g(), shown.b()).widen());
    Rgb::from(<[f64; 3]>::from(light).map(|c| c as f32))
}

#[cfg(test)]
mod tests {
    use lobe::image::Curve;

    use super::*;
    use crate::widgets::tone::Look;

    #[test]
    fn beside_a_ball_there_is_the_color_of_the_panel_and_no_other() {
        for (panel, factor) in [(27, 0.05), (27, 40.0), (248, 1.0)] {
            let panel = Color32::from_gray(panel);
            let tone = Look { stops: 1.5, curve: Curve::REINHARD }.of(factor);
            let ball = Ball::new(16).picture(background(panel, &tone), |_| Rgb::new(1.0, 1.0, 1.0));
            let corner = &tone.to_bytes(&ball)[..3];
            assert_eq!(corner, [panel.r(), panel.g(), panel.b()], "at exposure {factor}");
        }
    }
}
