from os import PathLike
from typing import Any, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import NDArray

Path = Union[str, PathLike[str]]
Image = NDArray[np.uint8]

__version__: str
__all__: List[str]

class CompassError(ValueError):
    """Input that COMPASS cannot use; the message names it and what is wrong with it."""

class Plan:
    """A floor plan: a raster of walls and glazing."""

    @property
    def name(self) -> str: ...
    @property
    def size(self) -> Tuple[float, float]: ...
    @property
    def resolution(self) -> float: ...
    @property
    def origin(self) -> List[float]: ...
    @property
    def notes(self) -> List[str]: ...
    @property
    def image(self) -> Image: ...
    def scan(self, x: float, y: float, heading: float = 0.0) -> Tuple[NDArray[np.float64], NDArray[np.uint8]]: ...
    def describe(self, x: float, y: float, heading: float = 0.0) -> NDArray[np.float64]: ...

class Site:
    """The floors of a building, each with its plan and its candidates."""

    @staticmethod
    def build(
        plan: Plan,
        spacing: float = 0.5,
        *,
        name: Optional[str] = None,
        clearance: Optional[float] = None,
        max_gap: Optional[float] = None,
        inside: Optional[Sequence[Sequence[float]]] = None,
        region: Optional[Sequence[float]] = None,
        layers: int = 2,
    ) -> Site: ...
    @staticmethod
    def open(path: Path) -> Site: ...
    def save(self, path: Path) -> None: ...
    def to_bytes(self) -> bytes: ...
    @property
    def floors(self) -> List[str]: ...
    def candidates(self, floor: int = 0) -> NDArray[np.float64]: ...

class Rig:
    """One or two calibrated cameras, and which side of cam0's image is up."""

    @staticmethod
    def from_kalibr(path: Path, mount: str = "auto", *, cameras: Optional[str] = None) -> Rig: ...
    @staticmethod
    def nominal(mount: str = "auto") -> Rig: ...
    @property
    def mount(self) -> str: ...

class Pose:
    """A pose of cam0 on a floor, with its score and covariance."""

    @property
    def x(self) -> float: ...
    @property
    def y(self) -> float: ...
    @property
    def heading_deg(self) -> float: ...
    @property
    def score(self) -> float: ...
    @property
    def floor(self) -> str: ...
    @property
    def bits(self) -> str: ...
    @property
    def covariance(self) -> Optional[NDArray[np.float64]]: ...
    def to_dict(self) -> Dict[str, Any]: ...

class Estimate:
    """What a track believes."""

    @property
    def pose(self) -> Pose: ...
    @property
    def probability(self) -> float: ...
    @property
    def spread_m(self) -> float: ...

class Track:
    """A belief over a sequence of frames: give it to Locator.locate with each."""

    def __init__(self) -> None: ...
    def forget(self) -> None: ...

class Fix:
    """Where the cameras are, or why that is not sure."""

    @property
    def pose(self) -> Optional[Pose]: ...
    @property
    def x(self) -> Optional[float]: ...
    @property
    def y(self) -> Optional[float]: ...
    @property
    def heading_deg(self) -> Optional[float]: ...
    @property
    def floor(self) -> Optional[str]: ...
    @property
    def covariance(self) -> Optional[NDArray[np.float64]]: ...
    @property
    def candidates(self) -> List[Pose]: ...
    @property
    def estimate(self) -> Optional[Estimate]: ...
    @property
    def is_sure(self) -> bool: ...
    @property
    def reason(self) -> Optional[str]: ...
    @property
    def probability(self) -> float: ...
    @property
    def margin(self) -> float: ...
    @property
    def camera_height(self) -> float: ...
    @property
    def ceiling_height(self) -> float: ...
    @property
    def up_in_cam0(self) -> Optional[List[float]]: ...
    def to_dict(self) -> Dict[str, Any]: ...

class Locator:
    """Finds the poses of a rig on a site."""

    def __init__(self, site: Site, rig: Rig, settings: str = "full") -> None: ...
    def locate(
        self,
        cam0: Optional[Image] = None,
        cam1: Optional[Image] = None,
        *,
        up: Optional[Sequence[float]] = None,
        camera_height: Optional[float] = None,
        ceiling_between: Optional[Sequence[float]] = None,
        near: Optional[Sequence[float]] = None,
        heading_near: Optional[Sequence[float]] = None,
        floor: Optional[str] = None,
        min_probability: float = 0.5,
        track: Optional[Track] = None,
        seconds: float = 0.0,
        motion: Optional[Sequence[float]] = None,
    ) -> Fix: ...
    def see(
        self,
        cam0: Optional[Image] = None,
        cam1: Optional[Image] = None,
        *,
        up: Optional[Sequence[float]] = None,
        camera_height: Optional[float] = None,
    ) -> Dict[str, Any]: ...

def evaluate(
    site: Site,
    rig: Rig,
    dataset: Path,
    groundtruth: Path,
    *,
    odometry: Optional[Path] = None,
    floor: Optional[str] = None,
    camera_height: Optional[float] = None,
    every: int = 1,
) -> Dict[str, Any]: ...
def load_plan(
    path: Path,
    *,
    walls: Optional[Path] = None,
    resolution: Optional[float] = None,
    origin: Optional[Sequence[float]] = None,
    invert: bool = False,
    min_thickness: Optional[float] = None,
    scale: Optional[float] = None,
    page: int = 1,
) -> Plan: ...
def sample_plan() -> Plan: ...
def read_image(path: Path) -> Image: ...
def simulate(
    plan: Plan,
    rig: Rig,
    x: float,
    y: float,
    heading: float,
    *,
    z: float = 1.6,
    pitch: float = 0.0,
    roll: float = 180.0,
    size: Tuple[int, int] = (736, 720),
    seed: int = 1,
    ceiling: float = 2.75,
    clutter: int = 2,
    people: int = 1,
    missing: float = 0.0,
) -> Tuple[Optional[Image], Optional[Image]]: ...
