/* A driver of potamoi_npu_ext, as software of an SoC has it. */
#ifndef DRIVER_H
#define DRIVER_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A job of the gathering unit, and what must come of it. */
struct gather_job {
  uint32_t vertices;  /* log2 */
  uint32_t segments;
  uint32_t two_records;
  uint32_t channels;
  uint32_t packets;
  uint32_t entries;
  uint32_t errors;
};

/* A job of the vector unit, and what must come of it. */
struct vector_job {
  uint32_t packets;
  uint32_t vectors;
  uint32_t errors;
};

/* Returns when the interrupt is high, or with 0 when it stays low for too long. */
int wait_for_interrupt(volatile void *device);

/* What the driver says before it fails. */
void complain(const char *what, uint32_t found, uint32_t expected);

/* Identifies the block, and enables the interrupts of jobs that are done. */
int open_device(volatile void *device);

/* Runs a job, with either unit; 0 when something is wrong. */
int run_gather(volatile void *device, const struct gather_job *job);
int run_vector(volatile void *device, const struct vector_job *job);

#ifdef __cplusplus
}
#endif

#endif
