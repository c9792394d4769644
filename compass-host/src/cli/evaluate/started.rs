//! The output folder of a run that has just begun.

use std::path::{Path, PathBuf};

/// What of the output folder the run creates.
pub(super) struct Started {
    /// The outermost folder that was not there.
    folder: Option<PathBuf>,
    /// The journal, if it was not there.
    journal: Option<PathBuf>,
}

impl Started {
    /// Before anything is written.
    pub(super) fn new(out: &Path) -> Self {
        let evidence = out.join("evidence");
        let missing = evidence.ancestors().take_while(|path| !path.as_os_str().is_empty() && !path.exists());
        let journal = Some(out.join("frames.jsonl")).filter(|journal| !journal.exists());
        Self { folder: missing.last().map(Path::to_path_buf), journal }
    }

    /// Removes what was created: the input turned out to be unusable.
    pub(super) fn undo(&self) {
        // What cannot be removed is left; the error about the input is the one to report.
        if let Some(journal) = &self.journal {
            let _ = std::fs::remove_file(journal);
        }
        if let Some(folder) = &self.folder {
            let _ = std::fs::remove_dir_all(folder);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_was_created_is_removed() {
        let folder = tempfile::tempdir().unwrap();
        for (there, out) in [("", "a/b"), ("a/b/evidence", "a/b"), ("a", "a/b")] {
            let there = folder.path().join(there);
            std::fs::create_dir_all(&there).unwrap();
            let out = folder.path().join(out);
            let started = Started::new(&out);
            std::fs::create_dir_all(out.join("evidence")).unwrap();
            std::fs::write(out.join("frames.jsonl"), "").unwrap();
            started.undo();
            assert!(there.exists() && !out.join("frames.jsonl").exists());
            assert_eq!(out.exists(), there.ends_with("evidence"), "{}", there.display());
            let _ = std::fs::remove_dir_all(folder.path().join("a"));
        }
    }
}
