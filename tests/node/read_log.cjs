// Reads logs as Foxglove does: MCAP chunks, schemas of ROS 2, messages in CDR. Prints how many messages each log holds.
// node read_log.cjs NODE_MODULES LOG...
const { createRequire } = require("node:module");
const { readFileSync } = require("node:fs");

const [modules, ...logs] = process.argv.slice(2);
const load = createRequire(`${modules}/`);
const { McapIndexedReader } = load("@mcap/core");
const { loadDecompressHandlers } = load("@mcap/support");
const { parse } = load("@foxglove/rosmsg");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");

async function read(path, decompressHandlers) {
  const data = readFileSync(path);
  const readable = {
    size: async () => BigInt(data.length),
    read: async (offset, length) => new Uint8Array(data.subarray(Number(offset), Number(offset + length))),
  };
  const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
  const readers = new Map();
  let count = 0;
  let pose = null;
  for await (const message of reader.readMessages()) {
    const channel = reader.channelsById.get(message.channelId);
    if (channel.messageEncoding !== "cdr") throw new Error(`${channel.topic}: ${channel.messageEncoding}`);
    if (!readers.has(channel.id)) {
      const schema = reader.schemasById.get(channel.schemaId);
      readers.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
    }
    const content = readers.get(channel.id).readMessage(message.data);
    count += 1;
    if (channel.topic === "/cdpr/platform/pose") pose = content.pose.position;
  }
  return { count, statistics: Number(reader.statistics.messageCount), topics: readers.size, pose };
}

(async () => {
  const handlers = await loadDecompressHandlers();
  const found = [];
  for (const log of logs) found.push(await read(log, handlers));
  console.log(JSON.stringify(found));
})().catch((error) => { console.error(error.stack); process.exit(1); });
