//! Sparse symmetric matrices, put together entry by entry.

/// A square matrix of which most entries are zero, row by row.
#[derive(Debug)]
pub(crate) struct SparseMatrix {
    /// Where the entries of each row begin, and the end.
    starts: Vec<usize>,
    columns: Vec<u32>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// The sums of these entries, `(row, column, value)`, which come in any order, and twice alike.
    ///
    /// Sums are in the order of the entries. Entries are many times as many as sums, and are not kept.
    pub(crate) fn of_entries<I: Iterator<Item = (u32, u32, f64)>>(rows: usize, entries: impl Fn() -> I) -> Self {
        let (starts, columns) = columns(rows, || entries().map(|(row, column, _)| (row, column)));
        // As sums of numbers begin, which leaves a zero its sign.
        let mut values = vec![-0.0; columns.len()];
        for (row, column, value) in entries() {
            let range = starts[row as usize]..starts[row as usize + 1];
            let own = &columns[range.clone()];
            let place = match own.len() {
                0..=SHORT => own.iter().position(|&own| own == column),
                _ => own.binary_search(&column).ok(),
            };
            if let Some(place) = place {
                values[range.start + place] += value;
            }
        }
        Self { starts, columns, values }
    }

    pub(crate) fn rows(&self) -> usize {
        self.starts.len() - 1
    }

    /// The columns and values of a row.
    pub(crate) fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.starts[row]..self.starts[row + 1];
        self.columns[range.clone()].iter().map(|&column| column as usize).zip(self.values[range].iter().copied())
    }

    /// The entry on the diagonal of a row.
    pub(crate) fn diagonal(&self, row: usize) -> f64 {
        self.row(row).find(|(column, _)| *column == row).map_or(0.0, |(_, value)| value)
    }
}

/// Columns of a row up to which they are searched one after the other. A row has a dozen, but for the tips of fans.
const SHORT: usize = 32;

/// The columns of each row in their order, each once, and where those of a row begin.
fn columns<I: Iterator<Item = (u32, u32)>>(rows: usize, entries: impl Fn() -> I) -> (Vec<usize>, Vec<u32>) {
    // Count the entries of each row, for a place that holds all of them.
    let mut places = vec![0; rows + 1];
    entries().for_each(|(row, _)| places[row as usize + 1] += 1);
    (0..rows).for_each(|row| places[row + 1] += places[row]);
    // Put the columns there that a row does not have yet; in a long row some are there several times for a while.
    let mut found = vec![0_u32; places[rows]];
    let mut counts = vec![0; rows];
    for (row, column) in entries() {
        let (own, count) = (&mut found[places[row as usize]..places[row as usize + 1]], &mut counts[row as usize]);
        if *count > SHORT || !own[..*count].contains(&column) {
            own[*count] = column;
            *count += 1;
        }
    }
    let mut starts = Vec::with_capacity(rows + 1);
    starts.push(0);
    let mut columns: Vec<u32> = Vec::with_capacity(counts.iter().sum());
    for (row, count) in counts.into_iter().enumerate() {
        let own = &mut found[places[row]..][..count];
        own.sort_unstable();
        columns.extend(own.chunk_by(|a, b| a == b).map(|group| group[0]));
        starts.push(columns.len());
    }
    (starts, columns)
}

#[cfg(test)]
mod tests {
    use lobe_testkit::Random;

    use super::*;

    #[test]
    fn entries_at_one_place_are_summed_in_their_order() {
        let rows = 2 * SHORT;
        let mut random = Random::new(4);
        let mut index = || (random.unit() * (rows - 1) as f64) as u32;
        let mut places: Vec<_> = (0..500).map(|_| (index(), index())).collect();
        // A long row has all columns, thrice. Sums of numbers of many sizes depend on the order. The last row has none.
        places.extend((0..3 * rows as u32).map(|k| (7, 7 * k % rows as u32)));
        let entries: Vec<_> =
            places.into_iter().map(|(i, j)| (i, j, 10.0_f64.powi((random.unit() * 20.0) as i32))).collect();
        let matrix = SparseMatrix::of_entries(rows, || entries.iter().copied());
        for row in 0..rows {
            let of_row = entries.iter().filter(|entry| entry.0 as usize == row);
            let mut expected = std::collections::BTreeMap::new();
            of_row.for_each(|&(_, column, value)| *expected.entry(column as usize).or_insert(0.0) += value);
            let found: Vec<_> = matrix.row(row).collect();
            assert_eq!(found, expected.into_iter().collect::<Vec<_>>(), "row {row}");
        }
    }
}
