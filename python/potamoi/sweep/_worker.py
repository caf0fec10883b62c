"""What runs on a worker of Dask.

Functions are sent by value and each call stands for itself: what a worker has is in a folder of its own,
``potamoi-TOKEN`` in the local folder of its Dask worker. Nothing here imports another module of the package.
"""

import hashlib
import json
import os
import shutil
import subprocess
import tempfile


def sha256_of(path):
    """SHA-256 of a file, in hexadecimal digits."""
    hashed = hashlib.sha256()
    with open(path, "rb") as file:
        while block := file.read(1 << 20):
            hashed.update(block)
    return hashed.hexdigest()


def place_of(token):
    """The folder of a sweep on this worker."""
    from distributed import get_worker

    return os.path.join(get_worker().local_directory, f"potamoi-{token}")


def program_of(theirs):
    """The program of this worker: POTAMOI_PROGRAM, else `potamoi` in PATH, else where the runner has it."""
    return os.environ.get("POTAMOI_PROGRAM") or shutil.which("potamoi") or theirs


def marks_of(path):
    """What changes when a file does, without reading it."""
    found = os.stat(path)
    return [path, found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns]


def prepare(token, program, sha256):
    """Checks the program. Returns why this worker is refused, and None if it is not."""
    own = program_of(program)
    try:
        marks, found = marks_of(own), sha256_of(own)
    except OSError as error:
        return f"it has no program potamoi: {error}; name one in POTAMOI_PROGRAM"
    if found != sha256:
        return (f"{own} has the SHA-256 {found[:16]}..., and the sweep's program {sha256[:16]}...: "
                "expected the same program everywhere")
    place = place_of(token)
    os.makedirs(os.path.join(place, "cache", "work"), mode=0o700, exist_ok=True)
    os.chmod(os.path.join(place, "cache"), 0o700)
    with open(os.path.join(place, "program.json"), "w") as file:
        json.dump(marks, file)
    return None


def inside(place, path):
    """Where a file of the runner's is in the folder of a sweep."""
    return os.path.join(place, "tree", path.lstrip("/"))


def put(token, path, block, offset):
    """Writes a block of a file that the plan reads."""
    path = inside(place_of(token), path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "r+b" if offset else "wb") as file:
        file.seek(offset)
        file.write(block)


def write_counted(folder, name, content):
    """Writes a file of counted work whole or not at all, for its owner alone."""
    descriptor, unfinished = tempfile.mkstemp(prefix=".", dir=folder)
    with os.fdopen(descriptor, "wb") as file:
        file.write(content)
    os.replace(unfinished, os.path.join(folder, name))


def evaluate(token, folder, plan, numbers, counted, wanted, most):
    """Evaluates points of a plan.

    `folder` is the runner's, `counted` holds files of counted work by name, `wanted` names those to return if
    they are made here, of `most` bytes together. Returns a dictionary: `unprepared` where the worker has to be
    prepared first, else `status`, `lines`, `said` and `made`.
    """
    place = place_of(token)
    try:
        with open(os.path.join(place, "program.json")) as file:
            marks = json.load(file)
        if marks != marks_of(marks[0]):
            return {"unprepared": True}
    except (OSError, ValueError):
        return {"unprepared": True}
    work = os.path.join(place, "cache", "work")
    for name, content in counted.items():
        write_counted(work, name, content)
    from distributed import get_worker

    environment = dict(os.environ, POTAMOI_CACHE=os.path.join(place, "cache"),
                       RAYON_NUM_THREADS=str(get_worker().state.nthreads))
    if os.path.isabs(plan):
        plan = inside(place, plan)
    within = inside(place, folder)
    os.makedirs(within, exist_ok=True)
    points = ",".join(str(number) for number in numbers)
    had = set(os.listdir(work))
    done = subprocess.run([marks[0], "sweep", plan, "--points", points], cwd=within, env=environment,
                          stdin=subprocess.DEVNULL, capture_output=True)
    made = {}
    for name in sorted(set(os.listdir(work)) - had):
        path = os.path.join(work, name)
        size = os.path.getsize(path)
        if name in wanted and size <= most:
            with open(path, "rb") as file:
                made[name] = file.read()
            most -= size
    return {"status": done.returncode, "lines": done.stdout.decode(errors="replace").splitlines(),
            "said": done.stderr.decode(errors="replace")[-2000:], "made": made}
