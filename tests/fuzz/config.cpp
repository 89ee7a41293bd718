// Configurations: what is accepted is the same after it was printed and read again. Keys that name files are left at
// auto, since the file may be there or not.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>

#include "app/config/config_load.h"
#include "app/config/config_print.h"
#include "app/config/config_schema.h"
#include "folder/scratch_folder.h"

namespace scanknit {
namespace {

/// A first byte of odd value: "KEY=VALUE" as --set takes it, else a file.
std::vector<ConfigProblem> apply(std::uint8_t how, std::string_view text, const ScratchFolder& empty,
                                 LoadedConfig& loaded) {
  return how % 2 == 1 ? apply_assignment(std::string(text), loaded)
                      : apply_yaml(text, "fuzz.yaml", empty.path(), loaded);
}

void check_read_again(const ScanConfig& config, const ScratchFolder& empty) {
  LoadedConfig again;
  const auto problems = apply_yaml(config_to_yaml(config), "printed.yaml", empty.path(), again);
  require(problems.empty(),
          problems.empty() ? "" : ("a printed configuration is accepted: " + problems[0].message).c_str());
  for (const ConfigKey& key : config_schema()) {
    require(key.get(config) == key.get(again.config),
            ("a printed configuration is read as the same: " + key.name).c_str());
  }
  require(!config_to_json(config).empty(), "a configuration can be printed as JSON");
}

}  // namespace
}  // namespace scanknit

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace scanknit;
  static const ScratchFolder empty;
  if (size == 0) return 0;
  LoadedConfig loaded;
  const std::string_view text(reinterpret_cast<const char*>(bytes) + 1, size - 1);
  const auto problems = apply(bytes[0], text, empty, loaded);
  for (const ConfigProblem& problem : problems) {
    require(!problem.where.empty() && !problem.message.empty(), "a problem says where and what it is");
  }
  if (loaded.given.empty()) return 0;
  loaded.config.acquire.camera = nullptr;
  check_read_again(loaded.config, empty);  // keys with a problem have kept their values
  return 0;
}
