//! Work on many numbers, shared among the threads of the current rayon pool. The pieces do not
//! depend on the number of threads, so a result has the same bytes on any number of them.

use std::ops::Range;

use rayon::prelude::*;

/// The approximate number of elements of a band: enough work to be worth a thread's while, and
/// little enough to stay in its cache.
pub(crate) const BAND: usize = 8192;

/// The count of numbers below which one thread is as fast as two, because waking another takes some
/// ten microseconds.
pub(crate) const WORTH_SHARING: usize = 1 << 15;

/// Returns whether work on so many numbers is worth sharing.
pub(crate) fn is_worth_sharing(numbers: usize) -> bool {
    numbers >= WORTH_SHARING && rayon::current_num_threads() > 1
}

/// Does every piece of work; the pieces hold `numbers` numbers in all.
pub(crate) fn each<T: Send>(numbers: usize, pieces: Vec<T>, work: impl Fn(T) + Sync + Send) {
    if is_worth_sharing(numbers) {
        pieces.into_par_iter().for_each(work)
    } else {
        pieces.into_iter().for_each(work)
    }
}

/// Calls `work` on every band of `len` elements and returns the results in order.
pub(crate) fn bands<T: Send>(len: usize, work: impl Fn(Range<usize>) -> T + Sync + Send) -> Vec<T> {
    let band = |index: usize| work(index * BAND..len.min((index + 1) * BAND));
    let count = len.div_ceil(BAND);
    if is_worth_sharing(len) {
        (0..count).into_par_iter().map(band).collect()
    } else {
        (0..count).map(band).collect()
    }
}

/// Writes the rows of a field, each `width` long; `work` gets the index of a row and the row.
pub(crate) fn rows<T: Send>(
    field: &mut [T],
    width: usize,
    work: impl Fn(usize, &mut [T]) + Sync + Send,
) {
    if is_worth_sharing(field.len()) {
        let least = BAND.div_ceil(width);
        field
            .par_chunks_mut(width)
            .with_min_len(least)
            .enumerate()
            .for_each(|(index, row)| work(index, row));
    } else {
        field.chunks_mut(width).enumerate().for_each(|(index, row)| work(index, row));
    }
}

/// Returns a vector of `len` equal values. All threads write it, because the first touch of new
/// memory takes most of the time.
pub(crate) fn filled<T: Copy + Send + Sync>(len: usize, value: T) -> Vec<T> {
    if is_worth_sharing(len) {
        rayon::iter::repeat_n(value, len).collect()
    } else {
        vec![value; len]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_element_is_in_one_band_and_one_row() {
        for len in [0, 1, BAND, 5 * BAND + 3] {
            let elements: Vec<usize> = bands(len, |band| band.collect::<Vec<_>>()).concat();
            assert_eq!(elements, (0..len).collect::<Vec<_>>());
            let mut field = vec![0; len];
            rows(&mut field, 7, |index, row| {
                row.iter_mut().enumerate().for_each(|(i, value)| *value = 7 * index + i)
            });
            assert_eq!(field, elements);
        }
    }
}
