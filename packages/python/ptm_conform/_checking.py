"""Runs the suite against functions of this process.

The program requests views of files over a socket and receives the results of the function. It compares, judges and searches
for causes as for any other decoder, so the verdicts are those of `ptm-conform check`.
"""

import dataclasses
import json
import os
import socket
import subprocess
import tempfile

from ._program import Malformed, Unsupported, program

CHANNEL_TYPES = {"raw": "u1", "coef": "<f4", "rgb": "u1"}


@dataclasses.dataclass(frozen=True)
class Case:
    """The verdict on one case."""

    id: str
    #: pass, fail, unsupported, inconclusive, not judged or not run
    outcome: str
    clauses: list
    #: why, where there is something to say
    says: str


@dataclasses.dataclass(frozen=True)
class Report:
    """What `ptm-conform check` says of a decoder."""

    #: exit status of the program: 0 passes, 1 fails, 3 is not a decoder
    status: int
    #: what it prints: causes, examples, scores
    text: str
    #: the whole report, as spec-cases/schema/report.schema.json describes it
    data: dict

    @property
    def passed(self):
        """Whether no case failed and at least one file was decoded."""
        return self.status == 0

    @property
    def causes(self):
        """The misreadings that explain the failures, most telling first."""
        return [cause["misreading"] for cause in self.data["diagnoses"] if "misreading" in cause]

    @property
    def cases(self):
        """The verdict on each case, by its id."""
        return {
            case["id"]: Case(case["id"], case["outcome"], case["clauses"], case.get("says", ""))
            for case in self.data["cases"]
        }


def check_callable(raw=None, *, coef=None, rgb=None, malformed=Malformed, unsupported=Unsupported, options=()):
    """Runs the suite against functions, and returns a Report.

    `raw(file)` and `coef(file)` take the bytes of a file and return an array of (height, width, channels), top row first:
    the stored values as uint8, the final coefficients as floats. `rgb(file, lu, lv)` returns the image under a light as
    uint8. One of them is enough. `malformed` and `unsupported` are the exceptions by which they refuse a file and say that
    they do not read its kind; any other exception is a crash. `options` are options of `ptm-conform check`, for example
    ["--smoke"]. A function has no time limit and runs in this process: if it does not return, or crashes the
    interpreter, so does this call.
    """
    if not hasattr(socket, "AF_UNIX"):
        raise RuntimeError("check_callable needs Linux or macOS, as ptm-conform check does")
    functions = {"raw": raw, "coef": coef, "rgb": rgb}
    if not any(functions.values()):
        raise TypeError("check_callable needs raw, coef or rgb")
    answer = _Answer(functions, malformed, unsupported)
    # The name of a socket may have some hundred bytes.
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
                raise RuntimeError(errors.read().strip() or "ptm-conform ended with %d" % status)
        with open(paths["text"], encoding="utf-8") as text, open(paths["json"], "rb") as data:
            lines = [line for line in text if not line.startswith("report: ")]
            return Report(status, "".join(lines), json.load(data))


def _serve(listener, run, answer):
    """Answers until the program asks no more. Returns if it ends without asking."""
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
    """What the functions do with a request, as a word and what belongs to it."""

    def __init__(self, functions, malformed, unsupported):
        self.functions = functions
        self.malformed = malformed
        self.unsupported = unsupported

    def __call__(self, view, file):
        name, _, light = view.partition(":")
        function = self.functions[name]
        if function is None:
            return b"unsupported", b""
        try:
            value = function(file, *map(float, light.split(","))) if light else function(file)
        except self.malformed as what:
            return b"reject", _message(what)
        except self.unsupported as what:
            return b"unsupported", _message(what)
        except Exception as what:
            hint = b"; if that means a malformed file, pass malformed=" + type(what).__name__.encode()
            return b"crash", _message(what) + hint
        try:
            return b"ok", _frame(name, value)
        except TypeError as what:
            return b"error", str(what).encode()


def _message(what):
    return ("%s: %s" % (type(what).__name__, what)).encode(errors="replace")[:4000]


def _frame(view, value):
    """An array as a frame; bytes are read as a frame, a NumPy file or an image."""
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
