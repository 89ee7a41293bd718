// Descriptors that lie. A kernel would not let most of these cameras in: here libusb and the driver see them all.
#include "tests/usb/emulated/live_camera.h"

namespace {
bool has_lied_to_libusb = false;
}
/// The leak sanitizer asks at the end of the process, which ctest starts for one test: libusb 1.0.26 does not free what
/// it has read of a configuration that it then refuses.
extern "C" int __lsan_is_turned_off() {
  return has_lied_to_libusb ? 1 : 0;
}

namespace scanknit::test {
namespace {

/// A camera whose descriptors are not what they should be.
class HostileCamera final : public UsbModel {
 public:
  explicit HostileCamera(std::vector<std::byte> descriptors) : descriptors_(std::move(descriptors)) {}
  [[nodiscard]] UsbIdentity identity() const override { return camera_.identity(); }
  [[nodiscard]] std::vector<ModelEndpoint> endpoints() const override { return camera_.endpoints(); }
  [[nodiscard]] std::vector<std::byte> descriptors() const override { return descriptors_; }
  [[nodiscard]] std::optional<std::vector<std::byte>> control(std::uint8_t type, std::uint8_t request,
                                                              std::uint16_t value, std::uint16_t index,
                                                              std::uint16_t length, std::span<const std::byte> data,
                                                              std::int64_t now_ns) override {
    return camera_.control(type, request, value, index, length, data, now_ns);
  }
  void set_alternate(std::uint8_t interface, std::uint8_t alternate, std::int64_t now_ns) override {
    camera_.set_alternate(interface, alternate, now_ns);
  }
  void clear_halt(std::uint8_t endpoint) override { camera_.clear_halt(endpoint); }
  [[nodiscard]] std::optional<Delivery> fill_transfer(std::uint8_t endpoint, std::span<std::byte> buffer,
                                                      std::int64_t now_ns) override {
    return camera_.fill_transfer(endpoint, buffer, now_ns);
  }
  void nobody_asked(std::uint8_t endpoint, std::int64_t now_ns) override { camera_.nobody_asked(endpoint, now_ns); }
  [[nodiscard]] Delivery fill_packet(std::uint8_t endpoint, std::span<std::byte> packet, std::int64_t now_ns) override {
    return camera_.fill_packet(endpoint, packet, now_ns);
  }

 private:
  Vcam camera_{VcamOptions{}};
  const std::vector<std::byte> descriptors_;
};

/// Every 13th byte of the configuration is spoilt in turn: it streams all the same, or an error says why not.
TEST(PluggedCamera, WithHostileDescriptorsStreamsOrSaysWhyNot) {
  has_lied_to_libusb = true;
  const std::vector<std::byte> good = Vcam(VcamOptions{}).descriptors();
  constexpr std::size_t kConfiguration = 18 + 9;  // after the device's and the configuration's own
  for (std::size_t at = kConfiguration; at < good.size(); at += 13) {
    for (const std::byte value : {std::byte{0}, std::byte{0xFF}}) {
      auto bad = good;
      bad[at] = value;
      EmulatedBus bus;
      FrameLog log;
      bus.plug_model(std::make_unique<HostileCamera>(std::move(bad)));
      const auto source = open_first();
      if (!source) {
        EXPECT_FALSE(source.error().message.empty()) << at;
        continue;
      }
      const auto streams = choose_streams((*source)->profiles(), 640, 480, EmulatedBus::kBriskFps);
      if (streams.empty()) continue;
      const auto started = (*source)->start(
          streams, [](const RawFrame&) {}, log.event_sink());
      EXPECT_TRUE(started || !started.error().message.empty()) << at;
      (*source)->stop();
    }
  }
}

}  // namespace
}  // namespace scanknit::test
