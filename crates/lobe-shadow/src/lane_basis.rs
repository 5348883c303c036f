//! The basis in lanes: one direction for each receiver.

use std::f64::consts::PI;

use lobe_sh::simd::{Wide, constant};
use pulp::Simd;

/// The values of the basis in one direction of each lane.
///
/// ```text
///   y_l^m = √2 P_l^m(z) C_m,   y_l^-m = √2 P_l^m(z) S_m,   y_l^0 = P_l^0(z)        C_m + i S_m = (x + iy)^m
///   P_0^0 = 1/√(4π),   P_m^m = -√((2m+1)/2m) P_{m-1}^{m-1},   P_l^m = a (z P_{l-1}^m - b P_{l-2}^m)
///   a = √((4l² - 1)/(l² - m²)),   b = √(((l-1)² - m²)/(4(l-1)² - 1))
/// ```
///
/// The plain recurrence, half the operations of the one by differences in [`lobe_sh::basis::Basis`], is within 5e-6 to order 9 (test
/// `every_lane_is_the_basis_in_its_direction`).
#[derive(Clone, Debug)]
pub(crate) struct LaneBasis {
    order: usize,
    /// `P_m^m`, with √2 for `m > 0`.
    diagonal: Vec<f32>,
    /// a and a b, column after column from `l = m + 1` on.
    steps: Vec<[f32; 2]>,
}

impl LaneBasis {
    pub(crate) fn new(order: usize) -> Self {
        let mut diagonal = Vec::with_capacity(order);
        let mut steps = Vec::new();
        let mut p = (4.0 * PI).sqrt().recip();
        for m in 0..order {
            if m > 0 {
                p *= -((2 * m + 1) as f64 / (2 * m) as f64).sqrt();
            }
            diagonal.push((if m > 0 { 2.0_f64.sqrt() * p } else { p }) as f32);
            for l in m + 1..order {
                let square = |x: usize| (x * x) as f64;
                let a = ((4.0 * square(l) - 1.0) / (square(l) - square(m))).sqrt();
                let b = ((square(l - 1) - square(m)) / (4.0 * square(l - 1) - 1.0)).max(0.0).sqrt();
                steps.push([a as f32, (a * b) as f32]);
            }
        }
        Self { order, diagonal, steps }
    }

    /// Calls `emit(l, i, y_i)` for every function.
    #[inline(always)]
    pub(crate) fn for_each<S: Simd>(
        &self,
        simd: S,
        [x, y, z]: [Wide<S>; 3],
        mut emit: impl FnMut(usize, usize, Wide<S>),
    ) {
        let splat = |value| constant(simd, value);
        let (mut cos, mut sin) = (splat(1.0), splat(0.0));
        let mut steps = self.steps.iter();
        for (m, diagonal) in self.diagonal.iter().enumerate() {
            let (mut before, mut p) = (splat(0.0), splat(*diagonal));
            for l in m..self.order {
                let middle = l * (l + 1);
                emit(l, middle + m, p * cos);
                if m > 0 {
                    emit(l, middle - m, p * sin);
                }
                if l + 1 < self.order
                    && let Some([a, ab]) = steps.next()
                {
                    (before, p) = (p, (splat(*a) * z).times_plus(p, splat(-ab) * before));
                }
            }
            (cos, sin) = (x * cos - y * sin, x * sin + y * cos);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::simd::{LANES, Lanes};
    use lobe_sh::{Dir, eval_basis};
    use lobe_testkit::directions;
    use pulp::{Arch, WithSimd};

    struct All<'a> {
        basis: &'a LaneBasis,
        axis: &'a [Lanes; 3],
        out: &'a mut [Lanes],
    }

    impl WithSimd for All<'_> {
        type Output = ();

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let [x, y, z] = self.axis;
            for part in 0..Wide::<S>::PARTS {
                let load = |c| Wide::load(simd, c, part);
                self.basis.for_each(simd, [load(x), load(y), load(z)], |l, i, value| {
                    assert!((l * l..(l + 1) * (l + 1)).contains(&i), "band {l} has no function {i}");
                    value.store(&mut self.out[i], part);
                });
            }
        }
    }

    #[test]
    fn every_lane_is_the_basis_in_its_direction() {
        for order in 1..=9 {
            let basis = LaneBasis::new(order);
            for group in directions().chunks_exact(LANES) {
                let axis = [0, 1, 2].map(|k| Lanes(std::array::from_fn(|lane| group[lane][k] as f32)));
                for arch in [Arch::new(), Arch::Scalar] {
                    let mut found = vec![Lanes::ZERO; order * order];
                    arch.dispatch(All { basis: &basis, axis: &axis, out: &mut found });
                    for lane in 0..LANES {
                        for (i, y) in eval_basis(Dir::from_unit(group[lane]), order).into_iter().enumerate() {
                            let off = (f64::from(found[i][lane]) - y).abs();
                            assert!(off < 5e-6, "order {order}, {:?}, {i}: off by {off}", group[lane]);
                        }
                    }
                }
            }
        }
    }
}
