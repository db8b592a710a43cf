"""What `tissuectl serve` lets in and what not, over sockets: check_server.py PROGRAM MODEL SCRATCH
Prints "ok - sentence", or "not ok - sentence" and what was seen; exits 1 if any failed."""
import json
import os
import re
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

import h5py
from web_socket import (CLOSE, PATIENCE_S, PING, TEXT, Client, Refused, Server, connects, get, hostile_frames, numbers, request,
                        wait_for)

program, model, scratch = sys.argv[1], sys.argv[2], Path(sys.argv[3])
failed = 0


def check(sentence, right, *seen):
    global failed
    failed += not right
    print(f"ok - {sentence}" if right else f"not ok - {sentence}\n#   {seen}", flush=True)


def metrics(port):
    """name{labels} -> number."""
    body = get(port, "/metrics")[2].decode()
    return {m[1]: float(m[2]) for m in re.finditer(r"^(tissue_\S+) (\S+)$", body, re.M)}


def refused(port, reason):
    return metrics(port).get(f'tissue_refused_total{{reason="{reason}"}}', 0)


def refusal(port, **how):
    try:
        Client(port, **how).close()
    except Refused as error:
        return error.status
    return 101


def ends(port, act):
    """How a connection ends on which `act` was done."""
    client = Client(port)
    try:
        act(client)
    except OSError:
        pass
    end = client.ended()
    client.close()
    return end


def http(port):
    status, head, body = get(port, "/healthz")
    check("healthz answers ok", (status, body) == (200, b"ok"), status, body)
    took, pages = [], {}

    def fetched():
        began = time.monotonic()
        pages.update((path, get(port, path)) for path in ("/", "/page.css", "/page.js", "/three.module.js"))
        took.append(time.monotonic() - began)
        return took[-1] < 1

    # some 0.01 s; the best of many, since the machine may be busy
    check("the page and its parts come in under a second", wait_for(fetched) and all(p[0] == 200 for p in pages.values()), took)
    policy = re.search(r"Content-Security-Policy: (.*)\r", pages["/"][1])
    check("the page has a strict policy: nothing but its own", policy and "default-src 'none'" in policy[1]
          and "unsafe" not in policy[1] and "script-src 'self'" in policy[1] and "*" not in policy[1], policy)
    check("types are said and not guessed", "text/html" in pages["/"][1] and "text/css" in pages["/page.css"][1]
          and "text/javascript" in pages["/page.js"][1] and all("nosniff" in p[1] for p in pages.values())
          and "text/javascript" in pages["/three.module.js"][1])
    status, head, body = get(port, "/page.js", "HEAD")
    check("HEAD is GET without the body", status == 200 and body == b"" and f"Content-Length: {len(pages['/page.js'][2])}" in head, head)
    answers = [get(port, "/", method) for method in ("POST", "PUT", "DELETE", "OPTIONS", "BREW")]
    check("other methods: 405, with those allowed", all(a[0] == 405 and "Allow: GET, HEAD" in a[1] for a in answers[:4])
          and answers[4][0] in (400, 405), [a[0] for a in answers])
    check("other paths: 404", [get(port, p)[0] for p in ("/index.html", "/../Makefile", "/%2e%2e/etc/passwd", "//", "/surface")] == [404] * 5)
    check("a Host that is a name: 403", [get(port, "/", host=h)[0] for h in ("evil.example", f"evil.example:{port}", "")] == [403] * 3)
    check("a Host in digits or localhost is served", [get(port, "/healthz", host=h)[0] for h in (f"localhost:{port}", "[::1]:1", "10.0.0.1")] == [200] * 3)
    check("a request of another Origin: 403", get(port, "/", headers="Origin: http://evil.example\r\n")[0] == 403)
    check("no Host, or no HTTP: 4xx, or nothing", all(request(port, t)[9:10] in (b"4", b"") for t in
          ("GET / HTTP/1.1\r\nConnection: close\r\n\r\n", "hello\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\xfc" + bytes(100),
           "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + "y" * 20000 + "\r\n\r\n")))
    check("a body: refused", get(port, "/", headers="Content-Length: 5\r\n")[0] in (400, 413))
    check("/ws without an upgrade: 426", get(port, "/ws")[0] == 426)
    wait_for(lambda: metrics(port)["tissue_ticks_total"] > 0)   # the first state comes with the 17th tick
    m = metrics(port)
    check("metrics: what Prometheus reads, with ticks, times and refusals", m["tissue_ticks_total"] > 0 and m["tissue_misses_total"] >= 0
          and 0 < m['tissue_tick_seconds{quantile="0.5"}'] <= m['tissue_tick_seconds{quantile="0.99"}']
          and m['tissue_refused_total{reason="host"}'] >= 3 and m['tissue_refused_total{reason="method"}'] >= 4, m)
    lines = get(port, "/metrics")[2].decode().splitlines()
    check("metrics: every line is a comment or a name and a number", all(
        re.fullmatch(r"# (HELP|TYPE) tissue_[a-z_]+ .+|tissue_[a-z_0-9]+(\{[a-z_]+=\"[^\"]*\"\})? [-+0-9.e]+", l) for l in lines))


def conversation(port):
    client = Client(port)
    first = json.loads(client.receive()[1])
    check("the first message is the model, with FE's curves", first["type"] == "model" and all(len(p["curve"]) == 3 for p in first["places"]), first["type"])
    check("the demo plays by itself", client.hear("control", holder="demo") is not None)
    state = client.state()
    check("a state is as long as it should be and counts ticks", state[1] > 0 and state[26] == 1, state)
    times = [client.state()[0] for _ in range(200)]
    rate = (len(times) - 1) / (times[-1] - times[0])   # a second of the simulation's, however long the machine takes
    check("states come 60 times a second at most", rate <= 62, rate)
    deepest = 0
    for k in range(60):
        client.say(type="pointer", x=0.05, y=0.12 - 0.028 * min(1, k / 30), down=True)
        state = client.state()
        deepest = max(deepest, -state[15])
    check("a pointer that goes down presses the tissue", deepest > 0.004 and state[13] == 0 and state[19] < 0, deepest, state)
    check("it feels the nearest place and FE's force there", state[22] >= 0 and state[23] > 0, state[22:24])
    other = Client(port)
    other.say(type="pointer", x=0, y=0, down=True)
    check("others watch meanwhile", other.hear("control", holder="other") is not None)
    client.say(type="pointer", x=0, y=0, down=False)
    check("letting go takes the hand out of the tissue", client.until(lambda k, p: k == 2 and
          numbers(p)[13] == -1 and numbers(p)[10] > 0.1) is not None)
    client.say(type="pause", on=True)
    check("pause is told to everyone", other.hear("control", paused=True) is not None)
    a, b = client.state(), client.state()
    while a[1] != b[1]:   # states from before the pause are on their way still
        a, b = b, client.state()
    b = [client.state() for _ in range(5)][-1]
    check("paused, no tick passes", a[1] == b[1] and a[0] == b[0], a[1], b[1])
    client.say(type="pause", on=False)
    client.say(type="reset")
    check("and on it goes", client.until(lambda k, p: k == 2 and numbers(p)[1] > b[1]) is not None)
    client.say(type="demo", place=1)
    check("the demo can be asked for by place", client.hear("control", holder="demo", place=1) is not None)
    state = client.state()
    check("no position of the pointer was a fault", state[5] == 0, state[5])
    client.send(b"\x03\xe8", kind=CLOSE)
    check("a close is answered", client.ended() == (1000, ""))
    client.close(), other.close()


def empty_pieces(port):
    """How it ended, and the bytes that were taken, of one message in pieces of nothing."""
    taken = [0]

    def send(client):
        client.send("", final=False)
        client.socket.settimeout(0.5)
        pieces, end = bytes((0, 0x80, 0, 0, 0, 0)) * 10000, time.monotonic() + 3
        while time.monotonic() < end:
            try:
                taken[0] += client.socket.send(pieces[taken[0] % 6:])
            except TimeoutError:
                pass
    return ends(port, send), taken[0]


def misbehaviour(port):
    check("a foreign Origin: 403", refusal(port, headers="Origin: http://evil.example\r\n") == 403)
    check("Origin null: 403", refusal(port, headers="Origin: null\r\n") == 403)
    check("the page's own Origin is let in", refusal(port, headers=f"Origin: http://127.0.0.1:{port}\r\n") == 101)
    check("a Host that is a name: 403", refusal(port, host=f"evil.example:{port}") == 403)
    for sentence, text, reason in (("not JSON", "{", "not JSON"), ("an unknown type", '{"type":"fly"}', "a type that is none of"),
                                   ("an unknown key", '{"type":"reset","x":1}', "a key that"),
                                   ("a number that is none", '{"type":"pointer","x":1e999,"y":0,"down":true}', "not JSON"),
                                   ("a pointer of space in the plane", '{"type":"pointer","x":0,"y":0,"z":0,"down":true}', "'z' is of models in space"),
                                   ("a model that is not there", '{"type":"model","model":7}', "no such model")):
        end = ends(port, lambda c: c.send(text))
        check(f"{sentence}: 1008 and the reason", end and end[0] == 1008 and end[1].startswith(reason), end)
    check("binary: 1008", ends(port, lambda c: c.send(b"12", kind=2))[0] == 1008)
    check("text that is not UTF-8: closed", ends(port, lambda c: c.send(b"\xff\xfe{}"))[0] in (1007, 1008))
    check("too long: 1009 and the reason", ends(port, lambda c: c.send(" " * 1025)) == (1009, "a message of more than 1024 bytes"))
    check("too long in pieces: 1009", ends(port, lambda c: [c.send(" " * 300, kind=TEXT if k == 0 else 0, final=False) for k in range(5)])[0] == 1009)
    check("a length that is only announced: 1009", ends(port, lambda c: (c.send(b" " * 2000, size=2 ** 62)))[0] == 1009)
    end = ends(port, lambda c: [c.say(type="reset") for _ in range(600)])
    check("too many messages a second: 1008", end in ((1008, "too many messages a second"), (None, "")), end)
    check("pings in a flood: closed", ends(port, lambda c: [c.send(b"", kind=PING) for _ in range(600)]) in ((1008, "too many messages a second"), (None, "")))
    before = refused(port, "rate")
    check("both were counted", before == 2, before)
    end, taken = empty_pieces(port)
    check("a message of empty pieces without end: 1008, and little of it was taken", end in ((1008, "too many messages a second"), (None, "")) and taken < 30e6, end, taken)
    check("it was counted too, and its place is free soon", refused(port, "rate") == 3 and wait_for(lambda: metrics(port)["tissue_clients"] == 0, 15))
    check("a frame without a mask: closed", ends(port, lambda c: c.send("{}", mask=False)) is not None)
    clients = [Client(port) for _ in range(8)]
    check("the ninth page: 503", refusal(port) == 503 and metrics(port)["tissue_clients"] == 8)
    for c in clients:
        c.close()
    check("when they have left, there is room", wait_for(lambda: refusal(port) == 101))
    slow = Client(port, receive_buffer=2048)
    wait_for(lambda: refused(port, "slow") > 0)
    check("a page that does not read is dropped", refused(port, "slow") == 1 and metrics(port)["tissue_frames_dropped_total"] > 0)
    slow.close()
    idle = socket.create_connection(("127.0.0.1", port))
    idle.sendall(b"GET / HTTP/1.1\r\n")
    idle.settimeout(PATIENCE_S)
    began = time.monotonic()
    idle.recv(100)
    check("a request that does not end is given up after 5 s", time.monotonic() - began > 3, time.monotonic() - began)
    idle.close()


def attack(port):
    before = metrics(port)
    sent = hostile_frames(port, 1000)
    connects(port, 100)
    status = get(port, "/healthz")[0]
    wait_for(lambda: metrics(port)["tissue_clients"] == 0)
    after = metrics(port)
    check("a thousand hostile frames and a hundred connects: it goes on, without a fault, and nobody stays",
          status == 200 and sent >= 1000 and after["tissue_ticks_total"] > before["tissue_ticks_total"] and after["tissue_clients"] == 0
          and all(v == 0 for k, v in after.items() if k.startswith("tissue_faults_total")), after)
    # a virtual machine charges the tick's thread for time that its host took, so a few misses say nothing: the median tick has to be in time
    ticks, missed = (after[key] - before[key] for key in ("tissue_ticks_total", "tissue_misses_program_total"))
    check("the median tick kept its period meanwhile", missed < ticks / 2, missed, ticks)


def ending():
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # nohup's would be handed down
    for sign in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
        record = scratch / f"s{sign}.h5"
        server = Server(program, model, "--port", "0", "--record", str(record), "--json")
        client = Client(server.port)
        client.state()
        server.process.send_signal(sign)
        bye = client.hear("bye")
        end = client.ended()
        client.close()
        status, out, err = server.wait()
        check(f"{sign.name}: bye, then 1001, exit 0", bye is not None and end and end[0] == 1001 and status == 0, bye, end, status, err)
        statistics = json.loads(out)
        with h5py.File(record) as f:
            check(f"{sign.name}: the recording is whole, and its last tick is the statistics's", f.attrs["kind"] == b"recording"
                  and len(f["time"]) + f.attrs["dropped_samples"] == statistics["ticks"] > 10 and statistics["device"] == "pointer", statistics["ticks"])
    status, _, _ = Server(program, model, "--seconds", "0.5").wait()
    check("--seconds ends it by itself", status == 0, status)


def command_line():
    def run(*arguments):
        done = subprocess.run([program, "serve", *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        return done.returncode, done.stderr
    with socket.create_server(("127.0.0.1", 0)) as taken:
        status, err = run(model, "--port", str(taken.getsockname()[1]))
    check("a port in use: exit 1, one line", status == 1 and err.count("\n") == 1 and "cannot listen on 127.0.0.1 port" in err, status, err)
    for sentence, arguments in (("a token on the command line", ("--token=0123456789abcdef",)),
                                ("an address that is a name", ("--bind", "example.org")), ("a recording of two models", (model, "--record", "x.h5")),
                                ("no clients", ("--clients", "0")), ("a port that is none", ("--port", "70000"))):
        status, err = run(model, *arguments)
        check(f"{sentence}: exit 2", status == 2, status, err)
    for words in (("--token", "secret-of-mine"), ("--token=secret-of-mine",)):
        status, err = run(model, *words)
        check(f"{' '.join(words)}: exit 2, the variable is named and the text is not", status == 2 and "TISSUECTL_TOKEN" in err and "secret-of-mine" not in err, status, err)
    done = subprocess.run([program, "serve", model], capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, "TISSUECTL_TOKEN": "abc"})
    check("a token too short: exit 2, one line", done.returncode == 2 and "TISSUECTL_TOKEN: wanted 16 to 128" in done.stderr, done.returncode, done.stderr)
    status, err = run(str(scratch / "none.h5"))
    check("a model that is not there: exit 1, one line", status == 1 and err.count("\n") == 1 and "none.h5" in err, status, err)
    status, err = run(model, "--record", str(scratch / "none" / "s.h5"))
    check("a recording that cannot be written: exit 1", status == 1 and "cannot write" in err, status, err)


def slow_download(port, path, bytes_a_second):
    """How many bytes come of an answer that is taken at this rate, and how many should."""
    with socket.socket() as s:
        s.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 8192)
        s.settimeout(PATIENCE_S)
        s.connect(("127.0.0.1", port))
        s.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n".encode())
        began, taken, head = time.monotonic(), 0, b""
        try:
            while part := s.recv(8192):
                taken += len(part)
                head += part if len(head) < 2000 else b""
                time.sleep(max(0, began + taken / bytes_a_second - time.monotonic()))
        except ConnectionResetError:
            pass
    size = int(re.search(rb"Content-Length: (\d+)", head)[1])
    return taken - head.index(b"\r\n\r\n") - 4, size, time.monotonic() - began


def answer_of(connection):
    """(status, text) of what a connection is told before it is closed; (None, "") when nothing."""
    connection.settimeout(PATIENCE_S)
    told = b""
    try:
        while part := connection.recv(65536):
            told += part
    except ConnectionError:
        pass
    return (int(told.split()[1]), told.decode()) if told else (None, "")


def crowds(port, page="/", headers=""):
    """Many connections, which say nothing or half of something, and one who wants the page."""
    for sentence, words in (("silent", b""), ("halfway through a request", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")):
        crowd = []
        for _ in range(150):
            crowd.append(socket.create_connection(("127.0.0.1", port)))
            crowd[-1].sendall(words)
        loads = [get(port, page, headers=headers)[0] for _ in range(40)]
        check(f"a crowd of 150 connections, {sentence}: every load of the page succeeds", loads == [200] * 40, loads)
        gave_way = answer_of(crowd[0])
        check("who gives way is told so", gave_way[0] == 503 and "this one gave way to another" in gave_way[1], gave_way)
        last = answer_of(crowd[-1])
        reason = "nothing came within 2 s" if not words else "no whole request came within 5 s"
        check("who is late is told so", last[0] == 408 and reason in last[1], last)
        for c in crowd:
            c.close()
    many = [socket.create_connection(("127.0.0.1", port), source_address=(f"127.0.0.{k + 2}", 0)) for k in range(100)]
    check("nor do a hundred from as many addresses of this machine", [get(port, page, headers=headers)[0] for _ in range(10)] == [200] * 10)
    for c in many:
        c.close()


def rates(port):
    one = b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    told = request(port, one * 2000 + one.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"))
    check("too many requests a second: 429, when, and why", told.count(b"HTTP/1.1 429") == 1 and 100 < told.count(b"HTTP/1.1 200") < 1500
          and b"Retry-After: 1" in told and b"more than 250 requests a second" in told, told.count(b"HTTP/1.1 200"), told[-400:])
    time.sleep(1)  # as the answer says
    check("and a second later again", get(port, "/healthz")[0] == 200 and refused(port, "requests") >= 1)
    taken, size, seconds = slow_download(port, "/three.module.js", 150e3)
    check("a slow download at 150 kB/s is whole", taken == size > 1e6 and seconds > 5.5, taken, size, seconds)
    slow = socket.socket()
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.connect(("127.0.0.1", port))
    before = refused(port, "slow")
    slow.sendall(b"GET /three.module.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    check("one that is not taken is given up", wait_for(lambda: refused(port, "slow") == before + 1, 60))
    slow.close()


def token():
    secret = "0123456789abcdefXYZ_-"
    record = scratch / "token.h5"
    server = Server(program, model, "--bind", "0.0.0.0", "--record", str(record), TISSUECTL_TOKEN=secret)
    port = server.port
    check("with a token the URL has it", server.url.endswith(f"/?token={secret}"), server.url)
    check("without it: 401, to pages and WebSockets", [get(port, p)[0] for p in ("/", "/page.js", "/metrics", f"/?token={secret[:-1]}")] == [401] * 4
          and refusal(port) == 401)
    status, head, _ = get(port, f"/?token={secret}")
    cookie = re.search(rf"Set-Cookie: (tissue_token_{port}=[^;]*); (.*)\r", head)
    there = re.search(r"Location: (/[0-9a-f]{32}/)\r", head)
    check("with it the page's own path, without the token, and a cookie of this port and that path alone", status == 303 and cookie and there
          and f"Path={there[1]};" in cookie[2] and "HttpOnly" in cookie[2] and "SameSite=Lax" in cookie[2], head)
    mine = f"Cookie: {cookie[1]}\r\n"
    check("the cookie lets in, to the page, its parts and its WebSocket", [get(port, there[1] + p, headers=mine)[0] for p in ("", "page.js", "healthz")] == [200] * 3
          and refusal(port, path=f"{there[1]}ws", headers=mine) == 101 and refusal(port, path=f"/ws?token={secret}") == 101)
    check("the path without the cookie does not", [get(port, there[1] + p)[0] for p in ("", "page.js", "metrics")] == [401] * 3)
    earlier = "/" + "0123456789abcdef" * 2 + "/"
    check("a page of an earlier session finds its server again, by the same token", get(port, earlier + "healthz", headers=mine)[0] == 200
          and refusal(port, path=earlier + "ws", headers=mine) == 101 and get(port, earlier + "healthz")[0] == 401)
    other = Server(program, model, "--token")
    drawn = re.search(r"/\?token=([0-9a-f]{32})$", other.url)
    check("--token draws one", drawn and get(other.port, f"/?token={drawn[1]}")[0] == 303 and get(other.port)[0] == 401, other.url)
    check("which no list of processes has", drawn[1].encode() not in Path(f"/proc/{other.process.pid}/cmdline").read_bytes())
    both = f"Cookie: {cookie[1]}; tissue_token_{other.port}={drawn[1]}\r\n"
    check("the cookies of two servers stand beside each other", [get(p, headers=both)[0] for p in (port, other.port)] == [200] * 2)
    crowds(port, there[1], mine)
    began, guesses = time.monotonic(), []
    while 429 not in guesses and len(guesses) < 3000:
        guesses.append(get(port, "/?token=guess")[0])
    check("who guesses tokens is refused by their number, and takes none from the owner's", get(port, there[1], headers=mine)[0] == 200
          and (429 in guesses or len(guesses) / (time.monotonic() - began) < 260), guesses[-1])
    status, _, err = other.end()
    check("it is printed once", status == 0 and err.count(drawn[1]) == 1, err)
    status, _, _ = server.end()
    with h5py.File(record) as f:
        check("the recording does not hold the token", status == 0 and secret.encode() not in f.attrs["command"], f.attrs["command"])
    beyond = [Server(program, model, "--bind", "0.0.0.0") for _ in range(2)]
    drawn = [re.search(r"/\?token=([0-9a-f]{32})$", s.url) for s in beyond]
    check("beyond this machine a token is drawn, another each time", all(drawn) and drawn[0][1] != drawn[1][1] and get(beyond[0].port)[0] == 401)
    for s in beyond:
        s.end()


command_line()
server = Server(program, model, "--port", "0")
for part in (http, conversation, misbehaviour, crowds, rates, attack):
    part(server.port)
status, out, err = server.end()
check("after all this it ends as it should", status == 0 and "rror" not in err, status, err)
ending()
token()
sys.exit(failed > 0)
