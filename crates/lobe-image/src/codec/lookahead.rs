//! As many of the next bytes of a source as a parser needs.

use std::io::{self, Read};

/// The least number of bytes that are asked for at once.
const LEAST: usize = 1 << 16;

/// A source of which no more is in memory than what is parsed next. Parsers of slices read from it.
pub(crate) struct Lookahead<R> {
    source: R,
    bytes: Vec<u8>,
    /// Of the bytes, those that have been parsed.
    parsed: usize,
    /// Whether the source has no more bytes.
    has_ended: bool,
    /// All that have been parsed.
    position: u64,
}

impl<R: Read> Lookahead<R> {
    pub(crate) fn new(source: R) -> Self {
        Self { source, bytes: Vec::new(), parsed: 0, has_ended: false, position: 0 }
    }

    /// Bytes that have been parsed.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// What `parse` finds in the next bytes, of which it takes what it has used. If it finds none for want of bytes it is asked again
    /// with twice as many, until its second argument says that there are no more.
    pub(crate) fn parse<T>(&mut self, mut parse: impl FnMut(&mut &[u8], bool) -> Option<T>) -> io::Result<Option<T>> {
        loop {
            let mut rest = &self.bytes[self.parsed..];
            if let Some(found) = parse(&mut rest, self.has_ended) {
                let parsed = self.bytes.len() - rest.len();
                self.position += (parsed - self.parsed) as u64;
                self.parsed = parsed;
                return Ok(Some(found));
            }
            if self.has_ended {
                return Ok(None);
            }
            self.read_more()?;
        }
    }

    /// Whether all bytes have been parsed.
    pub(crate) fn is_at_end(&mut self) -> io::Result<bool> {
        let at_end = self.parse(|rest, has_ended| (has_ended || !rest.is_empty()).then_some(rest.is_empty()))?;
        Ok(at_end.unwrap_or(true))
    }

    fn read_more(&mut self) -> io::Result<()> {
        self.bytes.drain(..self.parsed);
        self.parsed = 0;
        let count = self.bytes.len().max(LEAST);
        let read = self.source.by_ref().take(count as u64).read_to_end(&mut self.bytes)?;
        self.has_ended = read < count;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_parser_gets_as_many_bytes_as_it_asks_for_and_what_it_leaves_again() {
        let bytes: Vec<u8> = (0..400_000_u32).map(|i| i.wrapping_mul(2_654_435_761) as u8).collect();
        for sizes in [vec![1, 2, 3], vec![LEAST, 1, 3 * LEAST, 7], vec![200_000, 100_000, 100_000]] {
            let mut source = Lookahead::new(bytes.as_slice());
            let mut found = Vec::new();
            for size in sizes.iter().cycle() {
                let part = source.parse(|rest, has_ended| {
                    let size = if has_ended { (*size).min(rest.len()) } else { *size };
                    rest.split_off(..size).map(<[u8]>::to_vec)
                });
                let part = part.unwrap().unwrap();
                if part.is_empty() {
                    break;
                }
                found.extend(part);
                assert_eq!(source.position(), found.len() as u64, "sizes {sizes:?}");
                assert!(source.bytes.len() <= 2 * (LEAST + sizes.iter().max().unwrap()), "sizes {sizes:?}");
            }
            assert!(source.is_at_end().unwrap() && found == bytes, "sizes {sizes:?}");
        }
    }

    #[test]
    fn a_parser_that_never_finds_is_told_the_end() {
        let mut source = Lookahead::new(&[1_u8; 10][..]);
        let mut ended = 0;
        let found = source.parse(|_, has_ended| {
            ended += usize::from(has_ended);
            None::<()>
        });
        assert!(found.unwrap().is_none() && ended == 1 && !source.is_at_end().unwrap());
    }
}
