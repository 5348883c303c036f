//! The state of the window that is kept from one start to the next.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::loading::cache::{UserFolder, read_text};
use crate::loading::export::ExportPlan;
use crate::rooms::rooms::{KeptRooms, RoomName};
use crate::widgets::within::within;

/// The file.
const NAME: &str = "window.json";

/// Files that are remembered.
const MOST_RECENT: usize = 8;

/// Sizes of everything, as the menu and the keys have them.
pub(crate) const ZOOMS: RangeInclusive<f64> = 0.75..=2.0;

/// The least width and height of the window, in points.
pub(crate) const LEAST: [f32; 2] = [480.0, 320.0];

/// The largest that is kept, wider than any screen.
const LARGEST: f32 = 16384.0;

/// Light or dark.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Theme {
    /// As the system says.
    #[default]
    System,
    /// Dark.
    Dark,
    /// Light.
    Light,
}

/// What is kept.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
#[non_exhaustive]
pub struct Kept {
    /// The room that is open.
    pub room: RoomName,
    /// Light or dark.
    pub theme: Theme,
    /// Size of everything, 1 for that of the system.
    pub zoom: f32,
    /// Width and height of the window, in points of the system.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size: Option<[f32; 2]>,
    /// Files that were opened, the last first.
    pub recent: Vec<PathBuf>,
    /// What is kept of the rooms.
    #[serde(flatten)]
    pub rooms: KeptRooms,
    /// Where pictures are exported to, and how large they are.
    pub export: ExportPlan,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            room: RoomName::default(),
            theme: Theme::default(),
            zoom: 1.0,
            size: None,
            recent: Vec::new(),
            rooms: KeptRooms::default(),
            export: ExportPlan::default(),
        }
    }
}

impl Kept {
    /// What was kept in a folder; fields that cannot be read are as at the first start, and numbers are brought into their ranges.
    #[must_use]
    pub fn read(folder: &UserFolder) -> Self {
        let text = folder.file(NAME).and_then(|path| read_text(&path));
        let mut kept = text.and_then(|text| readable(&text)).unwrap_or_default();
        kept.check();
        kept
    }

    /// Brings every number into the range that its control has, whoever wrote the file.
    fn check(&mut self) {
        self.zoom = within(f64::from(self.zoom), ZOOMS, 1.0) as f32;
        self.recent.truncate(MOST_RECENT);
        self.size = self.size.filter(|size| is_window(*size));
        self.rooms.check();
        self.export.check();
    }

    /// Keeps it. That it cannot is no error.
    pub fn write(&self, folder: &UserFolder) {
        if let (Some(path), Ok(text)) = (folder.file(NAME), serde_json::to_string_pretty(self)) {
            drop(lobe::io::write_atomically(&path, |file| file.write_all(text.as_bytes())));
        }
    }

    /// Remembers a file.
    pub fn remember(&mut self, path: &Path) {
        self.recent.retain(|recent| recent != path);
        self.recent.insert(0, path.into());
        self.recent.truncate(MOST_RECENT);
    }
}

/// What a text has kept, without the fields that cannot be read; none if it is no object of JSON.
fn readable(text: &str) -> Option<Kept> {
    if let Ok(kept) = serde_json::from_str(text) {
        return Some(kept);
    }
    let read = |fields: Map<String, Value>| serde_json::from_value::<Kept>(Value::Object(fields)).ok();
    let all: Map<String, Value> = serde_json::from_str(text).ok()?;
    let alone = |(name, value): &(String, Value)| read(Map::from_iter([(name.clone(), value.clone())])).is_some();
    read(all.into_iter().filter(alone).collect())
}

/// Whether a window can have this size.
pub(crate) fn is_window(size: [f32; 2]) -> bool {
    size.iter().zip(LEAST).all(|(side, least)| (least..=LARGEST).contains(side))
}
