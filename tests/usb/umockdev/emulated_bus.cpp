#include "tests/usb/emulated/emulated_bus.h"

#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <pty.h>
#include <sys/uio.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <deque>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace scanknit::test {
namespace {

using Address = std::uintptr_t;

std::int64_t now_ns() {
  return std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
}

/// Reads and writes the client's memory; works for this process itself, too.
class ClientMemory {
 public:
  explicit ClientMemory(pid_t process) : process_(process) {}
  bool read(Address from, void* to, std::size_t bytes) const {
    const iovec local{to, bytes}, remote{pointer(from), bytes};
    return process_vm_readv(process_, &local, 1, &remote, 1, 0) == static_cast<ssize_t>(bytes);
  }
  bool write(Address to, const void* from, std::size_t bytes) const {
    const iovec local{const_cast<void*>(from), bytes}, remote{pointer(to), bytes};
    return bytes == 0 || process_vm_writev(process_, &local, 1, &remote, 1, 0) == static_cast<ssize_t>(bytes);
  }
  template <typename T>
  [[nodiscard]] T get(Address from) const {
    T value{};
    (void)read(from, &value, sizeof(value));
    return value;
  }
  template <typename T>
  void put(Address to, const T& value) const {
    (void)write(to, &value, sizeof(value));
  }

 private:
  static void* pointer(Address address) { return reinterpret_cast<void*>(address); }
  pid_t process_;
};

/// A transfer that the client has handed over.
struct Urb {
  Address at = 0;
  usbdevfs_urb head{};
};

struct Answer {
  long result = 0;
  int error = 0;
};

}  // namespace

/// One plugged device: its node is a pseudo terminal, because that can be polled as usbfs can: stopped output is
/// "nothing to reap", a closed master is "disconnected".
struct EmulatedBus::Device {
  explicit Device(std::unique_ptr<UsbModel> plugged) : model(std::move(plugged)) {
    char name[128];
    if (openpty(&master, &slave, name, nullptr, nullptr) != 0) std::abort();
    node = name;
    tcflow(slave, TCOOFF);
  }
  ~Device() {
    pump.request_stop();
    if (pump.joinable()) pump.join();
    if (master >= 0) close(master);
    close(slave);
  }
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  Answer handle(unsigned long request, Address argument);
  Answer submit(Address at);
  Answer reap(Address result);
  Answer discard(Address at);
  void control(Urb urb);
  void complete(const Urb& urb, int status, std::size_t bytes);
  void run(const std::stop_token& stop);
  void feed_bulk(std::uint8_t endpoint);
  void feed_packets(std::uint8_t endpoint);
  void drop_all(int status);

  std::mutex mutex;  // of all that follows: umockdev calls on its own thread
  const std::unique_ptr<UsbModel> model;
  ClientMemory memory{getpid()};
  std::map<std::uint8_t, std::deque<Urb>> waiting;
  std::deque<Address> done;
  std::map<std::uint8_t, std::int64_t> packet_time_ns;
  std::vector<std::byte> scratch;
  bool is_unplugged = false, is_claim_refused = false;
  std::size_t held_bytes = 0, most_bytes = 16u << 20;  // of the transfers that were not reaped, as Linux has it
  int idle_asks = 0;
  int master = -1, slave = -1;
  std::string node, syspath;
  UMockdevIoctlBase* handler = nullptr;
  std::jthread pump;
};

Answer EmulatedBus::Device::handle(unsigned long request, Address argument) {
  const std::lock_guard lock(mutex);
  if (request == USBDEVFS_REAPURB || request == USBDEVFS_REAPURBNDELAY) return reap(argument);
  if (is_unplugged) return {-1, ENODEV};
  switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
      memory.put<std::uint32_t>(argument, USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                                              USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_BULK_SCATTER_GATHER |
                                              USBDEVFS_CAP_REAP_AFTER_DISCONNECT);
      return {};
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM: return is_claim_refused ? Answer{-1, EBUSY} : Answer{};
    case USBDEVFS_GETDRIVER: return {-1, ENODATA};
    case USBDEVFS_SETINTERFACE: {
      const auto wanted = memory.get<usbdevfs_setinterface>(argument);
      model->set_alternate(static_cast<std::uint8_t>(wanted.interface), static_cast<std::uint8_t>(wanted.altsetting),
                           now_ns());
      packet_time_ns.clear();
      return {};
    }
    case USBDEVFS_CLEAR_HALT: model->clear_halt(static_cast<std::uint8_t>(memory.get<unsigned>(argument))); return {};
    case USBDEVFS_SUBMITURB: return submit(argument);
    case USBDEVFS_DISCARDURB: return discard(argument);
    case USBDEVFS_GET_SPEED: return {model->identity().speed_mbit >= 5000 ? 5 : 3, 0};
    case USBDEVFS_RELEASEINTERFACE:
    case USBDEVFS_RESET:
    case USBDEVFS_SETCONFIGURATION:
    case USBDEVFS_IOCTL: return {};
    default: return {-1, ENOTTY};
  }
}

Answer EmulatedBus::Device::submit(Address at) {
  const Urb urb{at, memory.get<usbdevfs_urb>(at)};
  const auto bytes = static_cast<std::size_t>(urb.head.buffer_length);
  if (held_bytes + bytes > most_bytes) return {-1, ENOMEM};
  held_bytes += bytes;
  if (urb.head.type == USBDEVFS_URB_TYPE_CONTROL) return control(urb), Answer{};
  waiting[urb.head.endpoint].push_back(urb);
  return {};
}

void EmulatedBus::Device::control(Urb urb) {
  std::vector<std::byte> bytes(static_cast<std::size_t>(urb.head.buffer_length));
  const auto buffer = reinterpret_cast<Address>(urb.head.buffer);
  (void)memory.read(buffer, bytes.data(), bytes.size());
  const auto u8 = [&](std::size_t i) { return std::to_integer<unsigned>(bytes[i]); };
  const auto u16 = [&](std::size_t i) { return static_cast<std::uint16_t>(u8(i) | u8(i + 1) << 8); };
  if (model->ignores(static_cast<std::uint8_t>(u8(0)), u16(2), u16(4))) {
    waiting[urb.head.endpoint].push_back(urb);  // until the client has had enough
    return;
  }
  const bool is_in = (u8(0) & 0x80) != 0;
  const auto data = std::span<const std::byte>(bytes).subspan(8);
  const auto answer = model->control(static_cast<std::uint8_t>(u8(0)), static_cast<std::uint8_t>(u8(1)), u16(2), u16(4),
                                     u16(6), is_in ? std::span<const std::byte>{} : data, now_ns());
  if (!answer) return complete(urb, -EPIPE, 0);
  const std::size_t size = std::min(answer->size(), data.size());
  (void)memory.write(buffer + 8, answer->data(), size);
  complete(urb, 0, is_in ? size : data.size());
}

void EmulatedBus::Device::complete(const Urb& urb, int status, std::size_t bytes) {
  memory.put<int>(urb.at + offsetof(usbdevfs_urb, status), status);
  memory.put<int>(urb.at + offsetof(usbdevfs_urb, actual_length), static_cast<int>(bytes));
  done.push_back(urb.at);
  if (done.size() == 1 && !is_unplugged) tcflow(slave, TCOON);
}

Answer EmulatedBus::Device::reap(Address result) {
  if (done.empty()) {
    ++idle_asks;
    return {-1, is_unplugged ? ENODEV : EAGAIN};
  }
  held_bytes -= static_cast<std::size_t>(memory.get<usbdevfs_urb>(done.front()).buffer_length);
  memory.put<Address>(result, done.front());
  done.pop_front();
  if (done.empty() && !is_unplugged) tcflow(slave, TCOOFF);
  return {};
}

Answer EmulatedBus::Device::discard(Address at) {
  for (auto& [endpoint, queue] : waiting) {
    for (auto urb = queue.begin(); urb != queue.end(); ++urb) {
      if (urb->at != at) continue;
      const Urb found = *urb;
      queue.erase(urb);
      complete(found, -ENOENT, 0);
      return {};
    }
  }
  return {-1, EINVAL};
}

void EmulatedBus::Device::drop_all(int status) {
  for (auto& [endpoint, queue] : waiting) {
    for (const Urb& urb : queue) complete(urb, status, 0);
    queue.clear();
  }
}

void EmulatedBus::Device::feed_bulk(std::uint8_t endpoint) {
  auto& queue = waiting[endpoint];
  if (queue.empty()) return model->nobody_asked(endpoint, now_ns());
  while (!queue.empty()) {
    const Urb urb = queue.front();
    scratch.resize(std::max(scratch.size(), static_cast<std::size_t>(urb.head.buffer_length)));
    const auto buffer = std::span(scratch).first(static_cast<std::size_t>(urb.head.buffer_length));
    const auto delivery = model->fill_transfer(endpoint, buffer, now_ns());
    if (!delivery) return;
    queue.pop_front();
    (void)memory.write(reinterpret_cast<Address>(urb.head.buffer), buffer.data(), delivery->bytes);
    complete(urb, delivery->status, delivery->bytes);
  }
}

/// A transfer is done when all of its microframes of 125 us are over.
void EmulatedBus::Device::feed_packets(std::uint8_t endpoint) {
  constexpr std::int64_t kMicroframe = 125'000;
  auto& queue = waiting[endpoint];
  if (queue.empty()) return;
  auto [clock, is_new] = packet_time_ns.try_emplace(endpoint, now_ns());
  while (!queue.empty() && now_ns() >= clock->second + queue.front().head.number_of_packets * kMicroframe) {
    const Urb urb = queue.front();
    queue.pop_front();
    const auto buffer = reinterpret_cast<Address>(urb.head.buffer);
    std::size_t offset = 0;
    for (int i = 0; i < urb.head.number_of_packets; ++i) {
      const Address at = urb.at + sizeof(usbdevfs_urb) + static_cast<Address>(i) * sizeof(usbdevfs_iso_packet_desc);
      auto packet = memory.get<usbdevfs_iso_packet_desc>(at);
      std::vector<std::byte> bytes(packet.length);
      const Delivery delivery = model->fill_packet(endpoint, bytes, clock->second);
      (void)memory.write(buffer + offset, bytes.data(), delivery.bytes);
      offset += packet.length;
      packet.actual_length = static_cast<unsigned>(delivery.bytes);
      packet.status = static_cast<unsigned>(delivery.status);
      memory.put(at, packet);
      clock->second += kMicroframe;
    }
    complete(urb, 0, 0);
  }
}

void EmulatedBus::Device::run(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    {
      const std::lock_guard lock(mutex);
      if (is_unplugged) return;
      for (const ModelEndpoint& endpoint : model->endpoints()) {
        if (endpoint.is_isochronous) {
          feed_packets(endpoint.address);
        } else {
          feed_bulk(endpoint.address);
        }
      }
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

namespace {

gboolean on_ioctl(UMockdevIoctlBase* /*handler*/, UMockdevIoctlClient* client, gpointer user) {
  UMockdevIoctlData* argument = umockdev_ioctl_client_get_arg(client);
  Address address = 0;
  __builtin_memcpy(&address, argument->data, sizeof(address));
  auto& device = *static_cast<EmulatedBus::Device*>(user);
  const Answer answer = device.handle(umockdev_ioctl_client_get_request(client), address);
  umockdev_ioctl_client_complete(client, answer.result, answer.error);
  return TRUE;
}

void on_vanished(UMockdevIoctlBase* /*handler*/, UMockdevIoctlClient* /*client*/, gpointer user) {
  auto& device = *static_cast<EmulatedBus::Device*>(user);
  const std::lock_guard lock(device.mutex);
  device.waiting.clear();
  device.done.clear();
  device.held_bytes = 0;
  if (!device.is_unplugged) tcflow(device.slave, TCOOFF);
}

}  // namespace

struct EmulatedBus::Testbed {
  UMockdevTestbed* testbed = umockdev_testbed_new();
  std::map<int, std::unique_ptr<Device>> devices;
  int next_address = 2;
};

const double EmulatedBus::kBriskFps = 90;

EmulatedBus::EmulatedBus() : testbed_(std::make_unique<Testbed>()) {
  if (umockdev_in_mock_environment() == 0) {
    std::fputs("not under umockdev-wrapper\n", stderr);
    std::abort();
  }
}

EmulatedBus::~EmulatedBus() {
  for (const auto& [address, each] : testbed_->devices) {
    unplug(address);
    umockdev_testbed_detach_ioctl(testbed_->testbed, ("/dev/bus/usb/001/" + each->node).c_str(), nullptr);
    g_object_unref(each->handler);
  }
  g_object_unref(testbed_->testbed);
}

EmulatedBus::Device& EmulatedBus::device(int address) {
  return *testbed_->devices.at(address);
}

int EmulatedBus::plug_model(std::unique_ptr<UsbModel> model) {
  const UsbIdentity identity = model->identity();
  const int address = testbed_->next_address++;
  auto& device = *(testbed_->devices[address] = std::make_unique<Device>(std::move(model)));
  char node[64];
  std::snprintf(node, sizeof(node), "/dev/bus/usb/001/%03d", address);

  char* root = umockdev_testbed_get_root_dir(testbed_->testbed);
  const std::filesystem::path link = std::string(root) + node;
  g_free(root);
  std::filesystem::create_directories(link.parent_path());
  std::filesystem::create_symlink(device.node, link);

  device.handler = umockdev_ioctl_base_new();
  g_signal_connect(device.handler, "handle-ioctl", G_CALLBACK(on_ioctl), &device);
  g_signal_connect(device.handler, "client-vanished", G_CALLBACK(on_vanished), &device);
  GError* error = nullptr;
  if (umockdev_testbed_attach_ioctl(testbed_->testbed, node, device.handler, &error) == 0) {
    std::fprintf(stderr, "%s\n", error->message);
    std::abort();
  }
  device.node = node;
  device.node = device.node.substr(device.node.rfind('/') + 1);

  const std::string number = std::to_string(address), speed = std::to_string(identity.speed_mbit);
  char vendor[8], product[8];
  std::snprintf(vendor, sizeof(vendor), "%04x", identity.vendor);
  std::snprintf(product, sizeof(product), "%04x", identity.product);
  // Address 2 is on port 1, and so on.
  const std::string name = "1-" + std::to_string(address - 1);
  const char* attributes[] = {"busnum",
                              "1",
                              "devnum",
                              number.c_str(),
                              "speed",
                              speed.c_str(),
                              "bConfigurationValue",
                              "1",
                              "idVendor",
                              vendor,
                              "idProduct",
                              product,
                              "product",
                              "Emulated depth camera",
                              "serial",
                              identity.serial.c_str(),
                              nullptr};
  const char* properties[] = {"DEVTYPE",           "usb_device", "BUSNUM", "001",  "DEVNUM",
                              device.node.c_str(), "DEVNAME",    node,     nullptr};
  device.syspath = umockdev_testbed_add_devicev(testbed_->testbed, "usb", name.c_str(), nullptr,
                                                const_cast<char**>(attributes), const_cast<char**>(properties));
  auto descriptors = device.model->descriptors();
  umockdev_testbed_set_attribute_binary(testbed_->testbed, device.syspath.c_str(), "descriptors",
                                        reinterpret_cast<guint8*>(descriptors.data()),
                                        static_cast<gint>(descriptors.size()));
  device.pump = std::jthread([&device](const std::stop_token& stop) { device.run(stop); });
  umockdev_testbed_uevent(testbed_->testbed, device.syspath.c_str(), "add");
  return address;
}

void EmulatedBus::unplug(int address) {
  Device& gone = device(address);
  {
    const std::lock_guard lock(gone.mutex);
    if (gone.is_unplugged) return;
    gone.drop_all(-ESHUTDOWN);
    gone.is_unplugged = true;
    close(std::exchange(gone.master, -1));
  }
  umockdev_testbed_uevent(testbed_->testbed, gone.syspath.c_str(), "remove");
  umockdev_testbed_remove_device(testbed_->testbed, gone.syspath.c_str());
}

void EmulatedBus::with_model(int address, const std::function<void(UsbModel&)>& change) {
  const std::lock_guard lock(device(address).mutex);
  change(*device(address).model);
}

void EmulatedBus::refuse_claims(int address, bool is_refused) {
  const std::lock_guard lock(device(address).mutex);
  device(address).is_claim_refused = is_refused;
}

void EmulatedBus::limit_memory(int megabytes) {
  for (const auto& [address, each] : testbed_->devices) {
    const std::lock_guard lock(each->mutex);
    each->most_bytes = static_cast<std::size_t>(megabytes) << 20;
  }
}

void EmulatedBus::serve(int address, pid_t client) {
  const std::lock_guard lock(device(address).mutex);
  device(address).memory = ClientMemory(client);
}

std::optional<int> EmulatedBus::idle_asks(int address) {
  const std::lock_guard lock(device(address).mutex);
  return device(address).idle_asks;
}

int EmulatedBus::waiting_transfers(int address) {
  const std::lock_guard lock(device(address).mutex);
  std::size_t sum = 0;
  for (const auto& [endpoint, queue] : device(address).waiting) sum += queue.size();
  return static_cast<int>(sum);
}

}  // namespace scanknit::test
