//! The `compass` command.

use clap::Parser as _;
use compass_host::commands::{Cli, Outcome};
use std::process::ExitCode;

fn main() -> ExitCode {
    match Cli::parse().run() {
        Ok(Outcome::Done) => ExitCode::SUCCESS,
        Ok(Outcome::No) => ExitCode::from(1),
        Err(error) => {
            // One line, whatever the chain of causes.
            let text = format!("{error:#}").replace('\n', " ");
            eprintln!("compass: {text}");
            ExitCode::from(2)
        }
    }
}
