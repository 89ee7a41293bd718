// By Ouster's "Sensor Documentation" (firmware 2.5 and 3.0): "Lidar Data Packet Format", "Lidar Range to XYZ",
// "Sensor Metadata".
#include "acquire/lidar/ouster_packets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "acquire/parse/json_numbers.h"
#include "acquire/replay/text_numbers.h"
#include "core/files/ascii_numbers.h"
#include "core/rotation.h"

namespace scanknit {
namespace {

using Bytes = std::span<const std::byte>;
using Json = nlohmann::json;

constexpr double kMillimetre = 0.001;
constexpr std::array<OusterProfile, 4> kProfiles = {{{"LEGACY", 0, 16, 12, 4, 0, 0xfffff, 1, 1},
                                                     {"RNG19_RFL8_SIG16_NIR16", 32, 12, 12, 0, 32, 0x7ffff, 1, 1},
                                                     {"RNG19_RFL8_SIG16_NIR16_DUAL", 32, 12, 16, 0, 32, 0x7ffff, 1, 2},
                                                     {"RNG15_RFL8_NIR8", 32, 12, 4, 0, 32, 0x7fff, 8, 1}}};

/// The value of a key: at the top, where older firmware has it, or in a section.
const Json* find_value(const Json& json, const char* section, const char* key) {
  const auto nested = json.find(section);
  const Json& place = nested != json.end() && nested->is_object() ? *nested : json;
  const auto found = place.find(key);
  return found == place.end() ? nullptr : &*found;
}

std::optional<std::string> find_text(const Json& json, const char* section, const char* key) {
  const Json* value = find_value(json, section, key);
  return value != nullptr && value->is_string() ? std::optional(value->get<std::string>()) : std::nullopt;
}

std::optional<double> find_number(const Json& json, const char* section, const char* key) {
  const Json* value = find_value(json, section, key);
  return value != nullptr && value->is_number() ? std::optional(value->get<double>()) : std::nullopt;
}

/// The angles of the beams in radians; empty: there are none, or wrong ones.
std::vector<double> find_angles(const Json& json, const char* key) {
  constexpr std::size_t kMostBeams = 256;
  const Json* list = find_value(json, "beam_intrinsics", key);
  if (list == nullptr || list->empty() || list->size() > kMostBeams) return {};
  auto angles = json_list(*list, list->size()).value_or(std::vector<double>());
  for (double& angle : angles) {
    if (!(std::abs(angle) <= 360)) return {};
    angle *= kDegree;
  }
  return angles;
}

/// A number of columns or pixels; `otherwise` where there is none; 0 where it cannot be.
std::size_t find_count(const Json& json, const char* section, const char* key, std::size_t most,
                       std::size_t otherwise) {
  const auto number = find_number(json, section, key);
  if (!number) return otherwise;
  return *number >= 1 && *number <= static_cast<double>(most) ? static_cast<std::size_t>(*number) : 0;
}

/// "1024x10": columns and turns a second.
std::pair<std::size_t, double> parse_mode(std::string_view mode) {
  const std::size_t cross = mode.find('x');
  if (cross == std::string_view::npos) return {0, 0};
  const auto columns = parse_integer(mode.substr(0, cross)), turns = parse_integer(mode.substr(cross + 1));
  constexpr std::int64_t kMost = 4096;
  if (!columns || !turns || *columns < 1 || *columns > kMost || *turns < 1 || *turns > 100) return {0, 0};
  return {static_cast<std::size_t>(*columns), static_cast<double>(*turns)};
}

/// How far the beams begin from the lidar's axis, for firmware that does not say it.
double usual_beam_out_mm(std::string_view model) {
  if (model.starts_with("OS-0")) return 27.67;
  if (model.starts_with("OS-2")) return 13.762;
  return model.starts_with("OS-1") ? 15.806 : 12.163;
}

Result<void> read_beams(const Json& json, OusterMetadata& metadata) {
  metadata.altitudes = find_angles(json, "beam_altitude_angles");
  metadata.azimuths = find_angles(json, "beam_azimuth_angles");
  if (metadata.altitudes.empty() || metadata.azimuths.size() != metadata.altitudes.size()) {
    return Error{ErrorCode::kInput, "no metadata of an Ouster: expected beam_altitude_angles and beam_azimuth_angles"};
  }
  const Json* matrix = find_value(json, "beam_intrinsics", "beam_to_lidar_transform");
  const auto numbers = matrix != nullptr ? json_list(*matrix, 16) : std::nullopt;
  const auto out_mm = find_number(json, "beam_intrinsics", "lidar_origin_to_beam_origin_mm");
  metadata.beam_out_m = kMillimetre * (numbers ? (*numbers)[3] : out_mm.value_or(usual_beam_out_mm(metadata.model)));
  metadata.beam_up_m = kMillimetre * (numbers ? (*numbers)[11] : 0);
  constexpr double kMost_m = 1;
  if (!(std::abs(metadata.beam_out_m) < kMost_m && std::abs(metadata.beam_up_m) < kMost_m)) {
    return Error{ErrorCode::kInput, "the beams' origin is farther from the lidar's than can be"};
  }
  return {};
}

Result<void> read_placement(const Json& json, OusterMetadata& metadata) {
  std::vector<double> numbers = {-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 36.18, 0, 0, 0, 1};  // what most sensors say
  if (const Json* matrix = find_value(json, "lidar_intrinsics", "lidar_to_sensor_transform")) {
    const auto given = json_list(*matrix, 16);
    if (!given) return Error{ErrorCode::kInput, "lidar_to_sensor_transform: expected 16 numbers"};
    numbers = *given;
  }
  auto pose = pose_from_numbers(numbers);
  if (!pose) return Error{ErrorCode::kInput, "lidar_to_sensor_transform: " + pose.error().message};
  metadata.T_sensor_lidar = *pose;
  metadata.T_sensor_lidar.translation() *= kMillimetre;
  return {};
}

Result<void> read_format(const Json& json, OusterMetadata& metadata) {
  const char* section = json.contains("lidar_data_format") ? "lidar_data_format" : "data_format";
  std::string profile = kProfiles[0].name;  // the only one of firmware before 2.0
  const auto nested = json.find(section);
  if (nested != json.end() && nested->is_object()) {
    profile = find_text(json, section, "udp_profile_lidar").value_or(profile);
  }
  const auto known =
      std::find_if(kProfiles.begin(), kProfiles.end(), [&](const OusterProfile& p) { return p.name == profile; });
  if (known == kProfiles.end()) {
    return Error{ErrorCode::kInput,
                 fmt::format("the UDP profile {} is not read; expected LEGACY, RNG19_RFL8_SIG16_NIR16, "
                             "RNG19_RFL8_SIG16_NIR16_DUAL or RNG15_RFL8_NIR8",
                             profile.substr(0, 64))};
  }
  metadata.profile = &*known;
  const auto [mode_columns, turns] =
      parse_mode(find_text(json, json.contains("config_params") ? "config_params" : "", "lidar_mode").value_or(""));
  metadata.frames_per_s = turns;
  constexpr std::size_t kMostColumns = 4096, kMostInPacket = 256, kMostPixels = 256, kUsual = 16;
  metadata.columns_per_frame = find_count(json, section, "columns_per_frame", kMostColumns, mode_columns);
  metadata.columns_per_packet = find_count(json, section, "columns_per_packet", kMostInPacket, kUsual);
  metadata.pixels_per_column = find_count(json, section, "pixels_per_column", kMostPixels, metadata.altitudes.size());
  if (metadata.columns_per_frame == 0 || metadata.columns_per_packet == 0 ||
      metadata.pixels_per_column != metadata.altitudes.size()) {
    return Error{ErrorCode::kInput,
                 fmt::format("{} beams, {} pixels a column, {} columns a frame, {} a packet cannot be",
                             metadata.altitudes.size(), metadata.pixels_per_column, metadata.columns_per_frame,
                             metadata.columns_per_packet)};
  }
  return {};
}

class OusterPackets final : public LidarPackets {
 public:
  explicit OusterPackets(OusterMetadata metadata) : metadata_(std::move(metadata)), profile_(*metadata_.profile) {
    column_bytes_ = profile_.column_header + profile_.pixel * metadata_.pixels_per_column + profile_.column_footer;
  }

  [[nodiscard]] std::string name() const override { return "ouster"; }
  [[nodiscard]] std::size_t blocks() const override { return metadata_.columns_per_packet; }
  [[nodiscard]] std::int64_t clock_period_ns() const override { return 0; }
  [[nodiscard]] std::int64_t duration_ns() const override {
    if (metadata_.frames_per_s <= 0) return 0;
    return std::llround(1e9 * static_cast<double>(metadata_.columns_per_packet) /
                        (metadata_.frames_per_s * static_cast<double>(metadata_.columns_per_frame)));
  }
  [[nodiscard]] bool fits(Bytes packet) const override { return packet.size() == metadata_.packet_bytes(); }

  [[nodiscard]] std::optional<PacketHead> head(Bytes packet) override {
    const auto first = first_column(packet);
    if (!first) return std::nullopt;
    const std::uint16_t frame = frame_of(packet, *first);
    PacketHead head{.clock_ns = clock_ns(packet, *first), .turn = frame};
    constexpr std::uint16_t kLate = 4;  // a packet of so many frames before came late
    const auto before = static_cast<std::uint16_t>(frame_ - frame);
    if (!has_frame_ || before > kLate) {
      head.turn_begins = 0;
      frame_ = frame;
      has_frame_ = true;
    }
    return head;
  }

  void add_points(Bytes packet, PacketBlocks range, std::int64_t offset_ns, Sweep& sweep) const override {
    const auto first = first_column(packet);
    if (!first) return;
    const std::int64_t begins_ns = clock_ns(packet, *first);
    for (std::size_t i = range.first; i < std::min(range.end, metadata_.columns_per_packet); ++i) {
      const Bytes bytes = column(packet, i);
      if (!is_valid(bytes)) continue;
      constexpr std::int64_t kLongest_ns = 1'000'000'000;  // a turn takes 0.2 s at most
      const std::int64_t after_ns = clock_ns(packet, i) - begins_ns;
      if (std::abs(after_ns) < kLongest_ns) add_column(bytes, offset_ns + after_ns, sweep);
    }
  }

 private:
  [[nodiscard]] Bytes column(Bytes packet, std::size_t index) const {
    return packet.subspan(profile_.packet_header + index * column_bytes_, column_bytes_);
  }
  [[nodiscard]] bool is_legacy() const { return profile_.packet_header == 0; }

  [[nodiscard]] bool is_valid(Bytes column) const {
    const std::size_t measurement = little_endian_at<std::uint16_t>(column, 8);
    const unsigned status = is_legacy() ? little_endian_at<std::uint32_t>(column, column.size() - 4)
                                        : little_endian_at<std::uint16_t>(column, 10);
    return (status & 1U) != 0 && measurement < metadata_.columns_per_frame;
  }
  [[nodiscard]] std::optional<std::size_t> first_column(Bytes packet) const {
    for (std::size_t i = 0; i < metadata_.columns_per_packet; ++i) {
      if (is_valid(column(packet, i))) return i;
    }
    return std::nullopt;
  }
  [[nodiscard]] std::int64_t clock_ns(Bytes packet, std::size_t index) const {
    constexpr std::uint64_t kClockEnd_ns = std::numeric_limits<std::int64_t>::max() / 2;
    const auto time = little_endian_at<std::uint64_t>(column(packet, index), 0);
    return static_cast<std::int64_t>(std::min(time, kClockEnd_ns));
  }
  [[nodiscard]] std::uint16_t frame_of(Bytes packet, std::size_t index) const {
    return is_legacy() ? little_endian_at<std::uint16_t>(column(packet, index), 10)
                       : little_endian_at<std::uint16_t>(packet, 2);
  }

  /// "Lidar Range to XYZ": the encoder's angle falls with the measurement's number.
  void add_column(Bytes column, std::int64_t offset_ns, Sweep& sweep) const {
    const double turned = little_endian_at<std::uint16_t>(column, 8) / static_cast<double>(metadata_.columns_per_frame);
    const double encoder = kFullTurn * (1 - turned);
    const Eigen::Vector3d origin_m(metadata_.beam_out_m * std::cos(encoder), metadata_.beam_out_m * std::sin(encoder),
                                   metadata_.beam_up_m);
    const double to_origin_m = std::hypot(metadata_.beam_out_m, metadata_.beam_up_m);
    for (std::size_t beam = 0; beam < metadata_.pixels_per_column; ++beam) {
      const std::size_t at = profile_.column_header + beam * profile_.pixel;
      double before_m = 0;
      for (int i = 0; i < profile_.returns; ++i) {
        const double range_m = range_m_at(column, at + 4 * static_cast<std::size_t>(i));
        if (range_m == 0 || range_m == before_m) continue;
        before_m = range_m;
        const double azimuth = encoder - metadata_.azimuths[beam], altitude = metadata_.altitudes[beam];
        const Eigen::Vector3d ray(std::cos(altitude) * std::cos(azimuth), std::cos(altitude) * std::sin(azimuth),
                                  std::sin(altitude));
        const Eigen::Vector3d p_lidar = origin_m + (range_m - to_origin_m) * ray;
        sweep.points_m.emplace_back((metadata_.T_sensor_lidar * p_lidar).cast<float>());
        sweep.rings.push_back(static_cast<std::uint16_t>(beam));
        sweep.offsets_ns.push_back(offset_ns);
      }
    }
  }

  [[nodiscard]] double range_m_at(Bytes column, std::size_t at) const {
    const std::uint32_t range = little_endian_at<std::uint32_t>(column, at) & profile_.range_mask;
    return range * profile_.range_unit_mm * kMillimetre;
  }

  OusterMetadata metadata_;
  const OusterProfile& profile_;
  std::size_t column_bytes_ = 0;
  std::uint16_t frame_ = 0;
  bool has_frame_ = false;
};

}  // namespace

std::size_t OusterMetadata::packet_bytes() const {
  return profile->packet_header + profile->packet_footer +
         columns_per_packet * (profile->column_header + profile->pixel * pixels_per_column + profile->column_footer);
}

Result<OusterMetadata> parse_ouster_metadata(std::string_view text) {
  const auto json = Json::parse(text, nullptr, false);
  if (!json.is_object()) return Error{ErrorCode::kInput, "not a JSON object, or truncated"};
  OusterMetadata metadata;
  metadata.model = find_text(json, "sensor_info", "prod_line").value_or("").substr(0, 64);
  if (auto read = read_beams(json, metadata); !read) return read.error();
  if (auto read = read_placement(json, metadata); !read) return read.error();
  if (auto read = read_format(json, metadata); !read) return read.error();
  return metadata;
}

std::unique_ptr<LidarPackets> ouster_packets(OusterMetadata metadata) {
  return std::make_unique<OusterPackets>(std::move(metadata));
}

}  // namespace scanknit
