//! The basis for several directions side by side.

use std::f64::consts::PI;

use crate::field::lanes::{LANES, Lanes};

/// The values of the basis in one direction of each lane.
///
/// ```text
///   y_l^m = √2 P_l^m(z) C_m,   y_l^-m = √2 P_l^m(z) S_m,   y_l^0 = P_l^0(z)        C_m + i S_m = (x + iy)^m
///   P_0^0 = 1/√(4π),   P_m^m = -√((2m+1)/2m) P_{m-1}^{m-1},   P_l^m = a (z P_{l-1}^m - b P_{l-2}^m)
///   a = √((4l² - 1)/(l² - m²)),   b = √(((l-1)² - m²)/(4(l-1)² - 1))
/// ```
///
/// `lobe_sh::Basis` evaluates sixteen directions at once, and fewer one by one.
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
    pub(crate) fn for_each(&self, [x, y, z]: [Lanes<f32>; 3], mut emit: impl FnMut(usize, usize, Lanes<f32>)) {
        let splat = |s: f32| Lanes([s; LANES]);
        let (mut cos, mut sin) = (splat(1.0), splat(0.0));
        let mut steps = self.steps.iter();
        for m in 0..self.order {
            let (mut before, mut p) = (splat(0.0), splat(self.diagonal[m]));
            for l in m..self.order {
                let middle = l * (l + 1);
                emit(l, middle + m, p * cos);
                if m > 0 {
                    emit(l, middle - m, p * sin);
                }
                if l + 1 < self.order
                    && let Some([a, ab]) = steps.next()
                {
                    (before, p) = (p, splat(*a) * z * p - splat(*ab) * before);
                }
            }
            (cos, sin) = (x * cos - y * sin, x * sin + y * cos);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lobe_sh::{Dir, eval_basis};
    use lobe_testkit::directions;

    #[test]
    fn every_lane_is_the_basis_in_its_direction() {
        for order in 1..=8 {
            for four in directions().chunks_exact(LANES) {
                let axis = |k: usize| Lanes(std::array::from_fn(|lane| four[lane][k] as f32));
                let mut found = vec![Lanes([0.0; LANES]); order * order];
                LaneBasis::new(order).for_each([axis(0), axis(1), axis(2)], |l, i, y| {
                    assert!((l * l..(l + 1) * (l + 1)).contains(&i), "band {l} has no function {i}");
                    found[i] = y;
                });
                for lane in 0..LANES {
                    for (i, y) in eval_basis(Dir::from_unit(four[lane]), order).into_iter().enumerate() {
                        let off = (f64::from(found[i].0[lane]) - y).abs();
                        assert!(off < 5e-6, "order {order}, {:?}, {i}: off by {off}", four[lane]);
                    }
                }
            }
        }
    }
}
