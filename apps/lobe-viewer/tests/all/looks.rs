//! The bar of the window: light and dark, the size of everything, files that were opened, changes that are taken back.

use std::path::{Path, PathBuf};

use eframe::egui::{Key, Modifiers, Theme as Shade};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT as _, Queryable as _};
use lobe::sh::Expansion as _;
use lobe_viewer::{Kept, Orbit, RoomName, Section, Shape, Theme, UserFolder, ViewerApp};

use crate::mouse::are_close;
use crate::press::slide;
use crate::wait::step_until;

/// The window on a triangle, and on functions of few bands without unfolded cubes: on what is drawn soonest.
fn window(folder: &Path, change: impl FnOnce(&mut Kept)) -> Harness<'static, ViewerApp> {
    let user = UserFolder::at(folder);
    let mut kept = Kept::default();
    (kept.rooms.scene.scene, kept.rooms.scene.sky, kept.rooms.scene.order) =
        (triangle(folder, "triangle"), "made:even".into(), 1);
    (kept.rooms.functions.order, kept.rooms.functions.shape) = (2, Shape::Basis(1, 0));
    (kept.rooms.functions.has_crosses, kept.rooms.functions.section) = (false, Section::None);
    (kept.rooms.sky.order, kept.rooms.sky.lights, kept.rooms.sky.has_expansion) = (1, 0, true);
    change(&mut kept);
    kept.write(&user);
    again(folder)
}

fn triangle(folder: &Path, name: &str) -> PathBuf {
    let path = folder.join(format!("{name}.obj"));
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    path
}

/// The window as it was left.
fn again(folder: &Path) -> Harness<'static, ViewerApp> {
    let app = ViewerApp::new(None, UserFolder::at(folder), &[]);
    let mut harness =
        Harness::builder().with_size([800.0, 700.0]).build_ui_state(|ui, app: &mut ViewerApp| app.show(ui), app);
    harness.run_steps(2);
    step_until(&mut harness, |app| app.scene().is_idle());
    harness
}

/// What is kept after more than the few seconds between two times of writing.
fn kept(harness: &mut Harness<'_, ViewerApp>, folder: &Path) -> Kept {
    harness.run_steps(20);
    Kept::read(&UserFolder::at(folder))
}

#[test]
fn light_and_dark_and_the_size_are_chosen_in_the_bar_and_kept() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), |_| ());
    for (name, theme, shade) in [("Light", Theme::Light, Shade::Light), ("Dark", Theme::Dark, Shade::Dark)] {
        harness.get_all_by_label("Window").next().unwrap().click();
        harness.run_steps(3);
        harness.get_by_label(name).click();
        harness.run_steps(3);
        assert_eq!(harness.ctx.theme(), shade, "{name}: shown");
        harness.key_press(Key::Escape);
        assert_eq!(kept(&mut harness, folder.path()).theme, theme, "{name}: kept");
    }
    harness.get_all_by_label("Window").next().unwrap().click();
    harness.run_steps(3);
    slide(&mut harness, "Size", 150.0);
    harness.run_steps(2);
    assert_eq!(harness.ctx.zoom_factor(), 1.5, "half as large again");
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Minus);
    harness.run_steps(3);
    assert_eq!(harness.ctx.zoom_factor(), 1.25, "a step less by its keys");
    assert_eq!(kept(&mut harness, folder.path()).zoom, 1.25, "kept");
}

#[test]
fn files_that_were_opened_are_in_the_menu_and_open_again() {
    let folder = tempfile::tempdir().unwrap();
    let (first, second) = (triangle(folder.path(), "first"), triangle(folder.path(), "second"));
    let mut harness = window(folder.path(), |kept| kept.recent = vec![first.clone(), second.clone()]);
    harness.get_by_label("File").click();
    harness.run_steps(3);
    harness.get_by_label("second.obj").click();
    harness.run_steps(3);
    step_until(&mut harness, |app| app.scene().is_idle());
    assert_eq!(harness.state().scene().edits().scene, second, "the one that was pressed");
    assert_eq!(harness.state().scene().message(), None, "and nothing is wrong");
    assert_eq!(kept(&mut harness, folder.path()).recent, [second, first], "the last one comes first");
}

#[test]
fn a_change_of_a_function_is_taken_back_and_made_again_by_the_buttons_of_the_bar() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = window(folder.path(), |kept| kept.room = RoomName::Functions);
    harness.run_steps(10);
    let is_off =
        |harness: &Harness<'_, ViewerApp>, name: &str| harness.get_by_label(name).accesskit_node().is_disabled();
    assert!(is_off(&harness, "Undo") && is_off(&harness, "Redo"), "nothing was changed");
    let first = harness.state().functions().edits().clone();
    slide(&mut harness, "Yaw", -75.0);
    // Undo knows a change once it has rested for a second.
    harness.run_steps(10);
    let changed = harness.state().functions().edits().clone();
    assert_eq!(changed.angles[0], -75.0, "as the slider says");
    harness.get_by_label("Undo").click();
    harness.run_steps(3);
    assert_eq!(*harness.state().functions().edits(), first, "taken back");
    let turned = first.function().rotated(&first.rotation());
    let row: Vec<String> = turned.band(1).iter().map(|c| format!("{c:8.4}")).collect();
    let text = format!("band 1: {}   energy {:.4}", row.join(" "), turned.band_energies()[1]);
    assert!(harness.query_by_label(&text).is_some(), "the numbers are those of before: {text}");
    harness.get_by_label("Redo").click();
    harness.run_steps(3);
    assert_eq!(*harness.state().functions().edits(), changed, "made again");
}

#[test]
fn the_cameras_of_all_rooms_and_the_size_of_the_window_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let (user, moving) = (folder.path(), crate::motion::described(folder.path()));
    let mut harness = window(user, |kept| kept.rooms.motion.source = moving);
    for room in RoomName::ALL {
        harness.get_all_by_label(room.title()).next().unwrap().click();
        harness.run_steps(3);
        if room == RoomName::Motion {
            assert_eq!(Kept::read(&UserFolder::at(user)).rooms.motion_orbit, None, "no scene was seen there");
            step_until(&mut harness, |app| app.motion().is_ready());
        }
        harness.key_press(Key::ArrowLeft);
        harness.key_press(Key::Plus);
        harness.run_steps(2);
    }
    harness.set_size([1234.0, 777.0].into());
    let orbits = |app: &ViewerApp| {
        [app.scene().orbit(), app.sky().orbit(), app.functions().orbit(), app.motion().orbit()].map(|orbit| *orbit)
    };
    let before = orbits(harness.state());
    let written = kept(&mut harness, user);
    let found =
        [written.rooms.orbit, written.rooms.sky_orbit, written.rooms.functions_orbit, written.rooms.motion_orbit];
    for (found, expected) in found.iter().zip(&before) {
        assert!(found.is_some_and(|found| are_close(&found, expected)), "kept: {found:?}, expected {expected:?}");
    }
    assert_eq!(written.size, Some([1234.0, 777.0]), "the size");
    let mut harness = again(user);
    step_until(&mut harness, |app| app.motion().is_ready());
    for (found, expected) in orbits(harness.state()).iter().zip(&before) {
        assert!(are_close(found, expected), "after another start: {found:?}, expected {expected:?}");
    }
    harness.get_by_label("Frame").click();
    harness.run_steps(2);
    assert_ne!(harness.state().motion().orbit().distance, before[3].distance, "framed anew");
}

#[test]
fn sizes_and_cameras_that_are_none_are_those_of_the_first_start() {
    let folder = tempfile::tempdir().unwrap();
    let user = UserFolder::at(folder.path());
    for size in [[0.0, 600.0], [1e9, 600.0], [-800.0, -600.0], [300.0, 200.0]] {
        let mut kept = Kept::default();
        kept.size = Some(size);
        let orbit = Orbit { distance: 1e30, ..Orbit::default() };
        (kept.rooms.sky_orbit, kept.rooms.motion_orbit) = (Some(orbit), Some(orbit));
        kept.write(&user);
        let read = Kept::read(&user);
        assert_eq!(read.size, None, "{size:?}");
        assert!(read.rooms.sky_orbit.is_none() && read.rooms.motion_orbit.is_none(), "{read:?}");
        kept.rooms.sky_orbit = Some(Orbit { height: 9.0, ..Orbit::default() });
        kept.write(&user);
        assert!(Kept::read(&user).rooms.sky_orbit.unwrap().camera().is_some(), "an angle that is none");
    }
}
