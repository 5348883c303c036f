//! The types of the numbers of a glTF accessor.

use gltf_json::accessor::ComponentType;

/// The type of a component. Half floats are no part of glTF 2.0, and some programs write attributes of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F16,
    F32,
}

/// The number of half floats: OpenGL's `HALF_FLOAT`.
const HALF_FLOAT: u64 = 5131;

impl Component {
    /// The type of an accessor: what glTF knows, or else the number that the file says.
    pub(crate) fn of(known: Option<ComponentType>, said: Option<u64>) -> Option<Self> {
        match known {
            Some(known) => Some(known.into()),
            None => (said == Some(HALF_FLOAT)).then_some(Self::F16),
        }
    }

    /// Its bytes.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 | Self::F16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    pub(crate) fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32)
    }
}

impl From<ComponentType> for Component {
    fn from(known: ComponentType) -> Self {
        match known {
            ComponentType::I8 => Self::I8,
            ComponentType::U8 => Self::U8,
            ComponentType::I16 => Self::I16,
            ComponentType::U16 => Self::U16,
            ComponentType::U32 => Self::U32,
            ComponentType::F32 => Self::F32,
        }
    }
}
