// Writes an Open3D folder as a bag of ROS 2, with the libraries that Foxglove uses:
//   node write_ros2_bag.mjs NPM_DIR FOLDER OUT.mcap chunks|no_chunks
// Depth is compressedDepth: the PNG files as they are. Exit code 77: the libraries are not installed.
import { createRequire } from "node:module";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const [npmDir, folder, output, layout] = process.argv.slice(2);
const load = createRequire(join(npmDir, "package.json"));
let mcap, rosmsg, serialization;
try {
  mcap = load("@mcap/core");
  rosmsg = load("@foxglove/rosmsg");
  serialization = load("@foxglove/rosmsg2-serialization");
} catch {
  process.exit(77);
}

const separator = "\n================\nMSG: ";
const time = `${separator}builtin_interfaces/Time\nint32 sec\nuint32 nanosec`;
const header = `${separator}std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id${time}`;
const definitions = {
  "sensor_msgs/msg/CompressedImage": `std_msgs/Header header\nstring format\nuint8[] data${header}`,
  "sensor_msgs/msg/CameraInfo":
    "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\nfloat64[] d\nfloat64[9] k\n" +
    "float64[9] r\nfloat64[12] p\nuint32 binning_x\nuint32 binning_y\nsensor_msgs/RegionOfInterest roi" +
    `${separator}sensor_msgs/RegionOfInterest\nuint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\n` +
    `bool do_rectify${header}`,
  "tf2_msgs/msg/TFMessage":
    `geometry_msgs/TransformStamped[] transforms${separator}geometry_msgs/TransformStamped\n` +
    "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform" +
    `${separator}geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation` +
    `${separator}geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z` +
    `${separator}geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w${header}`,
};

// Of a rotation's rows, with the largest component first (Shepperd 1978).
function quaternion(m) {
  const squares = [1 + m[0][0] - m[1][1] - m[2][2], 1 - m[0][0] + m[1][1] - m[2][2], 1 - m[0][0] - m[1][1] + m[2][2],
                   1 + m[0][0] + m[1][1] + m[2][2]];
  const largest = squares.indexOf(Math.max(...squares));
  const s = 2 * Math.sqrt(squares[largest]);
  const plus = (i, j) => (m[i][j] + m[j][i]) / s;
  const minus = (i, j) => (m[i][j] - m[j][i]) / s;
  const [x, y, z, w] = [
    [s / 4, plus(0, 1), plus(0, 2), minus(2, 1)],
    [plus(0, 1), s / 4, plus(1, 2), minus(0, 2)],
    [plus(0, 2), plus(1, 2), s / 4, minus(1, 0)],
    [minus(2, 1), minus(0, 2), minus(1, 0), s / 4],
  ][largest];
  return { x, y, z, w };
}

const lines = readFileSync(join(folder, "trajectory.log"), "utf8").trim().split("\n");
const poses = [];
for (let i = 0; i < lines.length; i += 5) poses.push(lines.slice(i + 1, i + 5).map((row) => row.split(" ").map(Number)));
const camera = JSON.parse(readFileSync(join(folder, "camera_intrinsic.json"), "utf8"));
const k = camera.intrinsic_matrix;

const parts = [];
let size = 0n;
const writable = {
  position: () => size,
  write: async (bytes) => {
    parts.push(Buffer.from(bytes));
    size += BigInt(bytes.byteLength);
  },
};
const writer = new mcap.McapWriter({ writable, useChunks: layout === "chunks", chunkSize: 1 << 16 });
await writer.start({ profile: "ros2", library: "write_ros2_bag.mjs" });
const topics = new Map();
async function topic(name, type) {
  const schemaId = await writer.registerSchema({
    name: type, encoding: "ros2msg", data: new TextEncoder().encode(definitions[type]) });
  const channelId = await writer.registerChannel({
    topic: name, schemaId, messageEncoding: "cdr", metadata: new Map() });
  const message = new serialization.MessageWriter(rosmsg.parse(definitions[type], { ros2: true }));
  topics.set(name, { channelId, message });
}
await topic("/tf", "tf2_msgs/msg/TFMessage");
await topic("/camera/depth/camera_info", "sensor_msgs/msg/CameraInfo");
await topic("/camera/depth/image_raw/compressedDepth", "sensor_msgs/msg/CompressedImage");
await topic("/camera/color/image_raw/compressed", "sensor_msgs/msg/CompressedImage");

let sequence = 0;
async function send(name, stamp, value) {
  const { channelId, message } = topics.get(name);
  const logTime = BigInt(stamp.sec) * 1000000000n + BigInt(stamp.nanosec);
  await writer.addMessage({ channelId, sequence: sequence++, logTime, publishTime: logTime,
                            data: message.writeMessage(value) });
}

const names = readdirSync(join(folder, "depth")).sort();
const colours = readdirSync(join(folder, "color")).sort();
for (let i = 0; i < names.length; ++i) {
  const stamp = { sec: 100 + Math.floor(i / 10), nanosec: (i % 10) * 100000000 };
  const head = { stamp, frame_id: "camera_optical" };
  const [x, y, z] = poses[i].map((row) => row[3]);
  await send("/tf", stamp, { transforms: [{ header: { stamp, frame_id: "map" }, child_frame_id: "camera_optical",
    transform: { translation: { x, y, z }, rotation: quaternion(poses[i]) } }] });
  await send("/camera/depth/camera_info", stamp, {
    header: head, height: camera.height, width: camera.width, distortion_model: "plumb_bob", d: [0, 0, 0, 0, 0],
    k: [k[0], 0, k[6], 0, k[4], k[7], 0, 0, 1], r: [1, 0, 0, 0, 1, 0, 0, 0, 1],
    p: [k[0], 0, k[6], 0, 0, k[4], k[7], 0, 0, 0, 1, 0], binning_x: 0, binning_y: 0,
    roi: { x_offset: 0, y_offset: 0, height: 0, width: 0, do_rectify: false } });
  const codec = Buffer.alloc(12);
  await send("/camera/depth/image_raw/compressedDepth", stamp, { header: head, format: "16UC1; compressedDepth png",
    data: Buffer.concat([codec, readFileSync(join(folder, "depth", names[i]))]) });
  const isJpeg = colours[i].endsWith(".jpg");
  await send("/camera/color/image_raw/compressed", stamp, { header: head,
    format: isJpeg ? "rgb8; jpeg compressed bgr8" : "rgb8; png compressed", data: readFileSync(join(folder, "color", colours[i])) });
}
await writer.end();
writeFileSync(output, Buffer.concat(parts));
