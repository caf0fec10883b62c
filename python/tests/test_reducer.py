"""Tests of the reducer alone. ``cargo test -p potamoi-reference --test twins`` compares it with the golden model."""

import unittest

import numpy as np
from potamoi import Reducer


class ReducerTest(unittest.TestCase):
    def test_ties_go_to_even_and_results_saturate(self):
        half = [1 << 14, 1 << 14]
        found = Reducer()([[[1], [0]], [[3], [0]], [[-1], [0]], [[-3], [0]], [[5], [4]]], [half] * 5)
        self.assertEqual(found.reshape(-1).tolist(), [0, 2, 0, -2, 4])
        self.assertEqual(found.dtype, np.int16)
        # Weights of 2 - 2^-15 for any code: the sum is above the largest feature.
        top = Reducer(weights="any")([[32767], [32767]], [0xFFFF, 0xFFFF])
        self.assertEqual(top.tolist(), [32767])

    def test_trusted_accumulators_wrap(self):
        codes, weights = [[32767], [32767]], [1 << 15, 1 << 15]
        self.assertEqual(Reducer()(codes, weights).tolist(), [-2])
        self.assertEqual(Reducer(registered_products=True)(codes, weights).tolist(), [32767])

    def test_exact_sums_are_not_rounded(self):
        exact = Reducer(sums="exact")
        self.assertEqual(exact([[1], [2]], [1, 3]).tolist(), [7])
        self.assertEqual(exact.gather([[5]], [[0]], [[0]], 1).tolist(), [[5 << 15]])

    def test_rows_that_are_not_loaded_count_as_0(self):
        rows, one = [[10, 20], [30, 40]], 1 << 15
        found = Reducer().gather(rows, [[0, 7], [1, 0]], [[one, one], [one, 0]], 2)
        self.assertEqual(found.tolist(), [[10, 20], [30, 40]])
        self.assertEqual(Reducer().gather(rows, [[1], [9]], [[0], [0]], 1).tolist(), [[30, 40], [0, 0]])

    def test_what_does_not_fit_is_refused(self):
        for wrong, word in (
            (lambda: Reducer(weight_bits=16), "gu.weight_bits = 16; expected 4 to 15"),
            (lambda: Reducer(feature_bits=7), "expected 8 to 16"),
            (lambda: Reducer(sums="all"), "expected one of rounded, exact"),
            (lambda: Reducer()([[1]], [1, 2]), "expected (..., V, C)"),
            (lambda: Reducer(feature_bits=8)([[128]], [1]), "does not fit gu.feature_bits = 8"),
        ):
            with self.assertRaises(ValueError) as caught:
                wrong()
            self.assertIn(word, str(caught.exception))
        with self.assertRaises(TypeError):
            Reducer()([[0.5]], [1])


if __name__ == "__main__":
    unittest.main()
