//! Edges of triangles: sides with the same two ends, side by side.

/// Calls `with` for each edge: its ends, the smaller one first, and the numbers of its sides in their order. Sides are
/// numbered as they come, each with its smaller end first; those whose ends are one are an edge, too.
///
/// Sides lie beside each other by their smaller end, so that the few of one vertex are compared with each other: in
/// linear time where no vertex has many. The order of edges is that of their ends.
pub(crate) fn for_each_edge<I: Iterator<Item = [u32; 2]>>(
    sides: impl Fn() -> I,
    mut with: impl FnMut([u32; 2], &[u32]),
) {
    // Count the sides of each smaller end, and put the other ends side by side.
    let mut ends = vec![0_u32; sides().map(|[a, _]| a as usize + 1).max().unwrap_or(0)];
    sides().for_each(|[a, _]| ends[a as usize] += 1);
    let mut before = 0;
    for end in &mut ends {
        (*end, before) = (before, before + *end);
    }
    let mut others = vec![(0, 0); before as usize];
    for (number, [a, b]) in (0..).zip(sides()) {
        others[ends[a as usize] as usize] = (b, number);
        ends[a as usize] += 1;
    }
    // Each end has been moved to where the next one begins.
    let (mut start, mut numbers) = (0, Vec::new());
    for (a, &end) in (0..).zip(&ends) {
        let own = &mut others[start..end as usize];
        start = end as usize;
        own.sort_unstable();
        for group in own.chunk_by(|c, d| c.0 == d.0) {
            numbers.clear();
            numbers.extend(group.iter().map(|(_, number)| *number));
            with([a, group[0].0], &numbers);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn sides_are_at_the_edges_of_their_ends_in_their_order() {
        let mut random = Random::new(3);
        let mut end = || (random.unit() * 9.0) as u32;
        let sides: Vec<[u32; 2]> = (0..200).map(|_| [end(), end()]).map(|[a, b]| [a.min(b), a.max(b)]).collect();
        let mut expected: BTreeMap<[u32; 2], Vec<u32>> = BTreeMap::new();
        for (number, side) in (0..).zip(&sides) {
            expected.entry(*side).or_default().push(number);
        }
        let mut found = Vec::new();
        for_each_edge(|| sides.iter().copied(), |edge, numbers| found.push((edge, numbers.to_vec())));
        assert_eq!(found, expected.into_iter().collect::<Vec<_>>());
        for_each_edge(std::iter::empty, |edge, _| panic!("an edge of nothing: {edge:?}"));
    }
}
