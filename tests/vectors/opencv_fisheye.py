#!/usr/bin/env python3
"""Writes opencv_fisheye.csv: bearings projected by OpenCV's fisheye model, for tests/camera.rs.

Usage: python3 opencv_fisheye.py > opencv_fisheye.csv (needs cv2 and numpy).

The intrinsics and coefficients are invented. Angles stay below 80 degrees, where OpenCV, which
divides by z, is accurate.
"""

import cv2
import numpy as np

LENSES = [
    # fx, fy, cx, cy, k1, k2, k3, k4
    (431.5, 430.25, 727.25, 716.5, 0.03, -0.012, -0.001, 0.0001),
    (286.125, 286.75, 423.5, 399.75, -0.004, 0.0375, -0.035, 0.006),
    (590.0, 592.5, 960.5, 540.25, 0.0, 0.0, 0.0, 0.0),
]

print(f"# cv2.fisheye.projectPoints, OpenCV {cv2.__version__}")
print("fx,fy,cx,cy,k1,k2,k3,k4,x,y,z,u,v")
for lens in LENSES:
    fx, fy, cx, cy, *k = lens
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    for degrees in range(0, 80, 4):
        for azimuth in np.radians(np.arange(0, 360, 30) + degrees):
            theta = np.radians(degrees)
            point = np.array([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.cos(theta)])
            zero = np.zeros(3)
            pixel, _ = cv2.fisheye.projectPoints(point.reshape(1, 1, 3), zero, zero, matrix, np.array(k))
            u, v = pixel.ravel()
            numbers = [f"{value:.9g}" for value in (*lens, *point)] + [f"{u:.6f}", f"{v:.6f}"]
            print(",".join(numbers))
            if degrees == 0:
                break
