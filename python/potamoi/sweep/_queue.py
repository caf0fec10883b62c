"""Which points are handed out next.

A point names the files of counted work that it is made from. A file that is not there yet is counted by the
first batch that needs it. Until it is back, no other worker gets a point that needs it.
"""

from collections import Counter

# Most points of a batch.
LARGEST = 64
# Batches that each worker gets of what is left, so that all end at about the same time.
SHARES = 3
# Times that a point may be lost together with its worker.
LOSSES = 3


class Queue:
    """Points that no line is of, in the plan's order."""

    def __init__(self, points, there):
        """`there` has the names of the files of counted work that are there already."""
        self.points = {point["key"]: point for point in points}
        self.waiting = dict(self.points)
        self.there = set(there)
        self.counting = {}
        self.losses = Counter()

    def __len__(self):
        """Number of points without a line."""
        return len(self.points)

    def take(self, worker, workers):
        """Points for one of so many workers. None where all have to wait for what others count."""
        size = max(1, min(LARGEST, -(-len(self.points) // (SHARES * max(1, workers)))))
        batch = []
        for key, point in self.waiting.items():
            lacking = [name for name in point["work"] if name not in self.there]
            if any(self.counting.get(name, worker) != worker for name in lacking):
                continue
            if lacking and batch:
                continue
            batch.append(point)
            self.counting.update((name, worker) for name in lacking)
            # What others wait for is counted alone; a point that was lost may have ended its worker.
            if lacking or self.losses[key] or len(batch) == size:
                break
        for point in batch:
            del self.waiting[point["key"]]
        return batch

    def finish(self, key):
        """Whether the line of a key is the first one. The key is done from then on."""
        self.waiting.pop(key, None)
        return self.points.pop(key, None) is not None

    def give_back(self, worker, batch, lost=False):
        """Ends a batch of a worker. Its points without a line wait again, before all others.

        Returns a point that was lost together with its worker too often, or None.
        """
        for name in [name for name, of in self.counting.items() if of == worker]:
            del self.counting[name]
        left = [point for point in batch if point["key"] in self.points]
        for point in left:
            self.losses[point["key"]] += lost
        self.waiting = {**{point["key"]: point for point in left}, **self.waiting}
        return next((p for p in left if self.losses[p["key"]] >= LOSSES), None)

    def add(self, names):
        """Files of counted work that are there now."""
        self.there.update(names)
