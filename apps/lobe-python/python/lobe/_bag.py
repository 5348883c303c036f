"""A bag of items on the workers of Dask: each on its own, one that fails no hindrance for the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar

from ._engine import LOOK_SECONDS, Gone, Waiting, asked, cancel, client_or_own, value_of

if TYPE_CHECKING:
    from distributed import Client

Item = TypeVar("Item")

NAMED = 3
"""Failures that a message spells out; of the rest it says how many there are."""

NAME_LENGTH = 80
"""Letters of an item's name at most, so that arrays do not fill the screen."""


GONE = "the scheduler is gone"


class Unfinished(RuntimeError):
    """Some items failed, after all others were done; or the scheduler was gone before they were."""

    def __init__(self, items: list[Any], results: list[Any], errors: dict[int, BaseException], gone: bool = False) -> None:
        self.results: list[Any] = results
        """What was returned, in the order of the items; None where there is an error."""
        self.errors: dict[int, BaseException] = errors
        """What was raised, by the number of the item, from 0 on; an error for each that was not done yet when the scheduler was gone."""
        if gone:
            text = "start one and repeat the call with the items of `errors`; what the others returned is in `results`"
            super().__init__(f"{len(errors)} of {len(items)} items are not done: {GONE}; {text}")
            return
        told = [f"{_name(items[index])}: {' '.join(str(error).split())}" for index, error in list(errors.items())[:NAMED]]
        if len(errors) > NAMED:
            told.append(f"and {len(errors) - NAMED} more")
        super().__init__(f"{len(errors)} of {len(items)} items failed: {'; '.join(told)}")


def _name(item: object) -> str:
    name = " ".join(str(item).split())
    return name if len(name) <= NAME_LENGTH else f"{name[:NAME_LENGTH]}..."


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
    are done first; then `Unfinished` names it, and has what they returned, as it does where the scheduler is gone. `progress(done, count)` is
    called for each.
    """
    given = list(items)
    results: list[Any] = [None] * len(given)
    errors: dict[int, BaseException] = {}
    left = set(range(len(given)))
    with client_or_own(client) as engine, engine.as_current():
        waiting, futures, ended = Waiting(engine), dict[Any, int](), SimpleQueue[Any]()
        try:
            for index, item in enumerate(given):
                with asked():
                    future = engine.submit(function, item, pure=False)
                futures[future] = index
                future.add_done_callback(ended.put)
            while left:
                try:
                    future = ended.get(timeout=LOOK_SECONDS)
                except Empty:
                    waiting.look()
                    continue
                index = futures[future]
                try:
                    results[index] = value_of(future)
                except Gone:
                    raise
                except Exception as error:
                    errors[index] = error
                left.remove(index)
                future.release()
                if progress is not None:
                    progress(len(given) - len(left), len(given))
        except Gone:
            errors |= {index: RuntimeError(GONE) for index in left}
            raise Unfinished(given, results, dict(sorted(errors.items())), gone=True) from None
        finally:
            cancel(engine, [future for future in futures if not future.done()])
    if errors:
        raise Unfinished(given, results, dict(sorted(errors.items())))
    return results
