"""What is asked of a Dask client, whose scheduler may be gone or have no workers."""

from __future__ import annotations

import asyncio
import sys
import time
from collections.abc import Iterator
from concurrent.futures import CancelledError
from contextlib import AbstractContextManager, contextmanager, nullcontext
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from distributed import Client

LOOK_SECONDS = 1.0
"""How often one looks for workers while nothing comes."""


QUIET = """
import logging, signal
signal.signal(signal.SIGINT, signal.SIG_IGN)
logging.getLogger("distributed.worker.state_machine").setLevel(logging.ERROR)
"""
"""What a process that is this program's own does first: Ctrl-C, which a terminal sends to both, is for the program alone, and that a task was
stopped no news."""


class Gone(Exception):
    """The scheduler does not answer any more."""


class NotYet(Exception):
    """What a task returned has not come in time; its worker may be gone, and another be needed."""


def client_or_own(client: Client | None) -> AbstractContextManager[Client]:
    """The client as it is, or one of a process on this machine that ends with it."""
    if client is not None:
        return nullcontext(client)
    from distributed import Client, LocalCluster

    # One task at a time: it has as many threads as there are processors.
    # Dask says that None is no dashboard, and not so in its types.
    none: Any = None
    cluster = LocalCluster(n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=none, preload=[QUIET])
    own: AbstractContextManager[Client] = Client(cluster, set_as_default=False)
    return own


@contextmanager
def asked() -> Iterator[None]:
    """Around what only asks the scheduler: `Gone` if it does not answer. What tasks raise is not asked for in it, nor what callers do."""
    from distributed import client

    # Of later versions.
    closed = getattr(client, "ClosedClientError", OSError)
    try:
        yield
    except (OSError, closed, CancelledError, asyncio.TimeoutError):
        raise Gone from None


def threads_of(client: Client) -> dict[str, int]:
    """How many threads each worker has, by its address."""
    with asked():
        # In Dask's types it may be a coroutine.
        threads: Any = client.nthreads()
        return dict(threads)


class Waiting:
    """Says once that there is no worker, and again when there was one meanwhile."""

    def __init__(self, client: Client) -> None:
        self._client, self._told = client, False

    def look(self) -> bool:
        """Whether there is a worker."""
        if threads_of(self._client):
            self._told = False
            return True
        if not self._told:
            address = getattr(self._client.scheduler, "address", "the scheduler")
            print(f"{address}: waiting for a worker; this starts one: dask worker {address} --nthreads 1", file=sys.stderr, flush=True)
            self._told = True
        return False

    def wait(self) -> None:
        """Returns when there is a worker."""
        while not self.look():
            time.sleep(LOOK_SECONDS)


def value_of(future: Any, seconds: float | None = None) -> Any:
    """What a task that has ended returned, or raises its error; `Gone` where the scheduler took it along, `NotYet` after some seconds."""
    if future.status == "error":
        return future.result()
    with asked():
        try:
            return future.result(timeout=seconds)
        except (TimeoutError, asyncio.TimeoutError):
            raise NotYet from None


def cancel(client: Client, futures: list[Any]) -> None:
    """Takes back tasks that are not needed any more, if there is a scheduler."""
    try:
        with asked():
            client.cancel(futures)
    except Gone:
        pass
