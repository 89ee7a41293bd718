// The binary messages, read back as the page reads them.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>

#include "view/mesh_chunk.h"

namespace scanknit {
namespace {

template <typename T>
T at(const std::string& bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof(T) <= bytes.size()) std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

constexpr std::size_t kVertices = 48, kVertexBytes = 16;

Eigen::Vector3f position_of(const std::string& message, std::size_t vertex) {
  const std::size_t place = kVertices + kVertexBytes * vertex;
  Eigen::Vector3f position;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    position[static_cast<Eigen::Index>(axis)] =
        at<float>(message, 32 + 4 * axis) + at<float>(message, 44) * at<std::uint16_t>(message, place + 2 * axis);
  }
  return position;
}

Mesh two_triangles() {
  Mesh mesh;
  mesh.positions_m = {{1, 2, 3}, {1.1f, 2, 3}, {1, 2.25f, 3}, {1, 2, 3.05f}};
  mesh.normals = {{0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0.6f, 0.8f, 0}};
  mesh.colours = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {250, 251, 252}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

TEST(MeshChunk, HoldsWhatTheMeshHolds) {
  const Mesh mesh = two_triangles();
  const ChunkPart part{&mesh, {10, 20, 30, 40}};
  const std::string message = chunk_message(7, 9, {&part, 1});
  EXPECT_EQ(message.substr(0, 4), "SKM1");
  EXPECT_EQ(at<std::uint32_t>(message, 4), 1u);
  EXPECT_EQ(at<std::uint32_t>(message, 8), 7u);
  EXPECT_EQ(at<std::uint32_t>(message, 12), 9u);
  ASSERT_EQ(at<std::uint32_t>(message, 16), 4u);
  ASSERT_EQ(at<std::uint32_t>(message, 20), 6u);
  EXPECT_EQ(at<std::uint32_t>(message, 24), 1u);
  ASSERT_EQ(message.size(), kVertices + 4 * kVertexBytes + 6 * 2);
  const float step = at<float>(message, 44);
  EXPECT_LE(step, 2 * 0.25f / 65534);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LE((position_of(message, i) - mesh.positions_m[i]).cwiseAbs().maxCoeff(), 0.51f * step) << i;
    const std::size_t place = kVertices + kVertexBytes * i;
    EXPECT_EQ(at<std::uint8_t>(message, place + 8), mesh.colours[i].r);
    EXPECT_EQ(at<std::uint8_t>(message, place + 10), mesh.colours[i].b);
    EXPECT_EQ(at<std::uint8_t>(message, place + 11), 10 * (i + 1));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      EXPECT_NEAR(at<std::int8_t>(message, place + 12 + axis) / 127.0f,
                  mesh.normals[i][static_cast<Eigen::Index>(axis)], 0.5f / 127);
    }
  }
  const std::size_t indices = kVertices + 4 * kVertexBytes;
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_EQ(at<std::uint16_t>(message, indices + 2 * i), mesh.triangles[i / 3][i % 3]) << i;
}

TEST(MeshChunk, TellsTheUncertaintyOfItsVerticesInMicrometres) {
  const Mesh mesh = two_triangles();
  const float unknown = std::numeric_limits<float>::quiet_NaN();
  const ChunkPart part{&mesh, {}, {250e-6f, 1e-9f, unknown, 1.0f}};
  const std::string message = chunk_message(7, 9, {&part, 1});
  const auto sent = [&](std::size_t i) { return at<std::uint16_t>(message, kVertices + kVertexBytes * i + 6); };
  EXPECT_NEAR(sent(0), 250, 1);
  EXPECT_EQ(sent(1), 1) << "less than a step is not unknown";
  EXPECT_EQ(sent(2), 0);
  EXPECT_EQ(sent(3), 65535);
  const ChunkPart without{&mesh, {}};
  EXPECT_EQ(at<std::uint16_t>(chunk_message(7, 9, {&without, 1}), kVertices + 6), 0);
}

TEST(MeshChunk, PartsFollowOneAnother) {
  const Mesh mesh = two_triangles();
  const std::vector<ChunkPart> parts = {{&mesh, {}}, {&mesh, {}}};
  const std::string message = chunk_message(0, 0, parts);
  ASSERT_EQ(at<std::uint32_t>(message, 16), 8u);
  ASSERT_EQ(at<std::uint32_t>(message, 20), 12u);
  EXPECT_EQ(at<std::uint16_t>(message, kVertices + 8 * kVertexBytes + 2 * 6), 4u);  // first of the second part
}

TEST(MeshChunk, ManyVerticesHaveWideIndices) {
  Mesh mesh;
  mesh.positions_m.assign(65'536, {0, 0, 0});
  mesh.triangles = {{0, 1, 65'535}};
  const ChunkPart part{&mesh, {}};
  const std::string message = chunk_message(0, 0, {&part, 1});
  EXPECT_EQ(at<std::uint32_t>(message, 24), 2u);  // no colours
  EXPECT_EQ(at<std::uint32_t>(message, kVertices + 65'536 * kVertexBytes + 8), 65'535u);
}

TEST(MeshChunk, NoNarrowIndexIsTheOneThatBeginsANewStrip) {
  Mesh mesh;
  mesh.positions_m.assign(65'535, {0, 0, 0});
  mesh.triangles = {{0, 1, 65'534}};
  const ChunkPart part{&mesh, {}};
  EXPECT_EQ(at<std::uint32_t>(chunk_message(0, 0, {&part, 1}), 24), 0u);
}

TEST(MeshChunk, NeighboursOfOneStepMeet) {
  Mesh left = two_triangles();
  Mesh right = two_triangles();
  right.positions_m[3] += Eigen::Vector3f(0.3f, 0.4f, 0.05f);  // another extent, the other vertices are shared
  const ChunkPart left_part{&left, {}};
  const ChunkPart right_part{&right, {}};
  const float step = step_for(0.5f);
  const std::string left_message = chunk_message(0, 0, {&left_part, 1}, step);
  const std::string right_message = chunk_message(1, 0, {&right_part, 1}, step);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(position_of(left_message, i), position_of(right_message, i)) << i;
}

TEST(MeshChunk, AMeshWithoutExtentIsAllOrigin) {
  Mesh mesh;
  mesh.positions_m = {{5, 5, 5}};
  const ChunkPart part{&mesh, {}};
  EXPECT_LE((position_of(chunk_message(0, 0, {&part, 1}), 0) - Eigen::Vector3f(5, 5, 5)).norm(), 1e-6f);
}

TEST(MeshChunk, AChunkThatIsGoneIsAHeader) {
  const std::string message = chunk_gone_message(3, 4);
  EXPECT_EQ(message.size(), 16u);
  EXPECT_EQ(at<std::uint32_t>(message, 4), 2u);
  EXPECT_EQ(at<std::uint32_t>(message, 8), 3u);
}

TEST(MeshChunk, APictureFollowsItsHeader) {
  const std::vector<std::uint8_t> jpeg = {0xFF, 0xD8, 0xFF, 0xD9};
  const std::string message = picture_message(1, jpeg);
  EXPECT_EQ(at<std::uint32_t>(message, 4), 3u);
  EXPECT_EQ(message.substr(16), "\xFF\xD8\xFF\xD9");
}

}  // namespace
}  // namespace scanknit
