# SPDX-License-Identifier: Apache-2.0
"""Starts a PostgreSQL database and nodes of a cluster for benchmarks, and measures processes."""

import json
import os
import shutil
import signal
import socket
import subprocess
import threading
import time
from pathlib import Path

import harness

PATIENCE = 120
ACCOUNT = "postgres"
TICKS = os.sysconf("SC_CLK_TCK")
CONNECTIONS = 500


def free_port():
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]


class Database:
    """A PostgreSQL server in a folder of its own. It does not run as root."""

    def __init__(self, folder):
        self.folder = folder / "database"
        self.folder.mkdir()
        self.port = free_port()
        self.account = []
        if os.geteuid() == 0:
            shutil.chown(self.folder, ACCOUNT)
            folder.chmod(0o755)
            self.account = ["setpriv", f"--reuid={ACCOUNT}", f"--regid={ACCOUNT}", "--clear-groups"]
        data = self.folder / "data"
        self.call(
            "initdb",
            f"--pgdata={data}",
            "--username=reve",
            "--auth=trust",
            "--no-locale",
            "--encoding=UTF8",
        )
        with (self.folder / "log").open("w") as log:
            self.process = subprocess.Popen(
                [
                    *self.account,
                    self.program("postgres"),
                    "-D",
                    data,
                    "-p",
                    str(self.port),
                    "-c",
                    "listen_addresses=127.0.0.1",
                    "-c",
                    f"unix_socket_directories={self.folder}",
                    "-c",
                    f"max_connections={CONNECTIONS}",
                ],
                stdout=log,
                stderr=log,
            )
        end = time.monotonic() + PATIENCE
        while self.query("postgres", "SELECT 1", check=False).returncode != 0:
            if time.monotonic() > end:
                harness.fail(f"PostgreSQL did not start: {(self.folder / 'log').read_text()}")
            time.sleep(0.1)
        self.query("postgres", "CREATE DATABASE worlds")
        self.url = f"postgresql://reve@127.0.0.1:{self.port}/worlds"

    @staticmethod
    def program(name):
        found = sorted(Path("/usr/lib/postgresql").glob(f"*/bin/{name}"))
        if found:
            return found[-1]
        harness.need(name, "postgresql")
        return name

    def call(self, name, *arguments):
        done = subprocess.run(
            [*self.account, self.program(name), *arguments],
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            cwd="/",
        )
        if done.returncode != 0:
            harness.fail(f"{name} failed: {done.stdout}")

    def query(self, database, sql, check=True):
        command = [
            self.program("psql"),
            "-h",
            "127.0.0.1",
            "-p",
            str(self.port),
            "-U",
            "reve",
            "-d",
            database,
            "-At",
            "-c",
            sql,
        ]
        done = subprocess.run(command, text=True, capture_output=True)
        if check and done.returncode != 0:
            harness.fail(f"psql failed: {done.stderr}")
        return done

    def size(self):
        return int(self.query("worlds", "SELECT pg_database_size('worlds')").stdout)

    def close(self):
        self.process.send_signal(signal.SIGINT)
        self.process.wait()


class Node:
    def __init__(self, database, seed, log, *options):
        command = [
            harness.ROOT / "reve",
            "serve",
            "--cluster",
            "bench",
            "--port",
            "0",
            "--json",
            "--store",
            database.url,
            *options,
        ]
        if seed:
            command += ["--seed", seed]
        self.log = log.open("w")
        self.process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=self.log,
            text=True,
            env=os.environ | {"REVE_HEAP": "1g"},
        )
        self.events = []
        self.changed = threading.Condition()
        threading.Thread(target=self.read, daemon=True).start()
        starts = self.wait(lambda event: event.get("status") == "starts")
        self.address, self.port = starts["node"], starts["agentPort"]

    def read(self):
        for line in self.process.stdout:
            with self.changed:
                self.events.append(json.loads(line))
                self.changed.notify_all()

    def wait(self, wanted):
        with self.changed:
            found = self.changed.wait_for(lambda: next(filter(wanted, self.events), None), PATIENCE)
        if not found:
            harness.fail(
                f"a node did not do what was expected; its messages are in {self.log.name}"
            )
        return found

    def close(self):
        self.process.terminate()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        self.log.close()


def tree(root):
    """Returns the ids of a process and of its descendants."""
    parents = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = stat.read_text().rpartition(")")[2].split()
        except OSError:
            continue
        parents.setdefault(int(fields[1]), []).append(int(stat.parent.name))
    found = [root]
    for each in found:
        found += parents.get(each, [])
    return found


def memory(roots):
    """Returns the memory of processes and their descendants [bytes]; shared pages count once."""
    total = 0
    for root in roots:
        for each in tree(root):
            try:
                for line in Path(f"/proc/{each}/smaps_rollup").read_text().splitlines():
                    if line.startswith("Pss:"):
                        total += int(line.split()[1]) * 1024
            except OSError:
                pass  # the process has ended
    return total


def processor_seconds(roots):
    total = 0
    for root in roots:
        for each in tree(root):
            try:
                fields = Path(f"/proc/{each}/stat").read_text().rpartition(")")[2].split()
            except OSError:
                continue
            total += (int(fields[11]) + int(fields[12])) / TICKS
    return total


def busy_seconds():
    """Returns the processor time that all programs of the machine have used."""
    fields = [int(field) for field in Path("/proc/stat").read_text().splitlines()[0].split()[1:9]]
    return (sum(fields) - fields[3] - fields[4]) / TICKS


def usage(roots, seconds):
    """Returns the processors that the processes, and that other programs, keep busy."""
    before, all_before, start = processor_seconds(roots), busy_seconds(), time.monotonic()
    time.sleep(seconds)
    length = time.monotonic() - start
    own = (processor_seconds(roots) - before) / length
    return own, max(0, (busy_seconds() - all_before) / length - own)
