import math
import threading
import time

import numpy as np
import pytest

import compass_localization as compass
from conftest import POSE, save_image


def off(pose):
    turn = (pose.heading_deg - POSE[2] + 180) % 360 - 180
    return math.hypot(pose.x - POSE[0], pose.y - POSE[1]), abs(turn)


def test_frames_find_their_place(fix):
    metres, degrees = off(fix)
    assert fix.is_sure and fix.reason is None and fix.probability > 0.9
    assert metres < 0.3 and degrees < 2
    assert fix.floor == "sample-building" and abs(fix.camera_height - 1.6) < 0.25
    assert 2 <= len(fix.candidates) <= 10 and fix.candidates[0].bits == fix.pose.bits
    assert np.linalg.norm(fix.up_in_cam0) == pytest.approx(1, abs=1e-5)


def test_covariances_are_positive_definite(fix):
    for pose in fix.candidates:
        covariance = pose.covariance
        assert covariance.shape == (3, 3) and np.array_equal(covariance, covariance.T)
        assert np.linalg.eigvalsh(covariance).min() > 0
    error = np.array([fix.x - POSE[0], fix.y - POSE[1]])
    assert error @ np.linalg.solve(fix.covariance[:2, :2], error) < 9


def test_the_command_gives_the_same_bits(command, fix, site, frames, tmp_path):
    site.save(tmp_path / "sample.site")
    for name, frame in zip(["cam0.ppm", "cam1.ppm"], frames):
        save_image(tmp_path / name, frame)
        assert np.array_equal(compass.read_image(tmp_path / name), frame)
    save_image(tmp_path / "plan.ppm", compass.sample_plan().image)
    (tmp_path / "poses.txt").write_text("1 4 17 1.6 0 0 0 1\n")
    # The simulator writes the calibration of its own rig.
    command("simulate", tmp_path / "plan.ppm", "--poses", tmp_path / "poses.txt", "--out", tmp_path / "rig", "--size", "32x32")
    calibration = next(path for path in [tmp_path / "rig" / "calibration.yaml"] if path.exists())
    rig = compass.Rig.from_kalibr(calibration, mount="inverted")
    for told, options in [
        ({}, []),
        ({"camera_height": 1.6}, ["--camera-height", 1.6]),
        ({"near": (4, 17, 3), "heading_near": (280, 40)}, ["--near", "4,17,3", "--heading-near", "280,40"]),
    ]:
        answer = command(
            *["localize", "--map", tmp_path / "sample.site", "--calib", calibration, "--mount", "inverted"],
            *["--cam0", tmp_path / "cam0.ppm", "--cam1", tmp_path / "cam1.ppm", *options],
        )
        here = compass.Locator(site, rig).locate(*frames, **told)
        assert here.pose.bits == answer["bits"]
        assert here.probability == pytest.approx(answer["probability"], abs=1e-6)
        assert [pose.score for pose in here.candidates] == [pose["score"] for pose in answer["candidates"]]
        assert np.allclose(here.covariance, answer["covariance"], rtol=1e-5, atol=1e-9)
    unsure = command(
        *["localize", "--map", tmp_path / "sample.site", "--calib", calibration, "--mount", "inverted"],
        *["--cam0", tmp_path / "cam0.ppm", "--cam1", tmp_path / "cam1.ppm", "--min-probability", 1],
        status=1,
    )
    here = compass.Locator(site, rig).locate(*frames, min_probability=1)
    assert here.reason == unsure["reason"] and len(here.candidates) == len(unsure["candidates"])


def test_what_is_not_sure_is_not_said(locator, frames):
    fix = locator.locate(*frames, min_probability=1)
    assert not fix.is_sure and fix.pose is None and fix.x is None and fix.covariance is None and fix.floor is None
    assert fix.reason and fix.candidates and "not sure" in repr(fix)
    assert "x" not in fix.to_dict() and fix.to_dict()["reason"] == fix.reason
    gray = np.full((720, 736), 90, np.uint8)
    blank = locator.locate(gray, gray)
    assert not blank.is_sure and "cannot tell which way is up" in blank.reason and blank.candidates == []
    assert "shows no detail" in blank.reason and blank.up_in_cam0 is None


def test_what_is_told_restricts_the_search(locator, frames):
    fix = locator.locate(*frames, near=(4, 17, 3), heading_near=(280, 40), floor="sample-building")
    assert all(math.hypot(pose.x - 4, pose.y - 17) <= 3 for pose in fix.candidates) and off(fix)[0] < 0.3
    elsewhere = locator.locate(*frames, near=(25, 5, 3), min_probability=0)
    assert math.hypot(elsewhere.x - 25, elsewhere.y - 5) <= 3


def test_arrays_of_all_kinds(locator, frames, fix):
    before = [frame.copy() for frame in frames]
    locked = [frame.copy() for frame in frames]
    for frame in locked:
        frame.setflags(write=False)
    assert locator.locate(*locked).pose.bits == fix.pose.bits, "read-only"
    fortran = [np.asfortranarray(frame) for frame in frames]
    assert locator.locate(*fortran).pose.bits == fix.pose.bits, "another memory order"
    assert all(np.array_equal(a, b) for a, b in zip(before, frames)), "arrays are not written to"
    single = locator.locate(cam1=frames[1], camera_height=1.6)
    assert single.candidates, "one camera is enough for candidates"


def test_wrong_input_is_named(locator, frames, site, rig):
    for wrong, words in [
        (lambda: locator.locate(), "no frame"),
        (lambda: locator.locate(frames[0].astype(float), frames[1]), "cam0: .*uint8.* not dtype float64"),
        (lambda: locator.locate(frames[0], [[1, 2]]), "cam1: .*uint8"),
        (lambda: locator.locate(frames[0], frames[1][..., :2]), r"cam1: .*not of shape \[720, 736, 2\]"),
        (lambda: locator.locate(np.zeros((0, 5), np.uint8)), "cam0: shape"),
        (lambda: locator.locate(frames[0][:300], frames[1]), "300"),
        (lambda: locator.locate(*frames, up=(0, 0, 0)), "up: "),
        (lambda: locator.locate(*frames, up=(0, math.nan, 0)), "up: "),
        (lambda: locator.locate(*frames, up=(0, 0, 1)), "heading"),
        (lambda: locator.locate(*frames, camera_height=9), "camera_height: 9"),
        (lambda: locator.locate(*frames, camera_height=math.nan), "camera_height: NaN"),
        (lambda: locator.locate(*frames, ceiling_between=(4, 2)), "ceiling_between"),
        (lambda: locator.locate(*frames, near=(1, 2, 0)), "near: "),
        (lambda: locator.locate(*frames, near=(math.inf, 2, 1)), "near: "),
        (lambda: locator.locate(*frames, heading_near=(1, -1)), "heading_near: "),
        (lambda: locator.locate(*frames, floor="attic"), "no floor \"attic\", but sample-building"),
        (lambda: locator.locate(*frames, min_probability=2), "min_probability: 2"),
        (lambda: locator.locate(*frames, track=compass.Track(), seconds=-1), "seconds: -1"),
        (lambda: locator.locate(*frames, track=compass.Track(), motion=(math.nan, 0, 0)), "motion: "),
        (lambda: compass.Locator(site, rig, settings="fast"), "settings: \"fast\""),
        (lambda: compass.Rig.nominal(mount="sideways"), "mount: \"sideways\""),
        (lambda: compass.Rig.from_kalibr("missing.yaml"), "missing.yaml"),
        (lambda: compass.read_image("missing.png"), "missing.png"),
    ]:
        with pytest.raises(compass.CompassError, match=words):
            wrong()


def test_a_track_believes_what_it_sees_again(locator, frames):
    track = compass.Track()
    assert locator.locate(*frames).estimate is None
    first = locator.locate(*frames, track=track).estimate
    again = locator.locate(*frames, track=track, seconds=0.2, motion=(0, 0, 0)).estimate
    assert off(again.pose)[0] < 0.3 and again.probability >= first.probability > 0.5
    track.forget()
    assert locator.locate(*frames, track=track).estimate.probability == first.probability


def test_other_threads_run_meanwhile(locator, frames):
    done, count = threading.Event(), 0

    def work():
        for _ in range(5):
            locator.locate(*frames)
        done.set()

    thread = threading.Thread(target=work)
    thread.start()
    while not done.is_set():
        count += 1
        time.sleep(0.001)
    thread.join()
    assert count > 20, "the interpreter was locked"


def test_see_gives_arrays(locator, frames, command, tmp_path):
    seen = locator.see(*frames)
    assert seen["channels"].shape == (5, 360) and seen["hit"].dtype == np.uint8
    for name in ["range_m", "hit", "confidence", "evidence"]:
        assert seen[name].shape == (360,)
    assert set(np.unique(seen["hit"])) <= {0, 1, 2, 255} and 0 <= seen["confidence"].min() <= seen["confidence"].max() <= 1
    known = seen["range_m"][~np.isnan(seen["range_m"])]
    assert len(known) > 180 and 0.2 < known.min() and known.max() <= 30


def test_answers_show_themselves(fix, site, rig, locator, plan):
    html = fix._repr_html_()
    assert "data:image/png;base64,iVBOR" in html
    assert repr(fix).startswith("Fix(x=4.1") and "sample-building" in repr(site)
    assert repr(rig) == 'Rig(2 camera(s), mount="inverted")'
    assert repr(plan) and repr(locator) and repr(fix.pose)
