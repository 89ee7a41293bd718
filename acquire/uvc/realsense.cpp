#include "acquire/uvc/realsense.h"

#include <algorithm>
#include <array>

#include "core/files/byte_reader.h"

namespace scanknit {
namespace {

constexpr std::uint8_t kSetCurrent = 0x01;
constexpr std::uint8_t kGetCurrent = 0x81;
constexpr std::uint8_t kGetLength = 0x85;

// {C9606CCB-594C-4D25-AF47-CCC496435995}, as it stands in descriptors.
constexpr std::array<std::uint8_t, 16> kGuid = {0xCB, 0x6C, 0x60, 0xC9, 0x4C, 0x59, 0x25, 0x4D,
                                                0xAF, 0x47, 0xCC, 0xC4, 0x96, 0x43, 0x59, 0x95};

constexpr std::uint16_t selector(RealsenseControl control) {
  return static_cast<std::uint16_t>(static_cast<std::uint16_t>(control) << 8);
}

}  // namespace

std::uint8_t realsense_unit_of(const UvcFunction& function) {
  const auto is_ours = [](const UvcExtensionUnit& unit) {
    return std::equal(unit.guid.begin(), unit.guid.end(), kGuid.begin(),
                      [](std::byte a, std::uint8_t b) { return a == std::byte{b}; });
  };
  const auto& units = function.extension_units;
  const auto unit = std::find_if(units.begin(), units.end(), is_ours);
  return unit == units.end() ? std::uint8_t{0} : unit->id;
}

Result<std::uint16_t> RealsenseUnit::length_of(RealsenseControl control) {
  const auto answer = device_.read_class(kGetLength, selector(control), index(), 2);
  if (!answer) return answer.error();
  const auto length = ByteReader(*answer).little_endian<std::uint16_t>();
  if (!length || *length == 0) return Error{ErrorCode::kDevice, "the camera does not say how long its control is"};
  return *length;
}

Result<std::vector<std::byte>> RealsenseUnit::ask(RealsenseOpcode opcode, std::uint32_t parameter) {
  const auto length = length_of(RealsenseControl::kHardwareMonitor);
  if (!length) return length.error();
  auto command = encode_command(opcode, parameter);
  command.resize(std::max<std::size_t>(command.size(), *length));
  const std::uint16_t monitor = selector(RealsenseControl::kHardwareMonitor);
  if (const auto sent = device_.write_class(kSetCurrent, monitor, index(), command); !sent) return sent.error();
  const auto reply = device_.read_class(kGetCurrent, monitor, index(), *length);
  if (!reply) return reply.error();
  const auto data = decode_reply(opcode, *reply);
  if (!data) return data.error();
  return std::vector<std::byte>(data->begin(), data->end());
}

Result<RealsenseIdentity> RealsenseUnit::identity() {
  const auto data = ask(RealsenseOpcode::kIdentity, 0);
  if (!data) return data.error();
  return parse_identity(*data);
}

Result<CameraIntrinsics> RealsenseUnit::depth_camera(int width, int height) {
  const auto table = ask(RealsenseOpcode::kReadTable, kDepthTable);
  if (!table) return table.error();
  return parse_depth_table(*table, width, height);
}

Result<double> RealsenseUnit::baseline_m() {
  const auto table = ask(RealsenseOpcode::kReadTable, kDepthTable);
  if (!table) return table.error();
  return parse_baseline(*table);
}

Result<RealsenseColour> RealsenseUnit::colour_camera(int width, int height) {
  const auto table = ask(RealsenseOpcode::kReadTable, kColourTable);
  if (!table) return table.error();
  return parse_colour_table(*table, width, height);
}

Result<double> RealsenseUnit::depth_unit_m() {
  const auto control = ask(RealsenseOpcode::kReadAdvanced, kDepthTableControl);
  if (!control) return control.error();
  return parse_depth_unit(*control);
}

Result<void> RealsenseUnit::set(RealsenseControl control, int value) {
  const auto length = length_of(control);
  if (!length) return length.error();
  std::vector<std::byte> bytes(*length);
  for (std::size_t i = 0; i < std::min<std::size_t>(4, bytes.size()); ++i) {
    bytes[i] = static_cast<std::byte>((value >> (8 * i)) & 0xFF);
  }
  return device_.write_class(kSetCurrent, selector(control), index(), bytes);
}

}  // namespace scanknit
