#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Independent judges of the Kubernetes manifests.

  manifests.py VDRIVED WORK

`kubectl kustomize` renders each overlay of deploy/kubernetes, and packages of npm (versions fixed
by the lock file) compare all documents with the schemas of Kubernetes. This program checks what no
schema covers: every name refers to something that exists, `vdrived --check` accepts each
configuration, and the pods that pods.py makes for podman are those of the manifests. WORK is a
directory for the npm packages. Exit code 0: all agree; 77: a judge is missing (no kubectl, no node,
no registry).
"""
import pathlib
import re
import shutil
import subprocess
import sys

import yaml

from gateway import HERE, fail, install, skip

MANIFESTS = HERE.parents[1] / "deploy/kubernetes"
sys.path.insert(0, str(MANIFESTS))
import pods  # noqa: E402
OVERLAYS = ("lab", "cluster", "closed", "monitor")
# Mistakes that a reader overlooks: the text in the lab's manifests, its replacement, and the
# judge's message.
MISTAKES = (
    ("readinessProbe:", "readynessProbe:", "'\"readynessProbe\"' does not exist"),
    ("clusterIP: None", "clusterIp: None", "'\"clusterIp\"' does not exist"),
    ("containerPort: 9464", "containerPort: metrics", "containerPort must be integer"),
    ("maxUnavailable: 1", "maxUnavailable: [1]", "maxUnavailable must be string"),
    ("apiVersion: policy/v1", "apiVersion: policy/v2", "policy/v2"),
)


def render(overlay):
    done = subprocess.run(["kubectl", "kustomize", MANIFESTS / "bench" / overlay],
                          capture_output=True, text=True, timeout=60)
    if done.returncode != 0:
        fail(f"{overlay}: {done.stderr.strip()}")
    return done.stdout


def judge(work, *files):
    """Returns the judge's output, and whether it agrees."""
    done = subprocess.run(["node", "judge.mjs", *files], cwd=work, capture_output=True, text=True,
                          timeout=120)
    return done.stdout + done.stderr, done.returncode == 0


def check_mistakes(work, lab):
    for right, wrong, expected in MISTAKES:
        if right not in lab:
            fail(f"'{right}' is not in the manifests of the lab")
        (work / "mistake.yaml").write_text(lab.replace(right, wrong, 1))
        text, agrees = judge(work, "mistake.yaml")
        if agrees or expected not in text:
            fail(f"'{wrong}' in the place of '{right}': {text}")


class Fleet:
    """The documents of an overlay, and the names that they refer to."""

    def __init__(self, name, text, vdrived, work):
        self.name = name
        self.documents = list(yaml.safe_load_all(text))
        self.vdrived = vdrived
        self.work = work
        self.sets = [d for d in self.documents if d["kind"] in ("StatefulSet", "Deployment")]
        self.pods = {f"{d['metadata']['name']}-{i}.{d['spec']['serviceName']}"
                     for d in self.of("StatefulSet")
                     for i in range(first(d), first(d) + d["spec"]["replicas"])}

    def of(self, kind):
        return [d for d in self.documents if d["kind"] == kind]

    def expect(self, condition, text):
        if not condition:
            fail(f"{self.name}: {text}")

    def selected(self, document, labels):
        """The sets whose pods are selected by a document."""
        found = [s for s in self.sets
                 if labels.items() <= s["spec"]["template"]["metadata"]["labels"].items()]
        self.expect(found, f"{document['kind']} {document['metadata']['name']} selects no pod")
        return found

    def check_names(self, text):
        """The names of pods in a configuration or an argument."""
        names = re.findall(r"\bvdrive-[a-z]+-\d+\.[a-z-]+", text)
        for name in names:
            self.expect(name in self.pods, f"{name} is none of {sorted(self.pods)}")
        return names

    def check(self):
        maps = {d["metadata"]["name"]: d["data"] for d in self.of("ConfigMap")}
        services = {d["metadata"]["name"]: d for d in self.of("Service")}
        for each in self.of("StatefulSet"):
            service = services.get(each["spec"]["serviceName"], {"spec": {}})
            self.expect(service["spec"].get("clusterIP") == "None"
                        and service["spec"].get("publishNotReadyAddresses"),
                        f"{each['metadata']['name']} has no headless Service")
        for service in services.values():
            ports = {p["name"] for s in self.selected(service, service["spec"]["selector"])
                     for c in s["spec"]["template"]["spec"]["containers"] for p in c.get("ports", [])}
            for port in service["spec"].get("ports", []):
                self.expect(port["targetPort"] in ports, f"no pod has the port {port['targetPort']}")
        for budget in self.of("PodDisruptionBudget"):
            self.selected(budget, budget["spec"]["selector"]["matchLabels"])
        for policy in self.of("NetworkPolicy"):
            found = self.selected(policy, policy["spec"]["podSelector"]["matchLabels"])
            self.expect(len(found) == len(self.sets), "the NetworkPolicy leaves pods out")
        named = []
        for each in self.sets:
            self.expect(self.selected(each, each["spec"]["selector"]["matchLabels"]) == [each],
                        f"{each['metadata']['name']} selects other pods than its own")
            pod = each["spec"]["template"]["spec"]
            volumes = {v["name"]: v for v in pod.get("volumes", [])}
            for container in pod["containers"]:
                for argument in container.get("args", []):
                    named += self.check_names(argument)
                for mount in container.get("volumeMounts", []):
                    self.expect(mount["name"] in volumes, f"no volume {mount['name']}")
            for volume in volumes.values():
                if "configMap" in volume:
                    self.expect(volume["configMap"]["name"] in maps, f"no ConfigMap of {volume}")
        for data in maps.values():
            named += self.check_names(data["vdrived.yaml"])
            self.check_configuration(data["vdrived.yaml"])
        self.expect(not self.sets or named, "nobody names a server or a peer")

    def made_pods(self):
        """The pods made by pods.py, by network name."""
        secrets = {v["secret"]["secretName"] for s in self.sets
                   for v in s["spec"]["template"]["spec"].get("volumes", []) if "secret" in v}
        return dict(pods.pods_of([*self.documents, *(
            {"kind": "Secret", "metadata": {"name": name}, "data": {}} for name in secrets)]))

    def check_pods(self):
        made = self.made_pods()
        single = {d["metadata"]["name"] for d in self.of("Deployment")}
        self.expect(made.keys() == self.pods | single, f"pods.py makes {sorted(made)}")
        for each in self.sets:
            name, template = each["metadata"]["name"], each["spec"]["template"]
            for alias, documents in made.items():
                pod = documents[-1]
                index = re.fullmatch(rf"{name}(?:-(\d+)\..*)?", alias)
                if index:
                    self.expect(pod["metadata"]["labels"].get("apps.kubernetes.io/pod-index")
                                == index[1], f"{alias} has another index")
                    self.check_pod(alias, pod["spec"], template["spec"])

    def check_pod(self, alias, pod, template):
        """Everything except the differences documented in pods.py."""
        def rest(of, *left_out):
            return {key: value for key, value in of.items() if key not in left_out}

        def paths(container):
            return [rest(mount, "name") for mount in container.get("volumeMounts", [])]
        self.expect(rest(pod, "containers", "volumes") == rest(template, "containers", "volumes"),
                    f"{alias}: pods.py makes {pod}")
        for ours, theirs in zip(pod["containers"], template["containers"], strict=True):
            differs = ("ports", "volumeMounts", "livenessProbe", "readinessProbe")
            self.expect(rest(ours, *differs) == rest(theirs, *differs),
                        f"{alias}: pods.py makes {ours}")
            self.expect(paths(ours) == paths(theirs), f"{alias}: pods.py mounts {paths(ours)}")
            mounted = {mount["name"] for mount in ours.get("volumeMounts", [])}
            self.expect(mounted == {v["name"] for v in pod["volumes"]},
                        f"{alias}: pods.py makes the volumes {pod['volumes']}")

    def check_configuration(self, text):
        """Only the credentials of closed mode may be missing."""
        (self.work / "vdrived.yaml").write_text(text)
        done = subprocess.run([self.vdrived, "--check", self.work / "vdrived.yaml"],
                              capture_output=True, text=True, timeout=60)
        missing = "/etc/vdrive-security/identity_ca.pem: cannot be read"
        is_closed = "security:" in text
        self.expect(missing in done.stderr if is_closed else done.returncode == 0,
                    f"vdrived --check: {done.stdout}{done.stderr}")


def first(stateful_set):
    return stateful_set["spec"].get("ordinals", {}).get("start", 0)


def main():
    vdrived, work = sys.argv[1:]
    work = pathlib.Path(work)
    if not shutil.which("kubectl"):
        skip("kubectl is not installed")
    install(work, "manifests")
    rendered = {overlay: render(overlay) for overlay in OVERLAYS}
    for overlay, text in rendered.items():
        (work / f"{overlay}.yaml").write_text(text)
    files = [f"{overlay}.yaml" for overlay in OVERLAYS] + sorted((MANIFESTS / "tests").glob("*.yaml"))
    text, agrees = judge(work, *files)
    if not agrees:
        fail(text)
    print(text.strip())
    check_mistakes(work, rendered["lab"])
    for overlay, text in rendered.items():
        fleet = Fleet(overlay, text, vdrived, work)
        fleet.check()
        fleet.check_pods()
        (work / "pods.yaml").write_text(yaml.safe_dump_all(
            document for documents in fleet.made_pods().values() for document in documents))
        text, agrees = judge(work, "pods.yaml")
        if not agrees:
            fail(f"{overlay}: pods.py: {text}")


if __name__ == "__main__":
    main()
