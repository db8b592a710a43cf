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


def force_of(datagram, sequence, force_max_N=FORCE_MAX_N):
    """The force of a datagram [N], at most force_max_N. None if it does not answer a position up to `sequence`."""
    if len(datagram) != 48:
        return None
    magic, used, age_s, fx, fy, fz, tick = struct.unpack("<4sId3dd", datagram)
    length = math.hypot(fx, fy, fz)
    if magic != b"TSF1" or not 0 < used <= sequence or not math.isfinite(length):
        return None
    share = min(1.0, force_max_N / length) if length > 0 else 1.0
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


class Link:
    """The socket of a device to `tissue-haptic --device remote --port PORT` on this machine."""

    def __init__(self, port, force_max_N=FORCE_MAX_N):
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.connect(("127.0.0.1", port))   # rejects forces of any other program
        self.socket.setblocking(False)
        self.force_max_N = force_max_N
        self.sent = self.answers = self.refused = 0

    def put(self, time_s, position_m, grasp=False):
        """Sends a position (3) [m]; time_s: of a monotonic clock, when it was measured."""
        self.sent += 1
        try:
            self.socket.send(struct.pack("<4sId3dd", b"TSP1", self.sent % 2 ** 32, time_s, *position_m, float(grasp)))
        except (BlockingIOError, ConnectionRefusedError):  # no program listens yet, or another client is connected
            pass

    def take(self):
        """The newest force that has come [N], at most force_max_N; None if none has."""
        force = None
        # Reads all waiting datagrams (the system bounds their number), so that the newest force counts also after a pause.
        for _ in range(512):
            try:
                newest = force_of(self.socket.recv(49), self.sent, self.force_max_N)
            except BlockingIOError:
                break
            except ConnectionRefusedError:
                continue
            if newest is None:
                self.refused += 1
                continue
            self.answers, force = self.answers + 1, newest
        return force


def main():
    port, seconds = arguments()
    link = Link(port)
    start, force, came, largest = time.monotonic(), NONE, 0.0, 0.0
    while (now := time.monotonic() - start) < seconds:
        y = 0.1 + 0.005 * math.cos(math.pi * now)          # in and out of the middle of the top, 2 s a cycle
        link.put(now, (0.05, y, 0.0))
        if (newest := link.take()) is not None:
            force, came = newest, now
            largest = max(largest, math.hypot(*force))
        if now - came > HELD_S:
            force = NONE
        if link.sent % 500 == 0:
            print(f"{now:6.2f} s  y {1e3 * y:7.2f} mm  force {1e3 * force[0]:8.4f} {1e3 * force[1]:8.4f} mN")
        time.sleep(max(0.0, start + link.sent * 1e-3 - time.monotonic()))
    print(f"largest force {largest:.4f} N, at the end {math.hypot(*force):.4f} N, refused {link.refused}")
    print(f"sent {link.sent}, answers {link.answers}")
    return 0 if link.answers > 0 else 1


if __name__ == "__main__":
    sys.exit(main())
