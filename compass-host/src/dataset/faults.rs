//! What of a recording was left out, and why.

use std::path::Path;

/// Faults that are kept with their place; the rest is counted.
const LISTED: usize = 100;

/// A kind of item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Item {
    /// A frame of one camera.
    Frame,
    /// A reading of the IMU.
    Reading,
    /// A pose of a trajectory.
    Pose,
}

impl Item {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Frame, Self::Reading, Self::Pose];

    /// The plural, for messages.
    #[must_use]
    pub const fn plural(self) -> &'static str {
        match self {
            Self::Frame => "frames",
            Self::Reading => "readings",
            Self::Pose => "poses",
        }
    }
}

/// An item that was left out.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// What it is.
    pub item: Item,
    /// The file and the line, or the topic and the time.
    pub place: String,
    /// What is wrong with it.
    pub problem: String,
}

/// The items of a recording that were left out, beside the number of those that were used.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Faults {
    first: Vec<Fault>,
    left_out: [usize; Item::ALL.len()],
    used: [usize; Item::ALL.len()],
}

impl Faults {
    /// Leaves out an item.
    pub fn add(&mut self, item: Item, place: impl Into<String>, problem: impl Into<String>) {
        self.left_out[item as usize] += 1;
        if self.first.len() < LISTED {
            self.first.push(Fault { item, place: place.into(), problem: problem.into() });
        }
    }

    /// Leaves out the item in a line of a file.
    pub(super) fn add_line(&mut self, item: Item, path: &Path, line: u64, problem: impl Into<String>) {
        self.add(item, format!("{}:{line}", path.display()), problem);
    }

    /// Counts items that were used.
    pub fn count_used(&mut self, item: Item, count: usize) {
        self.used[item as usize] += count;
    }

    /// An item that was used is left out after all.
    pub fn withdraw(&mut self, item: Item, place: impl Into<String>, problem: impl Into<String>) {
        let used = &mut self.used[item as usize];
        *used = used.saturating_sub(1);
        self.add(item, place, problem);
    }

    /// Adds those of another source.
    pub fn merge(&mut self, other: Self) {
        for item in Item::ALL {
            self.left_out[item as usize] += other.left_out[item as usize];
            self.used[item as usize] += other.used[item as usize];
        }
        self.first.extend(other.first);
        self.first.truncate(LISTED);
    }

    /// Number of items of a kind that were left out.
    #[must_use]
    pub const fn left_out(&self, item: Item) -> usize {
        self.left_out[item as usize]
    }

    /// Number of items of a kind, used or left out.
    #[must_use]
    pub const fn total(&self, item: Item) -> usize {
        self.left_out[item as usize] + self.used[item as usize]
    }

    /// The share of a kind that was left out, 0 to 1.
    #[must_use]
    pub fn share(&self, item: Item) -> f64 {
        self.left_out(item) as f64 / self.total(item).max(1) as f64
    }

    /// The first faults.
    #[must_use]
    pub fn first(&self) -> &[Fault] {
        &self.first
    }

    /// Whether everything was used.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.left_out.iter().all(|count| *count == 0)
    }
}

impl std::fmt::Display for Faults {
    /// Such as `1 of 3 frames, 2 of 200 readings`; the kinds of which something was left out.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let some = Item::ALL.into_iter().filter(|item| self.left_out(*item) > 0);
        let parts: Vec<_> = some
            .map(|item| format!("{} of {} {}", self.left_out(item), self.total(item), item.plural()))
            .collect();
        f.write_str(&parts.join(", "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_counted_and_the_first_are_listed() {
        let mut faults = Faults::default();
        assert!(faults.is_empty());
        faults.count_used(Item::Frame, 4);
        faults.withdraw(Item::Frame, "a.jpg", "damaged");
        let mut more = Faults::default();
        (0..200).for_each(|line| more.add_line(Item::Reading, Path::new("b.csv"), line, "NaN"));
        faults.merge(more);
        assert_eq!(faults.to_string(), "1 of 4 frames, 200 of 200 readings");
        assert_eq!((faults.share(Item::Frame), faults.share(Item::Pose)), (0.25, 0.0));
        assert_eq!((faults.first().len(), faults.first()[1].place.as_str()), (100, "b.csv:0"));
    }
}
