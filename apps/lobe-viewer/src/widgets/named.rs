//! Names for what is painted, so that screen readers and tests find it.

use eframe::egui::accesskit::Role;
use eframe::egui::{Response, WidgetInfo};

/// Gives a picture its name.
pub(crate) fn name_image(response: &Response, name: &str) {
    response.widget_info(|| WidgetInfo::labeled(Role::Image, true, name));
}
