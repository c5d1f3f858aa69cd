"""Pytest plugin with one test for each case of the suite.

    # test_ptm.py
    @pytest.fixture(scope="session")
    def ptm_decoder():
        return my_decoder.decode            # or the arguments of check_callable: {"raw": …, "malformed": …, "options": …}

    def test_ptm(ptm_case):
        ptm_case.check()

The suite runs once, before the first of these tests. With `-k` or a test id, only the selected cases run. With pytest-xdist, every
worker runs it. `--ptm-baseline FILE` expects the failures in a list (of `ptm-conform check --write-baseline`): a listed case that
passes fails its test.
"""

import collections
import json
import os
import re

import pytest

from . import check_callable

#: Why cases of an unsupported format are not in the report.
NOT_ASKED = "not asked: the decoder reads none of the first files of this kind"

#: Name of the property of a failed test that holds a cause.
CAUSE = "ptm_cause"

#: Where the session keeps the known failures, and the advice about undeclared exceptions.
KNOWN, ADVICE = pytest.StashKey(), pytest.StashKey()


def case_ids():
    """Returns all case ids in the order of the suite."""
    with open(os.path.join(os.path.dirname(__file__), "cases.json"), encoding="utf-8") as file:
        return json.load(file)


def known_failures(path):
    """Returns the reasons of a list of known failures by case id. The list has entries "- id: CASE", with an optional "reason: TEXT"."""
    known, last = {}, None
    try:
        file = open(path, encoding="utf-8")
    except OSError as what:
        raise pytest.UsageError("--ptm-baseline: %s" % what) from what
    with file:
        for number, line in enumerate(file, 1):
            if not line.strip() or line.lstrip().startswith("#") or line.strip() == "[]":
                continue
            entry = re.fullmatch(r"- id: *['\"]?([a-z0-9-]+)['\"]?\s*", line)
            reason = re.fullmatch(r"  reason: *(.*?)\s*", line)
            if entry:
                last = entry[1]
                if last in known:
                    raise pytest.UsageError("%s, line %d: %s is listed twice" % (path, number, last))
                known[last] = "known failure"
            elif reason and last:
                known[last] = reason[1].strip("'\"")
            else:
                raise pytest.UsageError("%s, line %d: expected `- id: CASE` or `  reason: TEXT`" % (path, number))
    unknown = sorted(set(known) - set(case_ids()))
    if unknown:
        raise pytest.UsageError("%s: no case is named %s" % (path, unknown[0]))
    return known


def pytest_addoption(parser):
    group = parser.getgroup("ptm-conform")
    group.addoption("--ptm-baseline", metavar="FILE", help="known failures, as written by ptm-conform check --write-baseline; they are expected to fail")


def pytest_configure(config):
    path = config.getoption("--ptm-baseline")
    config.stash[KNOWN] = known_failures(path) if path else {}


def pytest_generate_tests(metafunc):
    if "ptm_case" in metafunc.fixturenames:
        metafunc.parametrize("ptm_case", case_ids(), indirect=True)


@pytest.fixture(scope="session")
def ptm_report(request, ptm_decoder):
    """The Report on `ptm_decoder` for the cases of this session."""
    named = [item.callspec.params["ptm_case"] for item in request.session.items if "ptm_case" in getattr(getattr(item, "callspec", None), "params", {})]
    named = sorted(set(named))
    selected = [] if len(named) in (0, len(case_ids())) else [word for id in named for word in ("--case", id)]
    arguments = dict(ptm_decoder) if isinstance(ptm_decoder, dict) else {"raw": ptm_decoder}
    options = [*arguments.pop("options", ()), *selected]
    report = check_callable(**arguments, options=options)
    request.config.stash[ADVICE] = report.advice
    return report


@pytest.fixture
def ptm_case(request, ptm_report):
    """A case. Its check() fails, passes or skips according to the verdict."""
    return Verdict(request.param, ptm_report, request.config.stash[KNOWN], request.node)


class Verdict:
    """The verdict on a case."""

    def __init__(self, id, report, known, test):
        self.id = id
        self.report = report
        self.known = known
        self.test = test
        self.case = next((case for case in report.data["cases"] if case["id"] == id), None)

    def check(self):
        if self.report.status == 3:
            self.fail(self.report.data["reason"], [self.report.data["reason"]])
        if self.case is None:
            pytest.skip(NOT_ASKED)
        outcome, says, causes = self.case["outcome"], self.case.get("says", ""), self.causes()
        # A fault that all images share is reported once, and undone before the cases are judged.
        common_faults = [remark["says"] for remark in self.report.data.get("remarks", []) if remark.get("failure")]
        if common_faults and outcome == "pass" and self.case["expect"] == "decode":
            outcome, says, causes = "fail", common_faults[0], common_faults
        if outcome == "fail" and self.id in self.known:
            pytest.xfail("%s: %s" % (self.known[self.id], says))
        if outcome == "fail":
            self.fail(says, causes)
        if outcome != "pass":
            pytest.skip("%s: %s" % (outcome, says) if says else outcome)
        if self.id in self.known:
            reason = "known failures that pass; remove them from %s" % self.test.config.getoption("--ptm-baseline")
            self.fail(reason, [reason])

    def fail(self, reason, causes):
        """Fails the test. The first line is the reason, which the summary of pytest shows."""
        self.test.user_properties.extend((CAUSE, cause) for cause in causes or ["unexplained"])
        clauses = ", ".join(self.case["clauses"]) if self.case else ""
        pytest.fail("\n".join([reason, "%s (%s)" % (self.id, clauses), *(cause for cause in causes if cause != reason)]), pytrace=False)

    def causes(self):
        """Returns the causes of this failure in the report."""
        causes = self.report.data["diagnoses"]
        return ["The decoder %s. Fix: %s." % (cause["effect"], cause["fix"]) for cause in causes if self.id in cause["explains"]]


def pytest_terminal_summary(terminalreporter):
    """Lists the causes of the failures, the most frequent first."""
    failed = terminalreporter.stats.get("failed", [])
    causes = collections.Counter(value for report in failed for name, value in report.user_properties if name == CAUSE)
    if causes:
        terminalreporter.section("causes of PTM failures")
        for cause, count in causes.most_common():
            terminalreporter.write_line("%d of %d: %s" % (count, len(failed), cause))
        terminalreporter.write(terminalreporter.config.stash.get(ADVICE, ""))
