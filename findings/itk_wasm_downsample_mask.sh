#!/usr/bin/env bash
# @itk-wasm/downsample 2.0.2 (npm, Node.js 20; itk-wasm 1.0.0-b.201): downsampleNode, smoothing and taking each n-th voxel, cuts the smoothed values off
# to the integers of the image, one axis after the other. A mask of 0 and 1, or of 0 and 2, is 0 everywhere afterwards, also in the
# middle of a block of 16 voxels; of 0 and 3 a part of it is left. With 255, or 1000 in 16 bits, 1 to 2 % are missing, and floats are right.
# downsampleBinShrinkNode, which takes means of blocks, is right here. No message.
# Seen on 2026-12-01: "uint8, 0 and 1: 0.000 of the mass by 2, 0.000 by 4, ..." and the lines below.
# Usage: findings/itk_wasm_downsample_mask.sh     needs node and npm; exits with 1 if that changes.
set -euo pipefail
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
npm install --silent --ignore-scripts --no-audit --no-fund @itk-wasm/downsample@2.0.2 itk-wasm@1.0.0-b.201 >&2

cat >shrink.mjs <<'J'
import { downsampleBinShrinkNode, downsampleNode } from '@itk-wasm/downsample'

const types = { uint8: Uint8Array, int16: Int16Array, float32: Float32Array }

/** A block of 16 x 16 x 16 voxels in 40 x 40 x 40. */
function block (componentType, value) {
  const data = new types[componentType](40 ** 3)
  for (let z = 12; z < 28; z++) for (let y = 12; y < 28; y++) data.fill(value, 12 + 40 * (y + 40 * z), 28 + 40 * (y + 40 * z))
  return {
    imageType: { dimension: 3, componentType, pixelType: 'Scalar', components: 1 }, name: 'block', metadata: new Map(), data,
    size: [40, 40, 40], origin: [0, 0, 0], spacing: [1, 1, 1], direction: new Float64Array([1, 0, 0, 0, 1, 0, 0, 0, 1])
  }
}

for (const [type, value] of [['uint8', 1], ['uint8', 2], ['uint8', 3], ['uint8', 255], ['int16', 1000], ['float32', 1]]) {
  const mass = []
  for (const shrink of [downsampleNode, downsampleBinShrinkNode]) {
    for (const n of [2, 4]) {
      const { downsampled } = await shrink(block(type, value), { shrinkFactors: [n, n, n] })
      mass.push((downsampled.data.reduce((sum, v) => sum + v, 0) * n ** 3 / 16 ** 3 / value).toFixed(3))
    }
  }
  console.log(`${type}, 0 and ${value}: ${mass[0]} of the mass by 2, ${mass[1]} by 4, with downsampleBinShrinkNode ${mass[2]}, ${mass[3]}`)
}
J
node shrink.mjs | tee seen
diff seen - <<'E' || exit 1
uint8, 0 and 1: 0.000 of the mass by 2, 0.000 by 4, with downsampleBinShrinkNode 1.000, 1.000
uint8, 0 and 2: 0.000 of the mass by 2, 0.000 by 4, with downsampleBinShrinkNode 1.000, 1.000
uint8, 0 and 3: 0.578 of the mass by 2, 0.292 by 4, with downsampleBinShrinkNode 1.000, 1.000
uint8, 0 and 255: 0.992 of the mass by 2, 0.983 by 4, with downsampleBinShrinkNode 1.000, 1.000
int16, 0 and 1000: 0.998 of the mass by 2, 0.996 by 4, with downsampleBinShrinkNode 1.000, 1.000
float32, 0 and 1: 1.000 of the mass by 2, 1.000 by 4, with downsampleBinShrinkNode 1.000, 1.000
E
