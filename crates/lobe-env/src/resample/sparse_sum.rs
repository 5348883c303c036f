//! Sparse array of sums, allocated block by block.

/// The number of entries in a block.
pub(crate) const BLOCK: usize = 256;

/// An array of sums whose blocks are allocated when they are first added to.
pub(crate) struct SparseSum {
    blocks: Vec<Option<Box<[f64; BLOCK]>>>,
}

impl SparseSum {
    /// Of `len` entries, all 0.
    pub(crate) fn new(len: usize) -> Self {
        Self { blocks: vec![None; len.div_ceil(BLOCK)] }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, index: usize, value: f64) {
        self.block(index / BLOCK)[index % BLOCK] += value;
    }

    /// Adds to two consecutive entries.
    #[inline(always)]
    pub(crate) fn add_pair(&mut self, index: usize, [a, b]: [f64; 2]) {
        let at = index % BLOCK;
        if at + 1 == BLOCK {
            self.add(index, a);
            self.add(index + 1, b);
        } else {
            let sums = self.block(index / BLOCK);
            sums[at] += a;
            sums[at + 1] += b;
        }
    }

    /// Adds to consecutive entries.
    pub(crate) fn add_row(&mut self, mut index: usize, mut values: &[f64]) {
        while !values.is_empty() {
            let (at, (now, later)) = (index % BLOCK, values.split_at(values.len().min(BLOCK - index % BLOCK)));
            for (sum, value) in self.block(index / BLOCK)[at..].iter_mut().zip(now) {
                *sum += value;
            }
            (index, values) = (index + now.len(), later);
        }
    }

    #[inline(always)]
    fn block(&mut self, number: usize) -> &mut [f64; BLOCK] {
        self.blocks[number].get_or_insert_with(|| Box::new([0.0; BLOCK]))
    }

    /// Adds the sums of one block to `sums`.
    pub(crate) fn add_block(&self, block: usize, sums: &mut [f64]) {
        if let Some(block) = &self.blocks[block] {
            for (sum, value) in sums.iter_mut().zip(block.iter()) {
                *sum += value;
            }
        }
    }
}
