#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""A ROS 2 node that filters depth: 16UC1 (millimetres) or 32FC1 (metres) in, 32FC1 out, NaN where there is no surface.

    ros2_filter.py --ros-args -r depth/image:=/camera/depth/image_rect_raw -r depth/camera_info:=/camera/depth/camera_info

It publishes depth/filtered, with the headers that came. Tried with a stand-in for rclpy only: Debian has no ROS 2.
"""
import array
import sys

import numpy
import rclpy
import touchable
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from sensor_msgs.msg import CameraInfo, Image

kinds, gap_s, first_pictures = {"16UC1": "u2", "mono16": "u2", "32FC1": "f4"}, 0.5, 16


class DepthFilter(Node):
    def __init__(self):
        super().__init__("touchable_filter")
        self.camera, self.filter, self.first, self.last_s = None, None, [], 0.0
        self.publisher = self.create_publisher(Image, "depth/filtered", qos_profile_sensor_data)
        self.create_subscription(CameraInfo, "depth/camera_info", self.take_camera, qos_profile_sensor_data)
        self.create_subscription(Image, "depth/image", self.take_depth, qos_profile_sensor_data)

    def take_camera(self, info):
        self.camera = self.camera or touchable.Camera(info.width, info.height, info.k[0], info.k[4], info.k[2], info.k[5])

    def take_depth(self, image):
        if self.camera is None or image.encoding not in kinds:
            return self.get_logger().warning(f"no camera_info yet, or {image.encoding} is none of {', '.join(kinds)}")
        kind = numpy.dtype(kinds[image.encoding]).newbyteorder(">" if image.is_bigendian else "<")
        rows = numpy.frombuffer(image.data, numpy.uint8).reshape(image.height, image.step)
        depth = numpy.ascontiguousarray(rows[:, : image.width * kind.itemsize]).view(kind).astype(kind.newbyteorder("="))
        if self.filter is None:  # the first pictures tell which filters this camera needs
            self.first.append(depth)
            if len(self.first) < first_pictures:
                return
            self.filter = touchable.Filter(self.camera, self.first)
        now_s = image.header.stamp.sec + image.header.stamp.nanosec * 1e-9
        if not 0 < now_s - self.last_s < gap_s:
            self.filter.restart()
        self.last_s = now_s
        metres = self.filter(depth)
        self.publisher.publish(Image(header=image.header, height=image.height, width=image.width, encoding="32FC1", step=4 * image.width,
                                     is_bigendian=sys.byteorder == "big", data=array.array("B", metres.tobytes())))


if __name__ == "__main__":
    rclpy.init()
    try:
        rclpy.spin(DepthFilter())
    except KeyboardInterrupt:
        pass
