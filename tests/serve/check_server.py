"""Access rules and limits of `tissuectl serve`, over sockets: check_server.py PROGRAM MODEL SCRATCH
Prints "ok - sentence", or "not ok - sentence" and the values seen; exits 1 if any failed."""
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
    """End of a connection after act(client), as Client.ended() gives it."""
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

    # about 0.01 s; the best of many loads, because the machine may be busy
    check("the page and its parts load in under a second", wait_for(fetched) and all(p[0] == 200 for p in pages.values()), took)
    policy = re.search(r"Content-Security-Policy: (.*)\r", pages["/"][1])
    check("the content security policy allows only resources of the page's own origin", policy and "default-src 'none'" in policy[1]
          and "unsafe" not in policy[1] and "script-src 'self'" in policy[1] and "*" not in policy[1], policy)
    check("content types are declared, with nosniff", "text/html" in pages["/"][1] and "text/css" in pages["/page.css"][1]
          and "text/javascript" in pages["/page.js"][1] and all("nosniff" in p[1] for p in pages.values())
          and "text/javascript" in pages["/three.module.js"][1])
    status, head, body = get(port, "/page.js", "HEAD")
    check("HEAD has the length of GET and no body", status == 200 and body == b"" and f"Content-Length: {len(pages['/page.js'][2])}" in head, head)
    answers = [get(port, "/", method) for method in ("POST", "PUT", "DELETE", "OPTIONS", "BREW")]
    check("other methods: 405 with the allowed ones", all(a[0] == 405 and "Allow: GET, HEAD" in a[1] for a in answers[:4])
          and answers[4][0] in (400, 405), [a[0] for a in answers])
    check("other paths: 404", [get(port, p)[0] for p in ("/index.html", "/../Makefile", "/%2e%2e/etc/passwd", "//", "/surface")] == [404] * 5)
    check("a Host that is a domain name, or an empty one: 403", [get(port, "/", host=h)[0] for h in ("evil.example", f"evil.example:{port}", "")] == [403] * 3)
    check("a numeric Host or localhost is served", [get(port, "/healthz", host=h)[0] for h in (f"localhost:{port}", "[::1]:1", "10.0.0.1")] == [200] * 3)
    check("a request from another Origin: 403", get(port, "/", headers="Origin: http://evil.example\r\n")[0] == 403)
    check("a request without Host, or one that is not HTTP: 4xx or no answer", all(request(port, t)[9:10] in (b"4", b"") for t in
          ("GET / HTTP/1.1\r\nConnection: close\r\n\r\n", "hello\r\n\r\n", b"\x16\x03\x01\x02\x00\x01\xfc" + bytes(100),
           "GET / HTTP/1.1\r\nHost: 127.0.0.1\r\nX: " + "y" * 20000 + "\r\n\r\n")))
    check("a request with a body: 400 or 413", get(port, "/", headers="Content-Length: 5\r\n")[0] in (400, 413))
    check("/ws without an upgrade: 426", get(port, "/ws")[0] == 426)
    wait_for(lambda: metrics(port)["tissue_ticks_total"] > 0)   # the first state comes with the 17th tick
    m = metrics(port)
    check("metrics: ticks, tick times and refusals are counted", m["tissue_ticks_total"] > 0 and m["tissue_misses_total"] >= 0
          and 0 < m['tissue_tick_seconds{quantile="0.5"}'] <= m['tissue_tick_seconds{quantile="0.99"}']
          and m['tissue_refused_total{reason="host"}'] >= 3 and m['tissue_refused_total{reason="method"}'] >= 4, m)
    lines = get(port, "/metrics")[2].decode().splitlines()
    check("metrics: every line is a comment or a name and a number", all(
        re.fullmatch(r"# (HELP|TYPE) tissue_[a-z_]+ .+|tissue_[a-z_0-9]+(\{[a-z_]+=\"[^\"]*\"\})? [-+0-9.e]+", l) for l in lines))


def conversation(port):
    client = Client(port)
    first = json.loads(client.receive()[1])
    check("the first message is the model with its FE curves", first["type"] == "model" and all(len(p["curve"]) == 3 for p in first["places"]), first["type"])
    check("the demo starts by itself", client.hear("control", holder="demo") is not None)
    state = client.state()
    check("a state counts ticks and one client", state[1] > 0 and state[26] == 1, state)
    times = [client.state()[0] for _ in range(200)]
    rate = (len(times) - 1) / (times[-1] - times[0])   # per second of simulated time, at any speed of the machine
    check("states are sent 60 times a second at most", rate <= 62, rate)
    deepest = 0
    for k in range(60):
        client.say(type="pointer", x=0.05, y=0.12 - 0.028 * min(1, k / 30), down=True)
        state = client.state()
        deepest = max(deepest, -state[15])
    check("a pointer that moves down indents the tissue", deepest > 0.004 and state[13] == 0 and state[19] < 0, deepest, state)
    check("a state has the nearest place and its FE force", state[22] >= 0 and state[23] > 0, state[22:24])
    other = Client(port)
    other.say(type="pointer", x=0, y=0, down=True)
    check("another client is told that the tissue is held", other.hear("control", holder="other") is not None)
    client.say(type="pointer", x=0, y=0, down=False)
    check("after release the hand leaves the tissue", client.until(lambda k, p: k == 2 and
          numbers(p)[13] == -1 and numbers(p)[10] > 0.1) is not None)
    client.say(type="pause", on=True)
    check("a pause is sent to the other client", other.hear("control", paused=True) is not None)
    a, b = client.state(), client.state()
    while a[1] != b[1]:   # states from before the pause may still arrive
        a, b = b, client.state()
    b = [client.state() for _ in range(5)][-1]
    check("during a pause there is no tick", a[1] == b[1] and a[0] == b[0], a[1], b[1])
    client.say(type="pause", on=False)
    client.say(type="reset")
    check("ticks continue after pause and reset", client.until(lambda k, p: k == 2 and numbers(p)[1] > b[1]) is not None)
    client.say(type="demo", place=1)
    check("the demo can be requested at a place", client.hear("control", holder="demo", place=1) is not None)
    state = client.state()
    check("no position of the pointer is a fault", state[5] == 0, state[5])
    client.send(b"\x03\xe8", kind=CLOSE)
    check("a close frame is answered with code 1000", client.ended() == (1000, ""))
    client.close(), other.close()


def empty_pieces(port):
    """End of the connection and number of bytes accepted, for one message in endless empty fragments."""
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
    check("a WebSocket from a foreign Origin: 403", refusal(port, headers="Origin: http://evil.example\r\n") == 403)
    check("a WebSocket from Origin null: 403", refusal(port, headers="Origin: null\r\n") == 403)
    check("a WebSocket from the page's own Origin is accepted", refusal(port, headers=f"Origin: http://127.0.0.1:{port}\r\n") == 101)
    check("a WebSocket with a domain name as Host: 403", refusal(port, host=f"evil.example:{port}") == 403)
    for sentence, text, reason in (("not JSON", "{", "not JSON"), ("an unknown type", '{"type":"fly"}', "'type' must be one of"),
                                   ("an unknown key", '{"type":"reset","x":1}', "a key that a message of this type does not have"),
                                   ("a number that is not finite", '{"type":"pointer","x":1e999,"y":0,"down":true}', "not JSON"),
                                   ("a pointer with z in the plane", '{"type":"pointer","x":0,"y":0,"z":0,"down":true}', "'z' is not allowed: this model is in the plane"),
                                   ("a model that does not exist", '{"type":"model","model":7}', "no such model")):
        end = ends(port, lambda c: c.send(text))
        check(f"{sentence}: 1008 and the reason", end and end[0] == 1008 and end[1].startswith(reason), end)
    check("a binary message: 1008", ends(port, lambda c: c.send(b"12", kind=2))[0] == 1008)
    check("text that is not UTF-8: closed", ends(port, lambda c: c.send(b"\xff\xfe{}"))[0] in (1007, 1008))
    check("a message that is too long: 1009 and the reason", ends(port, lambda c: c.send(" " * 1025)) == (1009, "a message longer than 1024 bytes"))
    check("a fragmented message that is too long: 1009", ends(port, lambda c: [c.send(" " * 300, kind=TEXT if k == 0 else 0, final=False) for k in range(5)])[0] == 1009)
    check("an announced length above the limit: 1009", ends(port, lambda c: (c.send(b" " * 2000, size=2 ** 62)))[0] == 1009)
    end = ends(port, lambda c: [c.say(type="reset") for _ in range(600)])
    check("too many messages a second: 1008", end in ((1008, "too many messages a second"), (None, "")), end)
    check("a flood of pings: closed", ends(port, lambda c: [c.send(b"", kind=PING) for _ in range(600)]) in ((1008, "too many messages a second"), (None, "")))
    before = refused(port, "rate")
    check("both floods are counted as refusals", before == 2, before)
    end, taken = empty_pieces(port)
    check("a message in endless empty fragments: 1008, and less than 30 MB of it are accepted", end in ((1008, "too many messages a second"), (None, "")) and taken < 30e6, end, taken)
    check("it is counted as a refusal, and its seat is free within 15 s", refused(port, "rate") == 3 and wait_for(lambda: metrics(port)["tissue_clients"] == 0, 15))
    check("an unmasked frame: closed", ends(port, lambda c: c.send("{}", mask=False)) is not None)
    clients = [Client(port) for _ in range(8)]
    check("a ninth client: 503", refusal(port) == 503 and metrics(port)["tissue_clients"] == 8)
    for c in clients:
        c.close()
    check("a client is accepted after the others have left", wait_for(lambda: refusal(port) == 101))
    slow = Client(port, receive_buffer=2048)
    wait_for(lambda: refused(port, "slow") > 0)
    check("a client that does not read is dropped", refused(port, "slow") == 1 and metrics(port)["tissue_frames_dropped_total"] > 0)
    slow.close()
    idle = socket.create_connection(("127.0.0.1", port))
    idle.sendall(b"GET / HTTP/1.1\r\n")
    idle.settimeout(PATIENCE_S)
    began = time.monotonic()
    idle.recv(100)
    check("an incomplete request is closed, but not before 3 s", time.monotonic() - began > 3, time.monotonic() - began)
    idle.close()


def attack(port):
    before = metrics(port)
    hostile_frames(port, 1000)
    connects(port, 100)
    status = get(port, "/healthz")[0]
    wait_for(lambda: metrics(port)["tissue_clients"] == 0)
    after = metrics(port)

    def grown(name):
        return sum(v - before.get(k, 0) for k, v in after.items() if k.split("{")[0] == name)

    faults = [v for k, v in after.items() if k.startswith("tissue_faults_total{")]
    check("after 1000 hostile frames and 100 connects the server runs without faults and without clients",
          status == 200 and grown("tissue_ticks_total") > 0 and after["tissue_clients"] == 0 and faults == [0, 0, 0], after)
    # a connection ends at its first frame that is refused: the server receives few of those that are sent
    check("messages of the attack are received, and most connections of it are refused", grown("tissue_messages_total") > 0
          and grown("tissue_refused_total") > 30, before, after)
    # A virtual machine charges the thread of the tick for time that its host took, so a few overruns mean nothing.
    # Only the median tick must be in time.
    ticks, missed = grown("tissue_ticks_total"), grown("tissue_misses_program_total")
    check("fewer than half of the ticks overrun by the program's own work during the attack", missed < ticks / 2, missed, ticks)


def ending():
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # otherwise a server inherits the setting of nohup
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
            check(f"{sign.name}: the recording has as many ticks as the session statistics", f.attrs["kind"] == b"recording"
                  and len(f["time"]) + f.attrs["dropped_samples"] == statistics["ticks"] > 10 and statistics["device"] == "pointer", statistics["ticks"])
    status, _, _ = Server(program, model, "--seconds", "0.5").wait()
    check("--seconds ends the session with exit 0", status == 0, status)


def command_line():
    def run(*arguments):
        done = subprocess.run([program, "serve", *arguments], capture_output=True, text=True, timeout=PATIENCE_S)
        return done.returncode, done.stderr
    with socket.create_server(("127.0.0.1", 0)) as taken:
        status, err = run(model, "--port", str(taken.getsockname()[1]))
    check("a port in use: exit 1, one line", status == 1 and err.count("\n") == 1 and "cannot listen on 127.0.0.1 port" in err, status, err)
    for sentence, arguments in (("a token on the command line", ("--token=0123456789abcdef",)),
                                ("a domain name as address", ("--bind", "example.org")), ("a recording of two models", (model, "--record", "x.h5")),
                                ("0 clients", ("--clients", "0")), ("a port that does not exist", ("--port", "70000"))):
        status, err = run(model, *arguments)
        check(f"{sentence}: exit 2", status == 2, status, err)
    for words in (("--token", "secret-of-mine"), ("--token=secret-of-mine",)):
        status, err = run(model, *words)
        check(f"{' '.join(words)}: exit 2 with the name of the variable and without the token", status == 2 and "TISSUECTL_TOKEN" in err and "secret-of-mine" not in err, status, err)
    done = subprocess.run([program, "serve", model], capture_output=True, text=True, timeout=PATIENCE_S, env={**os.environ, "TISSUECTL_TOKEN": "abc"})
    check("a token that is too short: exit 2 and the allowed length", done.returncode == 2 and "TISSUECTL_TOKEN: must have 16 to 128" in done.stderr, done.returncode, done.stderr)
    status, err = run(str(scratch / "none.h5"))
    check("a missing model: exit 1, one line", status == 1 and err.count("\n") == 1 and "none.h5" in err, status, err)
    status, err = run(model, "--record", str(scratch / "none" / "s.h5"))
    check("a recording that cannot be written: exit 1", status == 1 and "cannot write" in err, status, err)


def slow_download(port, path, bytes_a_second):
    """Bytes of an answer that is received at this rate, bytes announced, and seconds."""
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
    """(status, text) of the answer before the connection is closed; (None, "") without one."""
    connection.settimeout(PATIENCE_S)
    told = b""
    try:
        while part := connection.recv(65536):
            told += part
    except ConnectionError:
        pass
    return (int(told.split()[1]), told.decode()) if told else (None, "")


def crowds(port, page="/", headers=""):
    """Many connections without a complete request, and one client that loads the page."""
    for sentence, words in (("silent", b""), ("halfway through a request", b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n")):
        crowd = []
        for _ in range(150):
            crowd.append(socket.create_connection(("127.0.0.1", port)))
            crowd[-1].sendall(words)
        loads = [get(port, page, headers=headers)[0] for _ in range(40)]
        check(f"150 connections, {sentence}: every load of the page succeeds", loads == [200] * 40, loads)
        gave_way = answer_of(crowd[0])
        check("a connection that is closed to make room gets 503 and the reason", gave_way[0] == 503 and "this one was closed to accept another" in gave_way[1], gave_way)
        last = answer_of(crowd[-1])
        reason = "no data was received within 2 s" if not words else "no complete request was received within 5 s"
        check("a late connection gets 408 and the reason", last[0] == 408 and reason in last[1], last)
        for c in crowd:
            c.close()
    many = [socket.create_connection(("127.0.0.1", port), source_address=(f"127.0.0.{k + 2}", 0)) for k in range(100)]
    check("100 connections from 100 local addresses: every load of the page succeeds", [get(port, page, headers=headers)[0] for _ in range(10)] == [200] * 10)
    for c in many:
        c.close()


def rates(port):
    one = b"GET /healthz HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n"
    told = request(port, one * 2000 + one.replace(b"\r\n\r\n", b"\r\nConnection: close\r\n\r\n"))
    check("too many requests a second: 429 with Retry-After and the reason", told.count(b"HTTP/1.1 429") == 1 and 100 < told.count(b"HTTP/1.1 200") < 1500
          and b"Retry-After: 1" in told and b"more than 250 requests a second" in told, told.count(b"HTTP/1.1 200"), told[-400:])
    time.sleep(1)  # as Retry-After states
    check("a request one second later succeeds", get(port, "/healthz")[0] == 200 and refused(port, "requests") >= 1)
    taken, size, seconds = slow_download(port, "/three.module.js", 150e3)
    check("a slow download at 150 kB/s is complete", taken == size > 1e6 and seconds > 5.5, taken, size, seconds)
    slow = socket.socket()
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.connect(("127.0.0.1", port))
    before = refused(port, "slow")
    slow.sendall(b"GET /three.module.js HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n")
    check("a download that is not received is closed", wait_for(lambda: refused(port, "slow") == before + 1, 60))
    slow.close()


def token():
    secret = "0123456789abcdefXYZ_-"
    record = scratch / "token.h5"
    server = Server(program, model, "--bind", "0.0.0.0", "--record", str(record), TISSUECTL_TOKEN=secret)
    port = server.port
    check("the printed URL contains the token", server.url.endswith(f"/?token={secret}"), server.url)
    check("pages and WebSockets without the token: 401", [get(port, p)[0] for p in ("/", "/page.js", "/metrics", f"/?token={secret[:-1]}")] == [401] * 4
          and refusal(port) == 401)
    status, head, _ = get(port, f"/?token={secret}")
    cookie = re.search(rf"Set-Cookie: (tissue_token_{port}=[^;]*); (.*)\r", head)
    there = re.search(r"Location: (/[0-9a-f]{32}/)\r", head)
    check("the token redirects to a session path without it and sets a cookie for this port and that path", status == 303 and cookie and there
          and f"Path={there[1]};" in cookie[2] and "HttpOnly" in cookie[2] and "SameSite=Lax" in cookie[2], head)
    mine = f"Cookie: {cookie[1]}\r\n"
    check("the cookie gives access to the page, its parts and its WebSocket", [get(port, there[1] + p, headers=mine)[0] for p in ("", "page.js", "healthz")] == [200] * 3
          and refusal(port, path=f"{there[1]}ws", headers=mine) == 101 and refusal(port, path=f"/ws?token={secret}") == 101)
    check("the session path without the cookie: 401", [get(port, there[1] + p)[0] for p in ("", "page.js", "metrics")] == [401] * 3)
    earlier = "/" + "0123456789abcdef" * 2 + "/"
    check("a page of an earlier session has access with the same token", get(port, earlier + "healthz", headers=mine)[0] == 200
          and refusal(port, path=earlier + "ws", headers=mine) == 101 and get(port, earlier + "healthz")[0] == 401)
    other = Server(program, model, "--token")
    drawn = re.search(r"/\?token=([0-9a-f]{32})$", other.url)
    check("--token draws a token", drawn and get(other.port, f"/?token={drawn[1]}")[0] == 303 and get(other.port)[0] == 401, other.url)
    check("the drawn token is not in the command line of the process", drawn[1].encode() not in Path(f"/proc/{other.process.pid}/cmdline").read_bytes())
    both = f"Cookie: {cookie[1]}; tissue_token_{other.port}={drawn[1]}\r\n"
    check("cookies of two servers are valid side by side", [get(p, headers=both)[0] for p in (port, other.port)] == [200] * 2)
    crowds(port, there[1], mine)
    began, guesses = time.monotonic(), []
    while 429 not in guesses and len(guesses) < 3000:
        guesses.append(get(port, "/?token=guess")[0])
    check("token guesses are limited in rate, and the owner still has access", get(port, there[1], headers=mine)[0] == 200
          and (429 in guesses or len(guesses) / (time.monotonic() - began) < 260), guesses[-1])
    status, _, err = other.end()
    check("the drawn token is printed once", status == 0 and err.count(drawn[1]) == 1, err)
    status, _, _ = server.end()
    with h5py.File(record) as f:
        check("the recording does not contain the token", status == 0 and secret.encode() not in f.attrs["command"], f.attrs["command"])
    beyond = [Server(program, model, "--bind", "0.0.0.0") for _ in range(2)]
    drawn = [re.search(r"/\?token=([0-9a-f]{32})$", s.url) for s in beyond]
    check("a server for other machines draws a new token each time", all(drawn) and drawn[0][1] != drawn[1][1] and get(beyond[0].port)[0] == 401)
    for s in beyond:
        s.end()


command_line()
server = Server(program, model, "--port", "0")
for part in (http, conversation, misbehaviour, crowds, rates, attack):
    part(server.port)
status, out, err = server.end()
check("the server then ends with exit 0 and no error message", status == 0 and "rror" not in err, status, err)
ending()
token()
sys.exit(failed > 0)
