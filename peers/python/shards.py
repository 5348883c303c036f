"""What bakes on Dask cost beside one process: the same bake by one process, and in shards by processes of one thread each.

    pip install ./apps/lobe-python distributed
    python peers/python/shards.py --samples 4096

Prints wall times, and times of processors, which say on a busy machine, too, what the engine adds; a difference of a byte ends the
program with 1.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time


def one_process(scene, output, samples, threads):
    """Seconds of one process, by the clock and of processors, the start of Python left out."""
    program = (
        "import sys, time, lobe\n"
        "begun, used = time.perf_counter(), time.process_time()\n"
        "lobe.bake(sys.argv[1], sys.argv[2], lobe.BakeOptions(samples=int(sys.argv[3])))\n"
        "print(time.perf_counter() - begun, time.process_time() - used)\n"
    )
    environment = dict(os.environ, RAYON_NUM_THREADS=str(threads))
    done = subprocess.run([sys.executable, "-c", program, scene, output, str(samples)], env=environment, check=True, capture_output=True, text=True)
    return [float(seconds) for seconds in done.stdout.split()]


def on_dask(scene, output, samples, workers):
    """Seconds of a bake on processes of one thread each that are there already, by the clock and of processors."""
    import lobe
    import lobe.distributed
    from distributed import Client, LocalCluster

    os.environ["RAYON_NUM_THREADS"] = "1"
    with (
        LocalCluster(n_workers=workers, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        Client(cluster, set_as_default=False) as client,
    ):
        client.run(lambda: __import__("lobe").__version__)
        # The client and the scheduler are threads of this process.
        processors = lambda: time.process_time() + sum(client.run(time.process_time).values())  # noqa: E731
        begun, used = time.perf_counter(), processors()
        lobe.distributed.bake(scene, output, lobe.BakeOptions(samples=samples), client=client)
        return [time.perf_counter() - begun, processors() - used]


def main():
    parser = argparse.ArgumentParser(description="Bake a scene by one process and on Dask, and compare times and bytes.")
    parser.add_argument("scene", nargs="?", default="built-in:columns")
    parser.add_argument("--samples", type=int, default=4096)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        alone, shared = os.path.join(folder, "alone.safetensors"), os.path.join(folder, "shared.safetensors")
        one = one_process(given.scene, alone, given.samples, given.workers)
        dask = on_dask(given.scene, shared, given.samples, given.workers)
        with open(alone, "rb") as a, open(shared, "rb") as b:
            same = a.read() == b.read()
    more = [100 * (b / a - 1) for a, b in zip(one, dask)]
    print(f"{'':<30} {'clock':>10} {'processors':>12}")
    print(f"{f'one process, {given.workers} threads':<30} {one[0]:>8.1f} s {one[1]:>10.1f} s")
    print(f"{f'{given.workers} processes, one thread each':<30} {dask[0]:>8.1f} s {dask[1]:>10.1f} s")
    print(f"{'the engine adds':<30} {more[0]:>+8.1f} % {more[1]:>+10.1f} %")
    if not same:
        print("error: the files differ", file=sys.stderr)
    return int(not same)


if __name__ == "__main__":
    sys.exit(main())
