//! Enumerations of the library on the command line.

/// Declares the values of an option, each with its help; they stand for the variants of `target` of the same names.
macro_rules! names {
    ($(#[$attr:meta])* $vis:vis enum $name:ident for $target:ident { $($(#[$help:meta])* $variant:ident,)+ }) => {
        $(#[$attr])*
        #[derive(Clone, Copy, Debug, PartialEq, clap::ValueEnum)]
        $vis enum $name {
            $($(#[$help])* $variant,)+
        }

        impl From<$name> for $target {
            fn from(name: $name) -> Self {
                match name {
                    $($name::$variant => Self::$variant,)+
                }
            }
        }
    };
}

pub(crate) use names;
