//! Spheres drawn over the picture as rings.

use eframe::egui::{Color32, Painter, Rect, Stroke, vec2};
use lobe::shadow::WorldSphere;

use crate::widgets::orbit::Orbit;

/// Draws each sphere as the ring that its silhouette nearly is.
pub(crate) fn rings(painter: &Painter, rect: Rect, orbit: &Orbit, spheres: &[WorldSphere]) {
    let half = 0.5 * rect.height();
    for sphere in spheres {
        let (Some([right, up]), Some(size)) = (orbit.project(sphere.center), orbit.size_at(sphere.center)) else {
            continue;
        };
        let at = rect.center() + vec2(right as f32, -up as f32) * half;
        let radius = (sphere.radius * size) as f32 * half;
        painter.circle(
            at,
            radius,
            Color32::from_rgba_unmultiplied(255, 210, 90, 18),
            Stroke::new(1.0, Color32::YELLOW),
        );
    }
}
