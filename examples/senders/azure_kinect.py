# SPDX-License-Identifier: Apache-2.0
"""Azure Kinect (and Orbbec's Femto with Microsoft's interface), by pyk4a: depth, and colour brought onto its
pixels. What its depth lens bends is not straightened.
touchable play --camera "pipe:python3 azure_kinect.py" """
from pyk4a import CalibrationType, ColorResolution, Config, DepthMode, FPS, ImageFormat, PyK4A
from framesets import send

camera = PyK4A(Config(color_resolution=ColorResolution.RES_720P, color_format=ImageFormat.COLOR_BGRA32,
                      depth_mode=DepthMode.NFOV_UNBINNED, camera_fps=FPS.FPS_30,
                      synchronized_images_only=True))
camera.start()
lens = camera.calibration.get_camera_matrix(CalibrationType.DEPTH)
number = 0
try:
    while True:
        taken = camera.get_capture()
        depth, colour = taken.depth, taken.transformed_color
        if depth is None or colour is None:
            continue
        height, width = depth.shape
        send(depth.tobytes(), width, height, 0.001, lens[0][0], lens[1][1], lens[0][2], lens[1][2],
             taken.depth_timestamp_usec * 1000, number, colour[:, :, 2::-1].tobytes(), width, height)
        number += 1
finally:
    camera.stop()
