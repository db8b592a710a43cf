#!/usr/bin/env python3
"""A node of ROS 2 between a robot's topics and `tissue-haptic MODEL --device remote`: poses in, wrenches out.

    ros2_device.py [--ros-args -p role:=hand -p port:=47474 -p force_max:=3.3 -r __ns:=/MTML -r servo_cf:=body/servo_cf]

Names and messages are CRTK's (Collaborative Robotics Toolkit), relative to the node's namespace:
    role hand: a person holds a robot that shows the tissue's force
        in   measured_cp   geometry_msgs/PoseStamped     position of the robot [m]; the orientation is not used
        out  servo_cf      geometry_msgs/WrenchStamped   force on the hand [N], in the axes of the pose; no torque
    role tool: a controller moves a tool in the tissue, which is a robot with a force sensor
        in   servo_cp      geometry_msgs/PoseStamped     where the tool is to be [m]; it is there at once
        out  measured_cp   geometry_msgs/PoseStamped     where it is: the same
        out  measured_cf   geometry_msgs/WrenchStamped   force of the tissue on the tool [N]
    both: in   grasp       std_msgs/Bool                 while true the tool grasps (tissue-haptic --help, grasp-max)
header.frame_id of what goes out is that of the last pose. tissue-haptic's --axes, --offset, --rotation and --scale lead
from that frame to the tissue.

Each pose is sent once, as measured when it arrives here: a constant delay of the transport is not visible, so poses
should come at 1 kHz from this machine, and at 20 Hz at least (option stale). A wrench is published for each force that
comes, up to 1000 a second, within force_max [N]; one of zero where none has come for 7.5 ms, and when the node ends. A
wrench is valid for 7.5 ms: a robot with motors must release it by itself after that, as where this node is killed.
For role tool give tissue-haptic and this node a high force-max, else the tool stays behind where the force would be
larger. One node is one tool; the second tool has its own port (--second-port) and its own node in another namespace.

Needs rclpy, geometry_msgs and std_msgs of a ROS 2 that is set up in this shell.
"""
import math
import select
import signal
import sys
import threading
import time

try:
    import rclpy
    from geometry_msgs.msg import PoseStamped, WrenchStamped
    from rclpy.exceptions import InvalidParameterTypeException
    from rclpy.executors import SingleThreadedExecutor
    from rclpy.node import Node
    from rclpy.qos import qos_profile_sensor_data
    from rclpy.signals import SignalHandlerOptions
    from std_msgs.msg import Bool
except ImportError as missing:
    rclpy, Node, why = None, object, str(missing).split("\n")[0]

from remote_device import FORCE_MAX_N, HELD_S, NONE, Link

TOPICS = {"hand": ("measured_cp", "servo_cf"), "tool": ("servo_cp", "measured_cf")}   # role: pose in, wrench out


class Refused(Exception):
    """A parameter with a wrong value, in one line."""


class TissueDevice(Node):
    """The node. Parameters role, port and force_max: see the file's head. Throws Refused."""

    def __init__(self):
        super().__init__("tissue_device")
        role = self.declare_parameter("role", "hand").value
        port = self.declare_parameter("port", 47474).value
        force_max_N = self.declare_parameter("force_max", FORCE_MAX_N).value
        if role not in TOPICS:
            raise Refused(f"parameter role must be hand or tool, not {role!r}")
        if not 0 < port < 65536:
            raise Refused(f"parameter port must be from 1 to 65535, not {port}")
        if not 0 < force_max_N < math.inf:
            raise Refused(f"parameter force_max must be a force above 0 N, not {force_max_N}")
        self.link = Link(port, force_max_N)
        self.frame, self.grasps, self.running = "", False, True
        pose_in, wrench_out = TOPICS[role]
        self.wrenches = self.create_publisher(WrenchStamped, wrench_out, 1)
        self.poses = self.create_publisher(PoseStamped, "measured_cp", 1) if role == "tool" else None
        # those of best effort and reliable publishers match
        self.create_subscription(PoseStamped, pose_in, self.moved, qos_profile_sensor_data)
        self.create_subscription(Bool, "grasp", self.grasp, qos_profile_sensor_data)
        self.receiver = threading.Thread(target=self.receive, name="forces")
        self.receiver.start()
        self.get_logger().info(f"role {role}: {pose_in} in, {wrench_out} out, tissue-haptic on port {port}")

    def moved(self, pose):
        self.frame = pose.header.frame_id
        at = pose.pose.position
        self.link.put(time.monotonic(), (at.x, at.y, at.z), self.grasps)
        if self.poses:
            self.poses.publish(pose)

    def grasp(self, on):
        self.grasps = on.data

    def receive(self):
        """Publishes forces as they come, and none where none has come for HELD_S. Runs in a thread of its own."""
        came_s = None   # when the last force came; None: what was published last is no force
        while self.running:
            select.select([self.link.socket], [], [], HELD_S)
            if (force_N := self.link.take()) is not None:
                came_s = time.monotonic()
                self.publish(force_N)
            elif came_s is not None and time.monotonic() - came_s > HELD_S:
                came_s = None
                self.publish(NONE)

    def publish(self, force_N):
        wrench = WrenchStamped()
        wrench.header.stamp = self.get_clock().now().to_msg()
        wrench.header.frame_id = self.frame
        wrench.wrench.force.x, wrench.wrench.force.y, wrench.wrench.force.z = force_N
        self.wrenches.publish(wrench)

    def stop(self):
        """Ends the thread, and the force."""
        self.running = False
        self.receiver.join()
        self.publish(NONE)


def main():
    if rclpy is None:
        print(f"ros2_device: {why}: set up ROS 2 in this shell (source its setup file), with rclpy, geometry_msgs and std_msgs", file=sys.stderr)
        return 2
    # with ROS 2's own handlers of signals nothing could be published at the end
    rclpy.init(args=sys.argv, signal_handler_options=SignalHandlerOptions.NO)
    ends = threading.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda *_: ends.set())
    node = None
    try:
        node = TissueDevice()
        executor = SingleThreadedExecutor()
        executor.add_node(node)
        while not ends.is_set():
            executor.spin_once(timeout_sec=0.05)
    except (Refused, InvalidParameterTypeException) as e:
        print(f"ros2_device: {e}", file=sys.stderr)
        return 2
    finally:
        if node:
            node.stop()
            node.destroy_node()
        rclpy.shutdown()
    print(f"sent {node.link.sent}, answers {node.link.answers}, refused {node.link.refused}")
    return 0


if __name__ == "__main__":
    if sys.argv[1:2] in (["-h"], ["--help"]):
        print(__doc__.strip())
        sys.exit(0)
    sys.exit(main())
