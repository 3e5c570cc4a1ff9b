"""A cluster of Ray on this machine for tests and benchmarks, with a raylet for each machine that it stands for. It ends with its stdin.

    python tests/python/ray_cluster.py NODES [CPUS]

A line of JSON on stdout: the address, and the process ids of the head and of the raylets; the first raylet is that of the head. `fill` on stdin fills the object store, and is answered by the number of MB that it holds.
"""

from __future__ import annotations

import json
import sys
from typing import Any

STORE_MB = 80  # of each node, about the least that Ray takes
BLOCK_MB = 10


def processes_of(name: str, parent: int | None = None) -> list[int]:
    """Children of this process whose program has that name, the oldest first."""
    import psutil

    found = [child for child in psutil.Process(parent).children(recursive=True) if child.name() == name]
    return [child.pid for child in sorted(found, key=lambda child: child.create_time())]


def fill() -> int:
    """Objects that nobody frees, more than the store of a node holds. The MB that are held."""
    import numpy as np
    import ray

    HELD.extend(ray.put(np.zeros(BLOCK_MB << 20, dtype=np.uint8)) for _ in range(3 * STORE_MB // (2 * BLOCK_MB)))
    return len(HELD) * BLOCK_MB


HELD: list[Any] = []


def main(nodes: int, cpus: int) -> None:
    from ray.cluster_utils import Cluster

    whole = {"num_cpus": cpus, "object_store_memory": STORE_MB << 20, "include_dashboard": False}
    cluster = Cluster(initialize_head=True, head_node_args=whole)
    for _ in range(nodes - 1):
        cluster.add_node(num_cpus=cpus, object_store_memory=STORE_MB << 20)
    print(json.dumps({"address": cluster.address, "head": processes_of("gcs_server")[0], "raylets": processes_of("raylet")}), flush=True)
    for line in sys.stdin:
        if line.strip() == "fill":
            import ray

            ray.init(address=cluster.address, log_to_driver=False)
            print(fill(), flush=True)
    cluster.shutdown()


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 1)
