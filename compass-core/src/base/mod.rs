//! The vocabulary of all wings; no algorithm of the field.

pub mod circle;
pub mod confidence;
pub mod crc;
pub mod ladder;
pub mod num;
pub(crate) mod order;
pub mod pose;
pub mod raster;
pub mod scan;
