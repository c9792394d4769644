//! `compass map build`, `compass map join` and `compass map info`.

mod build;
mod info;
mod join;

use super::exit::Outcome;
use anyhow::Result;

#[derive(Debug, clap::Subcommand)]
pub(super) enum Map {
    /// Build the site file of a plan: one floor with its site map and its packed plans
    Build(Box<build::Build>),
    /// Join the floors of several site files into one
    Join(join::Join),
    /// Print what is in a site file or a plain site map
    Info(info::Info),
}

impl Map {
    pub(super) fn run(&self) -> Result<Outcome> {
        match self {
            Self::Build(command) => command.run(),
            Self::Join(command) => command.run(),
            Self::Info(command) => command.run(),
        }
    }
}
