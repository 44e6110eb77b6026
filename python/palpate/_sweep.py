"""sweep(): many runs of a scene over values of its parameters."""

from __future__ import annotations

import hashlib
import inspect
import itertools
import json
import os
import pickle
import re
import sys
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from typing import TYPE_CHECKING, Any, NamedTuple

from . import _arrays, _core
from ._error import Error, NotConverged, WrongArgument, shown as shown_value
from ._pool import Runner, RunLost, dask_runner, local_runner
from ._progress import bar, needed
from ._scene import scene_dict, scene_of
from ._settings import scene_text, threads_or_default
from ._simulation import Simulation

if TYPE_CHECKING:
    import pandas

Row = dict[str, Any]

COLUMNS = ("status", "error", "traceback", "seconds", "steps", "time", "at_rest", "contacts", "deepest", "steps_not_converged",
           "inverted_tets", "most_inverted_tets", "kinetic_energy", "elastic_energy", "state_hash", "warnings")
"""Names of columns that every sweep may have: parameters, outcomes and measures must have others."""


class Job(NamedTuple):
    """A run, as it is sent to a worker."""

    scene: str
    apply: Callable[[dict[str, Any], Row], Any] | None
    measure: Callable[[Simulation], Mapping[str, Any]] | None
    values: Row
    steps: int | None
    until_rest: bool
    threads: int


def set_value(scene: dict[str, Any], path: str, value: Any) -> None:
    """Sets a value of a scene by its path, as errors name them: "bodies[2].material.young_modulus".

    A body may be named by its name: "bodies.liver.material.young_modulus". The last key may be absent in the scene.
    """
    place: Any = scene
    keys = re.findall(r"[^.\[\]]+", path)
    for depth, key in enumerate(keys):
        last = depth == len(keys) - 1
        if isinstance(place, list):
            place, key = place, _place_in_list(place, key, path)
        elif not isinstance(place, dict) or not (last or key in place):
            raise Error("sweep", path, f"no key '{key}'", "a path of keys of the scene")
        if last:
            place[key] = value
        else:
            place = place[key]


def _place_in_list(values: list[Any], key: str, path: str) -> int:
    if key.isdigit() and int(key) < len(values):
        return int(key)
    for number, value in enumerate(values):
        if isinstance(value, dict) and value.get("name") == key:
            return number
    raise Error("sweep", path, f"no element with the number or name '{key}'", f"a number below {len(values)}, or the name of an element")


def run_job(job: Job) -> Row:
    """Makes a run; returns the content of its row. A failure of the run also gives a row."""
    start = time.perf_counter()
    row: Row = {"status": "done", "error": "", "traceback": ""}
    try:
        row.update(_run(job))
    except Exception as error:  # whatever a run or the caller's functions raise must not end the study
        row.update(status="failed", error=_told(error),
                   traceback="" if isinstance(error, Error) else traceback.format_exc())
    row["seconds"] = time.perf_counter() - start
    return row


def _told(error: Exception) -> str:
    """An error in one line; for the caller's functions with the line where it was raised."""
    if isinstance(error, Error):
        return str(error)
    here = os.path.dirname(__file__)
    frames = [frame for frame in traceback.extract_tb(error.__traceback__) if not frame.filename.startswith(here)]
    place = f" (line {frames[-1].lineno} of {frames[-1].filename}, in {frames[-1].name})" if frames else ""
    return f"{type(error).__name__}: {error}{place}"


def _run(job: Job) -> Row:
    scene = json.loads(job.scene)
    if job.apply is None:
        for path, value in job.values.items():
            set_value(scene, path, value)
    else:
        job.apply(scene, dict(job.values))
    simulation = Simulation(scene, threads=job.threads)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", NotConverged)  # the row has steps_not_converged
        simulation.run(job.steps, until_rest=job.until_rest)
    metrics = simulation.metrics
    row: Row = {
        "steps": metrics.step,
        "time": metrics.time,
        "at_rest": simulation.at_rest,
        "contacts": metrics.detection.contacts,
        "deepest": metrics.deepest,
        "steps_not_converged": simulation.steps_not_converged,
        "inverted_tets": metrics.inverted_tets,
        "most_inverted_tets": simulation.most_inverted_tets,
        "kinetic_energy": metrics.kinetic_energy,
        "elastic_energy": metrics.elastic_energy,
        "state_hash": simulation.state_hash,
    }
    _add(row, _outcome_columns(simulation), "outcomes", [*COLUMNS, *job.values])
    if simulation.stage is not None:
        row["warnings"] = "; ".join(simulation.stage_warnings)
    if job.measure is not None:
        _add(row, _measured(job.measure, simulation), _place_of("measure", job.measure), [*COLUMNS, *job.values, *row])
    return row


def _add(row: Row, columns: Row, source: str, names: Sequence[str]) -> None:
    """Adds columns to a row; raises Error if one has one of the names that are in use."""
    for name in columns:
        if name in names:
            raise Error("sweep", source, f"the name '{name}', which another column has", "another name")
    row.update(columns)


def _measured(measure: Callable[[Simulation], Any], simulation: Simulation) -> Row:
    """What a measure returns, checked: a mapping whose values can be sent back from the process of the run."""
    values = measure(simulation)
    place = _place_of("measure", measure)
    if not isinstance(values, Mapping) and not (hasattr(values, "items") and hasattr(values, "keys")):
        raise Error("sweep", place, f"the result {shown_value(values)}", "a mapping of names to values")
    row = _plain_row(values)
    for name, value in row.items():
        try:
            pickle.loads(pickle.dumps(value))
        except Exception:  # whatever the methods of the value raise
            raise Error("sweep", place, f"{shown_value(value)} for '{name}', which cannot be sent to another process",
                        "numbers, texts, truth values, or lists of them") from None
    return row


def _place_of(name: str, function: Callable[..., Any]) -> str:
    """A function of the caller in an error: which argument it is, and where it is defined."""
    code = getattr(function, "__code__", None)
    if code is None:
        return name
    return f"{name} {getattr(function, '__name__', 'function')} (line {code.co_firstlineno} of {code.co_filename})"


def _outcome_columns(simulation: Simulation) -> Row:
    """Outcomes at the end by their names, at the ends of stages as "STAGE.NAME"; nothing for a scene without."""
    row: Row = {name: outcome.value for name, outcome in simulation.outcomes().items()}
    for stage, outcomes in simulation.stage_outcomes.items():
        row.update({f"{stage}.{name}": outcome.value for name, outcome in outcomes.items()})
    return row


def _plain_row(values: Mapping[str, Any]) -> Row:
    """Converts a row to storable values: numbers, text, truth values and lists of them."""
    return {str(name): value.tolist() if hasattr(value, "tolist") else value for name, value in values.items()}


class Store:
    """Rows of finished runs in a folder, one JSON file each. They make a study resumable."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self._folder = os.path.join(os.fspath(folder), "runs")
        try:
            os.makedirs(self._folder, exist_ok=True)
        except OSError as error:
            raise Error(self._folder, "", f"'{error.strerror}'", "a folder that can be written") from None

    def _file(self, key: str) -> str:
        return os.path.join(self._folder, f"{key}.json")

    def read(self, key: str) -> Row | None:
        """The row of a run, or None, also for a damaged file."""
        try:
            with open(self._file(key), encoding="utf-8") as stream:
                row = json.load(stream)
        except (OSError, ValueError):
            return None
        return row if isinstance(row, dict) else None

    def write(self, key: str, row: Row) -> None:
        """Keeps a row: written under a temporary name and renamed."""
        beside = f"{self._file(key)}.{os.getpid()}.part"
        with open(beside, "w", encoding="utf-8") as stream:
            json.dump(row, stream, indent=1, default=str)
        os.replace(beside, self._file(key))


def _digest_of(file: str | os.PathLike[str]) -> str:
    try:
        with open(file, "rb") as stream:
            return (hashlib.file_digest(stream, "sha256").hexdigest()
                    if hasattr(hashlib, "file_digest") else hashlib.sha256(stream.read()).hexdigest())
    except OSError as error:
        raise Error(os.fspath(file), "", f"'{error.strerror}'", "a mesh file") from None


def _digest_of_meshes(scene: Mapping[str, Any]) -> list[str]:
    """Digests of the mesh files of a scene, so that a changed mesh makes other runs."""
    return [_digest_of(body["mesh"]) for body in scene["bodies"] if "mesh" in body]


def _digest_of_values(values: Row) -> list[str]:
    """Digests of values that are files, such as the mesh of a plan, so that their content is part of the key."""
    return [_digest_of(value) for value in values.values() if isinstance(value, str) and os.path.isfile(value)]


def _name_of(function: Callable[..., Any] | None) -> str:
    """The part of a run's key for a function: its name and its code."""
    if function is None:
        return ""
    code = getattr(function, "__code__", None)
    constants = "" if code is None else repr((code.co_code, code.co_names, [c for c in code.co_consts
                                                                           if not hasattr(c, "co_code")]))
    return f"{getattr(function, '__qualname__', repr(type(function)))}:{constants}"


def _samples(parameters: Any) -> list[Row]:
    """The values of each run: all combinations of a mapping of lists, or the rows of a table or list of mappings."""
    if hasattr(parameters, "to_dict") and hasattr(parameters, "columns"):
        return [_plain_row(row) for row in parameters.to_dict(orient="records")]
    if isinstance(parameters, Mapping):
        lists = {}
        for name, values in parameters.items():
            if isinstance(values, (str, bytes)) or not isinstance(values, Iterable):
                raise Error("sweep", f"parameters[{name!r}]", f"{values!r}", "a list of values")
            lists[str(name)] = list(values.tolist() if hasattr(values, "tolist") else values)
        return [dict(zip(lists, values)) for values in itertools.product(*lists.values())]
    rows = list(parameters) if isinstance(parameters, Iterable) else [parameters]
    if not all(isinstance(row, Mapping) for row in rows):
        found = "rows that are no mappings" if isinstance(parameters, Iterable) else shown_value(parameters)
        raise Error("sweep", "parameters", found, "a mapping of lists, mappings, or a DataFrame")
    return [_plain_row(row) for row in rows]


def _key(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:24]


def _finished(runner: Runner, jobs: Mapping[str, Job]) -> Iterator[tuple[str, Row]]:
    """Rows as they become ready; a run whose workers died repeatedly counts as failed."""
    waiting = list(jobs.items())[::-1]
    running: dict[Future[Row], str] = {}
    while waiting or running:
        while waiting and len(running) < runner.width:
            key, job = waiting.pop()
            running[runner.submit(run_job, job)] = key
        for future in wait(running, return_when=FIRST_COMPLETED).done:
            key = running.pop(future)
            try:
                yield key, future.result()
            except RunLost as lost:
                if lost.again:
                    waiting.append((key, jobs[key]))
                else:
                    yield key, {"status": "failed", "error": str(lost), "traceback": "", "seconds": 0.0}


def sweep_rows(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    parameters: Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]] | pandas.DataFrame,
    *,
    apply: Callable[[dict[str, Any], Row], Any] | None = None,
    measure: Callable[[Simulation], Mapping[str, Any]] | None = None,
    steps: int | None = None,
    until_rest: bool = False,
    folder: str | os.PathLike[str] | None = None,
    retry_failed: bool = False,
    workers: int | None = None,
    threads: int = 1,
    client: Any = None,
    progress: bool = False,
) -> list[Row]:
    """Like sweep(), with a list of mappings instead of a DataFrame; needs no pandas."""
    _check_function("apply", apply, 2, "a function of the scene and the values of a run")
    _check_function("measure", measure, 1, "a function of the Simulation")
    base = scene_dict(scene_of(scene))
    samples = _samples(parameters)
    for name in dict.fromkeys(name for values in samples for name in values):
        if name in COLUMNS:
            raise Error("sweep", f"parameters[{name!r}]", "the name of another column", "another name")
    steps = None if steps is None else _arrays.integer(steps, "steps")
    threads_or_default(threads)
    text = scene_text(base, "scene")
    same = json.dumps([_core.version, text, _digest_of_meshes(base), steps, until_rest, _name_of(apply),
                       _name_of(measure)])
    store = None if folder is None else Store(folder)
    keys = [_key(same + scene_text(values, "parameters") + "".join(_digest_of_values(values))) for values in samples]
    jobs = {key: Job(text, apply, measure, values, steps, until_rest, threads) for key, values in zip(keys, samples)}
    rows: dict[str, Row] = {}
    for key in jobs if store is not None else ():
        row = store.read(key) if store is not None else None
        if row is not None and not (retry_failed and row["status"] == "failed"):
            rows[key] = row
    left = {key: job for key, job in jobs.items() if key not in rows}
    runner = dask_runner(client) if client is not None else local_runner(workers, len(left))
    with runner, bar(progress, len(jobs), "run", len(rows)) as shown:
        for key, row in _finished(runner, left):
            rows[key] = row
            if store is not None:
                store.write(key, row)
            shown.update()
    _warn_of_failures([rows[key] for key in keys])
    return [{**values, **rows[key]} for key, values in zip(keys, samples)]


def _check_function(name: str, function: Any, arguments: int, expected: str) -> None:
    """Raises Error if an argument is neither None nor a function that can be called with so many arguments."""
    if function is None:
        return
    if not callable(function):
        raise WrongArgument("sweep", name, shown_value(function), f"{expected}, or None")
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # functions of C may have none
        return
    try:
        signature.bind(*[None] * arguments)
    except TypeError:
        raise WrongArgument("sweep", _place_of(name, function), f"the arguments {signature}", expected) from None


def _warn_of_failures(rows: Sequence[Row]) -> None:
    """One warning where runs failed: their rows are without most columns, so that a study would end in a KeyError."""
    failed = [row for row in rows if row["status"] == "failed"]
    if failed:
        first = " ".join(failed[0]["error"].split())
        warnings.warn(f"sweep: {len(failed)} of {len(rows)} runs failed, the first by: {first}", stacklevel=_outside())


def _outside() -> int:
    """The stack level of the caller of this package, for warnings of the function that calls this one."""
    here = os.path.dirname(__file__)
    frame, level = sys._getframe(1), 1
    while frame.f_back is not None and frame.f_code.co_filename.startswith(here):
        frame, level = frame.f_back, level + 1
    return level


def sweep(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    parameters: Mapping[str, Sequence[Any]] | Iterable[Mapping[str, Any]] | pandas.DataFrame,
    *,
    apply: Callable[[dict[str, Any], Row], Any] | None = None,
    measure: Callable[[Simulation], Mapping[str, Any]] | None = None,
    steps: int | None = None,
    until_rest: bool = False,
    folder: str | os.PathLike[str] | None = None,
    retry_failed: bool = False,
    workers: int | None = None,
    threads: int = 1,
    client: Any = None,
    progress: bool = False,
) -> pandas.DataFrame:
    """Runs a scene for many values of its parameters; returns a DataFrame with a row for each run, failures too.

    scene: a file or mapping, as for Simulation.
    parameters: a mapping of lists (all combinations are run), or a run each: a list of mappings, or a DataFrame. Names
        are paths of scene keys, "bodies[1].material.young_modulus" or "bodies.liver.material.young_modulus".
    apply: a function (scene mapping, values) that changes the mapping instead; names are then free.
    measure: a function of the Simulation at the end of a run that returns a mapping; its items become columns, whose
        names must not be those of other columns. Its values: numbers, texts, truth values, arrays, or lists of them.
    steps, until_rest: as for Simulation.run().
    folder: keeps finished runs; a call with the same scene, values and functions reads them from there, so that an
    interrupted study continues. None keeps nothing.
    retry_failed: whether kept runs that failed are made again.
    workers: processes on this machine, None for one a core. threads: of each run.
    client: a dask.distributed Client instead of them; its workers need palpate and must see the mesh files.
    progress: shows a bar of tqdm.

    Columns: the parameters; status ("done" or "failed"), error (a line) and traceback (of a function of yours that raised); steps, time, at_rest, contacts, deepest, steps_not_converged,
    inverted_tets (at the end), most_inverted_tets, energies, state_hash and seconds; the scene's outcomes at the end (NAME) and at the ends of stages (STAGE.NAME), and warnings of stages; what `measure` returned. `apply` and `measure` are sent to other processes, by
    cloudpickle where it is installed: functions of a notebook, lambdas and local functions will do. A run whose worker process dies is made again, three times at most.
    Ctrl-C ends the study; what is finished is in `folder`. Raises Error if the scene is bad as it is. Warns, in a
    line, where runs failed: how many, and the first error.
    """
    try:
        import pandas
    except ImportError:
        raise needed("pandas", "sweep (sweep_rows does without)", "study") from None
    return pandas.DataFrame(sweep_rows(
        scene, parameters, apply=apply, measure=measure, steps=steps, until_rest=until_rest, folder=folder,
        retry_failed=retry_failed, workers=workers, threads=threads, client=client, progress=progress))
