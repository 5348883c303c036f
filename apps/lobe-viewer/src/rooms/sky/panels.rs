//! The pictures of the room.

use eframe::egui::{
    Align, Align2, Color32, FontId, Label, Layout, Painter, Pos2, Rect, Response, Rgba, RichText, Stroke, Ui, Vec2,
    vec2,
};
use lobe::env::Mapping;
use lobe::image::{Curve, Picture, Tone};
use lobe::render::{Ball, View};
use lobe::sh::{Coefficient as _, Dir, Expansion as _, Rgb};

use crate::rooms::sky::edits::SkyEdits;
use crate::rooms::sky::findings::Findings;
use crate::widgets::picture::PictureView;
use crate::widgets::tone::{fitting, photograph, shown_as};

/// Width of an unfolded mapping, in texels.
const UNFOLDED: usize = 256;

/// Pixels of a ball.
const BALL: usize = 176;

/// Size of a lat-long picture, in points.
const WIDE: Vec2 = vec2(360.0, 180.0);

/// Height of a title, in points.
const TITLE: f32 = 22.0;

/// All pictures of the room.
#[derive(Default)]
pub(crate) struct Panels {
    sky: PictureView,
    reconstruction: PictureView,
    difference: PictureView,
    unfolded: PictureView,
    mirror: PictureView,
    glossy: PictureView,
    matte: PictureView,
}

impl Panels {
    /// Shows them. `version` tells changes of the findings.
    pub(crate) fn show(&mut self, ui: &mut Ui, found: &Findings, edits: &SkyEdits) {
        let key = vec![found.version, edits.exposure.to_bits()];
        let tone = photograph(fitting(&found.picture), edits.exposure);
        ui.horizontal_wrapped(|ui| {
            panel(ui, "The sky", WIDE, |ui| {
                self.sky.show(ui, "The sky, lat-long", WIDE, key.clone(), || (found.picture.clone(), tone))
            });
            let title = format!("Its expansion, order {}", edits.order);
            let shown = panel(ui, &title, WIDE, |ui| {
                let make = || (found.reconstruction.clone(), tone);
                self.reconstruction.show(ui, "The expansion, lat-long", WIDE, key.clone(), make)
            });
            mark(ui, &shown, found);
            panel(ui, "What is cut off: red missing, blue too much", WIDE, |ui| {
                self.difference.show(ui, "The difference, lat-long", WIDE, key.clone(), || {
                    (difference(found), Tone { curve: Curve::Clip, ..tone })
                })
            });
            let mapping = Mapping::from_name(&edits.mapping).unwrap_or(Mapping::Octahedral);
            let mut unfolded_key = key.clone();
            unfolded_key.push(Mapping::ALL.iter().position(|known| *known == mapping).unwrap_or(0) as u64);
            let height = mapping.height_for(UNFOLDED);
            let size = vec2(180.0 * UNFOLDED as f32 / height.max(1) as f32, 180.0);
            panel(ui, &format!("Unfolded: {}", mapping.name()), size, |ui| {
                let make = || (unfolded(found, mapping, height), tone);
                self.unfolded.show(ui, "The sky, unfolded", size, unfolded_key, make)
            });
            self.balls(ui, found, (&key, tone));
        });
    }

    fn balls(&mut self, ui: &mut Ui, found: &Findings, (key, tone): (&[u64], Tone)) {
        let background = background(ui.visuals().panel_fill, &tone);
        let mut key = key.to_vec();
        key.extend(<[f32; 3]>::from(background).map(|c| u64::from(c.to_bits())));
        let view = View::ALONG_X;
        let ball = Ball::new(BALL).seen(view);
        let towards_eye = -Dir::X;
        let size = Vec2::splat(180.0);
        let reflected = |n: Dir| {
            let c = 2.0 * n.dot(towards_eye);
            let (n, e) = (n.to_array(), towards_eye.to_array());
            Dir::new(std::array::from_fn(|k| c * n[k] - e[k])).unwrap_or(towards_eye)
        };
        let response = panel(ui, "A mirror, with the lights", size, |ui| {
            self.mirror.show(ui, "Mirror ball", size, key.clone(), || {
                (ball.picture(background, |n| found.radiance(reflected(n))), tone)
            })
        });
        arrows(&ui.painter_at(response.rect), response.rect, found, view);
        panel(ui, "A mirror of the expansion", size, |ui| {
            self.glossy.show(ui, "Mirror ball of the expansion", size, key.clone(), || {
                (ball.picture(background, |n| found.light.eval(reflected(n))), tone)
            })
        });
        panel(ui, "Matte, by the expansion", size, |ui| {
            let make = || (ball.lit_by_sh(background, &found.irradiance), tone);
            self.matte.show(ui, "Matte ball", size, key, make)
        });
    }
}

/// The light behind the balls that the tone mapping shows as the color of the panel.
fn background(panel: Color32, tone: &Tone) -> Rgb<f32> {
    let shown = Rgba::from(panel);
    let light = shown_as(tone, Rgb::new(shown.r(), shown.g(), shown.b()).widen());
    Rgb::from(<[f64; 3]>::from(light).map(|c| c as f32))
}

/// A picture of this size under its title.
fn panel(ui: &mut Ui, title: &str, size: Vec2, show: impl FnOnce(&mut Ui) -> Response) -> Response {
    let with_title = size + vec2(0.0, TITLE);
    let content = |ui: &mut Ui| {
        ui.add(Label::new(RichText::new(title).strong()).truncate());
        show(ui)
    };
    ui.allocate_ui_with_layout(with_title, Layout::top_down(Align::Min), content).inner
}

/// The sky in another mapping; black where that shows nothing.
fn unfolded(found: &Findings, mapping: Mapping, height: usize) -> Picture {
    Picture::from_fn(UNFOLDED, height, |x, y| {
        let (u, v) = ((x as f64 + 0.5) / UNFOLDED as f64, (y as f64 + 0.5) / height as f64);
        mapping.dir_from_uv(u, v).map_or([0.0; 3], |s| <[f64; 3]>::from(found.radiance(s)).map(|c| c as f32))
    })
}

/// Red where the expansion has too little luminance, blue where it has too much.
fn difference(found: &Findings) -> Picture {
    let (picture, made) = (&found.picture, &found.reconstruction);
    Picture::from_fn(picture.width(), picture.height(), |x, y| {
        let lacking = Rgb::from(picture.pixel(x, y)).luminance() - Rgb::from(made.pixel(x, y)).luminance();
        if lacking > 0.0 {
            [lacking, 0.15 * lacking, 0.1 * lacking]
        } else {
            [-0.1 * lacking, -0.3 * lacking, -lacking]
        }
    })
}

/// Marks the minimum with a cross and the lights with rings.
fn mark(ui: &Ui, shown: &Response, found: &Findings) {
    let painter = ui.painter_at(shown.rect);
    let at = |s: Dir| {
        let (u, v) = Mapping::LatLong.uv_from_dir(s);
        shown.rect.min + vec2(shown.rect.width() * u as f32, shown.rect.height() * v as f32)
    };
    let place = at(found.minimum.dir);
    for (width, color) in [(4.0, Color32::BLACK), (2.0, Color32::from_rgb(90, 170, 255))] {
        for arm in [vec2(6.0, 6.0), vec2(6.0, -6.0)] {
            painter.line_segment([place - arm, place + arm], Stroke::new(width, color));
        }
    }
    let lights = found.lights.iter().flat_map(|fit| &fit.lights);
    for (number, light) in lights.enumerate() {
        painter.circle_stroke(at(light.dir), 8.0, Stroke::new(3.0, Color32::BLACK));
        painter.circle_stroke(at(light.dir), 8.0, Stroke::new(1.5, Color32::YELLOW));
        let text = (number + 1).to_string();
        for (by, color) in [(1.0, Color32::BLACK), (0.0, Color32::YELLOW)] {
            let place = at(light.dir) + vec2(10.0 + by, by - 6.0);
            painter.text(place, Align2::LEFT_BOTTOM, &text, FontId::monospace(14.0), color);
        }
    }
}

/// The lights as arrows that point at the ball, those from behind it thinner.
fn arrows(painter: &Painter, rect: Rect, found: &Findings, view: View) {
    let radius = 0.5 * rect.height();
    for light in found.lights.iter().flat_map(|fit| &fit.lights) {
        let [right, up, towards_eye] = view.project(light.dir.to_array());
        let from = vec2(right as f32, -up as f32) * radius;
        let start: Pos2 = rect.center() + from * 0.98;
        let width = if towards_eye > 0.0 { 3.0 } else { 1.2 };
        painter.arrow(start, -from * 0.55, Stroke::new(width + 2.0, Color32::BLACK));
        painter.arrow(start, -from * 0.55, Stroke::new(width, Color32::YELLOW));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beside_a_ball_there_is_the_color_of_the_panel_and_no_other() {
        for (panel, factor) in [(27, 0.05), (27, 40.0), (248, 1.0)] {
            let panel = Color32::from_gray(panel);
            let tone = photograph(factor, 1.5);
            let ball = Ball::new(16).picture(background(panel, &tone), |_| Rgb::new(1.0, 1.0, 1.0));
            let corner = &tone.to_bytes(&ball)[..3];
            assert_eq!(corner, [panel.r(), panel.g(), panel.b()], "at exposure {factor}");
        }
    }
}
