#!/usr/bin/env python3
"""A haptic device over UDP, for `tissue-haptic MODEL --device remote`: presses the top of the block and prints force.

    remote_device.py [port [seconds]]

Datagrams, little-endian, 48 bytes each way:
    out  "TSP1", uint32 sequence, float64 time_s, float64 position_m[3], float64 reserved
         or "TSP2", the same, float64 measured_N[3] of a force sensor in the tool (tissue-haptic --learn)
    in   "TSF1", uint32 sequence of the position used, float64 age_s, float64 force_N[3], float64 tick
A force counts until the next, and for 7.5 ms at most: then whoever has motors lets go.
"""
import math
import socket
import struct
import sys
import time

try:
    port = int(sys.argv[1]) if len(sys.argv) > 1 else 47474
    seconds = float(sys.argv[2]) if len(sys.argv) > 2 else 5.0
    if len(sys.argv) > 3 or not (0 < port < 65536 and seconds >= 0):
        raise ValueError
except ValueError:
    print(__doc__.strip(), file=sys.stdout if sys.argv[1] in ("-h", "--help") else sys.stderr)
    sys.exit(0 if sys.argv[1] in ("-h", "--help") else 2)
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.setblocking(False)
none = (0.0, 0.0, 0.0)
start, answers, force, came = time.monotonic(), 0, none, 0.0
sequence = 0
while (now := time.monotonic() - start) < seconds:
    sequence += 1
    y = 0.1 + 0.005 * math.cos(math.pi * now)          # in and out of the middle of the top, 2 s a cycle
    link.sendto(struct.pack("<4sId3dd", b"TSP1", sequence, now, 0.05, y, 0.0, 0.0), ("127.0.0.1", port))
    try:
        while True:
            magic, used, age_s, fx, fy, fz, tick = struct.unpack("<4sId3dd", link.recv(64))
            answers, force, came = answers + 1, (fx, fy, fz), now
    except (BlockingIOError, ConnectionRefusedError):
        pass
    if now - came > 0.0075:
        force = none
    if sequence % 500 == 0:
        print(f"{now:6.2f} s  y {1e3 * y:7.2f} mm  force {1e3 * force[0]:8.4f} {1e3 * force[1]:8.4f} mN")
    time.sleep(max(0.0, start + sequence * 1e-3 - time.monotonic()))
print(f"sent {sequence}, answers {answers}")
sys.exit(0 if answers > 0 else 1)
