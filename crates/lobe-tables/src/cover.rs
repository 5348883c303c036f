//! Placement of constants by minimum vertex cover: at the source of a value or at the sum that it goes into.

use std::collections::{BTreeMap, BTreeSet};

/// A value `constant · source` that goes into the sum `sink`. Sources and sinks are numbered from 0 each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Edge {
    pub(crate) source: usize,
    pub(crate) sink: usize,
    pub(crate) constant: f64,
}

/// For each edge, whether its constant multiplies the source.
///
/// Edges with one source share one product `|constant| · source`; edges with one sink share one product
/// `|constant| · (sum of their sources)`. The fewest products that serve all edges of one `|constant|` are a minimum
/// vertex cover of a bipartite graph, which a maximum matching gives (König 1931).
pub(crate) fn multiply_at_source(edges: &[Edge]) -> Vec<bool> {
    let mut of_constant: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (n, edge) in edges.iter().enumerate() {
        of_constant.entry(edge.constant.abs().to_bits()).or_default().push(n);
    }
    let mut at_source = vec![false; edges.len()];
    for group in of_constant.values() {
        let mut sinks: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
        for &n in group {
            sinks.entry(edges[n].source).or_default().push(edges[n].sink);
        }
        let covered = sources_of_minimum_cover(&sinks);
        for &n in group {
            at_source[n] = covered.contains(&edges[n].source);
        }
    }
    at_source
}

/// The sources in a minimum vertex cover; the sinks in it are those of the edges that are left.
fn sources_of_minimum_cover(sinks: &BTreeMap<usize, Vec<usize>>) -> BTreeSet<usize> {
    let mut source_of_sink = BTreeMap::new();
    let unmatched: Vec<usize> = sinks
        .keys()
        .copied()
        .filter(|&source| !augment(source, sinks, &mut source_of_sink, &mut BTreeSet::new()))
        .collect();
    // König: of the sources, those that no alternating path reaches from an unmatched source.
    let mut covered: BTreeSet<usize> = sinks.keys().copied().collect();
    let mut open = unmatched;
    while let Some(source) = open.pop() {
        if covered.remove(&source) {
            open.extend(sinks[&source].iter().filter_map(|sink| source_of_sink.get(sink)));
        }
    }
    covered
}

/// Finds a sink for `source`, moving other sources to other sinks where needed.
fn augment(
    source: usize,
    sinks: &BTreeMap<usize, Vec<usize>>,
    source_of_sink: &mut BTreeMap<usize, usize>,
    tried: &mut BTreeSet<usize>,
) -> bool {
    for &sink in &sinks[&source] {
        if !tried.insert(sink) {
            continue;
        }
        let free = match source_of_sink.get(&sink).copied() {
            None => true,
            Some(other) => augment(other, sinks, source_of_sink, tried),
        };
        if free {
            source_of_sink.insert(sink, source);
            return true;
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    fn products(edges: &[(usize, usize)]) -> usize {
        let edges: Vec<Edge> = edges.iter().map(|&(source, sink)| Edge { source, sink, constant: 0.5 }).collect();
        let at_source = multiply_at_source(&edges);
        let places: BTreeSet<(bool, usize)> =
            edges.iter().zip(at_source).map(|(e, at)| (at, if at { e.source } else { e.sink })).collect();
        places.len()
    }

    #[test]
    fn a_star_needs_one_product() {
        assert_eq!(products(&[(0, 0), (0, 1), (0, 2)]), 1, "one source");
        assert_eq!(products(&[(0, 0), (1, 0), (2, 0)]), 1, "one sink");
    }

    #[test]
    fn a_cover_is_never_larger_than_either_side() {
        assert_eq!(products(&[(0, 0), (0, 1), (0, 2), (1, 0), (2, 0), (3, 0)]), 2, "two stars that share an edge");
        assert_eq!(products(&[(0, 0), (1, 1), (2, 2)]), 3, "nothing shared");
        assert_eq!(products(&[(0, 0), (0, 1), (1, 1), (1, 2), (2, 2)]), 3, "a path of five edges");
    }

    #[test]
    fn constants_of_either_sign_share_a_product() {
        let edges = [0.5, -0.5].map(|constant| Edge { source: 0, sink: usize::from(constant < 0.0), constant });
        assert_eq!(multiply_at_source(&edges), [true, true], "one product at the source");
    }
}
