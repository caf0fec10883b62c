// A C++ test bench: stimulus from a file, two evaluations a cycle, all outputs folded.
// It waits for each round, so that another driver can take turns with it.
#include "Vm.h"
#include "verilated.h"
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
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

static uint64_t drive(const std::vector<uint32_t>& stimulus, long long& ns) {
    VerilatedContext ctx;
    ctx.threads(1);
    ctx.randReset(2);
    ctx.randSeed(2);
    Vm top{&ctx, "top"};
    const uint32_t* const end = stimulus.data() + stimulus.size();
    uint64_t sum = 0;
    const std::clock_t start = std::clock();
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
    ns = static_cast<long long>(std::clock() - start) * (1000000000 / CLOCKS_PER_SEC);
    return sum;
}

// One round for each line of input.
int main(int, char** argv) {
    std::ifstream file{argv[1], std::ios::binary | std::ios::ate};
    std::vector<uint32_t> stimulus(static_cast<size_t>(file.tellg()) / 4);
    file.seekg(0);
    file.read(reinterpret_cast<char*>(stimulus.data()), stimulus.size() * 4);
    if (!file) give_up(argv[1], 0, "cannot be read");
    for (int c; (c = std::getchar()) != EOF;) {
        long long ns = 0;
        const uint64_t sum = drive(stimulus, ns);
        std::printf("%lld %016llx\n", ns, static_cast<unsigned long long>(sum));
        std::fflush(stdout);
    }
}
