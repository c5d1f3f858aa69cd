"""Runs the suite against functions of this process.

The program requests views of files over a socket and receives the results of the function. It compares, judges and searches
for causes as for any other decoder, so the verdicts are those of `ptm-conform check`.
"""

import collections
import dataclasses
import json
import os
import socket
import subprocess
import tempfile
import traceback

from ._program import Malformed, Unsupported, program

#: Classes that say nothing about a file.
CATCH_ALL = (BaseException, Exception)

CHANNEL_TYPES = {"raw": "u1", "coef": "<f4", "rgb": "u1"}


@dataclasses.dataclass(frozen=True)
class Case:
    """The verdict on one case."""

    id: str
    #: pass, fail, unsupported, inconclusive, not judged or not run
    outcome: str
    clauses: list
    #: the reason, or an empty string
    says: str


@dataclasses.dataclass(frozen=True)
class Report:
    """The result of `ptm-conform check` for a decoder."""

    #: exit status of the program: 0 passed, 1 failed, 3 not a decoder
    status: int
    #: advice, and the output of the program: causes, examples and scores
    text: str
    #: whole report, in the format of spec-cases/schema/report.schema.json
    data: dict
    #: how to declare exceptions that counted as crashes, or an empty string
    advice: str = ""

    @property
    def passed(self):
        """True if no case failed and at least one file was decoded."""
        return self.status == 0

    @property
    def causes(self):
        """The names of misreadings that explain failures, most important first; `data["diagnoses"]` has the other causes, too."""
        return [cause["misreading"] for cause in self.data["diagnoses"] if "misreading" in cause]

    @property
    def cases(self):
        """The verdicts by case id."""
        return {
            case["id"]: Case(case["id"], case["outcome"], case["clauses"], case.get("says", ""))
            for case in self.data["cases"]
        }


def check_callable(raw=None, *, coef=None, rgb=None, malformed=Malformed, unsupported=Unsupported, options=()):
    """Runs the suite against functions and returns a Report.

    `raw(file)` and `coef(file)` take the bytes of a file and return an array of shape (height, width, channels), top row
    first: the stored values as uint8, and the final coefficients as floats. `rgb(file, lu, lv)` returns the image under a
    light as uint8. One function is enough. The functions raise `malformed` for a malformed file and `unsupported` for a kind
    of file that they do not support; of an exception that is both, its most specific class counts. Any other exception counts as a
    crash. `options` are options of `ptm-conform check`,
    such as ["--smoke"]. The functions run in this process without a time limit: if one runs forever or crashes the interpreter, so
    does this call.
    """
    if not hasattr(socket, "AF_UNIX"):
        raise RuntimeError("check_callable needs Linux or macOS, like ptm-conform check")
    functions = {"raw": raw, "coef": coef, "rgb": rgb}
    if not any(functions.values()):
        raise TypeError("check_callable needs raw, coef or rgb")
    for name, classes in (("malformed", malformed), ("unsupported", unsupported)):
        for kind in _as_tuple(classes):
            if kind in CATCH_ALL:
                raise TypeError(
                    "%s=%s is the class of nearly every error, so an accidental error would count as a refusal; "
                    "define a class of your own, and raise it for %s files" % (name, kind.__name__, name)
                )
    answer = _Answer(functions, malformed, unsupported)
    # The path of a socket is limited to about a hundred bytes.
    short = None if len(tempfile.gettempdir()) < 60 else "/tmp"
    with tempfile.TemporaryDirectory(prefix="ptm-", dir=short) as directory:
        paths = {name: os.path.join(directory, name) for name in ("socket", "yaml", "json", "text", "errors")}
        with socket.socket(socket.AF_UNIX) as listener, open(paths["text"], "wb") as text, open(paths["errors"], "wb") as errors:
            listener.bind(paths["socket"])
            listener.listen(1)
            command = [program(), "check", "--caller", paths["socket"], "--report", paths["yaml"], "--json", paths["json"], *options]
            run = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=text, stderr=errors)
            try:
                _serve(listener, run, answer)
                status = run.wait()
            finally:
                run.kill()
                run.wait()
        if not os.path.exists(paths["json"]):
            with open(paths["errors"], encoding="utf-8", errors="replace") as errors:
                raise RuntimeError(errors.read().strip() or "ptm-conform exited with %d" % status)
        with open(paths["text"], encoding="utf-8") as text, open(paths["json"], "rb") as data:
            lines = [line for line in text if not line.startswith("report: ")]
            data = json.load(data)
            advice = answer.advice(data)
            return Report(status, advice + "".join(lines), data, advice)


def _serve(listener, run, answer):
    """Answers requests until the program closes the connection, or exits without connecting."""
    listener.settimeout(0.1)
    while True:
        try:
            connection, _ = listener.accept()
            break
        except socket.timeout:
            if run.poll() is not None:
                return
    connection.settimeout(None)
    with connection, connection.makefile("rb") as requests:
        for line in requests:
            _, view, length = line.split(b" ")
            word, data = answer(view.decode(), requests.read(int(length)))
            connection.sendall(b"%s %d\n%s" % (word, len(data), data))


class _Answer:
    """Answers requests with the functions. An answer consists of a word and its data."""

    def __init__(self, functions, malformed, unsupported):
        self.functions = functions
        self.malformed = malformed
        self.unsupported = unsupported
        #: undeclared exceptions by class
        self.crashes = collections.Counter()

    def __call__(self, view, file):
        name, _, light = view.partition(":")
        function = self.functions[name]
        if function is None:
            return b"unsupported", b""
        try:
            value = function(file, *map(float, light.split(","))) if light else function(file)
        except Exception as what:
            malformed, unsupported = _specificity(what, self.malformed), _specificity(what, self.unsupported)
            if malformed == unsupported == 0:
                self.crashes[type(what)] += 1
                return b"crash", _message(what, is_declared=False)
            return (b"reject" if malformed >= unsupported else b"unsupported"), _message(what)
        try:
            return b"ok", _frame(name, value)
        except TypeError as what:
            return b"error", str(what).encode()

    def advice(self, report):
        """Says how to declare the exceptions that were not caught."""
        lines = []
        for kind, count in self.crashes.most_common(3):
            start = kind.__name__ + ":"
            expected = [case["expect"] for case in report["cases"] if case.get("stderr", "").startswith(start)]
            means = "unsupported" if 2 * expected.count("decode") > len(expected) else "malformed"
            lines.append("%s was raised %d times and counts as a crash; if it means a file that is %s, pass %s=%s\n" % (kind.__name__, count, means, means, kind.__name__))
        return "".join(lines)


def _as_tuple(classes):
    return classes if isinstance(classes, tuple) else (classes,)


def _specificity(what, classes):
    """Returns the depth of the most specific of these classes in the class tree, or 0 if the exception belongs to none of them."""
    return max((len(kind.__mro__) for kind in _as_tuple(classes) if isinstance(what, kind)), default=0)


def _message(what, is_declared=True):
    """Describes an exception. Undeclared exceptions of the same class have the same last line, because they have one cause."""
    name = type(what).__name__
    message = "%s: %s%s" % (name, what, _place(what))
    if not is_declared and type(what).__module__ != "builtins":
        message += "\n%s is declared neither as malformed nor as unsupported" % name
    return message.encode(errors="replace")[-4000:]


def _place(what):
    """Returns the file and line at which the caller's code raised an exception or called what raised it."""
    frames = traceback.extract_tb(what.__traceback__)[1:]
    own = [frame for frame in frames if "-packages" not in frame.filename] or frames
    return " (%s:%d)" % (os.path.basename(own[-1].filename), own[-1].lineno) if own else ""


def _frame(view, value):
    """Converts an array to a frame. Bytes may already be a frame, a NumPy file or an image."""
    if isinstance(value, (bytes, bytearray)):
        return bytes(value)
    if not hasattr(value, "__array__"):
        raise TypeError("it returned %s, not an array" % type(value).__name__)
    import numpy

    array, wanted = numpy.asarray(value), numpy.dtype(CHANNEL_TYPES[view])
    if array.ndim != 3:
        raise TypeError("its array has the shape %s, not (height, width, channels)" % (array.shape,))
    if array.dtype != wanted and not (view == "coef" and array.dtype.kind == "f"):
        raise TypeError("its array is of %s; %s is %s" % (array.dtype, view, wanted.name))
    with numpy.errstate(all="ignore"):
        samples = array.astype(wanted, copy=False).tobytes()
    height, width, channels = array.shape
    kind = "f32" if view == "coef" else "u8"
    return b"PTM1 %s %d %d %d %s\n%s" % (view.encode(), width, height, channels, kind.encode(), samples)
