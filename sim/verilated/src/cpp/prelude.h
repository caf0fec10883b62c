// Included before everything compiled for a model: what Verilog prints goes to the shim.
#pragma once
extern "C" int potamoi_printf(const char* format, ...) __attribute__((format(printf, 1, 2)));
#define VL_PRINTF potamoi_printf
