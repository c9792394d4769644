//! What was left out of a recording, once all frames were tried.

use crate::cli::exit::TooMuchLeftOut;
use compass_host::calibration::Calibration;
use compass_host::dataset::faults::Item;
use compass_host::dataset::recording::Recording;
use compass_host::evaluate::Record;

/// Adds what localizing the frames has shown: images that cannot be read, both lenses in one image, an IMU without its
/// place.
pub(super) fn complete(
    recording: &mut Recording,
    calibration: &Calibration,
    records: &[Record],
    has_imu: bool,
) {
    for record in records.iter().filter(|record| record.is_unreadable) {
        let (seconds, ns) = (record.timestamp_ns / 1_000_000_000, record.timestamp_ns % 1_000_000_000);
        let problem = record.problem.clone().unwrap_or_default();
        recording.faults.withdraw(Item::Frame, format!("frame at {seconds}.{ns:09} s"), problem);
    }
    if let Some(halves) = records.iter().find_map(|record| record.halves.clone()) {
        recording.notes.push(halves);
    }
    let lacks_place = calibration.cameras[0].as_ref().is_some_and(|camera| camera.from_imu.is_none());
    if has_imu && lacks_place {
        recording.notes.push(format!(
            "the readings of the IMU are not used: {}: {} has neither T_cam_imu nor T_imu_cam",
            calibration.path.display(),
            calibration.name(0)
        ));
    }
}

/// Refuses a result for which too much was left out.
pub(super) fn check_share(
    recording: &Recording,
    records: &[Record],
    most: f64,
) -> Result<(), TooMuchLeftOut> {
    let unreadable = records.iter().filter(|record| record.is_unreadable).count();
    let faults = &recording.faults;
    let shares = Item::ALL.map(|item| (item.plural(), faults.left_out(item), faults.total(item)));
    let all = shares.into_iter().chain([("frames", unreadable, records.len())]);
    let above =
        |(_, left_out, total): &(&str, usize, usize)| *left_out as f64 > most * (*total).max(1) as f64;
    let Some((items, left_out, total)) = all.into_iter().find(above) else { return Ok(()) };
    let first =
        faults.first().first().map(|fault| format!("; the first: {}: {}", fault.place, fault.problem));
    Err(TooMuchLeftOut(format!(
        "{left_out} of {total} {items} were left out, more than a share of {most} (--max-left-out){}",
        first.unwrap_or_default()
    )))
}
