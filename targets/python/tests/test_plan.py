import time

import numpy as np
import pytest

import compass_localization as compass
from conftest import POSE, save_image


def test_a_plan_has_its_size_and_picture(plan):
    assert plan.size == (32.0, 22.0) and plan.resolution == 0.01 and plan.origin == [0.0, 0.0]
    image = plan.image
    assert image.shape == (2200, 3200, 3) and image.dtype == np.uint8
    colours = {tuple(colour) for colour in np.unique(image.reshape(-1, 3), axis=0)}
    assert colours == {(0, 0, 0), (255, 0, 0), (255, 255, 255)}


def test_a_descriptor_follows_its_scan(plan):
    x, y, heading = POSE
    channels, (range_m, hit) = plan.describe(x, y, heading), plan.scan(x, y, heading)
    assert channels.shape == (5, 360) and channels.dtype == np.float64
    assert range_m.shape == (360,) and set(np.unique(hit)) <= {0, 1, 2}
    # The core rounds channels to 14 bits.
    assert np.abs(channels[0] - range_m / 30).max() < 1e-4
    assert np.abs(channels[3] - 1 / (1 + range_m)).max() < 1e-4
    assert np.array_equal(channels[1], np.array([0.0, 0.5, 1.0])[hit])
    turned = plan.describe(x, y, heading + 90)
    assert np.abs(np.roll(turned, 90, axis=1) - channels)[0].mean() < 0.01


def test_a_saved_picture_reads_as_the_same_plan(plan, tmp_path):
    save_image(tmp_path / "again.ppm", plan.image)
    again = compass.load_plan(tmp_path / "again.ppm")
    assert again.name == "again"
    assert np.array_equal(again.image, plan.image)
    assert np.array_equal(again.describe(*POSE), plan.describe(*POSE))


def test_a_description_takes_less_than_a_millisecond(plan):
    # Most of it is the marching of 360 rays; the call itself is a few microseconds.
    times = []
    for _ in range(50):
        start = time.perf_counter()
        plan.describe(*POSE)
        times.append(time.perf_counter() - start)
    assert sorted(times)[25] < 1e-3


def test_bad_plans_are_named(plan, tmp_path):
    (tmp_path / "text.png").write_text("no picture")
    with pytest.raises(compass.CompassError, match="text.png"):
        compass.load_plan(tmp_path / "text.png")
    with pytest.raises(compass.CompassError, match="missing.png"):
        compass.load_plan(tmp_path / "missing.png")
    with pytest.raises(compass.CompassError, match="sample-building: .*outside"):
        plan.describe(-5, 0)
    with pytest.raises(compass.CompassError, match="x: NaN is not a finite number"):
        plan.scan(float("nan"), 0)
    with pytest.raises(TypeError):
        plan.describe("here", 0)
