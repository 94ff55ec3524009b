# SPDX-License-Identifier: Apache-2.0
"""Intel RealSense, by pyrealsense2: depth, and colour brought onto its pixels.
touchable play --camera "pipe:python3 realsense.py [WIDTH HEIGHT FPS]" """
import sys
import pyrealsense2 as rs
from framesets import send

width, height, rate = map(int, sys.argv[1:4] or (640, 480, 30))
config = rs.config()
config.enable_stream(rs.stream.depth, width, height, rs.format.z16, rate)
config.enable_stream(rs.stream.color, width, height, rs.format.rgb8, rate)
camera = rs.pipeline()
profile = camera.start(config)
unit = profile.get_device().first_depth_sensor().get_depth_scale()
lens = profile.get_stream(rs.stream.depth).as_video_stream_profile().get_intrinsics()
onto_depth = rs.align(rs.stream.depth)
try:
    while True:
        both = onto_depth.process(camera.wait_for_frames())
        depth, colour = both.get_depth_frame(), both.get_color_frame()
        if depth and colour:
            send(depth.get_data(), lens.width, lens.height, unit, lens.fx, lens.fy, lens.ppx, lens.ppy,
                 int(depth.get_timestamp() * 1e6), depth.get_frame_number(),
                 colour.get_data(), colour.get_width(), colour.get_height())
finally:
    camera.stop()
