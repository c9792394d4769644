//! The outcome of a command as the exit status of the process.

use super::notes::{line, note};
use compass_host::locator::SeeError;
use compass_host::temporary;
use std::process::ExitCode;

/// The outcome of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Done.
    Done,
    /// Done, and the answer is "no".
    No,
}

/// The exit status of the process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Status {
    /// The work was done.
    Done = 0,
    /// The work was done and its answer is "no".
    No = 1,
    /// Bad input or usage; clap uses the same for bad usage.
    BadInput = 2,
    /// Ctrl-C, or the system asked the process to end; shells use it for that.
    Interrupted = 130,
}

impl From<Outcome> for Status {
    fn from(outcome: Outcome) -> Self {
        match outcome {
            Outcome::Done => Self::Done,
            Outcome::No => Self::No,
        }
    }
}

impl From<&SeeError> for Status {
    fn from(error: &SeeError) -> Self {
        if error.is_answer() { Self::No } else { Self::BadInput }
    }
}

/// The work was done, but on too little of the input to trust it.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub(super) struct TooMuchLeftOut(pub(super) String);

impl From<&anyhow::Error> for Status {
    fn from(error: &anyhow::Error) -> Self {
        if error.is::<TooMuchLeftOut>() {
            return Self::No;
        }
        error.downcast_ref::<SeeError>().map_or(Self::BadInput, Self::from)
    }
}

/// Set instead of ending the process, once somebody [asked](stop_when_interrupted) for it.
#[cfg(feature = "ros2")]
static STOP: std::sync::OnceLock<std::sync::atomic::AtomicBool> = std::sync::OnceLock::new();

/// From now on an interruption sets this, and does not end the process.
#[cfg(feature = "ros2")]
pub(super) fn stop_when_interrupted() -> &'static std::sync::atomic::AtomicBool {
    STOP.get_or_init(|| std::sync::atomic::AtomicBool::new(false))
}

/// Removes temporary files before the process ends because of Ctrl-C or because the system asks it to.
pub(super) fn clean_up_when_interrupted() {
    let handled = ctrlc::set_handler(|| {
        #[cfg(feature = "ros2")]
        if let Some(stop) = STOP.get() {
            // Asked twice, it ends at once.
            if !stop.swap(true, std::sync::atomic::Ordering::Relaxed) {
                return;
            }
        }
        temporary::remove_all();
        std::process::exit(Status::Interrupted as i32);
    });
    if let Err(error) = handled {
        // Without it the command does the same work; only an interrupted one leaves files.
        note(&format!("temporary files are left behind when interrupted: {error}"));
    }
}

/// Reports an error on standard error, and gives the exit status.
pub(super) fn code(result: anyhow::Result<Outcome>) -> ExitCode {
    let status = result.map_or_else(
        |error| {
            line(&one_line(&error));
            Status::from(&error)
        },
        Status::from,
    );
    ExitCode::from(status as u8)
}

/// The chain of causes in one line; a cause is skipped if the message before it already ends with it.
fn one_line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        if text.is_empty() {
            text = cause;
        } else if !text.ends_with(&cause) {
            text = format!("{text}: {cause}");
        }
    }
    text.replace('\n', " ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use anyhow::Context as _;

    #[test]
    fn every_result_has_its_status() {
        let of = |error: SeeError| Status::from(&anyhow::Error::from(error).context("cam0.png"));
        assert_eq!(Status::from(Outcome::Done) as u8, 0);
        assert_eq!(Status::from(Outcome::No) as u8, 1);
        assert_eq!(of(SeeError::Disagreement(12.0)) as u8, 1);
        assert_eq!(of(SeeError::NoVertical) as u8, 1);
        assert_eq!(of(SeeError::Up) as u8, 2);
        assert_eq!(Status::from(&anyhow::Error::from(TooMuchLeftOut("half".into()))) as u8, 1);
        assert_eq!(Status::from(&anyhow::anyhow!("no such file")) as u8, 2);
    }

    #[test]
    fn causes_are_not_repeated() {
        let error: anyhow::Result<()> = Err(SeeError::NoSky).context("a.png");
        let text = one_line(&error.context("localize").unwrap_err());
        assert!(text.starts_with("localize: a.png: cannot tell up from down"), "{text}");
        let repeated = anyhow::anyhow!("gone").context("a.png: cannot be read: gone");
        assert_eq!(one_line(&repeated), "a.png: cannot be read: gone");
    }
}
