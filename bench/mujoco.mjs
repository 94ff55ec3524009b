// MuJoCo's height field in the suite `beside`: node bench/mujoco.mjs OUT [MODULES [BENCH]]
// OUT gets places, surfaces and forces (bench/README.md). MODULES: where `npm install @mujoco/mujoco` was run;
// without it the other columns are printed. BENCH: touchable-bench.
import { spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [out, modules = '.', bench = 'build/release/bench/touchable-bench'] = process.argv.slice(2);
if (!out) {
  console.error('node bench/mujoco.mjs OUT [MODULES [BENCH]]');
  process.exit(2);
}
const radii = [0.0005, 0.002, 0.005];  // metres

function runBench(stdio) {
  const ran = spawnSync(bench, ['beside'], { env: { ...process.env, TOUCHABLE_BESIDE: out }, stdio });
  if (ran.status !== 0) process.exit(ran.status ?? 1);
}

const rows = (file) => readFileSync(file, 'utf8').trim().split('\n').slice(1).map((line) => line.split(',').map(Number));

function forcesOn(mj, heights, places, radius) {
  const [[columns, lines, left, right, bottom, top], ...grid] = heights;
  const flat = grid.flat(), low = flat.reduce((a, b) => Math.min(a, b)), high = flat.reduce((a, b) => Math.max(a, b));
  const model = mj.MjModel.from_xml_string(`<mujoco><option gravity="0 0 0"/>
    <asset><hfield name="surface" ncol="${columns}" nrow="${lines}"
      size="${(right - left) / 2} ${(top - bottom) / 2} ${high - low} 0.01"/></asset>
    <worldbody><geom type="hfield" hfield="surface" pos="${(left + right) / 2} ${(bottom + top) / 2} ${low}" condim="1"/>
      <body><freejoint/><geom type="sphere" size="${radius}" mass="0.1" condim="1"/></body></worldbody></mujoco>`);
  model.hfield_data.set(flat.map((z) => (z - low) / (high - low)));
  const data = new mj.MjData(model), wrench = new mj.DoubleBuffer(6);
  let most = 0;
  const forces = places.map(([x, y, z, nx, ny, nz]) => {
    data.qpos.set([x + radius * nx, y + radius * ny, z + radius * nz, 1, 0, 0, 0]);
    data.qvel.fill(0);
    data.qacc_warmstart.fill(0);
    mj.mj_forward(model, data);
    const force = [0, 0, 0], contacts = data.contact;
    most = Math.max(most, data.ncon);
    for (let k = 0; k < data.ncon; ++k) {
      const contact = contacts.get(k), frame = contact.frame, side = contact.geom1 === 0 ? 1 : -1;
      mj.mj_contactForce(model, data, k, wrench);
      for (let axis = 0; axis < 3; ++axis) force[axis] += side * wrench.GetView()[0] * frame[axis];
      contact.delete();
    }
    contacts.delete();
    return force;
  });
  for (const held of [wrench, data, model]) held.delete();
  return { forces, most };
}

mkdirSync(out, { recursive: true });
let mj;
try {
  mj = await (await import(pathToFileURL(resolve(modules, 'node_modules/@mujoco/mujoco/mujoco.js')))).default();
} catch {
  console.error(`MuJoCo is not in ${modules}, so its columns are left out: npm install --prefix ${modules} @mujoco/mujoco`);
}
if (mj) {
  runBench('ignore');
  for (const file of readdirSync(out).filter((name) => name.endsWith('.places.csv'))) {
    const name = file.slice(0, -'.places.csv'.length), places = rows(join(out, file));
    const heights = rows(join(out, `${name}.heights.csv`));
    for (const radius of radii) {
      const { forces, most } = forcesOn(mj, heights, places, radius);
      const lines = places.map((place, k) => [...place.slice(0, 3), ...forces[k]].join(' '));
      const ball = `mujoco-ball-${1000 * radius}mm`;
      writeFileSync(join(out, `${name}.${ball}.forces.csv`), `x y z fx fy fz\n${lines.join('\n')}\n`);
      console.error(`${name}, ${ball}: at most ${most} contacts at a place`);
    }
  }
}
runBench('inherit');
