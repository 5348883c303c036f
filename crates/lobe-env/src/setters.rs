//! Macro for the builder-style setters of options.

/// One setter for each field, with the field's name and this documentation.
macro_rules! setters {
    ($($(#[$doc:meta])* $field:ident: $kind:ty;)*) => {$(
        $(#[$doc])*
        #[must_use]
        pub fn $field(self, $field: $kind) -> Self {
            Self { $field, ..self }
        }
    )*};
}

pub(crate) use setters;
