// Watches and steers a run by Foxglove's own client for its WebSocket protocol. Prints what it saw as JSON.
// node watch_run.cjs NODE_MODULES URL
const { createRequire } = require("node:module");

const [modules, url] = process.argv.slice(2);
const load = createRequire(`${modules}/`);
const WebSocket = load("ws");
const { FoxgloveClient } = load("@foxglove/ws-protocol");
const { parse } = load("@foxglove/rosmsg");
const { MessageReader } = load("@foxglove/rosmsg2-serialization");

const ws = new WebSocket(url, [FoxgloveClient.SUPPORTED_SUBPROTOCOL]);
const client = new FoxgloveClient({ ws });
const seen = { messages: 0, topics: [], times: 0, statuses: [], parameters: {}, services: {}, pose: null };
const readers = new Map();
const topics = new Set();

const fail = (error) => { console.error(error.stack ?? error); process.exit(1); };
const guarded = (work) => (event) => { try { work(event); } catch (error) { fail(error); } };
const call = (service, callId) =>
  client.sendServiceCallRequest({ serviceId: service.id, callId, encoding: "json", data: new TextEncoder().encode("{}") });

client.on("error", fail);
client.on("serverInfo", guarded((info) => {
  seen.info = info;
  client.subscribeParameterUpdates([]);
  client.getParameters([], "all");
}));
client.on("advertise", guarded((channels) => {
  for (const channel of channels) {
    readers.set(client.subscribe(channel.id), [channel.topic, new MessageReader(parse(channel.schema, { ros2: true }))]);
  }
  if (channels.length) {
    const target = client.advertise({ topic: "/cdpr/target_pose", encoding: "json", schemaName: "geometry_msgs/PoseStamped" });
    const pose = { position: { x: 0.2, y: 0.1, z: 1.3 }, orientation: { x: 0, y: 0, z: 0, w: 1 } };
    client.sendMessage(target, new TextEncoder().encode(JSON.stringify({ pose, duration: 0.3 })));
    client.unadvertise(target);
    client.setParameters([{ name: "controller.kp", value: 150, type: "float64" }], "gain");
  }
}));
client.on("advertiseServices", guarded((services) => {
  for (const service of services) seen.services[service.name] = service.id;
  call(services.find((one) => one.name === "/cdpr/resume"), 7);
  call({ id: 99 }, 8);
}));
client.on("serviceCallResponse", guarded((answer) => {
  seen.answer = { callId: answer.callId, encoding: answer.encoding, ...JSON.parse(new TextDecoder().decode(answer.data)) };
}));
client.on("serviceCallFailure", guarded((answer) => { seen.failure = answer; }));
client.on("parameterValues", guarded((event) => {
  for (const one of event.parameters) seen.parameters[one.name] = one.value;
}));
client.on("status", guarded((event) => seen.statuses.push(event.message)));
client.on("time", guarded(() => { seen.times += 1; }));
client.on("message", guarded((event) => {
  const [topic, reader] = readers.get(event.subscriptionId);
  const content = reader.readMessage(event.data);
  if (topic === "/cdpr/platform/pose") seen.pose = content.pose.position;
  topics.add(topic);
  seen.messages += 1;
}));
client.on("close", () => { seen.topics = [...topics].sort(); console.log(JSON.stringify(seen)); });
