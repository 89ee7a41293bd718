// EmulatedBus: plugs a UsbModel into the computer, for an unmodified libusb to find. Two front ends:
// umockdev/emulated_bus.cpp makes this process' view of Linux (sysfs, udev events, a usbfs node that answers ioctls;
// the process must run under umockdev-wrapper), vhci/emulated_bus.cpp asks the kernel itself (as root, in a virtual
// machine).
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "tests/usb/vcam/vcam.h"

namespace scanknit::test {

class EmulatedBus {
 public:
  /// Frames a second of tests to which it does not matter: 90, or what a virtual machine has time for.
  static const double kBriskFps;

  EmulatedBus();
  ~EmulatedBus();  ///< cameras are unplugged
  EmulatedBus(const EmulatedBus&) = delete;
  EmulatedBus& operator=(const EmulatedBus&) = delete;

  /// Gives its address; the system has set it up by then.
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
  /// The system's limit of USB memory.
  void limit_memory(int megabytes);
  /// The process whose memory transfers go to; this one unless said. A kernel knows by itself.
  void serve(int address, pid_t client);
  /// How often the client asked for a finished transfer where there was none; not known of a kernel.
  [[nodiscard]] std::optional<int> idle_asks(int address);
  /// Transfers the client has handed over at the moment.
  [[nodiscard]] int waiting_transfers(int address);

  struct Device;

 private:
  struct Testbed;
  [[nodiscard]] Device& device(int address);
  std::unique_ptr<Testbed> testbed_;
};

}  // namespace scanknit::test
