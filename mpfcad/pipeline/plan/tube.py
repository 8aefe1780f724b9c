"""Plans of jobs whose backlight has tubes: what is not made under LEDs asks for one."""

from pathlib import Path

from mpfcad.errors import InputError
from mpfcad.job import Job
from mpfcad.pipeline.plan.plan import Plan, read_plan


def read_tube_plan(job: Job, job_file: Path) -> Plan:
    """Return the plan of a job whose backlight has tubes, as `read_plan`.

    Raises
    ------
    InputError
        when LEDs light it, too.
    """
    plan = read_plan(job, job_file)
    if plan.stack.period.along > 0:
        raise InputError(
            f"{job_file}: stack: {plan.stack.name}: LEDs light it: expected a stack of tubes; "
            "mpfcad run, mask, cad, trace and measure take LEDs, and a design of kind 'leds'"
        )
    return plan
