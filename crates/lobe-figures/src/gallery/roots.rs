//! The real roots of a polynomial of degree up to four in an interval.

/// Newton steps, bisections among them. Beside a double root each step halves the distance, so 60 reach rounding.
const STEPS: usize = 100;

/// The difference of two Newton iterates at which the root is found, as a part of the interval's larger end.
const TOLERANCE: f64 = 2.0 * f64::EPSILON;

/// Up to four numbers in rising order.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Roots {
    values: [f64; 4],
    count: usize,
}

impl Roots {
    pub(crate) fn as_slice(&self) -> &[f64] {
        &self.values[..self.count]
    }

    fn push(&mut self, root: f64) {
        if let Some(place) = self.values.get_mut(self.count) {
            *place = root;
            self.count += 1;
        }
    }
}

/// The roots of `c₀ + c₁ t + c₂ t² + ..` between `low` and `high`, each once, in rising order.
///
/// Bracketing: between two roots of the derivative the polynomial is monotone, so there is one root where its signs at
/// the ends differ, and none elsewhere. The derivative's roots come the same way, down to the straight line. Nothing is
/// divided by a leading coefficient and no case is told from another, so a quartic that is nearly a cubic needs no
/// care. A double root is found if rounding does not lift it off zero.
///
/// # Panics
/// If there are more than five coefficients.
pub(crate) fn roots_between(c: &[f64], low: f64, high: f64) -> Roots {
    assert!(c.len() <= 5, "degree {} is above 4", c.len());
    let mut roots = Roots::default();
    if c.len() < 2 {
        return roots;
    }
    // Find the turning points: the roots of the derivative.
    let mut slope = [0.0; 4];
    for k in 1..c.len() {
        slope[k - 1] = k as f64 * c[k];
    }
    let slope = &slope[..c.len() - 1];
    let turns = roots_between(slope, low, high);
    // Find the root between each two of them where the sign changes.
    let (mut from, mut at_from) = (low, eval(c, low));
    for &to in turns.as_slice().iter().chain([&high]) {
        let at_to = eval(c, to);
        if at_from == 0.0 {
            roots.push(from);
        } else if at_to != 0.0 && (at_from < 0.0) != (at_to < 0.0) {
            roots.push(refine(c, slope, from, to));
        }
        (from, at_from) = (to, at_to);
    }
    if at_from == 0.0 {
        roots.push(from);
    }
    roots
}

/// `c₀ + c₁ t + ..` by Horner's rule.
fn eval(c: &[f64], t: f64) -> f64 {
    c.iter().rev().fold(0.0, |sum, c| sum * t + c)
}

/// The root between two ends of different sign: Newton's method, and bisection where it would leave the bracket.
fn refine(c: &[f64], slope: &[f64], low: f64, high: f64) -> f64 {
    let rising = eval(c, low) < 0.0;
    let tolerance = TOLERANCE * low.abs().max(high.abs());
    let (mut low, mut high) = (low, high);
    let mut t = 0.5 * (low + high);
    for _ in 0..STEPS {
        let value = eval(c, t);
        if (value < 0.0) == rising {
            low = t;
        } else {
            high = t;
        }
        let newton = t - value / eval(slope, t);
        let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
        if (next - t).abs() <= tolerance {
            return next;
        }
        t = next;
    }
    t
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    /// The coefficients of `Π (t - root)`.
    fn with_roots(roots: &[f64]) -> Vec<f64> {
        roots.iter().fold(vec![1.0], |c, root| {
            let shifted = |k: usize| if k > 0 { c[k - 1] } else { 0.0 };
            (0..=c.len()).map(|k| shifted(k) - root * c.get(k).unwrap_or(&0.0)).collect()
        })
    }

    #[test]
    fn planted_roots_are_found_in_order() {
        let mut random = Random::new(5);
        for degree in 1..=4 {
            for _ in 0..200 {
                let mut planted: Vec<f64> = (0..degree).map(|_| 2.0 * random.signed()).collect();
                planted.sort_by(f64::total_cmp);
                if planted.windows(2).any(|w| w[1] - w[0] < 0.01) {
                    continue;
                }
                let inside: Vec<f64> = planted.iter().copied().filter(|t| t.abs() < 1.5).collect();
                let found = roots_between(&with_roots(&planted), -1.5, 1.5);
                assert_eq!(found.count, inside.len(), "planted {planted:?}, found {found:?}");
                for (a, b) in found.as_slice().iter().zip(&inside) {
                    // Rounding of the coefficients, over the distance to the other roots.
                    assert!((a - b).abs() < 1e-9, "planted {planted:?}, found {found:?}");
                }
            }
        }
    }

    #[test]
    fn roots_at_the_ends_and_double_roots_count_once() {
        let ends = roots_between(&with_roots(&[-1.0, 1.0]), -1.0, 1.0);
        assert_eq!(ends.as_slice(), [-1.0, 1.0], "roots at both ends");
        let double = roots_between(&with_roots(&[0.5, 0.5]), -1.0, 1.0);
        assert_eq!(double.as_slice(), [0.5], "a double root");
        assert!(roots_between(&[1.0, 0.0, 1.0], -9.0, 9.0).as_slice().is_empty(), "t² + 1 has none");
        assert!(roots_between(&[3.0], -1.0, 1.0).as_slice().is_empty(), "a constant has none");
    }
}
