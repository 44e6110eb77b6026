"""Execution of the runs of a study: in processes of this machine, or by the workers of a Dask cluster."""

from __future__ import annotations

import contextlib
import multiprocessing
import os
import pickle
import signal
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import Future, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from types import TracebackType
from typing import Any, Protocol

from . import _arrays
from ._error import Error, shown

_TRIES = 3


class RunLost(Exception):
    """A worker died during a run. again: whether the run should be made once more."""

    def __init__(self, text: str, again: bool) -> None:
        super().__init__(text)
        self.again = again


class Runner(Protocol):
    """Makes runs in other processes."""

    width: int
    """Number of runs at a time."""

    def submit(self, function: Callable[[Any], Any], job: Any) -> Future[Any]: ...
    def __enter__(self) -> Any: ...
    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> Any: ...


def _end_at_once_on_interrupt() -> None:
    """For workers: Ctrl-C in a terminal reaches all processes, and only the main one reports it."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def _call_pickled(call: bytes) -> Any:
    """In a worker: the call that pickled_call() packed."""
    function, job = pickle.loads(call)
    return function(job)


def pickled_call(function: Callable[[Any], Any], job: Any) -> bytes:
    """A call as bytes; with cloudpickle, functions of notebooks and lambdas are sent as code. Raises Error if the
    job cannot be sent to another process.
    """
    try:
        import cloudpickle
    except ImportError:
        _refuse_functions_of_notebooks(job)
        dumps: Callable[[Any], bytes] = pickle.dumps
    else:
        dumps = cloudpickle.dumps
    try:
        return dumps((function, job))
    except Exception as error:  # whatever the methods of a value raise
        expected = ("a function that uses no such value from outside of it" if dumps is not pickle.dumps else
                    "functions of a module, or the package cloudpickle: pip install 'palpate[study]'")
        raise Error("sweep", _not_picklable(dumps, job), f"a function that cannot be sent to other processes ({error})",
                    expected) from None


def _not_picklable(dumps: Callable[[Any], bytes], job: Any) -> str:
    """The names of the fields of a job that cannot be pickled."""
    names = []
    for name in getattr(job, "_fields", ()):
        try:
            dumps(getattr(job, name))
        except Exception:
            names.append(name)
    return ", ".join(names)


@contextlib.contextmanager
def _unknown_main() -> Iterator[None]:
    """Keeps workers from running the calling program again at their start, as 'spawn' does: its functions are sent as code."""
    main = sys.modules["__main__"]
    kept: dict[str, Any] = {name: main.__dict__.pop(name) for name in ("__file__", "__spec__") if name in main.__dict__}
    main.__spec__ = None
    try:
        yield
    finally:
        main.__dict__.update(kept)


def _has_cloudpickle() -> bool:
    try:
        import cloudpickle  # noqa: F401
    except ImportError:
        return False
    return True


def _starts_alone() -> contextlib.AbstractContextManager[None]:
    """How workers start: without the program if cloudpickle sends all functions, otherwise with it, because they are sent by name."""
    return _unknown_main() if _has_cloudpickle() else contextlib.nullcontext()


def _refuse_functions_of_notebooks(job: Any) -> None:
    """Raises Error for functions of notebooks without cloudpickle: they would go by name, and notebooks cannot be imported."""
    if os.path.isfile(getattr(sys.modules["__main__"], "__file__", "")):
        return
    for value in job if isinstance(job, tuple) else ():
        if callable(value) and getattr(value, "__module__", "") == "__main__":
            raise Error("sweep", getattr(value, "__qualname__", "function"), "a function of a notebook, without the package cloudpickle",
                        "the package cloudpickle, which can send it to other processes: pip install 'palpate[study]'")


class LocalRunner:
    """Processes of this machine. They are spawned, not forked: a fork would lose the threads of the library."""

    def __init__(self, workers: int) -> None:
        self.width = workers
        self._pool: ProcessPoolExecutor | None = None
        self._tries: dict[int, int] = {}

    def submit(self, function: Callable[[Any], Any], job: Any) -> Future[Any]:
        """A future of function(job); RunLost where the process died."""
        call = pickled_call(function, job)
        result: Future[Any] = Future()
        result.set_running_or_notify_cancel()
        with _starts_alone():
            try:
                running = self._workers().submit(_call_pickled, call)
            except BrokenProcessPool:
                self._end()
                running = self._workers().submit(_call_pickled, call)
        running.add_done_callback(lambda done: self._pass_on(done, result, id(job)))
        return result

    def _workers(self) -> ProcessPoolExecutor:
        if self._pool is None:
            self._pool = ProcessPoolExecutor(self.width, multiprocessing.get_context("spawn"),
                                             initializer=_end_at_once_on_interrupt)
        return self._pool

    def _pass_on(self, done: Future[Any], result: Future[Any], job: int) -> None:
        error = done.exception() if not done.cancelled() else None
        if isinstance(error, BrokenProcessPool):
            self._tries[job] = self._tries.get(job, 0) + 1
            text = f"a worker process died in each of {_TRIES} tries"
            result.set_exception(RunLost(text, self._tries[job] < _TRIES))
        elif error is not None:
            result.set_exception(error)
        elif not done.cancelled():
            result.set_result(done.result())

    def _end(self) -> None:
        if self._pool is not None:
            self._pool.shutdown(wait=False, cancel_futures=True)
        self._pool = None

    def __enter__(self) -> LocalRunner:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        pool, self._pool = self._pool, None
        if pool is None:
            return
        processes = list((getattr(pool, "_processes", None) or {}).values())
        pool.shutdown(wait=kind is None, cancel_futures=True)
        for process in processes if kind is not None else ():
            process.terminate()  # an interrupted study does not wait for its runs


class DaskRunner:
    """The workers of a Dask cluster. Dask repeats the runs of a dead worker on other workers."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._futures: list[Any] = []
        threads = sum(client.nthreads().values())
        self.width = 4 * max(1, threads)  # so that no worker waits for the next run to be sent

    def submit(self, function: Callable[[Any], Any], job: Any) -> Future[Any]:
        """A future of function(job); RunLost where its workers died again and again."""
        from distributed.scheduler import KilledWorker

        result: Future[Any] = Future()
        result.set_running_or_notify_cancel()

        def pass_on(done: Any) -> None:
            self._futures.remove(done)
            if done.status == "finished":
                result.set_result(done.result())
                return
            error = done.exception() if done.status == "error" else None
            if isinstance(error, KilledWorker):
                result.set_exception(RunLost("its workers died again and again", False))
            else:
                result.set_exception(error or RunLost("the cluster gave it up", True))

        future = self._client.submit(_call_pickled, pickled_call(function, job), pure=False)
        self._futures.append(future)
        future.add_done_callback(pass_on)
        return result

    def __enter__(self) -> DaskRunner:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None,
                 trace: TracebackType | None) -> None:
        if kind is not None:
            self._client.cancel(list(self._futures))


def local_runner(workers: int | None, runs: int) -> Runner:
    """Processes of this machine: `workers`, or one per core, but at most one per run."""
    if workers is not None and _arrays.integer(workers, "workers") < 1:
        raise Error("sweep", "workers", str(workers), "1 or more")
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    return LocalRunner(max(1, min(workers or cores, runs)))


def dask_runner(client: Any) -> Runner:
    """The workers of a client of dask.distributed."""
    if not hasattr(client, "submit") or not hasattr(client, "nthreads"):
        raise Error("sweep", "client", shown(client), "a dask.distributed.Client")
    return DaskRunner(client)
