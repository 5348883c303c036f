//! Quadrature nodes over a texel of any mapping.

use lobe_sh::Dir;

use crate::mapping::form::{Pair, Rule};
use crate::mapping::mapping::Mapping;

/// Replaces `out` by directions in a texel with their solid angles, whose sum is the exact one of the texel.
///
/// `rule` is a Gauss-Legendre rule on `[-1, 1]`. It is applied to each smooth piece of the texel: the mapping's folds,
/// poles and rims lie between pieces. Empty for a texel outside the discs of a round picture.
pub(crate) fn nodes_into(mapping: Mapping, size: Pair, texel: Pair, rule: &Rule, out: &mut Vec<(Dir, f64)>) {
    nodes_of_rules_into(mapping, size, texel, [rule; 2], out);
}

/// [`nodes_into`] with one rule across the radius of a disc and another along it; elsewhere the second is not used.
pub(crate) fn nodes_of_rules_into(
    mapping: Mapping,
    size: Pair,
    texel: Pair,
    rules: [&Rule; 2],
    out: &mut Vec<(Dir, f64)>,
) {
    out.clear();
    mapping.form().add_nodes(size, texel, rules, out);
    normalize(out, mapping.solid_angle(size[0], size[1], texel[0], texel[1]));
}

/// Scales the weights to the given sum; the mass of a rim's sliver too thin for the nodes goes nowhere else.
fn normalize(nodes: &mut [(Dir, f64)], sum: f64) {
    let found: f64 = nodes.iter().map(|(_, weight)| weight).sum();
    if found > 0.0 {
        for (_, weight) in nodes {
            *weight *= sum / found;
        }
    }
}
