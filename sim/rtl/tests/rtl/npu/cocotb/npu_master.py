"""A foreign master of potamoi_npu_ext: cocotb with the bus models of cocotbext-axi.

It runs in a folder of emitted Verilog with its benches. The environment says what and how:
NPU_LAYOUT is the JSON file with the fields of the words of the .hex files, NPU_GAPS the percentage of
clocks in which sources and sinks pause, NPU_SEED the seed of the pauses.
"""

import itertools
import json
import os
import random
from pathlib import Path

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge, with_timeout
from cocotbext.axi import (
    AxiLiteBus,
    AxiLiteMaster,
    AxiResp,
    AxiStreamBus,
    AxiStreamFrame,
    AxiStreamSink,
    AxiStreamSource,
)

GAPS = int(os.environ["NPU_GAPS"])
SEED = int(os.environ["NPU_SEED"])
FOLDER = Path(os.environ["NPU_FOLDER"])
LAYOUT = json.loads(Path(os.environ["NPU_LAYOUT"]).read_text(encoding="utf-8"))
MAP = json.loads((FOLDER / "registers" / "potamoi_npu.json").read_text(encoding="utf-8"))
REGISTERS = {own["name"]: own for own in MAP["registers"]}
# Clocks after which a job counts as hanging.
PATIENCE = 20_000


def mask(register, field):
    """The bits of a field in its register."""
    own = next(f for f in REGISTERS[register]["fields"] if f["name"] == field)
    return ((1 << own["width"]) - 1) << own["low"]


def words(name):
    """The words of a .hex file, each a dictionary of its fields."""
    own = LAYOUT[name]
    found = []
    for line in (FOLDER / "sim" / own["file"]).read_text(encoding="utf-8").split():
        value = int(line, 16)
        word = {}
        for field, bits in reversed(own["fields"]):
            word[field] = value & ((1 << bits) - 1)
            value >>= bits
        found.append(word)
    return found


def packets(beats, stream):
    """Beats as frames, one a packet. Every byte has the sideband of its beat."""
    bits = dict(LAYOUT[stream]["fields"])
    size = bits["tdata"] // 8
    found, data, keep, user = [], bytearray(), [], []
    for beat in beats:
        data += beat["tdata"].to_bytes(size, "little")
        kept = beat.get("tkeep", (1 << size) - 1)
        keep += [kept >> byte & 1 for byte in range(size)]
        user += [beat.get("tuser", 0)] * size
        if beat["tlast"]:
            found.append(AxiStreamFrame(bytes(data), tkeep=keep, tuser=user))
            data, keep, user = bytearray(), [], []
    assert not data, f"{stream}: a packet without an end"
    return found


def pauses(generator):
    """An endless pattern of pauses, in bursts."""
    while True:
        rate = generator.choice([0, GAPS, (100 + GAPS) // 2]) if GAPS else 0
        for _ in range(16):
            yield generator.randrange(100) < rate


class Master:
    """The device under test with masters and sinks at all of its ports."""

    def __init__(self, dut):
        self.dut = dut
        # Packets that each sink had when the last interrupt came.
        self.received = {}
        generator = random.Random(SEED)
        cocotb.start_soon(Clock(dut.clk, 10, unit="ns").start())
        reset = {"reset": dut.rst_n, "reset_active_level": False}
        dut.rst_n.value = 0
        self.bus = AxiLiteMaster(AxiLiteBus.from_prefix(dut, "s_axil"), dut.clk, **reset)
        self.sources = {
            name: AxiStreamSource(AxiStreamBus.from_prefix(dut, name), dut.clk, **lanes(name), **reset)
            for name in ("s_axis_rit", "s_axis_mft", "s_axis_vec")
        }
        self.sinks = {
            name: AxiStreamSink(AxiStreamBus.from_prefix(dut, name), dut.clk, **lanes(name), **reset)
            for name in ("m_axis_feat", "m_axis_vec")
        }
        channels = [
            self.bus.write_if.aw_channel,
            self.bus.write_if.w_channel,
            self.bus.write_if.b_channel,
            self.bus.read_if.ar_channel,
            self.bus.read_if.r_channel,
        ]
        for model in itertools.chain(self.sources.values(), self.sinks.values(), channels):
            model.set_pause_generator(pauses(random.Random(generator.random())))

    async def reset(self):
        """Some clocks of reset."""
        self.dut.rst_n.value = 0
        await ClockCycles(self.dut.clk, 4)
        self.dut.rst_n.value = 1
        await RisingEdge(self.dut.clk)

    async def write(self, register, value):
        """Writes a register."""
        done = await self.bus.write(REGISTERS[register]["offset"], value.to_bytes(4, "little"))
        assert done.resp == AxiResp.OKAY, (register, done.resp)

    async def read(self, register):
        """The value of a register."""
        done = await self.bus.read(REGISTERS[register]["offset"], 4)
        assert done.resp == AxiResp.OKAY, (register, done.resp)
        return int.from_bytes(done.data, "little")

    async def interrupt(self):
        """Waits for the interrupt, and takes its events."""
        for _ in range(PATIENCE):
            if self.dut.irq.value == 1:
                break
            await RisingEdge(self.dut.clk)
        else:
            raise AssertionError(f"no interrupt in {PATIENCE} clocks")
        self.received = {name: sink.count() for name, sink in self.sinks.items()}
        events = await self.read("IRQ_STATUS")
        await self.write("IRQ_STATUS", events)
        return events


def lanes(stream):
    """Bytes of a beat, where no tkeep says how many there are."""
    fields = dict(LAYOUT[stream]["fields"])
    return {} if "tkeep" in fields else {"byte_lanes": fields["tdata"] // 8}


def jobs():
    """The jobs of both units: beats and settings."""
    found = []
    for unit, short, inputs, output in [
        ("gather_jobs", "GU", ("s_axis_rit", "s_axis_mft"), "m_axis_feat"),
        ("vector_jobs", "VU", ("s_axis_vec",), "m_axis_vec"),
    ]:
        beats = {name: words(name) for name in (*inputs, output)}
        for job in words(unit):
            own = {"short": short, "inputs": {}, "job": job, "output": output}
            for name in beats:
                # A later job may take the beats of an earlier one again.
                cut = beats[name][job[f"{name}_from"]:job[f"{name}_end"]]
                if name == output:
                    own["expected"] = cut
                else:
                    own["inputs"][name] = cut
            # One without packets breaks a promise, and has no end that an interrupt tells.
            if own["expected"]:
                found.append(own)
    return found


def mode(job):
    """The word of GU_MODE of a job."""
    word = 0
    for own in REGISTERS["GU_MODE"]["fields"]:
        word |= job[f"cfg_{own['name'].lower()}"] << own["low"]
    return word


async def begin(master, own):
    """Sends the beats of a job, and starts it."""
    for name, beats in own["inputs"].items():
        for frame in packets(beats, name):
            await master.sources[name].send(frame)
    short = own["short"]
    if short == "GU":
        await master.write("GU_MODE", mode(own["job"]))
    ends = sum(beat["tlast"] for beat in own["expected"])
    await master.write(f"{short}_PACKETS", ends)
    await master.write("CONTROL", mask("CONTROL", f"{short}_START"))


def events(own):
    """The events of a job: done, and an error where a beat breaks a promise."""
    found = mask("IRQ_STATUS", f"{own['short']}_DONE")
    if own["job"]["stat_errors"]:
        found |= mask("IRQ_STATUS", f"{own['short']}_ERROR")
    return found


async def finish(master, own):
    """Compares what a job gave: frames, counters, flags."""
    sink = master.sinks[own["output"]]
    frames = packets(own["expected"], own["output"])
    assert master.received[own["output"]] == len(frames), "the interrupt came before the last packet"
    for frame in frames:
        found = await with_timeout(sink.recv(compact=False), 1, "ms")
        assert found.tdata == frame.tdata, own["output"]
        assert list(found.tkeep) == list(frame.tkeep), own["output"]
        if "tuser" in dict(LAYOUT[own["output"]]["fields"]):
            # The sink repeats the sideband of a beat for its bytes.
            assert list(found.tuser) == list(frame.tuser), own["output"]
    assert sink.empty(), f"a surplus packet of {own['output']}"
    await master.write("CONTROL", mask("CONTROL", "SNAPSHOT"))
    short, counter = own["short"], {"GU": "entries", "VU": "vectors"}[own["short"]]
    assert await master.read(f"{short}_{counter.upper()}") == own["job"][f"stat_{counter}"]
    assert await master.read(f"{short}_ERRORS") == own["job"]["stat_errors"]


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def registers_after_reset(dut):
    """Every register has its reset value; other addresses and read-only registers refuse."""
    master = Master(dut)
    await master.reset()
    for own in MAP["registers"]:
        assert await master.read(own["name"]) == own["reset"], own["name"]
        if own["access"] in ("constant", "status"):
            done = await master.bus.write(own["offset"], bytes(4))
            assert done.resp == AxiResp.SLVERR, own["name"]
    for hole in (0x060, 0xFFC):
        assert (await master.bus.read(hole, 4)).resp == AxiResp.SLVERR
        assert (await master.bus.write(hole, bytes(4))).resp == AxiResp.SLVERR
    # A write of one byte leaves the others.
    await master.write("GU_PACKETS", 0x01020304)
    await master.bus.write(REGISTERS["GU_PACKETS"]["offset"] + 2, b"\xee")
    assert await master.read("GU_PACKETS") == 0x01EE0304


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def all_jobs(dut):
    """The jobs of both units, one after the other."""
    master = Master(dut)
    await master.reset()
    await master.write("IRQ_ENABLE", mask("IRQ_STATUS", "GU_DONE") | mask("IRQ_STATUS", "VU_DONE"))
    for own in jobs():
        await master.write("CONTROL", mask("CONTROL", "CLEAR"))
        await begin(master, own)
        assert await master.interrupt() == events(own)
        await finish(master, own)


@cocotb.test(timeout_time=4, timeout_unit="ms")
async def reset_in_a_job(dut):
    """A job that a reset cuts off at any clock is forgotten, and the next one is right."""
    master = Master(dut)
    await master.reset()
    generator = random.Random(SEED)
    first = {own["short"]: own for own in reversed(jobs())}
    for own in first.values():
        for _ in range(3):
            await begin(master, own)
            await ClockCycles(dut.clk, generator.randrange(1, 120))
            await master.reset()
            for model in itertools.chain(master.sources.values(), master.sinks.values()):
                model.clear()
            status = mask("STATUS", "GU_IDLE") | mask("STATUS", "VU_IDLE")
            assert await master.read("STATUS") == status
            assert await master.read("IRQ_STATUS") == 0
        await master.write("IRQ_ENABLE", mask("IRQ_STATUS", f"{own['short']}_DONE"))
        await begin(master, own)
        assert await master.interrupt() == events(own)
        await finish(master, own)
