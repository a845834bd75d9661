"""Checks a manifest of two Jobs against Kubernetes' schemas and runs their containers' commands on this machine: an index to
each pod, one pod stopped and one killed on the way, replaced as the manifest says. `pods.py MANIFEST`."""

import os
import re
import signal
import subprocess
import sys
import time

import kubernetes_validate
import yaml

VERSIONS = ["1.29", kubernetes_validate.latest_version()]


def check(manifest):
    for version in VERSIONS:
        kubernetes_validate.validate(manifest, version, strict=True)
        # A check that lets everything pass would prove nothing.
        wrong = {**manifest, "spec": {**manifest["spec"], "backoffLimitPerIndx": 1}}
        try:
            kubernetes_validate.validate(wrong, version, strict=True)
        except kubernetes_validate.ValidationError:
            continue
        sys.exit(f"the schemas of {version} take a misspelt key")


def command_of(container):
    """As Kubernetes expands it: `$$` is `$`, `$(NAME)` a variable of the container's, left as it is if there is none."""
    expand = lambda text: re.sub(r"\$\$|\$\([^)]*\)", lambda found: "$" if found[0] == "$$" else found[0], text)
    return [expand(word) for word in container["command"]]


class Pods:
    def __init__(self, manifest):
        self.spec = manifest["spec"]
        (self.container,) = self.spec["template"]["spec"]["containers"]

    def start(self, index=None):
        environment = {"PATH": os.environ["PATH"]}
        if index is not None:
            environment["JOB_COMPLETION_INDEX"] = str(index)
        log = open(f"{self.container['workingDir']}/pods.out", "a")
        return subprocess.Popen(
            command_of(self.container), cwd=self.container["workingDir"], env=environment, stdout=log, stderr=log
        )

    def action(self, code):
        """What the Job does about a pod that ended so."""
        for rule in self.spec["podFailurePolicy"]["rules"]:
            if code in rule.get("onExitCodes", {}).get("values", []):
                return rule["action"]
        return "Count"

    def run_index(self, index, disturb):
        """Runs pods for an index until one succeeds; the first is sent a signal once it has rows. Returns what happened."""
        happened = []
        failures = 0
        while True:
            pod = self.start(index)
            try:
                if disturb is not None:
                    self.wait_for_rows(index, pod)
                    pod.send_signal(disturb)
                    disturb = None
                code = pod.wait()
            finally:
                pod.kill()
            if code == 0:
                return happened + ["done"]
            # A container that dies by a signal has the code 128 and its number.
            code = code if code > 0 else 128 - code
            action = self.action(code)
            happened.append(f"{code}: {action}")
            failures += action == "Count"
            if action == "FailJob" or failures > self.spec["backoffLimitPerIndex"]:
                sys.exit(f"shard {index} failed: {happened}")

    def wait_for_rows(self, index, pod):
        command = command_of(self.container)
        out = command[command.index("--out") + 1]
        journal = f"{self.container['workingDir']}/{out}/shard-{index}-of-{self.spec['completions']}/counts.journal"
        first = None
        while pod.poll() is None:
            if os.path.exists(journal):
                with open(journal, "rb") as file:
                    now = file.read()
                first = first or now
                if now != first:
                    return
            time.sleep(0.1)
        sys.exit(f"shard {index} ended with {pod.returncode} before it could be disturbed")


def main():
    with open(sys.argv[1]) as file:
        sweep, merge = yaml.safe_load_all(file)
    for manifest in (sweep, merge):
        check(manifest)
    print(f"schemas of Kubernetes {' and '.join(VERSIONS)}: as they say", file=sys.stderr)

    pods = Pods(sweep)
    assert sweep["spec"]["completions"] == 3 and sweep["spec"]["completionMode"] == "Indexed"
    for index, disturb, expected in [
        (0, signal.SIGTERM, ["75: Ignore", "done"]),
        (1, signal.SIGKILL, ["137: Count", "done"]),
        (2, None, ["done"]),
    ]:
        happened = pods.run_index(index, disturb)
        print(f"shard {index}: {', '.join(happened)}", file=sys.stderr)
        assert happened == expected, f"expected {expected}"

    assert merge["spec"]["suspend"] is True
    code = Pods(merge).start().wait()
    assert code == 0, f"the merge ended with {code}"


signal.signal(signal.SIGTERM, lambda number, frame: sys.exit(143))
main()
