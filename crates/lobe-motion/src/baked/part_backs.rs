//! The backs of vertices of a part: transfer of those that views have shown.

use lobe_io::Job;
use lobe_prt::{BakeOptions, Receivers, Transfer, bake};
use lobe_scene::{Bvh, Scene};

use lobe_render::RenderError;

const NONE: u32 = u32::MAX;

/// The transfer of the backs of some vertices of a part from the part alone, in its own frame.
#[derive(Clone, Debug)]
pub(crate) struct PartBacks {
    /// The receiver at the back of each vertex; [`NONE`] where there is none.
    receivers: Vec<u32>,
    transfer: Transfer,
    /// What all of them were baked with.
    options: BakeOptions,
}

impl PartBacks {
    /// Bakes the backs of these vertices, in rising order, beside those that are known already
    /// [of these options](PartBacks::is_of).
    pub(crate) fn bake(
        known: Option<&Self>,
        scene: &Scene,
        vertices: &[usize],
        options: &BakeOptions,
        job: Job<'_>,
    ) -> Result<Self, RenderError> {
        let fronts = Receivers::at_vertices(scene)?;
        // All backs of a part have as many channels, whichever are baked together.
        let with_channels = options.clone().channels(Some(options.channels_for(scene, scene.is_gray())));
        let (found, _) = bake(scene, &Bvh::new(scene), &fronts.backs(vertices)?, &with_channels, job)?;
        let (mut receivers, before) = match known {
            Some(known) => (known.receivers.clone(), known.transfer.coefficients()),
            None => (vec![NONE; scene.vertex_count()], &[][..]),
        };
        let first = known.map_or(0, |known| known.transfer.receivers());
        for (k, vertex) in vertices.iter().enumerate() {
            receivers[*vertex] = (first + k) as u32;
        }
        let rows = [before, found.coefficients()].concat();
        let transfer = Transfer::new(found.order(), found.channels(), rows)?;
        Ok(Self { receivers, transfer, options: options.clone() })
    }

    /// Whether they were baked with these options: rows of others have another length, or are of other light.
    pub(crate) fn is_of(&self, options: &BakeOptions) -> bool {
        self.options == *options
    }

    /// Whether the back of a vertex is known.
    pub(crate) fn has(&self, vertex: usize) -> bool {
        self.receivers[vertex] != NONE
    }

    /// The transfer of the backs of these vertices, all of which are known.
    pub(crate) fn transfer_of(&self, vertices: &[usize]) -> Result<Transfer, RenderError> {
        let transfer = &self.transfer;
        let channels = transfer.channels();
        let mut rows = Vec::with_capacity(vertices.len() * channels.count() * transfer.order().pow(2));
        for vertex in vertices {
            for channel in 0..channels.count() {
                rows.extend_from_slice(transfer.vector(self.receivers[*vertex] as usize, channel));
            }
        }
        Ok(Transfer::new(transfer.order(), channels, rows)?)
    }
}
