"""Programs that run beside Slicer: started, asked for their lines, cancelled."""

from __future__ import annotations

import queue
import subprocess
import threading
from collections.abc import Mapping, Sequence


class Process:
    """A program whose output is read by a thread, so that the caller never waits. Nothing of it uses a shell."""

    def __init__(self, arguments: Sequence[str], environment: Mapping[str, str] | None = None) -> None:
        """environment: of the program; in Slicer slicer.util.startupEnvironment(), None: that of this process.

        Raises OSError if the program cannot be started.
        """
        self._process = subprocess.Popen(list(arguments), stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                         stderr=subprocess.PIPE, env=None if environment is None else dict(environment),
                                         text=True, encoding="utf-8", errors="replace")
        self._lines: queue.Queue[str] = queue.Queue()
        self._output: list[str] = []
        self._readers = [threading.Thread(target=self._read_output, daemon=True),
                         threading.Thread(target=self._read_errors, daemon=True)]
        for reader in self._readers:
            reader.start()

    def _read_output(self) -> None:
        assert self._process.stdout is not None
        self._output.append(self._process.stdout.read())

    def _read_errors(self) -> None:
        assert self._process.stderr is not None
        for line in self._process.stderr:
            self._lines.put(line.rstrip("\n"))

    def lines(self) -> list[str]:
        """What it wrote to stderr since the last call."""
        found = []
        while True:
            try:
                found.append(self._lines.get_nowait())
            except queue.Empty:
                return found

    @property
    def done(self) -> bool:
        return self._process.poll() is not None and not any(reader.is_alive() for reader in self._readers)

    @property
    def code(self) -> int | None:
        """The exit code, once it is done."""
        return self._process.poll()

    @property
    def output(self) -> str:
        """All of stdout, once it is done."""
        return "".join(self._output)

    def cancel(self) -> None:
        """Asks it to end; `palpate run` then leaves a checkpoint."""
        if self._process.poll() is None:
            self._process.terminate()
