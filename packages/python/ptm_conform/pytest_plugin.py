"""One test for each case of the suite.

    # test_ptm.py
    @pytest.fixture(scope="session")
    def ptm_decoder():
        return my_decoder.decode            # or {"raw": …, "rgb": …, "malformed": …}: arguments of check_callable

    def test_ptm(ptm_case):
        ptm_case.check()

The suite runs once, when the first of them does; with `-k` or an id, only the cases that are asked for.
"""

import json
import os

import pytest

from . import check_callable

SKIPPED = ("unsupported", "inconclusive", "not judged", "not run")


def case_ids():
    """All ids, in the order of the suite."""
    with open(os.path.join(os.path.dirname(__file__), "cases.json"), encoding="utf-8") as file:
        return json.load(file)


def pytest_generate_tests(metafunc):
    if "ptm_case" in metafunc.fixturenames:
        ids = case_ids()
        metafunc.parametrize("ptm_case", ids, ids=ids, indirect=True)


@pytest.fixture(scope="session")
def ptm_report(request, ptm_decoder):
    """The Report on `ptm_decoder`, of the cases that this session runs."""
    named = [item.callspec.params["ptm_case"] for item in request.session.items if "ptm_case" in getattr(getattr(item, "callspec", None), "params", {})]
    named = sorted(set(named))
    options = [] if len(named) in (0, len(case_ids())) else [word for id in named for word in ("--case", id)]
    arguments = ptm_decoder if isinstance(ptm_decoder, dict) else {"raw": ptm_decoder}
    return check_callable(**arguments, options=options)


@pytest.fixture
def ptm_case(request, ptm_report):
    """One case; its check() fails, passes or skips as the suite's verdict says."""
    return Verdict(request.param, ptm_report)


class Verdict:
    """The verdict on a case, as a test."""

    def __init__(self, id, report):
        self.id = id
        self.report = report
        self.case = next((case for case in report.data["cases"] if case["id"] == id), None)

    def check(self):
        if self.report.status == 3:
            pytest.fail(self.report.data["reason"], pytrace=False)
        outcome, says = self.case["outcome"], self.case.get("says", "")
        if outcome == "fail":
            pytest.fail("\n".join(["%s (%s)" % (self.id, ", ".join(self.case["clauses"])), says, *self.causes()]), pytrace=False)
        # A fault of all images is reported once, and undone before the cases are judged.
        everywhere = [remark["says"] for remark in self.report.data.get("remarks", []) if remark.get("failure")]
        if everywhere and outcome == "pass" and self.case["expect"] == "decode":
            pytest.fail("\n".join([self.id, *everywhere]), pytrace=False)
        if outcome in SKIPPED:
            pytest.skip("%s: %s" % (outcome, says))

    def causes(self):
        """What the report names as the cause of this failure."""
        causes = self.report.data["diagnoses"]
        return ["The decoder %s. Fix: %s." % (cause["effect"], cause["fix"]) for cause in causes if self.id in cause["explains"]]
