#include "acquire/openni2/openni2_plugin.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <string_view>

#include "acquire/layouts/oni_file.h"
#include "acquire/reconnecting_source.h"
#include "acquire/waiting.h"
#include "core/files/located.h"
#include "core/system/module.h"

namespace scanknit {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

constexpr const char* kRemedy =
    "Install the package scanknit-openni2, which holds the module, and Debian's libopenni2-0; when building ScanKnit, "
    "libopenni2-dev (cmake -DSCANKNIT_WITH_OPENNI2=ON says what is missing)";

/// OpenNI's player believes every number of a file: it gets only those that are whole and whose pictures we could read.
Result<void> check_recording(const std::string& path) {
  auto access = open_random_access(path);
  if (!access) return access.error();
  const auto file = OniFile::open(*std::move(access), {});
  if (!file) return located(file.error(), path);
  const auto refuse = [&](const std::string& why) {
    return Error{ErrorCode::kInput, why + "; `scanknit run` reads what is good in it", path};
  };
  if (file->fault()) return refuse("the recording is torn: " + *file->fault());
  for (std::size_t i = 0; i < file->depth().pictures.size(); ++i) {
    if (const auto picture = file->read(StreamKind::kDepth, i); !picture) return refuse(picture.error().message);
  }
  for (std::size_t i = 0; file->colour() && i < file->colour()->pictures.size(); ++i) {
    if (const auto picture = file->read(StreamKind::kColour, i); !picture) return refuse(picture.error().message);
  }
  return {};
}

/// Which camera is wanted: any, the one with this URI, or (after unplugging, when its URI is another) of this name.
struct WantedDevice {
  std::string uri, name;
  [[nodiscard]] bool fits(const DeviceInfo& camera) const {
    return (uri.empty() || uri == camera.uri) && (name.empty() || name == camera.name);
  }
};

Result<std::unique_ptr<DeviceSource>> wait_and_open(const OpenNi2Plugin& plugin, const WantedDevice& wanted,
                                                    const DeviceOptions& options, Clock::time_point deadline,
                                                    const std::stop_token& stop) {
  constexpr milliseconds kAgain{200};
  while (true) {
    const auto cameras = plugin.list();
    if (!cameras) return cameras.error();
    const auto found =
        std::find_if(cameras->begin(), cameras->end(), [&](const DeviceInfo& camera) { return wanted.fits(camera); });
    Result<std::unique_ptr<DeviceSource>> opened =
        Error{ErrorCode::kDevice, cameras->empty() ? "OpenNI2 sees no camera. Is it plugged in, and may you use it?"
                                                   : "OpenNI2 does not see it, but " + cameras->front().uri};
    if (found != cameras->end()) opened = plugin.open(found->uri, options);
    const auto left = std::chrono::duration_cast<milliseconds>(deadline - Clock::now());
    if (opened || left <= milliseconds(0) || !pause(std::min(left, kAgain), stop)) return opened;
  }
}

}  // namespace

Result<const OpenNi2Plugin*> load_openni2() {
  const auto plugin = load_module<OpenNi2Plugin>("openni2", kRemedy);
  if (!plugin) return Error{ErrorCode::kDevice, plugin.error().message};  // a camera cannot be used
  return plugin;
}

std::vector<DeviceInfo> list_openni2() {
  const auto plugin = load_openni2();
  if (!plugin) return {};
  auto cameras = (*plugin)->list();
  return cameras ? *std::move(cameras) : std::vector<DeviceInfo>{};
}

Result<std::unique_ptr<DeviceSource>> open_openni2(const std::string& uri, const DeviceOptions& options,
                                                   const std::stop_token& stop) {
  const auto plugin = load_openni2();
  if (!plugin) return plugin.error();
  const std::string name = uri.substr(std::string_view(kOpenNi2Prefix).size());
  std::error_code ignored;
  if (name.ends_with(".oni") || std::filesystem::is_regular_file(name, ignored)) {
    if (const auto checked = check_recording(name); !checked) return checked.error();
    return (*plugin)->open(uri, options);
  }
  const WantedDevice wanted{name.empty() ? "" : uri, ""};
  auto opened = wait_and_open(**plugin, wanted, options, after(options.wait_s), stop);
  if (!opened || options.reconnect_s <= 0) return opened;
  const WantedDevice same{"", (*opened)->info().name};
  auto reopen = [plugin = *plugin, same, options](const std::stop_token& give_up) {
    return wait_and_open(*plugin, same, options, after(options.reconnect_s), give_up);
  };
  return make_reconnecting(std::move(*opened), std::move(reopen),
                           std::chrono::duration_cast<milliseconds>(after(options.reconnect_s) - Clock::now()));
}

}  // namespace scanknit
