//! Mappings between directions and points of a picture.

use lobe_sh::Dir;

use crate::mapping::angular;
use crate::mapping::azimuthal::{Frame, Profile};
use crate::mapping::cube;
use crate::mapping::dual_paraboloid;
use crate::mapping::equal_area;
use crate::mapping::lat_long;
use crate::mapping::mirror_ball;
use crate::mapping::octahedral;

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
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Mapping {
    /// Longitude across, latitude down: [`lat_long`].
    LatLong,
    /// OpenGL's sphere map: [`mirror_ball`].
    Sphere,
    /// The photograph of a mirror ball: [`mirror_ball`].
    MirrorBall,
    /// The light probe: [`angular`].
    Angular,
    /// Two parabolic mirrors: [`dual_paraboloid`].
    DualParaboloid,
    /// The unfolded octahedron: [`octahedral`].
    Octahedral,
    /// The unfolded octahedron, every texel of the same solid angle: [`equal_area`].
    EqualArea,
    /// Six faces below each other, six times as high as wide: [`cube`].
    Cube,
}

impl Mapping {
    /// All mappings.
    pub const ALL: [Self; 8] = [
        Self::LatLong,
        Self::Sphere,
        Self::MirrorBall,
        Self::Angular,
        Self::DualParaboloid,
        Self::Octahedral,
        Self::EqualArea,
        Self::Cube,
    ];

    /// The name on a command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::LatLong => "lat-long",
            Self::Sphere => "sphere",
            Self::MirrorBall => "mirror-ball",
            Self::Angular => "angular",
            Self::DualParaboloid => "dual-paraboloid",
            Self::Octahedral => "octahedral",
            Self::EqualArea => "equal-area",
            Self::Cube => "cube",
        }
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
        match self {
            Self::LatLong | Self::DualParaboloid => width.div_ceil(2),
            Self::Cube => cube::FACES * width,
            _ => width,
        }
    }

    /// The direction of the point `(u, v)` of the picture, both in `[0, 1]`; `None` outside the discs of a round
    /// picture.
    #[must_use]
    pub fn dir_from_uv(self, u: f64, v: f64) -> Option<Dir> {
        match self {
            Self::LatLong => Some(lat_long::dir_from_uv(u, v)),
            Self::Sphere => mirror_ball::sphere_dir_from_uv(u, v),
            Self::MirrorBall => mirror_ball::dir_from_uv(u, v),
            Self::Angular => angular::dir_from_uv(u, v),
            Self::DualParaboloid => dual_paraboloid::dir_from_uv(u, v),
            Self::Octahedral => Some(octahedral::dir_from_uv(u, v)),
            Self::EqualArea => Some(equal_area::dir_from_uv(u, v)),
            Self::Cube => Some(cube::dir_from_uv(u, v)),
        }
    }

    /// The point `(u, v)` of the picture in the direction `s`, both in `[0, 1]`.
    #[must_use]
    pub fn uv_from_dir(self, s: Dir) -> (f64, f64) {
        match self {
            Self::LatLong => lat_long::uv_from_dir(s),
            Self::Sphere => mirror_ball::sphere_uv_from_dir(s),
            Self::MirrorBall => mirror_ball::uv_from_dir(s),
            Self::Angular => angular::uv_from_dir(s),
            Self::DualParaboloid => dual_paraboloid::uv_from_dir(s),
            Self::Octahedral => octahedral::uv_from_dir(s),
            Self::EqualArea => equal_area::uv_from_dir(s),
            Self::Cube => cube::uv_from_dir(s),
        }
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
        match self {
            Self::LatLong => lat_long::solid_angle(width, height, y),
            Self::Sphere | Self::MirrorBall => mirror_ball::solid_angle(width, height, x, y),
            Self::Angular => angular::solid_angle(width, height, x, y),
            Self::DualParaboloid => dual_paraboloid::solid_angle(width, height, x, y),
            Self::Octahedral => octahedral::solid_angle(width, height, x, y),
            Self::EqualArea => equal_area::solid_angle(width, height),
            Self::Cube => {
                assert!(height == cube::FACES * width, "six faces of {width} x {width} are not {width} x {height}");
                cube::solid_angle(width, x, y % width)
            }
        }
    }

    /// The solid angle per area `du dv` at the point `(u, v)`; meaningless outside the discs of a round picture.
    pub(crate) fn density(self, u: f64, v: f64) -> f64 {
        use std::f64::consts::PI;
        match self {
            Self::LatLong => 2.0 * PI * PI * lat_long::sin_cos_pi(v).0,
            Self::Octahedral => octahedral::density(u, v),
            Self::EqualArea => 4.0 * PI,
            Self::Cube => cube::density(u, v),
            Self::Sphere | Self::MirrorBall | Self::Angular => {
                let r = (2.0 * u - 1.0).hypot(2.0 * v - 1.0).min(1.0);
                let profile = if self == Self::Angular { Profile::Angular } else { Profile::Ball };
                4.0 * profile.density(r)
            }
            Self::DualParaboloid => {
                let offset = if u < 0.5 { 1.0 } else { 3.0 };
                8.0 * Profile::Paraboloid.density((4.0 * u - offset).hypot(2.0 * v - 1.0).min(1.0))
            }
        }
    }

    /// The solid angle per area `du dv` in the direction `s`: [`density`](Self::density) without angles where possible.
    #[inline]
    pub(crate) fn density_towards(self, s: Dir) -> f64 {
        use std::f64::consts::PI;
        let (x, y, z) = (s.x().abs(), s.y().abs(), s.z().abs());
        match self {
            Self::LatLong => 2.0 * PI * PI * (x * x + y * y).sqrt(),
            Self::EqualArea => 4.0 * PI,
            // The point of the octahedron or the cube is at the distance 1/(|x| + |y| + |z|) or 1/max.
            Self::Octahedral => 4.0 * (x + y + z).powi(3),
            Self::Cube => 24.0 * x.max(y).max(z).powi(3),
            Self::Sphere | Self::MirrorBall => 16.0,
            // 1 + |p|² = 2/(1 + |x|).
            Self::DualParaboloid => 8.0 * (1.0 + x) * (1.0 + x),
            Self::Angular => {
                let (u, v) = self.uv_from_dir(s);
                self.density(u, v)
            }
        }
    }

    /// The profile and the frame of a mapping of one disc that fills the picture.
    pub(crate) fn single_disc(self) -> Option<(Profile, &'static Frame)> {
        match self {
            Self::Sphere => Some((Profile::Ball, &mirror_ball::SPHERE)),
            Self::MirrorBall => Some((Profile::Ball, &mirror_ball::MIRROR_BALL)),
            Self::Angular => Some((Profile::Angular, &angular::FRAME)),
            _ => None,
        }
    }
}

impl std::fmt::Display for Mapping {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}
