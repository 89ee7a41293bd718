#include "tests/usb/vcam/vcam.h"

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "tests/usb/realsense_bytes.h"

namespace scanknit::test {
namespace {

constexpr std::uint8_t kSetCurrent = 0x01, kGetCurrent = 0x81, kGetLength = 0x85;
constexpr std::size_t kMonitorBytes = 1024;
constexpr std::uint8_t kDepthInterface = 1, kColourInterface = 3;

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8 * i);
  return value;
}

void put_u32(std::span<std::byte> bytes, std::size_t at, std::uint32_t value) {
  for (std::size_t i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::byte>((value >> (8 * i)) & 0xFF);
}

bool is_hardware_monitor(std::uint16_t value, std::uint16_t index) {
  return index == 0x0300 && value == 0x0100;
}

std::size_t probe_bytes_of(std::uint16_t version) {
  return version >= 0x0150 ? 48 : version >= 0x0110 ? 34 : 26;
}

}  // namespace

Vcam::Vcam(const VcamOptions& options) : options_(options) {
  for (Stream& stream : streams_) {
    stream.probe.resize(probe_bytes_of(options_.uvc_version));
    stream.probe[2] = stream.probe[3] = std::byte{1};  // the first format and its first size, until asked for others
    put_u32(stream.probe, 4, stream.interval_100ns);
    answer_probe(stream);
  }
}

UsbIdentity Vcam::identity() const {
  return {options_.vendor, options_.product, options_.serial, options_.speed_mbit};
}

std::vector<ModelEndpoint> Vcam::endpoints() const {
  std::vector<ModelEndpoint> all = {{kDepthEndpoint, options_.is_isochronous}};
  if (options_.has_colour) all.push_back({kColourEndpoint, options_.has_isochronous_colour});
  return all;
}

std::optional<std::vector<std::byte>> Vcam::control(std::uint8_t type, std::uint8_t request, std::uint16_t value,
                                                    std::uint16_t index, std::uint16_t length,
                                                    std::span<const std::byte> data, std::int64_t now_ns) {
  if ((type & 0x60) != 0x20) return std::nullopt;  // class requests only
  const int unit = index >> 8, interface = index & 0xFF;
  if (unit == 0 && interface == kDepthInterface) {
    return streaming_control(streams_[0], request, value, length, data, now_ns);
  }
  if (unit == 0 && interface == kColourInterface && options_.has_colour) {
    return streaming_control(streams_[1], request, value, length, data, now_ns);
  }
  return unit_control(request, value, index, length, data);
}

std::optional<std::vector<std::byte>> Vcam::streaming_control(Stream& stream, std::uint8_t request, std::uint16_t value,
                                                              std::uint16_t length, std::span<const std::byte> data,
                                                              std::int64_t now_ns) {
  const std::size_t expected = probe_bytes_of(options_.uvc_version);
  if (control_faults.probe_stalls) return std::nullopt;
  if (request == kSetCurrent) {
    if (data.size() != expected) return std::nullopt;  // as strict as Linux is the other way round
    stream.probe.assign(data.begin(), data.end());
    answer_probe(stream);
    if (value == 0x0200) {
      ++commits;
      if (&stream == &streams_[0]) depth_format = std::to_integer<int>(stream.probe[2]);
      begin(stream, now_ns);
    }
    return std::vector<std::byte>{};
  }
  if (request != kGetCurrent) return std::nullopt;
  auto answer = stream.probe;
  if (control_faults.probe_changes_format) answer[2] ^= std::byte{3};
  if (control_faults.probe_has_no_sizes) put_u32(answer, 18, 0);
  answer.resize(control_faults.probe_bytes.value_or(expected));
  answer.resize(std::min<std::size_t>(answer.size(), length));
  return answer;
}

/// The sizes of what was asked for.
void Vcam::answer_probe(Stream& stream) {
  const bool is_colour = &stream == &streams_[1];
  stream.is_compressed = is_colour && (stream.probe[2] == std::byte{2} || !options_.has_yuyv);
  stream.interval_100ns = std::max(1u, u32_at(stream.probe, 4));
  stream.picture_bytes = 2 * pixels();
  const std::size_t header_bytes = has_metadata(stream) ? 60 : 12;
  stream.payload_bytes = options_.payload_bytes > 0 ? options_.payload_bytes : stream.picture_bytes + header_bytes;
  if (is_isochronous(stream)) stream.payload_bytes = 3072;
  put_u32(stream.probe, 18, static_cast<std::uint32_t>(stream.picture_bytes));
  put_u32(stream.probe, 22, static_cast<std::uint32_t>(stream.payload_bytes));
}

void Vcam::begin(Stream& stream, std::int64_t now_ns) {
  if (!is_isochronous(stream)) stream.is_active = true;  // an isochronous one waits for its alternate setting
  stream.is_silent = false;
  stream.payloads.clear();
  stream.sent = 0;
  stream.due_ns = now_ns;
}

bool Vcam::ignores(std::uint8_t type, std::uint16_t value, std::uint16_t index) const {
  if (control_faults.is_mute) return true;
  return control_faults.has_mute_calibration && (type & 0x60) == 0x20 && is_hardware_monitor(value, index);
}

void Vcam::set_alternate(std::uint8_t interface, std::uint8_t alternate, std::int64_t now_ns) {
  Stream& stream = streams_[interface == kColourInterface ? 1 : 0];
  const bool is_streaming_interface = interface == kDepthInterface || interface == kColourInterface;
  if (!is_streaming_interface || !is_isochronous(stream)) return;
  begin(stream, now_ns);
  stream.is_active = alternate != 0;
}

void Vcam::clear_halt(std::uint8_t endpoint) {
  Stream& stream = stream_of(endpoint);
  if (std::exchange(stream.is_halted, false)) ++halts_cleared;
  stream.payloads.clear();
  stream.sent = 0;
}

std::optional<std::vector<std::byte>> Vcam::unit_control(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                                         std::uint16_t length, std::span<const std::byte> data) {
  const bool is_monitor = is_hardware_monitor(value, index);
  if (is_monitor && control_faults.has_no_calibration) return std::nullopt;
  if (request == kGetLength)
    return std::vector<std::byte>(is_monitor ? Bytes{}.u16(kMonitorBytes).vector() : Bytes{}.u16(2).vector());
  if (request == kSetCurrent && !is_monitor) {
    written[{index, value}].assign(data.begin(), data.end());
    return std::vector<std::byte>{};
  }
  if (request == kGetCurrent && is_monitor) {
    auto answer = reply_;
    answer.resize(std::min<std::size_t>(kMonitorBytes, length));
    return answer;
  }
  if (request != kSetCurrent || data.size() < 24) return std::nullopt;
  const std::uint32_t opcode = u32_at(data, 4), table = u32_at(data, 8);
  constexpr std::uint32_t kReadAdvanced = 0x2C, kDepthTableControl = 9, kNotNow = 0xFFFFFFEC;  // an error code: -20
  Bytes reply;
  reply.u32(opcode == kReadAdvanced && control_faults.has_no_advanced_mode ? kNotNow : opcode);
  // Micrometres; clamps, disparity mode and shift.
  if (opcode == kReadAdvanced && table == kDepthTableControl)
    reply.u32(options_.depth_unit_um).u32(0).u32(65535).fill(8);
  if (opcode == 0x10) reply.add(identity_data());
  if (opcode == 0x15 && table == kDepthTable) reply.add(depth_table());
  if (opcode == 0x15 && table == kColourTable) reply.add(colour_table());
  const bool is_broken =
      control_faults.has_broken_calibration || (control_faults.has_broken_colour && table == kColourTable);
  if (is_broken) reply[reply.size() - 40] ^= std::byte{1};
  reply_ = reply.vector();
  return std::vector<std::byte>{};
}

std::span<const std::uint16_t> Vcam::depth_pixels(std::uint64_t n, std::size_t count) {
  constexpr std::size_t kPixels = 1280 * 720, kNumbers = 4096;
  static const std::vector<std::uint16_t> all = [] {
    std::vector<std::uint16_t> values(kPixels + kNumbers);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<std::uint16_t>(i);
    return values;
  }();
  return std::span(all).subspan(n % kNumbers, count);
}

std::vector<std::byte> Vcam::picture(const Stream& stream) const {
  const bool is_depth = &stream == &streams_[0];
  const bool is_pair = is_depth && depth_format == kPairFormat;
  if (is_pair && options_.infrared_pair) return options_.infrared_pair(stream.number);
  if (is_depth && options_.depth_picture) return options_.depth_picture(stream.number);
  if (!is_depth && options_.colour_picture) return options_.colour_picture(stream.number);
  if (!stream.is_compressed) {
    const auto bytes = std::as_bytes(depth_pixels(stream.number, pixels()));
    return {bytes.begin(), bytes.end()};
  }
  Bytes bytes{0xFF, 0xD8};
  return bytes.fill(20'000 + stream.number % 100, static_cast<int>(stream.number % 200)).add({0xFF, 0xD9}).vector();
}

std::vector<std::byte> Vcam::header(const Stream& stream, bool is_last, bool has_time) const {
  const bool tells_more = has_time && has_metadata(stream);
  const int flags = 0x80 | (has_time ? 0x0C : 0) | (stream.frame_id ? 1 : 0) | (is_last ? 2 : 0);
  Bytes bytes{tells_more ? 60 : has_time ? 12 : 2, flags};
  if (has_time) bytes.u32(picture_us_).u32(picture_us_).u16(0);
  if (tells_more) {
    bytes.u32(0x80000001)
        .u32(48)
        .u32(1)
        .u32(0)
        .u32(static_cast<std::uint32_t>(stream.number))
        .u32(picture_us_)
        .fill(24);
  }
  return bytes.vector();
}

/// The next picture as payloads, when it is due.
void Vcam::make_picture(Stream& stream, std::int64_t now_ns) {
  if (!stream.is_active || stream.is_silent || !stream.payloads.empty() || now_ns < stream.due_ns) return;
  if (&stream == &streams_[0] && stream.number >= depth_waits_at) return;
  if (!clock_is_frozen) {
    picture_us_ = options_.clock_start_us + static_cast<std::uint32_t>(now_ns / 1000 + clock_offset_us_);
  }
  const auto bytes = picture(stream);
  const std::size_t header_bytes = header(stream, false, true).size();
  const std::size_t part = stream.payload_bytes - header_bytes;
  for (std::size_t at = 0; at < bytes.size(); at += part) {
    const std::size_t size = std::min(part, bytes.size() - at);
    Payload payload{header(stream, at + size == bytes.size(), true)};
    payload.bytes.insert(payload.bytes.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at),
                         bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
    stream.payloads.push_back(std::move(payload));
  }
  stream.sent = 0;
  const auto& faults = faults_of(stream);
  if (const auto fault = faults.find(stream.number); fault != faults.end()) misbehave(stream, fault->second);
  if (&stream == &streams_[0]) {
    if (lasting_fault && stream.number >= lasting_fault->from && commits < lasting_fault->until_commits)
      misbehave(stream, lasting_fault->fault);
  }
  stream.due_ns += stream.interval_100ns * std::int64_t{100};
  stream.frame_id = !stream.frame_id;
  ++stream.number;
}

void Vcam::misbehave(Stream& stream, Fault fault) {
  auto& payloads = stream.payloads;
  if (payloads.empty()) return;  // another fault has taken the picture
  auto& last = payloads.back().bytes;
  const auto middle_at = static_cast<std::ptrdiff_t>(payloads.size() / 2);
  Payload& middle = payloads[payloads.size() / 2];
  switch (fault) {
    case Fault::kTruncated: last.resize(last.size() - 1000); break;
    case Fault::kOversize: last.resize(last.size() + 100); break;
    case Fault::kHeaderLength0: payloads.front().bytes[0] = std::byte{0}; break;
    case Fault::kHeaderLength1: payloads.front().bytes[0] = std::byte{1}; break;
    case Fault::kHeaderTooLong:
      payloads.front().bytes[0] = std::byte{255};
      payloads.front().bytes.resize(100);
      break;
    case Fault::kErrorBit: payloads.front().bytes[1] |= std::byte{0x40}; break;
    case Fault::kSameFrameId:
      for (Payload& payload : payloads) payload.bytes[1] ^= std::byte{1};
      stream.frame_id = !stream.frame_id;
      break;
    case Fault::kMissingEnd: payloads.back().bytes[1] &= ~std::byte{2}; break;
    case Fault::kHeaderOnly:
      payloads.resize(1);
      payloads.front().bytes = header(stream, true, true);
      break;
    case Fault::kBabble: payloads.front().status = -EOVERFLOW; break;
    case Fault::kIoError: payloads.front().status = -EPROTO; break;
    case Fault::kEio: middle.status = -EIO; break;
    case Fault::kStall:
    case Fault::kStallForever: stream.is_halted = true; break;
    case Fault::kSilent:
    case Fault::kSilentForever:
      stream.is_silent = true;
      payloads.clear();
      break;
    case Fault::kSkipped: payloads.clear(); break;
    case Fault::kSentTwice: payloads.insert(payloads.end(), payloads.begin(), payloads.end()); break;
    case Fault::kShortPayload: middle.bytes.resize(middle.bytes.size() - 1000); break;
    case Fault::kLongPayload: middle.bytes.resize(middle.bytes.size() + 100); break;
    case Fault::kRepeatedPayload: payloads.insert(payloads.begin() + middle_at, Payload(middle)); break;
    case Fault::kReordered: std::swap(payloads.end()[-1], payloads.end()[-2]); break;
    case Fault::kLostPacket: middle.status = -EXDEV; break;
    case Fault::kGarbledPacket: middle.status = -EILSEQ; break;
    case Fault::kClockBack: clock_offset_us_ -= 3'000'000; break;
    case Fault::kClockAhead: clock_offset_us_ += 5'000'000; break;
  }
  const bool is_for_ever = fault == Fault::kStallForever || fault == Fault::kSilentForever;
  if (is_for_ever) faults_of(stream)[stream.number + 1] = fault;
}

std::optional<Delivery> Vcam::fill_transfer(std::uint8_t endpoint, std::span<std::byte> buffer, std::int64_t now_ns) {
  if (control_faults.is_mute) return std::nullopt;
  Stream& stream = stream_of(endpoint);
  make_picture(stream, now_ns);
  if (stream.is_halted) return Delivery{-EPIPE, 0};
  if (stream.payloads.empty()) return std::nullopt;
  Payload& payload = stream.payloads.front();
  const std::size_t size = std::min(buffer.size(), payload.bytes.size() - stream.sent);
  std::memcpy(buffer.data(), payload.bytes.data() + stream.sent, size);
  stream.sent += size;
  const Delivery delivery{payload.status, size};
  const bool is_sent = stream.sent == payload.bytes.size() || payload.status != 0;
  if (is_sent) {
    stream.payloads.pop_front();
    stream.sent = 0;
  }
  return delivery;
}

void Vcam::nobody_asked(std::uint8_t endpoint, std::int64_t now_ns) {
  if (options_.waits_for_computer) return;
  Stream& stream = stream_of(endpoint);
  make_picture(stream, now_ns);
  const std::int64_t interval_ns = stream.interval_100ns * std::int64_t{100};
  if (stream.is_halted || !stream.is_active || stream.payloads.empty() || now_ns < stream.due_ns + interval_ns) return;
  stream.payloads.clear();  // it has room for one picture
  make_picture(stream, now_ns);
}

Delivery Vcam::fill_packet(std::uint8_t endpoint, std::span<std::byte> packet, std::int64_t now_ns) {
  if (control_faults.is_mute) return {0, 0};
  Stream& stream = stream_of(endpoint);
  make_picture(stream, now_ns);
  if (!stream.is_active) return {0, 0};
  if (stream.payloads.empty()) {
    const auto only_header = header(stream, false, false);
    std::memcpy(packet.data(), only_header.data(), only_header.size());
    return {0, only_header.size()};
  }
  const Payload payload = std::move(stream.payloads.front());
  stream.payloads.pop_front();
  if (payload.status != 0) return {payload.status, 0};
  const std::size_t size = std::min(packet.size(), payload.bytes.size());
  std::memcpy(packet.data(), payload.bytes.data(), size);
  return {0, size};
}

}  // namespace scanknit::test
