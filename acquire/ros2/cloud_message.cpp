#include "acquire/ros2/cloud_message.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "core/checked_math.h"

namespace scanknit {
namespace {

constexpr std::uint32_t kMostFields = 100;

std::optional<std::vector<CloudField>> take_fields(CdrReader& reader) {
  const auto count = reader.number<std::uint32_t>();
  if (!count || *count > kMostFields) return std::nullopt;
  std::vector<CloudField> fields;
  for (std::uint32_t i = 0; i < *count; ++i) {
    auto name = reader.text();
    const auto offset = reader.number<std::uint32_t>();
    const auto type = reader.number<std::uint8_t>();
    const auto elements = reader.number<std::uint32_t>();
    if (!name || !offset || !type || !elements) return std::nullopt;
    fields.push_back({*std::move(name), *offset, static_cast<CloudType>(*type), *elements});
  }
  return fields;
}

}  // namespace

std::size_t size_of(CloudType type) {
  switch (type) {
    case CloudType::kInt8:
    case CloudType::kUint8: return 1;
    case CloudType::kInt16:
    case CloudType::kUint16: return 2;
    case CloudType::kInt32:
    case CloudType::kUint32:
    case CloudType::kFloat32: return 4;
    case CloudType::kFloat64: return 8;
  }
  return 0;
}

const CloudField* CloudMessage::find(std::string_view name, std::initializer_list<CloudType> types) const {
  const auto found = std::find_if(fields.begin(), fields.end(), [&](const CloudField& field) {
    const std::size_t size = size_of(field.type);
    const bool is_read = size > 0 && std::find(types.begin(), types.end(), field.type) != types.end();
    const bool fits = point_step >= size && field.offset <= point_step - size;
    return field.name == name && is_read && field.count <= 1 && fits;
  });
  return found == fields.end() ? nullptr : &*found;
}

bool CloudMessage::has_all_points() const {
  const std::uint64_t row = std::uint64_t{width} * point_step;
  // Writers of one row leave its length at anything.
  if (height <= 1) return data.size() >= row * height;
  const auto all = checked_mul<std::uint64_t>(row_step, height);
  return row_step >= row && all && data.size() >= *all;
}

double CloudMessage::number(const CloudField& field, std::size_t point) const {
  switch (field.type) {
    case CloudType::kInt8: return value<std::int8_t>(field, point);
    case CloudType::kUint8: return value<std::uint8_t>(field, point);
    case CloudType::kInt16: return value<std::int16_t>(field, point);
    case CloudType::kUint16: return value<std::uint16_t>(field, point);
    case CloudType::kInt32: return value<std::int32_t>(field, point);
    case CloudType::kUint32: return value<std::uint32_t>(field, point);
    case CloudType::kFloat32: return value<float>(field, point);
    case CloudType::kFloat64: return value<double>(field, point);
  }
  return 0;
}

Result<CloudMessage> parse_cloud_message(const RosMessage& message) {
  const Error truncated{ErrorCode::kInput,
                        "a message of sensor_msgs/PointCloud2 is truncated, or not as its type is written"};
  auto reader = CdrReader::open(message);
  auto header = reader ? take_header(*reader) : std::nullopt;
  if (!header) return truncated;
  const auto height = reader->number<std::uint32_t>();
  const auto width = reader->number<std::uint32_t>();
  auto fields = take_fields(*reader);
  if (!height || !width || !fields) return truncated;
  const auto is_big_endian = reader->number<std::uint8_t>();
  const auto point_step = reader->number<std::uint32_t>();
  const auto row_step = reader->number<std::uint32_t>();
  const auto data = reader->sequence();
  if (!is_big_endian || !point_step || !row_step || !data) return truncated;
  return CloudMessage{*std::move(header),  *width,      *height,   *std::move(fields),
                      *is_big_endian != 0, *point_step, *row_step, *data};
}

}  // namespace scanknit
