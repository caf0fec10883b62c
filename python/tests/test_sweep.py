"""Sweeps elsewhere without a cluster: addresses, what is handed out, and what one worker does."""

import hashlib
import random
import unittest

from potamoi.sweep import _address, _worker
from potamoi.sweep._queue import LOSSES, Queue


class AddressTest(unittest.TestCase):
    def test_tls_and_the_loopback_are_talked_to(self):
        for address in ["tls://10.0.0.5:8786", "tls://node7.cluster:8786", "tcp://127.0.0.1:8786",
                        "tcp://127.9.9.9:1", "tcp://localhost:8786", "tcp://[::1]:8786"]:
            _address.check(address, "scheduler")

    def test_all_else_is_refused(self):
        for address in ["tcp://10.0.0.5:8786", "tcp://node7.cluster:8786", "tcp://0.0.0.0:8786",
                        "tcp://127.0.0.1.example.org:8786", "tcp://localhost.example.org:1", "ws://127.0.0.1:1",
                        "inproc://127.0.0.1/1", "127.0.0.1:8786", "tcp://", "tcp://[::1:8786", "tls:", "",
                        "tcp://127.0.0.1@10.0.0.5:8786", "tcp://127.0.0.1:x"]:
            with self.assertRaisesRegex(_address.Refused, "TLS", msg=address):
                _address.check(address, "scheduler")


def point(number, *work):
    return {"number": number, "key": f"k{number}", "work": list(work)}


class QueueTest(unittest.TestCase):
    def test_what_is_counted_for_one_is_not_counted_by_another(self):
        queue = Queue([point(0, "a"), point(1, "a"), point(2, "b"), point(3), point(4, "a", "b")], [])
        self.assertEqual([p["number"] for p in queue.take("x", 2)], [0])
        self.assertEqual([p["number"] for p in queue.take("y", 2)], [2])
        # What needs neither file alone is left.
        self.assertEqual([p["number"] for p in queue.take("z", 2)], [3])
        self.assertEqual(queue.take("z", 2), [])
        self.assertTrue(queue.finish("k0"))
        self.assertFalse(queue.finish("k0"))
        queue.add(["a"])
        self.assertIsNone(queue.give_back("x", [point(0, "a")]))
        self.assertEqual([p["number"] for p in queue.take("x", 2)], [1])
        self.assertEqual(queue.take("x", 2), [])

    def test_a_lost_batch_is_handed_out_again_and_not_for_ever(self):
        queue = Queue([point(n) for n in range(20)], [])
        for loss in range(1, LOSSES + 1):
            batch = queue.take("x", 1)
            self.assertEqual(batch[0]["number"], 0)
            # One that was lost stands alone, so that it is known which one ends its worker.
            self.assertEqual(len(batch), 7 if loss == 1 else 1)
            lost = queue.give_back("x", batch, lost=True)
            self.assertEqual(lost is not None, loss == LOSSES)

    def test_each_point_is_finished_once_whatever_happens(self):
        for seed in range(200):
            chance = random.Random(seed)
            works = [f"w{n}" for n in range(4)]
            points = [point(n, *chance.sample(works, chance.randrange(3))) for n in range(chance.randrange(1, 60))]
            queue = Queue(points, chance.sample(works, chance.randrange(3)))
            busy, done, counting = {}, [], {}
            while len(queue):
                worker = chance.choice("xyz")
                if worker not in busy:
                    batch = queue.take(worker, 3)
                    if batch:
                        busy[worker] = batch
                        for name in {n for p in batch for n in p["work"]} - queue.there:
                            self.assertNotIn(name, counting, f"seed {seed}")
                            counting[name] = worker
                    else:
                        self.assertTrue(busy, f"seed {seed}: points wait for nobody")
                    continue
                batch = busy.pop(worker)
                counting = {n: w for n, w in counting.items() if w != worker}
                is_lost = chance.random() < 0.02
                if not is_lost:
                    done += [p["number"] for p in batch if queue.finish(p["key"])]
                    queue.add(n for p in batch for n in p["work"])
                if queue.give_back(worker, batch, lost=is_lost):
                    break
            else:
                self.assertEqual(sorted(done), list(range(len(points))), f"seed {seed}")


class WorkerTest(unittest.TestCase):
    def test_a_hash_is_of_the_whole_file(self):
        with open(__file__, "rb") as file:
            self.assertEqual(_worker.sha256_of(__file__), hashlib.sha256(file.read()).hexdigest())

    def test_files_stay_inside(self):
        self.assertEqual(_worker.inside("/w", "/data/a.toml"), "/w/tree/data/a.toml")


if __name__ == "__main__":
    unittest.main()
