//! The sky as it surrounds the eye, and a mirror, a glossy and a matte ball before it.

use eframe::egui::{Align2, Color32, FontId, Painter, Pos2, Rect, Response, Stroke, Ui, pos2, vec2};
use lobe::env::Sun;
use lobe::figures::{Shading, SurfacePoint};
use lobe::image::{Picture, Tone};
use lobe::render::Camera;
use lobe::sh::sphere::vector::{add, dot, scale, sub};
use lobe::sh::{Coefficient as _, Dir, Rgb};

use crate::rooms::sky::findings::Findings;
use crate::rooms::sky::panels::SUN;
use crate::widgets::orbit::Orbit;
use crate::widgets::picture::PictureView;

/// The middles of the balls, of radius 1: seen along +x from left to right.
const BALLS: [[f64; 3]; 3] = [[0.0, 2.4, 0.0], [0.0, 0.0, 0.0], [0.0, -2.4, 0.0]];

/// The box around them.
const BOUNDS: [[f64; 3]; 2] = [[-1.0, -3.4, -1.0], [1.0, 3.4, 1.0]];

/// Height over width, and the most rows.
const SHAPE: f32 = 0.36;
const MOST_ROWS: f32 = 300.0;

/// Pixels for a point while the camera moves.
const COARSE: f32 = 0.5;

/// The arrows of lights begin and end so far from the middle.
const ARROW: [f64; 2] = [2.3, 1.25];

/// The picture.
#[derive(Default)]
pub(crate) struct SkyStage {
    picture: PictureView,
}

/// What it shows.
pub(crate) struct Scenery<'a> {
    pub(crate) found: &'a Findings,
    /// A mirror, a glossy and a matte ball.
    pub(crate) balls: [&'a dyn Shading; 3],
    pub(crate) suns: &'a [Sun],
    pub(crate) tone: Tone,
    pub(crate) key: Vec<u64>,
}

/// The camera that sees the balls along +x.
pub(crate) fn framed(orbit: Orbit) -> Orbit {
    orbit.framing(BOUNDS)
}

/// The camera of the first start.
pub(crate) fn first_orbit() -> Orbit {
    framed(Orbit { azimuth: std::f64::consts::PI, height: 0.12, ..Orbit::default() })
}

impl SkyStage {
    /// Shows it as wide as there is room for.
    pub(crate) fn show(&mut self, ui: &mut Ui, orbit: &Orbit, scenery: &Scenery<'_>) -> Response {
        let width = ui.available_width().max(64.0);
        let size = vec2(width, (SHAPE * width).min(MOST_ROWS));
        let is_moving = ui.input(|input| input.pointer.is_decidedly_dragging());
        let scale = if is_moving { COARSE } else { ui.ctx().pixels_per_point().min(1.0) };
        let pixels = [size.x, size.y].map(|points| ((points * scale).round() as usize).max(1));
        let mut key = scenery.key.clone();
        key.extend(pixels.map(|side| side as u64));
        let numbers = [orbit.azimuth, orbit.height, orbit.distance].into_iter().chain(orbit.target);
        key.extend(numbers.map(f64::to_bits));
        let name = "The sky with a mirror, a glossy and a matte ball";
        let response = self.picture.show(ui, name, size, key, || {
            let picture = orbit.camera().map(|camera| picture(&camera, pixels, scenery));
            (picture.unwrap_or_else(|| Picture::filled(1, 1, [0.0; 3])), scenery.tone)
        });
        arrows(&ui.painter_at(response.rect), response.rect, orbit, scenery);
        response
    }
}

/// The direction from the eye through a point of the picture; none through a ball.
pub(crate) fn seen_behind(orbit: &Orbit, rect: Rect, at: Pos2) -> Option<Dir> {
    let half = 0.5 * f64::from(rect.height());
    let from = at - rect.center();
    let (origin, towards) = orbit.camera()?.ray(f64::from(from.x) / half, -f64::from(from.y) / half);
    nearest(origin, towards).is_none().then_some(towards)
}

fn picture(camera: &Camera, [width, height]: [usize; 2], scenery: &Scenery<'_>) -> Picture {
    let half = 0.5 * height as f64;
    Picture::from_fn(width, height, |x, y| {
        let (right, up) = (x as f64 + 0.5 - 0.5 * width as f64, half - y as f64 - 0.5);
        let (origin, towards) = camera.ray(right / half, up / half);
        match nearest(origin, towards) {
            Some((number, point)) => scenery.balls[number].radiance(&point),
            None => Rgb::narrow(scenery.found.radiance(towards)),
        }
    })
}

/// The first ball that a ray meets, and where.
fn nearest(origin: [f64; 3], towards: Dir) -> Option<(usize, SurfacePoint)> {
    let d = towards.to_array();
    let hit = |(number, center): (usize, &[f64; 3])| {
        let o = sub(origin, *center);
        // |o + t d|² = 1
        let (b, c) = (dot(o, d), dot(o, o) - 1.0);
        let root = (b * b - c).sqrt();
        let t = -b - root;
        (t > 0.0).then_some((number, t))
    };
    let (number, t) = BALLS.iter().enumerate().filter_map(hit).min_by(|a, b| a.1.total_cmp(&b.1))?;
    let position = add(origin, scale(d, t));
    let normal = Dir::new(sub(position, BALLS[number]))?;
    Some((number, SurfacePoint { position, normal, view: -towards }))
}

/// The lights of the expansion, with their numbers, and the suns that were taken out, as arrows that point at the balls.
fn arrows(painter: &Painter, rect: Rect, orbit: &Orbit, scenery: &Scenery<'_>) {
    let place = |s: Dir, length: f64| {
        let [right, up] = orbit.project(s.to_array().map(|c| length * c))?;
        let half = 0.5 * rect.height();
        Some(pos2(rect.center().x + right as f32 * half, rect.center().y - up as f32 * half))
    };
    let draw = |s: Dir, color: Color32, text: &str| {
        let [Some(from), Some(to)] = ARROW.map(|length| place(s, length)) else { return };
        painter.arrow(from, to - from, Stroke::new(5.0, Color32::BLACK));
        painter.arrow(from, to - from, Stroke::new(2.5, color));
        for (by, color) in [(1.0, Color32::BLACK), (0.0, color)] {
            painter.text(from + vec2(by, by), Align2::CENTER_BOTTOM, text, FontId::monospace(14.0), color);
        }
    };
    for (number, light) in scenery.found.lights.iter().flat_map(|fit| &fit.lights).enumerate() {
        draw(light.dir, Color32::YELLOW, &(number + 1).to_string());
    }
    let turn = scenery.found.back().inverse();
    for sun in scenery.suns {
        draw(turn.rotate_dir(sun.direction), SUN, "sun");
    }
}
