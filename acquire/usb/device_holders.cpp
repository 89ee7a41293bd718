#include "acquire/usb/device_holders.h"

#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <string_view>

namespace scanknit {
namespace {

namespace fs = std::filesystem;

/// udev looks into what has just been plugged in, and is gone in a moment.
constexpr std::string_view kUdevWorker = "(udev-worker)";

/// Entries come and go while we look, and many are not ours to see: both are no errors here.
template <typename Visit>
void for_each_entry(const fs::path& folder, const Visit& visit) {
  std::error_code ignored;
  for (fs::directory_iterator it(folder, ignored), end; !ignored && it != end; it.increment(ignored)) visit(it->path());
}

bool has_open(const fs::path& process, const std::vector<fs::path>& nodes) {
  bool is_found = false;
  for_each_entry(process / "fd", [&](const fs::path& descriptor) {
    std::error_code ignored;
    const fs::path target = fs::read_symlink(descriptor, ignored);
    is_found = is_found || std::find(nodes.begin(), nodes.end(), target) != nodes.end();
  });
  return is_found;
}

}  // namespace

std::vector<fs::path> device_nodes(const fs::path& node, const std::string& port, const fs::path& sysfs) {
  std::vector<fs::path> nodes = {node};
  for_each_entry(sysfs / "bus/usb/devices" / port, [&](const fs::path& interface) {
    if (!interface.filename().string().starts_with(port + ":")) return;
    for_each_entry(interface / "video4linux",
                   [&](const fs::path& video) { nodes.push_back("/dev" / video.filename()); });
  });
  return nodes;
}

std::vector<DeviceHolder> find_holders(const std::vector<fs::path>& nodes, const fs::path& proc) {
  std::vector<DeviceHolder> holders;
  for_each_entry(proc, [&](const fs::path& process) {
    const std::string name = process.filename().string();
    DeviceHolder holder;
    const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), holder.process);
    if (error != std::errc() || end != name.data() + name.size() || holder.process == ::getpid()) return;
    if (!has_open(process, nodes)) return;
    std::ifstream file(process / "comm");
    std::getline(file, holder.program);
    if (holder.program != kUdevWorker) holders.push_back(holder);
  });
  std::sort(holders.begin(), holders.end(),
            [](const DeviceHolder& a, const DeviceHolder& b) { return a.process < b.process; });
  return holders;
}

std::string describe_holders(const std::vector<DeviceHolder>& holders) {
  std::string text;
  for (const DeviceHolder& holder : holders) {
    text += (text.empty() ? "" : ", ") + ("process " + std::to_string(holder.process));
    if (!holder.program.empty()) text += " (" + holder.program + ")";
  }
  return text;
}

}  // namespace scanknit
