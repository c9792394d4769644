//! Types of messages.

/// What a topic carries.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// `sensor_msgs/msg/Image`.
    Image,
    /// `sensor_msgs/msg/CompressedImage`.
    CompressedImage,
    /// `foxglove_msgs/msg/RawImage`.
    FoxgloveImage,
    /// `foxglove_msgs/msg/CompressedImage`.
    FoxgloveCompressedImage,
    /// `sensor_msgs/msg/Imu`.
    Imu,
    /// Packets of a video, which are not read.
    Video,
    /// Anything else.
    Other,
}

impl Kind {
    /// The kind of a type; the old spelling without `/msg/` is the same.
    pub(super) fn of(name: &str) -> Self {
        let parts: Vec<_> = name.split('/').filter(|part| *part != "msg").collect();
        match parts[..] {
            ["sensor_msgs", "Image"] => Self::Image,
            ["sensor_msgs", "CompressedImage"] => Self::CompressedImage,
            ["sensor_msgs", "Imu"] => Self::Imu,
            ["foxglove_msgs", "RawImage"] | ["foxglove.RawImage"] => Self::FoxgloveImage,
            ["foxglove_msgs", "CompressedImage"] | ["foxglove.CompressedImage"] => {
                Self::FoxgloveCompressedImage
            }
            ["foxglove_msgs", "CompressedVideo"] | ["foxglove.CompressedVideo"] => Self::Video,
            [package, "FFMPEGPacket" | "Packet"] if package.contains("image_transport") => Self::Video,
            [package, "H264Packet" | "Packet"] if package.starts_with("h264") => Self::Video,
            _ => Self::Other,
        }
    }

    pub(super) const fn is_image(self) -> bool {
        matches!(
            self,
            Self::Image | Self::CompressedImage | Self::FoxgloveImage | Self::FoxgloveCompressedImage
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_spellings_are_one_kind() {
        for (name, kind) in [
            ("sensor_msgs/msg/CompressedImage", Kind::CompressedImage),
            ("sensor_msgs/CompressedImage", Kind::CompressedImage),
            ("sensor_msgs/Image", Kind::Image),
            ("sensor_msgs/Imu", Kind::Imu),
            ("foxglove_msgs/msg/RawImage", Kind::FoxgloveImage),
            ("ffmpeg_image_transport_msgs/msg/FFMPEGPacket", Kind::Video),
            ("theora_image_transport/msg/Packet", Kind::Video),
            ("foxglove_msgs/CompressedVideo", Kind::Video),
            ("my_msgs/msg/Image", Kind::Other),
        ] {
            assert_eq!(Kind::of(name), kind, "{name}");
        }
    }
}
