//! The axes as seen from the eye.

use lobe_sh::Rgb;

use crate::View;
use lobe_image::draw_lines;
use lobe_image::{Label, Picture};

/// Draws the axes from the point `(x, y)`, each `length` pixels long when seen from the side, with their names.
pub(crate) fn draw_axes(picture: &mut Picture, view: &View, x: f64, y: f64, length: f64, color: Rgb<f32>) {
    let axes = [("x", [1.0, 0.0, 0.0]), ("y", [0.0, 1.0, 0.0]), ("z", [0.0, 0.0, 1.0])];
    let ends = axes.map(|(name, axis)| {
        let [right, up, _] = view.project(axis);
        (name, [right, -up])
    });
    let lines = ends.map(|(_, [dx, dy])| [[x, y], [x + length * dx, y + length * dy]]);
    draw_lines(picture, &lines, (0.03 * length).max(1.2), color);
    for (name, [dx, dy]) in ends {
        let height = (0.3 * length).max(9.0);
        let label = Label { left: 0.0, top: 0.0, height, color: color.into() };
        let away = length + 0.75 * height;
        // An axis that points at the eye has no direction in the picture.
        let scale = if dx.hypot(dy) > 0.1 { (length * dx.hypot(dy) + 0.75 * height) / dx.hypot(dy) } else { away };
        let (left, top) = (x + scale * dx - 0.5 * label.width(name), y + scale * dy - 0.5 * height);
        Label { left, top, ..label }.draw(picture, name);
    }
}
