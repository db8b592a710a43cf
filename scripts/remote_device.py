#!/usr/bin/env python3
"""A haptic device over UDP, for `tissue-haptic MODEL --device remote`: indents the top of the block and prints the
force.

    remote_device.py [port [seconds]]

Datagrams, little-endian, 48 bytes (TSP2: 72 bytes):
    out  "TSP1", uint32 sequence, float64 time_s, float64 position_m[3], float64 grasp (1: the tool grasps)
         or "TSP2", the same, float64 measured_N[3] of a force sensor in the tool (tissue-haptic --learn)
    in   "TSF1", uint32 sequence of the position used, float64 age_s, float64 force_N[3], float64 tick
time_s is this program's monotonic clock at the measurement of the position, not a count of positions. Positions that
are too old by it are not used, and a constant time_s gets no force at all.
Forces are accepted from the connected socket only and limited to 3.3 N. A force is valid until the next one, for at
most 7.5 ms. After that a device with motors must set its force to zero.
"""
import math
import socket
import struct
import sys
import time

FORCE_MAX_N = 3.3   # of a Touch, as tissue-haptic --force-max
HELD_S = 0.0075     # three quarters of the time for which tissue-haptic holds a force
NONE = (0.0, 0.0, 0.0)


def force_of(datagram, sequence):
    """The force of a datagram [N], at most FORCE_MAX_N. None if it does not answer a position up to `sequence`."""
    if len(datagram) != 48:
        return None
    magic, used, age_s, fx, fy, fz, tick = struct.unpack("<4sId3dd", datagram)
    length = math.hypot(fx, fy, fz)
    if magic != b"TSF1" or not 0 < used <= sequence or not math.isfinite(length):
        return None
    share = min(1.0, FORCE_MAX_N / length) if length > 0 else 1.0
    return fx * share, fy * share, fz * share


def arguments():
    try:
        port = int(sys.argv[1]) if len(sys.argv) > 1 else 47474
        seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 5.0
        if len(sys.argv) > 3 or not (0 < port < 65536 and seconds >= 0):
            raise ValueError
        return port, seconds
    except ValueError:
        print(__doc__.strip(), file=sys.stdout if sys.argv[1] in ("-h", "--help") else sys.stderr)
        sys.exit(0 if sys.argv[1] in ("-h", "--help") else 2)


port, seconds = arguments()
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.connect(("127.0.0.1", port))   # rejects forces of any other program
link.setblocking(False)
start, force, came = time.monotonic(), NONE, 0.0
sequence = answers = refused = 0
largest = 0.0
while (now := time.monotonic() - start) < seconds:
    sequence += 1
    y = 0.1 + 0.005 * math.cos(math.pi * now)          # in and out of the middle of the top, 2 s a cycle
    try:
        link.send(struct.pack("<4sId3dd", b"TSP1", sequence, now, 0.05, y, 0.0, 0.0))
    except (BlockingIOError, ConnectionRefusedError):  # no program listens yet, or another client is connected
        pass
    # Reads all waiting datagrams (the system bounds their number), so that the newest force counts also after a pause.
    for _ in range(512):
        try:
            newest = force_of(link.recv(49), sequence)
        except BlockingIOError:
            break
        except ConnectionRefusedError:
            continue
        if newest is None:
            refused += 1
            continue
        answers, force, came = answers + 1, newest, now
        largest = max(largest, math.hypot(*force))
    if now - came > HELD_S:
        force = NONE
    if sequence % 500 == 0:
        print(f"{now:6.2f} s  y {1e3 * y:7.2f} mm  force {1e3 * force[0]:8.4f} {1e3 * force[1]:8.4f} mN")
    time.sleep(max(0.0, start + sequence * 1e-3 - time.monotonic()))
print(f"largest force {largest:.4f} N, at the end {math.hypot(*force):.4f} N, refused {refused}")
print(f"sent {sequence}, answers {answers}")
sys.exit(0 if answers > 0 else 1)
