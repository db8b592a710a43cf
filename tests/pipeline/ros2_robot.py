"""A robot for scripts/ros2_device.py: ros2_robot.py SCRIPTS TISSUE_HAPTIC MODEL.h5 ROLE. It presses the middle of the
top of a block in the plane, rests, grasps and pulls, lets go, falls silent, and loses tissue-haptic; asserts what wrenches come.
Uses rclpy where this Python has it, else ros2_stand_in.py."""
import math
import os
import signal
import socket
import subprocess
import sys
import time

import tissue

try:
    import rclpy
except ImportError:
    import ros2_stand_in  # noqa: F401
    import rclpy
scripts, program, file, role = sys.argv[1:]
sys.path.insert(0, scripts)
import ros2_device  # noqa: E402
from geometry_msgs.msg import PoseStamped, WrenchStamped  # noqa: E402
from rclpy.executors import SingleThreadedExecutor  # noqa: E402
from std_msgs.msg import Bool  # noqa: E402

with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
    free.bind(("127.0.0.1", 0))
    port = free.getsockname()[1]
sys.argv = ["ros2_device.py", "--ros-args", "-p", f"role:={role}", "-p", f"port:={port}", "-p", "force_max:=3.0"]
tissue_haptic = subprocess.Popen([program, file, "--device", "remote", "--port", str(port), "--seconds", "0", "--no-heuristic"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
wrenches, echoes = [], []


class Robot(ros2_device.Node):
    def __init__(self):
        super().__init__("robot")
        self.poses = self.create_publisher(PoseStamped, ros2_device.TOPICS[role][0], 1)
        self.grasps = self.create_publisher(Bool, "grasp", 1)
        self.create_subscription(WrenchStamped, ros2_device.TOPICS[role][1], lambda w: wrenches.append((time.monotonic(), w)), 10)
        if role == "tool":
            self.create_subscription(PoseStamped, "measured_cp", echoes.append, 10)

    def to(self, y_m, seconds):
        """Moves evenly to this height, in so many seconds, at 500 Hz."""
        begin, start_m = time.monotonic(), self.y_m
        while (part := (time.monotonic() - begin) / seconds) < 1:
            self.y_m = start_m + part * (y_m - start_m)
            pose = PoseStamped()
            pose.header.frame_id = "block"
            pose.pose.position.x, pose.pose.position.y = 0.05, self.y_m
            self.poses.publish(pose)
            spin(0.002)
        self.y_m = y_m

    def grasp(self, on):
        message = Bool()
        message.data = on
        self.grasps.publish(message)


def spin(seconds):
    until = time.monotonic() + seconds
    while (left := until - time.monotonic()) > 0:
        executor.spin_once(timeout_sec=left)


def force():
    return wrenches[-1][1].wrench.force


def forces(since):
    return [w.wrench.force for at, w in wrenches if at >= since]


def rests(y_m, holds, what):
    """Stays there until the force is as it should be. A busy machine stalls now and then, and after that the tool has no
    force until it was outside: then it comes again, for a minute in all."""
    until = time.monotonic() + 60
    while time.monotonic() < until:
        for _ in range(20):
            robot.to(y_m, 0.1)
            if wrenches and holds(force()):
                return
        robot.to(0.102, 0.3)
        robot.to(y_m, 0.3)
    raise AssertionError(f"{what}: not {[getattr(force(), axis) for axis in 'xyz'] if wrenches else 'without any wrench'}")


rest, _, why = tissue.Model(file).press([[0.05, 0.1]], [[0, -0.004]])
assert why == [""]
rclpy.init(args=sys.argv)
device, robot, executor = ros2_device.TissueDevice(), Robot(), SingleThreadedExecutor()
for node in (device, robot):
    executor.add_node(node)
try:
    robot.y_m = 0.102
    rests(0.102, lambda f: f.y == 0, "outside")
    robot.to(0.096, 0.5)
    rests(0.096, lambda f: math.isclose(f.y, -rest[0][1], rel_tol=0.02) and abs(f.x) < 0.02 * f.y and f.z == 0, f"the force of an equilibrium, {rest[0]}")
    at_rest = force()
    assert wrenches[-1][1].header.frame_id == "block" and wrenches[-1][1].wrench.torque.y == 0

    def lifts():   # a stall lets go of the tissue: then again
        robot.grasp(False)
        robot.to(0.102, 0.3)
        robot.to(0.096, 0.3)
        robot.grasp(True)
        robot.to(0.096, 0.2)
        robot.to(0.102, 0.5)
        return any(f.y < -0.2 * at_rest.y for f in forces(time.monotonic() - 0.1))
    assert any(lifts() for _ in range(20)), "a grasp does not pull"
    robot.grasp(False)
    rests(0.102, lambda f: f.y == 0, "no force after a release")
    assert device.link.force_max_N == 3.0
    device.link.force_max_N = 0.05
    robot.to(0.096, 0.5)
    rests(0.096, lambda f: math.isclose(math.hypot(f.x, f.y), 0.05), "a force within force_max")
    device.link.force_max_N = 3.0
    rests(0.096, lambda f: f.y > 0.5 * at_rest.y, "a force again")
    spin(0.5)                                        # no pose: the last one is too old
    assert force().y == 0, force()
    robot.to(0.102, 0.3)
    robot.to(0.096, 0.5)
    rests(0.096, lambda f: f.y > 0.5 * at_rest.y, "a force after a silence")
    os.kill(tissue_haptic.pid, signal.SIGKILL)
    tissue_haptic.wait()
    since = time.monotonic()
    spin(0.5)
    assert force().y == 0 and len(forces(since)) < 100, (force(), len(forces(since)))   # one of zero, after those on the way
    if role == "tool":
        assert len(echoes) > 100 and echoes[-1].header.frame_id == "block" and abs(echoes[-1].pose.position.y - 0.096) < 1e-4 and echoes[-1].pose.position.x == 0.05
    count = len(wrenches)
    device.stop()
    spin(0.2)
    assert len(wrenches) == count + 1 and force().y == 0
    assert device.link.refused == 0 and device.link.answers > 1000
finally:
    tissue_haptic.kill()
    device.stop()
    rclpy.shutdown()
print(f"at rest {at_rest.y:.4f} N, sent {device.link.sent}, answers {device.link.answers}, {'stand-in' if 'ros2_stand_in' in sys.modules else 'rclpy'}")
