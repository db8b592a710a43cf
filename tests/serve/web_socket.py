"""A WebSocket client for tests and bench of `tissuectl serve`, which can also violate the protocol. It needs only the
standard library."""
import base64
import json
import os
import random
import socket
import struct
import subprocess
import time

TEXT, BINARY, CLOSE, PING, PONG = 1, 2, 8, 9, 10
PATIENCE_S = 120  # longest wait; waits take less than 1 s except in a failing test or on a busy machine


def wait_for(wanted, seconds=PATIENCE_S):
    """Polls wanted() until its value is true, and returns that; after the time it returns the last value."""
    end = time.monotonic() + seconds
    while not (answer := wanted()) and time.monotonic() < end:
        time.sleep(0.02)
    return answer


class Server:
    """A running `tissuectl serve`; its port is read from its output."""

    def __init__(self, program, *arguments, **environment):
        self.process = subprocess.Popen([program, "serve", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                        text=True, env={**os.environ, **environment})
        self.said, self.url = "", None
        while self.url is None:
            line = self.process.stderr.readline()
            if not line:
                raise RuntimeError(f"tissuectl serve did not start: {self.said}")
            self.said += line
            if line.startswith("tissuectl serve: http://"):
                self.url = line.split()[-1]
        self.host = self.url.split("/")[2]
        self.port = int(self.host.rsplit(":", 1)[1])

    def end(self, signal=15):
        """Sends a signal; returns exit status, standard output and all of standard error."""
        self.process.send_signal(signal)
        return self.wait()

    def wait(self):
        out, err = self.process.communicate(timeout=PATIENCE_S)
        return self.process.returncode, out, self.said + err


def request(port, text, timeout=PATIENCE_S):
    """The whole answer to these bytes, until the server closes."""
    with socket.create_connection(("127.0.0.1", port), timeout=timeout) as s:
        s.sendall(text if isinstance(text, bytes) else text.encode())
        answer = b""
        try:
            while part := s.recv(65536):
                answer += part
        except ConnectionResetError:
            pass
        return answer


def get(port, path="/", method="GET", host=None, headers=""):
    """(status, headers as text, body) of one request."""
    host = f"127.0.0.1:{port}" if host is None else host
    answer = request(port, f"{method} {path} HTTP/1.1\r\nHost: {host}\r\n{headers}Connection: close\r\n\r\n")
    head, _, body = answer.partition(b"\r\n\r\n")
    return int(head.split()[1]) if head else 0, head.decode(), body


class Refused(Exception):
    def __init__(self, status, body):
        super().__init__(status, body)
        self.status, self.body = status, body


def numbers(payload):
    """The 32 numbers at the head of a state."""
    return struct.unpack("<32d", payload[:256])


class Client:
    """One WebSocket. Raises Refused if the server refuses the handshake."""

    def __init__(self, port, path="/ws", headers="", host=None, receive_buffer=None):
        self.socket = socket.socket()
        if receive_buffer:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, receive_buffer)
        self.socket.settimeout(PATIENCE_S)
        self.socket.connect(("127.0.0.1", port))
        self.buffer = b""
        key = base64.b64encode(os.urandom(16)).decode()
        host = f"127.0.0.1:{port}" if host is None else host
        self.socket.sendall(f"GET {path} HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
                            f"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n{headers}\r\n".encode())
        while b"\r\n\r\n" not in self.buffer:
            part = self.socket.recv(65536)
            if not part:
                raise Refused(0, b"closed")
            self.buffer += part
        head, _, self.buffer = self.buffer.partition(b"\r\n\r\n")
        status = int(head.split()[1])
        if status != 101:
            raise Refused(status, self.buffer)

    def take(self, count):
        while len(self.buffer) < count:
            part = self.socket.recv(65536)
            if not part:
                raise EOFError
            self.buffer += part
        taken, self.buffer = self.buffer[:count], self.buffer[count:]
        return taken

    def receive(self):
        """(kind, payload) of the next frame; the server sends each message in one frame."""
        first, second = self.take(2)
        size = second & 127
        if size > 125:
            size = int.from_bytes(self.take(2 if size == 126 else 8), "big")
        return first & 15, self.take(size)

    def send(self, data, kind=TEXT, final=True, mask=True, size=None):
        data = data.encode() if isinstance(data, str) else data
        size = len(data) if size is None else size
        header = bytes([(0x80 if final else 0) | kind])
        flag = 0x80 if mask else 0
        header += (bytes([flag | size]) if size < 126 else bytes([flag | 126]) + struct.pack(">H", size) if size < 65536
                   else bytes([flag | 127]) + struct.pack(">Q", size))
        if mask:
            key = os.urandom(4)
            header += key
            data = bytes(b ^ key[k % 4] for k, b in enumerate(data))
        self.socket.sendall(header + data)

    def say(self, **message):
        self.send(json.dumps(message))

    def until(self, wanted, seconds=PATIENCE_S):
        """The first message for which wanted(kind, payload) is true; None after the time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            kind, payload = self.receive()
            if wanted(kind, payload):
                return kind, payload
        return None

    def hear(self, type, seconds=PATIENCE_S, **keys):
        """The next JSON message of a type with these keys."""
        found = self.until(lambda kind, p: kind == TEXT and (m := json.loads(p))["type"] == type
                           and all(m[k] == v for k, v in keys.items()), seconds)
        return found and json.loads(found[1])

    def state(self):
        """The next state's 32 numbers."""
        return numbers(self.until(lambda kind, _: kind == BINARY)[1])

    def ended(self, seconds=PATIENCE_S):
        """(code, reason) of the server's close frame; (None, "") if it disconnects without one; None after the time."""
        try:
            found = self.until(lambda kind, _: kind == CLOSE, seconds)
        except (EOFError, ConnectionError):
            return None, ""
        except TimeoutError:
            return None
        return found and (int.from_bytes(found[1][:2], "big"), found[1][2:].decode())

    def close(self):
        self.socket.close()


# ---- violations of the protocol

def hostile_frames(port, count, seed=1):
    """Sends at least `count` frames that no page sends, over several connections. Returns their number."""
    draw = random.Random(seed)
    sent = 0
    while sent < count:
        try:
            client = Client(port)
        except (Refused, OSError):
            time.sleep(0.02)
            continue
        try:
            for _ in range(draw.randrange(1, 60)):
                sent += 1
                kind = draw.randrange(8)
                if kind < 3:   # well-formed, but no motion of a hand
                    client.say(type="pointer", x=draw.uniform(-1e6, 1e6), y=draw.choice([1e300, -1e300, draw.uniform(0, .1)]), down=True,
                               **draw.choice([{}, {}, {"z": draw.choice([1e300, draw.uniform(0, .1)])}]))
                elif kind == 3:
                    client.send(os.urandom(draw.randrange(200)), kind=draw.choice([TEXT, BINARY, PING, PONG]))
                elif kind == 4:
                    client.send(b"{" * draw.randrange(2000))
                elif kind == 5:
                    client.send(os.urandom(50), kind=draw.choice([0, 3, 7, 11, 15]))
                elif kind == 6:
                    client.send(b"x", size=draw.choice([2000, 65535, 2 ** 31, 2 ** 63 - 1]))
                else:
                    client.send(b'{"type":"reset"}', final=draw.random() < .5, mask=draw.random() < .5)
        except OSError:
            pass
        client.close()
    return sent


def connects(port, count, seed=2):
    """Connects `count` times, and disconnects at a random stage up to the finished handshake."""
    draw = random.Random(seed)
    for _ in range(count):
        kind = draw.randrange(4)
        try:
            if kind == 0:
                socket.create_connection(("127.0.0.1", port)).close()
            elif kind == 1:
                with socket.create_connection(("127.0.0.1", port)) as s:
                    s.sendall(os.urandom(draw.randrange(1, 3000)))
            elif kind == 2:
                with socket.create_connection(("127.0.0.1", port)) as s:
                    s.sendall(b"GET /ws HTTP/1.1\r\nHost: 127.0.0.1\r\n")
            else:
                Client(port).close()
        except (Refused, OSError):
            pass
