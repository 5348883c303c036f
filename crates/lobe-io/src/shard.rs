//! Shards: parts of the records of a piece of work, which machines make by themselves.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// One of several parts of a piece of work, as equal as they can be: of `N` shards, number `I` has the records from
/// `⌊(I-1) R / N⌋` up to `⌊I R / N⌋` of all `R`. Some are empty if there are more shards than records.
/// By serde it is its text, `"2/3"`.
///
/// ```
/// use lobe_io::Shard;
///
/// let shard: Shard = "2/3".parse()?;
/// assert_eq!(shard.range(10), 3..6);
/// assert_eq!(Shard::WHOLE.range(10), 0..10);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "String", into = "String")
)]
pub struct Shard {
    number: u32,
    count: u32,
}

impl Shard {
    /// All of the work.
    pub const WHOLE: Self = Self { number: 1, count: 1 };

    /// The most shards of a piece of work; more are taken for a typing error.
    pub const MAX_COUNT: u32 = 1 << 20;

    /// Number `number` of `count`, both from 1 on. `None` if there is no such shard, or more than [`Shard::MAX_COUNT`].
    #[must_use]
    pub fn new(number: u32, count: u32) -> Option<Self> {
        let is_one = (1..=count).contains(&number) && count <= Self::MAX_COUNT;
        is_one.then_some(Self { number, count })
    }

    /// Which of them it is, from 1 on.
    #[must_use]
    pub fn number(self) -> u32 {
        self.number
    }

    /// How many there are.
    #[must_use]
    pub fn count(self) -> u32 {
        self.count
    }

    /// The records that it has of all `records`.
    #[must_use]
    pub fn range(self, records: usize) -> Range<usize> {
        let before = |number: u32| (u128::from(number) * records as u128 / u128::from(self.count)) as usize;
        before(self.number - 1)..before(self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.count)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
        let shard = numbers.and_then(|(number, count)| Self::new(number, count));
        shard.ok_or_else(|| {
            format!("expected a shard such as 2/7, its number from 1 and how many there are, found {text}")
        })
    }
}

#[cfg(feature = "serde")]
impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(feature = "serde")]
impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_all_records_once_and_as_equal_as_can_be() {
        for (records, count) in [(0, 3), (1, 1), (2, 7), (10, 3), (1_000_003, 7), (usize::MAX, Shard::MAX_COUNT)] {
            let mut next = 0;
            let fair = records / count as usize;
            for number in 1..=count {
                let range = Shard::new(number, count).unwrap().range(records);
                assert_eq!(range.start, next, "{number}/{count} of {records}");
                assert!((fair..=fair + 1).contains(&range.len()), "{number}/{count} of {records}: {range:?}");
                next = range.end;
            }
            assert_eq!(next, records, "all of them by {count} shards");
        }
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        assert_eq!("2/7".parse(), Ok(Shard { number: 2, count: 7 }), "one of seven");
        for text in ["", "2", "0/7", "8/7", "1/0", "-1/2", "a/b", "1/2/3", "1/2000000", "99999999999/3"] {
            assert!(text.parse::<Shard>().unwrap_err().ends_with(&format!("found {text}")), "{text}");
        }
    }
}
