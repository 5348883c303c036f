//! Suns of a sky, and the sky without those that were clicked on.

use std::sync::Arc;

use lobe::env::{MappedMap, Sun, SunChoice, SunOptions, extract_sun, project_map};
use lobe::prt::Transfer;
use lobe::sh::{Coefficient as _, Dir, Rgb};

use crate::loading::sky_source::OpenedSky;
use crate::loading::task::{Control, Task, TaskEvent};
use crate::rooms::sky::edits::MOST_SUNS;

/// A click within so many radians of a sun is meant for it.
pub(crate) const NEAR: f64 = 0.15;

/// What became of a sky whose suns were looked for.
pub(crate) struct Found {
    /// All suns of the sky, the brightest first.
    pub(crate) all: Vec<Sun>,
    /// Those that were taken out.
    pub(crate) taken: Vec<Sun>,
    /// The sky without them; none if none was taken out.
    pub(crate) rest: Option<OpenedSky>,
}

/// A sky, the places that were clicked, and what looks for them.
struct Asked {
    map: Arc<MappedMap>,
    places: Vec<[f64; 2]>,
    task: Task<Found>,
}

/// Looks for suns beside the window.
#[derive(Default)]
pub(crate) struct Suns {
    asked: Option<Asked>,
    found: Option<(Arc<MappedMap>, Found)>,
    pub(crate) message: Option<String>,
}

impl Suns {
    /// Looks for the suns of a sky where it or the places that were clicked are others.
    pub(crate) fn follow(&mut self, wake: impl Fn() + Send + 'static, sky: &OpenedSky, clicked: &[[f64; 2]]) {
        let of_sky = self.asked.as_ref().filter(|asked| Arc::ptr_eq(&asked.map, &sky.map));
        let is_asked = of_sky.is_some_and(|asked| asked.places == clicked);
        if of_sky.is_none() {
            self.message = None;
        }
        if !is_asked {
            let (work, places) = (sky.clone(), clicked.to_vec());
            let task = Task::start("Suns", wake, move |control| look(control, &work, &places));
            self.asked = Some(Asked { map: sky.map.clone(), places: clicked.to_vec(), task });
        }
        let Some(Asked { map, task, .. }) = &self.asked else { return };
        for event in task.events() {
            match event {
                TaskEvent::Result(found) => self.found = Some((map.clone(), found)),
                TaskEvent::Failed(message) => self.message = Some(message),
                TaskEvent::Done | TaskEvent::Cancelled => {}
            }
        }
    }

    /// What is known of a sky.
    pub(crate) fn found(&self, sky: &OpenedSky) -> Option<&Found> {
        self.found.as_ref().filter(|(map, _)| Arc::ptr_eq(map, &sky.map)).map(|(_, found)| found)
    }
}

/// The sun that is meant by a click towards `s`, in the frame of the sky: the nearest.
pub(crate) fn meant(all: &[Sun], s: Dir) -> Option<&Sun> {
    let nearest = all.iter().min_by(|a, b| a.direction.angle_to(s).total_cmp(&b.direction.angle_to(s)));
    nearest.filter(|sun| sun.direction.angle_to(s) <= NEAR + 0.5 * sun.angular_diameter)
}

/// Azimuth and height in degrees.
pub(crate) fn place_of(s: Dir) -> [f64; 2] {
    [s.phi().to_degrees(), 90.0 - s.theta().to_degrees()]
}

fn dir_of([azimuth, height]: [f64; 2]) -> Dir {
    Dir::from_angles((90.0 - height).to_radians(), azimuth.to_radians())
}

/// Takes out one sun after the other, then puts back those that nobody clicked on.
fn look(control: &Control<Found>, sky: &OpenedSky, clicked: &[[f64; 2]]) -> Result<(), String> {
    control.stage("looking for suns");
    let (mut all, mut lights) = (Vec::new(), Vec::new());
    let mut map = (*sky.map).clone();
    while all.len() < MOST_SUNS
        && !control.is_cancelled()
        && let Some(report) = extract_sun(&map, &SunOptions::default())
    {
        lights.push(changed(&map, &report.rest));
        all.push(report.sun);
        map = report.rest;
    }
    let is_taken: Vec<bool> = all
        .iter()
        .map(|sun| clicked.iter().any(|place| meant(&all, dir_of(*place)).is_some_and(|meant| meant == sun)))
        .collect();
    let taken: Vec<Sun> = all.iter().zip(&is_taken).filter(|(_, taken)| **taken).map(|(sun, _)| *sun).collect();
    for (light, _) in lights.iter().zip(&is_taken).filter(|(_, taken)| !**taken) {
        for (number, light) in light {
            let texel = &mut map.texels_mut()[*number];
            *texel = Rgb::narrow(texel.widen() + light.widen());
        }
    }
    let rest = (!taken.is_empty()).then(|| {
        let light = Arc::new(project_map(&map, Transfer::MAX_ORDER));
        let map = Arc::new(map);
        let split = Arc::new((*light).clone().into());
        OpenedSky { name: sky.name.clone(), shown: map.clone(), map, light, split, choice: SunChoice::None }
    });
    control.send(Found { all, taken, rest });
    Ok(())
}

/// The texels that differ, by their numbers, and what the first map has more.
fn changed(before: &MappedMap, after: &MappedMap) -> Vec<(usize, Rgb<f32>)> {
    let all = before.texels().iter().zip(after.texels()).enumerate();
    all.filter(|(_, (before, after))| before != after).map(|(k, (before, after))| (k, *before - *after)).collect()
}

#[cfg(test)]
mod tests {
    use lobe::env::Mapping;

    use super::*;

    fn even() -> OpenedSky {
        OpenedSky::of("even".into(), MappedMap::from_fn(Mapping::LatLong, 8, 4, |_| Rgb::splat(1.0)))
    }

    #[test]
    fn what_is_said_of_a_sky_is_not_said_of_the_next() {
        let (mut suns, sky) = (Suns::default(), even());
        suns.follow(|| (), &sky, &[]);
        suns.message = Some("No sun".into());
        suns.follow(|| (), &sky, &[[10.0, 20.0]]);
        assert!(suns.message.is_some(), "it is the same sky");
        suns.follow(|| (), &even(), &[]);
        assert_eq!(suns.message, None, "it is another");
    }
}
