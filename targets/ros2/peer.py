"""Talks to `compass node` as a peer of another make: Cyclone DDS publishes frames and hears what comes back.

    python peer.py COMPASS FOLDER [--soak SECONDS --rate HZ]

FOLDER is what `compass demo --out` writes under `seen`: site, calibration and a pair of frames; the plan lies beside it. Run it in a
network of its own, so that no packet leaves the machine (`.ci/run ros2`). Exit status 0 if the poses are those of `compass localize`
and, of a recording, those of `compass evaluate`, to the bit.
"""

import argparse
import json
import math
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic
from cyclonedds.util import duration


def ros(package, name):
    return f"{package}::msg::dds_::{name}_"


@dataclass
class Time(IdlStruct, typename=ros("builtin_interfaces", "Time")):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename=ros("std_msgs", "Header")):
    stamp: Time
    frame_id: str


@dataclass
class CompressedImage(IdlStruct, typename=ros("sensor_msgs", "CompressedImage")):
    header: Header
    format: str
    data: sequence[uint8]


@dataclass
class Image(IdlStruct, typename=ros("sensor_msgs", "Image")):
    header: Header
    height: uint32
    width: uint32
    encoding: str
    is_bigendian: uint8
    step: uint32
    data: sequence[uint8]


@dataclass
class Point(IdlStruct, typename=ros("geometry_msgs", "Point")):
    x: float64
    y: float64
    z: float64


@dataclass
class Vector3(IdlStruct, typename=ros("geometry_msgs", "Vector3")):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename=ros("geometry_msgs", "Quaternion")):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename=ros("geometry_msgs", "Pose")):
    position: Point
    orientation: Quaternion


@dataclass
class PoseWithCovariance(IdlStruct, typename=ros("geometry_msgs", "PoseWithCovariance")):
    pose: Pose
    covariance: array[float64, 36]


@dataclass
class PoseWithCovarianceStamped(IdlStruct, typename=ros("geometry_msgs", "PoseWithCovarianceStamped")):
    header: Header
    pose: PoseWithCovariance


@dataclass
class PoseArray(IdlStruct, typename=ros("geometry_msgs", "PoseArray")):
    header: Header
    poses: sequence[Pose]


@dataclass
class Twist(IdlStruct, typename=ros("geometry_msgs", "Twist")):
    linear: Vector3
    angular: Vector3


@dataclass
class TwistWithCovariance(IdlStruct, typename=ros("geometry_msgs", "TwistWithCovariance")):
    twist: Twist
    covariance: array[float64, 36]


@dataclass
class Odometry(IdlStruct, typename=ros("nav_msgs", "Odometry")):
    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


@dataclass
class Transform(IdlStruct, typename=ros("geometry_msgs", "Transform")):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename=ros("geometry_msgs", "TransformStamped")):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename=ros("tf2_msgs", "TFMessage")):
    transforms: sequence[TransformStamped]


@dataclass
class KeyValue(IdlStruct, typename=ros("diagnostic_msgs", "KeyValue")):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename=ros("diagnostic_msgs", "DiagnosticStatus")):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename=ros("diagnostic_msgs", "DiagnosticArray")):
    header: Header
    status: sequence[DiagnosticStatus]


SENSOR = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(5))
RELIABLE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(100))
KEPT = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(10), Policy.Durability.TransientLocal
)


class Peer:
    def __init__(self):
        self.participant = DomainParticipant(0)
        self.images = [self.writer(f"/cam{n}/image_raw/compressed", CompressedImage) for n in range(2)]
        self.odometry = self.writer("/odom", Odometry)
        self.pose = self.reader("/compass/pose", PoseWithCovarianceStamped, RELIABLE)
        self.candidates = self.reader("/compass/candidates", PoseArray, RELIABLE)
        self.initial = self.reader("/initialpose", PoseWithCovarianceStamped, KEPT)
        self.tf = self.reader("/tf", TFMessage, RELIABLE)
        self.diagnostics = self.reader("/diagnostics", DiagnosticArray, RELIABLE)

    def topic(self, name, kind):
        return Topic(self.participant, f"rt{name}", kind)

    def writer(self, name, kind):
        return DataWriter(self.participant, self.topic(name, kind), qos=SENSOR)

    def reader(self, name, kind, qos):
        return DataReader(self.participant, self.topic(name, kind), qos=qos)

    def send(self, frames, stamp):
        for writer, frame in zip(self.images, frames):
            writer.write(CompressedImage(Header(stamp, "cam"), "png", frame))

    def send_odometry(self, stamp):
        still = TwistWithCovariance(Twist(Vector3(0, 0, 0), Vector3(0, 0, 0)), [0.0] * 36)
        pose = Pose(Point(1.0, 2.0, 0.0), Quaternion(0, 0, math.sin(0.15), math.cos(0.15)))
        self.odometry.write(Odometry(Header(stamp, "odom"), "base", PoseWithCovariance(pose, [0.0] * 36), still))


def waited(reader, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        taken = [sample for sample in reader.take(N=64) if hasattr(sample, "header") or hasattr(sample, "transforms")]
        if taken:
            return taken
        time.sleep(0.002)
    return []


def yaw(q):
    return math.degrees(math.atan2(2 * (q.w * q.z + q.x * q.y), 1 - 2 * (q.y * q.y + q.z * q.z)))


def check(condition, what):
    if not condition:
        raise SystemExit(f"FAILED: {what}")
    print(f"ok      {what}")


def memory_kib(process):
    with open(f"/proc/{process.pid}/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS"))


def answers(peer, expected, frames):
    """One pair of frames gives the pose of the command."""
    # Discovery takes a moment, and a best-effort message before it is lost.
    poses, tries = [], 0
    while not poses and tries < 20:
        tries += 1
        peer.send_odometry(Time(1000 + tries, 0))
        peer.send(frames, Time(1000 + tries, 500))
        poses = waited(peer.pose, 3)
    check(poses, f"a pose after {tries} pairs")
    pose = poses[0]
    at, covariance = pose.pose.pose.position, pose.pose.covariance
    check((at.x, at.y, at.z) == (expected["x"], expected["y"], 0.0), f"x, y are the command's: {at.x:.6f}, {at.y:.6f}")
    turn = (yaw(pose.pose.pose.orientation) - expected["heading_deg"] + 180) % 360 - 180
    check(abs(turn) < 1e-5, "so is the heading")
    wanted = [expected["covariance"][row][column] for row in range(3) for column in range(3)]
    found = [covariance[6 * row + column] for row in (0, 1, 5) for column in (0, 1, 5)]
    check(all(abs(a - b) < 1e-9 for a, b in zip(wanted, found)), "and the covariance")
    check((pose.header.frame_id, pose.header.stamp.nanosec) == ("map", 500), "the stamp is that of the frames")
    check(len(waited(peer.candidates, 2)[0].poses) == len(expected["candidates"]), "all candidates")
    initial = waited(peer.initial, 2)
    check(len(initial) == 1 and initial[0].pose.pose.position.x == at.x, "the initial pose is said once")
    tf = waited(peer.tf, 2)[0].transforms[0]
    check((tf.header.frame_id, tf.child_frame_id) == ("map", "odom"), "the transform is that of map and odom")
    c, s = math.cos(math.radians(yaw(tf.transform.rotation))), math.sin(math.radians(yaw(tf.transform.rotation)))
    there = (tf.transform.translation.x + c * 1 - s * 2, tf.transform.translation.y + s * 1 + c * 2)
    check(math.dist(there, (at.x, at.y)) < 0.3, "with which odometry is where the track believes it")
    status = waited(peer.diagnostics, 2)[0].status[0]
    check(status.level == 0 and "sample" in status.message, f"diagnosis: {status.message}")


def refuses(peer, frames):
    """Bad frames are said, and the node goes on."""
    peer.send([b"no image", b"nothing"], Time(2000, 0))
    status = [status for message in waited(peer.diagnostics, 5) for status in message.status]
    check(any(s.level == 2 and "cam0" in s.message for s in status), f"a damaged frame is said: {status[-1].message}")
    peer.images[0].write(CompressedImage(Header(Time(-5, 0), ""), "png", frames[0]))
    peer.send(frames, Time(2001, 0))
    check(waited(peer.pose, 5), "and the next pair is answered")


def says_other_types(compass, common, peer):
    """A topic of another type gives no frames: what is waited for is said, and nothing hangs."""
    writer = peer.writer("/front", CompressedImage)
    node = subprocess.Popen(
        [compass, "node", *common, "--name", "other", "--cam0-topic", "/front", "--cam1-topic="], stderr=subprocess.PIPE, text=True
    )
    time.sleep(7)
    node.send_signal(signal.SIGTERM)
    said = node.communicate(timeout=5)[1]
    check("no frames on /front (sensor_msgs/msg/Image): " in said, f"it says what it waits for: {said!r}")
    del writer


# x, y in metres and heading in degrees, in the sample building.
PLACES = [(4.1, 17.8, 288), (13.4, 3.7, 74), (25.5, 15.2, 200), (20.2, 11.7, 5), (6, 4, 120), (28, 4, 330)]


def upside_down(heading):
    """The quaternion of a camera that hangs upside down and looks level."""
    half = math.radians(heading) / 2
    c, s = math.cos(half), math.sin(half)
    # Turned about the vertical after x lies right, y up and z ahead: the rotation by 120 degrees about (1, 1, 1).
    x, y, z, w = 0.5, 0.5, 0.5, 0.5
    return (c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z)


def replays(compass, common, peer, folder, scratch):
    """A recording through the node gives the poses of `evaluate`."""
    poses, data, out = (os.path.join(scratch, name) for name in ("poses.txt", "data", "out"))
    with open(poses, "w") as file:
        for number, (x, y, heading) in enumerate(PLACES):
            print(3000 + number, x, y, 1.6, *upside_down(heading), file=file)
    plan = os.path.join(folder, "..", "sample-building.png")
    run = lambda *line: subprocess.run([compass, *line], capture_output=True, check=True)
    run("simulate", plan, "--poses", poses, "--out", data)
    truth = os.path.join(data, "groundtruth.txt")
    run("evaluate", *common, "--dataset", data, "--groundtruth", truth, "--out", out)
    with open(os.path.join(out, "frames.jsonl")) as lines:
        records = {record["timestamp_ns"]: record for record in map(json.loads, lines) if "timestamp_ns" in record}
    check(len(records) == len(PLACES), f"evaluate answers {len(records)} frames")
    for stamp, record in sorted(records.items()):
        frames = [open(os.path.join(data, f"cam{n}", "data", f"{stamp}.jpg"), "rb").read() for n in range(2)]
        waited(peer.candidates, 0.1)
        peer.send(frames, Time(stamp // 10**9, stamp % 10**9))
        heard = waited(peer.candidates, 5)
        check(heard, f"the pair of {stamp // 10**9} s is answered")
        found = [(pose.position.x, pose.position.y) for pose in heard[-1].poses]
        wanted = [(pose["x"] / 2**32, pose["y"] / 2**32) for pose in record["single"]]
        check(found == wanted, f"with all {len(wanted)} poses of evaluate, to the bit")


def soak(peer, node, frames, seconds, rate):
    """Frames at a rate: the memory stays, none is lost but those that are overtaken."""
    times, sent, stamps = [], 0, {}
    waited(peer.pose, 0.5)
    start = time.monotonic()
    before = None
    while time.monotonic() - start < seconds:
        due = start + sent / rate
        while time.monotonic() < due:
            for pose in peer.pose.take(N=64):
                if hasattr(pose, "header") and pose.header.stamp.sec in stamps:
                    times.append(time.monotonic() - stamps.pop(pose.header.stamp.sec))
            time.sleep(0.001)
        stamp = 10_000 + sent
        peer.send(frames, Time(stamp, 0))
        stamps[stamp] = time.monotonic()
        sent += 1
        # The caches of DDS fill first, in half a minute.
        if before is None and time.monotonic() - start > seconds / 2:
            before = memory_kib(node)
    after = memory_kib(node)
    times.sort()
    print(f"soak    {sent} pairs at {rate} Hz, {len(times)} answered; memory {before} to {after} KiB")
    print(f"        from sending to the pose: median {1e3 * times[len(times) // 2]:.1f} ms, p99 {1e3 * times[int(len(times) * 0.99)]:.1f} ms")
    check(after < 1.1 * before + 4096, "the memory is flat")
    check(len(times) > 0.5 * sent, "at least half of the pairs are answered")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("compass")
    parser.add_argument("folder")
    parser.add_argument("--soak", type=float, default=0)
    parser.add_argument("--rate", type=float, default=5)
    told = parser.parse_args()
    files = {name: os.path.join(told.folder, name) for name in ("sample.site", "calibration.yaml", "cam0.png", "cam1.png")}
    common = ["--map", files["sample.site"], "--calib", files["calibration.yaml"], "--mount", "inverted"]
    images = ["--cam0", files["cam0.png"], "--cam1", files["cam1.png"]]
    ran = subprocess.run([told.compass, "localize", *common, *images, "--json", "-"], capture_output=True, check=True)
    expected = json.loads(ran.stdout)
    # The JSON rounds to a micrometre; the bits do not.
    x, y = (int(word, 16) / 2**32 for word in expected["bits"].split()[:2])
    expected["x"], expected["y"] = x, y
    frames = [open(files[name], "rb").read() for name in ("cam0.png", "cam1.png")]
    node = subprocess.Popen(
        [told.compass, "node", *common, "--initialpose", "--ros-args", "-p", "odom_topic:=/odom", "-r", "/unused:=/x"]
    )
    try:
        peer = Peer()
        answers(peer, expected, frames)
        refuses(peer, frames)
        says_other_types(told.compass, common, peer)
        with tempfile.TemporaryDirectory() as scratch:
            replays(told.compass, common, peer, told.folder, scratch)
        if told.soak:
            soak(peer, node, frames, told.soak, told.rate)
        node.send_signal(signal.SIGINT)
        check(node.wait(5) == 0, "it ends when asked to")
    finally:
        node.kill()


if __name__ == "__main__":
    sys.exit(main())
