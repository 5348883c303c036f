//! The transfer of the vertex under the pointer.

use eframe::egui::{Color32, Painter, Pos2, Rect, Stroke, Ui};
use lobe::prt::Transfer;
use lobe::scene::{Hit, Ray, Scene};
use lobe::sh::{Expansion as _, ShVec};

use crate::loading::bake::SceneData;
use crate::widgets::balloon::{BalloonView, Shown};
use crate::widgets::orbit::Orbit;

/// Sides of the balloon in points.
const LARGEST: f32 = 190.0;
const LEAST: f32 = 96.0;

/// Shows what a vertex does to light: red where light from there reaches the eye from it, blue where the expansion rings.
#[derive(Default)]
pub(crate) struct Probe {
    pub(crate) is_on: bool,
    vertex: Option<Vertex>,
    balloon: BalloonView,
    /// Whether the panel has scrolled to the balloon since it was switched on.
    is_found: bool,
}

/// A vertex by its number among all, and where it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Among those of all meshes, in their order.
    pub number: usize,
    /// In the world.
    pub position: [f64; 3],
}

/// The vertex nearest to where a ray of the camera meets the scene. `right` and `up` count from the middle of the picture, whose upper
/// edge is at 1.
#[must_use]
pub fn vertex_under(data: &SceneData, orbit: &Orbit, right: f64, up: f64) -> Option<Vertex> {
    let camera = orbit.camera()?.relative_to(data.scene.origin());
    let (origin, towards) = camera.ray(right, up);
    let ray = Ray::new(origin.map(|c| c as f32), towards.to_array().map(|c| c as f32));
    let hit = data.bvh.closest(&ray)?;
    Some(nearest_corner(&data.scene, &hit))
}

fn nearest_corner(scene: &Scene, hit: &Hit) -> Vertex {
    let (mesh, triangle) = scene.locate(hit.triangle as usize);
    let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let nearest = (0..3).max_by(|a, b| weights[*a].total_cmp(&weights[*b])).unwrap_or(0);
    let corner = scene.meshes()[mesh].triangles()[triangle][nearest] as usize;
    let before: usize = scene.meshes()[..mesh].iter().map(|mesh| mesh.positions().len()).sum();
    let local = scene.meshes()[mesh].positions()[corner].map(f64::from);
    let origin = scene.origin();
    Vertex { number: before + corner, position: std::array::from_fn(|k| local[k] + origin[k]) }
}

/// The transfer of a vertex, the mean of its channels.
#[must_use]
pub fn transfer_of(transfer: &Transfer, vertex: usize) -> Option<ShVec<f64>> {
    if vertex >= transfer.receivers() {
        return None;
    }
    let channels = [0, 1, 2].map(|channel| transfer.vector(vertex, channel));
    let mean = (0..channels[0].len()).map(|i| channels.iter().map(|c| f64::from(c[i])).sum::<f64>() / 3.0);
    ShVec::from_vec(mean.collect())
}

impl Probe {
    /// Finds the vertex under the pointer and marks it in the picture.
    pub(crate) fn look(&mut self, painter: &Painter, rect: Rect, at: Option<Pos2>, data: &SceneData, orbit: &Orbit) {
        if !self.is_on {
            return;
        }
        let half = 0.5 * f64::from(rect.height());
        let place = |c: f32, middle: f32| f64::from(c - middle) / half;
        if let Some(at) = at.filter(|at| rect.contains(*at)) {
            let (right, up) = (place(at.x, rect.center().x), -place(at.y, rect.center().y));
            self.vertex = vertex_under(data, orbit, right, up).or(self.vertex);
        }
        let Some([right, up]) = self.vertex.and_then(|vertex| orbit.project(vertex.position)) else { return };
        let at = rect.center() + eframe::egui::vec2((right * half) as f32, (-up * half) as f32);
        painter.circle_stroke(at, 5.0, Stroke::new(2.0, Color32::BLACK));
        painter.circle_stroke(at, 5.0, Stroke::new(1.0, Color32::WHITE));
    }

    /// Forgets the vertex, for another scene.
    pub(crate) fn forget(&mut self) {
        self.vertex = None;
    }

    /// The switch, the number of the vertex and its balloon, seen from where the picture is, or why there is none.
    pub(crate) fn controls(&mut self, ui: &mut Ui, transfer: Result<&Transfer, &str>, orbit: &mut Orbit) {
        ui.checkbox(&mut self.is_on, "Transfer under the pointer (P)");
        if !self.is_on {
            self.is_found = false;
            return;
        }
        let Some(vertex) = self.vertex else {
            ui.weak("Point at a surface.");
            return;
        };
        let f = match transfer.map(|transfer| transfer_of(transfer, vertex.number)) {
            Ok(Some(f)) => f,
            Ok(None) => return,
            Err(why) => {
                ui.weak(why);
                return;
            }
        };
        let mean = f.mean();
        ui.label(format!("Vertex {}, mean {mean:.4}", vertex.number));
        let key: Vec<f64> = f.coefficients().to_vec();
        let shown = Shown { name: "Transfer of the vertex", key: &key, f: |s| f.eval(s), extent: None };
        // As large as there is room for below, and never so small that nothing is seen: then the panel scrolls to it.
        let below = ui.clip_rect().bottom() - ui.cursor().top();
        let side = ui.available_width().min(LARGEST).min(below.max(LEAST));
        let balloon = self.balloon.show(ui, side, orbit, &shown);
        let by = balloon.drag_delta() / side;
        orbit.turn(f64::from(by.x), f64::from(by.y));
        // Once: who scrolls away again is left there.
        if below < LEAST && !self.is_found {
            balloon.scroll_to_me(None);
        }
        self.is_found = true;
    }
}
