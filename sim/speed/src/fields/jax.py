"""Gathering, interpolation and perceptrons of radiance fields in JAX, in 64-bit floats.

    python3 -c "$(cat jax.py)" '{"runs": 3, "models": [...]}'

A peer of the floating-point renderer of fields, and no ray marcher: it has no rays, no empty space and
no compositing. It takes as many samples as a frame of the renderer gathered, and computes the colour of
as many as the renderer coloured, in models of the same sizes with random weights. Positions run along
parallel rays, so that neighbours read the same rows. Encoded directions are given, not computed.

Processor time is that of all threads of this process. Of several sizes of batches the fastest counts.
Prints one line of JSON.
"""

import json
import os
import sys
import time

os.environ.setdefault("JAX_PLATFORMS", "cpu")
os.environ.setdefault("JAX_ENABLE_X64", "1")
try:
    import jax
    import jax.numpy as jnp
    import numpy
except ImportError as error:
    print(json.dumps({"missing": str(error)}))
    sys.exit(0)

PRIMES = (1, 2654435761, 805459861)
SAMPLES_A_RAY = 64
BATCHES = (1 << 12, 1 << 14)


def positions(count):
    """Points in the unit cube, ray after ray."""
    index = numpy.arange(count)
    ray, along = index // SAMPLES_A_RAY, index % SAMPLES_A_RAY
    side = max(1, round((count / SAMPLES_A_RAY) ** 0.5 + 0.5))
    parts = [(ray % side + 0.5) / side, (ray // side % side + 0.5) / side,
             (along + 0.5) / SAMPLES_A_RAY]
    return numpy.stack(parts, axis=1)


def rows_of(shape, corner):
    """The row of each vertex."""
    x, y, z = (corner[:, axis] for axis in range(3))
    if shape["hashed"]:
        words = [part.astype(jnp.uint32) * jnp.uint32(prime)
                 for part, prime in zip((x, y, z), PRIMES)]
        mixed = words[0] ^ words[1] ^ words[2]
        count = shape["rows"]
        if count & (count - 1) == 0:
            return (mixed & jnp.uint32(count - 1)).astype(jnp.int32)
        return (mixed % jnp.uint32(count)).astype(jnp.int32)
    points = shape["points"]
    return x + points[0] * (y + points[1] * z)


def gathered(shape, table, at):
    """Features at points, by trilinear interpolation."""
    last = jnp.array([count - 1 for count in shape["points"]], dtype=jnp.float64)
    place = at * last
    low = jnp.minimum(place.astype(jnp.int32), jnp.maximum(last.astype(jnp.int32) - 1, 0))
    part = place - low
    total = 0.0
    for vertex in range(8):
        bits = jnp.array([vertex >> axis & 1 for axis in range(3)], dtype=jnp.int32)
        weight = jnp.prod(jnp.where(bits == 1, part, 1.0 - part), axis=1)
        total = total + weight[:, None] * table[rows_of(shape, low + bits)]
    return total


def perceptron(layers, values):
    for number, (weights, bias) in enumerate(layers):
        values = values @ weights
        values = values if bias is None else values + bias
        values = values if number + 1 == len(layers) else jnp.maximum(values, 0.0)
    return values


def softplus(value):
    return jnp.logaddexp(value, 0.0)


def sigmoid(value):
    return 1.0 / (1.0 + jnp.exp(-value))


def dvgo(model, parts, at, directions):
    """Optical depths of all samples, and colours of the first."""
    tables, (head,) = parts
    features = gathered(model["tables"][0], tables[0], at)
    coloured = jnp.concatenate([features[:len(directions), 1:], directions], axis=1)
    return softplus(features[:, 0]), sigmoid(perceptron(head, coloured))


def ngp(model, parts, at, directions):
    """Densities of all samples, and colours of the first."""
    tables, (density, colour) = parts
    levels = [gathered(shape, table, at) for shape, table in zip(model["tables"], tables)]
    latents = perceptron(density, jnp.concatenate(levels, axis=1))
    coloured = jnp.concatenate([latents[:len(directions)], directions], axis=1)
    return jnp.exp(latents[:, 0]), sigmoid(perceptron(colour, coloured)[:, :3])


def random(seed, shape):
    return jnp.asarray(0.1 * numpy.random.default_rng(seed).standard_normal(shape))


def parts_of(model):
    tables = [random(number, (shape["rows"], shape["channels"]))
              for number, shape in enumerate(model["tables"])]
    heads = [[(random(100 + number, (layer["inputs"], layer["outputs"])),
               random(200 + number, (layer["outputs"],)) if layer["bias"] else None)
              for number, layer in enumerate(layers)] for layers in model["perceptrons"]]
    return tables, heads


def sizes_of(count):
    """Sizes of batches of which almost all samples are whole ones."""
    return sorted({max(1, count // max(1, round(count / size))) for size in BATCHES})


def work_of(model, size):
    """Inputs of each batch, all of one size: positions, and encoded directions of those that are coloured."""
    count, share = model["gathered"], model["coloured"] / max(1, model["gathered"])
    lit = min(size, max(1, round(share * size)))
    at = positions(count)
    return [(jnp.asarray(at[first:first + size]), random(first, (lit, model["encoded"])))
            for first in range(0, count - size + 1, size)]


def measured(model, runs):
    """Processor time in milliseconds: the fastest run of the fastest size of batches."""
    parts = parts_of(model)
    compute = {"dvgo": dvgo, "ngp": ngp}[model["kind"]]
    step = jax.jit(lambda parts, at, directions: compute(model, parts, at, directions))
    best = float("inf")
    for size in sizes_of(model["gathered"]):
        batches = work_of(model, size)
        # The samples that fill no batch, fewer than there are batches.
        rest = model["gathered"] / sum(len(at) for at, _ in batches)

        def frame():
            start = time.process_time()
            jax.block_until_ready([step(parts, *batch) for batch in batches])
            return 1e3 * rest * (time.process_time() - start)

        frame()  # Compiles.
        best = min([best] + [frame() for _ in range(runs)])
    return best


def main():
    asked = json.loads(sys.argv[1])
    found = [{"name": model["name"], "ms": measured(model, asked["runs"])}
             for model in asked["models"]]
    print(json.dumps({"version": jax.__version__, "models": found}))


main()
