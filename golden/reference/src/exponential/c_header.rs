//! The operation `exp` as C99 text, for programs without Rust.

use std::fmt::Write as _;

use potamoi_formats::config::{ExpBase, ExpConfig, ExpOutput};

use super::ReferenceExponential;

/// The header `potamoi_exp.h`: `static inline uint32_t potamoi_exp(uint32_t s)` computes the
/// operation `exp` of `config`, bit for bit as [`ReferenceExponential::exp`].
///
/// `s` holds the 32 bits of the operand, the result those of the result. The text is C99 and
/// C++11, has no undefined behaviour, and needs no integer of more than 64 bits.
///
/// `prefix`, letters, digits and underscores, begins the names of functions and macros, so that two
/// engines meet in one program.
///
/// `config` must have passed the rules of `potamoi_formats::config`. For any other, the text is
/// unspecified.
///
/// ```
/// use potamoi_formats::config::Config;
/// use potamoi_reference::exponential::c_header;
///
/// let text = c_header(&Config::paper().vu.exp, "");
/// assert!(text.contains("static inline uint32_t potamoi_exp(uint32_t s)"));
/// ```
#[must_use]
pub fn c_header(config: &ExpConfig, prefix: &str) -> String {
    let own = ReferenceExponential::new(config);
    let (name, format) = (config.form.name(), own.input);
    let (described, returned) = result(&own);
    let (power, is_signed) = match (own.is_signed(), config.base) {
        (true, _) => ("exp(x)", true),
        (false, ExpBase::E) => ("exp(-x)", false),
        (false, ExpBase::Two) => ("2^-x", false),
    };
    let body = own.form.c_power();
    let product = if body.contains("_product(") {
        PRODUCTS
    } else {
        ""
    };
    let bits = own.engine.constant_bits;
    let factor = 1i64 << bits.saturating_sub(format.frac_bits()).min(40);
    let (low, high) = (format.min() as i64, format.max() as i64);
    let operand = if is_signed { "-operand" } else { "operand" };
    let text = format!(
        r"/* {power} of a vector unit by Potamoi, bit for bit: the form {name}.

   Operand: {format}, a code in units of 2^-{frac}, of {low} to {high}. The 32 bits of s are its two's
   complement; a code outside the format is clamped to it.
   Result: {described}.
   C99 or C++11. */
#ifndef POTAMOI_EXP_H
#define POTAMOI_EXP_H

#include <stdint.h>

{product}/* value / 2^drop, half-up; value is not negative. */
static inline int64_t potamoi_exp_rounded(int64_t value, int drop)
{{
    return (value + ((INT64_C(1) << drop) >> 1)) >> drop;
}}

/* Sets the mantissa, with {accumulator_bits} fraction bits, and the binary exponent of exp(-value);
   value has {bits} fraction bits. */
static inline void potamoi_exp_power(int64_t value, int64_t *mantissa, int32_t *binary_exponent)
{{
    int64_t accumulator;
    int32_t exponent;
{body}    *mantissa = accumulator;
    *binary_exponent = exponent;
}}

static inline uint32_t potamoi_exp(uint32_t s)
{{
    int64_t operand = (int64_t)s - (s > UINT32_C(0x7fffffff) ? INT64_C(0x100000000) : 0);
    int64_t mantissa;
    int32_t exponent;
    if (operand < INT64_C({low})) {{
        operand = INT64_C({low});
    }} else if (operand > INT64_C({high})) {{
        operand = INT64_C({high});
    }}
    potamoi_exp_power({operand} * INT64_C({factor}), &mantissa, &exponent);
{returned}}}

#endif
",
        frac = format.frac_bits(),
        accumulator_bits = own.engine.accumulator_bits,
    );
    text.replace("potamoi_exp", &format!("{prefix}potamoi_exp"))
        .replace(
            "POTAMOI_EXP",
            &format!("{}POTAMOI_EXP", prefix.to_uppercase()),
        )
}

/// Products of 128 bits in halves. No factor or sum of halves exceeds 64 bits.
const PRODUCTS: &str = r"/* a b / 2^drop, truncated. The quotient is below 2^64; drop is 1 to 63. */
static inline uint64_t potamoi_exp_product(uint64_t a, uint64_t b, int drop)
{
    const uint64_t half = UINT64_C(0xffffffff);
    const uint64_t low = (a & half) * (b & half);
    const uint64_t middle = (a >> 32) * (b & half) + (low >> 32);
    const uint64_t other = (a & half) * (b >> 32) + (middle & half);
    const uint64_t high = (a >> 32) * (b >> 32) + (middle >> 32) + (other >> 32);
    return (high << (64 - drop)) | (((other << 32) | (low & half)) >> drop);
}

/* a b / 2^drop, rounded half-up. a and the quotient are below 2^63; drop is 1 to 63. */
static inline uint64_t potamoi_exp_rounded_product(uint64_t a, uint64_t b, int drop)
{
    return (potamoi_exp_product(2 * a, b, drop) + 1) >> 1;
}

";

/// What the result is, and the C statements that return it.
fn result(own: &ReferenceExponential) -> (String, String) {
    let f = own.output_bits;
    let drop = own.engine.accumulator_bits.saturating_sub(f);
    if own.form.is_bare() {
        return (
            format!("the power with {f} fraction bits, rounded half-up from the mantissa"),
            format!("    return (uint32_t)potamoi_exp_rounded(mantissa, {drop} - exponent);\n"),
        );
    }
    match own.output {
        ExpOutput::Alpha => {
            let most = (1 << f) - 1;
            (
                format!(
                    "U0.{f}, the power rounded half-up from the mantissa; 1 saturates at {most}"
                ),
                format!(
                    r"    mantissa = potamoi_exp_rounded(mantissa, {drop} - exponent);
    return (uint32_t)(mantissa > {most} ? {most} : mantissa);
"
                ),
            )
        }
        ExpOutput::General => (
            format!(
                "bits {f}..0 are a mantissa U1.{f} of at least 1, rounded half-up; the bits above are the
   binary exponent in two's complement"
            ),
            format!(
                r"    mantissa = potamoi_exp_rounded(mantissa, {drop});
    if (mantissa > {largest}) {{ /* rounded up to 2 */
        mantissa = {one};
        exponent += 1;
    }}
    return ((uint32_t)exponent << {place}) | (uint32_t)mantissa;
",
                largest = (2 << f) - 1,
                one = 1 << f,
                place = f + 1,
            ),
        ),
    }
}

/// The definition of a constant array, for the body of a function.
pub(super) fn table(kind: &str, name: &str, values: &[i64]) -> String {
    let mut text = format!("    static const {kind} {name}[{}] = {{", values.len());
    for (i, value) in values.iter().enumerate() {
        text += if i % 4 == 0 { "\n        " } else { " " };
        let _ = match kind {
            "int" => write!(text, "{value},"),
            _ => write!(text, "INT64_C({value}),"),
        };
    }
    text + "\n    };"
}

/// Statements that multiply by 1 + the remainder, where a tail is built.
pub(super) fn tail(is_built: bool, bits: u32) -> String {
    if !is_built {
        return String::new();
    }
    format!(
        r"    /* Times 1 + the remainder, which is not negative; truncated. */
    accumulator += (int64_t)potamoi_exp_product((uint64_t)accumulator, (uint64_t)remain, {bits});
"
    )
}
