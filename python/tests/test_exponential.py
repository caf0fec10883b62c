"""Tests of the package alone: shapes, types, files and errors.

All operands of many engines are compared with the golden model by
``cargo test -p potamoi-reference --test twins``.
"""

import sys
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from potamoi import Exponential, _constants, _forms, _knobs

try:
    import tomllib  # noqa: F401

    HAS_TOML = True
except ImportError:
    try:
        import tomli  # noqa: F401

        HAS_TOML = True
    except ImportError:
        HAS_TOML = False

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


class Results(unittest.TestCase):
    """Codes, and the arrays that they come in."""

    def test_anchors_of_the_default_engine(self):
        codes = Exponential()([-(1 << 31), 0, 8192, 65535, (1 << 31) - 1])
        # exp(-1) 65536 = 24109.35, exp(-65535 / 8192) 65536 = 21.98.
        self.assertEqual(codes.tolist(), [65535, 65535, 24109, 22, 22])

    def test_general_results_are_exponent_and_mantissa(self):
        codes = Exponential(output="general", input="S3.12")([0, 4096, -4096])
        values = (codes & 0x1FFFF) * 2.0 ** ((codes.view(np.int32) >> 17) - 16)
        self.assertEqual(values[0], 1.0)
        self.assertLess(np.abs(values[1:] / np.exp([1.0, -1.0]) - 1).max(), 2.0**-16)

    def test_all_forms_are_close(self):
        operands = np.arange(1 << 16)
        exact = np.minimum(np.exp(-operands / 8192) * 65536, 65535)
        for knobs in (
            {},
            {"early_out": True},
            {"form": "radix-4", "iterations": 8},
            {"form": "piecewise", "pipelined": True, "pieces": 128},
        ):
            error = np.abs(Exponential(**knobs)(operands) - exact)
            self.assertLess(error.max(), 1.0, knobs)

    def test_a_wrong_constant_changes_results(self):
        operands = np.arange(1 << 16)
        right = Exponential()(operands)
        exact = _constants.times_ln2
        with mock.patch.object(_constants, "times_ln2", lambda m, bits: exact(m, bits) + 1):
            self.assertTrue((Exponential()(operands) != right).any())

    def test_shapes_and_types(self):
        exp = Exponential()
        for operands in (5, [1, 2], np.zeros((2, 0), int), np.ones((2, 3), np.uint8)):
            codes = exp(operands)
            self.assertEqual((codes.shape, codes.dtype), (np.shape(operands), np.uint32))
        self.assertEqual(exp(np.array([8192], dtype=np.uint64)).tolist(), [24109])
        for operands in (0.5, [1.0], [True], ["1"]):
            self.assertRaisesRegex(TypeError, "integer codes", exp, operands)
        for operands in (1 << 31, -(1 << 31) - 1, np.array([1 << 63], dtype=np.uint64)):
            self.assertRaisesRegex(ValueError, "outside -2", exp, operands)


class Products(unittest.TestCase):
    """Products of more than 64 bits."""

    def test_products_are_exact(self):
        random = np.random.default_rng(1)
        a, b = random.integers(0, 1 << 62, (2, 1000)), random.integers(0, 1 << 40, (2, 1000))
        for x, y in zip(a, b):
            for drop in (40, 41, 63):
                found = _constants.product(x, y, drop).tolist()
                self.assertEqual(found, [int(p) * int(q) >> drop for p, q in zip(x, y)])
                half = 1 << (drop - 1)
                found = _constants.rounded_product(x, y, drop).tolist()
                self.assertEqual(found, [int(p) * int(q) + half >> drop for p, q in zip(x, y)])


class Files(unittest.TestCase):
    """Configuration files."""

    def read(self, text):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "own.toml"
            path.write_text(text)
            try:
                return Exponential.from_toml(path)
            except ValueError as error:
                raise ValueError(str(error).replace(str(path), "own.toml")) from None

    def error(self, text):
        with self.assertRaises(ValueError) as caught:
            self.read(text)
        return str(caught.exception)

    @unittest.skipUnless(HAS_TOML, "Python has no reader of TOML: from_toml says so")
    def test_the_presets_are_read(self):
        found = Exponential.from_toml(CONFIGS / "piecewise.toml")
        self.assertEqual(found, Exponential(form="piecewise", pieces=128, pipelined=True))
        self.assertEqual(Exponential.from_toml(str(CONFIGS / "paper.toml")), Exponential())
        self.assertEqual(self.read("[gu]\nbanks = 7\n"), Exponential())

    @unittest.skipUnless(HAS_TOML, "Python has no reader of TOML: from_toml says so")
    def test_errors_name_file_and_field(self):
        for text, wanted in (
            ("[vu", "own.toml: field `(the file)`: invalid TOML: "),
            ("vu = 3", "own.toml: field `vu`: found 3, expected a section of named values"),
            ("[vu]\nexp = 3", "own.toml: field `vu.exp`: found 3, expected a section of named values"),
            ("[vu.exp]\nmode = 3", "own.toml: field `vu.exp.mode`: no such field here: expected one"),
            ("[vu.exp]\ntail = 1", "own.toml: field `vu.exp.tail`: found 1, expected true or false"),
            ("[vu.exp]\noffset = 17", "own.toml: rule `exp-offset`: vu.exp.offset = 17; expected"),
        ):
            self.assertTrue(self.error(text).startswith(wanted), self.error(text))

    def test_no_reader_of_toml(self):
        with mock.patch.dict(sys.modules, {"tomllib": None, "tomli": None}):
            self.assertRaisesRegex(ImportError, "Python 3.11 or .*tomli", self.read, "")


class Registry(unittest.TestCase):
    """Forms and their names."""

    def test_names_of_forms_are_those_of_the_knob(self):
        self.assertEqual(tuple(_forms.FORMS), _knobs.CHOICES["form"])

    def test_unknown_knobs_are_refused(self):
        self.assertRaises(TypeError, Exponential, mode=1)
        self.assertRaisesRegex(ValueError, 'found "x", expected one of', Exponential, form="x")


if __name__ == "__main__":
    unittest.main()
