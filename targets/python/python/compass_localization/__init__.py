"""COMPASS: where am I in this building?

From the frames of one or two fisheye cameras and the architect's floor plan to a pose, without training, GPU or initial
pose. Lengths are metres, headings degrees counter-clockwise from +x, map axes x right and y up.

>>> import compass_localization as compass
>>> site = compass.Site.build(compass.load_plan("floor.png"))
>>> rig = compass.Rig.from_kalibr("camchain.yaml", mount="inverted")
>>> fix = compass.Locator(site, rig).locate(compass.read_image("cam0.png"), compass.read_image("cam1.png"))
"""

from ._native import (
    CompassError,
    Estimate,
    Fix,
    Locator,
    Plan,
    Pose,
    Rig,
    Site,
    Track,
    __version__,
    evaluate,
    load_plan,
    read_image,
    sample_plan,
    simulate,
)

__all__ = [
    "CompassError",
    "Estimate",
    "Fix",
    "Locator",
    "Plan",
    "Pose",
    "Rig",
    "Site",
    "Track",
    "__version__",
    "evaluate",
    "load_plan",
    "read_image",
    "sample_plan",
    "simulate",
]
