"""What the fuzz scripts share: seeded inputs until the time is over, each judged alone; offenders are kept."""

from __future__ import annotations

import resource
import signal
import tempfile
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from pathlib import Path
from random import Random
from time import monotonic

__all__ = ["LONGEST", "Files", "Kind", "bounded", "fuzz", "mutated"]

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


@dataclass(frozen=True)
class Kind:
    """Inputs of one kind. An attempt on the folder that holds them says how it ended, or raises an allowed exception.

    Its sentence has to be printable and short. Any other exception, a warning, more than LONGEST seconds or MEMORY
    bytes offend.
    """

    name: str
    inputs: Callable[[Random], Files]
    attempt: Callable[[Path], str]
    allowed: tuple[type[Exception], ...]


def fuzz(kind: Kind, *, seconds: float, seed: int, number: int | None, keep: Path) -> bool:
    """Attempt one input after the other, each in a folder of its own, or only one. Whether one offends; it is kept.

    Input number n of a kind and a seed is always the same.
    """
    counts, begin, end = Counter[str](), number or 0, monotonic() + seconds
    for n in count(begin) if number is None else [begin]:
        files = kind.inputs(Random(f"{kind.name}/{seed}/{n}"))
        fault = _fault(files, kind, counts)
        if fault:
            folder = keep / f"{kind.name}-{seed}-{n}"
            _write(folder, {**files, "fault.txt": fault.encode(errors="backslashreplace")})
            print(f"{kind.name} {n} offends, kept in {folder}: {ascii(fault.strip().splitlines()[-1])[1:400]}")
        if monotonic() > end:
            break
    found = ", ".join(f"{n} {word}" for word, n in counts.most_common())
    print(f"{kind.name}, seed {seed}, {sum(counts.values())} inputs: {found}", flush=True)
    return counts["offending"] > 0


def bounded() -> None:
    """From now on this process has bounds of memory and time."""
    used = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (used + MEMORY, used + MEMORY))
    signal.signal(signal.SIGALRM, _too_long)


def _write(folder: Path, files: Files) -> None:
    for name, content in files.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def _fault(files: Files, kind: Kind, counts: Counter[str]) -> str:
    """What is wrong about an attempt, nothing if all is well."""
    fault = ""
    with tempfile.TemporaryDirectory() as name, warnings.catch_warnings():
        warnings.simplefilter("error")
        _write(Path(name), files)
        signal.alarm(LONGEST)
        try:
            counts[kind.attempt(Path(name))] += 1
        except kind.allowed as error:
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
