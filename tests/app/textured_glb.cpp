#include "tests/app/textured_glb.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

namespace scanknit::test {
namespace {

using Json = nlohmann::json;

class Glb {
 public:
  explicit Glb(const std::filesystem::path& path) {
    std::ifstream stream(path, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    std::uint32_t json_bytes = 0;
    if (bytes.size() < 28) throw std::runtime_error("no GLB");
    std::memcpy(&json_bytes, bytes.data() + 12, sizeof(json_bytes));
    json = Json::parse(bytes.substr(20, json_bytes));
    binary_ = bytes.substr(20 + json_bytes + 8);
  }

  template <typename T>
  [[nodiscard]] std::vector<T> accessor(const Json& index) const {
    const Json& accessor = json.at("accessors").at(index.get<std::size_t>());
    const std::string bytes = view(accessor.at("bufferView"));
    std::vector<T> values(accessor.at("count").get<std::size_t>());
    if (bytes.size() != values.size() * sizeof(T)) throw std::runtime_error("another type than expected");
    std::memcpy(values.data(), bytes.data(), bytes.size());
    return values;
  }

  [[nodiscard]] std::string view(const Json& index) const {
    const Json& view = json.at("bufferViews").at(index.get<std::size_t>());
    return binary_.substr(view.value("byteOffset", std::size_t{0}), view.at("byteLength").get<std::size_t>());
  }

  Json json;

 private:
  std::string binary_;
};

ColourImage decoded(const std::string& file) {
  const cv::Mat bgr = cv::imdecode(std::vector<char>(file.begin(), file.end()), cv::IMREAD_COLOR);
  ColourImage image(bgr.cols, bgr.rows);
  for (int y = 0; y < bgr.rows; ++y) {
    for (int x = 0; x < bgr.cols; ++x) {
      const auto& c = bgr.at<cv::Vec3b>(y, x);
      image.at(x, y) = {c[2], c[1], c[0]};
    }
  }
  return image;
}

Eigen::Vector3d vector(Rgb8 c) {
  return {double{1} * c.r, double{1} * c.g, double{1} * c.b};
}

}  // namespace

Eigen::Vector3d TexturedMesh::texture_colour(const Triangle& triangle, const std::array<float, 3>& weights) const {
  Eigen::Vector2f uv = Eigen::Vector2f::Zero();
  for (std::size_t k = 0; k < 3; ++k) uv += weights[k] * coordinates.at(triangle[k]);
  const double x = std::clamp(double{uv.x()} * texture.width() - 0.5, 0.0, texture.width() - 1.001);
  const double y = std::clamp(double{uv.y()} * texture.height() - 0.5, 0.0, texture.height() - 1.001);
  const int column = static_cast<int>(x), row = static_cast<int>(y);
  const double s = x - column, t = y - row;
  return (1 - t) * ((1 - s) * vector(texture.at(column, row)) + s * vector(texture.at(column + 1, row))) +
         t * ((1 - s) * vector(texture.at(column, row + 1)) + s * vector(texture.at(column + 1, row + 1)));
}

TexturedMesh read_textured_glb(const std::filesystem::path& path) {
  const Glb glb(path);
  const Json& primitive = glb.json.at("meshes").at(0).at("primitives").at(0);
  TexturedMesh read;
  for (const auto& p : glb.accessor<std::array<float, 3>>(primitive.at("attributes").at("POSITION"))) {
    read.mesh.positions_m.emplace_back(p[0], -p[1], -p[2]);
  }
  for (const auto& uv : glb.accessor<std::array<float, 2>>(primitive.at("attributes").at("TEXCOORD_0"))) {
    read.coordinates.emplace_back(uv[0], uv[1]);
  }
  const auto indices = glb.accessor<std::uint32_t>(primitive.at("indices"));
  for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
    read.mesh.triangles.emplace_back(indices[i], indices[i + 1], indices[i + 2]);
  }
  read.texture = decoded(glb.view(glb.json.at("images").at(0).at("bufferView")));
  return read;
}

}  // namespace scanknit::test
