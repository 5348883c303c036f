//! Sums for some of many places.

/// Places that are held together.
pub(crate) const BLOCK: usize = 256;

/// A sum for each place, held in blocks, only where there is one.
pub(crate) struct SparseSum {
    /// 0 where there is none, or the number of the block, from 1.
    blocks: Vec<u32>,
    sums: Vec<[f64; BLOCK]>,
}

impl SparseSum {
    /// For `len` places.
    pub(crate) fn new(len: usize) -> Self {
        Self { blocks: vec![0; len.div_ceil(BLOCK)], sums: vec![[0.0; BLOCK]] }
    }

    #[inline(always)]
    pub(crate) fn add(&mut self, index: usize, value: f64) {
        let block = &mut self.blocks[index / BLOCK];
        if *block == 0 {
            *block = self.sums.len() as u32;
            self.sums.push([0.0; BLOCK]);
        }
        self.sums[*block as usize][index % BLOCK] += value;
    }

    /// Adds the sums of one block to others.
    pub(crate) fn add_block(&self, block: usize, sums: &mut [f64]) {
        let block = self.blocks[block];
        if block > 0 {
            for (sum, value) in sums.iter_mut().zip(&self.sums[block as usize]) {
                *sum += value;
            }
        }
    }
}
