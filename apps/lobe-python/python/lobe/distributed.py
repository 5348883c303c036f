"""Bakes on many machines, by Dask: `bake` here, or `python -m lobe.distributed SCENE --scheduler ADDRESS -o baked.glb`.

A bake is cut into shards, each a task. Dask gives them to workers, to others if a worker dies, and to those that join
late; the scene is sent to each worker once. Shards that come back are kept in a folder beside the output: a bake whose
client or scheduler died goes on from there. They are put together to the bytes that one machine alone writes. Needs
`pip install distributed filelock`.

One process with one thread a machine is right, and `bake` starts it without a client: a shard computes on all
processors by itself, and each process has a copy of the scene. `dask worker tcp://HOST:PORT --nthreads 1
--memory-limit 1.0` is such a worker; without the second option Dask divides the machine's memory by its processors.

Other work needs Dask alone, such as the nine colors of many skies:

    lights = client.gather(client.map(lambda path: lobe.EnvMap.load(path).project(3), paths, retries=2))
"""

from __future__ import annotations

import argparse
import asyncio
import sys
import uuid
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from dataclasses import MISSING, fields
from typing import TYPE_CHECKING, Any, NoReturn

from . import __version__
from ._bake import BakeOptions, BakeReport
from ._engine import RETRIES, SHARDS_EACH, Engine, Work, bake_on
from ._scene import Path, Scene
from ._tasks import Refused, bake_shard, one_line, version

if TYPE_CHECKING:
    from distributed import Client

__all__ = ["bake", "main"]


def bake(
    scene: Path | Scene,
    output: Path,
    options: BakeOptions | None = None,
    *,
    client: Client | None = None,
    shards: int | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> BakeReport:
    """Bakes on the workers of a Dask client, and writes the bytes of `lobe.bake`.

    Without a client a process of this machine is started that computes on all processors; `lobe.bake` does the same
    work without one. A .glb, .vrm or .ply is sent to the workers; other scenes they read under the same path, as on a
    file system that they share. There are 64 shards for each thread of the workers, unless `shards` says otherwise.
    `progress(done, shards)` is called for each shard.

    A worker whose system refuses something, such as one with a full disk, gets no more shards while there is another,
    and a warning names it; where none is left an error says what to do. The same holds for a worker without this
    version of Lobe. Where there is no worker at all, a line on the standard error says that one is waited for.

    Shards that were done stay in the folder `OUTPUT.shards` until all are there; the same bake takes them up, with as
    many shards as before. While one bake is at work another into the same output is refused.
    """
    return bake_on(lambda work: _connected(client, work), scene, output, options, shards, progress)


class _Gone(Exception):
    """The scheduler does not answer any more."""


@contextmanager
def _asked() -> Iterator[None]:
    """Around what only asks the scheduler. Errors of tasks and of callers are raised elsewhere."""
    from distributed import client

    # Later versions have it.
    closed = getattr(client, "ClosedClientError", OSError)
    try:
        yield
    except (OSError, closed, CancelledError, asyncio.TimeoutError):
        raise _Gone from None


@contextmanager
def _connected(client: Client | None, work: Work) -> Iterator[Engine]:
    """The workers of the client, or of a process on this machine that ends with the bake."""
    from distributed import KilledWorker

    try:
        with _own() if client is None else nullcontext(client) as given:
            workers = Workers(given, work)
            try:
                yield workers
            finally:
                workers.stop()
    except _Gone:
        raise RuntimeError(work.ended_by("the scheduler is gone; start one")) from None
    except KilledWorker as error:
        remedy = "Give workers more memory, or ask for more shards"
        raise RuntimeError(work.ended_by(f"{one_line(error)} {remedy}")) from None


QUIET = """
import logging, signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
logging.getLogger("distributed.worker.state_machine").setLevel(logging.ERROR)
"""
"""What a process that is this program's own does first. Ctrl-C, which a terminal sends to both, is for the program
alone, and a task that was stopped is no news."""


def _own() -> AbstractContextManager[Client]:
    from distributed import Client, LocalCluster

    # One task at a time: it has as many threads as there are processors. Dask's page has any port that is free.
    page = "127.0.0.1:0"
    cluster = LocalCluster(n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=page, preload=[QUIET])
    own: AbstractContextManager[Client] = Client(cluster, set_as_default=False)
    return own


class Workers(Engine):
    """The workers of a Dask client."""

    def __init__(self, client: Client, work: Work) -> None:
        from distributed import as_completed

        super().__init__(work)
        self._client, self._running = client, dict[Any, int]()
        self._ended = as_completed([], loop=client.loop)
        if not self.places():
            address = client.scheduler.address if client.scheduler else "the scheduler"
            start = f"dask worker {address} --nthreads 1"
            print(f"{address}: waiting for a worker; this starts one: {start}", file=sys.stderr, flush=True)
        with _asked():
            # Nothing can be sent to none.
            client.wait_for_workers(1)
            scene = work.whole_scene()
            # None if workers read it by themselves.
            self._scene: Any = None if scene is None else client.scatter(scene, broadcast=True, hash=True)

    def places(self) -> dict[str, int]:
        with _asked():
            # In Dask's types it may be a coroutine.
            threads: Any = self._client.nthreads()
            return dict(threads)

    def unfit(self) -> list[Refused]:
        with _asked():
            # What a worker without the package raises is returned, too.
            versions: Any = self._client.run(version, on_error="return")
        others = {worker: found for worker, found in versions.items() if found != __version__}
        has = {at: f"has lobe {found}" if isinstance(found, str) else one_line(found) for at, found in others.items()}
        return [Refused(worker, worker, f"{has[worker]}; install lobe {__version__} there") for worker in others]

    def start(self, number: int, count: int) -> None:
        # Should those that are left die, any other will do.
        left = (list(self.left()) or None) if self.refused else None
        work = self.work
        # A call that was stopped may still be cancelling tasks of these names.
        key = f"lobe-{work.identity}-{number}-of-{count}-{uuid.uuid4().hex}"
        with _asked():
            future = self._client.submit(
                bake_shard, self._scene, work.job, number, count,
                key=key, pure=False, retries=RETRIES, workers=left, allow_other_workers=left is not None,
            )  # fmt: skip
        self._running[future] = number
        self._ended.add(future)

    def ended(self) -> tuple[int, bytes | Refused]:
        future: Any = next(self._ended)
        number = self._running.pop(future)
        if future.status == "error":
            raise future.exception()
        with _asked():
            # What the worker has is here then, and it may forget it.
            return number, future.result()

    def stop(self) -> None:
        with suppress(_Gone), _asked():
            self._client.cancel([future for future in self._running if not future.done()])


TYPES: dict[str, Callable[[str], Any]] = {
    "bool": lambda text: bool(("off", "on").index(text)),
    "int": int,
    "float": float,
    "str": str,
    "tuple[int": lambda text: tuple(int(part) for part in text.split(",")),
    "tuple[float": lambda text: tuple(float(part) for part in text.split(",")),
}
"""How options are read, by how their types begin."""

STOPPED = 130
"""The exit code of what Ctrl-C has stopped."""


class _Parser(argparse.ArgumentParser):
    """Says in one line what it does not understand, without the usage of all options."""

    def error(self, message: str) -> NoReturn:
        self.exit(2, f"error: {one_line(message)}; {self.prog} --help lists the arguments\n")

    def add_fields(self, of: type[BakeOptions] | type[Scene]) -> None:
        """An option for each field with a default."""
        for field in fields(of):
            name, text = "--" + field.name.replace("_", "-"), f"see lobe.{of.__name__} [default: {field.default}]"
            if field.default is False:
                self.add_argument(name, action="store_true", help=text)
            elif field.default is not MISSING:
                kind = TYPES[str(field.type).split(" |")[0].split(",")[0]]
                self.add_argument(name, type=kind, default=field.default, help=text)


def _parsed(arguments: list[str] | None) -> dict[str, Any]:
    parser = _Parser(prog="python -m lobe.distributed", description="Bake a scene on the workers of a Dask scheduler.")
    parser.add_argument("path", metavar="scene", help="a .glb, .gltf, .obj or .ply file, or built-in:NAME")
    parser.add_argument("-o", "--output", required=True, help="a .glb or .safetensors file")
    parser.add_argument("--scheduler", help="such as tcp://10.0.0.1:8786 [default: a process on this machine]")
    parser.add_argument("--shards", type=int, help=f"parts of the work [default: {SHARDS_EACH} for each thread of the workers]")
    parser.add_fields(BakeOptions)
    parser.add_fields(Scene)
    return vars(parser.parse_args(arguments))


def _bake_as_told(given: dict[str, Any]) -> None:
    from distributed import Client

    scene = Scene(**{field.name: given[field.name] for field in fields(Scene)})
    options = BakeOptions(**{field.name: given[field.name] for field in fields(BakeOptions)})
    address = given["scheduler"]

    def tell(done: int, count: int) -> None:
        print(f"progress: {done} of {count} shards", file=sys.stderr)

    with Client(address, timeout=10, set_as_default=False) if address else nullcontext() as client:
        bake(scene, given["output"], options, client=client, shards=given["shards"], progress=tell)


def main(arguments: list[str] | None = None) -> int:
    """The command; errors are one line, and exit code 2."""
    given = _parsed(arguments)

    def warn(message: Warning | str, *_: object, **__: object) -> None:
        print(f"warning: {one_line(message)}", file=sys.stderr)

    try:
        with warnings.catch_warnings():
            warnings.showwarning = warn
            _bake_as_told(given)
    except (ImportError, OSError, RuntimeError, TypeError, ValueError) as error:
        remedy = "; pip install distributed filelock" if isinstance(error, ImportError) else ""
        print(f"error: {one_line(error)}{remedy}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("error: stopped; the same command takes up the shards that are done", file=sys.stderr)
        return STOPPED
    return 0


if __name__ == "__main__":
    sys.exit(main())
