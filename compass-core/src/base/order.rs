//! In-place heapsort without a panic path: the sorts of `core` detect inconsistent orders and panic on them.
//!
//! At most `n log2 n` steps, of which one sift-down takes `log2 n`; not stable, not recursive.

/// Sorts by ascending key.
pub(crate) fn sort_by_key<T, K: Ord>(items: &mut [T], key: impl Fn(&T) -> K) {
    heapify(items, &key);
    for end in (1..items.len()).rev() {
        swap(items, 0, end);
        sink(items.get_mut(..end).unwrap_or_default(), 0, &key);
    }
}

/// Reorders the items into a max-heap: item 0 has the largest key.
pub(crate) fn heapify<T, K: Ord>(items: &mut [T], key: &impl Fn(&T) -> K) {
    for at in (0..items.len() / 2).rev() {
        sink(items, at, key);
    }
}

/// Sifts an item of a max-heap down until both of its children are smaller or equal.
pub(crate) fn sink<T, K: Ord>(heap: &mut [T], mut at: usize, key: &impl Fn(&T) -> K) {
    loop {
        let order = |slot: usize| heap.get(slot).map(key);
        // `None`, for a slot beyond the end, compares below every key.
        let greater = if order(2 * at + 2) > order(2 * at + 1) { 2 * at + 2 } else { 2 * at + 1 };
        if order(greater) <= order(at) {
            return;
        }
        swap(heap, at, greater);
        at = greater;
    }
}

/// Swaps two items; no effect if an index is out of range.
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
        fn sorts_as_sort_unstable_does(mut items: Vec<u16>) {
            let mut expected = items.clone();
            expected.sort_unstable_by_key(|item| Reverse(*item));
            sort_by_key(&mut items, |item| Reverse(*item));
            prop_assert_eq!(items, expected);
        }

        #[test]
        fn item_0_of_a_heap_has_the_largest_key(mut items in proptest::collection::vec(any::<u8>(), 1..99), last: u8) {
            heapify(&mut items, &|item| *item);
            prop_assert_eq!(Some(&items[0]), items.iter().max());
            items[0] = last;
            sink(&mut items, 0, &|item| *item);
            prop_assert_eq!(Some(&items[0]), items.iter().max());
        }
    }
}
