//! The host side of COMPASS.
