//! The middle of the room: its pictures, and the pointer on them.

use eframe::egui::{Rect, Response, Sense, Ui};
use lobe::motion::MovingMethod;

use crate::rooms::motion::hands;
use crate::rooms::motion::motion_room::MotionRoom;
use crate::rooms::motion::panes::{Panes, Scenery};
use crate::rooms::motion::spheres::rings;
use crate::rooms::motion::stage::Frame;
use crate::rooms::steer;
use crate::widgets::gpu::{Gpu, failure};
use crate::widgets::named::name_image;
use crate::widgets::orbit::Orbit;

impl MotionRoom {
    /// The pictures of the last moment, and what a pointer does to them.
    pub(super) fn picture(&mut self, ui: &mut Ui, gpu: Option<&Gpu>) {
        let whole = ui.available_rect_before_wrap();
        let places = Panes::places(self.edits.view, whole);
        self.picture_ids.clear();
        ui.painter().rect_filled(whole, 0.0, ui.visuals().panel_fill);
        for (number, (pane, rect)) in places.iter().enumerate() {
            let response = ui.interact(*rect, ui.scope_id().with(("picture", number)), Sense::click_and_drag());
            name_image(&response, &format!("Picture of what moves: {}", pane.title()));
            self.follow(ui, &response);
            self.picture_ids.push(response.id);
            steer::hold_keys(ui, &response);
        }
        let (Some(gpu), Some(lit)) = (gpu, self.lit.clone()) else {
            let text = if gpu.is_none() { "No graphics device: the picture is not drawn." } else { self.unlit() };
            ui.centered_and_justified(|ui| ui.label(text));
            return;
        };
        let scale = ui.ctx().pixels_per_point();
        let side = |points: f32| (points.max(0.0) * scale).round() as u32;
        let size = places.first().map_or([0, 0], |(_, rect)| [side(rect.width()), side(rect.height())]);
        let is_playing = self.clock.is_playing && !self.edits.is_by_hand;
        let is_still = !is_playing && !self.is_sky_turning && !self.is_waiting;
        let behind = self.behind();
        let scenery = Scenery { lit: &lit, sky: self.sky.as_ref(), behind: &behind };
        let orbit = places.first().map_or(self.orbit, |(_, rect)| self.seen(*rect));
        let (turn, look) = (self.edits.rotation(), self.edits.look());
        let frame = Frame { orbit, size, turn, look, is_still };
        if let Err(error) = self.panes.show(ui, gpu, &places, &scenery, &frame) {
            ui.centered_and_justified(|ui| ui.label(failure(&error)));
        }
        if self.edits.has_spheres {
            for (_, rect) in places.iter().filter(|(pane, _)| pane.method() == Some(MovingMethod::Exponentials)) {
                rings(&ui.painter_at(*rect), *rect, &orbit, self.spheres_of_moment());
            }
        }
    }

    /// The camera of a picture at a place: what is in the picture remains there beside others.
    fn seen(&self, place: Rect) -> Orbit {
        self.orbit.fitting(f64::from(place.width()), f64::from(place.height()))
    }

    /// A drag on an object moves, turns or scales it; elsewhere it changes the camera and the light.
    fn follow(&mut self, ui: &Ui, response: &Response) {
        if response.drag_started() {
            let at = ui.input(|input| input.pointer.press_origin());
            let found = at.zip(self.cast.as_ref()).filter(|_| self.edits.is_by_hand).and_then(|(at, cast)| {
                hands::object_at(&self.edits.hands, cast, &self.seen(response.rect), response.rect, at)
            });
            if let Some(found) = found {
                self.chosen = found;
            }
            ui.data_mut(|data| data.insert_temp(response.id, found.is_some()));
        }
        if response.dragged() && ui.data(|data| data.get_temp(response.id)).unwrap_or(false) {
            let orbit = self.seen(response.rect);
            let modifiers = ui.input(|input| input.modifiers);
            if let Some(hand) = self.edits.hands.get_mut(self.chosen) {
                hands::drag(hand, &orbit, modifiers, steer::drag_of(response));
            }
            steer::zoom(ui, response, &mut self.orbit);
        } else {
            let most_order = self.most_order();
            steer::pointer(ui, response, &mut self.orbit, &mut self.edits.light(most_order));
        }
    }
}
