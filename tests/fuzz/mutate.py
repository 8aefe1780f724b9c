"""Mutations: of bytes, of numbers and words in text, and of what several files have."""

import random
import re

_NUMBERS = [
    b"0", b"-0", b"-1", b"1e308", b"-1e308", b"1e-320", b"nan", b"inf", b"-inf", b"1e400",
    b"4294967296", b"-9223372036854775809", b"18446744073709551616", b"9" * 400, b"1_000", b"0x10",
    b"1,5", b".", b"1e", b"true", b'""', b"[]", b"{}", b"[[]]", b"1979-05-27", b"'a'",
]  # fmt: skip
_PIECES = [
    b"", b"\0", b"\xff", b"\xfe\xff", b"\xef\xbb\xbf", b"\r", b"\n", b'"', b"'", b",", b";", b"\t",
    b"[", b"]", b"{", b"}", b"<", b">", b"&", b"<!DOCTYPE a [<!ENTITY b 'c'>]>", b"../",
    b"/dev/zero", b"\x1b[31m", b"\xe2\x80\xae", b"=", b"#", b" " * 300, b"[" * 2000, b"A" * 3000,
]  # fmt: skip
_NUMBER = re.compile(rb"-?\d+\.?\d*(?:[eE][-+]?\d+)?")


def mutate(rng: random.Random, data: bytes, other: bytes) -> bytes:
    """Return data after one to four mutations; `other` is another file to take pieces from."""
    for _ in range(rng.choice((1, 1, 1, 2, 2, 3, 4))):
        data = rng.choice(_WAYS)(rng, data, other)
    return data


def _flip(rng, data, other):
    out = bytearray(data)
    for _ in range(rng.choice((1, 1, 2, 8))):
        if out:
            out[rng.randrange(len(out))] ^= 1 << rng.randrange(8)
    return bytes(out)


def _set(rng, data, other):
    out = bytearray(data)
    if out:
        at = rng.randrange(len(out))
        out[at : at + 4] = rng.choice((b"\xff" * 4, bytes(4), b"\x7f" * 4, rng.randbytes(4)))
    return bytes(out)


def _number(rng, data, other):
    found = list(_NUMBER.finditer(data))
    if not found:
        return data
    one = rng.choice(found)
    return data[: one.start()] + rng.choice(_NUMBERS) + data[one.end() :]


def _piece(rng, data, other):
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.choice(_PIECES) + data[at + rng.choice((0, 0, 1, 5)) :]


def _cut(rng, data, other):
    a, b = sorted(rng.randrange(len(data) + 1) for _ in range(2))
    return rng.choice((data[:a], data[a:], data[:a] + data[b:], data[a:b]))


def _splice(rng, data, other):
    a, b = rng.randrange(len(data) + 1), rng.randrange(len(other) + 1)
    return data[:a] + other[b : b + rng.choice((10, 100, 10_000))] + data[a:]


def _line(rng, data, other):
    lines = data.split(b"\n")
    i, j = rng.randrange(len(lines)), rng.randrange(len(lines))
    how = rng.randrange(4)
    if how == 0:
        lines[i], lines[j] = lines[j], lines[i]
    elif how == 1:
        lines.insert(i, lines[j])
    elif how == 2:
        del lines[i]
    else:
        lines[i] = lines[i].swapcase()
    return b"\n".join(lines)


def _repeat(rng, data, other):
    a = rng.randrange(len(data) + 1)
    piece = data[a : a + rng.choice((1, 10, 200))]
    return data[:a] + piece * rng.choice((2, 50)) + data[a:]


_WAYS = (_flip, _flip, _set, _number, _number, _number, _piece, _piece, _cut, _splice, _line, _line,
         _repeat)  # fmt: skip
