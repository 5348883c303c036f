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
    pub(crate) fn of_entries<I: Iterator<Item = (u32, u32, f64)>>(rows: usize, entries: impl Fn() -> I) -> Self {
        // Count the entries of each row, and put them side by side.
        let mut starts = vec![0; rows + 1];
        entries().for_each(|(row, ..)| starts[row as usize + 1] += 1);
        (0..rows).for_each(|row| starts[row + 1] += starts[row]);
        let mut filled = starts.clone();
        let mut all = vec![(0, 0.0); starts[rows]];
        for (row, column, value) in entries() {
            let place = &mut filled[row as usize];
            all[*place] = (column, value);
            *place += 1;
        }
        // Add up the entries of each place.
        let mut matrix = Self { starts: vec![0], columns: Vec::new(), values: Vec::new() };
        for row in 0..rows {
            let own = &mut all[starts[row]..starts[row + 1]];
            own.sort_by_key(|(column, _)| *column);
            for group in own.chunk_by(|a, b| a.0 == b.0) {
                matrix.columns.push(group[0].0);
                matrix.values.push(group.iter().map(|(_, value)| value).sum());
            }
            matrix.starts.push(matrix.columns.len());
        }
        matrix
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
