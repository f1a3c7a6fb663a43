// Prints as JSON what three.js's USDLoader makes of a file, and what its parser has of the points.
// Usage: node usd_loader.mjs FILE, where node finds the package three
import fs from 'node:fs';
import { createRequire } from 'node:module';
import path from 'node:path';
import { pathToFileURL } from 'node:url';

// From the folder in which it is called: modules are looked for beside this file otherwise.
const found = createRequire(path.join(process.cwd(), 'here.js')).resolve('three');
const addons = path.join(path.dirname(found), '../examples/jsm/loaders');
const load = file => import(pathToFileURL(file));
const { Box3 } = await load(path.join(path.dirname(found), 'three.module.js'));
const { USDLoader } = await load(path.join(addons, 'USDLoader.js'));
const { USDAParser } = await load(path.join(addons, 'usd/USDAParser.js'));

const bytes = fs.readFileSync(process.argv[2]);
const scene = new USDLoader().parse(
    bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength));
scene.updateMatrixWorld(true);
const meshes = {};
scene.traverse(node => {
  if (!node.isMesh) return;
  const box = new Box3().setFromObject(node, true);
  const geometry = node.geometry;
  meshes[node.name] = {
    triangles: (geometry.index ?? geometry.attributes.position).count / 3,
    low: box.min.toArray(),
    high: box.max.toArray(),
  };
});
const answer = { meshes };

if (bytes.subarray(0, 5).toString() === '#usda') {
  const { specsByPath } = new USDAParser().parseData(bytes.toString());
  answer.stage = specsByPath['/'].fields;
  answer.translation = specsByPath['/pack.xformOp:translate']?.fields.default ?? [0, 0, 0];
  const of = '/pack/spheres.';
  answer.spheres = {};
  for (const [place, spec] of Object.entries(specsByPath))
    if (place.startsWith(of)) answer.spheres[place.slice(of.length)] = spec.fields.default;
}
console.log(JSON.stringify(answer));
