//! glTF accessors: arrays of numbers in buffers. Nothing is allocated before its length was checked against a buffer,
//! or without one against the limit of vertices.

use gltf_json::accessor::{Accessor, Type};
use gltf_json::{Index, buffer, validation::Checked};
use half::f16;

use crate::error::SceneError;
use crate::files::gltf::component::Component;
use crate::files::gltf::files::GltfFile;
use crate::files::source::Source;

/// An array within a buffer whose bytes are known to exist.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    count: usize,
    component: Component,
    components: usize,
    normalized: bool,
}

/// The one element of an accessor without a buffer view: at most sixteen floats.
static ZEROS: [u8; 64] = [0; 64];

/// The numbers of a 4 × 4 matrix, the largest element.
const MOST_COMPONENTS: usize = 16;

/// The accessors of a file, with the place for error messages.
pub(crate) struct Accessors<'a> {
    pub(crate) file: &'a GltfFile,
    /// The place for messages: `mesh 0, primitive 1`.
    pub(crate) place: String,
}

impl<'a> Accessors<'a> {
    fn invalid(&self, source: &Source<'_>, message: &str) -> SceneError {
        source.invalid(format!("{}: {message}", self.place))
    }

    fn accessor(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<&'a Accessor, SceneError> {
        let count = self.file.root.accessors.len();
        self.file
            .root
            .accessors
            .get(index.value())
            .ok_or_else(|| self.invalid(source, &format!("uses accessor {}, but there are {count}", index.value())))
    }

    /// The number of elements of an accessor.
    pub(crate) fn count(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<usize, SceneError> {
        let accessor = self.accessor(index, source)?;
        // Checked against the buffer before anything of this size is allocated.
        self.elements(accessor, index.value(), source).map(|elements| elements.count)
    }

    /// An attribute of `N` numbers for each vertex. A color may have three, and the cluster of a vertex may be one: the
    /// others are then 1.
    pub(crate) fn vectors<const N: usize>(
        &self,
        what: &str,
        index: Index<Accessor>,
        source: &Source<'_>,
    ) -> Result<Vec<[f32; N]>, SceneError> {
        let accessor = self.accessor(index, source)?;
        let elements = self.elements(accessor, index.value(), source)?;
        let may_be_whole = self.may_be_whole(what, elements.normalized);
        let has_default = N == 4
            && match elements.components {
                3 => what.starts_with("COLOR"),
                1 => what == "_CLUSTER",
                _ => false,
            };
        let is_float = elements.component.is_float();
        if !(elements.components == N || has_default) || !(is_float || may_be_whole) {
            let (components, component) = (elements.components, elements.component);
            let is_raw = !elements.normalized && matches!(what, "ROTATION" | "WEIGHTS") && !is_float;
            let raw = if is_raw { " that is not normalized" } else { "" };
            let message = format!("expected vectors of {N} floats as {what}, found {components} x {component:?}{raw}");
            return Err(self.invalid(source, &message));
        }
        let mut values = vec![[1.0; N]; elements.count];
        for (i, value) in values.iter_mut().enumerate() {
            for (k, c) in value.iter_mut().enumerate().take(elements.components) {
                *c = elements.float(i, k);
            }
        }
        self.overwrite(accessor, &mut values, &elements, source, |elements, i| {
            std::array::from_fn(|k| if k < elements.components { elements.float(i, k) } else { 1.0 })
        })?;
        Ok(values)
    }

    /// Whether an attribute, or the values of an animation, may be whole numbers: fractions of their largest value, or with
    /// `KHR_mesh_quantization` positions, normals, tangents and texture coordinates as they are. Vertex weights and colors that are not
    /// said to be fractions are taken as they are too: weights are divided by their sum, colors clamped. Transfer is
    /// within -1 and 1 where a program has made fractions of it.
    fn may_be_whole(&self, what: &str, is_normalized: bool) -> bool {
        let is_one_of = |names: &[&str]| names.iter().any(|name| what.starts_with(name));
        let is_quantized = || self.file.root.extensions_used.iter().any(|name| name == "KHR_mesh_quantization");
        match what {
            "ROTATION" | "WEIGHTS" => is_normalized,
            _ if what.starts_with("_TRANSFER_") => is_normalized,
            _ if is_one_of(&["TEXCOORD", "COLOR", "WEIGHTS_", "_CLUSTER", "_WEIGHTS"]) => true,
            _ => is_one_of(&["POSITION", "NORMAL", "TANGENT"]) && is_quantized(),
        }
    }

    /// The indices of a primitive.
    pub(crate) fn indices(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<Vec<u32>, SceneError> {
        let accessor = self.accessor(index, source)?;
        let elements = self.elements(accessor, index.value(), source)?;
        let is_unsigned = matches!(elements.component, Component::U8 | Component::U16 | Component::U32);
        if elements.components != 1 || !is_unsigned {
            let (components, component) = (elements.components, elements.component);
            let message = format!("expected unsigned whole numbers as indices, found {components} x {component:?}");
            return Err(self.invalid(source, &message));
        }
        let mut values: Vec<u32> = (0..elements.count).map(|i| elements.whole(i)).collect();
        self.overwrite(accessor, &mut values, &elements, source, Elements::whole)?;
        Ok(values)
    }

    /// The joints of each vertex, four of a set.
    pub(crate) fn joints(
        &self,
        what: &str,
        index: Index<Accessor>,
        source: &Source<'_>,
    ) -> Result<Vec<[u16; 4]>, SceneError> {
        let accessor = self.accessor(index, source)?;
        let elements = self.elements(accessor, index.value(), source)?;
        if elements.components != 4 || !matches!(elements.component, Component::U8 | Component::U16) {
            let (components, component) = (elements.components, elements.component);
            let message =
                format!("expected four bytes or shorts, unsigned, as {what}, found {components} x {component:?}");
            return Err(self.invalid(source, &message));
        }
        let joints = |elements: &Elements<'_>, i: usize| std::array::from_fn(|k| elements.whole_at(i, k) as u16);
        let mut values: Vec<[u16; 4]> = (0..elements.count).map(|i| joints(&elements, i)).collect();
        self.overwrite(accessor, &mut values, &elements, source, joints)?;
        Ok(values)
    }

    /// The bytes of an element of an accessor.
    pub(crate) fn size(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<usize, SceneError> {
        let accessor = self.accessor(index, source)?;
        self.elements(accessor, index.value(), source).map(|elements| elements.size())
    }

    /// The bytes of all elements side by side.
    pub(crate) fn packed(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<Vec<u8>, SceneError> {
        let accessor = self.accessor(index, source)?;
        let elements = self.elements(accessor, index.value(), source)?;
        let mut values: Vec<&[u8]> = (0..elements.count).map(|i| elements.raw(i)).collect();
        self.overwrite(accessor, &mut values, &elements, source, Elements::raw)?;
        Ok(values.concat())
    }

    /// All numbers of an accessor as floats, one element after the other, and how many each has.
    pub(crate) fn floats(&self, index: Index<Accessor>, source: &Source<'_>) -> Result<(Vec<f32>, usize), SceneError> {
        let accessor = self.accessor(index, source)?;
        let elements = self.elements(accessor, index.value(), source)?;
        let row = |elements: &Elements<'_>, i: usize| -> [f32; MOST_COMPONENTS] {
            std::array::from_fn(|k| if k < elements.components { elements.float(i, k) } else { 0.0 })
        };
        let mut rows: Vec<_> = (0..elements.count).map(|i| row(&elements, i)).collect();
        self.overwrite(accessor, &mut rows, &elements, source, row)?;
        let numbers = rows.iter().flat_map(|row| &row[..elements.components]).copied().collect();
        Ok((numbers, elements.components))
    }

    /// The bytes of an accessor.
    fn elements(&self, accessor: &Accessor, index: usize, source: &Source<'_>) -> Result<Elements<'a>, SceneError> {
        let known = match accessor.component_type {
            Checked::Valid(known) => Some(known.0),
            Checked::Invalid => None,
        };
        let component = Component::of(known, self.file.json["accessors"][index]["componentType"].as_u64());
        let (Some(component), Checked::Valid(kind)) = (component, accessor.type_) else {
            return Err(self.invalid(source, &format!("accessor {index} is of no type that glTF knows")));
        };
        let Some(view) = accessor.buffer_view else {
            let (count, components) = (accessor.count.0 as usize, components_of(kind));
            source.check_limit(count, 0)?;
            let normalized = accessor.normalized;
            return Ok(Elements { bytes: &ZEROS, stride: 0, count, component, components, normalized });
        };
        let offset = accessor.byte_offset.unwrap_or_default().0;
        let layout = Layout { component, components: components_of(kind), count: accessor.count.0, offset };
        let elements = layout.find(self.file, view, accessor.normalized);
        elements.map_err(|message| self.invalid(source, &format!("accessor {index}: {message}")))
    }

    /// Writes the exceptions of a sparse accessor to `values`.
    fn overwrite<T>(
        &self,
        accessor: &Accessor,
        values: &mut [T],
        base: &Elements<'a>,
        source: &Source<'_>,
        element: impl Fn(&Elements<'a>, usize) -> T,
    ) -> Result<(), SceneError> {
        let Some(sparse) = &accessor.sparse else { return Ok(()) };
        let Checked::Valid(index_type) = sparse.indices.component_type else {
            return Err(self.invalid(source, "a sparse accessor has indices of no type that glTF knows"));
        };
        let (count, offset) = (sparse.count.0, sparse.indices.byte_offset.0);
        let places = Layout { component: index_type.0.into(), components: 1, count, offset };
        let places = places.find(self.file, sparse.indices.buffer_view, false);
        let offset = sparse.values.byte_offset.0;
        let replaced = Layout { component: base.component, components: base.components, count, offset };
        let replaced = replaced.find(self.file, sparse.values.buffer_view, base.normalized);
        let wrong = |message: String| self.invalid(source, &format!("sparse accessor: {message}"));
        let (places, replaced) = (places.map_err(wrong)?, replaced.map_err(wrong)?);
        for i in 0..places.count {
            let (place, all) = (places.whole(i) as usize, values.len());
            let Some(value) = values.get_mut(place) else {
                return Err(wrong(format!("replaces element {place}, but there are {all}")));
            };
            *value = element(&replaced, i);
        }
        Ok(())
    }
}

/// The layout of an accessor's bytes.
struct Layout {
    component: Component,
    components: usize,
    count: u64,
    offset: u64,
}

impl Layout {
    /// The bytes, if the buffer view and its buffer hold all of them.
    fn find<'a>(
        &self,
        file: &'a GltfFile,
        view: Index<buffer::View>,
        normalized: bool,
    ) -> Result<Elements<'a>, String> {
        let bytes = view_bytes(file, view)?;
        let view = &file.root.buffer_views[view.value()];
        let size = self.component.size() * self.components;
        let stride = view.byte_stride.map_or(size, |stride| stride.0);
        if stride < size {
            return Err(format!("elements of {size} bytes stand only {stride} apart"));
        }
        let available = bytes.len() as u64;
        let end = match self.count {
            0 => Some(self.offset),
            n => {
                let last = (n - 1).checked_mul(stride as u64).and_then(|e| e.checked_add(size as u64));
                last.and_then(|e| e.checked_add(self.offset))
            }
        };
        match end {
            Some(end) if end <= available => {}
            _ => return Err(format!("{} elements do not fit into a buffer view of {available} bytes", self.count)),
        }
        Ok(Elements {
            bytes: &bytes[self.offset as usize..],
            stride,
            count: self.count as usize,
            component: self.component,
            components: self.components,
            normalized,
        })
    }
}

/// The bytes of a buffer view.
pub(crate) fn view_bytes(file: &GltfFile, view: Index<buffer::View>) -> Result<&[u8], String> {
    let buffer_views = &file.root.buffer_views;
    let index = view.value();
    let Some(view) = buffer_views.get(index) else {
        return Err(format!("uses buffer view {index}, but there are {}", buffer_views.len()));
    };
    let Some(buffer) = file.buffers.get(view.buffer.value()) else {
        let (buffer, count) = (view.buffer.value(), file.buffers.len());
        return Err(format!("buffer view {index} lies in buffer {buffer}, but there are {count}"));
    };
    let (start, length) = (view.byte_offset.unwrap_or_default().0, view.byte_length.0);
    let range = start.checked_add(length).and_then(|end| buffer.get(start as usize..usize::try_from(end).ok()?));
    range.ok_or_else(|| {
        format!("buffer view {index} of {length} bytes from {start} does not fit into {} bytes", buffer.len())
    })
}

fn components_of(kind: Type) -> usize {
    match kind {
        Type::Scalar => 1,
        Type::Vec2 => 2,
        Type::Vec3 => 3,
        Type::Vec4 | Type::Mat2 => 4,
        Type::Mat3 => 9,
        Type::Mat4 => 16,
    }
}

impl<'a> Elements<'a> {
    /// The bytes of an element.
    fn size(&self) -> usize {
        self.component.size() * self.components
    }

    fn raw(&self, element: usize) -> &'a [u8] {
        &self.bytes[element * self.stride..][..self.size()]
    }

    fn bytes<const N: usize>(&self, element: usize, component: usize) -> [u8; N] {
        let start = element * self.stride + component * N;
        std::array::from_fn(|k| self.bytes[start + k])
    }

    fn whole(&self, element: usize) -> u32 {
        self.whole_at(element, 0)
    }

    fn whole_at(&self, element: usize, component: usize) -> u32 {
        match self.component {
            Component::U8 => u32::from(self.bytes::<1>(element, component)[0]),
            Component::U16 => u32::from(u16::from_le_bytes(self.bytes(element, component))),
            _ => u32::from_le_bytes(self.bytes(element, component)),
        }
    }

    /// A component as a float: normalized integers are fractions of their largest value.
    fn float(&self, element: usize, component: usize) -> f32 {
        let (value, largest) = match self.component {
            Component::F32 => return f32::from_le_bytes(self.bytes(element, component)),
            Component::F16 => return f16::from_le_bytes(self.bytes(element, component)).to_f32(),
            Component::I8 => (f64::from(i8::from_le_bytes(self.bytes(element, component))), 127.0),
            Component::U8 => (f64::from(u8::from_le_bytes(self.bytes(element, component))), 255.0),
            Component::I16 => (f64::from(i16::from_le_bytes(self.bytes(element, component))), 32767.0),
            Component::U16 => (f64::from(u16::from_le_bytes(self.bytes(element, component))), 65535.0),
            Component::U32 => (f64::from(u32::from_le_bytes(self.bytes(element, component))), 4294967295.0),
        };
        (if self.normalized { (value / largest).max(-1.0) } else { value }) as f32
    }
}
