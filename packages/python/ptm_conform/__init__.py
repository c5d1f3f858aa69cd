"""Checks a decoder of Polynomial Texture Maps (PTM 1.2) and says which clauses it misreads.

    report = ptm_conform.check_callable(my_decoder.decode)     # the whole suite, in this process
    print(report.text)
    array = ptm_conform.decode(file)                           # the reference
    findings = ptm_conform.lint("coin.ptm")

The work is done by the program `ptm-conform`, which this package carries.
"""

from ._checking import Case, Report, check_callable
from ._program import Malformed, Unsupported, decode, lint, program

__all__ = ["Case", "Malformed", "Report", "Unsupported", "check_callable", "decode", "lint", "program"]
__version__ = "@VERSION@"
