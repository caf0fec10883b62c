//! `potamoi_npu.h`: the map as a C99 header, with small functions to drive the block.

use std::fmt::Write as _;

use super::model::RegisterMap;

/// The map as a header for C99 and C++. `prefix` begins its names, as those of the modules; `command`
/// is the command that writes it again.
#[must_use]
pub fn c_header(map: &RegisterMap, prefix: &str, command: &str) -> String {
    let mut text = "/*\n".to_owned();
    for line in map.origin(command) {
        let _ = writeln!(text, " * {line}");
    }
    text += HEAD;
    for own in &map.registers {
        let name = &own.name;
        let _ = write!(
            text,
            "\n/* {}: {} */\n#define POTAMOI_NPU_{name}_OFFSET UINT32_C({:#05x})\n\
             #define POTAMOI_NPU_{name}_RESET UINT32_C({:#010x})\n",
            own.access.short(),
            own.description,
            own.offset,
            own.reset()
        );
        for field in &own.fields {
            let whole = format!("POTAMOI_NPU_{name}_{}", field.name);
            let _ = write!(
                text,
                "#define {whole}_SHIFT {}u\n#define {whole}_MASK UINT32_C({:#010x})  /* {} */\n",
                field.low,
                field.mask(),
                field.description
            );
        }
    }
    text += FUNCTIONS;
    let upper = prefix.to_uppercase();
    text.replace("potamoi_npu", &format!("{prefix}potamoi_npu"))
        .replace("POTAMOI_NPU", &format!("{upper}POTAMOI_NPU"))
}

const HEAD: &str = " *
 * Registers of potamoi_npu_ext. A device is a pointer to its first register, mapped uncached.
 * Where POTAMOI_NPU_OWN_BUS is defined, the user declares and defines the two functions of the bus:
 *   uint32_t potamoi_npu_read(volatile void *device, uint32_t offset);
 *   void potamoi_npu_write(volatile void *device, uint32_t offset, uint32_t value);
 */
#ifndef POTAMOI_NPU_H
#define POTAMOI_NPU_H

#include <stdint.h>
";

const FUNCTIONS: &str = r#"
#ifdef __cplusplus
extern "C" {
#endif

#ifdef POTAMOI_NPU_OWN_BUS
uint32_t potamoi_npu_read(volatile void *device, uint32_t offset);
void potamoi_npu_write(volatile void *device, uint32_t offset, uint32_t value);
#else
static inline uint32_t potamoi_npu_read(volatile void *device, uint32_t offset) {
  return ((volatile uint32_t *)device)[offset / 4u];
}
static inline void potamoi_npu_write(volatile void *device, uint32_t offset, uint32_t value) {
  ((volatile uint32_t *)device)[offset / 4u] = value;
}
#endif

/* A field of a word, and a word with nothing but a field: POTAMOI_NPU_GET(word, GU_MODE, SEGMENTS). */
#define POTAMOI_NPU_GET(word, reg, field) \
  (((uint32_t)(word) & POTAMOI_NPU_##reg##_##field##_MASK) >> POTAMOI_NPU_##reg##_##field##_SHIFT)
#define POTAMOI_NPU_SET(value, reg, field) \
  (((uint32_t)(value) << POTAMOI_NPU_##reg##_##field##_SHIFT) & POTAMOI_NPU_##reg##_##field##_MASK)

/* Whether the block is one that this header describes, of the same configuration. */
static inline int potamoi_npu_is_known(volatile void *device) {
  return potamoi_npu_read(device, POTAMOI_NPU_ID_OFFSET) == POTAMOI_NPU_ID_RESET
      && potamoi_npu_read(device, POTAMOI_NPU_VERSION_OFFSET) == POTAMOI_NPU_VERSION_RESET
      && potamoi_npu_read(device, POTAMOI_NPU_CONFIG_LOW_OFFSET) == POTAMOI_NPU_CONFIG_LOW_RESET
      && potamoi_npu_read(device, POTAMOI_NPU_CONFIG_HIGH_OFFSET) == POTAMOI_NPU_CONFIG_HIGH_RESET;
}

/* Begins a job of the gathering unit: its settings (a word of GU_MODE), and MVoxels times segments. */
static inline void potamoi_npu_start_gather(volatile void *device, uint32_t mode, uint32_t packets) {
  potamoi_npu_write(device, POTAMOI_NPU_GU_MODE_OFFSET, mode);
  potamoi_npu_write(device, POTAMOI_NPU_GU_PACKETS_OFFSET, packets);
  potamoi_npu_write(device, POTAMOI_NPU_CONTROL_OFFSET, POTAMOI_NPU_CONTROL_GU_START_MASK);
}

/* Begins a job of the vector unit: packets of its operands. */
static inline void potamoi_npu_start_vector(volatile void *device, uint32_t packets) {
  potamoi_npu_write(device, POTAMOI_NPU_VU_PACKETS_OFFSET, packets);
  potamoi_npu_write(device, POTAMOI_NPU_CONTROL_OFFSET, POTAMOI_NPU_CONTROL_VU_START_MASK);
}

/* Clears counters and error flags. */
static inline void potamoi_npu_clear(volatile void *device) {
  potamoi_npu_write(device, POTAMOI_NPU_CONTROL_OFFSET, POTAMOI_NPU_CONTROL_CLEAR_MASK);
}

/* Makes the registers of counters show all counters as of one clock. */
static inline void potamoi_npu_snapshot(volatile void *device) {
  potamoi_npu_write(device, POTAMOI_NPU_CONTROL_OFFSET, POTAMOI_NPU_CONTROL_SNAPSHOT_MASK);
}

/* Events of IRQ_STATUS that have occurred, which it clears. */
static inline uint32_t potamoi_npu_take_events(volatile void *device) {
  uint32_t events = potamoi_npu_read(device, POTAMOI_NPU_IRQ_STATUS_OFFSET);
  potamoi_npu_write(device, POTAMOI_NPU_IRQ_STATUS_OFFSET, events);
  return events;
}

#ifdef __cplusplus
}
#endif

#endif
"#;
