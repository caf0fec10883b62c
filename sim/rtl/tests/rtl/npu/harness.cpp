// The Verilated potamoi_npu_ext as the device of the driver: bus, streams and interrupt. layout.h lists
// the fields of the words in the .hex files, highest first.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "Vpotamoi_npu_ext.h"
#include "driver.h"
#include "layout.h"
#include "verilated.h"

extern "C" {
uint32_t potamoi_npu_read(volatile void *device, uint32_t offset);
void potamoi_npu_write(volatile void *device, uint32_t offset, uint32_t value);
}

namespace {

constexpr int PATIENCE = 100000;  // clocks

// A word of a .hex file, bit 0 first.
using Bits = std::vector<bool>;

[[noreturn]] void fail(const std::string &what) {
  std::printf("FAIL: %s\n", what.c_str());
  std::exit(1);
}

std::vector<Bits> words_of(const std::string &file) {
  std::ifstream in(file);
  if (!in) fail(file + " is missing");
  std::vector<Bits> words;
  for (std::string line; std::getline(in, line);) {
    Bits bits;
    for (auto digit = line.rbegin(); digit != line.rend(); ++digit) {
      int value = std::stoi(std::string(1, *digit), nullptr, 16);
      for (int bit = 0; bit < 4; ++bit) bits.push_back(value >> bit & 1);
    }
    words.push_back(bits);
  }
  return words;
}

uint64_t number(const Bits &word, unsigned low, unsigned bits) {
  uint64_t value = 0;
  for (unsigned bit = 0; bit < bits && bit < 64; ++bit)
    value |= uint64_t(word[low + bit]) << bit;
  return value;
}

template <typename Port>
void put(Port &port, const Bits &word, unsigned low, unsigned bits) {
  port = Port(number(word, low, bits));
}
template <std::size_t N>
void put(VlWide<N> &port, const Bits &word, unsigned low, unsigned bits) {
  for (unsigned at = 0; at < bits; at += 32)
    port[at / 32] = uint32_t(number(word, low + at, bits - at < 32 ? bits - at : 32));
}

template <typename Port>
bool same(const Port &port, const Bits &word, unsigned low, unsigned bits) {
  return uint64_t(port) == number(word, low, bits);
}
template <std::size_t N>
bool same(const VlWide<N> &port, const Bits &word, unsigned low, unsigned bits) {
  for (unsigned at = 0; at < bits; at += 32)
    if (port[at / 32] != uint32_t(number(word, low + at, bits - at < 32 ? bits - at : 32))) return false;
  return true;
}

#define WIDTH(stream, field, bits) + (bits)
#define PUT(stream, field, bits) low -= (bits), put(top.stream##_##field, word, low, (bits));
#define SAME(stream, field, bits) \
  low -= (bits); \
  if (!same(top.stream##_##field, word, low, (bits))) fail("beat " + std::to_string(at) + " of " #stream "_" #field);

struct Device {
  VerilatedContext context;
  Vpotamoi_npu_ext top{&context};
  unsigned random = 1;
  std::vector<Bits> rit = words_of("gather_rit.hex"), mft = words_of("gather_mft.hex"),
                    feat = words_of("gather_feat.hex"), vec_in = words_of("vector_in.hex"),
                    vec_out = words_of("vector_out.hex");
  std::size_t rit_at = 0, mft_at = 0, feat_at = 0, vec_in_at = 0, vec_out_at = 0;

  bool willing() {
    random = random * 1664525u + 1013904223u;
    return random >> 30 != 0;
  }

  void show(const Bits &word, std::size_t which) {
    unsigned low;
    switch (which) {
      case 0: low = 0 RIT_FIELDS(WIDTH); RIT_FIELDS(PUT) break;
      case 1: low = 0 MFT_FIELDS(WIDTH); MFT_FIELDS(PUT) break;
      default: low = 0 VEC_IN_FIELDS(WIDTH); VEC_IN_FIELDS(PUT)
    }
  }

  void compare_features(std::size_t at) {
    if (at >= feat.size()) fail("a surplus beat of features");
    const Bits &word = feat[at];
    unsigned low = 0 FEAT_FIELDS(WIDTH);
    FEAT_FIELDS(SAME)
  }

  void compare_results(std::size_t at) {
    if (at >= vec_out.size()) fail("a surplus beat of results");
    const Bits &word = vec_out[at];
    unsigned low = 0 VEC_OUT_FIELDS(WIDTH);
    VEC_OUT_FIELDS(SAME)
  }

  // One clock: sources offer all that they have, and the sinks pause now and then.
  void clock() {
    top.s_axis_rit_tvalid = rit_at < rit.size();
    if (top.s_axis_rit_tvalid) show(rit[rit_at], 0);
    top.s_axis_mft_tvalid = mft_at < mft.size();
    if (top.s_axis_mft_tvalid) show(mft[mft_at], 1);
    top.s_axis_vec_tvalid = vec_in_at < vec_in.size();
    if (top.s_axis_vec_tvalid) show(vec_in[vec_in_at], 2);
    top.m_axis_feat_tready = willing();
    top.m_axis_vec_tready = willing();
    top.clk = 0;
    top.eval();
    rit_at += top.s_axis_rit_tvalid && top.s_axis_rit_tready;
    mft_at += top.s_axis_mft_tvalid && top.s_axis_mft_tready;
    vec_in_at += top.s_axis_vec_tvalid && top.s_axis_vec_tready;
    if (top.m_axis_feat_tvalid && top.m_axis_feat_tready) compare_features(feat_at++);
    if (top.m_axis_vec_tvalid && top.m_axis_vec_tready) compare_results(vec_out_at++);
    top.clk = 1;
    top.eval();
  }

  // A transfer of one channel: clocks until valid and ready meet.
  template <typename Valid, typename Ready>
  void meet(Valid &&set, Ready &&is_ready, const char *what) {
    for (int waited = 0; waited < PATIENCE; ++waited) {
      set(1);
      top.clk = 0;
      top.eval();
      bool meets = is_ready();
      clock();
      if (meets) return set(0);
    }
    fail(what);
  }
};

}  // namespace

uint32_t potamoi_npu_read(volatile void *device, uint32_t offset) {
  Device &d = *static_cast<Device *>(const_cast<void *>(device));
  d.top.s_axil_araddr = offset;
  d.meet([&](int v) { d.top.s_axil_arvalid = v; }, [&] { return d.top.s_axil_arready; }, "arready");
  uint32_t value = 0;
  d.meet([&](int v) { d.top.s_axil_rready = v; },
         [&] {
           value = d.top.s_axil_rdata;
           if (d.top.s_axil_rvalid && d.top.s_axil_rresp != 0) fail("rresp");
           return d.top.s_axil_rvalid;
         },
         "rvalid");
  return value;
}

void potamoi_npu_write(volatile void *device, uint32_t offset, uint32_t value) {
  Device &d = *static_cast<Device *>(const_cast<void *>(device));
  d.top.s_axil_awaddr = offset;
  d.top.s_axil_wdata = value;
  d.top.s_axil_wstrb = 15;
  d.meet([&](int v) { d.top.s_axil_awvalid = v; }, [&] { return d.top.s_axil_awready; }, "awready");
  d.meet([&](int v) { d.top.s_axil_wvalid = v; }, [&] { return d.top.s_axil_wready; }, "wready");
  d.meet([&](int v) { d.top.s_axil_bready = v; },
         [&] {
           if (d.top.s_axil_bvalid && d.top.s_axil_bresp != 0) fail("bresp");
           return d.top.s_axil_bvalid;
         },
         "bvalid");
}

int wait_for_interrupt(volatile void *device) {
  Device &d = *static_cast<Device *>(const_cast<void *>(device));
  for (int waited = 0; waited < PATIENCE; ++waited) {
    if (d.top.irq) return 1;
    d.clock();
  }
  return 0;
}

void complain(const char *what, uint32_t found, uint32_t expected) {
  std::printf("%s: %u, expected %u\n", what, found, expected);
}

#define FIELD(stream, field, bits) low -= (bits); const uint64_t stream##_##field = number(word, low, (bits)); (void)stream##_##field;

int main() {
  Device device;
  device.top.rst_n = 0;
  for (int i = 0; i < 4; ++i) device.clock();
  device.top.rst_n = 1;
  if (!open_device(&device)) fail("the device is not the one of the header");
  // Ends of packets up to a beat, by the lowest bits of a field that the layout names.
  auto ends = [](const std::vector<Bits> &words, std::size_t from, std::size_t to, unsigned last) {
    uint32_t count = 0;
    for (; from < to; ++from) count += words[from][last];
    return count;
  };
  unsigned jobs = 0;
  std::size_t before = 0;
  for (const Bits &word : words_of("gather_jobs.hex")) {
    unsigned low = 0 GATHER_JOB_FIELDS(WIDTH);
    const uint64_t job_cfg_two_records = 0, job_cfg_channels = 0;
    (void)job_cfg_two_records, (void)job_cfg_channels;
    struct gather_job own;
    {
      GATHER_JOB_FIELDS(FIELD)
      // Jobs that raise flags, or use beats again, come last, and are for the unit alone.
      if (job_stat_errors != 0 || job_m_axis_feat_from != before) break;
      own = {uint32_t(job_cfg_vertices), uint32_t(job_cfg_segments), uint32_t(job_cfg_two_records),
             uint32_t(job_cfg_channels), ends(device.feat, before, job_m_axis_feat_end, FEAT_LAST),
             uint32_t(job_stat_entries), uint32_t(job_stat_errors)};
      before = job_m_axis_feat_end;
    }
    if (!run_gather(&device, &own)) fail("gathering job " + std::to_string(jobs));
    if (device.feat_at != before) fail("beats of features");
    ++jobs;
  }
  before = 0;
  for (const Bits &word : words_of("vector_jobs.hex")) {
    unsigned low = 0 VECTOR_JOB_FIELDS(WIDTH);
    VECTOR_JOB_FIELDS(FIELD)
    if (job_stat_errors != 0 || job_m_axis_vec_from != before) break;
    struct vector_job own = {ends(device.vec_out, before, job_m_axis_vec_end, VEC_OUT_LAST),
                             uint32_t(job_stat_vectors), uint32_t(job_stat_errors)};
    before = job_m_axis_vec_end;
    if (!run_vector(&device, &own)) fail("vector job " + std::to_string(jobs));
    if (device.vec_out_at != before) fail("beats of results");
    ++jobs;
  }
  std::printf("PASS: %u jobs\n", jobs);
  return 0;
}
