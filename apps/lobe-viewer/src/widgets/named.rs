//! Names for what is painted, so that screen readers and tests find it.

use eframe::egui::accesskit::Role;
use eframe::egui::{Response, WidgetInfo};

/// Gives a picture its name.
pub(crate) fn name_image(response: &Response, name: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
}

/// Gives a control a longer name for screen readers than the one beside it, where several have the same.
pub(crate) fn name_fully(response: &Response, name: &str) {
    // Nobody listens where nothing is built.
    let _is_built: Option<()> = response.ctx.accesskit_node_builder(response.id, |node| node.set_label(name));
}
