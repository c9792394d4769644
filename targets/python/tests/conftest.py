import json
import os
import subprocess

import numpy as np
import pytest

import compass_localization as compass

# A pose in the hall of the sample building: x, y, heading.
POSE = (4.12, 17.77, 288.6)


@pytest.fixture(scope="session")
def plan():
    return compass.sample_plan()


@pytest.fixture(scope="session")
def site(plan):
    return compass.Site.build(plan)


@pytest.fixture(scope="session")
def rig():
    return compass.Rig.nominal(mount="inverted")


@pytest.fixture(scope="session")
def frames(plan, rig):
    return compass.simulate(plan, rig, *POSE, pitch=4.0, roll=187.0)


@pytest.fixture(scope="session")
def locator(site, rig):
    return compass.Locator(site, rig)


@pytest.fixture(scope="session")
def fix(locator, frames):
    return locator.locate(*frames)


@pytest.fixture(scope="session")
def command():
    """Runs the `compass` command and gives its JSON, where COMPASS_COMMAND names one."""
    path = os.environ.get("COMPASS_COMMAND")
    if not path:
        pytest.skip("COMPASS_COMMAND does not name the compass command")

    def run(*arguments, status=0):
        ran = subprocess.run([path, *map(str, arguments), "--json", "-"], capture_output=True, text=True)
        assert ran.returncode == status, ran.stderr
        return json.loads(ran.stdout)

    return run


def save_image(path, image):
    """Writes an image as binary PPM or PGM, which every reader takes."""
    kind = b"P6" if image.ndim == 3 else b"P5"
    with open(path, "wb") as file:
        file.write(b"%s %d %d 255\n" % (kind, image.shape[1], image.shape[0]))
        file.write(np.ascontiguousarray(image).tobytes())
