"""Tests of what the package reads: traces, register maps, reports and sweeps."""

import importlib.util
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import numpy as np
from potamoi import Reducer, RegisterMap, Trace, program
from potamoi.program import ProgramError

ROOT = Path(__file__).resolve().parents[2]
MAP = ROOT / "rtl_out" / "paper" / "registers" / "potamoi_npu.json"
HAS_PANDAS = importlib.util.find_spec("pandas") is not None
NEEDS_PANDAS = unittest.skipUnless(HAS_PANDAS, "pandas is missing: pip install pandas")


def arrays():
    """Arrays of a small trace: an MVoxel of two rows and two entries, and one operation."""
    one = 1 << 15
    return {
        "gather_tasks": np.array([[2, 1, 2, 2]], "<u4"),
        "gather_rows": np.array([100, 200], "<i2"),
        "gather_slots": np.array([5, 6], "<u4"),
        "gather_entry_rows": np.array([[0, 1] + [0] * 6, [1, 0] + [0] * 6], "<u2"),
        "gather_entry_weights": np.array([[one // 2, one // 2] + [0] * 6, [one, 0] + [0] * 6], "<u2"),
        "gather_features": np.array([150, 200], "<i2"),
        "vector_ops": np.array([[3, 1, 2, 2]], "<u4"),
        "vector_a": np.array([1, 2], "<i4"),
        "vector_b": np.array([3, 4], "<i4"),
        "vector_results": np.array([4, 6], "<i4"),
    }


class Folder(unittest.TestCase):
    def setUp(self):
        own = tempfile.TemporaryDirectory()
        self.addCleanup(own.cleanup)
        self.folder = Path(own.name)

    def text(self, name, text):
        (self.folder / name).write_text(text)
        return self.folder / name


class TraceTest(Folder):
    def write(self, change=lambda own: None, version=1):
        own = arrays()
        listed = [{"name": n, "dtype": a.dtype.str, "shape": list(a.shape), "digest": ""} for n, a in own.items()]
        formats = [["feature", "signed, 16 bits"], ["weight", "U1.15"]]
        header = {"format_version": version, "scene": "s", "configuration": "c", "formats": formats, "arrays": listed}
        change(own)
        path = self.folder / f"t{version}.npz"
        np.savez(path, header=np.frombuffer(json.dumps(header).encode(), np.uint8), **own)
        return path

    def test_tasks_are_views_whose_results_the_reducer_gives(self):
        trace = Trace.read(self.write())
        self.assertEqual((trace.feature_bits, trace.weight_bits, trace.is_exact), (16, 15, False))
        (task,) = trace.tasks()
        found = Reducer().gather(task.rows, task.entry_rows, task.entry_weights, task.vertices)
        np.testing.assert_array_equal(found, task.features)
        (own,) = trace.operations()
        self.assertEqual((own.code, own.shift, own.rounding, own.results.tolist()), (3, 1, "half-even", [4, 6]))

    def test_files_that_are_no_trace_are_refused(self):
        cut = lambda own: own.update(gather_rows=own["gather_rows"][:1])
        for path, word in (
            (self.write(cut, 1), "array `gather_rows` is not the one of its header"),
            (self.write(version=2), "format_version is 2: expected 1"),
            (self.text("n.npz", "no"), "expected a file of `potamoi trace`"),
        ):
            with self.assertRaises(ValueError) as caught:
                Trace.read(path)
            self.assertIn(word, str(caught.exception))
        with self.assertRaises(OSError):
            Trace.read(self.folder / "none.npz")

    @NEEDS_PANDAS
    def test_tasks_are_a_table(self):
        self.assertEqual(Trace.read(self.write()).frame().to_dict("list")["entries"], [2])


class RegistersTest(Folder):
    def test_values_of_the_checked_in_map_are_decoded_and_encoded(self):
        registers = RegisterMap.read(MAP)
        self.assertEqual((registers.name, registers["ID"].offset), ("potamoi_npu", 0))
        self.assertEqual(len({own.offset for own in registers}), len(registers))
        for own in registers:
            self.assertEqual(own.encode(**own.decode(own.reset)), own.reset)
        major = registers["VERSION"].decode(0x0003_0007)
        self.assertEqual(major, {"MINOR": 7, "MAJOR": 3})

    def test_values_that_do_not_fit_are_refused(self):
        control = RegisterMap.read(MAP)["CONTROL"]
        with self.assertRaisesRegex(ValueError, "no field STRT: expected some of GU_START"):
            control.encode(STRT=1)
        with self.assertRaisesRegex(ValueError, "2 does not fit 1 bits"):
            control.encode(GU_START=2)
        with self.assertRaisesRegex(ValueError, "does not fit 32 bits"):
            control.decode(1 << 32)
        with self.assertRaisesRegex(ValueError, "expected the JSON register map"):
            RegisterMap.read(self.text("r.json", "{}"))

    @NEEDS_PANDAS
    def test_fields_are_a_table(self):
        frame = RegisterMap.read(MAP).frame()
        self.assertEqual(list(frame[frame.register == "VERSION"].field), ["MINOR", "MAJOR"])


@NEEDS_PANDAS
class FramesTest(Folder):
    CSV = "key,vu.lanes,machine,width,fps,mm2,refused\na,12,m,64,10,1,\nb,24,m,64,20,2,\nc,48,m,64,15,3,\nd,96,m,,,,no\n"

    def test_rows_of_a_sweep_are_typed(self):
        from potamoi import frames

        rows = frames.sweep(self.text("rows.csv", self.CSV))
        kinds = {name: str(kind) for name, kind in rows.dtypes.items()}
        self.assertEqual((kinds["vu.lanes"], kinds["width"], kinds["fps"]), ("Int64", "Int64", "Float64"))
        self.assertTrue(rows.fps.isna().iloc[3])
        # c has fewer frames a second than b, on more area.
        self.assertEqual(list(frames.front(rows, fps="max", mm2="min").key), ["a", "b"])
        with self.assertRaisesRegex(ValueError, "no column gold"):
            frames.front(rows, gold="max")

    def test_lists_of_a_report_are_tables(self):
        from potamoi import frames

        report = {"format_version": 1, "command": "x", "size": [4, 3], "scenes": [
            {"name": "a", "clock": {"ghz": 1.0}, "runs": [{"ms": 1}, {"ms": 2}]},
            {"name": "b", "clock": {"ghz": 2.0}, "runs": [{"ms": 3}]}]}
        found = frames.report(self.text("r.json", json.dumps(report)))
        self.assertEqual(sorted(found), ["", "scenes", "scenes.runs"])
        self.assertEqual(found["scenes"].to_dict("list"), {"name": ["a", "b"], "clock.ghz": [1.0, 2.0]})
        self.assertEqual(found["scenes.runs"].to_dict("list"), {"scenes": [0, 0, 1], "ms": [1, 2, 3]})
        self.assertEqual(found[""]["size"].iloc[0], [4, 3])
        with self.assertRaisesRegex(ValueError, "expected a report of --json"):
            frames.report(self.text("l.json", "[]"))


class ProgramTest(Folder):
    def test_a_run_gives_its_output_or_its_error(self):
        own = self.text("potamoi", "#!/bin/sh\necho \"$1\"; echo 'error: no' >&2; exit \"$2\"\n")
        own.chmod(0o755)
        with mock.patch.dict("os.environ", POTAMOI=str(own)):
            self.assertEqual(program.run("a", 0), "a\n")
            with self.assertRaises(ProgramError) as caught:
                program.run("a", 2)
            self.assertEqual((caught.exception.status, str(caught.exception)), (2, "error: no"))

    def test_what_to_do_without_the_program_is_told(self):
        for platform, word in (("linux", "pip install ./python"), ("darwin", "runs on Linux")):
            with (
                mock.patch.dict("os.environ", PATH="", clear=True),
                mock.patch("shutil.which", return_value=None),
                mock.patch("sys.platform", platform),
                self.assertRaisesRegex(FileNotFoundError, word),
            ):
                program.path()


if __name__ == "__main__":
    unittest.main()
