"""Pictures traced for reference by whole programs: Lobe beside Mitsuba, one thread each, with their noise.

    pip install mitsuba OpenEXR numpy
    python3 peers/speed/programs.py target/release/lobe

`speed.py` runs this in its environment and prints the table below its own. Times are of the processor, so that other
work on the machine disturbs little. Reading the scene, building its tree and compiling kernels are left out for both.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "mitsuba"))

SIZE, SAMPLES, BOUNCES, SEEDS = (256, 192), 64, 3, 4
SCENES = ("columns", "ball")


def processor_seconds(command):
    """What a program takes of the processor."""
    process = subprocess.Popen(list(map(str, command)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"failed: {' '.join(map(str, command))}")
    return usage.ru_utime


def noise(pictures):
    """The root of the mean variance of a picture, in parts of the mean."""
    return float(np.sqrt(pictures.var(axis=0, ddof=1).mean()) / pictures.mean())


def by_lobe(lobe, compare, folder, name):
    """Seconds of a picture, and all pictures."""
    eye, target = (",".join(map(str, v)) for v in compare.SCENES[name])
    command = [lobe, "render", "trace", f"built-in:{name}", "--env", folder / "sky.exr", "--threads", 1, "--quiet",
               "--bounces", BOUNCES, "--fov", compare.FOV, "--eye", eye, "--target", target, "-o", folder / "t.exr"]  # fmt: skip
    start = min(processor_seconds([*command, "--size", "1x1", "--samples", 2]) for _ in range(SEEDS))
    seconds, pictures = [], []
    for seed in range(SEEDS):
        more = ["--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", SAMPLES, "--seed", seed]
        seconds.append(processor_seconds([*command, *more]) - start)
        with compare.OpenEXR.File(str(folder / "t.exr")) as file:
            channels = file.channels()
            pictures.append(channels["RGB"].pixels.astype(np.float64))
            whole = channels["coverage.A"].pixels == 1.0
    return min(seconds), np.stack(pictures)[:, whole], whole


def by_mitsuba(lobe, compare, folder, name, whole):
    """The same, of the triangles of a bake."""
    eye, target = compare.SCENES[name]
    compare.run(lobe, "bake", f"built-in:{name}", "-o", folder / "b.glb", "--order", 3, "--samples", 4)
    primitives, _ = compare.read_glb(folder / "b.glb")
    scene = compare.mi.load_dict({
        "type": "scene", **compare.shapes(primitives), "light": compare.mitsuba_map(compare.light, 512),
        "sensor": compare.sensor(eye, target, SAMPLES),
        "integrator": {"type": "path", "max_depth": BOUNCES + 2, "rr_depth": 1000},
    })  # fmt: skip
    seconds, pictures = [], []
    # The first compiles, and does not count.
    for seed in range(SEEDS + 1):
        begun = time.process_time()
        pictures.append(np.array(compare.mi.render(scene, spp=SAMPLES, seed=seed + 1), dtype=np.float64))
        seconds.append(time.process_time() - begun)
    return min(seconds[1:]), np.stack(pictures[1:])[:, whole]


def absent():
    """Why there is no Mitsuba here, if there is none."""
    try:
        import peers

        os.environ.setdefault("DRJIT_LIBLLVM_PATH", peers.DrJit.llvm())
        import mitsuba
        import OpenEXR  # noqa: F401

        mitsuba.set_variant("llvm_ad_rgb")
        import drjit

        drjit.set_thread_count(1)
    except Exception as error:
        return " ".join(str(error).split()) or type(error).__name__
    return None


def rows(lobe):
    """A row for each scene: seconds and noise of both, Lobe's time over the peer's, and the same at equal noise."""
    import compare

    compare.SIZE = SIZE
    found = []
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        compare.lobe_map(folder / "sky.exr", 512)
        for name in SCENES:
            ours, our_pictures, whole = by_lobe(lobe, compare, folder, name)
            theirs, their_pictures = by_mitsuba(lobe, compare, folder, name, whole)
            noises = noise(our_pictures), noise(their_pictures)
            apart = abs(our_pictures.mean() / their_pictures.mean() - 1)
            ratio = ours / theirs
            found.append({"job": f"truth, {name}", "lobe": ours, "lobe_noise": noises[0], "peer": "Mitsuba", "peer_seconds": theirs,
                          "peer_noise": noises[1], "to_peer": ratio, "at_equal_noise": ratio * (noises[0] / noises[1]) ** 2,
                          "apart": float(apart)})  # fmt: skip
    return found


def table(found):
    lines = [f"{'whole programs':<18} {'lobe s':>8} {'noise':>7}  {'peer':<10} {'s':>8} {'noise':>7} {'lobe/peer':>9} {'at equal noise':>14}  means apart"]
    for row in found:
        lines.append(
            f"{row['job']:<18} {row['lobe']:>8.3f} {row['lobe_noise']:>7.4f}  {row['peer']:<10} {row['peer_seconds']:>8.3f} "
            f"{row['peer_noise']:>7.4f} {row['to_peer']:>9.2f} {row['at_equal_noise']:>14.2f}  {row['apart']:.1e}"
        )
    return lines


if __name__ == "__main__":
    why = absent()
    if why is not None:
        sys.exit(f"Mitsuba is not here: {why}")
    print("\n".join(table(rows(sys.argv[1]))))
