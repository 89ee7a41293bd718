// USB devices and the one thread on which their transfers end.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "core/result.h"

struct libusb_context;
struct libusb_device_handle;

namespace scanknit {

/// A device as it is known without opening it: no permission is needed for any of this.
struct UsbDeviceInfo {
  int bus = 0;
  int address = 0;
  std::uint16_t vendor = 0;
  std::uint16_t product = 0;
  int speed_mbit = 0;                    ///< 12, 480, 5000 ...; 0: unknown
  std::string port;                      ///< as Linux names it, "2-1.4"
  std::string product_name;              ///< empty: unknown
  std::string serial;                    ///< empty: none
  std::vector<std::byte> configuration;  ///< the active configuration descriptor and all that belong to it

  /// "8086:0b07 at bus 2 address 4".
  [[nodiscard]] std::string place() const;
  /// /dev/bus/usb/002/004.
  [[nodiscard]] std::string node() const;
};

class UsbHandle;

/// Runs the thread `usb` while it lives. All methods from any thread.
class UsbContext : public std::enable_shared_from_this<UsbContext> {
 public:
  /// Error (kDevice): USB cannot be used, and why.
  [[nodiscard]] static Result<std::shared_ptr<UsbContext>> create();
  ~UsbContext();
  UsbContext(const UsbContext&) = delete;
  UsbContext& operator=(const UsbContext&) = delete;

  [[nodiscard]] std::vector<UsbDeviceInfo> devices() const;

  /// Errors (kDevice): forbidden, unplugged ..., with what to do.
  [[nodiscard]] Result<std::unique_ptr<UsbHandle>> open(const UsbDeviceInfo& device);

  /// A number that changes whenever a device is plugged in or out.
  [[nodiscard]] std::uint64_t generation() const;
  /// Waits until generation() is not `seen` any more, until `timeout`, or until a stop.
  void wait_for_change(std::uint64_t seen, std::chrono::milliseconds timeout, std::stop_token stop) const;

  void device_came_or_went();  ///< for libusb's callback

 private:
  explicit UsbContext(libusb_context* context);

  libusb_context* context_;
  int hotplug_ = -1;  // no handle: changes are found by looking
  mutable std::mutex mutex_;
  mutable std::condition_variable_any changed_;
  std::uint64_t generation_ = 0;
  std::jthread events_;
};

/// An opened device. Every request ends within kControlTimeout. One thread, other than `usb`, except hurry().
class UsbHandle {
 public:
  static constexpr std::chrono::milliseconds kControlTimeout{1000};
  static constexpr std::chrono::milliseconds kHurriedTimeout{150};

  UsbHandle(std::shared_ptr<UsbContext> context, libusb_device_handle* handle, UsbDeviceInfo info);
  ~UsbHandle();  ///< releases what was claimed; transfers must have ended
  UsbHandle(const UsbHandle&) = delete;
  UsbHandle& operator=(const UsbHandle&) = delete;

  [[nodiscard]] const UsbDeviceInfo& info() const { return info_; }
  [[nodiscard]] libusb_device_handle* raw() const { return handle_; }

  /// The kernel's driver is put aside and comes back on release. Errors (kDevice): held by another program (named where
  /// it can be found), unplugged ...
  [[nodiscard]] Result<void> claim(std::uint8_t interface);
  /// These two are the system's to ask of the device, and it would wait for five seconds: a device that does not answer
  /// is not asked.
  [[nodiscard]] Result<void> set_alternate(std::uint8_t interface, std::uint8_t alternate);
  [[nodiscard]] Result<void> clear_halt(std::uint8_t endpoint);

  /// Class requests to an interface: `value` and `index` as USB has them. Errors (kDevice): refused, no answer,
  /// unplugged.
  [[nodiscard]] Result<void> write_class(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                         std::span<const std::byte> data);
  /// What came, at most `bytes`.
  [[nodiscard]] Result<std::vector<std::byte>> read_class(std::uint8_t request, std::uint16_t value,
                                                          std::uint16_t index, std::uint16_t bytes);

  /// True: from now on requests end within kHurriedTimeout, the one under way too, since somebody waits for us to stop.
  /// Any thread.
  void hurry(bool is_hurried);

 private:
  struct Patience;
  struct Request;
  /// As libusb_control_transfer(): the bytes that came or went, or an error of libusb's.
  [[nodiscard]] int control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                            std::span<std::byte> data);
  /// False: it is asked how it is, and says nothing.
  [[nodiscard]] bool answers();

  std::shared_ptr<UsbContext> context_;
  libusb_device_handle* handle_;
  UsbDeviceInfo info_;
  std::vector<std::uint8_t> claimed_;
  std::shared_ptr<Patience> patience_;
};

/// The last error of libusb's numbering in words, with the remedy: "cannot open 8086:0b07 at bus 2 address 4: ...".
[[nodiscard]] Error usb_error(int libusb_code, const std::string& action, const UsbDeviceInfo& device);

/// Error (kDevice): another program has the device, or a video node of it, open; it is named, as far as we may see.
[[nodiscard]] Result<void> refuse_if_used(const UsbDeviceInfo& device);

/// True for the error that usb_error() makes of an unplugged device.
[[nodiscard]] bool is_unplugged(const Error& error);

}  // namespace scanknit
