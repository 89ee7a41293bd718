// The module libscanknit_acquire_pcl.so.
#include <pcl/PCLPointCloud2.h>
#include <pcl/console/print.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/io/lzf_image_io.h>
#include <pcl/io/pcd_io.h>
#include <pcl/point_cloud.h>
#include <pcl/point_types.h>

#include <Eigen/Geometry>
#include <cstring>
#include <sstream>

#include "acquire/pcl/acquire_pcl.h"
#include "core/version.h"

namespace scanknit {
namespace {

void silence_pcl() {
  pcl::console::setVerbosityLevel(pcl::console::L_ALWAYS);  // a library never prints on input
}

std::optional<std::vector<std::uint8_t>> read_pcd_points(std::span<const std::byte> file, const PcdHeader& expected) {
  silence_pcl();
  try {
    pcl::PCDReader reader;
    pcl::PCLPointCloud2 cloud;
    std::string text(file.size(), '\0');
    std::memcpy(text.data(), file.data(), file.size());
    std::istringstream stream(text);
    Eigen::Vector4f origin;
    Eigen::Quaternionf orientation;
    int version = 0;
    int encoding = 0;
    unsigned int body = 0;
    if (reader.readHeader(stream, cloud, origin, orientation, version, encoding, body) != 0) return std::nullopt;
    // PCL's reading of the header must be ours, since ours is the one that was checked.
    const bool agrees = cloud.width == static_cast<std::uint32_t>(expected.width) &&
                        cloud.height == static_cast<std::uint32_t>(expected.height) &&
                        cloud.point_step == expected.point_bytes && body == expected.header_bytes &&
                        encoding == static_cast<int>(expected.encoding);
    if (!agrees) return std::nullopt;
    const std::size_t bytes = std::size_t{cloud.width} * cloud.height * cloud.point_step;
    cloud.data.resize(bytes);
    int status = 0;
    if (expected.encoding == PcdEncoding::kAscii) {
      stream.clear();
      stream.seekg(body);
      status = reader.readBodyASCII(stream, cloud, version);
    } else {
      std::vector<unsigned char> raw(file.size());
      std::memcpy(raw.data(), file.data(), file.size());
      const bool is_compressed = expected.encoding == PcdEncoding::kBinaryCompressed;
      status = reader.readBodyBinary(raw.data(), cloud, version, is_compressed, body);
    }
    if (status != 0 || cloud.data.size() != bytes) return std::nullopt;
    return std::move(cloud.data);
  } catch (const std::exception&) {  // pcl::IOException, std::bad_alloc, boost's casts
    return std::nullopt;
  }
}

// PCL's readers with their parts opened: they otherwise read from a file name and return points.
class OpenedReader : public pcl::io::LZFDepth16ImageReader {
 public:
  using pcl::io::LZFDepth16ImageReader::decompress;
};

class DepthParameters : public pcl::io::LZFDepth16ImageReader {
 public:
  [[nodiscard]] double metres_per_unit() const { return z_multiplication_factor_; }
};

std::optional<std::vector<char>> unpack_lzf(std::span<const std::byte> packed, std::size_t unpacked_bytes) {
  silence_pcl();
  try {
    std::vector<char> data(packed.size());
    std::memcpy(data.data(), packed.data(), packed.size());
    std::vector<char> unpacked(unpacked_bytes);
    OpenedReader reader;
    if (!reader.decompress(data, unpacked) || unpacked.size() != unpacked_bytes) return std::nullopt;
    return unpacked;
  } catch (const std::exception&) {
    return std::nullopt;
  }
}

template <typename Reader>
std::optional<CameraIntrinsics> read_camera(Reader& reader, const std::string& xml) {
  try {
    std::istringstream stream(xml);
    if (!reader.readParameters(stream)) return std::nullopt;
  } catch (const std::exception&) {  // boost::property_tree's parse and path errors
    return std::nullopt;
  }
  const auto p = reader.getParameters();
  const CameraIntrinsics camera{1, 1, p.focal_length_x, p.focal_length_y, p.principal_point_x, p.principal_point_y};
  return camera.is_valid() ? std::optional(camera) : std::nullopt;
}

PclzfParameters read_pclzf_parameters(const std::string& xml) {
  silence_pcl();
  DepthParameters depth;
  pcl::io::LZFRGB24ImageReader colour;
  PclzfParameters parameters;
  parameters.depth = read_camera(depth, xml);
  parameters.metres_per_unit = depth.metres_per_unit();
  parameters.colour = read_camera(colour, xml);
  return parameters;
}

std::vector<int> find_inliers(const std::vector<Eigen::Vector3f>& points_m, int neighbours, double std_multiplier) {
  auto cloud = pcl::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const Eigen::Vector3f& p : points_m) cloud->push_back({p.x(), p.y(), p.z()});
  pcl::StatisticalOutlierRemoval<pcl::PointXYZ> filter;
  filter.setInputCloud(cloud);
  filter.setMeanK(neighbours);
  filter.setStddevMulThresh(std_multiplier);
  std::vector<int> kept;
  filter.filter(kept);
  return kept;
}

}  // namespace
}  // namespace scanknit

extern "C" __attribute__((visibility("default"))) const scanknit::ModuleEntry* scanknit_module() {
  using namespace scanknit;
  static constexpr AcquirePcl kOffers{read_pcd_points, unpack_lzf, read_pclzf_parameters, find_inliers};
  static constexpr ModuleEntry kEntry{kVersion, &kOffers};
  return &kEntry;
}
