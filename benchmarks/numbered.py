"""Numbered random cases, each in a process of its own, every failure told with its number."""

from __future__ import annotations

import argparse
import time
import traceback
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass

from in_process import Died, limited


@dataclass(frozen=True)
class Told:
    """``judge(number)``, or what failed and where."""

    judge: Callable[[int], str]

    def __call__(self, number: int) -> str:
        try:
            return self.judge(number)
        except MemoryError:
            raise
        except BaseException as error:
            return f"FAILED: {_place_of(error)}: {error!r:.300}"


def _place_of(error: BaseException) -> str:
    """The check that failed, and its line."""
    frames = traceback.extract_tb(error.__traceback__)
    frame = next((f for f in frames if f.name.startswith("check_")), frames[-1])
    return f"{frame.name}, line {frame.lineno}"


def parser(description: str, seconds: int) -> argparse.ArgumentParser:
    """Of the range of numbers, and of the limits of each."""
    made = argparse.ArgumentParser(description=description)
    made.add_argument("first", type=int)
    made.add_argument("end", type=int)
    made.add_argument("--seconds", type=int, default=seconds, help="processor time of a case")
    made.add_argument("--memory", type=int, default=4, help="GiB")
    return made


def run(judge: Callable[[int], str], asked: argparse.Namespace) -> int:
    """Prints what became of each case, and how often; 1 if one failed.

    ``judge`` tells the kind of outcome, a colon, and the rest; it raises what its checks raise.
    """
    kinds: Counter[str] = Counter()
    for number in range(asked.first, asked.end):
        clock = time.perf_counter()
        answer = limited(Told(judge), number, asked.seconds, asked.memory)
        line = f"FAILED: {answer.why}" if isinstance(answer, Died) else answer
        kinds[line.split(":")[0]] += 1
        print(f"{number}: {line} ({time.perf_counter() - clock:.1f} s)", flush=True)
    for kind, count in kinds.most_common():
        print(f"{count} {kind}")
    return 1 if kinds["FAILED"] else 0
