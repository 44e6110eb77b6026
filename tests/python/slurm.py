"""A SLURM of one machine for the duration of a test: controller and node in a folder, on separate ports."""

from __future__ import annotations

import os
import pathlib
import shutil
import socket
import subprocess
import time

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")


def is_here() -> bool:
    """Whether Debian's slurmctld, slurmd and slurm-client are installed and may be run."""
    return os.geteuid() == 0 and all(shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin") for name in PROGRAMS)


def _free_ports(count: int) -> list[int]:
    sockets = [socket.socket() for _ in range(count)]
    for one in sockets:
        one.bind(("", 0))
    ports = [one.getsockname()[1] for one in sockets]
    for one in sockets:
        one.close()
    return ports


class Slurm:
    """Sets SLURM_CONF to a cluster of one node with this number of processors. Authentication: none, local only."""

    def __init__(self, folder: pathlib.Path, processors: int) -> None:
        self._folder = folder
        host = socket.gethostname().split(".")[0]
        controller, node = _free_ports(2)
        for name in ("state", "spool"):
            (folder / name).mkdir()
        self._conf = folder / "slurm.conf"
        self._conf.write_text(f"""ClusterName=palpate
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
AuthType=auth/none
CredType=cred/none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_res
SelectTypeParameters=CR_CPU
MpiDefault=none
ReturnToService=2
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
JobAcctGatherType=jobacct_gather/none
NodeName={host} NodeAddr=127.0.0.1 CPUs={processors} RealMemory=2000 State=UNKNOWN
PartitionName=all Nodes={host} Default=YES MaxTime=INFINITE State=UP
""")
        self._host = host
        self._daemons: list[subprocess.Popen[bytes]] = []

    def __enter__(self) -> Slurm:
        self._before = os.environ.get("SLURM_CONF")
        os.environ["SLURM_CONF"] = str(self._conf)
        environment = dict(os.environ, PATH=f"{os.environ['PATH']}:/usr/sbin")
        for command in (["slurmctld", "-D"], ["slurmd", "-D", "-N", self._host]):
            self._daemons.append(subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))
        deadline = time.monotonic() + 60
        while time.monotonic() < deadline:
            found = subprocess.run(["sinfo", "-h", "-o", "%t"], capture_output=True, text=True)
            if found.stdout.strip() == "idle":
                return self
            time.sleep(0.5)
        self.__exit__()
        logs = [(self._folder / name).read_text()[-2000:] for name in ("slurmctld.log", "slurmd.log")
                if (self._folder / name).exists()]
        raise RuntimeError("SLURM does not start:\n" + "\n".join(logs))

    @staticmethod
    def _jobs() -> str:
        return subprocess.run(["squeue", "-h"], capture_output=True, text=True).stdout.strip()

    def __exit__(self, *_: object) -> None:
        deadline = time.monotonic() + 20
        while time.monotonic() < deadline and self._jobs():  # a job outlives the daemons
            subprocess.run(["scancel", "--me"], capture_output=True)
            time.sleep(0.5)
        for daemon in reversed(self._daemons):
            daemon.terminate()
        for daemon in self._daemons:
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
        if self._before is None:
            del os.environ["SLURM_CONF"]
        else:
            os.environ["SLURM_CONF"] = self._before
