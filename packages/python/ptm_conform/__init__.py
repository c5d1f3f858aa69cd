"""Checks a decoder for Polynomial Texture Maps (PTM 1.2) and names the clauses that it misreads.

    report = ptm_conform.check_callable(my_decoder.decode)     # the whole suite, in this process
    print(report.text)
    array = ptm_conform.decode(file)                           # the reference decoder
    findings = ptm_conform.lint("coin.ptm")

The functions call the program `ptm-conform`, which this package contains.
"""

from ._checking import Case, Report, check_callable
from ._program import Malformed, Unsupported, decode, inspect, lint, lint_rows, program

__all__ = ["Case", "Malformed", "Report", "Unsupported", "check_callable", "decode", "inspect", "lint", "lint_rows", "program"]
__version__ = "@VERSION@"
