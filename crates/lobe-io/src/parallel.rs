//! Loops over all processors whose scheduling is compiled once, not once a loop.
//!
//! Rationale
//! - Every closure given to `rayon` makes the compiler translate its splitting, stealing and unwinding anew: a third of what
//!   lobe-env gave to LLVM in November 2026. Here `rayon` sees one loop over ranges of indices, and the others, which stand on it,
//!   add little more than their own bodies.
//! - The price is two indirect calls for every index of [`map`], and a lock, for which nobody waits, and 24 bytes for every row of
//!   [`rows`]: some tens of nanoseconds. What takes less for each number goes by [`rows`] or [`fill`] of many of them.
//! - Results lie in the order of their indices, whatever the number of threads. Which thread does what is `rayon`'s choice.

use std::env::var_os;
use std::ffi::OsStr;
use std::ops::Range;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use crate::error::IoError;

/// More threads than any machine has. A larger number is taken for a typing error.
pub const MAX_THREADS: usize = 1024;

/// The variables by which `rayon` is told its number of threads; the second is its old name.
const VARIABLES: [&str; 2] = ["RAYON_NUM_THREADS", "RAYON_RS_NUM_CPUS"];

/// Checks that the number of threads that the environment gives to `rayon` is from 1 to [`MAX_THREADS`]: `rayon` itself ignores
/// what is no number, and takes minutes for a large one.
///
/// # Errors
/// [`IoError::Invalid`] for another number and for what is none.
pub fn check_environment() -> Result<(), IoError> {
    VARIABLES.iter().try_for_each(|name| var_os(name).map_or(Ok(()), |value| check_threads(name, &value)))
}

fn check_threads(name: &str, value: &OsStr) -> Result<(), IoError> {
    let count = value.to_str().and_then(|text| text.parse().ok());
    if value.is_empty() || count.is_some_and(|count: usize| (1..=MAX_THREADS).contains(&count)) {
        return Ok(());
    }
    let found = value.to_string_lossy();
    let message = format!("expected a number of threads from 1 to {MAX_THREADS}, found `{found}`; correct or unset it");
    Err(IoError::Invalid { place: name.to_owned(), message })
}

/// Calls `of` with ranges that make up `0..count` together, each index in one of them, on all threads; with an empty one if `count` is 0.
fn ranges(count: usize, of: &(dyn Fn(Range<usize>) + Sync)) {
    rayon::iter::split(0..count, halves).for_each(of);
}

/// A range in two, if it has two indices.
fn halves(Range { start, end }: Range<usize>) -> (Range<usize>, Option<Range<usize>>) {
    let middle = start.midpoint(end);
    if middle == start { (start..end, None) } else { (start..middle, Some(middle..end)) }
}

/// `[of(0), of(1), …, of(count − 1)]`. The results are copied together at the end: many large ones go by [`fill`], which writes
/// them where they stay.
///
/// ```
/// assert_eq!(lobe_io::parallel::map(4, &|i| i * i), [0, 1, 4, 9]);
/// ```
pub fn map<T: Send>(count: usize, of: &(dyn Fn(usize) -> T + Sync)) -> Vec<T> {
    map_with(count, &|| (), &|(), i| of(i))
}

/// Like [`map`] with scratch memory, which `scratch` makes once for several calls in turn. What `of` returns must not depend on what
/// an earlier call has left there.
///
/// ```
/// let reversed = lobe_io::parallel::map_with(3, &Vec::new, &|digits: &mut Vec<char>, i| {
///     digits.clear();
///     digits.extend((98 + i).to_string().chars().rev());
///     digits.iter().collect::<String>()
/// });
/// assert_eq!(reversed, ["89", "99", "001"]);
/// ```
pub fn map_with<T: Send, S>(
    count: usize,
    scratch: &(dyn Fn() -> S + Sync),
    of: &(dyn Fn(&mut S, usize) -> T + Sync),
) -> Vec<T> {
    let parts = Mutex::new(Vec::new());
    ranges(count, &|range| {
        let (start, mut scratch) = (range.start, scratch());
        let part: Vec<T> = range.map(|i| of(&mut scratch, i)).collect();
        parts.lock().unwrap_or_else(PoisonError::into_inner).push((start, part));
    });
    let mut parts = parts.into_inner().unwrap_or_else(PoisonError::into_inner);
    parts.sort_unstable_by_key(|(start, _)| *start);
    let mut all = Vec::with_capacity(count);
    for (_, part) in parts {
        all.extend(part);
    }
    all
}

/// Calls `of(y, row)` for every `width` items, the last row having what is left.
///
/// # Panics
/// If `width` is 0.
///
/// ```
/// let mut texels = [0; 6];
/// lobe_io::parallel::rows(&mut texels, 3, &|y, row| row.fill(y));
/// assert_eq!(texels, [0, 0, 0, 1, 1, 1]);
/// ```
pub fn rows<T: Send>(items: &mut [T], width: usize, of: &(dyn Fn(usize, &mut [T]) + Sync)) {
    rows_with(items, width, &|| (), &|(), y, row| of(y, row));
}

/// Like [`rows`] with scratch memory as in [`map_with`].
///
/// # Panics
/// If `width` is 0.
pub fn rows_with<T: Send, S>(
    items: &mut [T],
    width: usize,
    scratch: &(dyn Fn() -> S + Sync),
    of: &(dyn Fn(&mut S, usize, &mut [T]) + Sync),
) {
    // A row is in one range, and a range on one thread: no lock is waited for, and what a panic poisons nobody reads.
    let rows: Vec<Mutex<&mut [T]>> = items.chunks_mut(width).map(Mutex::new).collect();
    ranges(rows.len(), &|range| {
        let mut scratch = scratch();
        for y in range {
            of(&mut scratch, y, &mut rows[y].lock().unwrap_or_else(PoisonError::into_inner));
        }
    });
}

/// `items[i] = of(i)`, with `together` of them a piece of work.
///
/// # Panics
/// If `together` is 0.
///
/// ```
/// let mut squares = [0; 5];
/// lobe_io::parallel::fill(&mut squares, 2, &|i| i * i);
/// assert_eq!(squares, [0, 1, 4, 9, 16]);
/// ```
pub fn fill<T: Send>(items: &mut [T], together: usize, of: &(dyn Fn(usize) -> T + Sync)) {
    rows(items, together, &|piece, items| {
        for (k, item) in items.iter_mut().enumerate() {
            *item = of(piece * together + k);
        }
    });
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    #[test]
    fn a_number_of_threads_that_cannot_be_meant_is_refused() {
        for value in ["", "1", "64", "1024"] {
            assert!(check_threads("N", value.as_ref()).is_ok(), "`{value}`");
        }
        for value in ["0", "1025", "100000", "-3", "two", "2 "] {
            let message = check_threads("N", value.as_ref()).unwrap_err().to_string();
            let expected =
                format!("N: expected a number of threads from 1 to 1024, found `{value}`; correct or unset it");
            assert_eq!(message, expected);
        }
    }

    #[test]
    fn results_lie_in_the_order_of_their_indices() {
        let expected: Vec<usize> = (0..10_000).map(|i| 3 * i).collect();
        assert_eq!(map(10_000, &|i| 3 * i), expected);
        let tripled = map_with(10_000, &Vec::new, &|before: &mut Vec<usize>, i| {
            before.push(i);
            3 * before.pop().unwrap()
        });
        assert_eq!(tripled, expected);
        assert!(map(0, &|i| i).is_empty());
    }

    #[test]
    fn every_index_is_in_one_range() {
        for count in [0, 1, 2, 3, 1000] {
            let seen: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
            ranges(count, &|range| range.for_each(|i| _ = seen[i].fetch_add(1, Ordering::Relaxed)));
            assert!(seen.into_iter().all(|times| times.into_inner() == 1), "{count}");
        }
    }

    #[test]
    fn every_row_is_visited_once_and_the_last_may_be_short() {
        let mut items = vec![0_usize; 1001];
        rows(&mut items, 10, &|y, row| row.iter_mut().enumerate().for_each(|(x, item)| *item += 10 * y + x));
        rows_with(&mut items, 7, &Vec::new, &|seen: &mut Vec<usize>, y, row| {
            seen.push(y);
            row.iter_mut().enumerate().for_each(|(x, item)| *item += 7 * y + x);
        });
        assert!(items.iter().enumerate().all(|(i, item)| *item == 2 * i));
        rows(&mut [] as &mut [u8], 10, &|_, _| unreachable!("there is no row"));
    }
}
