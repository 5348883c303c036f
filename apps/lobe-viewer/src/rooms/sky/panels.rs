//! The pictures of the room.

use eframe::egui::{Align, Align2, Color32, FontId, Label, Layout, Response, RichText, Stroke, Ui, Vec2, vec2};
use lobe::env::{Mapping, Sun};
use lobe::image::{Curve, Picture, Tone};
use lobe::sh::{Dir, Rgb, Rotation};

use crate::rooms::sky::edits::SkyEdits;
use crate::rooms::sky::findings::Findings;
use crate::widgets::picture::PictureView;
use crate::widgets::tone::fitting;

/// Width of an unfolded mapping, in texels.
const UNFOLDED: usize = 256;

/// Size of a lat-long picture, in points.
const WIDE: Vec2 = vec2(360.0, 180.0);

/// Height of a title, in points.
const TITLE: f32 = 22.0;

/// The color of suns that were taken out.
pub(crate) const SUN: Color32 = Color32::from_rgb(255, 120, 30);

/// All pictures of the room.
#[derive(Default)]
pub(crate) struct Panels {
    sky: PictureView,
    reconstruction: PictureView,
    difference: PictureView,
    unfolded: PictureView,
}

impl Panels {
    /// Shows them; returns the direction that was clicked on, in the world.
    pub(crate) fn show(&mut self, ui: &mut Ui, found: &Findings, suns: &[Sun], edits: &SkyEdits) -> Option<Dir> {
        let key = [vec![found.version], edits.look().key()].concat();
        let tone = edits.look().of(fitting(&found.picture));
        let mut clicked = None;
        let (width, wide) = (ui.available_width(), fitting_into(ui.available_width(), WIDE));
        ui.horizontal_wrapped(|ui| {
            let sky = panel(ui, "The sky", wide, |ui| {
                self.sky.show(ui, "The sky, lat-long", wide, key.clone(), || (found.picture.clone(), tone))
            });
            mark_suns(ui, &sky, suns, found.back().inverse());
            let at = sky.interact_pointer_pos().filter(|_| sky.clicked());
            clicked = at.and_then(|at| {
                let from = (at - sky.rect.min) / sky.rect.size();
                Mapping::LatLong.dir_from_uv(f64::from(from.x), f64::from(from.y))
            });
            let title = format!("Its expansion, order {}", edits.order);
            let shown = panel(ui, &title, wide, |ui| {
                let make = || (found.reconstruction.clone(), tone);
                self.reconstruction.show(ui, "The expansion, lat-long", wide, key.clone(), make)
            });
            mark(ui, &shown, found);
            panel(ui, "What is cut off: red missing, blue too much", wide, |ui| {
                self.difference.show(ui, "The difference, lat-long", wide, key.clone(), || {
                    (difference(found), Tone { curve: Curve::Clip, ..tone })
                })
            });
            let mapping = Mapping::from_name(&edits.mapping).unwrap_or(Mapping::Octahedral);
            let mut unfolded_key = key.clone();
            unfolded_key.push(Mapping::ALL.iter().position(|known| *known == mapping).unwrap_or(0) as u64);
            let height = mapping.height_for(UNFOLDED);
            let size = fitting_into(width, vec2(180.0 * UNFOLDED as f32 / height.max(1) as f32, 180.0));
            panel(ui, &format!("Unfolded: {}", mapping.name()), size, |ui| {
                let make = || (unfolded(found, mapping, height), tone);
                self.unfolded.show(ui, "The sky, unfolded", size, unfolded_key, make)
            });
        });
        clicked
    }
}

/// A size, smaller where this width is too little for it.
fn fitting_into(width: f32, size: Vec2) -> Vec2 {
    size * (width / size.x).clamp(0.1, 1.0)
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

/// Marks the suns that were taken out.
fn mark_suns(ui: &Ui, shown: &Response, suns: &[Sun], turn: Rotation) {
    let painter = ui.painter_at(shown.rect);
    for sun in suns {
        let (u, v) = Mapping::LatLong.uv_from_dir(turn.rotate_dir(sun.direction));
        let at = shown.rect.min + vec2(shown.rect.width() * u as f32, shown.rect.height() * v as f32);
        painter.circle_stroke(at, 8.0, Stroke::new(3.0, Color32::BLACK));
        painter.circle_stroke(at, 8.0, Stroke::new(1.5, SUN));
    }
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
