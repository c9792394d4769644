//! ROS 2 bags: a folder of `metadata.yaml` and one file or several, `SQLite` (`.db3`) or MCAP, each as a whole, its
//! messages or its chunks compressed or not; or such files without metadata.
//!
//! A bag is scanned once for the stamps of the frames and the readings of the IMU; a frame is fetched again on demand.
//! Times are those of the messages' headers, or of their recording where a topic has none.

mod choice;
mod contents;
mod encoding;
mod file;
mod kind;
mod mcap_file;
mod message;
mod metadata;
mod place;
mod scan;
mod sqlite_file;
mod topic;

use super::error::DatasetError;
use super::topics::Topics;
use crate::calibration::Calibration;
use crate::progress::Progress;
use contents::{Bag, METADATA};
use file::Content;
use scan::Scan;
use std::path::Path;
use std::sync::Arc;

pub(super) use contents::{Contents, Message};
#[cfg(feature = "ros2")]
pub(crate) use message::{compressed_frame, raw_frame};

/// Whether a path is a bag: a file of one, or a folder with some or with metadata.
pub(super) fn is_one(path: &Path) -> bool {
    if path.is_file() {
        return file::content(path).is_ok_and(|content| content != Content::Other);
    }
    path.join(METADATA).exists() || !file::storages(path).is_empty()
}

/// Reads the stamps and readings of a bag.
pub(super) fn read(
    path: &Path,
    topics: Option<&Topics>,
    calibration: &Calibration,
    progress: &dyn Progress,
) -> Result<Contents, DatasetError> {
    let mut notes = Vec::new();
    let bag = Bag::open(path, &mut notes)?;
    let chosen = choice::choose(&bag.topics, topics, calibration).map_err(|p| DatasetError::bad(path, p))?;
    let messages = chosen.iter().map(|(_, topic)| topic.count).sum();
    let mut scan = Scan::new(Arc::new(bag), chosen, notes, progress.begin(messages, "reading the bag"));
    scan.run();
    scan.finish(path)
}
