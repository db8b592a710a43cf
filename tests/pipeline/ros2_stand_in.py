"""A stand-in for what scripts/ros2_device.py uses of ROS 2 (rclpy, geometry_msgs, std_msgs): messages with the fields
of theirs, and topics within one process, delivered at once. It shows nothing about ROS 2 itself: transport, quality of
service, discovery, real message types. test_ros2.sh uses it where TISSUE_ROS2 names no Python with rclpy.

ros2_stand_in.py FILE ARGUMENT...: runs FILE as a program on it."""
import runpy
import sys
import time
import types

topics = {}   # name -> callbacks


def record(**fields):
    """A class of messages; a field is a value or a class."""
    def __init__(self):
        for name, value in fields.items():
            setattr(self, name, value() if isinstance(value, type) else value)
    return type("Message", (), {"__init__": __init__})


Header = record(stamp=0.0, frame_id="")
Vector3 = record(x=0.0, y=0.0, z=0.0)
PoseStamped = record(header=Header, pose=record(position=Vector3, orientation=record(x=0.0, y=0.0, z=0.0, w=1.0)))
WrenchStamped = record(header=Header, wrench=record(force=Vector3, torque=Vector3))
Bool = record(data=False)


class InvalidParameterTypeException(Exception):
    pass


class Publisher:
    def __init__(self, kind, topic):
        self.kind, self.topic = kind, topic

    def publish(self, message):
        assert isinstance(message, self.kind)
        for callback in list(topics.get(self.topic, [])):
            callback(message)


class Node:
    def __init__(self, name):
        self.name = name

    def create_publisher(self, kind, topic, qos):
        return Publisher(kind, topic)

    def create_subscription(self, kind, topic, callback, qos):
        topics.setdefault(topic, []).append(callback)

    def declare_parameter(self, name, value):
        for word in sys.argv:
            if word.startswith(f"{name}:="):
                text = word.split(":=")[1].replace(".inf", "inf")   # as YAML has it
                try:
                    value = type(value)(text)
                except ValueError:
                    raise InvalidParameterTypeException(f"parameter '{name}' has another type") from None
        return types.SimpleNamespace(value=value)

    def get_clock(self):
        return types.SimpleNamespace(now=lambda: types.SimpleNamespace(to_msg=time.time))

    def get_logger(self):
        return types.SimpleNamespace(info=lambda text: print(text, file=sys.stderr))

    def destroy_node(self):
        pass


class SingleThreadedExecutor:
    def add_node(self, node):
        pass

    def spin_once(self, timeout_sec):
        time.sleep(min(timeout_sec, 0.001))


def module(name, **content):
    sys.modules[name] = types.ModuleType(name)
    vars(sys.modules[name]).update(content)


module("rclpy", init=lambda args=None, **_: None, shutdown=lambda: None)
module("rclpy.exceptions", InvalidParameterTypeException=InvalidParameterTypeException)
module("rclpy.executors", SingleThreadedExecutor=SingleThreadedExecutor)
module("rclpy.node", Node=Node)
module("rclpy.qos", qos_profile_sensor_data=None)
module("rclpy.signals", SignalHandlerOptions=types.SimpleNamespace(NO=0))
module("geometry_msgs")
module("geometry_msgs.msg", PoseStamped=PoseStamped, WrenchStamped=WrenchStamped)
module("std_msgs")
module("std_msgs.msg", Bool=Bool)
if __name__ == "__main__":
    sys.argv = sys.argv[1:]
    sys.path.insert(0, sys.argv[0].rpartition("/")[0])
    runpy.run_path(sys.argv[0], run_name="__main__")
