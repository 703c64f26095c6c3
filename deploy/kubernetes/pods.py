#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Writes pods for podman, as Kubernetes would create them from StatefulSets and Deployments.

  { kubectl kustomize deploy/kubernetes/bench/lab && echo --- &&
    kubectl create secret generic vdrive-gateway --from-file token --dry-run=client --output yaml
  } | deploy/kubernetes/pods.py DIR

Writes one file per pod to DIR, with the ConfigMaps and Secrets that the pod mounts. The file has
the name of the pod in the network, such as vdrive-bench-1.vdrive-bench.yaml; podman needs this name
as an alias:

  podman network create vdrive
  for pod in DIR/*.yaml; do
    podman kube play --network "vdrive:alias=$(basename "$pod" .yaml)" "$pod"
  done

The pods are those of the manifests with these changes. The additions of the StatefulSet controller
are written out (name, index, claims). Node ports become ports of this machine, and all other ports
are dropped, because podman would publish every one of them. Volume names get the name of the pod as
a prefix, because podman would share volumes of the same name among all pods. Secrets become
ConfigMaps, because podman 4.3 would mount them in base64. Probes are dropped, because podman would
need curl in the image. Services, NetworkPolicies and disruption budgets are left out: podman has
none of them.
"""
import base64
import copy
import pathlib
import sys

import yaml


def pods_of(documents):
    """Yield pairs of a pod's name in the network and its documents, ConfigMaps first."""
    maps = {name(d): d for d in documents if d["kind"] == "ConfigMap"}
    maps |= {name(d): d for d in map(as_map, documents) if d}
    node_ports = {(name(d), port["targetPort"]): port["nodePort"]
                  for d in documents if d["kind"] == "Service"
                  for port in d["spec"].get("ports", []) if "nodePort" in port}
    for document in documents:
        if document["kind"] in ("StatefulSet", "Deployment"):
            for pod, alias in replicas(document):
                prepare(pod, name(document), node_ports)
                mounted = [v["configMap"]["name"] for v in pod["spec"]["volumes"] if "configMap" in v]
                missing = [each.removesuffix(SECRET) for each in mounted if each not in maps]
                if missing:
                    sys.exit(f"pods: {name(document)} needs '{missing[0]}', a Secret or a ConfigMap, "
                             "which is not among the documents")
                yield alias, [*(maps[each] for each in mounted), pod]


SECRET = "-secret"


def as_map(document):
    """Return a Secret as a ConfigMap; None for any other document."""
    if document["kind"] != "Secret":
        return None
    return {"apiVersion": "v1", "kind": "ConfigMap", "metadata": {"name": name(document) + SECRET},
            "data": {key: base64.b64decode(value).decode() for key, value in document["data"].items()}}


def name(document):
    return document["metadata"]["name"]


def replicas(document):
    """Yield (pod, alias) as a controller would create them; the first pod has the name of the Deployment."""
    spec = document["spec"]
    for index in range(spec.get("replicas", 1)):
        pod = {"apiVersion": "v1", "kind": "Pod", **copy.deepcopy(spec["template"])}
        if document["kind"] == "Deployment":
            pod["metadata"]["name"] = alias = name(document) + (f"-{index}" if index else "")
        else:
            index += spec.get("ordinals", {}).get("start", 0)
            pod["metadata"]["name"] = f"{name(document)}-{index}"
            pod["metadata"]["labels"]["apps.kubernetes.io/pod-index"] = str(index)
            alias = f"{name(pod)}.{spec['serviceName']}"
        claim(pod, [name(c) for c in spec.get("volumeClaimTemplates", [])])
        yield pod, alias


def claim(pod, claims):
    """Replace volumes by the claims with the same names."""
    volumes = [v for v in pod["spec"].get("volumes", []) if v["name"] not in claims]
    volumes += [{"name": c, "persistentVolumeClaim": {"claimName": f"{c}-{name(pod)}"}} for c in claims]
    pod["spec"]["volumes"] = volumes


def prepare(pod, owner, node_ports):
    """Make the changes that podman needs."""
    for container in pod["spec"]["containers"]:
        for probe in ("livenessProbe", "readinessProbe", "startupProbe"):
            container.pop(probe, None)
        ports = [{**p, "hostPort": node_ports[owner, p["name"]]}
                 for p in container.pop("ports", []) if (owner, p["name"]) in node_ports]
        if ports:
            container["ports"] = ports
        for mount in container.get("volumeMounts", []):
            mount["name"] = f"{name(pod)}-{mount['name']}"
    for volume in pod["spec"]["volumes"]:
        volume["name"] = f"{name(pod)}-{volume['name']}"
        if "secret" in volume:
            volume["configMap"] = {"name": volume.pop("secret")["secretName"] + SECRET}


def main():
    if len(sys.argv) != 2:
        print(__doc__.split("\n\n")[1], file=sys.stderr)
        sys.exit(2)
    directory = pathlib.Path(sys.argv[1])
    directory.mkdir(mode=0o700, parents=True, exist_ok=True)  # it contains Secrets
    for alias, documents in pods_of([d for d in yaml.safe_load_all(sys.stdin) if d]):
        path = directory / f"{alias}.yaml"
        path.write_text(yaml.safe_dump_all(documents, sort_keys=False), encoding="utf-8")


if __name__ == "__main__":
    main()
