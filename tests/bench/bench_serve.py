#!/usr/bin/env python3
"""Effect of an attack on the tick of `tissuectl serve`: bench_serve.py RESULTS, with the program in TISSUECTL.

One client indents the tissue all the time and reads the tick's median and p99 of every second. Windows of three kinds
alternate: without an attack; another process sends hostile frames and connects and disconnects, as fast as it can; the
same attack on another server, which runs all the time. The last kind gives the effect of a busy machine: caches and
clocks are shared in any case. Prints entries of results/bench.json; the peers are the first and the last kind."""
import json
import multiprocessing
import os
import statistics
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "serve"))
from web_socket import Client, Server, connects, hostile_frames, numbers  # noqa: E402

WINDOWS, WINDOW_S = 4, 5


def attack(port, until, sent):
    seed = 0
    while time.monotonic() < until:
        seed += 1
        frames = hostile_frames(port, 100, seed)
        connects(port, 10, seed)
        with sent.get_lock():
            sent[0] += frames
            sent[1] += 10


def window(client, seconds):
    """(p50, p99) of each whole second in it [us]."""
    begin, spoke, seen = time.monotonic(), 0, []
    while (now := time.monotonic()) - begin < seconds:
        if now - spoke > 0.05:
            client.say(type="pointer", x=0.05, y=0.092, down=True)
            spoke = now
        state = numbers(client.until(lambda kind, _: kind == 2)[1])
        # the first figures belong to the previous window
        if now - begin > 1.1 and (not seen or seen[-1] != state[7:9]):
            seen.append(state[7:9])
    return seen


def entry(name, ours, peer, theirs):
    def p95(samples):
        return sorted(samples)[int(0.95 * (len(samples) - 1))]
    ours_median, their_median = statistics.median(ours), statistics.median(theirs)
    return {"name": name, "unit": "us", "median": ours_median, "p95": p95(ours), "n": len(ours), "peer": peer,
            "peer_version": "same run", "peer_median": their_median, "ratio": ours_median / their_median}


def main():
    program = os.environ.get("TISSUECTL", str(ROOT / "build" / "release" / "tissuectl"))
    server, other = (Server(program, f"{sys.argv[1]}/model.h5", "--port", "0") for _ in range(2))
    sent = multiprocessing.Array("l", 2)
    client = Client(server.port)
    window(client, 2)
    quiet, attacked, elsewhere = [], [], []
    unseen = multiprocessing.Array("l", 2)
    for _ in range(WINDOWS):
        quiet += window(client, WINDOW_S)
        for port, count, seen in ((server.port, sent, attacked), (other.port, unseen, elsewhere)):
            attacker = multiprocessing.Process(target=attack, args=(port, time.monotonic() + WINDOW_S, count))
            attacker.start()
            seen += window(client, WINDOW_S)
            attacker.join()
            time.sleep(0.2)
            window(client, 0.5)
    client.close()
    status = max(server.end()[0], other.end()[0])
    if status != 0 or sent[0] < 1000 or sent[1] < 100:
        print(f"bench_serve: exit status {status}, {sent[0]} frames and {sent[1]} connects", file=sys.stderr)
        return 1
    what = f"under {sent[0]} hostile frames and {sent[1]} connects"
    print(f"bench_serve: {what}", file=sys.stderr)
    print(json.dumps([entry(f"serve: tick under attack, {share} of a second, beside {peer}", [s[k] for s in attacked], peer, [s[k] for s in theirs])
                      for k, share in ((0, "median"), (1, "p99"))
                      for peer, theirs in (("another server attacked", elsewhere), ("left alone", quiet))], indent=1))
    return 0


if __name__ == "__main__":
    sys.exit(main())
