/* A driver of potamoi_npu_ext in C99, with nothing of the hardware but its header. */
#define POTAMOI_NPU_OWN_BUS
#include "potamoi_npu.h"

#include "driver.h"

static int is(const char *what, uint32_t found, uint32_t expected) {
  if (found != expected) complain(what, found, expected);
  return found == expected;
}

static int done(volatile void *device, uint32_t event) {
  if (!wait_for_interrupt(device)) {
    complain("interrupt", 0u, 1u);
    return 0;
  }
  return is("events", potamoi_npu_take_events(device), event);
}

int open_device(volatile void *device) {
  if (!is("known", (uint32_t)potamoi_npu_is_known(device), 1u)) return 0;
  potamoi_npu_write(device, POTAMOI_NPU_IRQ_ENABLE_OFFSET,
                    POTAMOI_NPU_IRQ_ENABLE_GU_DONE_MASK | POTAMOI_NPU_IRQ_ENABLE_VU_DONE_MASK);
  return is("status", potamoi_npu_read(device, POTAMOI_NPU_STATUS_OFFSET), POTAMOI_NPU_STATUS_RESET);
}

int run_gather(volatile void *device, const struct gather_job *job) {
  uint32_t mode = POTAMOI_NPU_SET(job->vertices, GU_MODE, VERTICES)
      | POTAMOI_NPU_SET(job->segments, GU_MODE, SEGMENTS);
#ifdef POTAMOI_NPU_GU_MODE_TWO_RECORDS_MASK
  mode |= POTAMOI_NPU_SET(job->two_records, GU_MODE, TWO_RECORDS);
#endif
#ifdef POTAMOI_NPU_GU_MODE_CHANNELS_MASK
  mode |= POTAMOI_NPU_SET(job->channels, GU_MODE, CHANNELS);
#endif
  potamoi_npu_clear(device);
  potamoi_npu_start_gather(device, mode, job->packets);
  if (!done(device, POTAMOI_NPU_IRQ_STATUS_GU_DONE_MASK)) return 0;
  potamoi_npu_snapshot(device);
  return is("entries", potamoi_npu_read(device, POTAMOI_NPU_GU_ENTRIES_OFFSET), job->entries)
      && is("errors", potamoi_npu_read(device, POTAMOI_NPU_GU_ERRORS_OFFSET), job->errors);
}

int run_vector(volatile void *device, const struct vector_job *job) {
  potamoi_npu_clear(device);
  potamoi_npu_start_vector(device, job->packets);
  if (!done(device, POTAMOI_NPU_IRQ_STATUS_VU_DONE_MASK)) return 0;
  potamoi_npu_snapshot(device);
  return is("vectors", potamoi_npu_read(device, POTAMOI_NPU_VU_VECTORS_OFFSET), job->vectors)
      && is("errors", potamoi_npu_read(device, POTAMOI_NPU_VU_ERRORS_OFFSET), job->errors);
}
