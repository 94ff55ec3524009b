# SPDX-License-Identifier: Apache-2.0
"""As far as ros2.py uses it: a node that hears a camera on two topics."""
import time
import scene
from types import SimpleNamespace as Some
from sensor_msgs.msg import CameraInfo, Image

def init():
    pass

class Node:
    def __init__(self):
        self.heard = {}

    def create_subscription(self, kind, topic, take, qos):
        self.heard[kind] = topic, take

def create_node(name):
    return Node()

def spin(node):
    """An image comes before the lens does; rows end with two bytes that belong to none."""
    (info_topic, take_info), (depth_topic, take_depth) = node.heard[CameraInfo], node.heard[Image]
    assert info_topic.endswith("camera_info") and depth_topic != info_topic
    used = 2 * scene.width
    for number in range(10**9):
        scene.wait()
        data = scene.picture(number)
        rows = b"".join(data[y * used:(y + 1) * used] + b"\0\0" for y in range(scene.height))
        now = time.time_ns()
        take_depth(Some(encoding="16UC1", is_bigendian=0, width=scene.width, height=scene.height, step=used + 2,
                        data=rows, header=Some(stamp=Some(sec=now // 10**9, nanosec=now % 10**9))))
        if number == 0:
            take_info(Some(k=[60.0, 0.0, 31.5, 0.0, 60.0, 23.5, 0.0, 0.0, 1.0]))
