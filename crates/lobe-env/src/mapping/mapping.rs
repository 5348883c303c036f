//! Mappings between directions and points of a picture.

use lobe_sh::Dir;

use crate::mapping::form::Form;
use crate::mapping::{angular, cube, dual_paraboloid, equal_area, lat_long, mirror_ball, octahedral};

/// The table of the mappings: each is an entry here, and a file that holds its [`Form`].
macro_rules! mappings {
    ($(#[$attr:meta])* pub enum $mapping:ident { $($(#[$doc:meta])* $name:ident = $form:expr,)+ }) => {
        $(#[$attr])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[non_exhaustive]
        pub enum $mapping {
            $($(#[$doc])* $name,)+
        }

        impl $mapping {
            /// All mappings.
            pub const ALL: [Self; [$(stringify!($name)),+].len()] = [$(Self::$name),+];

            #[inline]
            pub(crate) fn form(self) -> &'static dyn Form {
                match self {
                    $(Self::$name => &$form,)+
                }
            }
        }
    };
}

mappings! {
    /// A mapping of the sphere to a picture. The module of each mapping has its unfolded figure.
    ///
    /// Each consists of [`dir_from_uv`](Mapping::dir_from_uv), [`uv_from_dir`](Mapping::uv_from_dir) and
    /// [`solid_angle`](Mapping::solid_angle), with `u` from the left edge to the right and `v` from the top down.
    ///
    /// ```
    /// use lobe_env::Mapping;
    /// use lobe_sh::Dir;
    ///
    /// for mapping in Mapping::ALL {
    ///     let s = Dir::from_angles(0.7, 0.4);
    ///     let (u, v) = mapping.uv_from_dir(s);
    ///     assert!(mapping.dir_from_uv(u, v).is_some_and(|back| back.angle_to(s) < 1e-12));
    /// }
    /// ```
    pub enum Mapping {
        /// Longitude across, latitude down: [`lat_long`].
        LatLong = lat_long::LatLong,
        /// OpenGL's sphere map: [`mirror_ball`].
        Sphere = mirror_ball::SPHERE,
        /// The photograph of a mirror ball: [`mirror_ball`].
        MirrorBall = mirror_ball::MIRROR_BALL,
        /// The light probe: [`angular`].
        Angular = angular::ANGULAR,
        /// Two parabolic mirrors: [`dual_paraboloid`].
        DualParaboloid = dual_paraboloid::DUAL_PARABOLOID,
        /// The unfolded octahedron: [`octahedral`].
        Octahedral = octahedral::Octahedral,
        /// The unfolded octahedron, every texel of the same solid angle: [`equal_area`].
        EqualArea = equal_area::EqualArea,
        /// Six faces below each other, six times as high as wide: [`cube`].
        Cube = cube::Cube,
    }
}

impl Mapping {
    /// The name on a command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.form().name()
    }

    /// What the picture shows, in a line for help pages.
    #[must_use]
    pub fn description(self) -> &'static str {
        self.form().description()
    }

    /// The mapping of a [`name`](Mapping::name).
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|mapping| mapping.name() == name)
    }

    /// The height that goes with a width, such that texels are about as high as wide; `width / 2` rounded up for the
    /// mappings that are twice as wide as high.
    #[must_use]
    pub fn height_for(self, width: usize) -> usize {
        let [across, down] = self.form().aspect();
        width.saturating_mul(down).div_ceil(across)
    }

    /// Width and height of a picture, of a cube that of all faces, whose height, or the side of whose faces, is `size`.
    #[must_use]
    pub fn picture_size(self, size: usize) -> [usize; 2] {
        self.form().aspect().map(|count| count.saturating_mul(size))
    }

    /// The number of squares below each other, each a picture of its own: 6 for a cube, 1 for others.
    #[must_use]
    pub fn faces(self) -> usize {
        self.form().faces()
    }

    /// Axes that the picture shows again elsewhere than [`uv_from_dir`](Self::uv_from_dir) says, by their names, `+x` to `-z`,
    /// and the point `(u, v)` of each: a label may stand there, too.
    #[must_use]
    pub fn axes_again(self) -> &'static [(&'static str, [f64; 2])] {
        self.form().axes_again()
    }

    /// The direction of the point `(u, v)` of the picture, both in `[0, 1]`; `None` outside the discs of a round
    /// picture.
    #[inline]
    #[must_use]
    pub fn dir_from_uv(self, u: f64, v: f64) -> Option<Dir> {
        self.form().dir_from_uv(u, v)
    }

    /// The point `(u, v)` of the picture in the direction `s`, both in `[0, 1]`.
    #[inline]
    #[must_use]
    pub fn uv_from_dir(self, s: Dir) -> (f64, f64) {
        self.form().uv_from_dir(s)
    }

    /// The solid angle in steradian of texel `(x, y)` of a picture of `width` x `height` texels, exact to rounding.
    ///
    /// Over all texels the sum is `4π` (test `solid_angles_of_every_mapping_and_size_sum_to_the_whole_sphere`).
    ///
    /// # Panics
    /// If there is no such texel, or a cube's picture is not six times as high as wide.
    #[must_use]
    pub fn solid_angle(self, width: usize, height: usize, x: usize, y: usize) -> f64 {
        assert!(x < width && y < height, "no texel ({x}, {y}) in a picture of {width} x {height}");
        self.form().solid_angle([width, height], [x, y])
    }
}

impl std::fmt::Display for Mapping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
