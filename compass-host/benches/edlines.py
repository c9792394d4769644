#!/usr/bin/env python3
"""Times `compass segments` beside OpenCV's EDLines on the same images, in turns, one thread each.

usage: edlines.py COMPASS IMAGE... [--rounds N]

Needs OpenCV with its contributed modules (pip install opencv-contrib-python-headless). Prints, for each image,
the fastest detection of either and the median over the rounds of their ratio.
"""
import argparse
import json
import statistics
import subprocess
import time

import cv2


def edlines(gray, repeat):
    detector = cv2.ximgproc.createEdgeDrawing()
    times = []
    for _ in range(repeat):
        start = time.perf_counter()
        detector.detectEdges(gray)
        detector.detectLines()
        times.append(1e3 * (time.perf_counter() - start))
    return statistics.median(times)


def ours(compass, image, repeat):
    command = [compass, "segments", image, "--repeat", str(repeat), "--json", "-"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)["milliseconds"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("compass")
    parser.add_argument("images", nargs="+", metavar="image")
    parser.add_argument("--rounds", type=int, default=15)
    options = parser.parse_args()
    cv2.setNumThreads(1)
    for image in options.images:
        gray = cv2.imread(image, cv2.IMREAD_GRAYSCALE)
        pairs = [(ours(options.compass, image, 5), edlines(gray, 3)) for _ in range(options.rounds)]
        ratio = statistics.median(a / b for a, b in pairs)
        a, b = (min(times) for times in zip(*pairs))
        print(f"{image}: {gray.shape[1]} x {gray.shape[0]}, compass {a:.2f} ms, EDLines {b:.2f} ms, ratio {ratio:.3f}")


if __name__ == "__main__":
    main()
