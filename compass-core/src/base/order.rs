//! Sorting in place that cannot panic: heapsort. The library's own sorts hold a check for orders that contradict
//! themselves, and with it a way to panic.
//!
//! `n log2 n` steps at most, `log2 n` of them for one sinking; neither stable nor recursive.

/// Sorts by rising key.
pub(crate) fn sort_by_key<T, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    heapify(items, &key);
    for end in (1..items.len()).rev() {
        swap(items, 0, end);
        sink(items.get_mut(..end).unwrap_or_default(), 0, &key);
    }
}

/// Makes a heap of the items: none is greater than the first.
pub(crate) fn heapify<T, K: Ord>(items: &mut [T], key: &impl Fn(&T) -> K) {
    for at in (0..items.len() / 2).rev() {
        sink(items, at, key);
    }
}

/// Moves an item of a heap down to where no greater one is below it.
pub(crate) fn sink<T, K: Ord>(heap: &mut [T], mut at: usize, key: &impl Fn(&T) -> K) {
    loop {
        let order = |slot: usize| heap.get(slot).map(key);
        // None, beyond the end, is less than any.
        let greater = if order(2 * at + 2) > order(2 * at + 1) { 2 * at + 2 } else { 2 * at + 1 };
        if order(greater) <= order(at) {
            return;
        }
        swap(heap, at, greater);
        at = greater;
    }
}

/// Exchanges two items; nothing where one of them does not exist.
pub(crate) fn swap<T>(items: &mut [T], a: usize, b: usize) {
    if let Ok([a, b]) = items.get_disjoint_mut([a, b]) {
        core::mem::swap(a, b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cmp::Reverse;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn sorts_as_the_library_does(mut items: Vec<u16>) {
            let mut expected = items.clone();
            expected.sort_unstable_by_key(|item| Reverse(*item));
            sort_by_key(&mut items, |item| Reverse(*item));
            prop_assert_eq!(items, expected);
        }

        #[test]
        fn the_first_of_a_heap_is_the_greatest(mut items in proptest::collection::vec(any::<u8>(), 1..99), last: u8) {
            heapify(&mut items, &|item| *item);
            prop_assert_eq!(Some(&items[0]), items.iter().max());
            items[0] = last;
            sink(&mut items, 0, &|item| *item);
            prop_assert_eq!(Some(&items[0]), items.iter().max());
        }
    }
}
