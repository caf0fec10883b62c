"""Rows of a sweep as Parquet."""

import contextlib
import importlib.util
import io
import json
import os
import tempfile
import unittest

from potamoi import parquet

HEADER = "key,vu.lanes,clock_ghz,gu.on,system.memory,machine,scene,width,memory_channels,clock_ghz,fps,refused\n"
CSV = HEADER + (
    'k0,6,reached,true,hbm,paper,garden,64,2,1.5,100.25,\n'
    'k1,12,0.5,false,7,paper,garden,64,2,,1e3,\n'
    'k2,24,1.0,true,hbm,paper,garden,,,,,"a, b"\n'
)


@unittest.skipUnless(importlib.util.find_spec("pyarrow"), "PyArrow is missing: tools/setup dask")
class ParquetTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def file(self, name, text=None):
        path = os.path.join(self.folder, name)
        if text is not None:
            with open(path, "w", encoding="utf-8") as file:
                file.write(text)
        return path

    def test_columns_have_types_and_unknown_figures_are_null(self):
        from pyarrow import parquet as read

        out = self.file("r.parquet")
        self.assertEqual(parquet.write(self.file("rows.csv", CSV), out), 3)
        table = read.read_table(out)
        types = {field.name: str(field.type) for field in table.schema}
        self.assertEqual(types, {
            "key": "string", "vu.lanes": "int64", "varied.clock_ghz": "string", "gu.on": "bool", "system.memory": "string",
            "machine": "string", "scene": "string", "width": "int64", "memory_channels": "int64", "clock_ghz": "double",
            "fps": "double", "refused": "string"})
        rows = table.to_pylist()
        self.assertEqual([row["fps"] for row in rows], [100.25, 1000.0, None])
        self.assertEqual([row["vu.lanes"] for row in rows], [6, 12, 24])
        self.assertEqual([row["gu.on"] for row in rows], [True, False, True])
        self.assertEqual([row["clock_ghz"] for row in rows], [1.5, None, None])
        self.assertEqual([row["refused"] for row in rows], [None, None, "a, b"])
        self.assertEqual(os.listdir(self.folder).count("r.parquet"), 1)
        self.assertEqual(len(os.listdir(self.folder)), 2)

    def test_a_report_has_the_same_columns(self):
        row = {"key": "k0", "vu.lanes": "6", "machine": "paper", "width": 64, "fps": 100.5, "refused": None,
               "on_front": True}
        report = {"command": "sweep", "rows": [row, dict(row, key="k1", fps=None, on_front=False)]}
        table = parquet.table(self.file("r.json", json.dumps(report)))
        self.assertEqual(table.column("fps").to_pylist(), [100.5, None])
        self.assertEqual(table.column("vu.lanes").to_pylist(), [6, 6])
        self.assertEqual(table.column("on_front").to_pylist(), [True, False])

    def test_what_is_no_sweep_is_refused(self):
        for name, text in [("a.csv", "a,b\n1,2\n"), ("b.csv", ""), ("c.json", "[]"), ("d.json", "{"),
                           ("e.csv", CSV + "k3,1\n")]:
            said = io.StringIO()
            with contextlib.redirect_stderr(said):
                self.assertEqual(parquet.main([self.file(name, text), self.file("out.parquet")]), 2)
            self.assertIn("error: ", said.getvalue())
            self.assertFalse(os.path.exists(self.file("out.parquet")))


if __name__ == "__main__":
    unittest.main()
