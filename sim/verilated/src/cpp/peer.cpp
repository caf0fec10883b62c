// A C++ test bench: stimulus from a file, two evaluations a cycle, all outputs folded.
#include "Vm.h"
#include "verilated.h"
#include <chrono>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

static constexpr uint64_t PRIME = @PRIME@;
static constexpr size_t WORDS = @WORDS@;

static void give_up(const char* file, int line, const char* text) {
    std::fprintf(stderr, "%s:%d: %s\n", file ? file : "", line, text);
    std::_Exit(1);
}
void vl_fatal(const char* file, int line, const char*, const char* text) { give_up(file, line, text); }
void vl_stop(const char* file, int line, const char*) { give_up(file, line, "$stop"); }
void vl_finish(const char* file, int line, const char*) { give_up(file, line, "$finish"); }
extern "C" int potamoi_printf(const char* format, ...) {
    va_list args;
    va_start(args, format);
    const int n = std::vfprintf(stderr, format, args);
    va_end(args);
    return n;
}

int main(int, char** argv) {
    std::ifstream file{argv[1], std::ios::binary};
    const std::vector<char> bytes{std::istreambuf_iterator<char>{file}, {}};
    std::vector<uint32_t> stimulus(bytes.size() / 4);
    std::memcpy(stimulus.data(), bytes.data(), stimulus.size() * 4);

    VerilatedContext ctx;
    ctx.randReset(2);
    ctx.randSeed(2);
    Vm top{&ctx, "top"};
    const auto start = std::chrono::steady_clock::now();
    uint64_t sum = 0;
    const uint32_t* const end = stimulus.data() + stimulus.size();
    for (const uint32_t* in = stimulus.data(); in != end; in += WORDS) {
@SET@
        top.@CLOCK@ = 0;
        ctx.timeInc(1);
        top.eval();
        top.@CLOCK@ = 1;
        ctx.timeInc(1);
        top.eval();
@READ@
    }
    const auto ns = std::chrono::nanoseconds{std::chrono::steady_clock::now() - start}.count();
    std::printf("%lld %016llx\n", static_cast<long long>(ns), static_cast<unsigned long long>(sum));
}
