// Decodes every message of a bag of ROS 2 with the libraries that Foxglove uses, by the definitions in the bag:
//   node read_ros2_bag.mjs NPM_DIR BAG.mcap
// Prints as JSON the count of each topic's messages and its last message, with the sum of its bytes for those.
// Exit code 77: the libraries are not installed.
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";
import { join } from "node:path";

const [npmDir, bag] = process.argv.slice(2);
const load = createRequire(join(npmDir, "package.json"));
let mcap, rosmsg, serialization;
try {
  mcap = load("@mcap/core");
  rosmsg = load("@foxglove/rosmsg");
  serialization = load("@foxglove/rosmsg2-serialization");
} catch {
  process.exit(77);
}

const bytes = readFileSync(bag);
const readable = {
  size: async () => BigInt(bytes.length),
  read: async (offset, size) => bytes.subarray(Number(offset), Number(offset + size)),
};
const reader = await mcap.McapIndexedReader.Initialize({ readable });
const readers = new Map();
const topics = {};
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  const schema = reader.schemasById.get(channel.schemaId);
  if (!readers.has(schema.id)) {
    const definition = rosmsg.parse(new TextDecoder().decode(schema.data), { ros2: true });
    readers.set(schema.id, new serialization.MessageReader(definition));
  }
  const value = readers.get(schema.id).readMessage(message.data);
  if (value.data) value.data = { length: value.data.length, sum: value.data.reduce((sum, byte) => sum + byte, 0) };
  const topic = (topics[channel.topic] ??= { type: schema.name, count: 0, metadata: Object.fromEntries(channel.metadata) });
  topic.count += 1;
  topic.last = value;
}
const plain = (_, value) => (ArrayBuffer.isView(value) ? Array.from(value) : value);
console.log(JSON.stringify({ profile: reader.header.profile, topics }, plain));
