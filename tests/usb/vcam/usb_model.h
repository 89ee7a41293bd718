// UsbModel: a USB device as a model, without any input or output: what its bus asks of it.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace scanknit::test {

/// What an endpoint does with one transfer or packet.
struct Delivery {
  int status = 0;  ///< 0 or a negative errno as Linux's USB core reports it
  std::size_t bytes = 0;
};

/// How the system names the device.
struct UsbIdentity {
  std::uint16_t vendor = 0, product = 0;
  std::string serial;
  int speed_mbit = 480;
};

struct ModelEndpoint {
  std::uint8_t address = 0;
  bool is_isochronous = false;
};

/// Not thread-safe.
class UsbModel {
 public:
  virtual ~UsbModel() = default;

  [[nodiscard]] virtual UsbIdentity identity() const = 0;
  [[nodiscard]] virtual std::vector<ModelEndpoint> endpoints() const = 0;
  /// The device descriptor and the configuration descriptor.
  [[nodiscard]] virtual std::vector<std::byte> descriptors() const = 0;

  /// What a control request gives (empty for writes), or nothing: a stall.
  [[nodiscard]] virtual std::optional<std::vector<std::byte>> control(std::uint8_t type, std::uint8_t request,
                                                                      std::uint16_t value, std::uint16_t index,
                                                                      std::uint16_t length,
                                                                      std::span<const std::byte> data,
                                                                      std::int64_t now_ns) = 0;
  /// True: the device does not answer this request at all, neither with data nor with a stall.
  [[nodiscard]] virtual bool ignores(std::uint8_t /*type*/, std::uint16_t /*value*/, std::uint16_t /*index*/) const {
    return false;
  }
  virtual void set_alternate(std::uint8_t interface, std::uint8_t alternate, std::int64_t now_ns) = 0;
  virtual void clear_halt(std::uint8_t endpoint) = 0;

  /// Fills one bulk transfer; nothing: the device has nothing to send yet.
  [[nodiscard]] virtual std::optional<Delivery> fill_transfer(std::uint8_t endpoint, std::span<std::byte> buffer,
                                                              std::int64_t now_ns) = 0;
  /// Nobody asked for data although the device has some: what it cannot keep is lost.
  virtual void nobody_asked(std::uint8_t endpoint, std::int64_t now_ns) = 0;
  /// Fills one isochronous packet.
  [[nodiscard]] virtual Delivery fill_packet(std::uint8_t endpoint, std::span<std::byte> packet,
                                             std::int64_t now_ns) = 0;
};

}  // namespace scanknit::test
