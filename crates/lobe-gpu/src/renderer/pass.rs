//! A pass: one program, what it reads and what it writes.

use std::ops::Range;

use crate::renderer::drawing::Drawing;
use crate::renderer::kernel::Kernel;

/// A named step of the work of a frame.
#[derive(Clone, Debug)]
pub(crate) struct Pass {
    pub(crate) name: String,
    pub(crate) reads: Vec<Use>,
    pub(crate) writes: Vec<Use>,
    pub(crate) work: Work,
}

/// A resource by its name, whole or a range of its bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Use {
    pub(crate) name: String,
    pub(crate) bytes: Option<Range<u64>>,
}

#[derive(Clone, Debug)]
pub(crate) enum Work {
    /// A compute program over `items`.
    Compute { kernel: Kernel, items: u32 },
    /// These vertices drawn into the first texture that is written, with the second as depth; the third, if there is
    /// one, gets the means of the samples of the first. Their attributes are in
    /// buffers, and with a buffer of indices, they are those vertices.
    Draw { drawing: Drawing, vertices: Range<u32>, attributes: Vec<String>, indices: Option<String>, clear: bool },
}

impl Pass {
    pub(crate) fn compute(name: impl Into<String>, kernel: &Kernel, items: u32) -> Self {
        Self::new(name, Work::Compute { kernel: kernel.clone(), items })
    }

    /// A pass that draws these vertices; with `clear`, after the targets were made black and infinitely far.
    pub(crate) fn draw(name: impl Into<String>, drawing: &Drawing, vertices: Range<u32>, clear: bool) -> Self {
        Self::new(name, Work::Draw { drawing: drawing.clone(), vertices, attributes: Vec::new(), indices: None, clear })
    }

    /// A draw pass whose vertices are those of a buffer of indices, with their attributes in these buffers.
    pub(crate) fn by_indices(mut self, buffer: &str, of_vertices: &[&str]) -> Self {
        if let Work::Draw { indices, attributes, .. } = &mut self.work {
            *indices = Some(buffer.into());
            *attributes = of_vertices.iter().map(|name| (*name).to_owned()).collect();
        }
        self
    }

    fn new(name: impl Into<String>, work: Work) -> Self {
        Self { name: name.into(), reads: Vec::new(), writes: Vec::new(), work }
    }

    pub(crate) fn read(self, resource: &str) -> Self {
        self.read_use(Use { name: resource.into(), bytes: None })
    }

    pub(crate) fn read_part(self, resource: &str, bytes: Range<u64>) -> Self {
        self.read_use(Use { name: resource.into(), bytes: Some(bytes) })
    }

    pub(crate) fn read_use(mut self, used: Use) -> Self {
        self.reads.push(used);
        self
    }

    pub(crate) fn write(mut self, resource: &str) -> Self {
        self.writes.push(Use { name: resource.into(), bytes: None });
        self
    }

    pub(crate) fn write_part(mut self, resource: &str, bytes: Range<u64>) -> Self {
        self.writes.push(Use { name: resource.into(), bytes: Some(bytes) });
        self
    }

    /// Whether it draws triangles; else it computes.
    pub(crate) fn is_draw(&self) -> bool {
        matches!(self.work, Work::Draw { .. })
    }

    /// The name.
    #[must_use]
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// The names of what it reads: in the order of its bindings, then attributes and indices of vertices.
    pub(crate) fn reads(&self) -> impl Iterator<Item = &str> {
        self.reads.iter().map(|used| used.name.as_str()).chain(self.fetched())
    }

    /// The buffers that vertices come from.
    pub(crate) fn fetched(&self) -> impl Iterator<Item = &str> {
        let (attributes, indices) = match &self.work {
            Work::Draw { attributes, indices, .. } => (attributes.as_slice(), indices.as_deref()),
            Work::Compute { .. } => (&[][..], None),
        };
        attributes.iter().map(String::as_str).chain(indices)
    }

    /// The names of what it writes.
    pub(crate) fn writes(&self) -> impl Iterator<Item = &str> {
        self.writes.iter().map(|used| used.name.as_str())
    }
}
