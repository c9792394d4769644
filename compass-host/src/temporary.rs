//! Temporary files: removed when they are dropped, and by [`remove_all`] where a process ends without that.

use std::collections::BTreeSet;
use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{Builder, NamedTempFile};
#[cfg(feature = "bag")]
use tempfile::{TempDir, TempPath};

/// Attempts to remove a path: another thread may still be adding files to a folder.
const ATTEMPTS: usize = 3;

/// Those that exist now.
static EXISTING: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn existing() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    // The set is whole after every call, whatever thread panicked.
    EXISTING.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes all temporary files of the process and makes none from then on: whoever asks for one waits.
///
/// For a process that is about to end, such as one that was interrupted. The files that the library writes are whole or
/// absent even so.
pub fn remove_all() {
    let mut paths = existing();
    for path in std::mem::take(&mut *paths) {
        let remove: fn(&Path) -> io::Result<()> = if path.is_dir() {
            |path| std::fs::remove_dir_all(path)
        } else {
            |path| std::fs::remove_file(path)
        };
        // Nobody is left to be told of what cannot be removed.
        let _ = (0..ATTEMPTS).any(|_| remove(&path).is_ok());
    }
    std::mem::forget(paths);
}

/// The system's message alone: errors of `tempfile` name a path that the user does not know.
fn plain(error: &io::Error) -> io::Error {
    error.raw_os_error().map_or_else(|| error.kind().into(), io::Error::from_raw_os_error)
}

/// A path in the set of those that exist, until it is dropped.
#[derive(Debug)]
struct Listed(PathBuf);

impl Drop for Listed {
    fn drop(&mut self) {
        existing().remove(&self.0);
    }
}

/// A temporary file or folder. It is deleted before it leaves the list.
#[derive(Debug)]
pub(crate) struct Temporary<T> {
    item: T,
    listed: Listed,
}

impl<T> Temporary<T> {
    /// Creates one. The list is locked meanwhile, so that [`remove_all`] misses none.
    fn create(create: impl FnOnce() -> io::Result<T>, path: impl FnOnce(&T) -> &Path) -> io::Result<Self> {
        let mut paths = existing();
        let item = create().map_err(|error| plain(&error))?;
        let path = path(&item).to_path_buf();
        paths.insert(path.clone());
        Ok(Self { item, listed: Listed(path) })
    }

    /// Where it is.
    pub(crate) fn path(&self) -> &Path {
        &self.listed.0
    }
}

impl Temporary<NamedTempFile> {
    /// A file in a folder.
    pub(crate) fn file_in(folder: &Path, builder: &Builder<'_, '_>) -> io::Result<Self> {
        Self::create(|| builder.tempfile_in(folder), |file| file.path())
    }

    /// A file in the folder for temporary files.
    #[cfg(feature = "bag")]
    pub(crate) fn file() -> io::Result<Self> {
        Self::create(NamedTempFile::new, |file| file.path())
    }

    /// What is written goes here.
    pub(crate) fn writer(&mut self) -> &mut File {
        self.item.as_file_mut()
    }

    /// Gives the file its final name, in place of one that has it.
    pub(crate) fn persist(self, path: &Path) -> io::Result<()> {
        self.item.persist(path).map(drop).map_err(|error| plain(&error.error))
    }

    /// The file, closed.
    #[cfg(feature = "bag")]
    pub(crate) fn close(self) -> Temporary<TempPath> {
        Temporary { item: self.item.into_temp_path(), listed: self.listed }
    }
}

#[cfg(feature = "bag")]
impl Temporary<TempDir> {
    /// A folder in the folder for temporary files.
    pub(crate) fn folder() -> io::Result<Self> {
        Self::create(TempDir::new, |folder| folder.path())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn is_listed(path: &Path) -> bool {
        existing().contains(path)
    }

    #[test]
    fn a_file_is_listed_until_it_has_its_name_or_is_gone() {
        let home = tempfile::tempdir().unwrap();
        let file = Temporary::file_in(home.path(), &Builder::new()).unwrap();
        let (path, named) = (file.path().to_path_buf(), home.path().join("named"));
        assert!(is_listed(&path) && path.exists());
        file.persist(&named).unwrap();
        assert!(!is_listed(&path) && !path.exists() && named.exists());

        let dropped = Temporary::file_in(home.path(), &Builder::new()).unwrap();
        let path = dropped.path().to_path_buf();
        drop(dropped);
        assert!(!is_listed(&path) && !path.exists());
        assert!(Temporary::file_in(&home.path().join("absent"), &Builder::new()).is_err());
    }

    #[test]
    #[cfg(feature = "bag")]
    fn closed_files_and_folders_stay_listed() {
        let closed = Temporary::file().unwrap().close();
        let folder = Temporary::folder().unwrap();
        let paths = [closed.path().to_path_buf(), folder.path().to_path_buf()];
        assert!(paths.iter().all(|path| is_listed(path) && path.exists()));
        drop((closed, folder));
        assert!(paths.iter().all(|path| !is_listed(path) && !path.exists()));
    }
}
