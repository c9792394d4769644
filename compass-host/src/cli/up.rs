//! What tells which way is up, as options.

use compass_host::up::{Mount, UpFrom};

/// [`Mount`] as `--mount` takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum MountOption {
    /// Not told: with a site both are tried and the plan decides; else the windows tell, by the bright sky
    Auto,
    /// The top
    Upright,
    /// The bottom
    Inverted,
}

impl From<MountOption> for Mount {
    fn from(option: MountOption) -> Self {
        match option {
            MountOption::Auto => Self::Auto,
            MountOption::Upright => Self::Upright,
            MountOption::Inverted => Self::Inverted,
        }
    }
}

/// [`UpFrom`] as `--up-from` takes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum UpFromOption {
    /// Vertical lines
    Image,
    /// The accelerometer
    Imu,
    /// The vertical lines near where the accelerometer says
    Both,
}

impl From<UpFromOption> for UpFrom {
    fn from(option: UpFromOption) -> Self {
        match option {
            UpFromOption::Image => Self::Image,
            UpFromOption::Imu => Self::Imu,
            UpFromOption::Both => Self::Both,
        }
    }
}
