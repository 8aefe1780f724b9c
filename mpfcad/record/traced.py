"""The films whose light a verification.json holds: this one, and those that it is compared with."""

from typing import Any, NamedTuple

#: Where their figures stand: at the top, and in tables of the same keys.
THIS, PLAIN, BASELINE = "", "plain", "baseline"
PLACES = (THIS, PLAIN, BASELINE)


class TracedFilm(NamedTuple):
    """One film that was traced.

    Attributes
    ----------
    place
        one of `PLACES`
    name, words
        in a table's head or a legend; in a sentence
    found
        its figures, as `describe_luminance` has them
    """

    place: str
    name: str
    words: str
    found: dict[str, Any]


def traced_films(record: dict[str, Any]) -> list[TracedFilm]:
    """Return the films of a verification.json that were traced, this one first.

    The baseline is left out where it is the plain film of the same backlight. Older exports have
    no plain film, and no words for the baseline.
    """
    base = record[BASELINE]
    films = [TracedFilm(THIS, "this film", f"this film: {record['name']}", record)]
    if record.get(PLAIN):
        words = "plain BEF in this backlight"
        films.append(TracedFilm(PLAIN, "plain BEF", words, record[PLAIN]))
    if not base.get("is_own"):
        name = str(base.get("stack", "conventional"))
        films.append(TracedFilm(BASELINE, name, baseline_words(record), base))
    return [film for film in films if film.found["luminance"] or film.found.get("cell")]


def baseline_words(record: dict[str, Any]) -> str:
    """Return what the film's light is compared with; of an older export the conventional stack."""
    return str(record[BASELINE].get("words", "the conventional stack"))


def comparison_words(record: dict[str, Any]) -> str:
    """Return what the baseline is and why it is that."""
    words = f"Baseline: {baseline_words(record)}"
    if "words" not in record[BASELINE]:
        return f"{words}."
    if record[BASELINE]["is_own"]:
        return f"{words}; the job names no other."
    return (
        f"{words}, which the job names. The contrast is compared with a plain BEF in this "
        "backlight, too."
    )
