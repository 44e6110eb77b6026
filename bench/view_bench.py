"""What looking at a simulation costs: frames and bytes per second of 'palpate view', and how fast the simulation runs with
and without a page, alternately: the same first steps of the scene each time.

Usage: view_bench.py PALPATE RESULT.json SCENE... [--steps N] [--rounds N] [--threads N]

The page is stood in for by a client that takes a frame, says at once that it has drawn it, and does nothing else: what
it costs is the server's part alone. A browser on the same machine needs cores of its own on top.

Beside the wall clock counts the time that the thread of the simulation was on a core for a step (what a machine that is busy
with other work does not disturb), and that of the thread of the server.
"""

import argparse
import base64
import json
import os
import pathlib
import socket
import statistics
import struct
import subprocess
import threading
import time
import urllib.parse
import urllib.request


class Page:
    """A WebSocket client that counts what it gets."""

    def __init__(self, address, look):
        self.frames = self.bytes = 0
        place = urllib.parse.urlparse(address)
        self.socket = socket.create_connection((place.hostname, place.port))
        key = base64.b64encode(os.urandom(16)).decode()
        self.socket.sendall(
            f"GET {place.path}socket HTTP/1.1\r\nHost: {place.netloc}\r\nOrigin: http://{place.netloc}\r\n"
            f"Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: {key}\r\n\r\n".encode()
        )
        self.stream = self.socket.makefile("rb")
        status = self.stream.readline()
        if b" 101 " not in status:
            raise RuntimeError(f"the server answered {status!r}")
        while self.stream.readline() != b"\r\n":
            pass
        self.send({"look": look})
        self.thread = threading.Thread(target=self.read, daemon=True)
        self.thread.start()

    def send(self, command):
        payload = json.dumps(command).encode()
        mask = os.urandom(4)
        length = struct.pack("!B", 128 | len(payload)) if len(payload) < 126 else struct.pack("!BH", 254, len(payload))
        self.socket.sendall(b"\x81" + length + mask + bytes(b ^ mask[i % 4] for i, b in enumerate(payload)))

    def read(self):
        try:
            while True:
                head, length = self.stream.read(2)
                if length == 126:
                    (length,) = struct.unpack("!H", self.stream.read(2))
                elif length == 127:
                    (length,) = struct.unpack("!Q", self.stream.read(8))
                message = self.stream.read(length)
                self.bytes += length
                if head & 15 == 2 and b'"kind":"frame"' in message[:4096]:
                    self.frames += 1
                    self.send({"shown": {"frame": int(message.split(b'"frame":', 1)[1].split(b",", 1)[0])}})
        except (OSError, ValueError):
            pass  # closed

    def close(self):
        self.socket.shutdown(socket.SHUT_RDWR)
        self.socket.close()
        self.thread.join()


LOOKS = {
    "surface": {},
    "all layers": {"contacts": True, "borders": True, "cells": True},
}


def thread_seconds(pid):
    """Seconds on a core of each thread of a process, to the nanosecond."""
    return {task.name: int((task / "schedstat").read_text().split()[0]) * 1e-9 for task in pathlib.Path(f"/proc/{pid}/task").iterdir()}


def measure(process, address, steps, look):
    """The first so many steps of the scene, with a page (look) or without (None): always the same work."""

    def done():
        with urllib.request.urlopen(address + "status") as answer:
            return json.load(answer).get("steps", 0)

    page = Page(address, look or {})
    page.send({"reset": {}})
    while done() > 5:
        time.sleep(0.01)
    if look is None:
        page.close()
    begin, first, cores = time.perf_counter(), done(), thread_seconds(process.pid)
    frames, size = page.frames, page.bytes
    while done() < steps:
        time.sleep(0.05)
    last, wall, now = done(), time.perf_counter() - begin, thread_seconds(process.pid)
    frames, size = page.frames - frames, page.bytes - size
    if look is not None:
        page.close()
    used = {task: now[task] - cores.get(task, 0.0) for task in now}
    server = used.pop(str(process.pid))  # the first thread serves
    count = last - first
    return {"steps": count / wall, "frames": frames / wall, "bytes": size / wall,
            "simulation_ms": 1e3 * sum(used.values()) / count, "server_ms": 1e3 * server / count}


def bench(command, scene, options):
    process = subprocess.Popen(
        [command, "view", scene, "--json", "--no-browser", "--alone", "--speed", "max", "--threads", str(options.threads)],
        stdout=subprocess.PIPE, text=True,
    )
    try:
        address = json.loads(process.stdout.readline())["address"]
        rounds = []
        for _ in range(options.rounds):
            turn = {"nobody": measure(process, address, options.steps, None)}
            for name, look in LOOKS.items():
                turn[name] = measure(process, address, options.steps, look)
            rounds.append(turn)
    finally:
        process.terminate()
        process.wait()
    median = lambda name, what: statistics.median(turn[name][what] for turn in rounds)
    slower = lambda name: statistics.median(1 - turn[name]["steps"] / turn["nobody"]["steps"] for turn in rounds)
    costs = lambda name: statistics.median(turn[name]["simulation_ms"] / turn["nobody"]["simulation_ms"] - 1 for turn in rounds)
    return {
        "scene": pathlib.Path(scene).stem,
        "steps_per_second": median("nobody", "steps"),
        "simulation_ms": median("nobody", "simulation_ms"),
        "looks": [
            {"look": name, "frames_per_second": median(name, "frames"), "bytes_per_second": median(name, "bytes"),
             "steps_per_second": median(name, "steps"), "slower": slower(name),
             "simulation_ms": median(name, "simulation_ms"), "costs": costs(name), "server_ms": median(name, "server_ms")}
            for name in LOOKS
        ],
        "rounds": rounds,
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command")
    parser.add_argument("result", type=pathlib.Path)
    parser.add_argument("scenes", nargs="+")
    parser.add_argument("--steps", type=int, default=100)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--threads", type=int, default=1)
    options = parser.parse_args()
    results = []
    for scene in options.scenes:
        results.append(bench(options.command, scene, options))
        row = results[-1]
        for look in row["looks"]:
            print(f"{row['scene']:12} {look['look']:11} {row['steps_per_second']:8.1f} steps/s alone, "
                  f"{look['steps_per_second']:8.1f} with a page ({100 * look['slower']:+.1f} % slower); on a core "
                  f"{row['simulation_ms']:.2f} ms a step, {look['simulation_ms']:.2f} with a page ({100 * look['costs']:+.1f} %), "
                  f"server {look['server_ms']:.2f}; "
                  f"{look['frames_per_second']:5.1f} frames/s, {look['bytes_per_second'] / 1e6:6.2f} MB/s", flush=True)
    options.result.write_text(json.dumps({"load": os.getloadavg(), "cores": os.cpu_count(), "threads": options.threads,
                                          "steps": options.steps, "results": results}, indent=1) + "\n")


if __name__ == "__main__":
    main()
