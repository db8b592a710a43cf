"""A program that answers a client of `tissue-haptic --device remote` with good, forged and invalid forces:
forged_forces.py FORCE_N LAG ANSWERS COMMAND...

COMMAND is run with PORT replaced by the port of this program. The first ANSWERS of its positions are answered with a
force of (0, FORCE_N, 0) for the position that was LAG before, if there was one, each before ten datagrams that a client
must refuse, and one from another socket. Prints what COMMAND prints; exits 1 where the positions are not those of
cli/view/PROTOCOL.md, else with COMMAND's exit status."""
import math
import socket
import struct
import subprocess
import sys

force, lag, answers = float(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])
link, forger = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
link.bind(("127.0.0.1", 0))
link.settimeout(0.2)
client = subprocess.Popen([str(link.getsockname()[1]) if word == "PORT" else word for word in sys.argv[4:]])


def datagram(used, y, age_s=0.0, magic=b"TSF1"):
    return struct.pack("<4sId3dd", magic, used % 2**32, age_s, 0, y, 0, 0)


last, last_s, wrong = 0, -1.0, 0
while client.poll() is None:
    try:
        position, where = link.recvfrom(100)
    except (TimeoutError, ConnectionRefusedError):
        continue
    if len(position) != 48:
        sys.exit(f"a position of {len(position)} bytes")
    magic, sequence, time_s, x, y, z, grasp = struct.unpack("<4sId3dd", position)
    wrong += magic != b"TSP1" or sequence <= last or not time_s > last_s or not all(map(math.isfinite, (x, y, z))) or grasp not in (0, 1)
    last, last_s = sequence, time_s
    if sequence > answers:
        continue
    good = datagram(sequence - lag, force)
    bad = (b"", b"x", good[:-1], good + b"x", datagram(sequence, 2.5, magic=b"TSF2"), datagram(sequence, math.nan), datagram(sequence, 2.5, age_s=math.nan),
           datagram(sequence, 2.5, age_s=math.inf), datagram(sequence + 100000, 2.5), datagram(sequence - 5000, 2.5))
    try:
        for one in (good, *bad) if sequence > lag else bad:  # what must be refused comes last, and would be the newest
            link.sendto(one, where)
        forger.sendto(datagram(sequence, 2.5), where)
    except ConnectionRefusedError:  # the client has ended
        pass
if wrong or last < answers:
    sys.exit(f"{wrong} wrong of {last} positions")
sys.exit(client.returncode)
