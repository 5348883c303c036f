"""`lobe-bench` beside other libraries, all on this machine in one run: each job, its floor and the best peer in one table.

    python3 peers/speed/speed.py target/release/lobe
    DIRECTXMATH=~/DirectXMath python3 peers/speed/speed.py target/release/lobe basis --json

The first run makes a virtual environment and installs what PyPI has of the peers. README.md says what is measured and how.
"""

import argparse
import importlib.metadata
import json
import os
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

HERE = Path(__file__).resolve().parent

# Beyond these the numbers are not the same: single precision of the basis of order 10, and texels that Lobe takes whole.
SAME = 1e-5
COMMAND_SAME = 1e-4

# Multiply-adds of a register in a cycle, below which floors are those of a bad build, as `lobe-bench` has it.
LEAST_EACH_CYCLE = 0.45

# What else pip needs, where it fails.
ADVICE = {"shtns": "it is built here: apt-get install libfftw3-dev and a C compiler"}

ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}


def arguments():
    parser = argparse.ArgumentParser(description="lobe-bench beside other libraries")
    parser.add_argument("lobe", help="the command, built with --release, and lobe-bench beside it")
    parser.add_argument("words", nargs="*", metavar="WORD", help="only jobs whose names contain one of these words")
    parser.add_argument("--rounds", type=int, default=5, help="rounds; in each, Lobe and every peer run once (default: 5)")
    parser.add_argument("--seconds", type=float, default=0.2, help="seconds for each job in a round (default: 0.2)")
    parser.add_argument("--venv", type=Path, default=HERE / "target" / "venv", help="where the peers are installed")
    parser.add_argument("--json", action="store_true", help="print JSON instead of the table")
    given = parser.parse_args()
    if shutil.which(given.lobe) is None:
        parser.error(f"{given.lobe}: no such command; cargo build --release -p lobe-cli makes target/release/lobe")
    given.bench = Path(shutil.which(given.lobe)).with_name("lobe-bench")
    if shutil.which(given.bench) is None:
        parser.error(f"{given.bench}: no such program; cargo build --release -p lobe-bench makes it")
    if given.rounds < 1 or not 0 < given.seconds < 1e3:
        parser.error("expected --rounds of at least 1 and --seconds above 0")
    return given


def python_of(folder):
    """The interpreter of the virtual environment, which is made if there is none."""
    python = folder / ("Scripts" if os.name == "nt" else "bin") / "python"
    if not python.exists():
        say(f"makes {folder}")
        try:
            venv.create(folder, with_pip=True)
        except (OSError, subprocess.CalledProcessError) as error:
            sys.exit(f"error: {folder}: no virtual environment could be made: {error}")
    return python


def install(python):
    """Installs the peers that are not there yet; why those that cannot be are absent."""
    have = subprocess.run([python, "-m", "pip", "freeze"], capture_output=True, text=True, check=True).stdout.split()
    absent = {}
    for wanted in (HERE / "requirements.txt").read_text().split():
        name = wanted.split("==")[0]
        if wanted in have:
            continue
        say(f"installs {wanted}")
        done = subprocess.run([python, "-m", "pip", "install", "--quiet", wanted], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            why = [line for line in done.stderr.splitlines() if "error" in line.lower()] or ["pip failed"]
            absent[name] = "; ".join([why[-1].strip(), *([ADVICE[name]] if name in ADVICE else [])])
    return absent


def compile_directxmath(folder):
    """The environment that tells the peer its program, or why it has none."""
    checkout = os.environ.get("DIRECTXMATH")
    if checkout is None:
        return {"LOBE_NO_DIRECTXMATH": "set DIRECTXMATH to a checkout"}
    source = Path(checkout).expanduser()
    include = [f"-I{path}" for path in (HERE / "sal", source / "Inc", source / "SHMath")]
    return compiled("DIRECTXMATH", folder, [*include, HERE / "directxmath.cpp", source / "SHMath" / "DirectXSH.cpp"])


def compile_filament(folder):
    """The same, by the headers and libraries of the system."""
    found = sorted(Path("/usr/include").glob("filament-*/ibl/CubemapSH.h"))
    if not found:
        return {"LOBE_NO_FILAMENT": "no header ibl/CubemapSH.h; apt-get install libfilament-dev"}
    libraries = ["-lfilament_ibl", "-lfilament_utils"]
    return compiled("FILAMENT", folder, [f"-I{found[-1].parents[1]}", HERE / "filament.cpp", *libraries])


def compiled(name, folder, arguments):
    """What tells a peer in C++ its program, or why it has none."""
    program = Path(folder) / name.lower()
    command = [os.environ.get("CXX", "g++"), "-O3", "-march=native", "-std=c++17", *arguments, "-o", program]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError as error:
        return {f"LOBE_NO_{name}": str(error)}
    if done.returncode != 0:
        why = [line for line in done.stderr.splitlines() if "error" in line] or ["the compiler failed"]
        return {f"LOBE_NO_{name}": why[0]}
    return {f"LOBE_{name}": str(program)}


class Worker:
    """A peer in its process."""

    def __init__(self, name, environment):
        self.name = name
        self.process = subprocess.Popen(
            [sys.executable, HERE / "worker.py", name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            env=os.environ | ONE_THREAD | environment,
        )
        answer = self.answer()
        self.absent, self.version = answer.get("absent"), answer.get("version")
        self.jobs = [tuple(job) for job in answer.get("jobs", [])]

    def answer(self):
        """The next answer; what else libraries print is passed over."""
        for line in self.process.stdout:
            if line.startswith("@"):
                return json.loads(line[1:])
        return {"absent": f"its process ended with {self.process.wait()}"}

    def measure(self, job, order, seconds):
        self.process.stdin.write(json.dumps([job, order, seconds]) + "\n")
        self.process.stdin.flush()
        return self.answer()

    def end(self):
        self.process.stdin.close()
        self.process.wait()


class Measured:
    """The least times of all rounds."""

    def __init__(self, workers):
        self.rows, self.peers, self.faults, self.machine = {}, {}, [], {}
        self.absent = [worker for worker in workers if worker.absent]

    def add_lobe(self, printed):
        for key, rate in printed["machine"].items():
            # As floors are the least of all rounds, rates are the highest.
            self.machine[key] = max(rate, self.machine.get(key, rate))
        for row in printed["jobs"]:
            kept = self.rows.setdefault((row["job"], row["order"]), dict(row))
            for key in ("nanoseconds", "floor"):
                if row[key] is not None:
                    kept[key] = min(kept[key], row[key])

    def add_peer(self, name, job, order, answer):
        """What a peer says about a job. Times of other numbers than ours are no times of the job."""
        fault = answer.get("error") or answer.get("absent")
        if fault is None and answer["apart"] > (answer["allowed"] or SAME):
            fault = f"its numbers are {answer['apart']:.1e} apart"
        if fault is not None:
            self.faults.append(f"{name}: {job} of order {order}: {fault}")
            return
        peer = self.peers.setdefault((job, order), {}).setdefault(name, answer)
        peer["nanoseconds"] = min(peer["nanoseconds"], answer["nanoseconds"])

    def joined(self):
        """The rows of the table."""
        rows = []
        for (job, order), row in self.rows.items():
            time, floor = row["nanoseconds"], row["floor"]
            peers = [{"peer": name, **answer} for name, answer in self.peers.get((job, order), {}).items()]
            peers.sort(key=lambda peer: peer["nanoseconds"])
            best = peers[0] if peers else {"peer": None, "nanoseconds": None}
            rows.append({
                "job": job, "order": order, "item": row["item"], "lobe": time, "floor": floor,
                "peer": best["peer"], "peer_nanoseconds": best["nanoseconds"],
                "to_peer": time / best["nanoseconds"] if peers else None,
                "to_floor": time / floor if floor else None, "peers": peers,
                "absent": [worker.name for worker in self.absent if (job, order) in worker.jobs],
            })  # fmt: skip
        return rows


def measure(given, folder):
    """All rounds; the peers that are absent, and the versions of the others."""
    rays = Path(folder) / "rays.safetensors"
    subprocess.run([given.bench, "occlusion", "--seconds", "0.001", "--quiet", "--rays", rays], stdout=subprocess.DEVNULL, check=True)
    environment = {"LOBE_RAYS": str(rays)} | compile_directxmath(folder) | compile_filament(folder)
    workers = [Worker(name, environment) for name in peer_names()]
    measured = Measured(workers)
    for k in range(given.rounds):
        say(f"round {k + 1} of {given.rounds}")
        command = [given.bench, "--json", "--quiet", "--seconds", str(given.seconds), *given.words]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            say(done.stderr.strip())
            sys.exit(done.returncode)
        measured.add_lobe(json.loads(done.stdout))
        for worker in workers:
            for job, order in worker.jobs:
                if worker.absent is None and worker.process.poll() is None and (job, order) in measured.rows:
                    measured.add_peer(worker.name, job, order, worker.measure(job, order, given.seconds))
    for worker in workers:
        worker.end()
    absent = {worker.name: worker.absent for worker in workers if worker.absent}
    return measured, absent, {worker.name: worker.version for worker in workers if worker.version}


def peer_names():
    import peers

    return [peer.name for peer in peers.PEERS]


def table(rows):
    lines = [f"{'job':<16} {'order':>5} {'lobe ns':>9} {'floor ns':>9}  {'best peer':<17} {'peer ns':>9} {'lobe/peer':>9} {'lobe/floor':>10}  per"]
    for row in rows:
        peer = row["peer"] or ("absent" if row["absent"] else "none does it")
        numbers = [short(row[key]) for key in ("lobe", "floor", "peer_nanoseconds", "to_peer", "to_floor")]
        lines.append(
            f"{row['job']:<16} {row['order'] or '':>5} {numbers[0]:>9} {numbers[1]:>9}  {peer:<17} "
            f"{numbers[2]:>9} {numbers[3]:>9} {numbers[4]:>10}  {row['item']}"
        )
    lines.append("\nall peers: nanoseconds, and how far their numbers are from ours, in parts of the largest")
    for row in rows:
        peers = [f"{peer['peer']} {short(peer['nanoseconds'])} ({peer['apart']:.0e})" for peer in row["peers"]]
        if peers:
            lines.append(f"{row['job']:<16} {row['order'] or '':>5}  " + ", ".join(peers))
    return lines


def pictures_of(given):
    """The rows of `programs.py`, or why there are none."""
    import programs

    if given.words and not any(word in "truth" for word in given.words):
        return "not asked for"
    why = programs.absent()
    if why is not None:
        return f"Mitsuba is not here: {why}"
    say("pictures")
    return programs.rows(given.lobe)


def pictures_table(pictures):
    import programs

    return [f"truth: {pictures}"] if isinstance(pictures, str) else programs.table(pictures)


def short(x):
    """Three digits; nothing for nothing."""
    if x is None:
        return ""
    return f"{x:.0f}" if abs(x) >= 100 else f"{x:#.3g}"


def say(text):
    print(text, file=sys.stderr, flush=True)


def main():
    given = arguments()
    if "LOBE_NOT_INSTALLED" not in os.environ:
        python = python_of(given.venv.resolve())
        os.environ["LOBE_NOT_INSTALLED"] = json.dumps(install(python))
        os.execv(python, [python, HERE / "speed.py", *sys.argv[1:]])
    try:
        importlib.metadata.version("numpy")
    except importlib.metadata.PackageNotFoundError:
        sys.exit(f"no numpy in {given.venv}: pip could install none of the peers")
    import reference

    with tempfile.TemporaryDirectory() as folder:
        differs = reference.command_differs(given.lobe, folder)
        measured, absent, versions = measure(given, folder)
    pictures = pictures_of(given)
    not_installed = json.loads(os.environ["LOBE_NOT_INSTALLED"])
    rows, faults = measured.joined(), sorted(set(measured.faults))
    faults += [f"lobe: {job}: its numbers are {far:.1e} from the definition" for job, far in differs.items() if far > COMMAND_SAME]
    each_cycle = measured.machine["each_cycle"]
    if each_cycle < LEAST_EACH_CYCLE:
        faults.append(f"lobe: its probe of arithmetic does {each_cycle:.2f} multiply-adds a cycle: the floors are void")
    if given.json:
        print(json.dumps({
            "machine": measured.machine, "jobs": rows, "versions": versions, "absent": absent, "not_installed": not_installed,
            "lobe_apart": differs, "pictures": pictures, "faults": faults,
        }))  # fmt: skip
    else:
        print("\n".join(table(rows) + [""] + pictures_table(pictures)))
        print("\n" + ", ".join(f"{name} {of}" for name, of in versions.items()))
        for name, why in absent.items():
            print(f"absent: {name}: {why}")
        for name, why in not_installed.items():
            print(f"not installed: {name}: {why}")
    for fault in faults:
        say(f"error: {fault}")
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
