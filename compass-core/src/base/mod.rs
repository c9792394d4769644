//! Vocabulary shared by all wings: number formats, angles, rasters, scans, poses. No algorithm of the field.

pub mod circle;
pub mod confidence;
pub mod crc;
pub mod ladder;
pub mod num;
pub(crate) mod order;
pub mod pose;
pub mod raster;
pub mod scan;
