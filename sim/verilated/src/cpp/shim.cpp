// The C interface between one Verilator model and its Rust driver. No exception leaves it.
#include "Vm.h"
#include "verilated.h"
#if VM_TRACE
#include "verilated_vcd_c.h"
#endif
#include <cstdarg>
#include <cstdint>
#include <cstring>
#include <cstdio>
#include <exception>
#include <memory>
#include <mutex>
#include <string>

namespace {

constexpr int FINISH = 1, STOP = 2, FATAL = 3, EXCEPTION = 4;
constexpr size_t OUTPUT_LIMIT = 1 << 16;

struct Stopped {
    int cause;
    std::string text;
};

struct Sim {
    VerilatedContext ctx;
    std::unique_ptr<Vm> top;
#if VM_TRACE
    std::unique_ptr<VerilatedVcdC> vcd;
#endif
    std::string output, error;
    int seed = 1, cause = 0;
    bool started = false, dumped = false;
    uint64_t last_dump = 0;

    // Otherwise each model gets a pool of threads of its own, one for each core but one, though none
    // is built to run on more than one.
    Sim() { ctx.threads(1); }
};

thread_local Sim* current = nullptr;
// Verilator's seed is one per process, so models are built and first evaluated one at a time.
std::mutex seeding;

// Sets what Verilator keeps for each thread. Most calls come from the thread and the model of
// the one before, and setting it anew would write to memory that all threads share.
void enter(Sim* s) {
    if (__builtin_expect(current == s, 1)) return;
    current = s;
    Verilated::threadContextp(&s->ctx);
}

std::string at(const char* file, int line) {
    return file && *file ? std::string{file} + ":" + std::to_string(line) + ": " : std::string{};
}

int died(Sim* s, int cause, const std::string& text) {
    s->cause = cause;
    s->error = text;
    return cause;
}

template <class F>
int guarded(Sim* s, F&& body) {
    if (__builtin_expect(s->cause != 0, 0)) return s->cause;
    enter(s);
    try {
        body();
        return 0;
    } catch (const Stopped& e) {
        return died(s, e.cause, e.text);
    } catch (const std::exception& e) {
        return died(s, EXCEPTION, e.what());
    } catch (...) {
        return died(s, EXCEPTION, "unknown C++ exception");
    }
}

void eval(Sim* s) {
    if (__builtin_expect(!s->started, 0)) {
        const std::lock_guard<std::mutex> lock{seeding};
        s->started = true;
        s->ctx.randSeed(s->seed);
        s->top->eval();
    } else {
        s->top->eval();
    }
}

void dump(Sim* s) {
#if VM_TRACE
    if (s->vcd && s->vcd->isOpen()) {
        s->vcd->dump(s->ctx.time());
        s->dumped = true;
        s->last_dump = s->ctx.time();
    }
#endif
}

void half(Sim* s, uint8_t* clock, int level) {
    *clock = level;
    s->ctx.timeInc(1);
    eval(s);
    dump(s);
}

}  // namespace

void vl_fatal(const char* file, int line, const char*, const char* text) {
    throw Stopped{FATAL, at(file, line) + (text ? text : "fatal error")};
}
void vl_stop(const char* file, int line, const char*) { throw Stopped{STOP, at(file, line) + "$stop"}; }
void vl_finish(const char* file, int line, const char*) {
    throw Stopped{FINISH, at(file, line) + "$finish"};
}

extern "C" int potamoi_printf(const char* format, ...) {
    char text[4096];
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (current && n > 0 && current->output.size() < OUTPUT_LIMIT) current->output += text;
    return n;
}

#define API extern "C" __attribute__((visibility("default")))

API Sim* vs_new(int seed) {
    try {
        const std::lock_guard<std::mutex> lock{seeding};
        auto s = std::make_unique<Sim>();
        enter(s.get());
        s->seed = seed;
        s->ctx.randReset(2);
        s->ctx.randSeed(seed);
        s->ctx.traceEverOn(VM_TRACE);
        s->top = std::make_unique<Vm>(&s->ctx, "top");
        current = nullptr;
        return s.release();
    } catch (...) {
        current = nullptr;
        return nullptr;
    }
}

API void vs_delete(Sim* s) {
    guarded(s, [&] { s->top->final(); });
    try {
        const std::lock_guard<std::mutex> lock{seeding};
        enter(s);
#if VM_TRACE
        if (s->vcd) s->vcd->close();
#endif
        current = nullptr;
        delete s;
    } catch (...) {
        current = nullptr;
    }
}

API void* vs_port(Sim* s, uint32_t index) {
    auto& t = *s->top;
    switch (index) {
@PORTS@
    default: return nullptr;
    }
}

API int vs_eval(Sim* s) {
    return guarded(s, [&] { eval(s); });
}
API int vs_half(Sim* s, uint8_t* clock, int level) {
    return guarded(s, [&] { half(s, clock, level); });
}
API int vs_tick(Sim* s, uint8_t* clock) {
    return guarded(s, [&] {
        half(s, clock, 0);
        half(s, clock, 1);
    });
}
API int vs_cycle(Sim* s, uint8_t* clock, const uint32_t* in, uint32_t* out) {
    (void)in, (void)out;
    return guarded(s, [&] {
        auto& t = *s->top;
        (void)t;
@LOAD@
        half(s, clock, 0);
        half(s, clock, 1);
@STORE@
    });
}
API uint64_t vs_time(Sim* s) { return s->ctx.time(); }
API const char* vs_error(Sim* s) { return s->error.c_str(); }
API const char* vs_output(Sim* s) { return s->output.c_str(); }
API void vs_clear_output(Sim* s) { s->output.clear(); }

// 0 done, -1 not possible, else the cause the model died of.
API int vs_vcd_open(Sim* s, const char* path) {
    int done = -1;
#if VM_TRACE
    const int cause = guarded(s, [&] {
        if (!s->vcd) {
            s->vcd = std::make_unique<VerilatedVcdC>();
            s->top->trace(s->vcd.get(), 99);
        }
        if (s->vcd->isOpen()) s->vcd->close();
        s->vcd->open(path);
        s->dumped = false;
        done = s->vcd->isOpen() ? 0 : -1;
    });
    return cause ? cause : done;
#else
    return done;
#endif
}
API int vs_vcd_dump(Sim* s, uint64_t time) {
    int done = -1;
#if VM_TRACE
    const int cause = guarded(s, [&] {
        if (!s->vcd || !s->vcd->isOpen() || (s->dumped && time <= s->last_dump)) return;
        s->ctx.time(time);
        dump(s);
        done = 0;
    });
    return cause ? cause : done;
#else
    return done;
#endif
}
API int vs_vcd_close(Sim* s) {
    int done = -1;
#if VM_TRACE
    const int cause = guarded(s, [&] {
        if (!s->vcd || !s->vcd->isOpen()) return;
        s->vcd->close();
        done = 0;
    });
    return cause ? cause : done;
#else
    return done;
#endif
}
