//! Options of a bake that a picture needs and no file has.

use lobe_io::{JobOptions, OptionError, OptionField, OptionKind, options};
use lobe_prt::{AdaptiveOptions, BakeOptions};

use crate::error::RenderError;

options! {
    /// How a scene is baked for a picture, where its transfer is in no file.
    pub struct PictureBake {
        /// Reflections at most; of what moves within each part
        bounces: Option<usize> = None,
            OptionKind::Whole { least: 0, most: BakeOptions::MAX_BOUNCES as u64, what: "a number of reflections" },
            "B", "3, or those of the file";
        /// Paths from each vertex where the scene is not baked yet
        bake_samples: Option<u32> = None,
            OptionKind::Whole { least: 1, most: 1 << 20, what: "a number of samples" },
            "N", "1024, or up to 4096 where their noise is above 2 %";
        /// Where a scene is baked: the most vertices that splitting may leave it, spent where transfer is farthest off.
        /// Of a scene that moves, what moves takes half of the new ones at most, and its shadows half of the rest
        max_vertices: Option<usize> = None,
            OptionKind::Whole { least: 1, most: u32::MAX as u64, what: "a number of vertices" }, "N",
            "four times those of the scene, at least 20000";
        /// Bake at the vertices that the scene has, however few
        no_split: bool = false, OptionKind::Flag, "", "";
    }
}

impl JobOptions for PictureBake {
    fn fields() -> Vec<&'static OptionField> {
        Self::FIELDS.iter().collect()
    }

    fn check_together(&self, _given: &lobe_io::Given<'_>) -> Result<(), OptionError> {
        if self.max_vertices.is_some() && self.no_split {
            return Err(OptionError::new("max_vertices", "not with @no_split, by which nothing is split"));
        }
        Ok(())
    }
}

impl PictureBake {
    /// The light paths, of `order` bands.
    #[must_use]
    pub fn light(&self, order: usize) -> BakeOptions {
        let defaults = BakeOptions::default();
        let bounces = self.bounces.unwrap_or(defaults.bounces);
        let mut options = defaults.order(order).bounces(bounces);
        options.samples = self.bake_samples;
        options
    }

    /// How a scene that begins with so many vertices is split, by bakes with these light paths.
    ///
    /// # Errors
    /// [`RenderError::OfJob`] if that is more than it may have.
    pub fn splitting(&self, found: usize, light: BakeOptions) -> Result<AdaptiveOptions, RenderError> {
        if self.max_vertices.is_some_and(|most| most < found) {
            let message = format!("expected at least the {found} vertices that the scene begins with");
            return Err(OptionError::new("max_vertices", message).into());
        }
        Ok(AdaptiveOptions::default().max_vertices(self.max_vertices).bake(light))
    }
}
