//! Form of a mapping: where its picture shows a direction, how large texels are, and where the picture goes on.

use std::f64::consts::PI;
use std::ops::Range;

use lobe_sh::Dir;
use lobe_sh::sphere::vector::Vec3;

use crate::mapping::taps::Taps;

/// Columns and rows of a picture, or the column and the row of a texel.
pub(crate) type Pair = [usize; 2];

/// Gauss-Legendre nodes in `[-1, 1]` and their weights.
pub(crate) type Rule = [(f64, f64)];

/// A mapping, in its own file, and an entry of [`Mapping`](crate::Mapping).
///
/// What most pictures are is the default: one part that fills a square and has no disc.
pub(crate) trait Form: Sync {
    /// The name on a command line.
    fn name(&self) -> &'static str;

    /// What the picture shows, in a line for help pages.
    fn description(&self) -> &'static str;

    /// The direction of a point of the picture; `None` outside the discs.
    fn dir_from_uv(&self, u: f64, v: f64) -> Option<Dir>;

    fn uv_from_dir(&self, s: Dir) -> (f64, f64);

    /// The point of the picture in a direction, to 1e-7: without exact angles.
    #[inline]
    fn fast_uv_from_dir(&self, s: Dir) -> (f64, f64) {
        self.uv_from_dir(s)
    }

    /// The solid angle of a texel of a picture of `size`.
    fn solid_angle(&self, size: Pair, texel: Pair) -> f64;

    /// The solid angle per area `du dv` at a point; meaningless outside the discs.
    fn density(&self, u: f64, v: f64) -> f64;

    /// The same in a direction, without angles where possible.
    fn density_towards(&self, s: Dir) -> f64 {
        let (u, v) = self.uv_from_dir(s);
        self.density(u, v)
    }

    /// Width and height of a picture whose texels are about as high as wide, as a ratio of small numbers.
    fn aspect(&self) -> Pair {
        [1, 1]
    }

    /// Whether readers take a picture of this size for this mapping, if nothing else says what it is.
    fn is_told_by(&self, _size: Pair) -> bool {
        false
    }

    /// The number of squares below each other, each a picture of its own.
    fn faces(&self) -> usize {
        1
    }

    /// The number of discs beside each other that show the sphere; 0 if all of the picture does.
    fn discs(&self) -> usize {
        0
    }

    /// Whether each row has one latitude, and all of its texels one solid angle.
    fn has_rows_of_latitude(&self) -> bool {
        false
    }

    /// The height, or the side of a face, that is usual near a number.
    fn usual_size(&self, size: f64) -> usize {
        (size.round() as usize).max(1)
    }

    /// Axes that the picture shows again elsewhere than [`uv_from_dir`](Self::uv_from_dir) says, and where.
    fn axes_again(&self) -> &'static [(&'static str, [f64; 2])] {
        &[]
    }

    /// The approximate lengths in radians of a texel along its row and its column, with the middle `(u, v)`, towards `center`.
    fn lengths(&self, [width, height]: Pair, [u, v]: [f64; 2], _center: Dir) -> [f64; 2] {
        // Nearly from edge to edge: the middles of the edges may lie on a fold.
        let across = |du: f64, dv: f64| {
            let (a, b) = (self.dir_from_uv(u - du, v - dv), self.dir_from_uv(u + du, v + dv));
            a.zip(b).map_or(PI, |(a, b)| a.angle_to(b))
        };
        [across(0.499 / width as f64, 0.0), across(0.0, 0.499 / height as f64)]
    }

    /// The number of texels in row `y` of `height` that are together as wide as one is high.
    fn texels_across(&self, _height: usize, _y: f64) -> f64 {
        1.0
    }

    /// What bends the interpolation between a row and the next one, so that each has its solid angle: of the fraction `t`
    /// of the way, `bend t (1 - t)` is added.
    fn bend(&self, _height: usize, _row: f64) -> f64 {
        0.0
    }

    /// The range of columns and of rows of the face or the disc with the point `p`, in texels, for single precision: rounding
    /// must not lead to the next one.
    fn limits(&self, [width, height]: Pair, _p: [f64; 2]) -> [[f32; 2]; 2] {
        [[0.0, width as f32], [0.0, height as f32]]
    }

    /// The point of a picture in the direction `s`, in texels from the upper left corner.
    fn point(&self, size: Pair, s: Dir) -> [f64; 2] {
        point_of(size, self.faces(), self.uv_from_dir(s))
    }

    /// The same to 1e-7 of the picture.
    fn fast_point(&self, size: Pair, s: Dir) -> [f64; 2] {
        point_of(size, self.faces(), self.fast_uv_from_dir(s))
    }

    /// The taps of the value in the direction `s`.
    fn taps_towards(&self, size: Pair, s: Dir) -> Taps {
        let [x, y] = self.point(size, s);
        self.taps(size, [x, bent(y, self.bend(size[1], (y - 0.5).floor()))])
    }

    /// The taps of the value at the point `p`, in texels. Beyond an edge the picture continues with the texels that are
    /// neighbors on the sphere.
    fn taps(&self, size: Pair, p: [f64; 2]) -> Taps;

    /// The range of columns and rows around the point `p` in which the four texels around each point are neighbors in
    /// the picture; `None` in a picture with rims.
    fn inner_part(&self, [width, height]: Pair, _p: [f64; 2]) -> Option<[[f64; 2]; 2]> {
        Some([between_centers(0, width), between_centers(0, height)])
    }

    /// Adds directions in a texel with their solid angles, by a rule on `[-1, 1]` for each smooth piece of it: folds, poles
    /// and rims lie between pieces. In a disc the first rule goes across the radius, the second along it; elsewhere the
    /// first goes both ways. The sum of the solid angles need not be exact.
    fn add_nodes(&self, size: Pair, texel: Pair, rules: [&Rule; 2], out: &mut Vec<(Dir, f64)>) {
        let side = |k: usize| [0, 1].map(|end| (2.0 * (texel[k] + end) as f64 - size[k] as f64) / size[k] as f64);
        add_rectangle(self, [side(0), side(1)], rules[0], out);
    }

    /// What asks for more nodes of a rule in a texel than its mean solid angle does.
    fn obstacle(&self, _size: Pair, _texel: Pair) -> Option<Obstacle> {
        None
    }

    /// The worst obstacle of a picture.
    fn worst_obstacle(&self, _size: Pair) -> Option<Obstacle> {
        None
    }

    /// The planes that make up the picture, if it does.
    fn planes(&self, _size: Pair) -> Vec<Plane> {
        Vec::new()
    }

    /// The one of the [`planes`](Self::planes), by its number, in which a texel lies as a whole.
    fn plane_of(&self, _size: Pair, _texel: Pair) -> Option<usize> {
        None
    }
}

/// What lets Gauss-Legendre rules over a texel converge slowly.
pub(crate) enum Obstacle {
    /// The texel is long: its extent in the angle to the center of a disc.
    Length(f64),
    /// The mapping is singular at this distance from the middle of the texel, in halves of its side.
    Singularity(f64),
}

/// A part of a picture in which directions are those of the points of a plane: `p = origin + a right + b down`, with `a`
/// and `b` in `[-1, 1]` over the whole of the frame.
pub(crate) struct Plane {
    /// Among those of the picture, for [`Form::plane_of`].
    pub(crate) number: usize,
    pub(crate) origin: Vec3,
    pub(crate) right: Vec3,
    pub(crate) down: Vec3,
    /// The columns and rows of the picture that `[-1, 1]²` spans.
    pub(crate) frame: [Range<usize>; 2],
    /// The columns and rows of whole texels of which the plane has some.
    pub(crate) texels: [Range<usize>; 2],
}

/// The point `(u, v)` of a picture in texels; the product must not round to the next of its faces.
#[inline]
fn point_of([width, height]: Pair, faces: usize, (u, v): (f64, f64)) -> [f64; 2] {
    let (x, y) = (u * width as f64, v * height as f64);
    let next = ((faces as f64 * v) as usize).min(faces - 1) + 1;
    [x, if next < faces { y.min(((next * (height / faces)) as f64).next_down()) } else { y }]
}

/// The row `y` between two centers, bent so that each row has its solid angle in the interpolation.
#[inline]
pub(crate) fn bent(y: f64, bend: f64) -> f64 {
    let t = (y - 0.5) - (y - 0.5).floor();
    y + bend * t * (1.0 - t)
}

/// The range between the centers of the first and the last of some texels.
pub(crate) fn between_centers(start: usize, length: usize) -> [f64; 2] {
    [start as f64 + 0.5, (start + length) as f64 - 0.5]
}

/// Adds the nodes of a product rule in a rectangle of the square `[-1, 1]²` that is the picture.
pub(crate) fn add_rectangle<F: Form + ?Sized>(form: &F, sides: [[f64; 2]; 2], rule: &Rule, out: &mut Vec<(Dir, f64)>) {
    let at = |[a, b]: [f64; 2], t: f64| 0.5 + 0.25 * (a + b + t * (b - a));
    for (a, weight) in rule {
        for (b, inner) in rule {
            let (u, v) = (at(sides[0], *a), at(sides[1], *b));
            if let Some(dir) = form.dir_from_uv(u, v) {
                out.push((dir, weight * inner * form.density(u, v)));
            }
        }
    }
}
