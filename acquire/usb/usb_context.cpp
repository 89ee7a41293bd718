#include "acquire/usb/usb_context.h"

#include <libusb-1.0/libusb.h>
#include <pthread.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include "acquire/device_rules.h"
#include "acquire/usb/device_holders.h"
#include "acquire/usb/keep_for_ever.h"

namespace scanknit {
namespace {

namespace fs = std::filesystem;

void append(std::vector<std::byte>& bytes, const unsigned char* data, int size) {
  const auto part = std::as_bytes(std::span(data, data != nullptr && size > 0 ? static_cast<std::size_t>(size) : 0));
  bytes.insert(bytes.end(), part.begin(), part.end());
}

void append(std::vector<std::byte>& bytes, std::initializer_list<int> values) {
  for (const int value : values) bytes.push_back(static_cast<std::byte>(value & 0xFF));
}

/// Where descriptors are cut short, libusb counts what it has not got.
template <typename T>
std::span<const T> present(const T* first, int count) {
  return {first, first != nullptr && count > 0 ? static_cast<std::size_t>(count) : 0};
}

/// libusb hands the descriptors over in pieces; put together again they are parsed as one (uvc_descriptors.h).
std::vector<std::byte> joined(const libusb_config_descriptor& config) {
  std::vector<std::byte> bytes;
  append(bytes, {9, LIBUSB_DT_CONFIG, 0, 0, config.bNumInterfaces, config.bConfigurationValue, 0, config.bmAttributes,
                 config.MaxPower});
  append(bytes, config.extra, config.extra_length);
  for (const libusb_interface& interface : present(config.interface, config.bNumInterfaces)) {
    for (const libusb_interface_descriptor& d : present(interface.altsetting, interface.num_altsetting)) {
      append(bytes, {9, LIBUSB_DT_INTERFACE, d.bInterfaceNumber, d.bAlternateSetting, d.bNumEndpoints,
                     d.bInterfaceClass, d.bInterfaceSubClass, d.bInterfaceProtocol, d.iInterface});
      append(bytes, d.extra, d.extra_length);
      for (const libusb_endpoint_descriptor& e : present(d.endpoint, d.bNumEndpoints)) {
        append(bytes, {7, LIBUSB_DT_ENDPOINT, e.bEndpointAddress, e.bmAttributes, e.wMaxPacketSize & 0xFF,
                       e.wMaxPacketSize >> 8, e.bInterval});
        append(bytes, e.extra, e.extra_length);
      }
    }
  }
  return bytes;
}

int speed_of(libusb_device* device) {
  switch (libusb_get_device_speed(device)) {
    case LIBUSB_SPEED_LOW: return 2;
    case LIBUSB_SPEED_FULL: return 12;
    case LIBUSB_SPEED_HIGH: return 480;
    case LIBUSB_SPEED_SUPER: return 5000;
    case LIBUSB_SPEED_SUPER_PLUS: return 10000;
    default: return 0;
  }
}

std::string port_of(libusb_device* device) {
  std::array<std::uint8_t, 8> ports{};  // USB allows seven
  const int depth = libusb_get_port_numbers(device, ports.data(), static_cast<int>(ports.size()));
  std::string name = std::to_string(libusb_get_bus_number(device));
  for (int i = 0; i < depth; ++i) name += (i == 0 ? "-" : ".") + std::to_string(ports[static_cast<std::size_t>(i)]);
  return name;
}

std::string sysfs_line(const std::string& port, const char* attribute) {
  std::ifstream file(fs::path("/sys/bus/usb/devices") / port / attribute);
  std::string line;
  std::getline(file, line);
  constexpr std::size_t kMaxText = 126;  // what a string descriptor can hold
  line = line.substr(0, kMaxText);
  // A device's text may hold control characters, which would act on the user's terminal.
  constexpr char kFirstPrintable = 0x20, kDelete = 0x7F;
  std::ranges::replace_if(
      line, [](char c) { return (c >= 0 && c < kFirstPrintable) || c == kDelete; }, '?');
  return line;
}

UsbDeviceInfo describe(libusb_device* device) {
  UsbDeviceInfo info;
  info.bus = libusb_get_bus_number(device);
  info.address = libusb_get_device_address(device);
  info.speed_mbit = speed_of(device);
  libusb_device_descriptor descriptor{};
  if (libusb_get_device_descriptor(device, &descriptor) == 0) {
    info.vendor = descriptor.idVendor;
    info.product = descriptor.idProduct;
  }
  info.port = port_of(device);
  info.product_name = sysfs_line(info.port, "product");
  info.serial = sysfs_line(info.port, "serial");
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_active_config_descriptor(device, &config) == 0) {
    info.configuration = joined(*config);
    libusb_free_config_descriptor(config);
  }
  return info;
}

int on_hotplug(libusb_context* /*context*/, libusb_device* /*device*/, libusb_hotplug_event /*event*/, void* user) {
  static_cast<UsbContext*>(user)->device_came_or_went();
  return 0;
}

class DeviceList {
 public:
  explicit DeviceList(libusb_context* context) { count_ = libusb_get_device_list(context, &devices_); }
  ~DeviceList() {
    if (devices_ != nullptr) libusb_free_device_list(devices_, 1);
  }
  DeviceList(const DeviceList&) = delete;
  DeviceList& operator=(const DeviceList&) = delete;
  [[nodiscard]] std::span<libusb_device*> all() const {
    return {devices_, count_ > 0 ? static_cast<std::size_t>(count_) : 0};
  }

 private:
  libusb_device** devices_ = nullptr;
  ssize_t count_ = 0;
};

}  // namespace

std::string UsbDeviceInfo::place() const {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%04x:%04x at bus %d address %d", vendor, product, bus, address);
  return text.data();
}

std::string UsbDeviceInfo::node() const {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "/dev/bus/usb/%03d/%03d", bus, address);
  return text.data();
}

Result<std::shared_ptr<UsbContext>> UsbContext::create() {
  libusb_context* context = nullptr;
  if (const int code = libusb_init(&context); code != 0) {
    return Error{ErrorCode::kDevice, std::string("USB cannot be used: ") + libusb_strerror(code) +
                                         ". Is this a container without access to USB and udev?"};
  }
  return std::shared_ptr<UsbContext>(new UsbContext(context));
}

UsbContext::UsbContext(libusb_context* context) : context_(context) {
  const int events = LIBUSB_HOTPLUG_EVENT_DEVICE_ARRIVED | LIBUSB_HOTPLUG_EVENT_DEVICE_LEFT;
  if (libusb_has_capability(LIBUSB_CAP_HAS_HOTPLUG) != 0) {
    libusb_hotplug_register_callback(context_, events, 0, LIBUSB_HOTPLUG_MATCH_ANY, LIBUSB_HOTPLUG_MATCH_ANY,
                                     LIBUSB_HOTPLUG_MATCH_ANY, on_hotplug, this, &hotplug_);
  }
  events_ = std::jthread([context](const std::stop_token& stop) {
    pthread_setname_np(pthread_self(), "usb");
    while (!stop.stop_requested()) {
      timeval at_most{1, 0};
      libusb_handle_events_timeout_completed(context, &at_most, nullptr);
    }
  });
}

UsbContext::~UsbContext() {
  if (hotplug_ >= 0) libusb_hotplug_deregister_callback(context_, hotplug_);
  events_.request_stop();
  libusb_interrupt_event_handler(context_);
  events_.join();
  libusb_exit(context_);
}

std::vector<UsbDeviceInfo> UsbContext::devices() const {
  std::vector<UsbDeviceInfo> found;
  const DeviceList list(context_);
  for (libusb_device* device : list.all()) found.push_back(describe(device));
  std::sort(found.begin(), found.end(), [](const UsbDeviceInfo& a, const UsbDeviceInfo& b) {
    return std::pair(a.bus, a.address) < std::pair(b.bus, b.address);
  });
  return found;
}

Result<std::unique_ptr<UsbHandle>> UsbContext::open(const UsbDeviceInfo& wanted) {
  int code = LIBUSB_ERROR_NO_DEVICE;
  const DeviceList list(context_);
  for (libusb_device* device : list.all()) {
    if (libusb_get_bus_number(device) != wanted.bus || libusb_get_device_address(device) != wanted.address) continue;
    libusb_device_handle* handle = nullptr;
    code = libusb_open(device, &handle);
    if (code != 0) break;
    libusb_set_auto_detach_kernel_driver(handle, 1);
    return std::make_unique<UsbHandle>(shared_from_this(), handle, wanted);
  }
  return usb_error(code, "cannot open", wanted);
}

std::uint64_t UsbContext::generation() const {
  const std::lock_guard lock(mutex_);
  return generation_;
}

void UsbContext::wait_for_change(std::uint64_t seen, std::chrono::milliseconds timeout, std::stop_token stop) const {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, stop, timeout, [&] { return generation_ != seen; });
}

void UsbContext::device_came_or_went() {
  {
    const std::lock_guard lock(mutex_);
    ++generation_;
  }
  changed_.notify_all();
}

/// How long requests are waited for; they keep it alive when one of them has to be left behind.
struct UsbHandle::Patience {
  std::mutex mutex;
  std::condition_variable changed;
  bool is_hurried = false;
  bool is_over = false;  // a hurried request was not answered: no other is made in this hurry
};

/// libusb's own blocking requests cannot be cut short.
struct UsbHandle::Request {
  std::shared_ptr<Patience> patience;
  libusb_transfer* transfer = libusb_alloc_transfer(0);
  std::vector<unsigned char> buffer;
  bool is_done = false;

  ~Request() { libusb_free_transfer(transfer); }

  static void on_done(libusb_transfer* transfer) {
    auto* request = static_cast<Request*>(transfer->user_data);
    const std::lock_guard lock(request->patience->mutex);  // its owner may free it as soon as it is released
    request->is_done = true;
    request->patience->changed.notify_all();
  }
};

UsbHandle::UsbHandle(std::shared_ptr<UsbContext> context, libusb_device_handle* handle, UsbDeviceInfo info)
    : context_(std::move(context)), handle_(handle), info_(std::move(info)), patience_(std::make_shared<Patience>()) {}

UsbHandle::~UsbHandle() {
  // The kernel's driver, when it comes back, asks the device many things, and waits for each.
  if (is_mute_) libusb_set_auto_detach_kernel_driver(handle_, 0);
  // In reverse: the kernel's driver of a control interface wants its streaming interfaces, too, or does not come back.
  for (auto it = claimed_.rbegin(); it != claimed_.rend(); ++it) libusb_release_interface(handle_, *it);
  libusb_close(handle_);
}

Result<void> UsbHandle::claim(std::uint8_t interface) {
  if (std::find(claimed_.begin(), claimed_.end(), interface) != claimed_.end()) return {};
  const int code = libusb_claim_interface(handle_, interface);
  if (code != 0) return usb_error(code, "cannot use interface " + std::to_string(interface) + " of", info_);
  claimed_.push_back(interface);
  return {};
}

Result<void> UsbHandle::set_alternate(std::uint8_t interface, std::uint8_t alternate) {
  const int code = is_mute_ ? LIBUSB_ERROR_TIMEOUT : libusb_set_interface_alt_setting(handle_, interface, alternate);
  if (code != 0) return usb_error(code, "cannot reserve bandwidth for", info_);
  return {};
}

Result<void> UsbHandle::clear_halt(std::uint8_t endpoint) {
  const int code = is_mute_ ? LIBUSB_ERROR_TIMEOUT : libusb_clear_halt(handle_, endpoint);
  if (code != 0) return usb_error(code, "cannot restart", info_);
  return {};
}

void UsbHandle::hurry(bool is_hurried) {
  const std::lock_guard lock(patience_->mutex);
  patience_->is_over = false;
  patience_->is_hurried = is_hurried;
  patience_->changed.notify_all();
}

int UsbHandle::control(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                       std::span<std::byte> data) {
  const int code = send(type, request, value, index, data);
  is_mute_ = code == LIBUSB_ERROR_TIMEOUT;
  return code;
}

int UsbHandle::send(std::uint8_t type, std::uint8_t request, std::uint16_t value, std::uint16_t index,
                    std::span<std::byte> data) {
  constexpr std::chrono::milliseconds kLongestReturn{200};
  auto own = std::make_unique<Request>();
  if (own->transfer == nullptr) return LIBUSB_ERROR_NO_MEM;
  own->patience = patience_;
  own->buffer.resize(LIBUSB_CONTROL_SETUP_SIZE + data.size());
  libusb_fill_control_setup(own->buffer.data(), type, request, value, index, static_cast<std::uint16_t>(data.size()));
  const auto payload = std::as_writable_bytes(std::span(own->buffer)).subspan(LIBUSB_CONTROL_SETUP_SIZE);
  std::copy(data.begin(), data.end(), payload.begin());
  libusb_fill_control_transfer(own->transfer, handle_, own->buffer.data(), Request::on_done, own.get(), 0);

  std::unique_lock lock(patience_->mutex);
  if (patience_->is_over) return LIBUSB_ERROR_TIMEOUT;
  if (const int code = libusb_submit_transfer(own->transfer); code != 0) return code;
  std::condition_variable& changed = patience_->changed;
  const auto is_done = [&] { return own->is_done; };
  changed.wait_for(lock, kControlTimeout, [&] { return own->is_done || patience_->is_hurried; });
  if (patience_->is_hurried) changed.wait_for(lock, kHurriedTimeout, is_done);
  if (!own->is_done) {
    patience_->is_over = patience_->is_hurried;
    libusb_cancel_transfer(own->transfer);
    if (!changed.wait_for(lock, kLongestReturn, is_done)) {
      keep_for_ever(std::move(own));  // the system may still write into it
      return LIBUSB_ERROR_TIMEOUT;
    }
  }
  const libusb_transfer& transfer = *own->transfer;
  switch (transfer.status) {
    case LIBUSB_TRANSFER_COMPLETED: break;
    case LIBUSB_TRANSFER_STALL: return LIBUSB_ERROR_PIPE;
    case LIBUSB_TRANSFER_NO_DEVICE: return LIBUSB_ERROR_NO_DEVICE;
    case LIBUSB_TRANSFER_OVERFLOW: return LIBUSB_ERROR_OVERFLOW;
    case LIBUSB_TRANSFER_CANCELLED:
    case LIBUSB_TRANSFER_TIMED_OUT: return LIBUSB_ERROR_TIMEOUT;
    default: return LIBUSB_ERROR_IO;
  }
  const auto size = std::min(data.size(), static_cast<std::size_t>(std::max(0, transfer.actual_length)));
  std::copy_n(payload.begin(), size, data.begin());
  return static_cast<int>(size);
}

Result<void> UsbHandle::write_class(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                    std::span<const std::byte> data) {
  constexpr std::uint8_t kToInterface = 0x21;  // class request
  std::vector<std::byte> bytes(data.begin(), data.end());
  const int code = control(kToInterface, request, value, index, bytes);
  if (code < 0) return usb_error(code, "a request was not answered by", info_);
  return {};
}

Result<std::vector<std::byte>> UsbHandle::read_class(std::uint8_t request, std::uint16_t value, std::uint16_t index,
                                                     std::uint16_t bytes) {
  constexpr std::uint8_t kFromInterface = 0xA1;  // class request
  std::vector<std::byte> data(bytes);
  const int code = control(kFromInterface, request, value, index, data);
  if (code < 0) return usb_error(code, "a request was not answered by", info_);
  data.resize(static_cast<std::size_t>(code));
  return data;
}

namespace {

constexpr const char* kUnplugged = "it was unplugged";

std::string remedy_of(int code, const UsbDeviceInfo& device) {
  switch (code) {
    case LIBUSB_ERROR_ACCESS:
      return "permission denied. Install the device rules (" + rules_command(device.vendor, device.product) +
             ") and re-plug the camera";
    case LIBUSB_ERROR_BUSY: {
      const std::string holders = describe_holders(find_holders(device_nodes(device.node(), device.port)));
      return "it is in use" + (holders.empty() ? "" : " by " + holders) + ". Close that program and try again";
    }
    case LIBUSB_ERROR_NO_DEVICE: return kUnplugged;
    case LIBUSB_ERROR_NO_MEM:
      return "the system's limit for USB memory is reached. Raise it: echo 128 | sudo tee "
             "/sys/module/usbcore/parameters/usbfs_memory_mb";
    case LIBUSB_ERROR_PIPE: return "the camera refused it. Re-plug the camera";
    case LIBUSB_ERROR_TIMEOUT: return "no answer in time. Re-plug the camera";
    case LIBUSB_ERROR_INVALID_PARAM:
    case LIBUSB_ERROR_NOT_FOUND:
      return "the system did not configure the device, or it has no such part; its port may give too little power. "
             "Plug it into the computer itself or into a powered hub";
    case LIBUSB_ERROR_IO: return "input/output error. Check the cable, then re-plug the camera";
    default: return libusb_strerror(code);
  }
}

}  // namespace

Error usb_error(int libusb_code, const std::string& action, const UsbDeviceInfo& device) {
  return {ErrorCode::kDevice, action + " " + device.place() + ": " + remedy_of(libusb_code, device)};
}

Result<void> refuse_if_used(const UsbDeviceInfo& device) {
  const auto holders = find_holders(device_nodes(device.node(), device.port));
  if (holders.empty()) return {};
  return Error{ErrorCode::kDevice, device.place() + " is in use by " + describe_holders(holders) +
                                       ". Close that program, or take the camera from it by force"};
}

bool is_unplugged(const Error& error) {
  return error.code == ErrorCode::kDevice && error.message.ends_with(kUnplugged);
}

}  // namespace scanknit
