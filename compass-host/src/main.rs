//! The `compass` command.

use clap::Parser as _;
use compass_host::commands::{Cli, Disagreement, Outcome};
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
            ExitCode::from(if error.is::<Disagreement>() { 1 } else { 2 })
        }
    }
}
