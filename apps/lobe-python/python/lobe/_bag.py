"""A bag of items on the workers of Dask: each on its own, one that fails no hindrance for the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")

NAMED = 3
"""Failures that a message spells out; of the rest it says how many there are."""

NAME_LENGTH = 80
"""Letters of an item's name at most, so that arrays do not fill the screen."""


class Unfinished(RuntimeError):
    """Some items failed, after all others were done."""

    def __init__(self, items: list[Any], results: list[Any], errors: dict[int, BaseException]) -> None:
        self.results: list[Any] = results
        """What was returned, in the order of the items; None where there is an error."""
        self.errors: dict[int, BaseException] = errors
        """What was raised, by the number of the item, from 0 on."""
        told = [f"{_name(items[index])}: {' '.join(str(error).split())}" for index, error in list(errors.items())[:NAMED]]
        if len(errors) > NAMED:
            told.append(f"and {len(errors) - NAMED} more")
        super().__init__(f"{len(errors)} of {len(items)} items failed: {'; '.join(told)}")


def _name(item: object) -> str:
    name = " ".join(str(item).split())
    return name if len(name) <= NAME_LENGTH else f"{name[:NAME_LENGTH]}..."


def client_or_own(client: Client | None) -> AbstractContextManager[Client]:
    """The client as it is, or one of a process on this machine that ends with it."""
    if client is not None:
        return nullcontext(client)
    from distributed import Client, LocalCluster

    # One task at a time: it has as many threads as there are processors.
    # Dask says that None is no dashboard, and not so in its types.
    none: Any = None
    cluster = LocalCluster(n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address=none)
    own: AbstractContextManager[Client] = Client(cluster, set_as_default=False)
    return own


def map(
    function: Callable[[Item], Any],
    items: Iterable[Item],
    *,
    client: Client | None = None,
    progress: Callable[[int, int], object] | None = None,
) -> list[Any]:
    """`function(item)` of each item on the workers of a Dask client, or in a process of this machine; what it returns, in the order of the items.

        light = lobe.distributed.map(lambda path: lobe.EnvMap.load(path).project(3), paths, client=client)

    Items are best small, such as paths of files that the workers share, or a path and a range of rows. Where an item fails the others
    are done first; then `Unfinished` names it, and has what they returned. `progress(done, count)` is called for each.
    """
    from distributed import as_completed

    given = list(items)
    results: list[Any] = [None] * len(given)
    errors: dict[int, BaseException] = {}
    with client_or_own(client) as engine, engine.as_current():
        futures = {engine.submit(function, item, pure=False): index for index, item in enumerate(given)}
        try:
            for done, future in enumerate(as_completed(list(futures)), 1):
                index, error = futures[future], future.exception()
                if error is None:
                    results[index] = future.result()
                else:
                    errors[index] = error
                future.release()
                if progress is not None:
                    progress(done, len(given))
        finally:
            engine.cancel([future for future in futures if not future.done()])
    if errors:
        raise Unfinished(given, results, dict(sorted(errors.items())))
    return results
