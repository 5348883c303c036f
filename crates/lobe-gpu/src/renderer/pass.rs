//! A pass: one program, what it reads and what it writes.

use std::ops::Range;

use crate::renderer::drawing::Drawing;
use crate::renderer::kernel::Kernel;

/// A named step of the work of a frame.
#[derive(Clone, Debug)]
pub struct Pass {
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
    /// A compute program over so many items.
    Compute { kernel: Kernel, items: u32 },
    /// So many vertices drawn into the first texture that is written, with the second as depth; with a buffer of indices, those
    /// vertices.
    Draw { drawing: Drawing, vertices: u32, indices: Option<String>, clear: bool },
}

impl Pass {
    pub(crate) fn compute(name: impl Into<String>, kernel: &Kernel, items: u32) -> Self {
        Self::new(name, Work::Compute { kernel: kernel.clone(), items })
    }

    /// A pass that draws `vertices` vertices; with `clear`, after the targets were made black and infinitely far.
    pub(crate) fn draw(name: impl Into<String>, drawing: &Drawing, vertices: u32, clear: bool) -> Self {
        Self::new(name, Work::Draw { drawing: drawing.clone(), vertices, indices: None, clear })
    }

    /// A draw pass whose vertices are those of a buffer of indices.
    pub(crate) fn by_indices(mut self, buffer: &str) -> Self {
        if let Work::Draw { indices, .. } = &mut self.work {
            *indices = Some(buffer.into());
        }
        self
    }

    fn new(name: impl Into<String>, work: Work) -> Self {
        Self { name: name.into(), reads: Vec::new(), writes: Vec::new(), work }
    }

    pub(crate) fn read(mut self, resource: &str) -> Self {
        self.reads.push(Use { name: resource.into(), bytes: None });
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

    /// The pass with another resource in the place of one that it writes.
    pub(crate) fn writing_instead(mut self, was: &str, now: &str) -> Self {
        self.writes.iter_mut().filter(|used| used.name == was).for_each(|used| used.name = now.into());
        self
    }

    /// The name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The names of what it reads, in the order of its bindings.
    pub fn reads(&self) -> impl Iterator<Item = &str> {
        self.reads.iter().map(|used| used.name.as_str())
    }

    /// The names of what it writes.
    pub fn writes(&self) -> impl Iterator<Item = &str> {
        self.writes.iter().map(|used| used.name.as_str())
    }
}
