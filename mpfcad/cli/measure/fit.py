"""`mpfcad fit`: a backlight's values from what was measured of it."""

from pathlib import Path
from typing import Annotated

import typer

from mpfcad.cli.option import Json, Threads, TraceEffort


def command(
    fit_file: Annotated[
        Path, typer.Argument(metavar="FIT.toml", help="The fit.", show_default=False)
    ],
    effort: TraceEffort = None,
    threads: Threads = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Folder of the results [default: exports/NAME-fit]."
        ),
    ] = None,
    json: Json = False,
) -> int:
    """Find the backlight that measurements hold, and what to measure next; resumes."""
    from mpfcad.cli.character import print_json
    from mpfcad.cli.terminal import Terminal
    from mpfcad.job.fit import read_fit
    from mpfcad.pipeline import FitSetting, default_fit_out, fit_backlight

    fit = read_fit(fit_file)
    folder = out or default_fit_out(fit)
    setting = FitSetting(None if effort is None else effort.value, threads)
    with Terminal() as terminal:
        record = fit_backlight(fit, fit_file, folder, setting, terminal)
    code = 1 if record["contradicts"] else 0
    if json:
        print_json(record)
        return code
    for row in record["values"]:
        prior = "no prior"
        if row["left"] is not None:
            known = f"{row['prior']:.5g} ± {row['prior_sigma']:.2g}"
            prior = f"prior {known}, {row['left']:.0%} of its width left"
        print(f"{row['name']:30} {row['value']:.5g} ± {row['sigma']:.2g}  ({prior})")
    if record["probability"] is not None:
        of = f"{record['chi2']:.1f} of {record['degrees_of_freedom']}"
        print(f"measurements and priors: chi2 {of}, probability {record['probability']:.2g}")
        if record["contradicts"]:
            print("they contradict each other, and the widths do not hold: see the residuals in "
                  "fit.html")  # fmt: skip
    if not record["settled"]:
        print(f"not settled: the last round moved the values by {record['rounds'][-1]:.2f} of "
              "their widths")  # fmt: skip
    if record["mostly_traces"]:
        print(f"the traces' noise is most of the error of {record['mostly_traces']} of "
              f"{len(record['data'])} measured numbers: a higher --effort tells more")  # fmt: skip
    for row in record["predictions"]:
        low, high = row["ci95"]
        print(f"predicted: {row['name']}: {row['value']:.5g} [{low:.5g}, {high:.5g}]")
    for row in record["measure_next"][:3]:
        print(f"measure next: {row['measurement']}: leaves {row['left']:.2f} of the widths")
    print(f"in a job: stack.file = {folder / f'{fit.name}.toml'}, confidence.covariance = "
          f"{folder / 'covariance.csv'}")  # fmt: skip
    print(folder / "fit.html")
    return code
