//! Fingerprints, which tell one piece of work from another.

use std::fmt;

use twox_hash::xxhash3_128::Hasher;

/// Changes whenever the same arguments lead to other results than before, or to another fingerprint.
const ALGORITHM: u64 = 3;

/// 128 bits that depend on everything written, and on its order. Not for secrets.
///
/// Everything that decides the result of long work is written into one, so that work is continued only from a checkpoint
/// of its own. It displays as 32 hexadecimal digits.
///
/// ```
/// use lobe_io::Fingerprint;
///
/// let of_word = |word| {
///     let mut fingerprint = Fingerprint::of_kind(99);
///     fingerprint.word(word);
///     fingerprint.bits()
/// };
/// assert_eq!(of_word(1), of_word(1));
/// assert_ne!(of_word(1), of_word(2));
/// ```
#[derive(Clone)]
pub struct Fingerprint(Hasher);

impl Fingerprint {
    /// The fingerprint of work of a kind, before anything else is written. Kinds below 64 are those of Lobe: 0 a
    /// scene, 1 to 3 bakes of vectors, of matrices and of grids, 16 a traced picture.
    #[must_use]
    pub fn of_kind(kind: u64) -> Self {
        let mut fingerprint = Self(Hasher::with_seed(ALGORITHM));
        fingerprint.word(kind);
        fingerprint
    }

    /// The 128 bits, the higher 64 first.
    #[must_use]
    pub fn bits(&self) -> [u64; 2] {
        let bits = self.0.finish_128();
        [(bits >> 64) as u64, bits as u64]
    }

    /// Writes a number.
    pub fn word(&mut self, word: u64) {
        self.0.write(&word.to_le_bytes());
    }

    /// Writes how many numbers there are, and then all of them.
    pub fn words(&mut self, words: impl ExactSizeIterator<Item = u64>) {
        self.word(words.len() as u64);
        words.for_each(|word| self.word(word));
    }

    /// Writes how many bytes there are, and then all of them.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.word(bytes.len() as u64);
        self.0.write(bytes);
    }

    /// Writes how many numbers there are, and then the bits of each: 0 and -0 differ.
    pub fn floats(&mut self, floats: &[f32]) {
        self.word(floats.len() as u64);
        floats.iter().for_each(|float| self.0.write(&float.to_le_bytes()));
    }
}

impl fmt::Display for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0.finish_128())
    }
}

impl fmt::Debug for Fingerprint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Fingerprint({self})")
    }
}

impl PartialEq for Fingerprint {
    fn eq(&self, other: &Self) -> bool {
        self.bits() == other.bits()
    }
}

impl Eq for Fingerprint {}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn everything_written_its_order_and_its_cuts_count() {
        let mut seen = HashSet::new();
        let mut expect_new = |what: &str, write: &dyn Fn(&mut Fingerprint)| {
            let mut fingerprint = Fingerprint::of_kind(1);
            write(&mut fingerprint);
            assert!(seen.insert(fingerprint.bits()), "{what}: {fingerprint}");
        };
        expect_new("nothing", &|_| ());
        expect_new("0", &|f| f.word(0));
        expect_new("1, 2", &|f| [1, 2].map(|word| f.word(word)).into_iter().collect());
        expect_new("2, 1", &|f| [2, 1].map(|word| f.word(word)).into_iter().collect());
        expect_new("bytes", &|f| f.bytes(b"ab"));
        expect_new("the same bytes, cut", &|f| [b"a", b"b"].map(|bytes| f.bytes(bytes)).into_iter().collect());
        expect_new("zero", &|f| f.floats(&[0.0]));
        expect_new("minus zero", &|f| f.floats(&[-0.0]));
        assert!(!seen.contains(&Fingerprint::of_kind(2).bits()), "another kind");
    }

    #[test]
    fn it_displays_its_bits() {
        let fingerprint = Fingerprint::of_kind(7);
        let [high, low] = fingerprint.bits();
        assert_eq!(fingerprint.to_string(), format!("{high:016x}{low:016x}"), "digits");
    }
}
