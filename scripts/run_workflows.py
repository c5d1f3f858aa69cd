#!/usr/bin/env python3
"""Runs the steps of action.yml and docs/*workflow*.yml on this machine, to test their shell scripts and conditions.

    scripts/run_workflows.py PROGRAM

PROGRAM is a built ptm-conform. Each workflow runs in a scratch repository with a decoder that makes a mistake, then once more, and
then with a correct decoder; the action runs with several inputs. The actions that the steps use (checkout, cache, upload) are
simulated in a local folder, and so are "git clone" and "cargo install", which provide PROGRAM. Nothing is downloaded. Exit status:
0 if every run ends as expected, or 1. It needs bash, curl and PyYAML.
"""

import hashlib
import os
import platform
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parent.parent

# "git clone … DIRECTORY" and "cargo install … --root DIRECTORY"; any other command is an error.
GIT = '#!/bin/sh\ntest "$1" = clone || exit 3\nfor last; do :; done\nmkdir "$last"\n'
CARGO = """#!/bin/sh
test "$1" = install || exit 3
while [ $# -gt 0 ]; do
  case $1 in
    --path) test -d "$2" || exit 4; shift ;;
    --root) mkdir -p "$2/bin" && cp "$LOCAL_PROGRAM" "$2/bin/ptm-conform"; exit ;;
  esac
  shift
done
exit 5
"""

RIGHT_DECODER = '#!/bin/sh\nexec "$LOCAL_PROGRAM" reference "$@"\n'
# It supports only the view raw, and adds 128 to all samples below 128, so that few calls are enough to find the mistake.
WRONG_DECODER = r"""#!/bin/sh
test "$1" = raw || exit 69
"$LOCAL_PROGRAM" reference "$@" > frame || exit $?
head -n 1 frame
tail -n +2 frame | tr '\000-\177' '\200-\377'
"""


class Expression:
    """Evaluates the expressions of GitHub Actions that the workflows use: names, strings, numbers, calls, !, ==, !=, && and ||."""

    TOKEN = re.compile(r"\s*('(?:[^']|'')*'|[\w.-]+(?:\(\))?|==|!=|&&|\|\||[!()])")

    def __init__(self, text, look_up):
        self.tokens = self.TOKEN.findall(text)
        if self.TOKEN.sub("", text).strip():
            raise ValueError("cannot read the expression %r" % text)
        self.look_up = look_up

    def value(self):
        value = self.either()
        if self.tokens:
            raise ValueError("unexpected %r in an expression" % self.tokens[0])
        return value

    def take(self, *wanted):
        return self.tokens.pop(0) if self.tokens and self.tokens[0] in wanted else None

    def either(self):
        value = self.both()
        while self.take("||"):
            other = self.both()
            value = value or other
        return value

    def both(self):
        value = self.comparison()
        while self.take("&&"):
            other = self.comparison()
            value = other if value else value
        return value

    def comparison(self):
        value = self.single()
        operator = self.take("==", "!=")
        if operator:
            value = (str(value) == str(self.single())) == (operator == "==")
        return value

    def single(self):
        if self.take("!"):
            return not self.single()
        if self.take("("):
            value = self.either()
            assert self.take(")"), "a parenthesis is not closed"
            return value
        token = self.tokens.pop(0)
        if token.startswith("'"):
            return token[1:-1].replace("''", "'")
        return int(token) if token.isdigit() else self.look_up(token)


class Runner:
    """Runs the steps of one job. Caches and artifacts are folders of the scratch directory."""

    def __init__(self, scratch, program, run_id, inputs=None, env=None):
        self.scratch, self.program, self.inputs = scratch, program, inputs or {}
        self.temp = scratch / ("temp-%d" % run_id)
        self.repository = scratch / ("repository-%d" % run_id)
        self.caches, self.artifacts = scratch / "caches", scratch / ("artifacts-%d" % run_id)
        for folder in (self.temp, self.repository, self.caches, self.artifacts):
            folder.mkdir(exist_ok=True)
        self.github = {
            "event_name": "push", "run_id": run_id, "run_number": run_id, "run_attempt": 1, "action_path": str(ROOT),
        }
        self.env, self.overrides = {}, env or {}
        self.path = [str(scratch / "bin"), os.environ["PATH"]]
        self.steps, self.failed, self.ran = {}, False, []

    def look_up(self, name):
        if name in ("always()", "success()", "failure()"):
            return {"always()": True, "success()": not self.failed, "failure()": self.failed}[name]
        runner = {"temp": str(self.temp), "os": "Linux", "arch": "X64"}
        places = {"github": self.github, "runner": runner, "env": self.env, "inputs": self.inputs, "steps": self.steps}
        value = places
        for part in name.split("."):
            # Steps and outputs that do not exist are empty; a misspelled context is an error.
            if value is places and part not in value:
                raise ValueError("unknown name %s" % name)
            value = value.get(part, "") if isinstance(value, dict) else ""
        return value

    def fill(self, text):
        """Replaces the expressions in a text."""
        def replace(match):
            value = Expression(match.group(1), self.look_up).value()
            return str(value).lower() if isinstance(value, bool) else str(value)
        return re.sub(r"\$\{\{(.*?)\}\}", replace, str(text))

    def applies(self, step):
        text = re.sub(r"\$\{\{(.*?)\}\}", r"\1", str(step.get("if", "success()")))
        is_status = any(call in text for call in ("always()", "success()", "failure()"))
        return bool(Expression(text, self.look_up).value()) and (is_status or not self.failed)

    def set_env(self, env):
        self.env.update({name: self.fill(value) for name, value in (env or {}).items()})
        self.env.update(self.overrides)

    def run(self, steps):
        """Runs all steps, and returns the name of the first one that fails, or None."""
        first_failure = None
        for step in steps:
            name = step.get("name") or step.get("uses", "").split("@")[0]
            state = {"outputs": {}, "outcome": "skipped"}
            if "id" in step:
                self.steps[step["id"]] = state
            if not self.applies(step):
                continue
            self.ran.append(name)
            succeeds = self.shell(step, state) if "run" in step else self.use(step, state)
            state["outcome"] = "success" if succeeds else "failure"
            if not succeeds:
                self.failed, first_failure = True, first_failure or name
        return first_failure

    def shell(self, step, state):
        output, path = self.temp / "output", self.temp / "path"
        for file in (output, path):
            file.write_text("")
        env = {name: value for name, value in os.environ.items() if not name.startswith(("GITHUB_", "RUNNER_"))}
        env.update(self.env)
        env.update({name: self.fill(value) for name, value in step.get("env", {}).items()})
        env.update({
            "PATH": os.pathsep.join(self.path), "RUNNER_TEMP": str(self.temp), "GITHUB_OUTPUT": str(output),
            "GITHUB_PATH": str(path), "GITHUB_STEP_SUMMARY": str(self.temp / "summary.md"),
            "LOCAL_PROGRAM": str(self.program), "PTM_CONFORM_RELEASES": "file://%s/releases" % self.scratch,
        })
        script = self.temp / "script.sh"
        script.write_text(self.fill(step["run"]))
        options = ["--noprofile", "--norc", "-eo", "pipefail"] if step.get("shell") == "bash" else ["-e"]
        call = subprocess.run(["bash", *options, str(script)], cwd=self.repository, env=env, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.log = call.stdout
        state["outputs"].update(line.split("=", 1) for line in output.read_text().splitlines() if "=" in line)
        self.path[:0] = path.read_text().split()
        return call.returncode == 0

    def use(self, step, state):
        action = step["uses"].split("@")[0]
        given = {name: self.fill(value) for name, value in step.get("with", {}).items()}
        if action == "actions/checkout":
            return True
        path = self.repository / given["path"]
        if action == "actions/upload-artifact":
            if path.exists():
                shutil.copytree(path, self.artifacts / given["name"])
            return True
        if not action.startswith("actions/cache"):
            raise ValueError("the action %s is not simulated" % action)
        exact = self.caches / given["key"]
        if action != "actions/cache/save":
            prefixes = given.get("restore-keys", "").split()
            others = sorted(self.caches.iterdir(), key=lambda cache: cache.stat().st_mtime_ns, reverse=True)
            others = [cache for cache in others if cache.name.startswith(tuple(prefixes))] if prefixes else []
            found = exact if exact.exists() else next(iter(others), None)
            if found:
                shutil.copytree(found, path, dirs_exist_ok=True)
            state["outputs"] = {
                "cache-primary-key": given["key"], "cache-hit": "true" if found == exact else "false" if found else "",
            }
        elif path.exists() and not exact.exists():
            shutil.copytree(path, exact)
            os.utime(exact)
        return True


class Trial:
    """Compares the outcomes of runs with the expected ones."""

    def __init__(self, program):
        self.program, self.faults = program, 0

    def scratch(self):
        scratch = Path(tempfile.mkdtemp(prefix="run-workflows-"))
        (scratch / "bin").mkdir()
        for name, text in (("git", GIT), ("cargo", CARGO)):
            write_program(scratch / "bin" / name, text)
        return scratch

    def expect(self, what, runner, failing, failure, ran=(), skipped=(), log=""):
        wrong = []
        if failure != failing:
            wrong.append("expected %s to fail, but %s failed" % (failing or "nothing", failure or "nothing"))
        wrong += ["step %r was not run" % name for name in ran if name not in runner.ran]
        wrong += ["step %r was run" % name for name in skipped if name in runner.ran]
        print("%s %s" % ("FAIL" if wrong else "ok  ", what))
        for line in wrong:
            print("     " + line)
        if wrong:
            print(getattr(runner, "log", ""))
            self.faults += 1

    def expect_file(self, what, path, exists=True):
        if path.exists() != exists:
            print("FAIL %s: %s %s" % (what, path.name, "is missing" if exists else "exists"))
            self.faults += 1


def write_program(path, text):
    path.write_text(text)
    path.chmod(0o755)


def pack_release(scratch, program, version):
    """Creates the archive of a release, as the action downloads it."""
    machine = "aarch64" if platform.machine() in ("aarch64", "arm64") else "x86_64"
    target = "%s-%s" % (machine, "apple-darwin" if sys.platform == "darwin" else "unknown-linux-musl")
    name, folder = "ptm-conform-v%s-%s" % (version, target), scratch / "releases" / ("v" + version)
    folder.mkdir(parents=True)
    archive = folder / (name + ".tar.gz")
    with tarfile.open(archive, "w:gz", compresslevel=1) as tar:
        tar.add(program, name + "/ptm-conform")
    digest = hashlib.sha256(archive.read_bytes()).hexdigest()
    (folder / "SHA256SUMS").write_text("%s  %s\n" % (digest, archive.name))


def run_action(trial):
    action = yaml.safe_load((ROOT / "action.yml").read_text())
    defaults = {name: str(about.get("default", "")) for name, about in action["inputs"].items()}
    scratch = trial.scratch()
    pack_release(scratch, trial.program, defaults["version"])
    smoke = {"args": "--case hand-*", "decoder": "./my-decoder"}
    local = dict(smoke, program=str(trial.program))
    download, compile_, check = "Download the release", "Compile ptm-conform", "Check the decoder"
    trials = [
        ("with a local program", local, RIGHT_DECODER, None, [check], [download, compile_]),
        ("with a release", smoke, RIGHT_DECODER, None, [download, check], [compile_]),
        ("with a cached release", smoke, RIGHT_DECODER, None, [download, check], [compile_]),
        ("with cargo", dict(smoke, compile="true"), RIGHT_DECODER, None, [compile_, check], [download]),
        ("with a wrong decoder", dict(local, args="--case first-*"), WRONG_DECODER, check, ["Upload the report"], []),
        ("without a decoder", dict(local, decoder=""), RIGHT_DECODER, check, [], []),
    ]
    for number, (what, inputs, decoder, failing, ran, skipped) in enumerate(trials):
        runner = Runner(scratch, trial.program, number, dict(defaults, **inputs))
        write_program(runner.repository / "my-decoder", decoder)
        failure = runner.run(action["runs"]["steps"])
        trial.expect("action.yml " + what, runner, failing, failure, ran, skipped)
        if what != "without a decoder":
            trial.expect_file("action.yml " + what, runner.artifacts / "ptm-conform-report" / "report.html")
    shutil.rmtree(scratch)


def run_workflow(trial, path):
    workflow = yaml.safe_load(path.read_text())
    scratch = trial.scratch()
    install, earlier, fuzz = "Install ptm-conform", "Check earlier findings", "Fuzz"
    trials = [
        ("with a right decoder", RIGHT_DECODER, None, [install, fuzz], []),
        ("with a wrong decoder", WRONG_DECODER, fuzz, ["Save the findings"], [install]),
        ("with the same mistake", WRONG_DECODER, earlier, ["Save the findings"], [install, fuzz]),
        ("with the mistake fixed", RIGHT_DECODER, None, [earlier, fuzz], [install]),
        ("with a decoder that is not built", None, "Build your decoder", [], [earlier, "Save the findings"]),
    ]
    for number, (what, decoder, failing, ran, skipped) in enumerate(trials, 1):
        # On a busy machine, the initial checks may take several seconds.
        seconds = "30" if failing == fuzz else "2"
        runner = Runner(scratch, trial.program, number, env={"FUZZ_SECONDS": seconds, "SEED": "7"})
        (runner.repository / "Makefile").write_text("my-decoder: source\n\tcp source my-decoder\n\tchmod +x my-decoder\n")
        if decoder:
            (runner.repository / "source").write_text(decoder)
        runner.set_env(workflow.get("env"))
        for job in workflow["jobs"].values():
            failure = runner.run(job["steps"])
            trial.expect("%s %s" % (path.name, what), runner, failing, failure, ran, skipped)
        has_finds = any(runner.artifacts.glob("finds/*.ptm"))
        if has_finds != (failing in (earlier, fuzz)):
            print("FAIL %s %s: the artifact has %s findings" % (path.name, what, "the" if has_finds else "no"))
            trial.faults += 1
    shutil.rmtree(scratch)


def main():
    trial = Trial(Path(sys.argv[1]).resolve())
    run_action(trial)
    for path in sorted((ROOT / "docs").glob("*workflow*.yml")):
        run_workflow(trial, path)
    sys.exit(1 if trial.faults else 0)


if __name__ == "__main__":
    main()
