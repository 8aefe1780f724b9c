"""The oracle's board of LEDs: every box, cup and plane under a ray's way is tried, in plain Python.

LEDs shine by Lambert's law.
"""

import math
from collections.abc import Iterator

from mpfcad.optics.cavity.board import Board
from oracle.ray import Philox, Vector, disk, dot, lambertian, roulette

#: A ray that starts on a surface does not meet it again within so much [mm].
_NEAR = 1e-9
Met = tuple[float, str, Vector]


def board_passage(
    board: Board, up: bool, place: Vector, d: Vector, weight: float, rng: Philox
) -> tuple[bool, Vector, Vector, float, float]:
    """Follow a ray until it leaves the board upward or ends."""
    o, total = (place[0], place[1], board.height), 0.0
    while weight > 0:
        distance, what, normal = min(all_met(board, o, d), key=lambda met: met[0])
        o = tuple(a + distance * b for a, b in zip(o, d, strict=True))
        if what == "open":
            break
        if what in ("top", "side"):
            if what == "top":
                area = board.led_size[0] * board.led_size[1]
                total += weight * 1e6 * board.led_flux / (math.pi * area)
            kept, share = board.led_reflectance, None
        elif what == "cup":
            kept, share = board.cup.reflectance, board.cup.specular_fraction
        elif _in_hole(board, o):
            kept, share = board.hole_reflectance, 0.0
        else:
            kept, share = board.reflectance, board.specular_fraction
        weight *= kept
        if share is not None and rng() < share:
            into = dot(d, normal)
            rng.mirror(normal)
            d = tuple(a - 2 * into * n for a, n in zip(d, normal, strict=True))
        elif what == "floor":
            px, py = disk(rng)
            rng.depolarise()
            d = (px, py, math.sqrt(1 - px * px - py * py))
        else:
            d = lambertian(normal, rng)
        weight = roulette(weight, rng)
    return True, (o[0], o[1], 0.0), d, weight, total


def _in_hole(board: Board, o: Vector) -> bool:
    away = [_from_middle(board, o[:2], led) for led in board.position]
    return any(math.hypot(*offset) <= board.hole_radius for offset in away)


def _from_middle(board: Board, place, led) -> tuple[float, float]:
    """Return a place from the nearest repetition of an LED."""
    away = [a - b for a, b in zip(place, led, strict=True)]
    u, v = (a - p * round(a / p) for a, p in zip(away, board.period, strict=True))
    return u, v


def all_met(board: Board, o: Vector, d: Vector) -> Iterator[Met]:
    """Return all that a ray meets: distance, what, the normal towards it."""
    plane = ((board.height if d[2] > 0 else 0.0) - o[2]) / d[2]
    top = board.cup.height if board.cup else board.led_height
    low, high = sorted((o[2], o[2] + plane * d[2]))
    if low <= top:
        yield from _among_leds(board, o, d, top, (low, high))
    # Last: a flat LED lies in the plane.
    yield plane, "open" if d[2] > 0 else "floor", (0.0, 0.0, 1.0)


def _among_leds(
    board: Board, o: Vector, d: Vector, top: float, span: tuple[float, float]
) -> Iterator[Met]:
    """Return what a ray between two heights meets up to `top`: LEDs, cups, the sheet's top."""
    low, high = span
    ends = [((z - o[2]) / d[2]) for z in (max(low, 0.0), min(high, top))]
    for middle in _middles(board, o, d, ends):
        yield from _box(board, o, d, middle)
        if board.cup:
            yield from _walls(board, o, d, middle)
    if board.cup and d[2] < 0:
        distance = (top - o[2]) / d[2]
        at = [o[i] + distance * d[i] for i in range(2)]
        away = [_from_middle(board, at, led) for led in board.position]
        nearest = min(_size(board, *offset) for offset in away)
        if distance > _NEAR and nearest > board.cup.rim_radius:
            yield distance, "cup", (0.0, 0.0, 1.0)


def _size(board: Board, u: float, v: float) -> float:
    return max(abs(u), abs(v)) if board.cup.square else math.hypot(u, v)


def _middles(board: Board, o: Vector, d: Vector, ends: list[float]) -> Iterator[tuple]:
    """Return the middles of all LEDs about a ray's way between two distances."""
    spread = [max(s, board.cup.rim_radius if board.cup else 0.0) for s in board.led_size]
    for led in board.position:
        numbers = []
        for axis in range(2):
            at = [o[axis] + end * d[axis] - led[axis] for end in ends]
            low, high = min(at) - spread[axis], max(at) + spread[axis]
            period = board.period[axis]
            numbers.append(range(math.ceil(low / period), math.floor(high / period) + 1))
        for i in numbers[0]:
            for k in numbers[1]:
                yield led[0] + i * board.period[0], led[1] + k * board.period[1]


def _box(board: Board, o: Vector, d: Vector, middle) -> Iterator[Met]:
    """Return where a ray meets the faces of an LED from outside."""
    half = [board.led_size[0] / 2, board.led_size[1] / 2]
    faces = [(2, 1.0, board.led_height)]
    faces += [(axis, sign, middle[axis] + sign * half[axis]) for axis in (0, 1) for sign in (-1, 1)]
    for axis, sign, at in faces:
        if sign * d[axis] >= 0:
            continue
        distance = (at - o[axis]) / d[axis]
        p = [a + distance * b for a, b in zip(o, d, strict=True)]
        inside = all(abs(p[i] - middle[i]) <= half[i] for i in (0, 1) if i != axis)
        if distance > _NEAR and inside and (axis == 2 or 0 <= p[2] < board.led_height):
            normal = tuple(sign if i == axis else 0.0 for i in range(3))  # no -0: it turns frames
            yield distance, "top" if axis == 2 else "side", normal


def _walls(board: Board, o: Vector, d: Vector, middle) -> Iterator[Met]:
    """Return where a ray meets the walls of a cup from within."""
    cup = board.cup
    slope = (cup.rim_radius - cup.radius) / cup.height
    long = math.hypot(1.0, slope)
    u, v = o[0] - middle[0], o[1] - middle[1]
    start = cup.radius + slope * o[2]
    tried = []
    if cup.square:
        for axis, at in ((0, u), (1, v)):
            for sign in (-1.0, 1.0):
                rate = sign * d[axis] - slope * d[2]
                normal = [0.0, 0.0, slope / long]
                normal[axis] = -sign / long
                tried += [((start - sign * at) / rate, tuple(normal))] if rate else []
    else:
        a = d[0] ** 2 + d[1] ** 2 - (slope * d[2]) ** 2
        b = u * d[0] + v * d[1] - start * slope * d[2]
        c = u * u + v * v - start * start
        if b * b >= a * c and a:
            for sign in (-1, 1):
                distance = (-b + sign * math.sqrt(b * b - a * c)) / a
                x, y = u + distance * d[0], v + distance * d[1]
                far = math.hypot(x, y) * long
                tried.append((distance, (-x / far, -y / far, slope / long)))
    for distance, normal in tried:
        z = o[2] + distance * d[2]
        x, y = u + distance * d[0], v + distance * d[1]
        size = cup.radius + slope * z
        within = not cup.square or max(abs(x), abs(y)) <= size * (1 + 1e-12)
        if distance > _NEAR and 0 <= z <= cup.height and within and dot(d, normal) < 0:
            yield distance, "cup", normal
