#!/bin/sh
# Alone: it plays a tissue in real time
# scripts/ros2_device.py between a robot's topics and tissue-haptic over UDP. TISSUE_ROS2 names a Python with rclpy;
# without it the topics are those of a stand-in in one process (ros2_stand_in.py), which shows nothing about ROS 2
# itself.
. "$(dirname "$0")/common"
TISSUE_HAPTIC=$(realpath "${TISSUE_HAPTIC:-$root/build/release/tissue-haptic}")
robot=${TISSUE_ROS2:-$PYTHON}
PYTHONPATH=$(dirname "$TISSUECTL")/python
export PYTHONPATH PYTHONDONTWRITEBYTECODE=1 ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST ROS_LOG_DIR="$scratch"
make_copy
poked_tissue
node=$root/scripts/ros2_device.py
check "this Python has rclpy, or none is named" sh -c '[ -z "$1" ] || "$1" -c "import rclpy"' - "${TISSUE_ROS2-}"
for role in hand tool; do
    check "role $role: the wrench is that of an equilibrium, a grasp pulls, and there is none without poses or without tissue-haptic" \
        timeout 400 "$robot" "$root/tests/pipeline/ros2_robot.py" "$root/scripts" "$TISSUE_HAPTIC" "$model" $role
done

# ---- the program
if "$PYTHON" -c 'import rclpy' 2>/dev/null; then
    skip "ros2_device without ROS 2: one line" "this Python has rclpy"
else
    run "$PYTHON" "$node"
    check "without ROS 2: one line names what is missing" one_line "^ros2_device: No module named 'rclpy': set up ROS 2 in this shell"
    check "without ROS 2: exit 2" exited 2
fi
run "$PYTHON" "$node" --help
check "--help without ROS 2 prints the topics" says 'out  servo_cf      geometry_msgs/WrenchStamped'
as_node() { # PARAMETER...: becomes the program, on rclpy or on the stand-in
    [ -n "${TISSUE_ROS2-}" ] || exec "$robot" "$root/tests/pipeline/ros2_stand_in.py" "$node" --ros-args "$@"
    exec "$robot" "$node" --ros-args "$@"
}
for wrong in 'role:=foot:must be hand or tool' 'port:=0:must be from 1 to 65535' 'port:=x:port' 'force_max:=-1.0:must be a force above 0 N' 'force_max:=.inf:must be a force above 0 N'; do
    (as_node -p "${wrong%:*}") >"$said" 2>&1
    status=$?
    check "parameter ${wrong%:*} is refused in one line" one_line "^ros2_device: .*${wrong##*:}"
    check "parameter ${wrong%:*}: exit 2" exited 2
done
as_node -p port:=9 >"$said" 2>&1 &
child=$!
wait_for grep -q 'tissue-haptic on port 9' "$said"
kill -TERM $child
wait $child
status=$?
check "SIGTERM ends the node" exited 0
check "at its end the node prints its counts" says '^sent 0, answers 0, refused 0$'
finish
