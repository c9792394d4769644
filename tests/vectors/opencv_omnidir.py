#!/usr/bin/env python3
"""Writes opencv_omnidir.csv: bearings projected by OpenCV's omnidirectional model, for tests/camera.rs.

Usage: python3 opencv_omnidir.py > opencv_omnidir.csv (needs cv2 with its contrib modules, and numpy).

The intrinsics and coefficients are invented. Xi 0 is the pinhole, which OpenCV projects by another function.
"""

import cv2
import numpy as np

LENSES = [
    # fx, fy, cx, cy, xi, k1, k2, p1, p2, largest angle in degrees
    (1035.5, 1032.75, 727.25, 716.5, 1.4, -0.02, 0.003, 0.0004, -0.0007, 110),
    (690.25, 691.0, 423.5, 399.75, 0.85, -0.11, 0.021, -0.002, 0.0015, 100),
    (860.0, 858.5, 960.5, 540.25, 1.0, 0.0, 0.0, 0.0, 0.0, 100),
    (590.0, 592.5, 640.5, 360.25, 0.0, -0.21, 0.03, 0.0006, -0.0011, 45),
]

print(f"# cv2.omnidir.projectPoints and cv2.projectPoints, OpenCV {cv2.__version__}")
print("fx,fy,cx,cy,xi,k1,k2,p1,p2,x,y,z,u,v")
zero = np.zeros(3)
for *lens, largest in LENSES:
    fx, fy, cx, cy, xi, *distortion = lens
    matrix = np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
    distortion = np.array(distortion)
    for degrees in range(0, largest + 1, 5):
        for azimuth in np.radians(np.arange(0, 360, 30) + degrees):
            theta = np.radians(degrees)
            point = np.array([np.sin(theta) * np.cos(azimuth), np.sin(theta) * np.sin(azimuth), np.cos(theta)])
            if xi > 0:
                pixel, _ = cv2.omnidir.projectPoints(point.reshape(1, 1, 3), zero, zero, matrix, xi, distortion)
            else:
                pixel, _ = cv2.projectPoints(point.reshape(1, 1, 3), zero, zero, matrix, distortion)
            u, v = pixel.ravel()
            print(",".join([f"{value:.9g}" for value in (*lens, *point)] + [f"{u:.6f}", f"{v:.6f}"]))
            if degrees == 0:
                break
