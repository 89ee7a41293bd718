// The kernel's virtual host controller (vhci_hcd) is given one end of a socket and speaks usbip over it: what it would
// ask a device on a wire comes as CMD_SUBMIT, the model's answer goes back as RET_SUBMIT (Linux,
// Documentation/usb/usbip_protocol.rst). The numbers are big-endian, each header has 48 bytes.
#include "tests/usb/emulated/emulated_bus.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "tests/usb/usb_bytes.h"

namespace scanknit::test {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

const fs::path kController = "/sys/devices/platform/vhci_hcd.0";
const fs::path kUsbMemory = "/sys/module/usbcore/parameters/usbfs_memory_mb";
constexpr int kUsualMemoryMb = 16;
constexpr int kHighSpeed = 3, kSuperSpeed = 5;  // enum usb_device_speed
constexpr std::size_t kHeaderBytes = 48, kPacketBytes = 16;
constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitted = 3, kUnlinked = 4;
constexpr std::uint8_t kIn = 0x80;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / 1ns;
}

[[noreturn]] void give_up(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::abort();
}

/// True: it happened within five seconds.
template <typename Condition>
bool wait_until(const Condition& condition) {
  for (int i = 0; i < 500; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(10ms);
  }
  return condition();
}

/// 0: there is none, or it is not a number.
int number_in(const fs::path& file) {
  int number = 0;
  std::ifstream(file) >> number;
  return number;
}

bool write_line(const fs::path& file, const std::string& line) {
  std::ofstream stream(file);
  return static_cast<bool>(stream << line << std::flush);
}

struct Port {
  int number = 0;  // among all
  int on_hub = 0;  // from 1
};

/// The controller has a hub for USB 2 and one for USB 3.
std::optional<Port> free_port(bool is_fast) {
  constexpr int kFree = 4;
  std::ifstream file(kController / "status");
  std::string line, hub;
  std::getline(file, line);  // what the columns are
  Port port;
  int state = 0;
  while (file >> hub >> port.number >> state && std::getline(file, line)) {
    if ((hub == "ss") != is_fast) continue;
    ++port.on_hub;
    if (state == kFree) return port;
  }
  return std::nullopt;
}

/// A message of 32-bit numbers, as they go over the socket.
class Words {
 public:
  Words(std::initializer_list<std::int64_t> values) {
    for (const std::int64_t value : values) put(value);
  }
  void put(std::int64_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes_.push_back(static_cast<std::byte>((value >> shift) & 0xFF));
  }
  [[nodiscard]] std::vector<std::byte>& bytes() { return bytes_; }

 private:
  std::vector<std::byte> bytes_;
};

std::uint32_t word_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (const std::byte b : bytes.subspan(at, 4)) value = value << 8 | std::to_integer<std::uint32_t>(b);
  return value;
}

std::vector<std::byte> text_descriptor(const std::string& text) {
  Bytes letters;
  for (const char letter : text) letters.u16(static_cast<unsigned char>(letter));
  return descriptor(Bytes{3}.add(letters)).vector();
}

/// A transfer that the kernel has handed over.
struct Transfer {
  std::uint32_t number = 0;
  std::size_t bytes = 0;
  std::vector<std::size_t> packets;  // the sizes of isochronous ones
};

struct Setup {
  std::uint8_t type, request;
  std::uint16_t value, index, length;
};

}  // namespace

/// One plugged device, and the thread that answers for it.
struct EmulatedBus::Device {
  explicit Device(std::unique_ptr<UsbModel> plugged) : model(std::move(plugged)) {}
  ~Device() {
    refuse_claims(false);
    leave();
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  void attach();
  void leave();
  void refuse_claims(bool is_refused);
  void run(const std::stop_token& stop);
  [[nodiscard]] bool take_command();
  void take_submit(std::span<const std::byte> header, std::uint32_t number, std::uint8_t endpoint);
  void take_unlink(std::uint32_t number, std::uint32_t unwanted);
  void control(std::uint32_t number, const Setup& setup, std::span<const std::byte> data);
  [[nodiscard]] std::optional<std::vector<std::byte>> standard_request(const Setup& setup);
  [[nodiscard]] std::optional<std::vector<std::byte>> described(const Setup& setup) const;
  void feed_bulk(std::uint8_t endpoint);
  void feed_packets(std::uint8_t endpoint);
  void complete(std::uint32_t number, int status, std::size_t moved, std::span<const std::byte> data = {},
                std::span<const std::byte> packets = {});
  [[nodiscard]] bool receive(std::span<std::byte> bytes) const;
  void send(std::span<const std::byte> bytes) const;

  std::mutex mutex;  // of all that follows
  const std::unique_ptr<UsbModel> model;
  std::map<std::uint8_t, std::deque<Transfer>> waiting;
  std::map<std::uint8_t, std::int64_t> packet_time_ns;
  std::vector<std::byte> scratch;
  bool is_gone = false;
  int line = -1;    // our end of the socket
  int holder = -1;  // the node, where it is held as another program would
  int address = 0;
  fs::path sysfs;
  std::jthread pump;
};

void EmulatedBus::Device::attach() {
  const bool is_fast = model->identity().speed_mbit >= 5000;
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends.data()) != 0) give_up("no socket pair");
  line = ends[0];
  pump = std::jthread([this](const std::stop_token& stop) { run(stop); });
  std::optional<Port> port;
  const auto is_attached = [&] {
    port = free_port(is_fast);
    const int device_id = 0x10002;  // bus 1, device 2 of the computer it would come from
    return port && write_line(kController / "attach", std::to_string(port->number) + " " + std::to_string(ends[1]) +
                                                          " " + std::to_string(device_id) + " " +
                                                          std::to_string(is_fast ? kSuperSpeed : kHighSpeed));
  };
  if (!wait_until(is_attached)) give_up("vhci_hcd takes no device: is it loaded, and are we root?");
  close(ends[1]);  // the kernel has its own hold of it

  for (const auto& hub : fs::directory_iterator(kController)) {
    const std::string name = hub.path().filename().string();
    if (!name.starts_with("usb") || (number_in(hub.path() / "speed") >= 5000) != is_fast) continue;
    sysfs = hub.path() / (name.substr(3) + "-" + std::to_string(port->on_hub));
  }
  if (!wait_until([this] { return number_in(sysfs / "bConfigurationValue") > 0; })) {
    give_up(sysfs.string() + " was not set up; dmesg tells more");
  }
  address = number_in(sysfs / "devnum");
}

/// As a cable that is drawn: transfers fail first, then the hub notices. Closing the socket alone may hang Linux 6.1
/// for ever: vhci_hcd loses transfers that it has not sent yet when they are cancelled at that moment.
void EmulatedBus::Device::leave() {
  if (line < 0) return;
  {
    const std::lock_guard lock(mutex);
    is_gone = true;
  }
  if (!write_line(sysfs / "remove", "1") || !wait_until([this] { return !fs::exists(sysfs); })) {
    give_up(sysfs.string() + " does not leave");
  }
  shutdown(line, SHUT_RDWR);
  pump = {};
  close(std::exchange(line, -1));
  waiting.clear();
}

void EmulatedBus::Device::refuse_claims(bool is_refused) {
  if (holder >= 0) close(std::exchange(holder, -1));
  if (!is_refused) return;
  std::array<char, 64> node{};
  std::snprintf(node.data(), node.size(), "/dev/bus/usb/%03d/%03d", number_in(sysfs / "busnum"), address);
  holder = open(node.data(), O_RDWR | O_CLOEXEC);
  for (int interface = 0; interface < number_in(sysfs / "bNumInterfaces"); ++interface) {
    usbdevfs_disconnect_claim claim{};
    claim.interface = static_cast<unsigned>(interface);
    if (ioctl(holder, USBDEVFS_DISCONNECT_CLAIM, &claim) != 0) give_up(std::string("cannot claim ") + node.data());
  }
}

bool EmulatedBus::Device::receive(std::span<std::byte> bytes) const {
  return bytes.empty() || recv(line, bytes.data(), bytes.size(), MSG_WAITALL) == static_cast<ssize_t>(bytes.size());
}

/// A line that is down is noticed when the next command is awaited.
void EmulatedBus::Device::send(std::span<const std::byte> bytes) const {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(line, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent <= 0) return;
    bytes = bytes.subspan(static_cast<std::size_t>(sent));
  }
}

bool EmulatedBus::Device::take_command() {
  std::array<std::byte, kHeaderBytes> header{};
  if (!receive(header)) return false;
  const std::uint32_t number = word_at(header, 4);
  if (word_at(header, 0) == kUnlink) return take_unlink(number, word_at(header, 20)), true;
  if (word_at(header, 0) != kSubmit) give_up("what the kernel sends is not usbip");
  const bool is_in = word_at(header, 12) != 0;
  take_submit(header, number, static_cast<std::uint8_t>(word_at(header, 16) | (is_in ? kIn : 0)));
  return true;
}

void EmulatedBus::Device::take_submit(std::span<const std::byte> header, std::uint32_t number, std::uint8_t endpoint) {
  Transfer transfer{number, word_at(header, 24), {}};
  std::vector<std::byte> data((endpoint & kIn) != 0 ? 0 : transfer.bytes);
  (void)receive(data);
  if ((endpoint & ~kIn) == 0) {
    const auto u8 = [&](std::size_t i) { return std::to_integer<std::uint8_t>(header[40 + i]); };
    const auto u16 = [&](std::size_t i) { return static_cast<std::uint16_t>(u8(i) | u8(i + 1) << 8); };
    const bool is_ignored = model->ignores(u8(0), u16(2), u16(4));
    if (!is_ignored) return control(number, {u8(0), u8(1), u16(2), u16(4), u16(6)}, data);
    waiting[endpoint].push_back(std::move(transfer));  // until the client has had enough
    return;
  }
  const auto packets = static_cast<std::int32_t>(word_at(header, 32));
  for (int i = 0; i < packets; ++i) {
    std::array<std::byte, kPacketBytes> packet{};
    (void)receive(packet);
    transfer.packets.push_back(word_at(packet, 4));
  }
  waiting[endpoint].push_back(std::move(transfer));
}

void EmulatedBus::Device::take_unlink(std::uint32_t number, std::uint32_t unwanted) {
  std::size_t taken_back = 0;
  for (auto& [endpoint, queue] : waiting) {
    taken_back += std::erase_if(queue, [&](const Transfer& transfer) { return transfer.number == unwanted; });
  }
  Words answer{kUnlinked, number, 0, 0, 0, taken_back > 0 ? -ECONNRESET : 0};
  answer.bytes().resize(kHeaderBytes);
  send(answer.bytes());
}

void EmulatedBus::Device::control(std::uint32_t number, const Setup& setup, std::span<const std::byte> data) {
  const bool is_standard = (setup.type & 0x60) == 0;
  auto answer = is_standard
                    ? standard_request(setup)
                    : model->control(setup.type, setup.request, setup.value, setup.index, setup.length, data, now_ns());
  if (is_gone) return complete(number, -EPROTO, 0);
  if (!answer) return complete(number, -EPIPE, 0);
  if ((setup.type & kIn) == 0) return complete(number, 0, data.size());
  answer->resize(std::min<std::size_t>(answer->size(), setup.length));
  complete(number, 0, answer->size(), *answer);
}

/// What every device answers (USB 3.2, table 9-5).
std::optional<std::vector<std::byte>> EmulatedBus::Device::standard_request(const Setup& setup) {
  constexpr std::uint8_t kGetStatus = 0, kClearFeature = 1, kGetDescriptor = 6, kSetInterface = 11;
  constexpr std::uint8_t kOfEndpoint = 2;
  if (setup.request == kGetStatus) return std::vector<std::byte>(2);
  if (setup.request == kGetDescriptor) return described(setup);
  if (setup.request == kClearFeature && setup.type == kOfEndpoint) {
    model->clear_halt(static_cast<std::uint8_t>(setup.index));
  }
  if (setup.request == kSetInterface) {
    model->set_alternate(static_cast<std::uint8_t>(setup.index), static_cast<std::uint8_t>(setup.value), now_ns());
    packet_time_ns.clear();
  }
  return std::vector<std::byte>{};
}

std::optional<std::vector<std::byte>> EmulatedBus::Device::described(const Setup& setup) const {
  constexpr std::ptrdiff_t kDeviceBytes = 18;
  const auto all = model->descriptors();
  const int index = setup.value & 0xFF;
  switch (setup.value >> 8) {
    case 1: return std::vector(all.begin(), all.begin() + kDeviceBytes);
    case 2: return std::vector(all.begin() + kDeviceBytes, all.end());
    case 3:
      if (index == 0) return Bytes{4, 3, 0x09, 0x04}.vector();  // American English
      return text_descriptor(index == 3 ? model->identity().serial : "Emulated depth camera");
    default: return std::nullopt;
  }
}

/// Isochronous data is sent without the gaps between the packets.
void EmulatedBus::Device::complete(std::uint32_t number, int status, std::size_t moved, std::span<const std::byte> data,
                                   std::span<const std::byte> packets) {
  const std::size_t count = packets.size() / kPacketBytes;
  Words answer{
      kSubmitted, number, 0, 0, 0, status, static_cast<std::int64_t>(moved), 0, static_cast<std::int64_t>(count), 0};
  answer.bytes().resize(kHeaderBytes);
  send(answer.bytes());
  send(data);
  send(packets);
}

void EmulatedBus::Device::feed_bulk(std::uint8_t endpoint) {
  auto& queue = waiting[endpoint];
  if (queue.empty()) return model->nobody_asked(endpoint, now_ns());
  while (!queue.empty()) {
    const Transfer transfer = queue.front();
    scratch.resize(std::max(scratch.size(), transfer.bytes));
    const auto buffer = std::span(scratch).first(transfer.bytes);
    const auto delivery = is_gone ? Delivery{-EPROTO, 0} : model->fill_transfer(endpoint, buffer, now_ns());
    if (!delivery) return;
    queue.pop_front();
    complete(transfer.number, delivery->status, delivery->bytes, buffer.first(delivery->bytes));
  }
}

/// A transfer is done when all of its microframes of 125 us are over.
void EmulatedBus::Device::feed_packets(std::uint8_t endpoint) {
  constexpr std::int64_t kMicroframe = 125'000;
  auto& queue = waiting[endpoint];
  if (queue.empty()) return;
  auto& clock = packet_time_ns.try_emplace(endpoint, now_ns()).first->second;
  while (!queue.empty() && now_ns() >= clock + static_cast<std::int64_t>(queue.front().packets.size()) * kMicroframe) {
    const Transfer transfer = std::move(queue.front());
    queue.pop_front();
    scratch.resize(std::max(scratch.size(), transfer.bytes));
    std::size_t used = 0;
    std::int64_t offset = 0;
    Words packets{};
    for (const std::size_t size : transfer.packets) {
      const auto packet = std::span(scratch).subspan(used, size);
      const Delivery delivery = is_gone ? Delivery{-EPROTO, 0} : model->fill_packet(endpoint, packet, clock);
      for (const std::int64_t word : {offset, static_cast<std::int64_t>(size),
                                      static_cast<std::int64_t>(delivery.bytes), std::int64_t{delivery.status}}) {
        packets.put(word);
      }
      offset += static_cast<std::int64_t>(size);
      used += delivery.bytes;
      clock += kMicroframe;
    }
    complete(transfer.number, 0, used, std::span(scratch).first(used), packets.bytes());
  }
}

void EmulatedBus::Device::run(const std::stop_token& stop) {
  constexpr int kPatience_ms = 4;  // each awakening costs an emulated processor a quarter of a millisecond
  while (!stop.stop_requested()) {
    pollfd wanted{line, POLLIN, 0};
    (void)poll(&wanted, 1, kPatience_ms);
    const std::lock_guard lock(mutex);
    if (wanted.revents != 0 && !take_command()) return;
    for (const ModelEndpoint& endpoint : model->endpoints()) {
      if (endpoint.is_isochronous) {
        feed_packets(endpoint.address);
      } else {
        feed_bulk(endpoint.address);
      }
    }
  }
}

struct EmulatedBus::Testbed {
  std::map<int, std::unique_ptr<Device>> devices;
};

const double EmulatedBus::kBriskFps = 15;

EmulatedBus::EmulatedBus() : testbed_(std::make_unique<Testbed>()) {}

EmulatedBus::~EmulatedBus() {
  if (number_in(kUsbMemory) != kUsualMemoryMb) limit_memory(kUsualMemoryMb);
}

EmulatedBus::Device& EmulatedBus::device(int address) {
  return *testbed_->devices.at(address);
}

int EmulatedBus::plug_model(std::unique_ptr<UsbModel> model) {
  auto device = std::make_unique<Device>(std::move(model));
  device->attach();
  const int address = device->address;
  testbed_->devices[address] = std::move(device);
  return address;
}

void EmulatedBus::unplug(int address) {
  device(address).leave();
}

void EmulatedBus::with_model(int address, const std::function<void(UsbModel&)>& change) {
  const std::lock_guard lock(device(address).mutex);
  change(*device(address).model);
}

void EmulatedBus::refuse_claims(int address, bool is_refused) {
  device(address).refuse_claims(is_refused);
}

void EmulatedBus::limit_memory(int megabytes) {
  if (!write_line(kUsbMemory, std::to_string(megabytes))) give_up("cannot write " + kUsbMemory.string());
}

void EmulatedBus::serve(int /*address*/, pid_t /*client*/) {}

std::optional<int> EmulatedBus::idle_asks(int /*address*/) {
  return std::nullopt;
}

int EmulatedBus::waiting_transfers(int address) {
  const std::lock_guard lock(device(address).mutex);
  std::size_t sum = 0;
  for (const auto& [endpoint, queue] : device(address).waiting) sum += queue.size();
  return static_cast<int>(sum);
}

}  // namespace scanknit::test
