"""Who is told how far the work is."""
from __future__ import annotations

from contextlib import contextmanager
from typing import Any, Callable, Iterator, Optional


@contextmanager
def listener(progress: Any) -> Iterator[Optional[Callable[[float, str], None]]]:
    """A callable as it is, which is called with 1 and "done" where the work was; True: a bar of tqdm, which is full
    then, and stays where it ended otherwise."""
    if progress is None or progress is False:
        yield None
        return
    if progress is not True:
        if not callable(progress):
            raise TypeError("progress: wanted a callable of a fraction and a step, True, or None")
        yield progress
        return
    try:
        from tqdm.auto import tqdm  # type: ignore[import]
    except ImportError as error:
        raise ImportError("progress=True shows a bar of tqdm, which is not installed (Debian: python3-tqdm); install "
                          "it, or give a callable of a fraction and a step") from error

    with tqdm(total=1.0, bar_format="{desc} {percentage:3.0f}%|{bar}| {elapsed}<{remaining}") as bar:
        def show(fraction: float, step: str) -> None:
            bar.set_description_str(step, refresh=False)
            bar.update(fraction - bar.n)

        yield show


def told(progress: Any, work: Callable[..., Any], *arguments: Any) -> Any:
    """What a function of the module gives back, whose last argument is whom to tell."""
    with listener(progress) as heard:
        return work(*arguments, heard)
