"""Pytest plugin with one test for each case of the suite.

    # test_ptm.py
    @pytest.fixture(scope="session")
    def ptm_decoder():
        return my_decoder.decode            # or {"raw": …, "rgb": …, "malformed": …}: arguments of check_callable

    def test_ptm(ptm_case):
        ptm_case.check()

The suite runs once, before the first of these tests. With `-k` or a test id, only the selected cases run.
"""

import json
import os

import pytest

from . import check_callable

SKIPPED = ("unsupported", "inconclusive", "not judged", "not run")


def case_ids():
    """Returns all case ids in the order of the suite."""
    with open(os.path.join(os.path.dirname(__file__), "cases.json"), encoding="utf-8") as file:
        return json.load(file)


def pytest_generate_tests(metafunc):
    if "ptm_case" in metafunc.fixturenames:
        ids = case_ids()
        metafunc.parametrize("ptm_case", ids, ids=ids, indirect=True)


@pytest.fixture(scope="session")
def ptm_report(request, ptm_decoder):
    """The Report on `ptm_decoder` for the cases of this session."""
    named = [item.callspec.params["ptm_case"] for item in request.session.items if "ptm_case" in getattr(getattr(item, "callspec", None), "params", {})]
    named = sorted(set(named))
    options = [] if len(named) in (0, len(case_ids())) else [word for id in named for word in ("--case", id)]
    arguments = ptm_decoder if isinstance(ptm_decoder, dict) else {"raw": ptm_decoder}
    return check_callable(**arguments, options=options)


@pytest.fixture
def ptm_case(request, ptm_report):
    """A case. Its check() fails, passes or skips according to the verdict."""
    return Verdict(request.param, ptm_report)


class Verdict:
    """The verdict on a case."""

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
        # A fault that all images share is reported once, and undone before the cases are judged.
        common_faults = [remark["says"] for remark in self.report.data.get("remarks", []) if remark.get("failure")]
        if common_faults and outcome == "pass" and self.case["expect"] == "decode":
            pytest.fail("\n".join([self.id, *common_faults]), pytrace=False)
        if outcome in SKIPPED:
            pytest.skip("%s: %s" % (outcome, says))

    def causes(self):
        """Returns the causes of this failure in the report."""
        causes = self.report.data["diagnoses"]
        return ["The decoder %s. Fix: %s." % (cause["effect"], cause["fix"]) for cause in causes if self.id in cause["explains"]]
