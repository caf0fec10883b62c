"""The job from its first worker to its last line."""

import json
import os
import re
import secrets
import sys
import time

from . import _address, _worker
from ._queue import Queue

# Version of the job.
FORMAT_VERSION = 1
# Bytes of a file that go in one message, and of counted work in one message.
BLOCK = 16 << 20
COUNTED = 256 << 20
# Seconds between looks at results and at the list of workers, and until a lack of workers is told.
PAUSE, LOOK, PATIENCE = 0.02, 0.5, 10.0
# Seconds until a scheduler answers.
ANSWER = 30
# Name of a file of counted work.
NAME = re.compile(r"[a-z-]+-[0-9a-f]{32}\.json")


class Failed(Exception):
    """Why the job cannot go on. `is_input`: the command line is at fault, and no tool."""

    def __init__(self, why, is_input=False):
        super().__init__(why)
        self.is_input = is_input


def say(what):
    """Prints a line for the program that started this one."""
    sys.stdout.write(what + "\n")
    sys.stdout.flush()


def note(text):
    say(json.dumps({"note": text}))


class ByValue:
    """A function of ``_worker`` that scheduler and workers read without the package."""

    def __init__(self, function):
        import cloudpickle

        cloudpickle.register_pickle_by_value(_worker)
        self.text = cloudpickle.dumps(function)

    def __reduce__(self):
        import cloudpickle

        return cloudpickle.loads, (self.text,)

    def __call__(self, *arguments):
        raise NotImplementedError("it is called where it was sent to")


class Worker:
    """A worker of the scheduler, as far as this job knows it."""

    def __init__(self, address):
        self.address = address
        self.is_ready = False
        self.future = None
        # Points that it evaluates, and files of counted work that it has.
        self.batch, self.has = [], set()


class Runner:
    """Hands points to workers and collects their lines."""

    def __init__(self, job, client):
        self.job, self.client = job, client
        self.token = secrets.token_hex(8)
        self.sha256 = _worker.sha256_of(job["program"])
        self.folder = os.getcwd()
        self.names = {name for point in job["points"] for name in point["work"] if NAME.fullmatch(name)}
        self.queue = Queue(job["points"], [n for n in self.names if os.path.isfile(self.counted(n))])
        self.workers, self.refused = {}, {}
        # Files of counted work that came from two workers.
        self.twice = 0
        self.since = time.monotonic()
        self.is_waiting_told = False

    def counted(self, name):
        return os.path.join(self.job["counted"], name)

    def run(self):
        """Runs until each point has its line."""
        looked = -LOOK
        while len(self.queue):
            now = time.monotonic()
            if now - looked >= LOOK:
                self.look()
                looked = now
            for worker in list(self.workers.values()):
                self.step(worker)
            time.sleep(PAUSE)
        if self.twice:
            note(f"{self.twice} files of counted work were made by two workers")

    # ---- workers

    def look(self):
        """Takes note of workers that came or went."""
        there = self.client.nthreads()
        for address in [a for a in self.workers if a not in there]:
            note(f"worker {address} is gone: its points are evaluated again")
            self.lose(self.workers[address])
        self.refused = {a: why for a, why in self.refused.items() if a in there}
        for address in there:
            if address not in self.workers and address not in self.refused:
                self.greet(address)
        if self.workers:
            self.since = time.monotonic()
        elif time.monotonic() - self.since > PATIENCE:
            if self.refused:
                raise Failed(f"all {len(self.refused)} workers are refused: "
                             + "; ".join(f"{a}: {why}" for a, why in self.refused.items()))
            if not self.is_waiting_told:
                note(f"no worker at {self.job['scheduler']} yet: waiting")
                self.is_waiting_told = True

    def greet(self, address):
        """Asks a new worker for its program."""
        try:
            _address.check(address, "worker")
        except _address.Refused as error:
            return self.refuse(address, str(error))
        worker = self.workers[address] = Worker(address)
        self.prepare(worker)

    def prepare(self, worker):
        worker.is_ready, worker.has = False, set()
        worker.future = self.submit(worker, _worker.prepare, self.job["program"], self.sha256)

    def refuse(self, address, why):
        """A refused worker gets no points."""
        note(f"worker {address} is refused and gets no points: {why}")
        self.refused[address] = why
        self.workers.pop(address, None)

    def lose(self, worker):
        """Forgets a worker that is gone; others evaluate its points."""
        self.workers.pop(worker.address, None)
        if worker.future is not None:
            worker.future.cancel()
        point = self.queue.give_back(worker.address, worker.batch, lost=True)
        if point:
            raise Failed(f"point {point['number']} was lost with its worker again and again: it may need more "
                         f"memory than a worker has; `potamoi sweep {self.job['plan']} --points "
                         f"{point['number']}` evaluates it alone")

    # ---- work

    def submit(self, worker, function, *arguments):
        """Runs a function on one worker and on no other."""
        key = f"potamoi-{function.__name__}-{secrets.token_hex(8)}"
        return self.client.submit(ByValue(function), self.token, *arguments, key=key, pure=False, retries=0,
                                  workers=[worker.address], allow_other_workers=False)

    def step(self, worker):
        """Takes what a worker has done, and gives it more."""
        if worker.future is not None:
            if not worker.future.done():
                return
            future, worker.future = worker.future, None
            if future.status != "finished":
                why = future.exception() if future.status == "error" else None
                if why is None or type(why).__name__ in ("KilledWorker", "CommClosedError"):
                    return self.lose(worker)
                return self.fail(worker, f"{type(why).__name__}: {why}")
            found = future.result()
            if not worker.is_ready:
                return self.admit(worker, found)
            if not self.take(worker, found):
                return
        batch = self.queue.take(worker.address, len(self.workers))
        if batch:
            self.give(worker, batch)

    def admit(self, worker, why):
        """Sends the files that the plan reads to a worker whose program is the right one."""
        if why:
            return self.refuse(worker.address, why)
        for path in self.job["files"]:
            path = os.path.abspath(path)
            size, offset = os.path.getsize(path), 0
            with open(path, "rb") as file:
                while offset == 0 or offset < size:
                    block = file.read(BLOCK)
                    self.wait(worker, self.submit(worker, _worker.put, path, block, offset))
                    if worker.address not in self.workers:
                        return
                    offset += max(1, len(block))
        worker.is_ready = True

    def wait(self, worker, future):
        """Waits for a short task; a worker that is gone meanwhile is lost."""
        while not future.done():
            time.sleep(PAUSE)
            if worker.address not in self.client.nthreads():
                future.cancel()
                return self.lose(worker)
        if future.status != "finished":
            self.fail(worker, str(future.exception()))

    def give(self, worker, batch):
        """Hands points to a worker, with the counted work that it lacks."""
        wanted = {name for point in batch for name in point["work"]} & self.names
        counted, room = {}, COUNTED
        for name in sorted((wanted & self.queue.there) - worker.has):
            try:
                with open(self.counted(name), "rb") as file:
                    content = file.read(room + 1)
            except OSError:
                continue
            if len(content) <= room:
                counted[name] = content
                room -= len(content)
        worker.batch = batch
        worker.has |= set(counted)
        numbers = [point["number"] for point in batch]
        worker.future = self.submit(worker, _worker.evaluate, self.folder, self.job["plan"], numbers, counted,
                                    sorted(wanted), COUNTED)

    def take(self, worker, found):
        """Takes the result of a batch. False if the worker gets nothing now."""
        batch, worker.batch = worker.batch, []
        if "unprepared" in found:
            # Another process has the address now, or the program was changed.
            self.queue.give_back(worker.address, batch)
            self.prepare(worker)
            return False
        keys = {point["key"] for point in batch}
        for name, content in found["made"].items():
            if name in self.names:
                self.twice += name in self.queue.there
                _worker.write_counted(self.job["counted"], name, content)
                worker.has.add(name)
                self.queue.add([name])
        strange = None
        for line in found["lines"]:
            key = key_of(line)
            if key not in keys:
                strange = line
            elif self.queue.finish(key):
                say(line)
        self.queue.give_back(worker.address, batch)
        why = None
        if strange is not None:
            why = ("it answers with a point that was not asked for: files that the plan reads differ there, "
                   "such as one that is named by its whole path")
        elif any(key in self.queue.points for key in keys):
            why = f"potamoi ended with status {found['status']}: {found['said'].strip()}"
        if why:
            self.refuse(worker.address, why)
        return not why

    def fail(self, worker, why):
        """Gives up a worker on which a task failed."""
        self.queue.give_back(worker.address, worker.batch)
        worker.batch = []
        self.refuse(worker.address, why)


def key_of(line):
    """Key of a line of the journal, or None."""
    try:
        return json.loads(line)["key"]
    except (ValueError, KeyError, TypeError):
        return None


def run(job):
    """Runs a job. Prints its lines as they come."""
    if job.get("format_version") != FORMAT_VERSION:
        raise Failed("the Python package is of another version than the program: install that of its sources")
    try:
        _address.check(job["scheduler"], "--scheduler")
    except _address.Refused as error:
        raise Failed(str(error), is_input=True) from None
    from distributed import Client

    try:
        client = Client(job["scheduler"], timeout=ANSWER, set_as_default=False)
    except (OSError, ValueError, TypeError, RuntimeError) as error:
        raise Failed(f"no scheduler answers at {job['scheduler']}: {error or type(error).__name__}; "
                     "start one: dask scheduler --host 127.0.0.1") from None
    try:
        _address.check(client.scheduler_info()["address"], "the scheduler listens at")
        Runner(job, client).run()
    except _address.Refused as error:
        raise Failed(str(error), is_input=True) from None
    finally:
        client.close(timeout=2)
