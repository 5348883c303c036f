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
    /// Its part without reflections.
    direct: Option<Transfer>,
    /// What all of them were baked with.
    options: BakeOptions,
}

impl PartBacks {
    /// Bakes the backs of these vertices, in rising order, and if asked their direct part, beside those that are known
    /// already [of the same](PartBacks::is_of).
    pub(crate) fn bake(
        known: Option<&Self>,
        scene: &Scene,
        (vertices, is_apart): (&[usize], bool),
        options: &BakeOptions,
        mut job: Job<'_>,
    ) -> Result<Self, RenderError> {
        let (bvh, backs) = (Bvh::new(scene), Receivers::at_vertices(scene)?.backs(vertices)?);
        // All backs of a part have as many channels, whichever are baked together.
        let with_channels = options.clone().channels(Some(options.channels_for(scene, scene.is_gray())));
        let (found, report) = bake(scene, &bvh, &backs, &with_channels, job.reborrow())?;
        let mut receivers = known.map_or_else(|| vec![NONE; scene.vertex_count()], |known| known.receivers.clone());
        let first = known.map_or(0, |known| known.transfer.receivers());
        for (k, vertex) in vertices.iter().enumerate() {
            receivers[*vertex] = (first + k) as u32;
        }
        let transfer = after(known.map(|known| &known.transfer), &found)?;
        let direct = match is_apart {
            false => None,
            true => {
                let paths = with_channels.of_direct_part(Some(report.samples));
                let found = bake(scene, &bvh, &backs, &paths, job)?.0;
                Some(after(known.and_then(|known| known.direct.as_ref()), &found)?)
            }
        };
        Ok(Self { receivers, transfer, direct, options: options.clone() })
    }

    /// Whether they were baked with these options, with a direct part or without: rows of others have another length,
    /// or are of other light.
    pub(crate) fn is_of(&self, options: &BakeOptions, is_apart: bool) -> bool {
        self.options == *options && self.direct.is_some() == is_apart
    }

    /// Whether the back of a vertex is known.
    pub(crate) fn has(&self, vertex: usize) -> bool {
        self.receivers[vertex] != NONE
    }

    /// The transfer of the backs of these vertices, all of which are known, and its direct part if that is known.
    pub(crate) fn transfer_of(&self, vertices: &[usize]) -> Result<(Transfer, Option<Transfer>), RenderError> {
        let direct = self.direct.as_ref().map(|direct| self.rows_of(direct, vertices)).transpose()?;
        Ok((self.rows_of(&self.transfer, vertices)?, direct))
    }

    fn rows_of(&self, transfer: &Transfer, vertices: &[usize]) -> Result<Transfer, RenderError> {
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

/// More receivers behind those that are known.
fn after(known: Option<&Transfer>, found: &Transfer) -> Result<Transfer, RenderError> {
    let before = known.map_or(&[][..], |known| known.coefficients());
    Ok(Transfer::new(found.order(), found.channels(), [before, found.coefficients()].concat())?)
}
