// VKinect: the camera of a first Kinect as a model: depth of one value everywhere, grey colour, both at 30 frames a
// second over isochronous endpoints. Written after libfreenect's source (protocol facts only).
#pragma once

#include <array>
#include <limits>
#include <map>
#include <string>
#include <utility>

#include "tests/usb/vcam/usb_model.h"

namespace scanknit::test {

struct VKinectOptions {
  std::string serial = "A00000000000000A";
  std::uint16_t product = 0x02ae;
  int raw_depth = 600;  ///< what the Kinect measures: disparities, 11 bits
};

class VKinect final : public UsbModel {
 public:
  explicit VKinect(VKinectOptions options = {}) : options_(std::move(options)) {}

  static constexpr std::uint8_t kColourEndpoint = 0x81, kDepthEndpoint = 0x82;
  static constexpr int kNever = std::numeric_limits<int>::max();

  [[nodiscard]] UsbIdentity identity() const override { return {0x045e, options_.product, options_.serial, 480}; }
  [[nodiscard]] std::vector<ModelEndpoint> endpoints() const override {
    return {{kColourEndpoint, true}, {kDepthEndpoint, true}};
  }
  [[nodiscard]] std::vector<std::byte> descriptors() const override;
  [[nodiscard]] std::optional<std::vector<std::byte>> control(std::uint8_t type, std::uint8_t request,
                                                              std::uint16_t value, std::uint16_t index,
                                                              std::uint16_t length, std::span<const std::byte> data,
                                                              std::int64_t now_ns) override;
  [[nodiscard]] bool ignores(std::uint8_t, std::uint16_t, std::uint16_t) const override { return is_mute; }
  void set_alternate(std::uint8_t, std::uint8_t, std::int64_t) override {}
  void clear_halt(std::uint8_t) override {}
  [[nodiscard]] std::optional<Delivery> fill_transfer(std::uint8_t, std::span<std::byte>, std::int64_t) override {
    return std::nullopt;
  }
  void nobody_asked(std::uint8_t, std::int64_t) override {}
  [[nodiscard]] Delivery fill_packet(std::uint8_t endpoint, std::span<std::byte> packet, std::int64_t now_ns) override;

  /// Depth pictures (counting from 0) of which one packet in the middle is lost.
  std::map<int, bool> loses_packet;
  int loses_packets_from = kNever;  ///< ... and all from this one on
  int depth_pictures = 0;
  /// From this depth picture on it sends nothing, until depth was started so often.
  int silent_from = kNever, silent_until_starts = kNever;
  int colour_silent_from = kNever;  ///< it sends no colour from this picture on, however often it is started
  int starts = 0;                   ///< of depth
  bool is_mute = false;             ///< no request is answered any more

 private:
  struct Stream {
    bool is_active = false;
    int flag = 0;                    ///< of its packets: 0x70 depth, 0x80 colour
    std::size_t packet_bytes = 0;    ///< without the header of twelve
    std::vector<std::byte> picture;  ///< as it is sent
    std::size_t sent = 0;
    std::uint8_t sequence = 0;
    std::int64_t due_ns = 0;
    int number = 0;
  };
  void set_register(int address, int value, std::int64_t now_ns);
  [[nodiscard]] Stream& stream_of(std::uint8_t endpoint) { return streams_[endpoint == kDepthEndpoint ? 0 : 1]; }

  VKinectOptions options_;
  std::array<Stream, 2> streams_;
  std::vector<std::byte> reply_;
};

}  // namespace scanknit::test
