"""pytest plugin: a test that takes long of a processor is listed, and one that takes 2.5 times as long fails the run.

Processor seconds of the test's process and of the processes that it ended count, for wall seconds grow with what else
the machine does. What fixtures of several tests take does not count for the one that needs them first.
"""

import os
from collections.abc import Generator

import pytest

LONGEST = 3.0  # s; a slower test is marked `validation`, unless a smaller job shows the same
FAILS = 2.5 * LONGEST  # cores that share caches and clock with other work take more than twice as long
_PROPERTY = "processor_seconds"

_slow: dict[str, float] = {}
_of_shared_fixtures, _depth, _start = 0.0, 0, 0.0


def _spent() -> float:
    return sum(os.times()[:4])  # user and system, of this process and of those that it waited for


@pytest.hookimpl(wrapper=True)
def pytest_fixture_setup(fixturedef: pytest.FixtureDef) -> Generator[None, object, object]:
    global _of_shared_fixtures, _depth
    if fixturedef.scope == "function":
        return (yield)
    before = _spent()
    _depth += 1
    try:
        return (yield)
    finally:
        _depth -= 1
        if not _depth:  # of a fixture that another asks for, once
            _of_shared_fixtures += _spent() - before


def pytest_runtest_logstart() -> None:
    global _of_shared_fixtures, _start
    _of_shared_fixtures, _start = 0.0, _spent()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(call: pytest.CallInfo) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    report = yield
    if call.when == "teardown":
        report.user_properties.append((_PROPERTY, _spent() - _start - _of_shared_fixtures))
    return report


def pytest_runtest_logreport(report: pytest.TestReport) -> None:
    for name, seconds in report.user_properties:
        if report.when == "teardown" and name == _PROPERTY and seconds > LONGEST:
            _slow[report.nodeid] = seconds


def pytest_sessionfinish(session: pytest.Session) -> None:
    if max(_slow.values(), default=0.0) > FAILS and session.exitstatus == pytest.ExitCode.OK:
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    if _slow:
        terminalreporter.section(f"tests over {LONGEST:g} s of a processor; over {FAILS:g} s the run fails")
        for name, seconds in sorted(_slow.items(), key=lambda item: -item[1]):
            terminalreporter.line(f"{seconds:6.1f} s  {name}")
