"""What the fuzz scripts share: seeded inputs until the time is over, each judged alone; offenders are kept."""

from __future__ import annotations

import argparse
import resource
import signal
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from random import Random
from time import monotonic

__all__ = ["Files", "fuzz", "mutated"]

Files = dict[str, bytes]
"""The files of one input, by their names."""

LONGEST = 10
"""Seconds that one small input may take; the slowest good one takes a hundredth of that."""

MEMORY = 2 * 2**30
"""Bytes that the process may grow by; good inputs take some megabytes."""

SENTENCE = 480
"""Characters of a sentence, the path aside: three lines of a wide terminal."""

WORDS = [
    b"", b"0", b"-1", b"1", b"2", b"3", b"1e400", b"-1e61", b"1e-300", b"nan", b"inf", b"0.5", b"1e30", b"9" * 5000,
    b"4294967295", b"2147483648", b"-2147483649", b"1000000000000", b"1/2/3", b"1//2", b"-1/-1", b"/", b"#", b"\\",
    b"v", b"f", b"l", b"OFF", b"4OFF", b"COFF", b"ply", b"x", b"list", b"float", b"uchar", b"face", b"vertex",
    b"end_header", b"1_0", b"0x10", b"\xff\xfe", b"\xef\xbb\xbf", b"\x00", b"\xa0", "屋根".encode(), b"x" * 3000,
]  # fmt: skip


def mutated(content: bytes, random: Random) -> bytes:
    """With one to three faults: bytes, words or lines lost, doubled, exchanged, another encoding, the end cut off."""
    for _ in range(random.choice([1, 1, 1, 2, 3])):
        content = random.choice([_bytes, _bytes, _words, _words, _words, _lines, _lines, _whole])(content, random)
    return content


def fuzz(
    inputs: Callable[[Random], Files],
    attempt: Callable[[Path], None],
    allowed: tuple[type[Exception], ...],
    description: str,
) -> int:
    """Run by hand: attempt one input after the other, each written to a folder of its own. 1 where one offends.

    An attempt may end well or with an allowed exception whose sentence can be printed and is short. Any other
    exception, a warning, more than LONGEST seconds or MEMORY bytes offend. Input number n of a seed is always the same.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--number", type=int, help="only this input of the seed")
    parser.add_argument("--keep", type=Path, default=Path("fuzz-offenders"), help="folder for inputs that offend")
    options = parser.parse_args()
    _limit_memory()
    signal.signal(signal.SIGALRM, _too_long)
    number, counts, end = options.number or 0, Counter[str](), monotonic() + options.seconds
    while monotonic() < end:
        files = inputs(Random(f"{options.seed}/{number}"))
        fault = _fault(files, attempt, allowed, counts)
        if fault:
            folder = options.keep / f"{options.seed}-{number}"
            folder.mkdir(parents=True, exist_ok=True)
            for name, content in {**files, "fault.txt": fault.encode(errors="backslashreplace")}.items():
                (folder / name).write_bytes(content)
            print(f"input {number} offends, kept in {folder}: {fault.strip().splitlines()[-1][:200]}")
        number += 1
        if options.number is not None:
            break
    print(
        f"seed {options.seed}, {sum(counts.values())} inputs:", ", ".join(f"{n} {k}" for k, n in counts.most_common())
    )
    return int(counts["offending"] > 0)


def _fault(
    files: Files, attempt: Callable[[Path], None], allowed: tuple[type[Exception], ...], counts: Counter[str]
) -> str:
    """What is wrong about an attempt, nothing if all is well."""
    fault = ""
    with tempfile.TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("error")
        for file, content in files.items():
            (Path(name) / file).write_bytes(content)
        signal.alarm(LONGEST)
        try:
            attempt(Path(name))
            counts["good"] += 1
        except allowed as error:
            sentence = str(error).replace(name, "")
            if not sentence.isprintable() or len(sentence) > SENTENCE:
                fault = f"a sentence of {len(sentence)} characters: {sentence!r}"
            counts["refused"] += not fault
        except BaseException as error:
            if isinstance(error, KeyboardInterrupt):
                raise
            fault = traceback.format_exc()
        finally:
            signal.alarm(0)
    counts["offending"] += bool(fault)
    return fault


class _TooLongError(BaseException):
    """Not an Exception, so that nobody catches it on the way."""


def _too_long(*_: object) -> None:
    raise _TooLongError(f"more than {LONGEST} seconds")


def _limit_memory() -> None:
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))


# --- faults


def _bytes(content: bytes, random: Random) -> bytes:
    place = random.randrange(len(content) + 1)
    length = random.choice([0, 1, 1, 2, 8, 64])
    new = random.choice([b"", random.randbytes(length or 1), bytes(length), content[place : place + 2 * length]])
    return content[:place] + new + content[place + length :]


def _words(content: bytes, random: Random) -> bytes:
    line, lines = _some_line(content, random)
    words = lines[line].split(b" ")
    place = random.randrange(len(words))
    words[place : place + random.choice([0, 1, 1, 1, 2])] = [random.choice([*WORDS, random.choice(words)])]
    lines[line] = b" ".join(words)
    return b"\n".join(lines)


def _lines(content: bytes, random: Random) -> bytes:
    line, lines = _some_line(content, random)
    other = random.randrange(len(lines))
    match random.randrange(4):
        case 0:
            del lines[line : line + random.choice([1, 1, 3])]
        case 1:
            lines.insert(other, lines[line])
        case 2:
            lines[line], lines[other] = lines[other], lines[line]
        case _:
            lines[line] = lines[line] + b" " + lines[other]
    return b"\n".join(lines)


def _whole(content: bytes, random: Random) -> bytes:
    match random.randrange(4):
        case 0:
            return content[: random.randrange(len(content) + 1)]
        case 1:
            return content.replace(b"\n", random.choice([b"\r\n", b"\r", b"\n\n", b" \\\n"]))
        case 2:
            return content.decode("latin-1").encode(
                random.choice(["utf-8-sig", "utf-16", "utf-16-be", "utf-32", "utf-8"])
            )
        case _:
            return random.choice([content.upper(), content.lower(), content * 2])


def _some_line(content: bytes, random: Random) -> tuple[int, list[bytes]]:
    """A line, near to the beginning rather often, where headers are; and all lines."""
    lines = content.split(b"\n")
    return min(random.randrange(len(lines)), random.choice([len(lines), 12])), lines
