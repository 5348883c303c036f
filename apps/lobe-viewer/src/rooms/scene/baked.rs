//! Transfer that is known of a scene.

use std::collections::HashMap;
use std::sync::Arc;

use lobe::prt::{BakeMode, Recipe, Transfer};

use crate::loading::mode::Mode;
use crate::loading::places::Places;

/// Transfer of some light paths.
pub(crate) struct Baked {
    pub(crate) transfer: Arc<Transfer>,
    pub(crate) samples: Option<u32>,
    pub(crate) bounces: usize,
    pub(crate) places: Places,
    /// How a file says that it was baked.
    pub(crate) recipe: Option<Arc<Recipe>>,
}

/// The part of transfer that is without reflections, by which suns are taken out of it.
#[derive(Default)]
pub(crate) struct DirectPart {
    /// One that was baked for transfer of a file.
    found: Option<Arc<Transfer>>,
    /// The transfer for which it was asked last.
    asked: Option<Arc<Transfer>>,
}

impl DirectPart {
    pub(crate) fn take(&mut self, found: Arc<Transfer>) {
        self.found = Some(found);
    }

    /// That of what is shown, in a mode that needs it: of the same receivers and order.
    pub(crate) fn of<'a>(
        &'a self,
        shown: Option<&(Mode, Arc<Transfer>)>,
        bakes: &'a HashMap<BakeMode, Baked>,
    ) -> Option<&'a Arc<Transfer>> {
        let (_, whole) = shown.filter(|(mode, _)| *mode == Mode::Interreflected)?;
        let places = &bakes.get(&BakeMode::Interreflected)?.places;
        let baked = bakes.get(&BakeMode::Shadowed).filter(|baked| baked.places.is_alike(places));
        let shape = |transfer: &Transfer| (transfer.order(), transfer.receivers());
        let known = baked.map(|baked| &baked.transfer).into_iter().chain(&self.found);
        known.into_iter().find(|direct| shape(direct) == shape(whole))
    }

    /// What has to be baked for that, once for each transfer: by which recipe, for which receivers.
    pub(crate) fn wish(
        &mut self,
        shown: Option<&(Mode, Arc<Transfer>)>,
        bakes: &HashMap<BakeMode, Baked>,
    ) -> Option<(Arc<Recipe>, usize, Places)> {
        let (_, whole) = shown.filter(|(mode, _)| *mode == Mode::Interreflected)?;
        let is_asked = self.asked.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, whole));
        if is_asked || self.of(shown, bakes).is_some() {
            return None;
        }
        let baked = bakes.get(&BakeMode::Interreflected)?;
        self.asked = Some(whole.clone());
        Some((baked.recipe.clone()?, whole.order(), baked.places.clone()))
    }
}
