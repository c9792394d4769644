//! COMPASS in the browser: the module that the page in `page/` loads.
//!
//! Nothing is computed here. Requests become calls of `compass-host`, its results become replies, so that an answer has the
//! bits of the `compass` command. Nothing is sent anywhere: the module has no imports but one that is told of progress.
//!
//! A message, in either direction, is the length of its JSON (four bytes, little-endian), the JSON, and bytes that belong to it.
//! [`Session::answer`] lists the requests.

mod abi;
mod message;
mod place;
mod plan;
mod progress;
mod session;

pub use message::{Reply, error, reply};
pub use session::Session;
