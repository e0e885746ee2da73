// A stranger's ADS client (npm ads-client) against the simulated winch controller.
//
//   npm ci && node winch_ads_client.mjs PATH/TO/interop_winch_server
//
// Exits 0 when everything agrees, 1 with the first disagreement.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { createInterface } from "node:readline";
import { Client } from "ads-client";

const NET_ID = "192.168.90.150.1.1";
const COMMAND_SIZE = 64;
const STATUS_SIZE = 120;
const SYSTEM_SERVICE = 10000;
const HANDLE_BY_NAME = 0xf003;
const VALUE_BY_HANDLE = 0xf005;
const PLC_DATA = 0x4040;

const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

async function startServer(path) {
  const child = spawn(path, ["30"], { stdio: ["ignore", "pipe", "inherit"] });
  const failed = new Promise((_, reject) => {
    child.once("error", reject);
    child.once("exit", (code) => reject(new Error(`the server ended early (${code})`)));
  });
  failed.catch(() => {});
  const [line] = await Promise.race([
    new Promise((resolve) => createInterface({ input: child.stdout }).once("line", (l) => resolve([l]))),
    failed,
  ]);
  return { child, port: Number(line.split(":").at(-1)) };
}

function options(port, local) {
  return {
    targetAmsNetId: NET_ID,
    targetAdsPort: 851,
    routerAddress: "127.0.0.1",
    routerTcpPort: port,
    rawClient: true,
    autoReconnect: false,
    timeoutDelay: 2000,
    hideConsoleWarnings: true,
    ...local,
  };
}

/// ST_WinchCommand as the PLC project lays it out, written here by hand.
function command({ heartbeat, enable = false, velocity = 0 }) {
  const bytes = Buffer.alloc(COMMAND_SIZE);
  bytes.writeUInt32LE(1, 0);
  bytes.writeUInt32LE(heartbeat, 4);
  bytes.writeDoubleLE(velocity, 24);
  bytes.writeUInt16LE(2, 48);
  bytes.writeUInt8(enable ? 1 : 0, 50);
  bytes.writeUInt32LE(500, 56);
  return bytes;
}

async function check(client) {
  const state = await client.readState();
  assert.equal(state.adsState, 5, "PLC in run");
  assert.equal((await client.readState({ adsPort: SYSTEM_SERVICE })).adsState, 5, "system in run");
  const info = await client.readDeviceInfo();
  assert.equal(info.deviceName, "Plc30 App");

  const handle = await client.createVariableHandle("GVL_Winch.stCommand");
  assert.equal(handle.size, COMMAND_SIZE, "long handle form");
  const statusHandle = await client.createVariableHandle("gvl_winch.stStatus");
  assert.equal(statusHandle.size, STATUS_SIZE);
  const short = await client.readWriteRaw(HANDLE_BY_NAME, 0, 4, Buffer.from("GVL_Winch.stStatus.nCycleCount\0"));
  assert.equal(short.length, 4, "short handle form");
  await assert.rejects(client.createVariableHandle("GVL_Winch.nothing"), "missing symbol");

  const first = command({ heartbeat: 1 });
  await client.writeRaw(VALUE_BY_HANDLE, handle.handle, first);
  assert.deepEqual(await client.readRaw(VALUE_BY_HANDLE, handle.handle, COMMAND_SIZE), first, "write, then read");
  assert.deepEqual(await client.readRaw(PLC_DATA, 0, COMMAND_SIZE), first, "the same by offset");

  const sum = await client.readRawMulti([
    { indexGroup: VALUE_BY_HANDLE, indexOffset: short.readUInt32LE(0), size: 4 },
    { indexGroup: VALUE_BY_HANDLE, indexOffset: 0xdead, size: 8 },
  ]);
  assert.equal(sum[0].success, true);
  assert.equal(sum[1].success, false);
  const written = await client.writeRawMulti([
    { indexGroup: VALUE_BY_HANDLE, indexOffset: handle.handle, value: command({ heartbeat: 2 }) },
  ]);
  assert.equal(written[0].success, true);

  // Cyclic status while the winch is enabled and pays out.
  const samples = [];
  const subscription = await client.subscribeRaw(
    VALUE_BY_HANDLE, statusHandle.handle, STATUS_SIZE, (sample) => samples.push(sample), 10, false);
  for (let heartbeat = 3; heartbeat < 120; ++heartbeat) {
    const enable = heartbeat > 20;
    await client.writeRaw(VALUE_BY_HANDLE, handle.handle, command({ heartbeat, enable, velocity: enable ? 0.1 : 0 }));
    await sleep(10);
  }
  assert.ok(samples.length > 50, `only ${samples.length} notifications`);
  const counts = samples.map((sample) => sample.value.readUInt32LE(4));
  assert.ok(counts.every((n, i) => i === 0 || n > counts[i - 1]), "nCycleCount grows");
  const stamp = samples.at(-1).timestamp.getTime();
  assert.ok(Math.abs(stamp - Date.now()) < 5000, "FILETIME is now");
  const last = samples.at(-1).value;
  assert.equal(last.length, STATUS_SIZE);
  assert.equal(last.readUInt16LE(108), 3, "eState velocity");
  assert.ok(Math.abs(last.readDoubleLE(32) - 0.1) < 0.05, `fActVelocity ${last.readDoubleLE(32)}`);
  assert.ok(last.readDoubleLE(24) > 0.81, "wire was paid out");
  await client.unsubscribe(subscription);
  const after = samples.length;
  await sleep(100);
  assert.equal(samples.length, after, "unsubscribed");

  // The heartbeat stops: the PLC's own watchdog stops the winch.
  await sleep(1000);
  const lost = await client.readRaw(VALUE_BY_HANDLE, statusHandle.handle, STATUS_SIZE);
  assert.equal(lost.readUInt16LE(108), 7, "eState communication lost");
  assert.equal(lost.readDoubleLE(32), 0, "at rest");
  assert.equal(lost.readUInt32LE(100), 1, "one watchdog trip");

  await client.deleteVariableHandle(handle);
  await assert.rejects(client.readRaw(VALUE_BY_HANDLE, handle.handle, 4), "released handle");
  await assert.rejects(client.readState({ adsPort: 500 }), "unknown port");
}

/// PLC mode: the client reads symbols and types by itself, and speaks in names and objects.
async function checkSymbols(client) {
  assert.ok(client.metaData.plcUploadInfo.symbolCount > 40, "upload info");
  assert.equal(client.metaData.plcRuntimeState.adsState, 5, "watches the PLC's state");

  const before = await client.readValue("GVL_Winch.stStatus.nCycleCount");
  await sleep(50);
  assert.ok((await client.readValue("gvl_winch.STSTATUS.ncyclecount")).value > before.value, "member by name, any case");
  const status = (await client.readValue("GVL_Winch.stStatus")).value;
  assert.equal(status.nLayoutVersion, 1, "struct by name");
  assert.equal(status.bHomed, true);
  assert.ok(Math.abs(status.fActPosition - 0.8) < 1, `fActPosition ${status.fActPosition}`);
  assert.equal(Object.keys(status).length, 29, "every member");
  const empty = (await client.readValue("GVL_Winch.stCommand")).value;
  assert.deepEqual(empty.aReserved, [0, 0], "an array member");

  await client.writeValue("GVL_Winch.stCommand.fSetVelocity", 0.125);
  assert.equal((await client.readValue("GVL_Winch.stCommand.fSetVelocity")).value, 0.125, "member written by name");
  await client.writeValue("GVL_Winch.stCommand", { ...empty, nLayoutVersion: 1, nHeartbeat: 77, nTimeoutMs: 500 });
  await sleep(50);
  assert.equal((await client.readValue("GVL_Winch.stStatus.nHeartbeatEcho")).value, 77, "struct written by name");

  const types = await client.getDataTypes();
  assert.ok(types["st_winchstatus"], "all types at once");
  const symbols = await client.getSymbols();
  assert.ok(symbols["main.winch.length_t"], "all symbols at once");
  assert.equal((await client.readValue("MAIN.winch.eMode")).value, 0, "the laboratory's own names");
  await assert.rejects(client.readValue("GVL_Winch.nothing"), "missing symbol");

  const counts = [];
  const structs = [];
  const changes = [];
  const a = await client.subscribeValue("GVL_Winch.stStatus.nCycleCount", (data) => counts.push(data.value), 10, true);
  const b = await client.subscribeValue("GVL_Winch.stStatus", (data) => structs.push(data.value), 10, false);
  const c = await client.subscribeValue("GVL_Winch.stStatus.nWatchdogTrips", (data) => changes.push(data.value), 10, true);
  await sleep(1000);
  assert.ok(counts.length > 50, `a member on change: ${counts.length}`);
  assert.ok(structs.length > 50, `a struct, cyclic: ${structs.length}`);
  assert.ok(structs.at(-1).nCycleCount > structs[0].nCycleCount);
  assert.equal(changes.length, 1, "what does not change is told once");
  for (const subscription of [a, b, c]) await client.unsubscribe(subscription);
  assert.equal((await client.readState()).adsState, 5);
}

const { child, port } = await startServer(process.argv[2]);
let status = 0;
try {
  const registered = new Client(options(port, {}));
  await registered.connect();
  assert.equal((await registered.readState()).adsState, 5, "after registering a port");
  await registered.disconnect();

  const client = new Client(options(port, { localAmsNetId: "10.0.0.1.1.1", localAdsPort: 32750 }));
  await client.connect();
  await check(client);
  await client.disconnect();

  const plc = new Client({ ...options(port, { localAmsNetId: "10.0.0.1.1.1", localAdsPort: 32751 }), rawClient: false });
  await plc.connect();
  await checkSymbols(plc);
  await plc.disconnect();
  console.log("ads-client agrees with the simulated winch controller");
} catch (error) {
  console.error(error);
  status = 1;
} finally {
  child.kill();
}
process.exit(status);
