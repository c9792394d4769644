//! The `compass` command.

mod cli;

use clap::Parser as _;
use cli::{Cli, Outcome};
use compass_host::eyes::EyesError;
use std::process::ExitCode;

/// The chain of causes in one line; a cause that the message before it already ends with is not repeated.
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

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::No) => ExitCode::from(1),
        Err(error) => {
            eprintln!("compass: {}", one_line(&error));
            // The one error that is an answer.
            let no = matches!(error.downcast_ref(), Some(EyesError::Disagreement(_)));
            ExitCode::from(if no { 1 } else { 2 })
        }
    }
}
