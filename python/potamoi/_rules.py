"""Rules of the knobs: what a configuration of the exponential has to keep."""

from __future__ import annotations

from ._forms import FORMS, Engine, Form, earliest_out, interval
from ._knobs import Knobs


class _Breaches:
    """Broken rules, in the order of the checks."""

    def __init__(self) -> None:
        self.lines: list[str] = []

    def require(self, kept: bool, rule: str, name: str, value: object, expected: str) -> None:
        if not kept:
            self.lines.append(f"rule `{rule}`: {name} = {value}; expected {expected}")

    def range(self, rule: str, name: str, value: int, low: int, high: int, why: str) -> None:
        self.require(low <= value <= high, rule, name, value, f"{low} to {high}: {why}")


def broken(knobs: Knobs) -> list[str]:
    """A line for each rule that the knobs break."""
    out, form = _Breaches(), FORMS[knobs.form]
    least, most, why = form.iterations
    n = knobs.iterations
    out.range("exp-iterations", "vu.exp.iterations", n, least, most, why)
    if not out.lines:
        _formats(knobs, form, out)
    if not out.lines:
        _widths(knobs, form, out)
    _unused(knobs, out)
    return out.lines


def _formats(knobs: Knobs, form: Form, out: _Breaches) -> None:
    """Rules of what the form offers, and of its formats."""
    out.require(
        knobs.output == "alpha" or form.general,
        "exp-form-output",
        "vu.exp.output",
        "general",
        '"alpha": the general output is of vu.exp.form = "restoring"',
    )
    out.require(
        knobs.base == "e" or form.base_two,
        "exp-base",
        "vu.exp.base",
        "two",
        '"e": powers of two are of vu.exp.form = "piecewise"',
    )
    for rule in form.rules(knobs):
        out.require(*rule)
    out.range(
        "exp-output-bits",
        "vu.exp.output_bits",
        knobs.output_bits,
        4,
        24 if knobs.output == "alpha" else 23,
        "fraction bits of the result, which has 32 in all",
    )
    out.range(
        "exp-one-minus-frac-bits",
        "vu.exp.one_minus_frac_bits",
        knobs.one_minus_frac_bits,
        8,
        24,
        "the input covers 0 to 16",
    )
    right, wanted = form.input(knobs.format, knobs.output)
    right = right and 4 <= knobs.format.frac_bits <= 24
    shown = "{}{}.{}".format("S" if knobs.format.is_signed else "U", *knobs.format[1:])
    out.require(right, "exp-input", "vu.exp.input", shown, wanted)


def _widths(knobs: Knobs, form: Form, out: _Breaches) -> None:
    """Rules that relate widths and steps."""
    engine = form.engine(knobs)
    out.range(
        "exp-iterations-per-clock",
        "vu.exp.iterations_per_clock",
        knobs.iterations_per_clock,
        1,
        max(engine.steps, 1),
        "steps taken in one clock, of n and the exponent's digits",
    )
    out.range(
        "exp-accumulator-bits",
        "vu.exp.accumulator_bits",
        engine.accumulator_bits,
        knobs.output_bits,
        40,
        "at least the result's fraction bits",
    )
    least, why = form.least_constant_bits(knobs)
    bits = engine.constant_bits if knobs.constant_bits is None else knobs.constant_bits
    out.range("exp-constant-bits", "vu.exp.constant_bits", bits, least, 40, why)
    out.require(
        -16 <= engine.offset <= 16,
        "exp-offset",
        "vu.exp.offset",
        engine.offset,
        "-16 to 16 units of the accumulator's last bit",
    )
    out.require(
        form.tail or not knobs.tail,
        "exp-literal-tail",
        "vu.exp.tail",
        "true",
        f"false: the {knobs.form} recurrence has no tail",
    )
    if knobs.early_out:
        _early_out(knobs, form, engine, out)


def _early_out(knobs: Knobs, form: Form, engine: Engine, out: _Breaches) -> None:
    """Rules of early termination."""
    name = "vu.exp.early_out"
    out.require(
        form.early_out and knobs.output == "alpha",
        "exp-early-out",
        name,
        "true",
        'false: it is of vu.exp.form = "restoring" and vu.exp.output = "alpha"',
    )
    out.require(
        not knobs.pipelined and not knobs.tail,
        "exp-early-out-iterative",
        name,
        "true",
        "false, or vu.exp.pipelined and vu.exp.tail false: stages and tail come at fixed clocks",
    )
    earliest, clocks = earliest_out(knobs, engine), interval(knobs, engine)
    out.require(
        earliest < clocks,
        "exp-early-out-clocks",
        name,
        "true",
        f"false: all iterations take {clocks} clocks, and the lanes agree to stop after {earliest} "
        "at the earliest",
    )


def _unused(knobs: Knobs, out: _Breaches) -> None:
    """A knob without effect has to have its default."""
    is_piecewise = knobs.form == "piecewise"
    out.require(
        is_piecewise or knobs.pieces == Knobs.pieces,
        "unused-pieces",
        "vu.exp.pieces",
        knobs.pieces,
        'left out: pieces are of vu.exp.form = "piecewise"',
    )
    out.require(
        not is_piecewise or knobs.iterations == Knobs.iterations,
        "unused-iterations",
        "vu.exp.iterations",
        knobs.iterations,
        'left out: vu.exp.form = "piecewise" takes no iterations',
    )
