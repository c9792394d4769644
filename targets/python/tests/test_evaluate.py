import json
import math

import numpy as np
import pytest

import compass_localization as compass

# Heading, and the quaternion of a camera that hangs upside down and looks level that way.
HALF = math.sqrt(0.5)
LOOKS = {0: (0.5, 0.5, 0.5, 0.5), 90: (0.0, HALF, HALF, 0.0)}
PLACES = [(3000, 4.1, 17.8, 90), (3001, 13.4, 3.7, 0), (3002, 25.5, 15.2, 90)]


@pytest.fixture(scope="module")
def recording(plan, site, command, tmp_path_factory):
    folder = tmp_path_factory.mktemp("recording")
    poses = folder / "poses.txt"
    lines = [" ".join(map(str, (time, x, y, 1.6, *LOOKS[heading]))) for time, x, y, heading in PLACES]
    poses.write_text("\n".join(lines))
    image = plan.image
    with open(folder / "plan.ppm", "wb") as file:
        file.write(b"P6 %d %d 255\n" % (image.shape[1], image.shape[0]) + image.tobytes())
    command("simulate", folder / "plan.ppm", "--poses", poses, "--out", folder / "data")
    site.save(folder / "sample.site")
    return folder


def test_columns_are_those_of_the_command(recording, site, command):
    data = recording / "data"
    rig = compass.Rig.from_kalibr(data / "calibration.yaml", mount="inverted")
    columns = compass.evaluate(site, rig, data, data / "groundtruth.txt")
    assert len({len(column) for column in columns.values()}) == 1 and len(columns["problem"]) == len(PLACES)
    command(
        "evaluate", "--map", recording / "sample.site", "--calib", data / "calibration.yaml", "--mount", "inverted",
        "--dataset", data, "--groundtruth", data / "groundtruth.txt", "--out", recording / "out",
    )  # fmt: skip
    records = {}
    for line in (recording / "out" / "frames.jsonl").read_text().splitlines():
        record = json.loads(line)
        if "timestamp_ns" in record:
            records[record["timestamp_ns"]] = record
    assert sorted(records) == columns["timestamp_ns"].tolist()
    for number, time in enumerate(columns["timestamp_ns"].tolist()):
        best = records[time]["single"][0]
        assert columns["x"][number] == best["x"] / 2**32
        assert columns["y"][number] == best["y"] / 2**32
    places = np.array([[x, y, heading] for _, x, y, heading in PLACES], dtype=float)
    true = np.stack([columns["true_x"], columns["true_y"], columns["true_heading_deg"]], axis=1)
    assert np.allclose(true, places, atol=1e-3)
    apart = np.hypot(columns["x"] - columns["true_x"], columns["y"] - columns["true_y"])
    assert np.allclose(apart, columns["error_m"]) and np.median(apart) < 0.3
    assert ((columns["probability"] >= 0) & (columns["probability"] <= 1)).all()


@pytest.mark.parametrize(
    "change, message",
    [
        ({"every": 0}, "every: "),
        ({"floor": "attic"}, 'no floor "attic"'),
        ({"dataset": "nowhere"}, "nowhere"),
        ({"groundtruth": "nowhere.txt"}, "nowhere.txt"),
        ({"camera_height": 9.0}, "camera_height: "),
    ],
)
def test_wrong_input_is_named(recording, site, rig, change, message):
    data = recording / "data"
    told = {"dataset": data, "groundtruth": data / "groundtruth.txt", **change}
    with pytest.raises(compass.CompassError, match=message):
        compass.evaluate(site, rig, told.pop("dataset"), told.pop("groundtruth"), **told)


def test_a_truth_of_another_time_is_refused(recording, site, rig, tmp_path):
    late = tmp_path / "late.txt"
    late.write_text("9000 1 1 1 0.5 0.5 0.5 0.5\n9001 1 1 1 0.5 0.5 0.5 0.5\n")
    with pytest.raises(compass.CompassError, match="no pose at the time of any frame"):
        compass.evaluate(site, rig, recording / "data", late)
