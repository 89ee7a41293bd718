// EmulatedBus: plugs a UsbModel into this process' view of Linux through umockdev: sysfs, udev events, and a usbfs node
// that answers the ioctls of an unmodified libusb. The process must run under umockdev-wrapper.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "tests/usb/vcam/vcam.h"

namespace scanknit::test {

class EmulatedBus {
 public:
  EmulatedBus();
  ~EmulatedBus();  ///< cameras are unplugged
  EmulatedBus(const EmulatedBus&) = delete;
  EmulatedBus& operator=(const EmulatedBus&) = delete;

  /// Gives its address on bus 1.
  int plug_model(std::unique_ptr<UsbModel> model);
  int plug(const VcamOptions& options) { return plug_model(std::make_unique<Vcam>(options)); }
  void unplug(int address);

  /// Calls `change` with the device while nothing else touches it.
  void with_model(int address, const std::function<void(UsbModel&)>& change);
  void with_camera(int address, const std::function<void(Vcam&)>& change) {
    with_model(address, [&](UsbModel& model) { change(dynamic_cast<Vcam&>(model)); });
  }

  /// From now on, claims are answered as if another program had the interface.
  void refuse_claims(int address, bool is_refused);
  /// Only so many transfers are taken, as with the system's limit of USB memory.
  void limit_transfers(int address, int most);
  /// The process whose memory transfers go to; this one unless said.
  void serve(int address, pid_t client);
  /// How often the client asked for a finished transfer where there was none.
  [[nodiscard]] int idle_asks(int address);
  /// Transfers the client has handed over at the moment.
  [[nodiscard]] int waiting_transfers(int address);

  struct Device;

 private:
  struct Testbed;
  [[nodiscard]] Device& device(int address);
  std::unique_ptr<Testbed> testbed_;
};

}  // namespace scanknit::test
