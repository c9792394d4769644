//! The subcommands, one file each.

mod cameras;
mod compare;
mod compare_hits;
mod debug;
mod demo;
mod describe;
mod evaluate;
mod exit;
mod fit;
mod gravity;
mod heights;
mod json;
mod localize;
mod map;
#[cfg(feature = "ros2")]
mod node;
mod notes;
mod pack;
mod pictures;
mod places;
mod plan;
mod pose;
mod prior;
mod progress;
mod see;
mod segments;
mod show_plan;
mod simulate;
mod up;
mod windows;

use clap::{Parser, Subcommand};
use compass_host::input::{Limits, set_limits};
use exit::Outcome;
use std::process::ExitCode;

/// Where am I in this building? All it takes is the architect's floor plan.
#[derive(Debug, Parser)]
#[command(name = "compass", version, about)]
struct Cli {
    /// Read input N times as large as the limits allow that keep a stranger's file from filling the memory
    #[arg(long, global = true, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    raise_limits: u32,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run the whole pipeline on the bundled sample building and write a report with pictures
    Demo(demo::Demo),
    /// Cast the descriptor of a position from a plan
    Describe(describe::Describe),
    /// Show what is understood of a plan: a picture and a summary, and masks for other programs
    Plan(show_plan::ShowPlan),
    /// Build site files, join them, or print what is in one
    #[command(subcommand)]
    Map(map::Map),
    /// Find floor, position and heading on a site
    Localize(localize::Localize),
    /// Localize a recording frame by frame and as a sequence, and hold it against the truth
    Evaluate(evaluate::Evaluate),
    /// Fit constants to localizations of known poses
    #[command(subcommand)]
    Fit(fit::Fit),
    /// Pack the frames of one or two cameras as a board reads them
    Pack(pack::Pack),
    /// Compare the fixed-point core with the float reference, stage by stage
    Compare(compare::Compare),
    /// Compare window or wall as the cameras see it with the plan at a known pose
    CompareHits(compare_hits::CompareHits),
    /// Find the line segments of an image
    Segments(segments::Segments),
    /// Find the windows in one camera's frame
    Windows(windows::Windows),
    /// Tell which way is up from vertical lines
    Gravity(gravity::Gravity),
    /// Tell window from wall in every direction from one or two cameras
    See(see::See),
    /// Render the frames of two fisheye cameras from a plan
    Simulate(simulate::Simulate),
    /// Run as a ROS 2 node: frames on topics become poses on topics
    #[cfg(feature = "ros2")]
    Node(node::Node),
}

impl Cli {
    /// Runs the subcommand; an error names the thing at fault and the place.
    fn run(&self) -> anyhow::Result<Outcome> {
        set_limits(Limits::DEFAULT.raised(self.raise_limits));
        match &self.command {
            Command::Demo(command) => command.run(),
            Command::Describe(command) => command.run(),
            Command::Plan(command) => command.run(),
            Command::Map(command) => command.run(),
            Command::Localize(command) => command.run(),
            Command::Evaluate(command) => command.run(),
            Command::Fit(command) => command.run(),
            Command::Pack(command) => command.run(),
            Command::Compare(command) => command.run(),
            Command::CompareHits(command) => command.run(),
            Command::Segments(command) => command.run(),
            Command::Windows(command) => command.run(),
            Command::Gravity(command) => command.run(),
            Command::See(command) => command.run(),
            Command::Simulate(command) => command.run(),
            #[cfg(feature = "ros2")]
            Command::Node(command) => command.run(),
        }
    }
}

/// The command line; a wrong one ends the process.
#[cfg(not(feature = "ros2"))]
#[expect(clippy::unnecessary_wraps, reason = "with ROS arguments it may fail")]
fn parse() -> anyhow::Result<Cli> {
    Ok(Cli::parse())
}

/// The command line, in which arguments of ROS are options; a wrong one ends the process.
#[cfg(feature = "ros2")]
fn parse() -> anyhow::Result<Cli> {
    let arguments = std::env::args_os();
    if !std::env::args_os().any(|argument| argument == "--ros-args") {
        return Ok(Cli::parse_from(arguments));
    }
    let arguments = arguments.map(|argument| argument.to_string_lossy().into_owned());
    Ok(Cli::parse_from(node::from_ros(arguments)?))
}

/// Runs the command line of the process.
pub(crate) fn main() -> ExitCode {
    exit::clean_up_when_interrupted();
    exit::code(parse().and_then(|cli| cli.run()))
}
